#include "genus/boolean/box_tree.h"

#include <cmath>
#include <limits>

namespace genus::exact {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float rounded_down(double v)
{
    const auto f = static_cast<float>(v);
    return static_cast<double>(f) > v ? std::nextafterf(f, -kInfinity) : f;
}

float rounded_up(double v)
{
    const auto f = static_cast<float>(v);
    return static_cast<double>(f) < v ? std::nextafterf(f, kInfinity) : f;
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
        box.low[k] = rounded_down(std::min({a[k], b[k], c[k]}));
        box.high[k] = rounded_up(std::max({a[k], b[k], c[k]}));
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
    std::vector<FloatBox> sorted(n);
    std::vector<std::int32_t> owner(n, -1);
    for (std::size_t i = 0; i < n; ++i) {
        items_[i] = keyed[i].second;
        sorted[i] = boxes[items_[i]];
        if (!owners.empty()) owner[i] = owners[items_[i]];
    }
    do {
        add_level(sorted, owner);
    } while (levels_.back().size() > 1);
}

// Packs the nodes of one level and leaves those of the next.
void BoxTree::add_level(std::vector<FloatBox>& boxes, std::vector<std::int32_t>& owners)
{
    std::vector<Quad> level((boxes.size() + 3) / 4);
    for (std::size_t q = 0; q < level.size(); ++q) {
        FloatBox all;
        std::int32_t owner = owners[4 * q];
        for (std::size_t i = 0; i < 4; ++i) {
            const bool exists = 4 * q + i < boxes.size();
            const FloatBox box = exists ? boxes[4 * q + i] : FloatBox{};
            for (int k = 0; k < 3; ++k) {
                level[q].low[k][i] = box.low[k];
                level[q].high[k][i] = box.high[k];
            }
            level[q].owner[i] = exists ? owners[4 * q + i] : -1;
            if (!exists) continue;
            all.add(box);
            if (owners[4 * q + i] != owner) owner = -1;
        }
        boxes[q] = all;
        owners[q] = owner;
    }
    boxes.resize(level.size());
    owners.resize(level.size());
    levels_.push_back(std::move(level));
}

}  // namespace genus::exact
