#include "genus/boolean/box_tree.h"

#include <cmath>
#include <limits>

namespace genus::exact {

namespace {

// The next float below or, where that is quicker to find, a little further on: these go for whole
// meshes, and half of all numbers have to be rounded the other way.
float lowered(double v)
{
    constexpr double kLargest = std::numeric_limits<float>::max();
    const auto f = static_cast<float>(std::clamp(v, -kLargest, kLargest));
    return f - (std::abs(f) * 0x1p-23f + std::numeric_limits<float>::min());
}

// The lower 10 bits of v, two zeros between each.
std::uint32_t spread(std::uint32_t v)
{
    v = (v | (v << 16)) & 0x030000FFu;
    v = (v | (v << 8)) & 0x0300F00Fu;
    v = (v | (v << 4)) & 0x030C30C3u;
    v = (v | (v << 2)) & 0x09249249u;
    return v;
}

using Keyed = std::pair<std::uint32_t, std::int32_t>;

// Stable, by key, 11 bits at a time.
void radix_sort(std::vector<Keyed>& items)
{
    std::vector<Keyed> other(items.size());
    for (int shift = 0; shift < 30; shift += 10) {
        std::vector<std::uint32_t> start(1025, 0);
        for (const Keyed& item : items) ++start[((item.first >> shift) & 1023u) + 1];
        for (int i = 0; i < 1024; ++i) start[i + 1] += start[i];
        for (const Keyed& item : items) other[start[(item.first >> shift) & 1023u]++] = item;
        items.swap(other);
    }
}

}  // namespace

FloatBox box_of(const Vec3& a, const Vec3& b, const Vec3& c)
{
    FloatBox box;
    for (int k = 0; k < 3; ++k) {
        box.low[k] = lowered(std::min(std::min(a[k], b[k]), c[k]));
        box.high[k] = -lowered(-std::max(std::max(a[k], b[k]), c[k]));
    }
    return box;
}

BoxTree::BoxTree(std::vector<FloatBox> boxes, std::vector<std::int32_t> owners)
{
    const std::size_t n = boxes.size();
    FloatBox all;
    for (const FloatBox& box : boxes) all.add(box);
    float scale[3];
    for (int k = 0; k < 3; ++k) {
        const float extent = all.high[k] - all.low[k];
        scale[k] = extent > 0.0f ? 1023.0f / extent : 0.0f;
    }
    std::vector<Keyed> keyed(n);
    parallel_for(n, 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            std::uint32_t key = 0;
            for (int k = 0; k < 3; ++k) {
                const float middle = 0.5f * (boxes[i].low[k] + boxes[i].high[k]) - all.low[k];
                key |=
                    spread(static_cast<std::uint32_t>(std::clamp(middle * scale[k], 0.0f, 1023.0f)))
                    << k;
            }
            keyed[i] = {key, static_cast<std::int32_t>(i)};
        }
    });
    radix_sort(keyed);
    items_.resize(n);
    if (n == 0) return;
    for (std::size_t i = 0; i < n; ++i) items_[i] = keyed[i].second;
    keyed = {};
    Level above = add_level(
        n, [&](std::size_t i) { return boxes[items_[i]]; },
        [&](std::size_t i) { return owners.empty() ? -1 : owners[items_[i]]; });
    while (levels_.back().size() > 1) {
        const Level level = std::move(above);
        above = add_level(
            level.boxes.size(), [&](std::size_t i) { return level.boxes[i]; },
            [&](std::size_t i) { return level.owners[i]; });
    }
}

// Packs the nodes of one level and returns those of the next.
template <class BoxAt, class OwnerAt>
BoxTree::Level BoxTree::add_level(std::size_t n, const BoxAt& box_at, const OwnerAt& owner_at)
{
    std::vector<Quad> level((n + 3) / 4);
    Level above{std::vector<FloatBox>(level.size()), std::vector<std::int32_t>(level.size())};
    for (std::size_t q = 0; q < level.size(); ++q) {
        FloatBox all;
        std::int32_t owner = owner_at(4 * q);
        for (std::size_t i = 0; i < 4; ++i) {
            const bool exists = 4 * q + i < n;
            const FloatBox box = exists ? box_at(4 * q + i) : FloatBox{};
            const std::int32_t own = exists ? owner_at(4 * q + i) : -1;
            for (int k = 0; k < 3; ++k) {
                level[q].low[k][i] = box.low[k];
                level[q].high[k][i] = box.high[k];
            }
            level[q].owner[i] = own;
            if (!exists) continue;
            all.add(box);
            if (own != owner) owner = -1;
        }
        above.boxes[q] = all;
        above.owners[q] = owner;
    }
    levels_.push_back(std::move(level));
    return above;
}

}  // namespace genus::exact
