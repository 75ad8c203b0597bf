#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "genus/base/parallel.h"
#include "genus/volume/grid.h"
#include "genus/volume/grid_bits.h"

namespace genus {

/// Bit i is set if values[i] < threshold; n is at most 64. The two are compared several values at
/// a time where the machine can.
std::uint64_t below(const float* values, std::int32_t n, float threshold);
std::uint64_t below(const double* values, std::int32_t n, double threshold);

/// The size with a layer all round, if padded.
inline GridSize padded_size(GridSize size, bool padded)
{
    for (std::int32_t& n : size) n += padded ? 2 : 0;
    return size;
}

/// A view of samples with, if asked for, a layer of outside samples all round. Indices count the
/// layer: with it, sample (1, 1, 1) is the first true one.
template <typename Value>
class PaddedSamples {
public:
    PaddedSamples(std::span<const Value> values, const GridSize& size, double level, bool padded)
        : values_(values),
          true_size_(size),
          size_(padded_size(size, padded)),
          level_(level),
          pad_(padded ? 1 : 0),
          bits_(size_)
    {
        parallel_for(bits_.n_rows(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) mark_row(row, bits_.words_of(row));
        });
    }

    const GridSize& size() const { return size_; }
    int pad() const { return pad_; }

    bool is_true(std::int32_t i, std::int32_t j, std::int32_t k) const
    {
        return within(i, 0) && within(j, 1) && within(k, 2);
    }
    /// Value less the level; infinity in the layer.
    double relative(std::int32_t i, std::int32_t j, std::int32_t k) const
    {
        if (!is_true(i, j, k)) return std::numeric_limits<double>::infinity();
        return static_cast<double>(line(j, k)[i - pad_]) - level_;
    }

    /// Which samples are below the level.
    const DenseBits& bits() const { return bits_; }

private:
    void mark_row(std::size_t row, std::uint64_t* bits) const
    {
        const auto j = static_cast<std::int32_t>(row % size_[1]);
        const auto k = static_cast<std::int32_t>(row / size_[1]);
        if (!within(j, 1) || !within(k, 2)) return;
        const Value* value = line(j, k);
        const Value threshold = first_outside();
        std::int32_t n = std::min(64 - pad_, true_size_[0]);
        bits[0] = below(value, n, threshold) << pad_;
        for (std::int32_t i = n, word = 1; i < true_size_[0]; i += n, ++word) {
            n = std::min(64, true_size_[0] - i);
            bits[word] = below(value + i, n, threshold);
        }
    }
    /// The least value that is not below the level: comparing with it needs no conversion.
    Value first_outside() const
    {
        const auto near = static_cast<Value>(level_);
        return static_cast<double>(near) < level_
                   ? std::nextafter(near, std::numeric_limits<Value>::infinity())
                   : near;
    }

    bool within(std::int32_t n, int axis) const { return n >= pad_ && n < true_size_[axis] + pad_; }
    const Value* line(std::int32_t j, std::int32_t k) const
    {
        return values_.data() +
               (static_cast<std::size_t>(k - pad_) * true_size_[1] + (j - pad_)) * true_size_[0];
    }

    std::span<const Value> values_;
    GridSize true_size_, size_;
    double level_;
    std::int32_t pad_;
    DenseBits bits_;
};

}  // namespace genus
