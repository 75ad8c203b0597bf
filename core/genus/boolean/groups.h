#pragma once

#include <optional>

#include "genus/boolean/solve.h"

namespace genus::exact {

/// As `solve_whole`; long unions, and long lists of things taken away, are united first in groups
/// of neighbours: what lies inside a group is gone before groups meet, so that the work grows with
/// the surface and not with the square of the overlaps. All groups use the grid of their cluster,
/// and what a group gives needs no look at itself again. See MeshBooleanOptions::largest_union.
std::optional<Solved> solve_in_groups(const Soup& soup, const Frame& frame, BooleanFormula formula,
                                      std::int32_t n_operands, const MeshBooleanOptions& options,
                                      MeshBooleanReport& report, Vec3& place);

}  // namespace genus::exact
