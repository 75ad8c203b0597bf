#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/volume/grid.h"

namespace genus {

/// Pairs of faces that meet elsewhere than in common corners or a common side, and faces on one
/// line, named twice: among the faces `doubtful` and those in the cells that these reach. Other
/// faces lie in one cell each. Ascending.
///
/// Exact, as self_intersections. O(faces), plus the search among those in such cells.
std::vector<std::pair<std::int32_t, std::int32_t>> fan_crossings(
    const IndexedMesh& mesh, const std::vector<std::int32_t>& doubtful, const GridFrame& frame);

}  // namespace genus
