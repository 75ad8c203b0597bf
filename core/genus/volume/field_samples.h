#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "genus/implicit/implicit.h"
#include "genus/volume/grid.h"
#include "genus/volume/grid_bits.h"

namespace genus {

/// The samples of a function, evaluated when asked for, with a layer of outside samples all round
/// if padded; the same face as PaddedSamples.
///
/// Boxes are halved until an interval bound decides all their samples or they are a tile of
/// TiledBits; in each the function is cut down to what matters there. Time and memory grow with the
/// tiles that the surface passes, but for four bytes of each tile.
class FieldSamples {
public:
    /// Marks the samples below the level. Without `skip` every one is evaluated; the marks are the
    /// same. In parallel. A reference to the field is kept.
    FieldSamples(const Implicit& field, const GridLayout& grid, double level, bool padded,
                 bool skip = true);

    const GridSize& size() const { return size_; }
    int pad() const { return pad_; }
    const GridFrame& frame() const { return grid_.frame; }
    const Implicit& field() const { return field_; }
    double level() const { return level_; }
    /// Which samples are below the level.
    const TiledBits& bits() const { return bits_; }
    /// How many samples interval bounds decided.
    std::int64_t decided() const { return decided_; }
    /// The function at a sample and up to one step from it along the axes.
    const Implicit& field_at(std::int32_t i, std::int32_t j, std::int32_t k) const;

    /// True samples, without the layer.
    std::int64_t n_samples() const
    {
        return std::int64_t{grid_.size[0]} * grid_.size[1] * grid_.size[2];
    }

    Vec3 point(std::int32_t i, std::int32_t j, std::int32_t k) const
    {
        return grid_.frame.point(i - pad_, j - pad_, k - pad_);
    }
    bool is_true(std::int32_t i, std::int32_t j, std::int32_t k) const
    {
        return within(i, 0) && within(j, 1) && within(k, 2);
    }
    double relative(std::int32_t i, std::int32_t j, std::int32_t k) const
    {
        if (!is_true(i, j, k)) return std::numeric_limits<double>::infinity();
        return field_at(i, j, k).value(point(i, j, k)) - level_;
    }

private:
    using Index = std::array<std::int32_t, 3>;
    // Samples low .. high - 1.
    struct Block {
        Index low, high;
        std::int64_t n_samples() const;
    };
    // Tiles low .. high - 1, and the function as it is there.
    struct Node {
        Index low, high;
        std::shared_ptr<const Implicit> field;  // null: the whole
    };
    struct Outcome;

    bool within(std::int32_t n, int axis) const { return n >= pad_ && n < grid_.size[axis] + pad_; }
    const Implicit& field_of(const Node& node) const { return node.field ? *node.field : field_; }
    Block true_samples(const Node& node) const;
    Box3 box_of(const Block& block, std::int32_t beyond) const;
    void mark();
    void look(Node& node, Outcome& out) const;
    std::int64_t mark_block(const Implicit& field, const Block& block,
                            TiledBits::Tile& words) const;
    std::int64_t mark_halves(const Implicit& field, const Block& block,
                             TiledBits::Tile& words) const;

    const Implicit& field_;
    GridLayout grid_;
    GridSize size_;
    double level_;
    std::int32_t pad_;
    bool skip_;
    TiledBits bits_;
    std::vector<std::shared_ptr<const Implicit>> fields_;  // of stored tiles
    std::int64_t decided_ = 0;
};

}  // namespace genus
