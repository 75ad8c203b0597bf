#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/volume/grid.h"

namespace genus {

/// Pairs of a face of `doubtful` and another that meet elsewhere than in common corners or a common
/// side, and faces of `doubtful` on one line, named twice. Faces that are not in doubt lie in one
/// cell each: those in the cells that doubtful ones reach are looked at. Ascending.
///
/// Exact, see triangle_contact. O(faces), plus the search among those in such cells.
std::vector<std::pair<std::int32_t, std::int32_t>> fan_crossings(
    const IndexedMesh& mesh, const std::vector<std::int32_t>& doubtful, const GridFrame& frame);

}  // namespace genus
