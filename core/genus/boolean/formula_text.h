#pragma once

#include <span>
#include <string>
#include <string_view>

#include "genus/boolean/formula.h"

namespace genus {

/// The formula that a text describes: "a - (b | c)". Operators by binding, tightest first, as
/// Python has them: ~x (all that is not in x); x + y (union), x - y; x & y; x ^ y (in one of the
/// two); x | y (union). Operands are words of letters, digits and underscores: one of `names`, or
/// else the number of an operand, from 0.
///
/// Unions and differences in a row become one instruction. Throws InvalidInput with the place for
/// what is no formula, for unknown operands, and for more than 200 levels of parentheses and ~.
/// O(length).
BooleanFormula parse_formula(std::string_view text, std::span<const std::string> names,
                             std::int32_t n_operands);

}  // namespace genus
