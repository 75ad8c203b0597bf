#pragma once

#include <optional>

#include "genus/model/solid.h"

namespace genus {

/// The solid with its functions written out as polyhedra, where these are unions and intersections
/// of half-spaces, as |x| + |y| <= 1 or mod(x, 1) <= 1/2, and all other leaves are polyhedra: then
/// the exact boolean gives it without error, also where more than two wedges touch along a line.
/// Nothing if there is no function, if another leaf is curved, or if the corners of a plane with a
/// cube that holds the solid are no doubles. O(nodes) and solid_parts of each function.
std::optional<Solid> as_polyhedra(const Solid& solid);

}  // namespace genus
