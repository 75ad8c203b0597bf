#pragma once

#include <vector>

#include "genus/boolean/arrangement.h"

namespace genus::exact {

/// Of the places where faces of two operands in `united` (by operand) cross, about what share lies
/// in no third of them: what is left where they are united. 0 if none was found.
///
/// From a few hundred faces in even steps and in floating point: good enough to choose a way, and
/// nothing of the result depends on it. `tree` holds all faces of the soup.
double surviving_share(const Soup& soup, const PlateTree& tree, const std::vector<char>& united);

}  // namespace genus::exact
