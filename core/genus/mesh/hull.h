#pragma once

#include <span>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// The convex hull of points in space, closed and oriented outward. Points of one face plane make
/// one face, a convex polygon of any degree; no vertex lies inside a face or an edge. Vertices
/// keep the bits and the order of the points. Empty if all points lie in one plane.
///
/// Every decision is an exact sign. Throws InvalidInput for points that are not finite.
/// O(n log n) expected for points that are mostly inside, O(n^2) at worst.
///
/// Implements [barber1996] with exact signs: a facet in whose plane the point lies counts as
/// hidden, which keeps the visible part a disc without facets of no area.
PolygonMesh convex_hull(std::span<const Vec3> points);

}  // namespace genus
