#pragma once

#include <optional>
#include <vector>

#include "genus/implicit/jump_parts.h"

namespace genus {

/// The pieces of space in which all denominators of an expression have one sign, brought to one
/// fraction: see jump_pieces. Equal parts of the expression are one.
std::optional<std::vector<JumpPiece>> pieces_by_sign(const Expression& expression, const Box3& box,
                                                     std::size_t most);

}  // namespace genus
