#pragma once

#include <vector>

#include "genus/model/solid.h"

namespace genus {

/// Solids that together are the same as the given one and whose boxes keep a distance of `margin`:
/// the parts of a union, those with boxes nearer to each other in one. In the order of their first
/// parts; polyhedral ones, for which the exact boolean does the same within itself, are one solid
/// at the end. One solid, the given one, if it is no union or all hangs together.
///
/// O(n log n + pairs of boxes near each other).
std::vector<Solid> parts_apart(const Solid& solid, double margin);

}  // namespace genus
