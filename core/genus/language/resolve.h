#pragma once

#include "genus/language/syntax.h"

namespace genus::language {

/// Fills in what the tree marks as resolved: slots of variables, targets of calls, frames; and
/// folds constant lists and ranges. A variable is found by its place in the text, as far as it is
/// set when it is read; else what lies outside of its scope is read.
///
/// Linear in the program but for the depth of scopes. Throws StackExhausted.
void resolve(Program& program);

}  // namespace genus::language
