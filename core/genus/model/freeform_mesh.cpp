#include "genus/model/freeform_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/error.h"
#include "genus/base/transform.h"
#include "genus/mesh/validate.h"
#include "genus/volume/extended_marching_cubes.h"
#include "genus/volume/marching_cubes.h"

namespace genus {

namespace {

struct Placed {
    const FreeformSource* source = nullptr;
    Transform map;
};

Placed placed_source(const Solid& solid)
{
    Placed p;
    for (const Solid* at = &solid;;) {
        const Shape& shape = at->node().shape;
        if (const auto* moved = std::get_if<Transformed>(&shape)) {
            p.map = p.map * moved->map;
            at = &moved->part;
        } else if (const auto* painted = std::get_if<Colored>(&shape)) {
            at = &painted->part;
        } else {
            if (const auto* leaf = std::get_if<Freeform>(&shape)) p.source = leaf->source.get();
            return p;
        }
    }
}

// Moves a mesh to its place; the bounds grow with the map.
void place(const Transform& map, FreeformSource::Meshed& made)
{
    if (map.is_identity()) return;
    for (Vec3& v : made.mesh.vertices) v = apply(map, v);
    if (determinant(map) < 0.0)
        for (Triangle& f : made.mesh.faces) std::swap(f[1], f[2]);
    const Box3 box = bounds(made.mesh);
    const double reach = box.empty() ? 0.0 : norm(box.min) + norm(box.max);
    const double stretch = largest_stretch(map);
    made.bound = made.bound * stretch + 0x1p-50 * reach;
    made.measured *= stretch;
    if (made.to_surface)
        made.to_surface = [own = std::move(made.to_surface), map,
                           back = inverse(map)](const Vec3& p) -> std::optional<Vec3> {
            const auto x = own(apply(back, p));
            return x ? std::optional(apply(map, *x)) : std::nullopt;
        };
}

IndexedMesh on_grid(const Implicit& field, const Box3& box, double cell, MeshMethod method)
{
    if (method == MeshMethod::Mc) {
        MarchingCubesOptions grid;
        grid.cell_size = cell;
        return marching_cubes(field, box, grid);
    }
    ExtendedMarchingCubesOptions grid;
    grid.cell_size = cell;
    return extended_marching_cubes(field, box, grid);
}

// By marching cubes, the grid made finer until the distance to the surface is proven. Where a few
// grids beyond the one on which sampling leaves a third of the tolerance in reserve do not do it,
// the mesh on that one is the answer, its bound estimated.
FreeformSource::Meshed mesh_by_field(const FreeformSource& source, double tolerance,
                                     const MeshOptions& options)
{
    constexpr double kReserve = 1.5;
    constexpr int kAttempts = 16, kProofs = 4;
    constexpr double kFiner = 0.7;
    constexpr double kOtherGrid = 0.87;  // where features of one grid run into each other
    const auto field = source.field();
    if (!field)
        throw InvalidInput(source.describe() +
                           ": there is no formula for it; method must be auto "
                           "or boolean");
    const Box3 box = source.bounds().inflated(0.01 * source.bounds().diagonal());
    const Vec3 size = box.size();
    double cell = std::max({size[0], size[1], size[2]}) / 15.7;
    double reached = std::numeric_limits<double>::infinity();
    std::int64_t expected = 0;
    std::optional<FreeformSource::Meshed> estimated;
    int proofs = 0;
    for (int attempt = 0; attempt < kAttempts && proofs < kProofs; ++attempt) {
        if (expected > options.max_triangles) break;
        FreeformSource::Meshed made;
        made.mesh = on_grid(*field, box, cell, options.method);
        expected = 4 * static_cast<std::int64_t>(made.mesh.n_faces());
        made.measured = source.sampled_distance(made.mesh);
        reached = std::min(reached, kReserve * made.measured);
        if (made.measured > 0.6 * tolerance) {
            cell *= 0.5;
            continue;
        }
        if (!validate(made.mesh).ok()) {
            cell *= kOtherGrid;
            continue;
        }
        ++proofs;
        if (const auto bound = source.proven_distance(made.mesh, tolerance)) {
            made.bound = *bound;
            made.certified = true;
            return made;
        }
        made.bound = kReserve * made.measured;
        made.doubt =
            "the mesh of marching cubes was not shown to be near the surface, on grids of cells "
            "down to " +
            to_text(cell);
        if (!estimated && made.bound <= tolerance) estimated = std::move(made);
        cell *= kFiner;
    }
    if (estimated) return std::move(*estimated);
    throw ToleranceNotMet(
        "mesh: no grid within the limits reaches the tolerance " + to_text(tolerance), tolerance,
        reached, {box});
}

}  // namespace

bool is_lone_freeform(const Solid& solid)
{
    return placed_source(solid).source != nullptr;
}

FreeformSource::Meshed mesh_freeform(const Solid& solid, double tolerance,
                                     const FreeformSource::Limits& limits)
{
    const Placed p = placed_source(solid);
    FreeformSource::Meshed made =
        p.source->mesh(tolerance * (1.0 - 0x1p-20) / largest_stretch(p.map), limits);
    place(p.map, made);
    return made;
}

bool mesh_freeform_alone(const Solid& solid, const MeshOptions& options, MeshedSolid& result)
{
    FreeformSource::Meshed made;
    if (options.method == MeshMethod::Auto) {
        made = mesh_freeform(solid, result.tolerance, {options.max_triangles, options.measure});
        if (!validate(made.mesh).ok()) return false;
        result.method = "freeform";
    } else {
        const Placed p = placed_source(solid);
        made = mesh_by_field(*p.source, result.tolerance / largest_stretch(p.map), options);
        place(p.map, made);
        result.method = options.method == MeshMethod::Mc ? "mc" : "emc";
    }
    result.error = {made.bound,
                    made.certified,
                    made.measured,
                    {{"surface", made.bound}},
                    std::move(made.doubt)};
    result.mesh = std::move(made.mesh);
    return true;
}

}  // namespace genus
