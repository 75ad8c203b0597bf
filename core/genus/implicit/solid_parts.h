#pragma once

#include "genus/base/box.h"
#include "genus/implicit/expression.h"
#include "genus/implicit/smooth_parts.h"

namespace genus {

/// As smooth_parts, of the solid where the expression is not positive: where that changes its sign
/// at a jump or a pole it is cut there, see jump_parts.h. Of mod(x, 1) - 1/2 each period is a part
/// of its own, between planes. What the cuts leave without volume, but for rounding, is dropped, as
/// the point in which a plane touches a ball from outside, and so are sides that the other parts
/// never reach. The parts are the same solid but for points on such places; their values are
/// others.
///
/// The expression is a single leaf if there would be more than 256, or one of them is not shown to
/// be defined and finite in the box. O(nodes) for each leaf, jump_at_border, and at
/// most 200 bounds of the leaves for each.
SmoothParts solid_parts(const Expression& expression, const Box3& box);

}  // namespace genus
