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

/// A closed polyhedron near an exact round shape: sphere, ellipsoid, cylinder, frustum, cone or
/// torus with no fragments, in the shape's own coordinates.
struct Tessellation {
    PolygonMesh mesh;  // planar faces of degree 3, 4 or, for caps, more; outward
    double bound;      // no point of either surface is farther than this from the other
};

/// All vertices lie on the surface, so convex shapes are inscribed. `bound` <= `tolerance`. Faces
/// grow in number with 1 / tolerance (a cylinder's with its square root).
/// Throws InvalidInput for other shapes, a tolerance that is not positive, and more than 10^8
/// corners.
Tessellation tessellate(const Shape& shape, double tolerance);

}  // namespace genus
