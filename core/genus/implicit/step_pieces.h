#pragma once

#include <optional>
#include <vector>

#include "genus/implicit/equal_parts.h"
#include "genus/implicit/jump_parts.h"

namespace genus {

/// A floor, ceil, round or sign of an expression in which equal parts are one, with none inside, of
/// more than one value in the box; null if there is none. O(nodes) for each.
const Expression::Node* innermost_step(const Expression& expression, const Box3& box);

/// The pieces of space in which that step has one value: see jump_pieces.
std::optional<std::vector<JumpPiece>> pieces_by_level(const Expression& expression,
                                                      const Expression::Node& step, const Box3& box,
                                                      std::size_t most, Rewriter& rewriter);

}  // namespace genus
