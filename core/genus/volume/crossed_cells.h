#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/volume/grid_bits.h"

namespace genus {

/// Bit i of `cube` is set if corner i of the cell is inside; `vertex[e]` numbers the vertex on cube
/// edge e where it is crossed.
struct CrossedCell {
    std::int32_t i, j, k;
    std::uint8_t cube;
    std::array<std::int32_t, 12> vertex;
};

/// The cells of a grid that the surface passes, found by one bit a sample, 64 at a time, and the
/// number of the vertex on every crossed grid edge. A grid edge belongs to the row (along x) of
/// its smaller end; vertices are numbered row by row, in a row first those on its edges along x,
/// then y, then z, then room for vertices inside cells. Rows are named by their slots in `Bits`,
/// DenseBits or TiledBits; the numbers are the same for both. Time and memory: O(slots).
template <typename Bits>
class CrossedCells {
public:
    using Cell = CrossedCell;
    struct RowCounts {
        std::int32_t inner_vertices = 0;
        std::int32_t triangles = 0;
    };

    /// A reference to the bits is kept.
    explicit CrossedCells(const Bits& bits) : bits_(bits), size_(bits.size()) {}

    std::size_t n_slots() const { return bits_.n_slots(); }

    /// Numbers vertices and triangles after `count(cell)`, which gives the RowCounts of one cell.
    template <typename Count>
    void number(const Count& count)
    {
        std::vector<RowCounts> counts(n_slots());
        parallel_for(n_slots(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t slot = begin; slot < end; ++slot) {
                visit_row<false>(slot, [&](const Cell& cell) {
                    const RowCounts more = count(cell);
                    counts[slot].inner_vertices += more.inner_vertices;
                    counts[slot].triangles += more.triangles;
                });
            }
        });
        add_up(counts);
    }
    /// Numbers the vertices on edges alone.
    void number() { add_up(std::vector<RowCounts>(n_slots())); }

    std::int64_t n_vertices() const { return first_vertex_.back()[0]; }
    std::int64_t n_triangles() const { return first_triangle_.back(); }
    std::int64_t first_triangle(std::size_t slot) const { return first_triangle_[slot]; }
    std::int64_t first_inner_vertex(std::size_t slot) const { return first_vertex_[slot][3]; }

    /// Calls `visit(cell)` for the crossed cells of a row, i ascending. Without `Numbered` the
    /// vertices are not filled in.
    template <bool Numbered, typename Visit>
    void visit_row(std::size_t slot, const Visit& visit) const;

    /// Calls `visit(number, axis, i, j, k)` for the crossed edges of a row.
    template <typename Visit>
    void visit_edges(std::size_t slot, const Visit& visit) const;

private:
    using Word = SampleWord;
    static constexpr int kAxes = 3;

    void add_up(const std::vector<RowCounts>& counts);
    /// Fills in the vertices of a cell and moves on behind it.
    static void number_edges(Cell& cell, std::array<std::int64_t, 8>& next);
    /// The vertex on the first crossed edge along an axis; anything if the row has none.
    std::int64_t first_on(std::size_t row, int axis) const
    {
        const std::ptrdiff_t slot = bits_.slot_of(row);
        return slot < 0 ? 0 : first_vertex_[static_cast<std::size_t>(slot)][axis];
    }

    template <typename Row>
    Word shifted(const Row& row, std::size_t w) const
    {
        return row[w] >> 1 | (w + 1 < bits_.n_words() ? row[w + 1] << 63 : 0);
    }
    /// Samples of word w that have a right neighbour.
    Word with_neighbour(std::size_t w) const
    {
        const std::int64_t left = size_[0] - 1 - static_cast<std::int64_t>(64 * w);
        return left >= 64 ? ~Word{0} : left <= 0 ? 0 : (Word{1} << left) - 1;
    }
    bool has_next(std::size_t row, int axis) const
    {
        return axis == 1 ? static_cast<std::int32_t>(row % size_[1]) + 1 < size_[1]
                         : static_cast<std::int32_t>(row / size_[1]) + 1 < size_[2];
    }
    std::size_t next_row(std::size_t row, int axis) const
    {
        return axis == 1 ? row + 1 : row + size_[1];
    }
    /// Calls visit(w, edges) for the crossed edges along `axis`, a bit each.
    template <typename Visit>
    void visit_crossed(std::size_t row, int axis, const Visit& visit) const
    {
        if (axis > 0 && !has_next(row, axis)) return;
        const auto own = bits_.row(row), next = axis > 0 ? bits_.row(next_row(row, axis)) : own;
        bits_.visit_runs(row, [&](std::size_t first, std::size_t last) {
            for (std::size_t w = first; w < last; ++w) {
                const Word edges =
                    axis > 0 ? own[w] ^ next[w] : (own[w] ^ shifted(own, w)) & with_neighbour(w);
                if (edges != 0) visit(w, edges);
            }
        });
    }

    const Bits& bits_;
    GridSize size_;
    std::vector<std::array<std::int32_t, 4>> first_vertex_;  // on x, y, z edges, inner; by slot
    std::vector<std::int64_t> first_triangle_;
};

template <typename Bits>
template <bool Numbered, typename Visit>
void CrossedCells<Bits>::visit_row(std::size_t slot, const Visit& visit) const
{
    const std::size_t row = bits_.row_of(slot);
    if (!has_next(row, 1) || !has_next(row, 2)) return;
    const std::array<std::size_t, 4> rows{row, row + 1, row + size_[1], row + size_[1] + 1};
    const std::array bits{bits_.row(rows[0]), bits_.row(rows[1]), bits_.row(rows[2]),
                          bits_.row(rows[3])};
    // The eight edge rows of a line of cells: 0-3 along x, 4, 5 along y, 6, 7 along z. Of each the
    // number of the vertex on its next crossed edge: whatever edge is crossed belongs to a crossed
    // cell at the same i, so that counting there is enough.
    std::array<std::int64_t, 8> next{};
    if (Numbered)
        next = {first_on(rows[0], 0), first_on(rows[1], 0), first_on(rows[2], 0),
                first_on(rows[3], 0), first_on(rows[0], 1), first_on(rows[2], 1),
                first_on(rows[0], 2), first_on(rows[1], 2)};
    Cell cell{};
    cell.j = static_cast<std::int32_t>(row % size_[1]);
    cell.k = static_cast<std::int32_t>(row / size_[1]);
    const std::size_t n_words = bits_.n_words();
    const auto any_of = [&](std::size_t w) {
        return w < n_words ? bits[0][w] | bits[1][w] | bits[2][w] | bits[3][w] : 0;
    };
    const auto all_of = [&](std::size_t w) {
        return w < n_words ? bits[0][w] & bits[1][w] & bits[2][w] & bits[3][w] : 0;
    };
    bits_.visit_runs(row, [&](std::size_t first, std::size_t last) {
        Word any_next = any_of(first), all_next = all_of(first);
        for (std::size_t w = first; w < last; ++w) {
            const Word any = any_next, all = all_next;
            any_next = any_of(w + 1);
            all_next = all_of(w + 1);
            Word active = (any | any >> 1 | any_next << 63) & ~(all & (all >> 1 | all_next << 63)) &
                          with_neighbour(w);
            if (active == 0) continue;
            std::array<Word, 8> corner;
            for (std::size_t r = 0; r < 4; ++r) {
                corner[2 * r] = bits[r][w];
                corner[2 * r + 1] = shifted(bits[r], w);
            }
            for (; active != 0; active &= active - 1) {
                const int bit = std::countr_zero(active);
                cell.i = static_cast<std::int32_t>(64 * w) + bit;
                unsigned cube = 0;
                for (unsigned c = 0; c < 8; ++c)
                    cube |= static_cast<unsigned>(corner[c] >> bit & 1) << c;
                cell.cube = static_cast<std::uint8_t>(cube);
                if (Numbered) number_edges(cell, next);
                visit(static_cast<const Cell&>(cell));
            }
        }
    });
}

template <typename Bits>
void CrossedCells<Bits>::number_edges(Cell& cell, std::array<std::int64_t, 8>& next)
{
    const unsigned cube = cell.cube;
    const unsigned along_x = cube ^ cube >> 1, along_y = cube ^ cube >> 2,
                   along_z = cube ^ cube >> 4;
    for (unsigned e = 0; e < 4; ++e) {
        cell.vertex[e] = static_cast<std::int32_t>(next[e]);
        next[e] += along_x >> 2 * e & 1;
    }
    // Along y and z a cell has the edges at i and at i + 1 of each edge row.
    const std::array<unsigned, 4> at_i{along_y & 1, along_y >> 4 & 1, along_z & 1,
                                       along_z >> 2 & 1};
    for (unsigned r = 0; r < 4; ++r) {
        cell.vertex[2 * r + 4] = static_cast<std::int32_t>(next[r + 4]);
        next[r + 4] += at_i[r];
        cell.vertex[2 * r + 5] = static_cast<std::int32_t>(next[r + 4]);
    }
}

template <typename Bits>
template <typename Visit>
void CrossedCells<Bits>::visit_edges(std::size_t slot, const Visit& visit) const
{
    if (first_vertex_[slot][0] == first_vertex_[slot][3]) return;
    const std::size_t row = bits_.row_of(slot);
    const auto j = static_cast<std::int32_t>(row % size_[1]);
    const auto k = static_cast<std::int32_t>(row / size_[1]);
    for (int axis = 0; axis < kAxes; ++axis) {
        std::int64_t number = first_vertex_[slot][axis];
        visit_crossed(row, axis, [&](std::size_t w, Word edges) {
            for (; edges != 0; edges &= edges - 1)
                visit(number++, axis, static_cast<std::int32_t>(64 * w) + std::countr_zero(edges),
                      j, k);
        });
    }
}

template <typename Bits>
void CrossedCells<Bits>::add_up(const std::vector<RowCounts>& counts)
{
    std::vector<std::array<std::int32_t, kAxes>> n_edges(n_slots());
    parallel_for(n_slots(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t slot = begin; slot < end; ++slot)
            for (int axis = 0; axis < kAxes; ++axis)
                visit_crossed(bits_.row_of(slot), axis, [&](std::size_t, Word edges) {
                    n_edges[slot][axis] += std::popcount(edges);
                });
    });
    first_vertex_.assign(n_slots() + 1, {});
    first_triangle_.assign(n_slots() + 1, 0);
    std::int64_t vertex = 0, triangle = 0;
    for (std::size_t slot = 0; slot < n_slots(); ++slot) {
        for (int axis = 0; axis < kAxes; ++axis) {
            first_vertex_[slot][axis] = static_cast<std::int32_t>(vertex);
            vertex += n_edges[slot][axis];
        }
        first_vertex_[slot][3] = static_cast<std::int32_t>(vertex);
        vertex += counts[slot].inner_vertices;
        first_triangle_[slot] = triangle;
        triangle += counts[slot].triangles;
        require(vertex <= std::numeric_limits<std::int32_t>::max(),
                "marching cubes: the surface has more than 2^31 vertices; take larger cells");
    }
    first_vertex_.back()[0] = static_cast<std::int32_t>(vertex);
    first_triangle_.back() = triangle;
}

}  // namespace genus
