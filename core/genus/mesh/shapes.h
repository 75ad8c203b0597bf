#pragma once

#include <cstdint>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// A sphere: the icosahedron with every edge cut into `parts` and all vertices on the sphere, 20
/// parts^2 triangles of nearly one shape and 10 parts^2 + 2 vertices, turned outward. All valences
/// are 6 but for twelve of 5. O(faces).
///
/// Throws InvalidInput unless 1 <= parts <= 5000 and the radius is positive and finite.
IndexedMesh icosphere(std::int32_t parts, double radius = 1.0);

/// A flat sheet in the plane z = 0 that faces up: nx times ny quadrilaterals from the origin to
/// (width, depth). Vertex (i, j) has the number j (nx + 1) + i. Throws InvalidInput for counts
/// below 1, more than 10^8 faces, or sizes that are not positive and finite.
PolygonMesh grid_mesh(std::int32_t nx, std::int32_t ny, double width = 1.0, double depth = 1.0);

/// A right prism over a regular polygon of n corners on a circle of radius `r`, the first corner
/// on the x axis; the base in the plane z = 0, or the middle there if `center`. n quadrilaterals
/// and two faces of n corners. Throws InvalidInput unless 3 <= n <= 10^7 and the sizes are positive
/// and finite.
PolygonMesh prism(std::int32_t n, double h, double r = 1.0, bool center = false);

/// A ring of nu by nv quadrilaterals about the z axis, vertices on the torus with a tube of radius
/// `r` round a circle of radius `R`: V - E + F = 0. Throws InvalidInput unless nu, nv >= 3, there
/// are at most 10^8 faces, and 0 < r < R.
PolygonMesh torus_mesh(double R, double r, std::int32_t nu, std::int32_t nv);

}  // namespace genus
