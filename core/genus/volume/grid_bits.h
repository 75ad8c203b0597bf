#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "genus/volume/grid.h"

namespace genus {

/// 64 samples along x, bit i set where the i-th is inside.
using SampleWord = std::uint64_t;
constexpr std::int32_t kWordSamples = 64;

/// Which samples of a grid are inside, one bit each, all of them stored: row j + size[1] * k of
/// samples along x as words. What CrossedCells asks of either kind of bits is below.
class DenseBits {
public:
    explicit DenseBits(const GridSize& size)
        : size_(size),
          n_words_((static_cast<std::size_t>(size[0]) + kWordSamples - 1) / kWordSamples),
          words_(n_rows() * n_words_, 0)
    {
    }

    const GridSize& size() const { return size_; }
    std::size_t n_rows() const { return static_cast<std::size_t>(size_[1]) * size_[2]; }
    std::size_t n_words() const { return n_words_; }

    /// To be filled in.
    SampleWord* words_of(std::size_t row) { return words_.data() + row * n_words_; }

    /// The words of a row, by number.
    const SampleWord* row(std::size_t row) const { return words_.data() + row * n_words_; }

    // Rows that may have crossed edges or cells stand in slots, in the order of the rows.

    std::size_t n_slots() const { return n_rows(); }
    std::size_t row_of(std::size_t slot) const { return slot; }
    std::ptrdiff_t slot_of(std::size_t row) const { return static_cast<std::ptrdiff_t>(row); }

    /// Calls visit(first, last) for runs of words from which crossed edges or cells may start.
    template <typename Visit>
    void visit_runs(std::size_t, const Visit& visit) const
    {
        visit(std::size_t{0}, n_words_);
    }

private:
    GridSize size_;
    std::size_t n_words_;
    std::vector<SampleWord> words_;
};

/// The same in tiles of 64 x 16 x 16 samples: of a tile that is inside or outside throughout only
/// that is stored, in four bytes. Memory: 2 KiB for each other tile, some 10 KiB for each line of
/// tiles along x that the surface passes.
class TiledBits {
public:
    static constexpr std::int32_t kSide = 16;  // along y and z
    static constexpr std::size_t kTileWords = std::size_t{kSide} * kSide;
    using Tile = std::array<SampleWord, kTileWords>;  // word j % 16 + 16 (k % 16)

    /// All outside.
    explicit TiledBits(const GridSize& size);

    const GridSize& size() const { return size_; }
    std::size_t n_rows() const { return static_cast<std::size_t>(size_[1]) * size_[2]; }
    std::size_t n_words() const { return static_cast<std::size_t>(n_tiles_[0]); }
    /// Numbers of tiles along x, y, z, and the number of one.
    const std::array<std::int32_t, 3>& n_tiles() const { return n_tiles_; }
    std::size_t number(std::int32_t i, std::int32_t j, std::int32_t k) const
    {
        return (static_cast<std::size_t>(k) * n_tiles_[1] + j) * n_tiles_[0] + i;
    }

    void set_inside(std::size_t tile) { states_[tile] = kInside; }
    void store(std::size_t tile, const Tile& words);
    /// The number that the tile was stored as, negative if it was not.
    std::int32_t stored(std::size_t tile) const { return states_[tile]; }
    std::size_t n_stored() const { return words_.size() / kTileWords; }
    /// To be called when all tiles are as they are to be.
    void find_slots();

    class Row {
    public:
        Row(const TiledBits& bits, std::size_t first, std::size_t within)
            : states_(bits.states_.data() + first), words_(bits.words_.data()), within_(within)
        {
        }
        SampleWord operator[](std::size_t w) const
        {
            const std::int32_t state = states_[w];
            if (state >= 0) return words_[static_cast<std::size_t>(state) * kTileWords + within_];
            return state == kInside ? ~SampleWord{0} : 0;
        }

    private:
        const std::int32_t* states_;
        const SampleWord* words_;
        std::size_t within_;
    };
    Row row(std::size_t row) const
    {
        const Place at = place(row);
        return {*this, number(0, at.j / kSide, at.k / kSide),
                static_cast<std::size_t>(at.j % kSide + kSide * (at.k % kSide))};
    }

    std::size_t n_slots() const { return first_slot_.back(); }
    std::size_t row_of(std::size_t slot) const;
    std::ptrdiff_t slot_of(std::size_t row) const;

    template <typename Visit>
    void visit_runs(std::size_t row, const Visit& visit) const
    {
        const Place at = place(row);
        const std::int32_t line = line_[line_number(at.j / kSide, at.k / kSide)];
        if (line < 0) return;
        for (std::size_t n = first_run_[line]; n < first_run_[line + 1]; ++n)
            visit(static_cast<std::size_t>(runs_[n][0]), static_cast<std::size_t>(runs_[n][1]));
    }

private:
    static constexpr std::int32_t kOutside = -1, kInside = -2;

    struct Place {
        std::int32_t j, k;
    };
    Place place(std::size_t row) const
    {
        return {static_cast<std::int32_t>(row % size_[1]),
                static_cast<std::int32_t>(row / size_[1])};
    }
    std::size_t line_number(std::int32_t j, std::int32_t k) const
    {
        return static_cast<std::size_t>(k) * n_tiles_[1] + j;
    }
    bool may_be_crossed(std::int32_t i, std::int32_t j, std::int32_t k) const;
    std::int32_t rows_in(std::int32_t tile, int axis) const
    {
        return std::min(kSide, size_[axis] - tile * kSide);
    }

    GridSize size_;
    std::array<std::int32_t, 3> n_tiles_;
    std::vector<std::int32_t> states_;
    std::vector<SampleWord> words_;
    // Lines of tiles along x with runs of tiles that may be crossed: in order of k, then j.
    std::vector<std::int32_t> line_;  // its number among them, -1 if it is none
    std::vector<std::int32_t> line_j_;
    std::vector<std::size_t> first_run_;
    std::vector<std::array<std::int32_t, 2>> runs_;
    // Of each layer of tiles: its first line and slot, and how many rows the lines have across.
    std::vector<std::size_t> first_line_, first_slot_{0}, width_;
};

}  // namespace genus
