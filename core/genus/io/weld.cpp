#include "genus/io/weld.h"

#include <algorithm>

namespace genus::io {

namespace {

// Odd constants with well mixed bits: the fractional parts of the golden ratio and of sqrt(3).
constexpr std::uint64_t kMix1 = 0x9E3779B97F4A7C15;
constexpr std::uint64_t kMix2 = 0xBB67AE8584CAA73B;

constexpr std::size_t kBatch = 128;
constexpr std::size_t kMinSlots = 1024;

std::uint64_t fold(std::uint64_t x)
{
    return x ^ (x >> 32);
}

}  // namespace

PointTable::PointTable(std::size_t expected)
{
    slots_.resize(std::bit_ceil(std::max(2 * expected, kMinSlots)));
    mask_ = slots_.size() - 1;
    points_.reserve(expected);
}

std::uint64_t PointTable::hash(const Vec3& p)
{
    // Adding 0 turns -0 into 0.
    const auto x = std::bit_cast<std::uint64_t>(p[0] + 0.0);
    const auto y = std::bit_cast<std::uint64_t>(p[1] + 0.0);
    const auto z = std::bit_cast<std::uint64_t>(p[2] + 0.0);
    std::uint64_t h = fold(x * kMix1) ^ y;
    h = fold(h * kMix2) ^ z;
    h = fold(h * kMix1) * kMix2;
    return fold(h);
}

std::int32_t PointTable::find_or_add(const Vec3& p, std::uint64_t h)
{
    const auto tag = static_cast<std::uint32_t>(h >> 32);
    std::size_t s = h & mask_;
    for (; slots_[s].number >= 0; s = (s + 1) & mask_)
        if (slots_[s].tag == tag && points_[static_cast<std::size_t>(slots_[s].number)] == p)
            return slots_[s].number;
    const auto number = static_cast<std::int32_t>(points_.size());
    slots_[s] = {tag, number};
    points_.push_back({{p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}});
    return number;
}

bool PointTable::number(const Vec3* points, std::size_t count, std::int32_t* numbers)
{
    std::uint64_t hashes[kBatch];
    for (std::size_t begin = 0; begin < count; begin += kBatch) {
        const std::size_t n = std::min(count - begin, kBatch);
        constexpr auto most = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
        if (points_.size() + n > most) return false;
        if (2 * (points_.size() + n) > slots_.size()) grow();
        for (std::size_t i = 0; i < n; ++i) {
            hashes[i] = hash(points[begin + i]);
            __builtin_prefetch(&slots_[hashes[i] & mask_], 1);
        }
        for (std::size_t i = 0; i < n; ++i)
            numbers[begin + i] = find_or_add(points[begin + i], hashes[i]);
    }
    return true;
}

void PointTable::grow()
{
    std::vector<Slot> larger(2 * slots_.size());
    mask_ = larger.size() - 1;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const std::uint64_t h = hash(points_[i]);
        std::size_t s = h & mask_;
        while (larger[s].number >= 0) s = (s + 1) & mask_;
        larger[s] = {static_cast<std::uint32_t>(h >> 32), static_cast<std::int32_t>(i)};
    }
    slots_ = std::move(larger);
}

}  // namespace genus::io
