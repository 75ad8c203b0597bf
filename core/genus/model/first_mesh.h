#pragma once

#include <optional>
#include <vector>

#include "genus/model/cell_mesh.h"
#include "genus/model/solid.h"
#include "genus/model/surface_form.h"

namespace genus {

/// A guess at a coarse mesh of a solid whose faces know their surfaces: the exact boolean of its
/// leaves, each as a polyhedron of a dozen sides round. Vertices are near their surfaces, not on
/// them. Right where features are larger than the sagitta of such sides, and where surfaces that
/// touch do so at corners of theirs; nothing is promised, a certificate has to tell.
///
/// `forms` and `cube` are those of the solid's CsgField. Nothing comes back where a leaf is none of
/// sphere, ellipsoid, cylinder, cone, torus, half-space or convex polyhedron, or where more than
/// three surfaces meet in a corner.
///
/// Cost: that of a boolean of about a hundred faces a leaf. Throws what mesh_boolean throws.
std::optional<SurfaceMesh> first_mesh(const Solid& solid, const std::vector<SurfaceForm>& forms,
                                      const Box3& cube);

}  // namespace genus
