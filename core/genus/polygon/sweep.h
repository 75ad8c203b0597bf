#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "genus/polygon/polygon.h"

namespace genus {

struct SweepTriangulation {
    std::vector<PolygonTriangle> triangles;
    /// For each point the first one at its place.
    std::vector<std::int32_t> first_at;
};

/// Triangulates what the rings wind round once, by a line that sweeps over them; for large
/// polygons. Outer rings turn counterclockwise, holes clockwise.
///
/// Rings may touch each other and themselves in common points and along common edges run through
/// once each way; flat corners and repeated points are legal. Points at the same place count as
/// one: triangles name the first of them. Edges that cross, a point inside an edge, a hole outside
/// or in another hole, a ring run through twice are refused: InvalidInput names points and place.
/// Coordinates must be finite.
///
/// All triangles have positive area and turn counterclockwise; every edge of a ring is a side of a
/// triangle: n - 2 + 2 h triangles for n points in an outer ring and h holes that touch nothing.
/// Every decision is an exact sign. O(n log n).
///
/// Implements [hertel1983] (each free stretch of the line drags along the chain of points not yet
/// joined to anything right of them); crossings are found as in [shamos1976].
SweepTriangulation sweep_triangulation(std::span<const OrientedRing> rings);

}  // namespace genus
