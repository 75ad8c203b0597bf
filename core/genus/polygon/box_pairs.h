#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "genus/base/box.h"

namespace genus {

/// All pairs i < j of boxes that overlap or touch, sorted. O(n log n + pairs) for boxes that can be
/// told apart by halving space; O(n^2) where they all lie over each other.
std::vector<std::pair<std::int32_t, std::int32_t>> overlapping_pairs(std::span<const Box2> boxes);

}  // namespace genus
