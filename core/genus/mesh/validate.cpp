#include "genus/mesh/validate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/predicates.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/t_junctions.h"
#include "genus/mesh/triangle_intersection.h"

namespace genus {

namespace {

using Numbers = std::vector<std::int32_t>;

std::string text_of(const Vec3& p)
{
    std::string text = "(";
    text += to_text(p[0]) + ", " + to_text(p[1]) + ", " + to_text(p[2]) + ")";
    return text;
}

std::string edge_text(std::int32_t a, std::int32_t b)
{
    return "edge " + std::to_string(a) + "-" + std::to_string(b);
}

TrianglePoints points_of(const IndexedMesh& mesh, std::size_t face)
{
    const auto& [a, b, c] = mesh.faces[face];
    return {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
}

Triangle sorted(Triangle t)
{
    std::sort(t.begin(), t.end());
    return t;
}

class Validator {
public:
    Validator(const IndexedMesh& mesh, const ValidateOptions& options)
        : mesh_(mesh), options_(options)
    {
    }

    Validation run()
    {
        check_indices();
        check_coordinates();
        if (out_.count(Defect::IndexOutOfRange) > 0) return std::move(out_);
        out_.topology = topology(mesh_);
        const bool finite = out_.count(Defect::NonFinite) == 0;
        check_degenerate(finite);
        check_duplicates();
        check_edges_and_vertices();
        if (finite) {
            check_self_intersections();
            check_turns();
            check_t_junctions();
        }
        return std::move(out_);
    }

private:
    // `text` is only made for findings that are listed.
    template <class Text>
    void add(Defect defect, Numbers vertices, Numbers faces, const Vec3& at, Text&& text)
    {
        const auto before = out_.counts[static_cast<std::size_t>(defect)]++;
        if (static_cast<std::size_t>(before) >= options_.max_findings) return;
        out_.findings.push_back({defect, std::move(vertices), std::move(faces), at, text()});
    }

    Vec3 middle(std::int32_t a, std::int32_t b) const
    {
        return 0.5 * mesh_.vertices[a] + 0.5 * mesh_.vertices[b];
    }

    void check_indices()
    {
        const auto n = static_cast<std::int64_t>(mesh_.n_vertices());
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f)
            for (const std::int32_t v : mesh_.faces[f]) {
                if (v >= 0 && v < n) continue;
                const auto face = static_cast<std::int32_t>(f);
                add(Defect::IndexOutOfRange, {v}, {face}, Vec3{}, [&] {
                    return "face " + std::to_string(f) + " names vertex " + std::to_string(v) +
                           " of " + std::to_string(n);
                });
                break;
            }
    }

    void check_coordinates()
    {
        for (std::size_t v = 0; v < mesh_.n_vertices(); ++v) {
            const Vec3& p = mesh_.vertices[v];
            if (is_finite(p)) continue;
            add(Defect::NonFinite, {static_cast<std::int32_t>(v)}, {}, p,
                [&] { return "vertex " + std::to_string(v) + " is at " + text_of(p); });
        }
    }

    void check_degenerate(bool finite)
    {
        flat_.assign(mesh_.n_faces(), 0);
        parallel_for(mesh_.n_faces(), 8192, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f) {
                const auto& [a, b, c] = mesh_.faces[f];
                const bool twice = a == b || b == c || c == a;
                flat_[f] = twice ? 1 : finite && has_no_area(points_of(mesh_, f)) ? 2 : 0;
            }
        });
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f) {
            if (!flat_[f]) continue;
            const Triangle& t = mesh_.faces[f];
            add(Defect::DegenerateFace, {t.begin(), t.end()}, {static_cast<std::int32_t>(f)},
                mesh_.vertices[t[0]], [&] {
                    return "face " + std::to_string(f) +
                           (flat_[f] == 1 ? " names a vertex twice" : " has no area");
                });
        }
    }

    // On a manifold mesh two faces with the same vertices are a part of their own.
    bool duplicates_possible() const
    {
        if (!out_.topology.manifold) return true;
        for (const SurfaceKind& part : out_.topology.components)
            if (part.vertices == 3 && part.faces > 1) return true;
        return false;
    }

    void check_duplicates()
    {
        if (!duplicates_possible()) return;
        std::vector<std::pair<Triangle, std::int32_t>> keys;
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f)
            if (flat_[f] != 1)
                keys.push_back({sorted(mesh_.faces[f]), static_cast<std::int32_t>(f)});
        std::sort(keys.begin(), keys.end());
        std::vector<std::pair<std::int32_t, std::int32_t>> found;  // face, the first alike
        for (std::size_t i = 1, first = 0; i < keys.size(); ++i) {
            if (keys[i].first == keys[first].first)
                found.push_back({keys[i].second, keys[first].second});
            else
                first = i;
        }
        std::sort(found.begin(), found.end());
        for (const auto& [face, first] : found) {
            const Triangle& t = mesh_.faces[face];
            add(Defect::DuplicateFace, {t.begin(), t.end()}, {first, face}, mesh_.vertices[t[0]],
                [&] {
                    return "face " + std::to_string(face) + " has the vertices of face " +
                           std::to_string(first);
                });
        }
    }

    void check_edges_and_vertices()
    {
        for (const BoundaryEdge& e : out_.topology.open_edges)
            add(Defect::OpenEdge, {e.a, e.b}, {e.face}, middle(e.a, e.b),
                [&] { return edge_text(e.a, e.b) + " has one face, " + std::to_string(e.face); });
        for (const FlippedEdge& e : out_.topology.flipped_edges)
            add(Defect::FlippedEdge, {e.a, e.b}, {e.faces[0], e.faces[1]}, middle(e.a, e.b), [&] {
                return "faces " + std::to_string(e.faces[0]) + " and " +
                       std::to_string(e.faces[1]) + " run the same way along " +
                       edge_text(e.a, e.b);
            });
        for (const ComplexEdge& e : out_.topology.complex_edges)
            add(Defect::ComplexEdge, {e.a, e.b}, e.faces, middle(e.a, e.b), [&] {
                return edge_text(e.a, e.b) + " has " + std::to_string(e.faces.size()) + " faces";
            });
        for (const ComplexVertex& v : out_.topology.complex_vertices)
            add(Defect::ComplexVertex, {v.vertex}, {}, mesh_.vertices[v.vertex], [&] {
                return "vertex " + std::to_string(v.vertex) + " has " + std::to_string(v.fans) +
                       " fans of faces";
            });
    }

    void check_self_intersections()
    {
        if (!options_.self_intersections) return;
        const SelfIntersections found = self_intersections(mesh_);
        out_.self_intersections_complete = found.complete;
        for (const auto& [f, g] : found.pairs) {
            const TrianglePoints a = points_of(mesh_, f), b = points_of(mesh_, g);
            Box3 box_a, box_b;
            for (const Vec3& p : a) box_a.add(p);
            for (const Vec3& p : b) box_b.add(p);
            const Vec3 at = intersection(box_a, box_b).center();
            add(Defect::SelfIntersection, {}, {f, g}, at, [&, face = f, other = g] {
                return "faces " + std::to_string(face) + " and " + std::to_string(other) +
                       " meet near " + text_of(at);
            });
        }
    }

    void check_t_junctions()
    {
        if (out_.topology.boundary_edges == 0) return;
        for (const genus::TJunction& t : find_t_junctions(mesh_)) {
            const std::int32_t face = t.side / 3, v = t.vertex;
            const Triangle& f = mesh_.faces[face];
            const std::int32_t a = f[t.side % 3], b = f[(t.side % 3 + 1) % 3];
            add(Defect::TJunction, {v, a, b}, {face}, mesh_.vertices[v], [&] {
                return "vertex " + std::to_string(v) + " lies within the open " + edge_text(a, b) +
                       " of face " + std::to_string(face);
            });
        }
    }

    // ---- which way closed parts turn ---------------------------------------------------------

    struct Part {
        Vec3 origin;        // one of its vertices; volumes are taken from there
        double volume = 0;  // six times
        double scale = 0;   // sum of the terms' magnitudes
        double largest = -1;
        std::int32_t largest_face = -1;
    };

    std::int32_t component(std::size_t face) const
    {
        return out_.topology.component_of_vertex[mesh_.faces[face][0]];
    }

    bool can_turn(std::size_t part) const
    {
        const SurfaceKind& kind = out_.topology.components[part];
        return kind.closed && kind.oriented;
    }

    std::vector<Part> measure_parts() const
    {
        std::vector<Part> parts(out_.topology.components.size());
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f) {
            if (flat_[f] == 1) continue;
            Part& part = parts[component(f)];
            const TrianglePoints t = points_of(mesh_, f);
            if (part.largest_face < 0) part.origin = t[0];
            const Vec3 a = t[0] - part.origin, b = t[1] - part.origin, c = t[2] - part.origin;
            const double term = dot(a, cross(b, c));
            part.volume += term;
            part.scale += norm(a) * norm(b) * norm(c);
            const double size = norm(cross(b - a, c - a));
            if (size <= part.largest) continue;
            part.largest = size;
            part.largest_face = static_cast<std::int32_t>(f);
        }
        return parts;
    }

    // How often the closed oriented other parts wind round the middle of a face of this one. Exact
    // but for the rounding of that point.
    int winding_of_others(const BoxTree& tree, std::size_t face) const
    {
        const TrianglePoints t = points_of(mesh_, face);
        const Vec3 p = (1.0 / 3.0) * t[0] + (1.0 / 3.0) * t[1] + (1.0 / 3.0) * t[2];
        const std::int32_t own = component(face);
        int winding = 0;
        visit_faces_ahead(mesh_, tree, p, [&](std::int32_t f, int around, int side) {
            const std::int32_t other = component(f);
            if (other != own && can_turn(other) && side == around) winding += around;
        });
        return winding;
    }

    void check_turns()
    {
        const std::vector<Part> parts = measure_parts();
        const bool any = std::any_of(parts.begin(), parts.end(),
                                     [](const Part& part) { return part.largest_face >= 0; });
        if (!any) return;
        BoxTree tree;
        if (parts.size() > 1) tree = BoxTree(face_boxes(mesh_));
        std::vector<int> winding(parts.size(), 0);
        parallel_for(parts.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                if (parts.size() > 1 && can_turn(i) && parts[i].largest_face >= 0)
                    winding[i] = winding_of_others(tree, parts[i].largest_face);
        });
        std::vector<Numbers> faces;  // by part, made when first wanted
        for (std::size_t i = 0; i < parts.size(); ++i) {
            if (!can_turn(i) || turns_well(parts[i], winding[i])) continue;
            if (faces.empty()) faces = faces_of_parts(parts.size());
            if (parts.size() == 1 || !turns_well_elsewhere(parts[i], faces[i], tree))
                report_turn(parts[i]);
        }
    }

    std::vector<Numbers> faces_of_parts(std::size_t n_parts) const
    {
        std::vector<Numbers> faces(n_parts);
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f)
            if (!flat_[f]) faces[component(f)].push_back(static_cast<std::int32_t>(f));
        return faces;
    }

    // Outside and inside of a part must be winding numbers 0 and 1, in either order.
    static bool turns_well(const Part& part, int outside)
    {
        constexpr double kRounding = 1e-14;
        if (!(std::fabs(part.volume) > kRounding * part.scale)) return true;
        const int inside = outside + (part.volume > 0.0 ? 1 : -1);
        return std::min(outside, inside) == 0 && std::max(outside, inside) == 1;
    }

    // Where a thin part touches others, the middle of a face is rounded across them. A part that is
    // doubled is so at all its faces.
    bool turns_well_elsewhere(const Part& part, const Numbers& faces, const BoxTree& tree) const
    {
        constexpr std::size_t kTries = 64;
        const std::size_t step = faces.size() / kTries + 1;
        for (std::size_t i = 0; i < faces.size(); i += step)
            if (turns_well(part, winding_of_others(tree, faces[i]))) return true;
        return false;
    }

    void report_turn(const Part& part)
    {
        const std::int32_t face = part.largest_face;
        add(Defect::Inverted, {}, {face}, points_of(mesh_, face)[0], [&] {
            return std::string("the closed part with face ") + std::to_string(face) + " turns " +
                   (part.volume > 0.0 ? "outward where it should be a cavity or is doubled"
                                      : "inward where there is nothing to hollow out");
        });
    }

    const IndexedMesh& mesh_;
    const ValidateOptions& options_;
    std::vector<std::uint8_t> flat_;  // 1 a vertex twice, 2 no area
    Validation out_;
};

bool same_vertices(const Triangle& a, const Triangle& b)
{
    return sorted(a) == sorted(b);
}

}  // namespace

const char* name(Defect defect)
{
    constexpr std::array<const char*, kDefects> kNames{
        "index out of range", "non-finite coordinate", "degenerate face", "duplicate face",
        "open edge",          "flipped edge",          "complex edge",    "complex vertex",
        "self-intersection",  "inverted part",         "T-junction"};
    return kNames[static_cast<std::size_t>(defect)];
}

SelfIntersections self_intersections(const IndexedMesh& mesh)
{
    // A small mesh is one task, a large one some thousands.
    const std::size_t max_per_task = mesh.n_faces() < 1000 ? 1'000'000 : 2'000;
    struct Found {
        std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
        bool complete = true;
    };
    const BoxTree tree(face_boxes(mesh));
    const auto look = [&](std::int32_t f, std::int32_t g, Found& found) {
        const auto contact = triangle_contact(points_of(mesh, f), points_of(mesh, g));
        if (contact != TriangleContact::Crossing) return true;
        if (same_vertices(mesh.faces[f], mesh.faces[g])) return true;
        found.complete = found.pairs.size() < max_per_task;
        if (found.complete) found.pairs.push_back({f, g});
        return found.complete;
    };
    SelfIntersections out;
    for (const Found& found : tree.visit_self_pairs<Found>(look)) {
        out.pairs.insert(out.pairs.end(), found.pairs.begin(), found.pairs.end());
        out.complete &= found.complete;
    }
    std::sort(out.pairs.begin(), out.pairs.end());
    return out;
}

Validation validate(const IndexedMesh& mesh, const ValidateOptions& options)
{
    return Validator(mesh, options).run();
}

}  // namespace genus
