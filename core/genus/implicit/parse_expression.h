#pragma once

#include <string_view>

#include "genus/implicit/expression.h"

namespace genus {

/// Reads a formula in x, y and z: numbers; + - * / % ^ (and ** for ^), ^ binding tightest and from
/// the right; parentheses; pi, tau, e; and functions of angles in radians:
///
///   sin cos tan asin acos atan sinh cosh tanh exp log (ln) log2 log10 sqrt cbrt abs sign square
///   floor ceil round              of one
///   atan2(y, x) pow mod           of two
///   min max hypot (length)        of one or more
///   clamp(a, low, high) mix(a, b, t) smin(a, b, width) smax(a, b, width) repeat(a, period)
///
/// A text may compare two formulas, "x^2 + y^2 <= 1 - z^2" or "... = 1": the function is then left
/// less right, or right less left for >= and >. O(length), but for what nests deeper than 200.
///
/// Throws InvalidInput naming the column, from 1, of what cannot be read; for a text longer than
/// 10^6 characters or nested deeper than 200.
Expression parse_expression(std::string_view text);

}  // namespace genus
