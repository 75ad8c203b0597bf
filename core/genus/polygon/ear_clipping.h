#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "genus/polygon/polygon.h"

namespace genus {

/// Which ear is cut next.
enum class EarOrder {
    InTurn,    ///< going round: fastest
    BestShape  ///< that of the greatest height over its longest side: a quality mode, O(n^2)
};

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
                                                      std::span<const std::int32_t> loop,
                                                      EarOrder order = EarOrder::InTurn);

/// Joins holes to the outer loop by bridges, then cuts ears, the best-shaped first. `loops[0]` is
/// the outer one and turns counterclockwise, the others are holes and turn clockwise; no
/// two corners may be at one place. No value if there is no ear to cut, or no way to a hole.
/// O(n h) for bridges as a rule, O(n^2) at worst, beside the cutting.
///
/// Implements [eberly2008], section 3 (holes), with bridges to any visible point on the left
/// instead of the first along a ray.
std::optional<std::vector<PolygonTriangle>> cut_corners(
    std::span<const Vec2> points, const std::vector<std::vector<std::int32_t>>& loops);

}  // namespace genus
