#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "genus/boolean/arrangement.h"
#include "genus/boolean/formula.h"

namespace genus::exact {

/// Which winding numbers of an operand count as inside.
enum class InsideRule { NonZero, Positive };

/// What of an arrangement bounds the set that a formula describes: 1 for a cell that is kept as it
/// is, -1 for one that is kept turned over, 0 for one left out. The same for passive faces.
struct Selection {
    std::vector<std::int8_t> cells;
    std::vector<std::int8_t> faces;   // of the soup; 0 where not passive
    std::vector<std::int8_t> tracts;  // of a zone
};

/// Follows the regions of space from cell to cell: round every edge the cells are sorted by exact
/// angle, so that neighbours share the region between them; crossing a cell changes the winding
/// numbers by what covers it. One exact ray a connected piece of surface gives the start. The
/// formula is evaluated once a region.
///
/// Implements [zhou2016], sections 3 and 4, with regions told apart by union of cell sides.
///
/// With buried faces winding numbers are not followed: each region is looked into from one place.
/// Empty then if some region is too thin for that; never without buried faces.
std::optional<Selection> select(const Soup& soup, const Arrangement& arrangement,
                                const BooleanFormula& formula, std::int32_t n_operands,
                                InsideRule rule);

}  // namespace genus::exact
