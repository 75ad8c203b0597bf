#pragma once

#include <optional>

#include "genus/boolean/solve.h"

namespace genus::exact {

/// As `solve_whole`; long unions, and long lists of things taken away, are united first in groups
/// of neighbours: what lies inside a group is gone before groups meet, so that the work grows with
/// the surface and not with the square of the overlaps. All groups use the grid of their cluster,
/// and what a group gives is looked at again only where its parts touch. If a group cannot be
/// written in doubles, all is solved at once, unless too many faces overlap for that. See
/// MeshBooleanOptions::largest_union.
std::optional<Solved> solve_in_groups(const Soup& soup, const Frame& frame,
                                      const BooleanFormula& formula, std::int32_t n_operands,
                                      const MeshBooleanOptions& options, MeshBooleanReport& report,
                                      Vec3& place);

}  // namespace genus::exact
