#include "genus/mesh/repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/disjoint_sets.h"
#include "genus/mesh/point_table.h"
#include "genus/mesh/sides.h"
#include "genus/mesh/t_junctions.h"
#include "genus/mesh/topology.h"

namespace genus {

namespace {

// ---- welding ----------------------------------------------------------------------------------

// Kept points in cells as wide as the tolerance: whatever is near lies in one of 27.
class NearPoints {
public:
    NearPoints(const Box3& box, double tolerance) : origin_(box.min), tolerance_(tolerance)
    {
        const Vec3 size = box.size();
        const double steps = std::max({size[0], size[1], size[2]}) / tolerance;
        require(steps < 0x1p40, "weld: tolerance", tolerance, "at least 1e-12 of the size");
    }

    /// The first kept point within tolerance, else p itself, kept as number `fresh`.
    std::int32_t find_or_keep(const Vec3& p, std::int32_t fresh)
    {
        const Cell cell = cell_of(p);
        std::int32_t best = -1;
        for (int k = 0; k < 27; ++k) {
            const Cell beside{cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1};
            const auto at = cells_.find(hash(beside));
            if (at == cells_.end()) continue;
            for (const auto& [q, number] : at->second)
                if ((best < 0 || number < best) && distance(p, q) <= tolerance_) best = number;
        }
        if (best >= 0) return best;
        cells_[hash(cell)].push_back({p, fresh});
        return fresh;
    }

private:
    using Cell = std::array<std::int64_t, 3>;

    Cell cell_of(const Vec3& p) const
    {
        Cell cell;
        for (std::size_t i = 0; i < 3; ++i)
            cell[i] = static_cast<std::int64_t>(std::floor((p[i] - origin_[i]) / tolerance_));
        return cell;
    }

    // Cells that share a hash share a list: more to compare, nothing wrong.
    static std::uint64_t hash(const Cell& cell)
    {
        std::uint64_t h = 0;
        for (const std::int64_t x : cell) {
            h = (h ^ static_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15;
            h ^= h >> 29;
        }
        return h;
    }

    Vec3 origin_;
    double tolerance_;
    std::unordered_map<std::uint64_t, std::vector<std::pair<Vec3, std::int32_t>>> cells_;
};

// Faces by new vertex names; vertices named by faces only, in the order of their first numbers.
// `sources` takes the number that each vertex had.
IndexedMesh renamed(const IndexedMesh& mesh, const std::vector<std::int32_t>& target,
                    std::vector<std::int32_t>& sources)
{
    std::vector<std::int32_t> number(mesh.n_vertices(), -1);
    std::vector<std::uint8_t> used(mesh.n_vertices(), 0);
    for (const Triangle& t : mesh.faces)
        for (const std::int32_t v : t) used[target[v]] = 1;
    IndexedMesh out;
    for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
        if (!used[v]) continue;
        number[v] = static_cast<std::int32_t>(out.n_vertices());
        out.vertices.push_back(mesh.vertices[v]);
        sources.push_back(static_cast<std::int32_t>(v));
    }
    for (const auto& [a, b, c] : mesh.faces)
        out.faces.push_back({number[target[a]], number[target[b]], number[target[c]]});
    return out;
}

IndexedMesh welded(const IndexedMesh& mesh, double tolerance, std::vector<std::int32_t>& sources)
{
    check_indices(TriangleSides(mesh), mesh.n_vertices());
    return renamed(mesh, weld_targets(mesh.vertices, tolerance), sources);
}

// ---- faces ------------------------------------------------------------------------------------

// Keeps the faces with these numbers, and what is known of them.
void keep_faces(RepairedMesh& out, const std::vector<std::size_t>& kept)
{
    std::vector<Triangle> faces;
    std::vector<std::int32_t> sources;
    for (const std::size_t f : kept) {
        faces.push_back(out.mesh.faces[f]);
        sources.push_back(out.source_face[f]);
    }
    out.mesh.faces = std::move(faces);
    out.source_face = std::move(sources);
}

void drop_faces(RepairedMesh& out)
{
    const IndexedMesh& mesh = out.mesh;
    RepairReport& report = out.report;
    std::vector<std::pair<Triangle, std::size_t>> keys;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        Triangle t = mesh.faces[f];
        std::sort(t.begin(), t.end());
        if (t[0] == t[1] || t[1] == t[2])
            ++report.degenerate_faces;
        else
            keys.push_back({t, f});
    }
    std::sort(keys.begin(), keys.end());
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < keys.size(); ++i) {
        if (i > 0 && keys[i].first == keys[i - 1].first)
            ++report.duplicate_faces;
        else
            kept.push_back(keys[i].second);
    }
    std::sort(kept.begin(), kept.end());
    keep_faces(out, kept);
}

std::vector<std::int32_t> twins_of(const IndexedMesh& mesh)
{
    const TriangleSides sides(mesh);
    const auto all = [](std::size_t) { return false; };
    return twins(make_edge_table(sides, mesh.n_vertices(), all), sides.n_sides());
}

// ---- orientation ------------------------------------------------------------------------------

class Orienter {
public:
    explicit Orienter(IndexedMesh& mesh) : mesh_(mesh), twin_(twins_of(mesh)) {}

    // Which faces were turned.
    std::vector<std::uint8_t> run()
    {
        part_.assign(mesh_.n_faces(), -1);
        turned_.assign(mesh_.n_faces(), 0);
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f)
            if (part_[f] < 0) spread_from(static_cast<std::int32_t>(f));
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f)
            if (one_sided_[part_[f]]) turned_[f] = 0;
        apply();
        turn_closed_parts();
        return std::move(turned_);
    }

private:
    // All faces that hang together with f by edges of two faces agree with it afterwards.
    void spread_from(std::int32_t f)
    {
        const TriangleSides sides(mesh_);
        const auto part = static_cast<std::int32_t>(closed_.size());
        closed_.push_back(1);
        one_sided_.push_back(0);
        std::vector<std::int32_t> open{f};
        part_[f] = part;
        while (!open.empty()) {
            const std::int32_t face = open.back();
            open.pop_back();
            for (std::int32_t s = 3 * face; s < 3 * face + 3; ++s) {
                if (twin_[s] < 0) {
                    closed_[part] = 0;
                    continue;
                }
                const std::int32_t other = sides.face(twin_[s]);
                const bool clash = sides.from(s) == sides.from(twin_[s]);
                const auto wanted = static_cast<std::uint8_t>(turned_[face] ^ clash);
                if (part_[other] < 0) {
                    part_[other] = part;
                    turned_[other] = wanted;
                    open.push_back(other);
                } else if (turned_[other] != wanted) {
                    one_sided_[part] = 1;
                }
            }
        }
        current_progress().check();
    }

    void apply()
    {
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f)
            if (turned_[f]) std::swap(mesh_.faces[f][1], mesh_.faces[f][2]);
    }

    struct Part {
        Vec3 origin;
        double volume = 0.0;
        double largest = -1.0;
        std::int32_t face = -1;
    };

    // Closed parts turn outward, and inward within an odd number of others.
    void turn_closed_parts()
    {
        std::vector<Part> parts(closed_.size());
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f) {
            Part& part = parts[part_[f]];
            const auto& [i, j, k] = mesh_.faces[f];
            if (part.face < 0) part.origin = mesh_.vertices[i];
            const Vec3 a = mesh_.vertices[i] - part.origin, b = mesh_.vertices[j] - part.origin;
            const Vec3 c = mesh_.vertices[k] - part.origin;
            part.volume += dot(a, cross(b, c));
            const double size = norm(cross(b - a, c - a));
            if (size <= part.largest) continue;
            part.largest = size;
            part.face = static_cast<std::int32_t>(f);
        }
        const BoxTree tree(face_boxes(mesh_));
        std::vector<std::uint8_t> turn(parts.size(), 0);
        for (std::size_t p = 0; p < parts.size(); ++p) {
            if (!closed_[p] || one_sided_[p]) continue;
            const bool inward = depth(tree, parts[p].face) % 2 == 1;
            turn[p] = inward ? parts[p].volume > 0.0 : parts[p].volume < 0.0;
        }
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f) {
            if (!turn[part_[f]]) continue;
            std::swap(mesh_.faces[f][1], mesh_.faces[f][2]);
            turned_[f] ^= 1;
        }
    }

    // How many other closed parts hold the middle of the face: those whose faces lie ahead an odd
    // number of times.
    int depth(const BoxTree& tree, std::int32_t face) const
    {
        const auto& [a, b, c] = mesh_.faces[face];
        const Vec3 p = (1.0 / 3.0) * mesh_.vertices[a] + (1.0 / 3.0) * mesh_.vertices[b] +
                       (1.0 / 3.0) * mesh_.vertices[c];
        std::map<std::int32_t, int> crossings;
        visit_faces_ahead(mesh_, tree, p, [&](std::int32_t f, int around, int side) {
            if (part_[f] != part_[face] && closed_[part_[f]] && side == around)
                ++crossings[part_[f]];
        });
        int n = 0;
        for (const auto& entry : crossings) n += entry.second % 2;
        return n;
    }

    IndexedMesh& mesh_;
    std::vector<std::int32_t> twin_;
    std::vector<std::int32_t> part_;
    std::vector<std::uint8_t> turned_, closed_, one_sided_;
};

// ---- T-junctions ------------------------------------------------------------------------------

// Faces with vertices in their sides, cut; the others as they are, all in their order. `sources`
// takes the number of the face that each comes from.
std::vector<Triangle> cut_faces(const IndexedMesh& mesh, const std::vector<TJunction>& junctions,
                                std::vector<std::int32_t>& sources)
{
    std::vector<Triangle> faces;
    auto at = junctions.begin();
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        if (at == junctions.end() || static_cast<std::size_t>(at->side / 3) != f) {
            faces.push_back(mesh.faces[f]);
            sources.push_back(static_cast<std::int32_t>(f));
            continue;
        }
        PolygonMesh cut;
        std::vector<std::int32_t> corners, numbers;
        for (std::size_t i = 0; i < 3; ++i) {
            numbers.push_back(mesh.faces[f][i]);
            const auto side = static_cast<std::int32_t>(3 * f + i);
            for (; at != junctions.end() && at->side == side; ++at) numbers.push_back(at->vertex);
        }
        for (const std::int32_t v : numbers) {
            corners.push_back(static_cast<std::int32_t>(cut.n_vertices()));
            cut.vertices.push_back(mesh.vertices[v]);
        }
        cut.add_face(corners);
        for (const auto& [a, b, c] : to_triangles(cut).faces)
            faces.push_back({numbers[a], numbers[b], numbers[c]});
        sources.resize(faces.size(), static_cast<std::int32_t>(f));
    }
    return faces;
}

void cut_at_junctions(RepairedMesh& out, double tolerance)
{
    const std::vector<TJunction> junctions = find_t_junctions(out.mesh, tolerance);
    out.report.t_junctions = static_cast<std::int64_t>(junctions.size());
    if (junctions.empty()) return;
    std::vector<std::int32_t> sources;
    std::vector<Triangle> faces = cut_faces(out.mesh, junctions, sources);
    for (std::int32_t& f : sources) f = out.source_face[f];
    out.mesh.faces = std::move(faces);
    out.source_face = std::move(sources);
    drop_faces(out);
}

// ---- cutting apart ----------------------------------------------------------------------------

// Corners stay together if they are joined across edges of exactly two faces that agree.
DisjointSets fans_of(const IndexedMesh& mesh, const std::vector<std::int32_t>& twin)
{
    const TriangleSides sides(mesh);
    DisjointSets fans(sides.n_sides());
    for (std::int32_t s = 0; s < static_cast<std::int32_t>(twin.size()); ++s) {
        const std::int32_t t = twin[s];
        if (t < s || sides.from(s) == sides.from(t)) continue;
        fans.unite(s, sides.next(t));
        fans.unite(sides.next(s), t);
    }
    return fans;
}

double size_of(const IndexedMesh& mesh, std::int32_t face)
{
    const auto& [a, b, c] = mesh.faces[face];
    return norm(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
}

// Of the faces at each complex edge all but the two largest, the earlier of equals.
std::vector<std::int32_t> faces_too_many(const IndexedMesh& mesh, const Topology& t)
{
    std::vector<std::int32_t> out;
    for (const ComplexEdge& edge : t.complex_edges) {
        std::vector<std::int32_t> faces = edge.faces;
        std::stable_sort(faces.begin(), faces.end(), [&](std::int32_t f, std::int32_t g) {
            return size_of(mesh, f) > size_of(mesh, g);
        });
        out.insert(out.end(), faces.begin() + 2, faces.end());
    }
    return out;
}

// Of the fans at each complex vertex all faces but those of the one that has most.
std::vector<std::int32_t> fans_too_many(const IndexedMesh& mesh, const Topology& t)
{
    DisjointSets fans = fans_of(mesh, twins_of(mesh));
    std::vector<std::uint8_t> is_complex(mesh.n_vertices(), 0);
    for (const ComplexVertex& v : t.complex_vertices) is_complex[v.vertex] = 1;
    std::map<std::int32_t, std::map<std::int32_t, std::vector<std::int32_t>>> by_vertex;
    for (std::size_t s = 0; s < 3 * mesh.n_faces(); ++s) {
        const std::int32_t v = mesh.faces[s / 3][s % 3], side = static_cast<std::int32_t>(s);
        if (is_complex[v]) by_vertex[v][fans.find(side)].push_back(side / 3);
    }
    std::vector<std::int32_t> out;
    for (const auto& [vertex, fans_there] : by_vertex) {
        auto largest = fans_there.begin();
        for (auto fan = fans_there.begin(); fan != fans_there.end(); ++fan)
            if (fan->second.size() > largest->second.size()) largest = fan;
        for (auto fan = fans_there.begin(); fan != fans_there.end(); ++fan)
            if (fan != largest) out.insert(out.end(), fan->second.begin(), fan->second.end());
    }
    return out;
}

// Each round takes at least one face away; rounds go on for what they lay open.
void drop_complex(RepairedMesh& out)
{
    const std::size_t before = out.mesh.n_faces();
    while (true) {
        current_progress().check();
        const Topology t = topology(out.mesh);
        std::vector<std::int32_t> drop = faces_too_many(out.mesh, t);
        if (drop.empty()) drop = fans_too_many(out.mesh, t);
        if (drop.empty()) break;
        std::vector<std::uint8_t> goes(out.mesh.n_faces(), 0);
        for (const std::int32_t f : drop) goes[f] = 1;
        std::vector<std::size_t> kept;
        for (std::size_t f = 0; f < out.mesh.n_faces(); ++f)
            if (!goes[f]) kept.push_back(f);
        keep_faces(out, kept);
    }
    out.report.dropped_faces = static_cast<std::int64_t>(before - out.mesh.n_faces());
}

void split_complex(RepairedMesh& out)
{
    IndexedMesh& mesh = out.mesh;
    const TriangleSides sides(mesh);
    const std::vector<std::int32_t> twin = twins_of(mesh);
    DisjointSets fans = fans_of(mesh, twin);
    std::vector<std::int32_t> fan_of_vertex(mesh.n_vertices(), -1), vertex_of_fan(twin.size(), -1);
    std::vector<Triangle> faces = mesh.faces;
    for (std::int32_t s = 0; s < static_cast<std::int32_t>(twin.size()); ++s) {
        const std::int32_t v = sides.from(s), fan = fans.find(s);
        if (vertex_of_fan[fan] < 0) {
            vertex_of_fan[fan] = v;
            if (fan_of_vertex[v] < 0) {
                fan_of_vertex[v] = fan;
            } else {
                vertex_of_fan[fan] = static_cast<std::int32_t>(mesh.n_vertices());
                mesh.vertices.push_back(Vec3(mesh.vertices[v]));
                out.source_vertex.push_back(std::int32_t(out.source_vertex[v]));
                ++out.report.split_vertices;
            }
        }
        faces[s / 3][s % 3] = vertex_of_fan[fan];
    }
    mesh.faces = std::move(faces);
}

// ---- holes ------------------------------------------------------------------------------------

// Each boundary loop as vertices in the direction in which new faces will run.
std::vector<std::vector<std::int32_t>> holes_of(const IndexedMesh& mesh, std::int64_t max_edges)
{
    const TriangleSides sides(mesh);
    const std::vector<std::int32_t> twin = twins_of(mesh);
    std::vector<std::uint8_t> seen(twin.size(), 0);
    std::vector<std::vector<std::int32_t>> holes;
    for (std::int32_t first = 0; first < static_cast<std::int32_t>(twin.size()); ++first) {
        if (twin[first] != kBoundarySide || seen[first]) continue;
        std::vector<std::int32_t> loop;
        std::int32_t s = first;
        bool whole = true;
        while (!seen[s]) {
            seen[s] = 1;
            loop.push_back(sides.from(s));
            const auto all = [](std::int32_t) { return true; };
            const std::int32_t end = sides.to(s);
            s = walk_around(sides, twin, end, sides.next(s), all);
            // Where faces disagree or the edge is complex there is no way on.
            whole = twin[s] == kBoundarySide && sides.from(s) == end;
            if (!whole) break;
        }
        if (!whole || s != first || loop.size() < 3) continue;
        if (static_cast<std::int64_t>(loop.size()) > max_edges) continue;
        std::reverse(loop.begin(), loop.end());
        holes.push_back(std::move(loop));
    }
    return holes;
}

// The triangulation of a closed polygon in space with the least total area.
class HoleFiller {
public:
    HoleFiller(const IndexedMesh& mesh, const std::vector<std::int32_t>& loop)
        : mesh_(mesh), loop_(loop), n_(loop.size()), least_(n_ * n_, 0.0), middle_(n_ * n_, 0)
    {
        for (std::size_t span = 2; span < n_; ++span) {
            current_progress().check();
            for (std::size_t i = 0; i + span < n_; ++i) choose(i, i + span);
        }
    }

    void add_faces(std::vector<Triangle>& faces) const
    {
        std::vector<std::array<std::size_t, 2>> open{{0, n_ - 1}};
        while (!open.empty()) {
            const auto [i, j] = open.back();
            open.pop_back();
            if (j - i < 2) continue;
            const std::size_t m = middle_[i * n_ + j];
            faces.push_back({loop_[i], loop_[m], loop_[j]});
            open.push_back({i, m});
            open.push_back({m, j});
        }
    }

private:
    void choose(std::size_t i, std::size_t j)
    {
        double best = std::numeric_limits<double>::infinity();
        for (std::size_t m = i + 1; m < j; ++m) {
            const Vec3 &a = point(i), &b = point(m), &c = point(j);
            const double area = least_[i * n_ + m] + least_[m * n_ + j] + norm(cross(b - a, c - a));
            if (area >= best && m > i + 1) continue;
            best = area;
            middle_[i * n_ + j] = m;
        }
        least_[i * n_ + j] = best;
    }

    const Vec3& point(std::size_t i) const { return mesh_.vertices[loop_[i]]; }

    const IndexedMesh& mesh_;
    const std::vector<std::int32_t>& loop_;
    std::size_t n_;
    std::vector<double> least_;        // by first and last corner of a part of the loop
    std::vector<std::size_t> middle_;  // third corner of the triangle on its chord
};

}  // namespace

std::vector<std::int32_t> weld_targets(const std::vector<Vec3>& points, double tolerance)
{
    require(tolerance >= 0.0 && std::isfinite(tolerance), "weld: tolerance", tolerance,
            "finite and at least 0");
    Box3 box;
    for (std::size_t v = 0; v < points.size(); ++v) {
        if (!is_finite(points[v]))
            throw InvalidInput("weld: vertex " + std::to_string(v) + " is not finite");
        box.add(points[v]);
    }
    std::vector<std::int32_t> target(points.size());
    if (tolerance == 0.0) {
        PointTable table;
        std::vector<std::int32_t> first;  // of the points in the table
        for (std::size_t v = 0; v < target.size(); ++v) {
            const auto i = static_cast<std::size_t>(table.find_or_add(points[v]));
            if (i == first.size()) first.push_back(static_cast<std::int32_t>(v));
            target[v] = first[i];
        }
        return target;
    }
    if (points.empty()) return target;
    NearPoints kept(box, tolerance);
    for (std::size_t v = 0; v < target.size(); ++v) {
        if (v % 4096 == 4095) current_progress().check();
        target[v] = kept.find_or_keep(points[v], static_cast<std::int32_t>(v));
    }
    return target;
}

IndexedMesh weld(const IndexedMesh& mesh, double tolerance)
{
    std::vector<std::int32_t> sources;
    return welded(mesh, tolerance, sources);
}

RepairedMesh repair(const IndexedMesh& mesh, const RepairOptions& options)
{
    constexpr std::int64_t kLongestHole = 500;
    require(options.max_hole >= 0 && options.max_hole <= kLongestHole, "repair: max_hole",
            static_cast<double>(options.max_hole), "between 0 and 500");
    RepairedMesh out;
    out.mesh = welded(mesh, options.weld, out.source_vertex);
    out.report.welded_vertices = static_cast<std::int64_t>(mesh.n_vertices()) -
                                 static_cast<std::int64_t>(out.mesh.n_vertices());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f)
        out.source_face.push_back(static_cast<std::int32_t>(f));
    drop_faces(out);
    if (options.t_junctions) cut_at_junctions(out, options.weld);
    if (options.non_manifold == NonManifold::Drop) drop_complex(out);
    const std::size_t n_faces = out.mesh.n_faces();
    std::vector<std::uint8_t> turned(n_faces, 0);
    if (options.orient) turned = Orienter(out.mesh).run();
    if (options.non_manifold == NonManifold::Split) split_complex(out);
    for (const std::vector<std::int32_t>& hole : holes_of(out.mesh, options.max_hole)) {
        HoleFiller(out.mesh, hole).add_faces(out.mesh.faces);
        ++out.report.closed_holes;
    }
    out.source_face.resize(out.mesh.n_faces(), -1);
    out.report.added_faces = static_cast<std::int64_t>(out.mesh.n_faces() - n_faces);
    if (options.orient) {
        // Once more: parts that were open until now turn outward as well.
        const std::vector<std::uint8_t> again = Orienter(out.mesh).run();
        for (std::size_t f = 0; f < n_faces; ++f) out.report.turned_faces += turned[f] != again[f];
    }
    out.report.open_edges = topology(out.mesh).boundary_edges;
    return out;
}

}  // namespace genus
