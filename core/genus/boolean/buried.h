#pragma once

#include <cstdint>
#include <vector>

#include "genus/boolean/arrangement.h"
#include "genus/boolean/formula.h"

namespace genus::exact {

/// Faces that cannot bound the set: they lie strictly inside an operand within which the formula
/// has one value whatever the others are, as in a union, or strictly outside of one outside of
/// which it has. Such faces need not be cut, and nothing need be cut by them.
///
/// A face that meets no face of an operand lies on one side of it, and so do its neighbours that
/// meet none: one exact ray a connected piece tells which. Empty if fewer than half of the
/// candidate pairs would be saved. Time grows with the faces in the boxes of the operands.
std::vector<char> find_buried(const Soup& soup, const Candidates& candidates,
                              const BooleanFormula& formula, std::int32_t n_operands);

}  // namespace genus::exact
