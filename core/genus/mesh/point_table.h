#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/vec.h"

namespace genus {

/// Numbers points in the order in which they first appear; equal coordinates, equal number. A hash
/// table with linear probing, at most half full.
class PointTable {
public:
    /// The number of p. Throws InvalidInput if it is not finite.
    std::int32_t find_or_add(Vec3 p)
    {
        if (!is_finite(p))
            throw InvalidInput("point (" + to_text(p[0]) + ", " + to_text(p[1]) + ", " +
                               to_text(p[2]) + ") is not finite");
        if (2 * (points_.size() + 1) > slots_.size()) grow();
        std::size_t slot = place(p);
        while (slots_[slot] >= 0 && points_[slots_[slot]] != p)
            slot = (slot + 1) & (slots_.size() - 1);
        if (slots_[slot] < 0) {
            require(points_.size() < (std::size_t{1} << 30), "more than 2^30 points");
            slots_[slot] = static_cast<std::int32_t>(points_.size());
            points_.push_back(p);
        }
        return slots_[slot];
    }

    std::vector<Vec3> take_points() { return std::move(points_); }

private:
    // 0 and -0 are equal, so they must go to one place: adding 0 makes both 0.
    std::size_t place(const Vec3& p) const
    {
        std::uint64_t hash = 0;
        for (const double x : p.c) {
            hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15;
            hash ^= hash >> 32;
        }
        return hash & (slots_.size() - 1);
    }

    void grow()
    {
        slots_.assign(slots_.empty() ? 64 : 2 * slots_.size(), -1);
        for (std::size_t i = 0; i < points_.size(); ++i) {
            std::size_t slot = place(points_[i]);
            while (slots_[slot] >= 0) slot = (slot + 1) & (slots_.size() - 1);
            slots_[slot] = static_cast<std::int32_t>(i);
        }
    }

    std::vector<Vec3> points_;
    std::vector<std::int32_t> slots_;  // a power of two of them
};

}  // namespace genus
