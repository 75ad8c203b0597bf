#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "genus/base/progress.h"
#include "genus/base/vec.h"

namespace genus::io {

/// Numbers points so that equal ones get the same number, in the order in which they first come.
/// Equal means the same three doubles; -0 equals 0. Open addressing with linear probing; about
/// 8 bytes for each slot, of which at most half are taken.
class PointTable {
public:
    /// With room for `expected` different points; grows beyond that.
    explicit PointTable(std::size_t expected);

    /// Numbers of `count` points in one go, so that the memory of their slots arrives together.
    /// False once there would be more points than numbers.
    bool number(const Vec3* points, std::size_t count, std::int32_t* numbers);

    std::size_t size() const { return points_.size(); }
    std::vector<Vec3> take_points() && { return std::move(points_); }

private:
    struct Slot {
        std::uint32_t tag = 0;     // a part of the hash that does not choose the slot
        std::int32_t number = -1;  // -1 where free
    };

    static std::uint64_t hash(const Vec3& p);
    std::int32_t find_or_add(const Vec3& p, std::uint64_t hash);
    void grow();

    std::vector<Slot> slots_;
    std::vector<Vec3> points_;
    std::size_t mask_ = 0;
};

/// Numbers the `n` corners that `corner(i)` gives. False where there are too many points.
template <class Corner>
bool number_corners(PointTable& table, std::size_t n, const Corner& corner, std::int32_t* numbers)
{
    constexpr std::size_t batch = 96;  // corners; their slots fit the first-level cache
    constexpr std::size_t batches_per_check = 4096;
    Vec3 points[batch];
    for (std::size_t begin = 0; begin < n; begin += batch) {
        if (begin / batch % batches_per_check == 0) current_progress().check();
        const std::size_t count = n - begin < batch ? n - begin : batch;
        for (std::size_t i = 0; i < count; ++i) points[i] = corner(begin + i);
        if (!table.number(points, count, numbers + begin)) return false;
    }
    return true;
}

/// Corners per vertex in a closed triangle mesh, nearly.
constexpr std::size_t kCornersPerVertex = 6;

}  // namespace genus::io
