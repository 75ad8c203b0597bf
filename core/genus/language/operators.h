#pragma once

#include <string>

#include "genus/language/syntax.h"
#include "genus/language/value.h"

namespace genus::language {

/// The operators on any two values, as the text language has them: element by element on vectors
/// for + and -, products of vectors and matrices for *. What is not defined is undef; then
/// `problem` gets the reason, unless that lies inside a vector.
Value apply(BinaryOp op, const Value& a, const Value& b, std::string& problem);
Value negate(const Value& a, std::string& problem);

}  // namespace genus::language
