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
    levels_.emplace_back(n);
    for (std::size_t i = 0; i < n; ++i) {
        items_[i] = keyed[i].second;
        const auto owner = owners.empty() ? static_cast<std::int32_t>(i) : owners[items_[i]];
        levels_[0][i] = {boxes[items_[i]], owner};
    }
    while (levels_.back().size() > 1) {
        const auto& below = levels_.back();
        std::vector<Node> level((below.size() + 3) / 4);
        for (std::size_t i = 0; i < below.size(); ++i) {
            Node& node = level[i / 4];
            if (i % 4 == 0)
                node = below[i];
            else {
                node.box.add(below[i].box);
                if (node.owner != below[i].owner) node.owner = -1;
            }
        }
        levels_.push_back(std::move(level));
    }
}

}  // namespace genus::exact
