#pragma once

#include <cstdint>
#include <vector>

#include "genus/boolean/arrangement.h"

namespace genus::exact {

/// Numbers for the faces of a soup such that two faces of one number neither cross nor touch but
/// in common corners and edges; -1 for faces that are compared with all others. An operand that
/// promises not to cross itself, or is star-shaped, has its own number for all its faces. Others
/// are divided into charts: connected pieces whose faces all look the same way along a coordinate
/// axis and whose border, seen along it, does not cross itself and has one outer loop. Such a piece
/// covers no point of the view twice, for the number of its faces over a point is the sum of the
/// winding numbers of its loops. Exact. O(faces) and a search among the edges of borders.
///
/// Implements the criterion of [volino1994], decided exactly.
std::vector<std::int32_t> find_owners(const Soup& soup);

}  // namespace genus::exact
