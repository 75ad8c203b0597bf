#pragma once

#include <vector>

#include "genus/polygon/polygon.h"

namespace genus {

enum class TriangulateMethod {
    Auto,     ///< Ear for few points, else Sweep
    Ear,      ///< corner cutting, best-shaped corner first: few points, good shapes; rings that
              ///< touch are left to Sweep
    Sweep,    ///< sweep line: many points
    Delaunay  ///< constrained Delaunay, at about twice the time of Sweep: the best shapes
};

/// Cuts a polygon into triangles without new points. Triangles turn counterclockwise, have
/// positive area, and name points: the outer ring first, then the holes. Rings of either
/// orientation; every edge becomes the side of a triangle; n - 2 + 2 h triangles for n points and
/// h holes where no ring touches itself or another.
///
/// Flat corners and repeated points are legal, and rings may touch in points of both, or along
/// edges run through once each way; points at one place count as the first of them. What is no
/// polygon is refused whatever the method: InvalidInput names the points where edges cross or
/// overlap, a point lies inside an edge, a hole is not inside the outer ring or is inside another
/// hole; and a ring without area. All decisions are exact.
std::vector<PolygonTriangle> triangulate(const Polygon& polygon,
                                         TriangulateMethod method = TriangulateMethod::Auto);

}  // namespace genus
