#pragma once

#include "genus/base/vec.h"

namespace genus {

/// Exact signs (-1, 0, 1) of determinants of doubles. A floating-point filter settles nearly all
/// calls; the rest is evaluated exactly with floating-point expansions. Any finite input whose
/// products neither overflow nor underflow gives the true sign: coordinates of magnitude up to
/// 1e100 and not below 1e-100 (or zero).
///
/// Implements [shewchuk1997], sections 2 to 4.

/// 1 if a, b, c turn counterclockwise, 0 if they are on one line.
int orient2d(const Vec2& a, const Vec2& b, const Vec2& c);

/// 1 if d lies on the side of the plane a, b, c from which they appear clockwise, that is below
/// a counterclockwise triangle; -1 above, 0 in the plane.
int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// 1 if d lies inside the circle through a, b, c, these counterclockwise; 0 on it.
int in_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d);

}  // namespace genus
