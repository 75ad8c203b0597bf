#include "genus/volume/crossed_cells.h"

#include <limits>

#include "genus/base/error.h"

namespace genus {

void CrossedCells::add_up(const std::vector<RowCounts>& counts)
{
    std::vector<std::array<std::int32_t, kAxes>> n_edges(n_rows());
    parallel_for(n_rows(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
            for (int axis = 0; axis < kAxes; ++axis) {
                if (axis > 0 && !has_next(row, axis)) continue;
                for (std::size_t w = 0; w < n_words_; ++w)
                    if (const Word edges = crossed(row, axis, w))
                        n_edges[row][axis] += std::popcount(edges);
            }
    });
    first_vertex_.assign(n_rows() + 1, {});
    first_triangle_.assign(n_rows() + 1, 0);
    std::int64_t vertex = 0, triangle = 0;
    for (std::size_t row = 0; row < n_rows(); ++row) {
        for (int axis = 0; axis < kAxes; ++axis) {
            first_vertex_[row][axis] = vertex;
            vertex += n_edges[row][axis];
        }
        first_vertex_[row][3] = vertex;
        vertex += counts[row].inner_vertices;
        first_triangle_[row] = triangle;
        triangle += counts[row].triangles;
    }
    first_vertex_.back()[0] = vertex;
    first_triangle_.back() = triangle;
    require(vertex <= std::numeric_limits<std::int32_t>::max(),
            "marching cubes: the surface has more than 2^31 vertices; take larger cells");
}

}  // namespace genus
