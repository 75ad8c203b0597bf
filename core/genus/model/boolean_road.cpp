#include "genus/model/boolean_road.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/disjoint_sets.h"
#include "genus/mesh/measure.h"
#include "genus/model/boolean_certificate.h"
#include "genus/model/leaf_mesh.h"
#include "genus/model/stage_clock.h"

namespace genus {

namespace {

constexpr int kFewFaces = 24;            // of a prism that may go through cells
constexpr std::size_t kDeepest = 8'000;  // nodes above a leaf

const std::vector<Solid>* parts_of(const Shape& shape)
{
    if (const auto* node = std::get_if<Union>(&shape)) return &node->parts;
    if (const auto* node = std::get_if<Intersection>(&shape)) return &node->parts;
    if (const auto* node = std::get_if<Difference>(&shape)) return &node->parts;
    return nullptr;
}

// What transforms and colours are put on, or null.
const Solid* only_part(const Shape& shape)
{
    if (const auto* moved = std::get_if<Transformed>(&shape)) return &moved->part;
    if (const auto* painted = std::get_if<Colored>(&shape)) return &painted->part;
    return nullptr;
}

class SceneBuilder {
public:
    // Smooth parts that reach farther than `region` are cut off there; it holds the whole solid.
    SceneBuilder(const SmoothMesher& mesher, double tolerance, const Box3& region)
        : mesher_(mesher), tolerance_(tolerance), region_(region)
    {
    }

    BooleanScene build(const Solid& solid)
    {
        const BooleanFormula::Term top = add(solid, Transform{}, 0);
        if (top.is_operand || top.index + 1 != n_instructions()) scene_.formula.add(false, {top});
        return std::move(scene_);
    }

private:
    std::int32_t n_instructions() const
    {
        return static_cast<std::int32_t>(scene_.formula.instructions.size());
    }

    BooleanFormula::Term add(const Solid& solid, const Transform& map, std::size_t depth)
    {
        require(depth < kDeepest, "mesh: the tree is nested more than 8000 levels deep");
        const Shape& shape = solid.node().shape;
        if (const auto* moved = std::get_if<Transformed>(&shape))
            return add(moved->part, map * moved->map, depth + 1);
        if (const auto* painted = std::get_if<Colored>(&shape))
            return add(painted->part, map, depth + 1);
        if (std::holds_alternative<Freeform>(shape)) {
            scene_.clean_operands = false;
            return add_smooth(solid, map);
        }
        if (!is_polyhedral(solid) && is_smooth(solid)) return add_smooth(solid, map);
        if (const auto* parts = parts_of(shape)) return add_operator(shape, *parts, map, depth);
        return add_leaf(solid, map);
    }

    BooleanFormula::Term add_operator(const Shape& shape, const std::vector<Solid>& parts,
                                      const Transform& map, std::size_t depth)
    {
        const bool subtracts = std::holds_alternative<Difference>(shape);
        std::vector<BooleanFormula::Term> terms;
        for (const Solid& part : joined_smooth_parts(shape, parts)) {
            BooleanFormula::Term term = add(part, map, depth + 1);
            if (subtracts && !terms.empty()) term.negated = !term.negated;
            terms.push_back(term);
        }
        const bool all = subtracts || std::holds_alternative<Intersection>(shape);
        return {scene_.formula.add(all, std::move(terms)), false, false};
    }

    // The parts of an operator with its smooth ones made one; the first part of a difference stays
    // by itself.
    static std::vector<Solid> joined_smooth_parts(const Shape& shape,
                                                  const std::vector<Solid>& parts)
    {
        std::vector<Solid> result, smooth;
        for (std::size_t n = 0; n < parts.size(); ++n) {
            const bool stays = n == 0 && std::holds_alternative<Difference>(shape);
            const bool joins = !stays && !is_polyhedral(parts[n]) && is_smooth(parts[n]);
            (joins ? smooth : result).push_back(parts[n]);
        }
        if (smooth.empty()) return result;
        result.push_back(std::holds_alternative<Intersection>(shape) ? intersect(std::move(smooth))
                                                                     : unite(std::move(smooth)));
        return result;
    }

    BooleanFormula::Term add_smooth(const Solid& solid, const Transform& map)
    {
        Solid placed = map.is_identity() ? solid : transformed(solid, map);
        if (!placed.bounds().bounded())
            placed =
                intersect({placed, transformed(cube(region_.size()), translation(region_.min))});
        SmoothMesh made = mesher_(placed, tolerance_);
        if (!made.certified) doubt(made.doubt);
        std::vector<IndexedMesh> parts = closed_surfaces(std::move(made.mesh));
        std::vector<BooleanFormula::Term> terms;
        for (IndexedMesh& part : parts) {
            terms.push_back({static_cast<std::int32_t>(scene_.operands.size()), true, false});
            add_operand(std::move(part), made.bound, made.to_surface);
        }
        return terms.size() == 1 ? terms[0]
                                 : BooleanFormula::Term{scene_.formula.add(false, std::move(terms)),
                                                        false, false};
    }

    void doubt(const std::string& what)
    {
        if (scene_.certified) scene_.doubt = what;
        scene_.certified = false;
    }

    void add_operand(IndexedMesh mesh, double deviation, FreeformSource::ToSurface to_surface)
    {
        scene_.operands.push_back(std::move(mesh));
        scene_.deviations.push_back(deviation);
        scene_.to_surface.push_back(std::move(to_surface));
    }

    // The parts connected by edges, if all of them turn outward: cavities belong to what is round
    // them.
    static std::vector<IndexedMesh> closed_surfaces(IndexedMesh mesh)
    {
        DisjointSets sets(mesh.n_faces());
        std::unordered_map<std::uint64_t, std::int32_t> face_at_edge;
        for (std::size_t f = 0; f < mesh.n_faces(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto [a, b] = std::minmax({mesh.faces[f][k], mesh.faces[f][(k + 1) % 3]});
                const auto key =
                    static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
                const auto number = static_cast<std::int32_t>(f);
                sets.unite(face_at_edge.try_emplace(key, number).first->second, number);
            }
        struct Part {
            IndexedMesh mesh;
            std::unordered_map<std::int32_t, std::int32_t> number;  // of vertices, there
        };
        std::map<std::int32_t, Part> parts;
        for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
            Part& part = parts[sets.find(static_cast<std::int32_t>(f))];
            Triangle copy = mesh.faces[f];
            for (std::int32_t& v : copy) {
                const auto next = static_cast<std::int32_t>(part.mesh.n_vertices());
                const auto [place, added] = part.number.try_emplace(v, next);
                if (added) part.mesh.vertices.push_back(mesh.vertices[v]);
                v = place->second;
            }
            part.mesh.faces.push_back(copy);
        }
        std::vector<IndexedMesh> result;
        for (auto& [first, part] : parts) {
            if (parts.size() == 1 || !(measure(part.mesh).volume > 0.0)) return {std::move(mesh)};
            result.push_back(std::move(part.mesh));
        }
        if (result.empty()) result.push_back(std::move(mesh));
        return result;
    }

    BooleanFormula::Term add_leaf(const Solid& solid, const Transform& map)
    {
        const Shape& shape = solid.node().shape;
        const auto number = static_cast<std::int32_t>(scene_.operands.size());
        IndexedMesh mesh;
        if (!std::holds_alternative<Empty>(shape)) {
            auto [known, is_new] = leaves_.try_emplace(&solid.node());
            if (is_new)
                known->second = to_triangles(facet_mesh(shape));
            else
                ++scene_.n_shared;
            mesh = known->second;
        }
        if (!map.is_identity())
            for (Vec3& v : mesh.vertices) v = apply(map, v);
        if (determinant(map) < 0.0)
            for (Triangle& f : mesh.faces) std::swap(f[1], f[2]);
        double deviation = 0.0;
        if (const auto* given = std::get_if<Polyhedron>(&shape)) {
            scene_.clean_operands = false;
            deviation = given->deviation * largest_stretch(map);
            // Whoever made the mesh said so.
            if (deviation > 0.0)
                doubt("the distance of a mesh to what it stands for is taken on trust");
        }
        add_operand(std::move(mesh), deviation, {});
        return {number, true, false};
    }

    const SmoothMesher& mesher_;
    double tolerance_;
    Box3 region_;
    BooleanScene scene_;
    std::unordered_map<const Node*, IndexedMesh> leaves_;  // a shape used often is meshed once
};

double distance_to_plane(const Vec3& p, const IndexedMesh& mesh, const Triangle& f)
{
    const Vec3& a = mesh.vertices[f[0]];
    const Vec3 normal = normalized(cross(mesh.vertices[f[1]] - a, mesh.vertices[f[2]] - a));
    return std::fabs(dot(normal, p - a));
}

// From points of the result to the exact surfaces that they come from.
class Deviation {
public:
    // `rounding` is how far corners may be from where they belong.
    Deviation(const BooleanScene& scene, const MeshBooleanResult& made, double rounding)
        : scene_(scene),
          made_(made),
          rounding_(rounding),
          trees_(scene.operands.size()),
          tree_made_(trees_.size())
    {
    }

    double largest() const
    {
        const double faces = over(made_.mesh.n_faces(), [&](std::size_t f) {
            return std::max(of_corners(f), of_middle(f));
        });
        const std::vector<Crossing> crossings = crossings_at_vertices();
        return std::max(faces, over(crossings.size(), [&](std::size_t v) {
                            return crossings[v].operand[1] < 0 ? 0.0 : of_crossing(v, crossings[v]);
                        }));
    }

private:
    template <class F>
    static double over(std::size_t n, const F& f)
    {
        constexpr std::size_t kMost = 3'000;
        const std::size_t stride = 1 + n / kMost;
        std::vector<double> found((n + stride - 1) / stride, 0.0);
        parallel_for(found.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) found[i] = f(i * stride);
        });
        return found.empty() ? 0.0 : *std::max_element(found.begin(), found.end());
    }

    // Of exact operands: what rounding did. The plane of a needle is known near by only; what seems
    // far off it is measured to the operand.
    double of_corners(std::size_t f) const
    {
        const std::int32_t i = made_.operand[f];
        if (scene_.deviations[i] > 0.0) return 0.0;
        const IndexedMesh& source = scene_.operands[i];
        double largest = 0.0;
        for (const std::int32_t v : made_.mesh.faces[f]) {
            const Vec3& p = made_.mesh.vertices[v];
            double d = distance_to_plane(p, source, source.faces[made_.source_face[f]]);
            if (!(d <= rounding_)) d = distance(tree(i).nearest(p).point, p);
            largest = std::max(largest, d);
        }
        return largest;
    }

    const MeshTree& tree(std::int32_t operand) const
    {
        std::call_once(tree_made_[operand], [&] {
            trees_[operand] = std::make_unique<MeshTree>(scene_.operands[operand]);
        });
        return *trees_[operand];
    }

    double of_middle(std::size_t f) const
    {
        const auto& to_surface = scene_.to_surface[made_.operand[f]];
        if (!to_surface) return 0.0;
        const Vec3 middle = middle_of(static_cast<std::int32_t>(f));
        const auto p = to_surface(middle);
        return p ? distance(*p, middle) : 0.0;
    }

    // Two curved operands whose faces meet in a vertex, with a face of each; -1 without.
    struct Crossing {
        std::array<std::int32_t, 2> operand{-1, -1}, face{-1, -1};
    };

    // To the curve of the two surfaces, or to one of them where that is nearer and on the same side
    // of the other as its face.
    double of_crossing(std::size_t v, const Crossing& c) const
    {
        const Vec3& start = made_.mesh.vertices[v];
        double least = to_curve(start, c.operand);
        for (const std::size_t k : {0u, 1u}) {
            const auto& own = scene_.to_surface[c.operand[k]];
            const auto& other = scene_.to_surface[c.operand[1 - k]];
            const Vec3 inside = middle_of(c.face[k]);
            const auto p = own(start);
            const auto beside = p ? other(*p) : std::nullopt, kept = other(inside);
            if (beside && kept && dot(*p - *beside, inside - *kept) >= 0.0)
                least = std::min(least, distance(*p, start));
        }
        return std::isfinite(least) ? least : 0.0;
    }

    // Back and forth between two surfaces, until on both: a point of their curve is there.
    double to_curve(const Vec3& start, const std::array<std::int32_t, 2>& operands) const
    {
        constexpr int kSteps = 24;
        Vec3 at = start;
        for (int step = 0; step < kSteps; ++step) {
            const Vec3 before = at;
            for (const std::int32_t i : operands) {
                const auto p = scene_.to_surface[i](at);
                if (!p) return std::numeric_limits<double>::infinity();
                at = *p;
            }
            if (distance(at, before) <= 1e-3 * distance(at, start)) return distance(at, start);
        }
        return std::numeric_limits<double>::infinity();
    }

    std::vector<Crossing> crossings_at_vertices() const
    {
        constexpr std::int32_t kMany = -2;
        std::vector<Crossing> crossings(made_.mesh.n_vertices());
        for (std::size_t f = 0; f < made_.mesh.n_faces(); ++f)
            for (const std::int32_t v : made_.mesh.faces[f]) {
                const std::int32_t i = made_.operand[f];
                auto& [operand, face] = crossings[v];
                if (operand[0] == -1 || (operand[1] == -1 && i != operand[0])) {
                    const std::size_t k = operand[0] == -1 ? 0 : 1;
                    operand[k] = i;
                    face[k] = static_cast<std::int32_t>(f);
                } else if (i != operand[0] && i != operand[1]) {
                    operand[1] = kMany;
                }
            }
        for (auto& [operand, face] : crossings)
            if (operand[1] < 0 || !scene_.to_surface[operand[0]] || !scene_.to_surface[operand[1]])
                operand[1] = -1;
        return crossings;
    }

    Vec3 middle_of(std::int32_t f) const
    {
        const Triangle& t = made_.mesh.faces[f];
        const std::vector<Vec3>& v = made_.mesh.vertices;
        return (v[t[0]] + v[t[1]] + v[t[2]]) / 3.0;
    }

    const BooleanScene& scene_;
    const MeshBooleanResult& made_;
    double rounding_;
    mutable std::vector<std::unique_ptr<MeshTree>> trees_;  // of operands, once they are needed
    mutable std::deque<std::once_flag> tree_made_;
};

template <typename Holds>
bool every_shape(const Solid& solid, const Holds& holds)
{
    std::vector<const Solid*> open{&solid};
    std::unordered_map<const Node*, bool> seen;
    while (!open.empty()) {
        const Solid* next = open.back();
        open.pop_back();
        if (!seen.try_emplace(&next->node(), true).second) continue;
        const Shape& shape = next->node().shape;
        if (const auto* parts = parts_of(shape)) {
            for (const Solid& part : *parts) open.push_back(&part);
        } else if (const Solid* part = only_part(shape)) {
            open.push_back(part);
        } else if (!holds(shape)) {
            return false;
        }
    }
    return true;
}

}  // namespace

bool is_polyhedral(const Solid& solid)
{
    return every_shape(solid, [](const Shape& shape) {
        return is_faceted(shape) || std::holds_alternative<Empty>(shape);
    });
}

bool is_smooth(const Solid& solid)
{
    return every_shape(solid, [](const Shape& shape) {
        if (const auto* s = std::get_if<Cylinder>(&shape)) return s->fragments <= kFewFaces;
        if (const auto* s = std::get_if<Sphere>(&shape)) return s->fragments == 0;
        return !std::holds_alternative<Polyhedron>(shape) &&
               !std::holds_alternative<Freeform>(shape);
    });
}

BooleanScene boolean_scene(const Solid& solid, const Box3& box, const SmoothMesher& mesher,
                           double tolerance)
{
    return SceneBuilder(mesher, tolerance, box.inflated(0.125 * box.diagonal())).build(solid);
}

namespace {

// One way through scene, boolean and proof.
struct Attempt {
    BooleanScene scene;
    MeshBooleanResult made;
    BooleanCertificate certificate;
    double deviation = 0.0, snapped = 0.0, rounded = 0.0;

    bool exact_parts() const { return deviation == 0.0; }
};

Attempt attempt(const Solid& solid, const Box3& box, const SmoothMesher& mesher, double share,
                double tolerance, StageClock& clock)
{
    Attempt a;
    a.scene = boolean_scene(solid, box, mesher, share * tolerance);
    clock.end("leaves");
    MeshBooleanOptions options;
    options.operands_may_cross_themselves = !a.scene.clean_operands;
    a.made = mesh_boolean(a.scene.operands, a.scene.formula, options);
    clock.end("boolean");
    for (const double d : a.scene.deviations) a.deviation = std::max(a.deviation, d);
    const MeshBooleanReport& report = a.made.report;
    a.snapped = std::sqrt(3.0) * report.largest_snap;
    // Corners where three planes meet are rounded to the grid, then to doubles of their size.
    const Box3 all = bounds(a.made.mesh);
    a.rounded = (report.n_new_points > 0 ? std::sqrt(3.0) * 0.5 * report.grid_step : 0.0) +
                (all.empty() ? 0.0 : 0x1p-51 * (norm(all.min) + norm(all.max)));
    if (!a.exact_parts() && a.scene.certified) {
        const double rounding = a.snapped + a.rounded;
        a.certificate = certify_boolean(a.scene.operands, a.scene.formula, a.scene.deviations,
                                        2.0 * rounding, a.made, tolerance - rounding);
        clock.end("certify");
    }
    return a;
}

// What keeps the bound from being proven.
std::string doubt_of(const Attempt& a)
{
    if (a.exact_parts())
        return "corners had to be moved to the grid of the exact boolean, by up to " +
               to_text(a.snapped);
    if (!a.scene.certified) return a.scene.doubt;
    if (a.certificate.doubtful.empty())
        return "curved surfaces that cross: the bound would exceed the tolerance";
    const Vec3 c = a.certificate.doubtful.front().center();
    return "curved surfaces touch or cross at a small angle near [" + to_text(c[0]) + ", " +
           to_text(c[1]) + ", " + to_text(c[2]) + "]";
}

}  // namespace

Explanation explain_boolean(const MeshBooleanReport& report)
{
    Explanation e;
    e.add("faces that nothing touches passed through", report.n_passive_faces, "faces");
    e.add("faces far from all contacts not looked at", report.n_left_alone, "faces");
    e.add("faces where they cannot matter not cut", report.n_buried_faces, "faces");
    e.add("clusters of parts that are apart solved alone",
          report.n_clusters > 1 ? report.n_clusters : 0, "clusters");
    e.add("groups of neighbours united first", report.n_steps, "groups");
    e.add("operands known from an earlier call", report.n_known, "operands");
    e.add("operands known not to cross themselves", report.n_known_clean, "operands");
    return e;
}

void mesh_by_boolean(const Solid& solid, const Box3& box, const SmoothMesher& mesher,
                     MeshedSolid& result)
{
    constexpr double kShare = 0.15, kFinerShare = 0.07;  // of the tolerance, for smooth parts
    constexpr double kReserve = 1.5;                     // over what sampling finds
    result.method = "boolean";
    StageClock clock(result.seconds);
    Attempt a = attempt(solid, box, mesher, kShare, result.tolerance, clock);
    std::optional<Attempt> finer;
    if (!a.certificate.proven && !a.exact_parts() && a.scene.certified) {
        try {
            finer = attempt(solid, box, mesher, kFinerShare, result.tolerance, clock);
        } catch (const ToleranceNotMet&) {
            // Too many triangles: the first attempt is the answer.
        }
    }
    if (finer && finer->certificate.proven) a = std::move(*std::exchange(finer, std::nullopt));
    result.error.measured = Deviation(a.scene, a.made, a.snapped + a.rounded).largest();
    if (finer && kReserve * result.error.measured > result.tolerance) {
        a = std::move(*finer);
        result.error.measured = Deviation(a.scene, a.made, a.snapped + a.rounded).largest();
    }
    clock.end("measure");

    const MeshBooleanReport& report = a.made.report;
    result.error.certified = a.exact_parts() ? report.largest_snap == 0.0 : a.certificate.proven;
    // An estimate is not below what was found.
    const double curved = a.exact_parts() ? 0.0
                          : a.certificate.proven
                              ? a.certificate.bound
                              : std::max(a.deviation, kReserve * result.error.measured);
    result.error.bound = curved + a.snapped + a.rounded;
    result.error.parts = {
        {"curved operands", curved}, {"rounding", a.rounded}, {"snapping", a.snapped}};
    if (result.error.bound > result.tolerance)
        throw ToleranceNotMet("mesh: the boolean of the parts is within " +
                                  to_text(result.error.bound) + " only, asked for " +
                                  to_text(result.tolerance),
                              result.tolerance, result.error.bound, {box});
    if (!result.error.certified) {
        result.error.doubt = doubt_of(a);
        result.explanation.add("error bound estimated: " + result.error.doubt, 1, "places");
    }
    result.explanation.add("operands that share the mesh of an equal one", a.scene.n_shared,
                           "operands");
    for (const Explanation::Entry& e : explain_boolean(report).entries)
        result.explanation.add(e.what, e.count, e.unit);
    result.mesh = std::move(a.made.mesh);
}

}  // namespace genus
