#pragma once

#include <vector>

#include "genus/model/solid.h"

namespace genus {

/// Solids that together are the same as the given one and whose boxes keep a distance of `margin`:
/// the parts of a union, those with boxes nearer to each other in one, or of a union intersected
/// with something, each intersected with that. In the order of their first parts; polyhedral ones,
/// for which the exact boolean does the same within itself, are one solid at the end. The given
/// solid alone, which must be bounded, if it is no such thing or all of it hangs together.
///
/// O(n log n + pairs of boxes near each other).
std::vector<Solid> parts_apart(const Solid& solid, double margin);

}  // namespace genus
