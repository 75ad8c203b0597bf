#pragma once

#include <optional>

#include "genus/model/csg_field.h"
#include "genus/model/mesh_solid.h"

namespace genus {

/// A place where the border of the solid is a jump of one of its functions, if one was seen; see
/// jump_parts.h. Some milliseconds for functions that may jump, nothing for others.
std::optional<Vec3> jump_at_border(const CsgField& field, const Box3& box);

/// The road over a uniform grid: marching cubes, plain (MeshMethod::Mc) or extended. The grid is
/// made finer until the sampled deviation leaves a third of the tolerance in reserve: halved, or by
/// less where that is enough, or where the error did not fall as it should because edges run along
/// planes of samples. Specks of the grid are left out (specks.h). Then a
/// bound is proven, by `certify` or else by boxes (mesh_bound.h); where boxes find a place that is
/// farther than the tolerance, as a thin tip that the grid cut off, it is halved on. If neither
/// comes to an end on two grids, as where surfaces touch, the error is estimated and says so; so it
/// is for functions, of which the certified road proves more at less cost.
///
/// Where a jump is the border, normals mean nothing and marching cubes stays plain: its vertices
/// are where the side changes, its edges nearer by the cell only. If that would take more than some
/// million faces, it is not begun.
/// `jump` is what jump_at_border says of the field of the solid. Fills mesh, error, seconds and
/// explanation of `result`, whose tolerance is given. Throws ToleranceNotMet if no grid within
/// `max_triangles` will do, with the place of a jump.
void mesh_over_grid(const Solid& solid, const Box3& box, const MeshOptions& options,
                    const std::optional<Vec3>& jump, MeshedSolid& result);

}  // namespace genus
