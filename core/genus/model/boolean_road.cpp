#include "genus/model/boolean_road.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/model/leaf_mesh.h"

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
    SceneBuilder(const SmoothMesher& mesher, const Box3& region) : mesher_(mesher), region_(region)
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
        IndexedMesh mesh;
        scene_.deviation = std::max(scene_.deviation, mesher_(placed, mesh));
        scene_.operands.push_back(std::move(mesh));
        return {static_cast<std::int32_t>(scene_.operands.size()) - 1, true, false};
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
        scene_.operands.push_back(std::move(mesh));
        if (const auto* given = std::get_if<Polyhedron>(&shape)) {
            scene_.clean_operands = false;
            scene_.deviation = std::max(scene_.deviation, given->deviation * largest_stretch(map));
        }
        return {number, true, false};
    }

    const SmoothMesher& mesher_;
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

double largest_deviation(const BooleanScene& scene, const MeshBooleanResult& made)
{
    double largest = 0.0;
    for (std::size_t f = 0; f < made.mesh.n_faces(); ++f) {
        const IndexedMesh& source = scene.operands[made.operand[f]];
        for (const std::int32_t v : made.mesh.faces[f])
            largest = std::max(largest, distance_to_plane(made.mesh.vertices[v], source,
                                                          source.faces[made.source_face[f]]));
    }
    return largest;
}

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

BooleanScene boolean_scene(const Solid& solid, const Box3& box, const SmoothMesher& mesher)
{
    return SceneBuilder(mesher, box.inflated(0.125 * box.diagonal())).build(solid);
}

void mesh_by_boolean(const Solid& solid, const Box3& box, const SmoothMesher& mesher,
                     MeshedSolid& result)
{
    double last = seconds_now();
    const auto end_stage = [&](const char* stage) {
        const double now = seconds_now();
        result.seconds.emplace_back(stage, now - last);
        last = now;
    };
    result.method = "boolean";
    const BooleanScene scene = boolean_scene(solid, box, mesher);
    end_stage("leaves");
    MeshBooleanOptions options;
    options.operands_may_cross_themselves = !scene.clean_operands;
    MeshBooleanResult made = mesh_boolean(scene.operands, scene.formula, options);
    end_stage("boolean");
    result.error.measured = largest_deviation(scene, made);
    end_stage("measure");

    const MeshBooleanReport& report = made.report;
    const double snapped = std::sqrt(3.0) * report.largest_snap;
    const double rounded = report.n_new_points > 0 ? std::sqrt(3.0) * 0.5 * report.grid_step : 0.0;
    // Corners where three planes meet are rounded to the grid, then to doubles of their size.
    const double digits =
        bounds(made.mesh).empty()
            ? 0.0
            : 0x1p-51 * (norm(bounds(made.mesh).min) + norm(bounds(made.mesh).max));
    result.error.bound = scene.deviation + snapped + rounded + digits;
    result.error.certified = report.largest_snap == 0.0 && scene.deviation == 0.0;
    result.error.parts = {{"curved operands", scene.deviation},
                          {"rounding", rounded + digits},
                          {"snapping", snapped}};
    if (result.error.bound > result.tolerance)
        throw ToleranceNotMet("mesh: the boolean of the parts is within " +
                                  to_text(result.error.bound) + " only, asked for " +
                                  to_text(result.tolerance),
                              result.tolerance, result.error.bound, {box});
    result.explanation.add("operands that share the mesh of an equal one", scene.n_shared,
                           "operands");
    result.explanation.add("faces that nothing touches passed through", report.n_passive_faces,
                           "faces");
    result.mesh = std::move(made.mesh);
}

}  // namespace genus
