#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "genus/polygon/polygon.h"

namespace genus {

/// Exchanges inner edges until no point lies strictly inside the circle round a triangle beside
/// which it lies: the constrained Delaunay triangulation of the same region, which of all
/// triangulations has the greatest least angle. Edges with one triangle, and those in `fixed`,
/// stay. Triangles must be counterclockwise, of positive area, and not overlap.
///
/// Every decision is an exact sign. O(n log n) for a region without holes whatever its shape; a
/// hole adds the cost of one more join, O(n) at worst, a few triangles as a rule.
///
/// Implements [lee1986], simple polygons (parts joined over a diagonal), with the merge step of
/// [guibas1985], divide and conquer, and joins in the order of a restricted multilevel partition
/// [frederickson1997] of the tree of triangles in place of a balanced cut of the polygon.
void make_delaunay(std::span<const Vec2> points, std::vector<PolygonTriangle>& triangles,
                   std::span<const std::array<std::int32_t, 2>> fixed = {});

}  // namespace genus
