#pragma once

#include "genus/model/mesh_solid.h"

namespace genus {

/// The road over a uniform grid: marching cubes, plain (MeshMethod::Mc) or extended. Nothing is
/// proven; the grid is halved until the sampled deviation leaves a third of the tolerance in
/// reserve. Fills mesh, error, seconds and explanation of `result`, whose tolerance is given.
/// Throws ToleranceNotMet if no grid within `max_triangles` will do.
void mesh_over_grid(const Solid& solid, const Box3& box, const MeshOptions& options,
                    MeshedSolid& result);

}  // namespace genus
