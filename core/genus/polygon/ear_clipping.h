#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "genus/polygon/polygon.h"

namespace genus {

/// Cuts one counterclockwise ring into triangles by cutting off ears: corners whose triangle holds
/// no other point of the ring. Flat corners are kept and get triangles of positive area; where
/// the ring touches itself in points or along edges it may do so as long as it does not cross.
///
/// `loop` names the points of the ring in order; the triangles name them alike, n - 2 for a ring
/// of n, counterclockwise. No value if there is no ear to cut: the ring crosses itself, turns
/// clockwise or lies on one line. O(n r) for r reflex corners, O(n) for a convex ring.
///
/// Implements [meisters1975] (two ears theorem), ear test by reflex corners as in [eberly2008].
std::optional<std::vector<PolygonTriangle>> clip_ears(std::span<const Vec2> points,
                                                      std::span<const std::int32_t> loop);

}  // namespace genus
