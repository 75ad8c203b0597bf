#pragma once

#include <cstdint>

#include "genus/boolean/soup.h"

namespace genus::exact {

/// True only if the faces `begin` to `end` of a soup are joined across all their edges, the middle
/// of their corners sees all of them from one side, and one ray from there meets one of them. Then
/// every ray does, for the faces on a ray, all of one sign, count its winding number: faces meet in
/// common corners and edges only. Exact. O(faces), and sooner where it is false.
bool is_star_shaped(const Soup& soup, std::int32_t begin, std::int32_t end);

}  // namespace genus::exact
