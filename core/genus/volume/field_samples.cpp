#include "genus/volume/field_samples.h"

#include <algorithm>
#include <span>
#include <utility>

#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/volume/padded_samples.h"

namespace genus {

namespace {

constexpr std::size_t kFewSamples = 48;  // no more are evaluated at once
constexpr std::array<std::int32_t, 3> kTile{kWordSamples, TiledBits::kSide, TiledBits::kSide};

int longest_axis(const std::array<std::int32_t, 3>& length)
{
    return static_cast<int>(std::max_element(length.begin(), length.end()) - length.begin());
}

}  // namespace

// What became of a node.
struct FieldSamples::Outcome {
    enum class Kind { Outside, Inside, Divided, Stored } kind = Kind::Outside;
    std::int64_t decided = 0;
    TiledBits::Tile words{};  // of a stored tile
};

FieldSamples::FieldSamples(const Implicit& field, const GridLayout& grid, double level, bool padded,
                           bool skip)
    : field_(field),
      grid_(grid),
      size_(padded_size(grid.size, padded)),
      level_(level),
      pad_(padded ? 1 : 0),
      skip_(skip),
      bits_(size_)
{
    mark();
    bits_.find_slots();
}

const Implicit& FieldSamples::field_at(std::int32_t i, std::int32_t j, std::int32_t k) const
{
    const std::int32_t tile = bits_.stored(bits_.number(i / kTile[0], j / kTile[1], k / kTile[2]));
    if (tile < 0 || !fields_[static_cast<std::size_t>(tile)]) return field_;
    return *fields_[static_cast<std::size_t>(tile)];
}

std::int64_t FieldSamples::Block::n_samples() const
{
    std::int64_t n = 1;
    for (int axis = 0; axis < 3; ++axis) n *= std::max(0, high[axis] - low[axis]);
    return n;
}

FieldSamples::Block FieldSamples::true_samples(const Node& node) const
{
    Block block;
    for (int axis = 0; axis < 3; ++axis) {
        block.low[axis] = std::max(node.low[axis] * kTile[axis], pad_);
        block.high[axis] = std::min(node.high[axis] * kTile[axis], grid_.size[axis] + pad_);
    }
    return block;
}

// Round the samples of the block, and so many beyond the last ones.
Box3 FieldSamples::box_of(const Block& block, std::int32_t beyond) const
{
    const std::int32_t last = beyond - 1;
    return {point(block.low[0], block.low[1], block.low[2]),
            point(block.high[0] + last, block.high[1] + last, block.high[2] + last)};
}

// Level by level, so that the order of what is stored does not depend on threads.
void FieldSamples::mark()
{
    constexpr std::size_t kBatch = 4096;  // outcomes held at a time
    std::vector<Node> level{{{0, 0, 0}, bits_.n_tiles(), nullptr}};
    while (!level.empty()) {
        std::vector<Node> next;
        for (std::size_t first = 0; first < level.size(); first += kBatch) {
            const std::size_t n = std::min(kBatch, level.size() - first);
            std::vector<Outcome> outcomes(n);
            parallel_for(n, 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) look(level[first + i], outcomes[i]);
            });
            current_progress().check();
            for (std::size_t i = 0; i < n; ++i) {
                Node& node = level[first + i];
                decided_ += outcomes[i].decided;
                if (outcomes[i].kind == Outcome::Kind::Stored) {
                    bits_.store(bits_.number(node.low[0], node.low[1], node.low[2]),
                                outcomes[i].words);
                    fields_.push_back(std::move(node.field));
                } else if (outcomes[i].kind == Outcome::Kind::Inside) {
                    for (std::int32_t k = node.low[2]; k < node.high[2]; ++k)
                        for (std::int32_t j = node.low[1]; j < node.high[1]; ++j)
                            for (std::int32_t x = node.low[0]; x < node.high[0]; ++x)
                                bits_.set_inside(bits_.number(x, j, k));
                } else if (outcomes[i].kind == Outcome::Kind::Divided) {
                    Index length;
                    for (int a = 0; a < 3; ++a)
                        length[a] = node.high[a] - node.low[a] > 1
                                        ? (node.high[a] - node.low[a]) * kTile[a]
                                        : 0;
                    const int axis = longest_axis(length);
                    Node second = node;
                    node.high[axis] = second.low[axis] = (node.low[axis] + node.high[axis]) / 2;
                    next.push_back(std::move(node));
                    next.push_back(std::move(second));
                }
            }
        }
        level = std::move(next);
    }
}

void FieldSamples::look(Node& node, Outcome& out) const
{
    using Kind = Outcome::Kind;
    const Block block = true_samples(node);
    const std::int64_t n = block.n_samples();
    if (n == 0) return;
    std::int64_t n_places = 1;
    bool single = true;
    for (int axis = 0; axis < 3; ++axis) {
        n_places *= std::int64_t{node.high[axis] - node.low[axis]} * kTile[axis];
        single = single && node.high[axis] - node.low[axis] == 1;
    }
    if (skip_) {
        if (auto here = field_of(node).within(box_of(block, 1))) node.field = std::move(here);
        const Interval range = field_of(node).bound(box_of(block, 0));
        out.decided = n;
        if (range.lo >= level_) return;
        // A tile with places that are no samples is not inside throughout.
        if (range.hi < level_ && n == n_places) {
            out.kind = Kind::Inside;
            return;
        }
        out.decided = 0;
    }
    if (!single) {
        out.kind = Kind::Divided;
        return;
    }
    // Its bound is known, if it has many samples.
    out.decided = skip_ && n > static_cast<std::int64_t>(kFewSamples)
                      ? mark_halves(field_of(node), block, out.words)
                      : mark_block(field_of(node), block, out.words);
    const auto all = [&](SampleWord word) {
        return std::all_of(out.words.begin(), out.words.end(),
                           [&](SampleWord w) { return w == word; });
    };
    out.kind = all(0) ? Kind::Outside : all(~SampleWord{0}) ? Kind::Inside : Kind::Stored;
}

// Sets the bits of a block of one tile; returns the number of samples that bounds decided.
std::int64_t FieldSamples::mark_block(const Implicit& field, const Block& block,
                                      TiledBits::Tile& words) const
{
    const auto word_of = [&](std::int32_t j, std::int32_t k) -> SampleWord& {
        return words[static_cast<std::size_t>(j % kTile[1] + kTile[1] * (k % kTile[2]))];
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
        field.values(std::span(points).first(n), std::span(values).first(n));
        n = 0;
        for_samples([&](std::int32_t i, std::int32_t j, std::int32_t k) {
            if (values[n++] < level_) word_of(j, k) |= SampleWord{1} << (i % kWordSamples);
        });
        return 0;
    }
    const Interval range = skip_ ? field.bound(box_of(block, 0)) : Interval::everything();
    if (range.lo >= level_) return block.n_samples();
    if (range.hi < level_) {
        const std::int32_t width = block.high[0] - block.low[0];
        const SampleWord ones = width == kWordSamples ? ~SampleWord{0}
                                                      : ((SampleWord{1} << width) - 1)
                                                            << (block.low[0] % kWordSamples);
        for (std::int32_t k = block.low[2]; k < block.high[2]; ++k)
            for (std::int32_t j = block.low[1]; j < block.high[1]; ++j) word_of(j, k) |= ones;
        return block.n_samples();
    }
    return mark_halves(field, block, words);
}

std::int64_t FieldSamples::mark_halves(const Implicit& field, const Block& block,
                                       TiledBits::Tile& words) const
{
    Index length;
    for (int a = 0; a < 3; ++a) length[a] = block.high[a] - block.low[a];
    const int axis = longest_axis(length);
    Block first = block, second = block;
    first.high[axis] = second.low[axis] = (block.low[axis] + block.high[axis]) / 2;
    return mark_block(field, first, words) + mark_block(field, second, words);
}

}  // namespace genus
