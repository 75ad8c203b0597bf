#pragma once

#include "genus/mesh/indexed_mesh.h"
#include "genus/model/solid.h"

namespace genus {

/// True for shapes that are polyhedra as they stand: cubes, polyhedra, and round shapes with a
/// number of fragments.
bool is_faceted(const Shape& shape);

/// The polyhedron that the text language builds for a faceted shape, faces counterclockwise seen
/// from outside, in the shape's own coordinates. A sphere with n fragments has (n + 1) / 2 rings
/// at polar angles 180 (i + 0.5) / rings degrees, points of a ring at angles 360 j / n, so it lies
/// inside the round sphere; a cylinder has n sides with their edges on the round one.
///
/// Throws InvalidInput for other shapes and for more than 10^8 corners. O(corners).
PolygonMesh facet_mesh(const Shape& shape);

}  // namespace genus
