#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "genus/polygon/polygon.h"

namespace genus {

/// Flips edges until no point lies strictly inside the circle round a triangle beside which it
/// lies: the constrained Delaunay triangulation of the same region, which of all
/// triangulations has the greatest least angle. Edges with one triangle, and those in `fixed`,
/// stay. Triangles must be counterclockwise, of positive area, and not overlap.
///
/// Every decision is an exact sign. Takes O(n) flips for most input, O(n^2) at worst.
///
/// Implements [lawson1972] (flips) for triangulations with fixed edges as defined in [lee1986].
void make_delaunay(std::span<const Vec2> points, std::vector<PolygonTriangle>& triangles,
                   std::span<const std::array<std::int32_t, 2>> fixed = {});

}  // namespace genus
