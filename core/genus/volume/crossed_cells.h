#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "genus/base/parallel.h"
#include "genus/volume/grid.h"

namespace genus {

/// The cells of a grid that the surface passes, found by one bit a sample, 64 at a time, and the
/// number of the vertex on every crossed grid edge. A grid edge belongs to the row (along x) of
/// its smaller end; vertices are numbered row by row, in a row first those on its edges along x,
/// then y, then z, then room for vertices inside cells.
class CrossedCells {
public:
    /// Bit i of `cube` is set if corner i of the cell is inside; `vertex[e]` numbers the vertex on
    /// cube edge e where it is crossed.
    struct Cell {
        std::int32_t i, j, k;
        std::uint8_t cube;
        std::array<std::int32_t, 12> vertex;
    };
    struct RowCounts {
        std::int32_t inner_vertices = 0;
        std::int32_t triangles = 0;
    };

    /// `fill(bits, words)` sets the bit of every inside sample: bit i % 64 of word i / 64 of the
    /// row j + size[1] * k, a row having `words` words. They come in as zeros.
    template <typename Fill>
    CrossedCells(const GridSize& size, const Fill& fill)
        : size_(size), n_words_((static_cast<std::size_t>(size[0]) + 63) / 64)
    {
        bits_.assign(n_rows() * n_words_, 0);
        fill(bits_.data(), n_words_);
    }

    std::size_t n_rows() const { return static_cast<std::size_t>(size_[1]) * size_[2]; }

    /// Numbers vertices and triangles after `count(cell)`, which gives the RowCounts of one cell.
    template <typename Count>
    void number(const Count& count)
    {
        std::vector<RowCounts> counts(n_rows());
        parallel_for(n_rows(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                visit_row<false>(row, [&](const Cell& cell) {
                    const RowCounts more = count(cell);
                    counts[row].inner_vertices += more.inner_vertices;
                    counts[row].triangles += more.triangles;
                });
            }
        });
        add_up(counts);
    }

    std::int64_t n_vertices() const { return first_vertex_.back()[0]; }
    std::int64_t n_triangles() const { return first_triangle_.back(); }
    std::int64_t first_triangle(std::size_t row) const { return first_triangle_[row]; }
    std::int64_t first_inner_vertex(std::size_t row) const { return first_vertex_[row][3]; }

    /// Calls `visit(cell)` for the crossed cells of a row, i ascending. Without `Numbered` the
    /// vertices are not filled in.
    template <bool Numbered, typename Visit>
    void visit_row(std::size_t row, const Visit& visit) const;

    /// Calls `visit(number, axis, i, j, k)` for the crossed edges of a row.
    template <typename Visit>
    void visit_edges(std::size_t row, const Visit& visit) const;

private:
    using Word = std::uint64_t;
    static constexpr int kAxes = 3;

    void add_up(const std::vector<RowCounts>& counts);
    /// Fills in the vertices of a cell and moves on behind it.
    static void number_edges(Cell& cell, std::array<std::int64_t, 8>& next);

    const Word* row_bits(std::size_t row) const { return bits_.data() + row * n_words_; }
    Word shifted(const Word* bits, std::size_t w) const
    {
        return bits[w] >> 1 | (w + 1 < n_words_ ? bits[w + 1] << 63 : 0);
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
    /// Crossed edges along `axis` of word w; the row must have a next one along y or z.
    Word crossed(std::size_t row, int axis, std::size_t w) const
    {
        const Word* bits = row_bits(row);
        if (axis == 0) return (bits[w] ^ shifted(bits, w)) & with_neighbour(w);
        return bits[w] ^ row_bits(next_row(row, axis))[w];
    }

    GridSize size_;
    std::size_t n_words_ = 0;
    std::vector<Word> bits_;
    std::vector<std::array<std::int64_t, 4>> first_vertex_;  // on x, y, z edges, inner; by row
    std::vector<std::int64_t> first_triangle_;
};

template <bool Numbered, typename Visit>
void CrossedCells::visit_row(std::size_t row, const Visit& visit) const
{
    if (!has_next(row, 1) || !has_next(row, 2)) return;
    const std::array<std::size_t, 4> rows{row, row + 1, row + size_[1], row + size_[1] + 1};
    const std::array<const Word*, 4> bits{row_bits(rows[0]), row_bits(rows[1]), row_bits(rows[2]),
                                          row_bits(rows[3])};
    // The eight edge rows of a line of cells: 0-3 along x, 4, 5 along y, 6, 7 along z. Of each the
    // number of the vertex on its next crossed edge: whatever edge is crossed belongs to a crossed
    // cell at the same i, so that counting there is enough.
    std::array<std::int64_t, 8> next{};
    if (Numbered)
        next = {first_vertex_[rows[0]][0], first_vertex_[rows[1]][0], first_vertex_[rows[2]][0],
                first_vertex_[rows[3]][0], first_vertex_[rows[0]][1], first_vertex_[rows[2]][1],
                first_vertex_[rows[0]][2], first_vertex_[rows[1]][2]};
    Cell cell{};
    cell.j = static_cast<std::int32_t>(row % size_[1]);
    cell.k = static_cast<std::int32_t>(row / size_[1]);
    const auto any_of = [&](std::size_t w) {
        return w < n_words_ ? bits[0][w] | bits[1][w] | bits[2][w] | bits[3][w] : 0;
    };
    const auto all_of = [&](std::size_t w) {
        return w < n_words_ ? bits[0][w] & bits[1][w] & bits[2][w] & bits[3][w] : 0;
    };
    Word any_next = any_of(0), all_next = all_of(0);
    for (std::size_t w = 0; w < n_words_; ++w) {
        const Word any = any_next, all = all_next;
        any_next = any_of(w + 1);
        all_next = all_of(w + 1);
        Word active = (any | any >> 1 | any_next << 63) & ~(all & (all >> 1 | all_next << 63)) &
                      with_neighbour(w);
        if (active == 0) continue;
        std::array<Word, 8> corner;
        for (int r = 0; r < 4; ++r) {
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
}

inline void CrossedCells::number_edges(Cell& cell, std::array<std::int64_t, 8>& next)
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

template <typename Visit>
void CrossedCells::visit_edges(std::size_t row, const Visit& visit) const
{
    if (first_vertex_[row][0] == first_vertex_[row][3]) return;
    const auto j = static_cast<std::int32_t>(row % size_[1]);
    const auto k = static_cast<std::int32_t>(row / size_[1]);
    for (int axis = 0; axis < kAxes; ++axis) {
        if (axis > 0 && !has_next(row, axis)) continue;
        std::int64_t number = first_vertex_[row][axis];
        for (std::size_t w = 0; w < n_words_; ++w)
            for (Word edges = crossed(row, axis, w); edges != 0; edges &= edges - 1)
                visit(number++, axis, static_cast<std::int32_t>(64 * w) + std::countr_zero(edges),
                      j, k);
    }
}

}  // namespace genus
