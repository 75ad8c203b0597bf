#include "genus/volume/field_samples.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <vector>

#include "genus/base/parallel.h"

namespace genus {

namespace {

constexpr std::int32_t kWord = 64;
constexpr std::int32_t kTile = 16;       // rows of a task along y and z
constexpr std::size_t kFewSamples = 48;  // no more are evaluated at once

}  // namespace

FieldSamples::FieldSamples(const Implicit& field, const GridLayout& grid, double level, bool padded,
                           bool skip)
    : field_(field), grid_(grid), level_(level), pad_(padded ? 1 : 0), skip_(skip)
{
    for (int axis = 0; axis < 3; ++axis) size_[axis] = grid.size[axis] + 2 * pad_;
}

std::int64_t FieldSamples::Block::n_samples() const
{
    std::int64_t n = 1;
    for (int axis = 0; axis < 3; ++axis) n *= std::max(0, high[axis] - low[axis]);
    return n;
}

// A task is a word wide, so that no two write to the same one.
std::int64_t FieldSamples::mark_inside(std::uint64_t* bits, std::size_t words) const
{
    const std::size_t across = (size_[1] + kTile - 1) / kTile, up = (size_[2] + kTile - 1) / kTile;
    std::vector<std::int64_t> decided(words * across * up);
    parallel_for(decided.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t task = begin; task < end; ++task) {
            const std::array<std::size_t, 3> tile{task % words, task / words % across,
                                                  task / (words * across)};
            const std::array<std::int32_t, 3> step{kWord, kTile, kTile};
            Block block;
            for (int axis = 0; axis < 3; ++axis) {
                const auto first = static_cast<std::int32_t>(tile[axis]) * step[axis];
                block.low[axis] = std::max(first, pad_);
                block.high[axis] = std::min(first + step[axis], grid_.size[axis] + pad_);
            }
            if (block.n_samples() > 0) decided[task] = mark_block(block, bits, words);
        }
    });
    return std::accumulate(decided.begin(), decided.end(), std::int64_t{0});
}

std::int64_t FieldSamples::mark_block(const Block& block, std::uint64_t* bits,
                                      std::size_t words) const
{
    const auto word_of = [&](std::int32_t j, std::int32_t k) -> std::uint64_t& {
        const std::size_t row = j + static_cast<std::size_t>(size_[1]) * k;
        return bits[row * words + block.low[0] / kWord];
    };
    if (block.n_samples() <= static_cast<std::int64_t>(kFewSamples)) {
        std::array<Vec3, kFewSamples> points;
        std::array<double, kFewSamples> values;
        std::size_t n = 0;
        const auto for_samples = [&](const auto& f) {
            for (std::int32_t k = block.low[2]; k < block.high[2]; ++k)
                for (std::int32_t j = block.low[1]; j < block.high[1]; ++j)
                    for (std::int32_t i = block.low[0]; i < block.high[0]; ++i) f(i, j, k);
        };
        for_samples(
            [&](std::int32_t i, std::int32_t j, std::int32_t k) { points[n++] = point(i, j, k); });
        field_.values(std::span(points).first(n), std::span(values).first(n));
        n = 0;
        for_samples([&](std::int32_t i, std::int32_t j, std::int32_t k) {
            if (values[n++] < level_) word_of(j, k) |= std::uint64_t{1} << (i % kWord);
        });
        return 0;
    }
    const Box3 box{point(block.low[0], block.low[1], block.low[2]),
                   point(block.high[0] - 1, block.high[1] - 1, block.high[2] - 1)};
    const Interval range = skip_ ? field_.bound(box) : Interval::everything();
    if (range.lo >= level_) return block.n_samples();
    if (range.hi < level_) {
        const std::int32_t width = block.high[0] - block.low[0];
        const std::uint64_t ones = width == kWord ? ~std::uint64_t{0}
                                                  : ((std::uint64_t{1} << width) - 1)
                                                        << (block.low[0] % kWord);
        for (std::int32_t k = block.low[2]; k < block.high[2]; ++k)
            for (std::int32_t j = block.low[1]; j < block.high[1]; ++j) word_of(j, k) |= ones;
        return block.n_samples();
    }
    int axis = 0;
    for (int a = 1; a < 3; ++a)
        if (block.high[a] - block.low[a] > block.high[axis] - block.low[axis]) axis = a;
    Block first = block, second = block;
    first.high[axis] = second.low[axis] = (block.low[axis] + block.high[axis]) / 2;
    return mark_block(first, bits, words) + mark_block(second, bits, words);
}

}  // namespace genus
