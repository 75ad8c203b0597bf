#pragma once

#include <cstdint>
#include <limits>

#include "genus/implicit/implicit.h"
#include "genus/volume/grid.h"

namespace genus {

/// The samples of a function, evaluated when asked for, with a layer of outside samples all round
/// if padded; the same face as PaddedSamples. Blocks of samples whose interval bound has one sign
/// are marked without evaluating them.
class FieldSamples {
public:
    /// Without `skip` every sample is evaluated; the marks are the same.
    FieldSamples(const Implicit& field, const GridLayout& grid, double level, bool padded,
                 bool skip = true);

    const GridSize& size() const { return size_; }
    int pad() const { return pad_; }
    const GridFrame& frame() const { return grid_.frame; }
    const Implicit& field() const { return field_; }
    double level() const { return level_; }
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
        return field_.value(point(i, j, k)) - level_;
    }

    /// Sets the bits of the samples below the level, as CrossedCells wants them. In parallel;
    /// returns the number of samples that an interval bound decided.
    std::int64_t mark_inside(std::uint64_t* bits, std::size_t words) const;

private:
    struct Block {
        std::array<std::int32_t, 3> low, high;  // samples low .. high - 1
        std::int64_t n_samples() const;
    };
    bool within(std::int32_t n, int axis) const { return n >= pad_ && n < grid_.size[axis] + pad_; }
    std::int64_t mark_block(const Block& block, std::uint64_t* bits, std::size_t words) const;

    const Implicit& field_;
    GridLayout grid_;
    GridSize size_{};
    double level_;
    std::int32_t pad_;
    bool skip_;
};

}  // namespace genus
