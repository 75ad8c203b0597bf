#pragma once

#include <optional>

#include "genus/implicit/expression.h"
#include "genus/implicit/quadric.h"

namespace genus {

/// Where the expression is not positive as a half-space, if it is a polynomial of degree one by its
/// sums, differences, negatives, and products and quotients by numbers. Coefficients are rounded as
/// these are carried out. Nothing for other expressions. O(nodes).
std::optional<Quadric> half_space_of(const Expression& expression);

}  // namespace genus
