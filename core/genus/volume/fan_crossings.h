#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/volume/grid.h"

namespace genus {

/// The faces of a row of cells along x: up to `end`, from where those of the row before end. `j`
/// and `k` count as in the frame of the grid.
struct RowFaces {
    std::int64_t j, k;
    std::size_t end;
};

/// Pairs of a face of `doubtful` and another that meet elsewhere than in common corners or a common
/// side, and faces of `doubtful` on one line, named twice. Faces that are not in doubt lie in one
/// cell each, or in two neighbours: those in the cells that doubtful ones reach are looked at.
/// `rows` in the order of the faces. Ascending.
///
/// Exact, see triangle_contact. O(rows and faces of rows with such cells), plus the search among
/// those in such cells.
std::vector<std::pair<std::int32_t, std::int32_t>> fan_crossings(
    const IndexedMesh& mesh, const std::vector<RowFaces>& rows,
    const std::vector<std::int32_t>& doubtful, const GridFrame& frame);

}  // namespace genus
