#pragma once

#include <optional>

#include "genus/model/solid.h"

namespace genus::language {

/// The smallest box that holds the solid, where the tree shows it: for boxes, polyhedra, round
/// shapes along the axes, unions of such, and their images under maps that keep the axes. Nothing
/// for others. O(nodes + corners).
std::optional<Box3> tight_bounds(const Solid& solid);

}  // namespace genus::language
