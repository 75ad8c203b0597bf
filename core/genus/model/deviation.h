#pragma once

#include <vector>

#include "genus/model/cell_mesh.h"
#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"

namespace genus {

/// Largest distance found between mesh and exact solid, by sampling, in model units. From the mesh:
/// the middle of every face and edge, of 32,768 faces where there are more, each to the nearest
/// point on the surfaces, curves and corners of its surroundings that lies on the solid. From the
/// solid: where random lines through the box of the mesh cross the exact surface, each to the
/// nearest point of the mesh. Shares nothing with the reasoning of `certify`. Faces and lines come
/// from a fixed seed.
///
/// Functions may have jumps in the border of the solid, where they have no zero that a point could
/// go to. With `by_sides` points of the mesh look along the normal of their face for where the
/// side changes: never nearer than the solid is.
double measure_deviation(const SurfaceMesh& mesh, const SignFormula& formula,
                         const std::vector<SurfaceForm>& forms, const Box3& box,
                         bool by_sides = false);

}  // namespace genus
