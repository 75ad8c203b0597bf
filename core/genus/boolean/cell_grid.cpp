#include "genus/boolean/cell_grid.h"

#include "genus/base/box.h"
#include "genus/base/parallel.h"

namespace genus::exact {

namespace {

constexpr int kMostCells = 1023;  // along an axis
// Sine of the least angle of a triangle whose plane is known well enough.
constexpr double kThin = 1e-6;

}  // namespace

CellGrid::CellGrid(const std::vector<Vec3>& points, std::size_t n_cells) : points_(points)
{
    Box3 box;
    for (const Vec3& p : points) box.add(p);
    if (points.empty()) box.add(Vec3{});
    low_ = box.min;
    const Vec3 extent = box.max - box.min;
    const double longest = std::max({extent[0], extent[1], extent[2], 1.0});
    const auto n_along = [&](int k) { return std::floor(extent[k] * scale_) + 1.0; };
    for (double n = kMostCells - 1; n >= 1.0; n *= 0.8) {
        scale_ = n / longest;
        if (n_along(0) * n_along(1) * n_along(2) <= static_cast<double>(n_cells)) break;
    }
    for (int k = 0; k < 3; ++k) count_[k] = static_cast<int>(n_along(k));
    cell_.resize(points.size());
    parallel_for(points.size(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            std::uint32_t packed = 0;
            for (int k = 0; k < 3; ++k)
                packed |= static_cast<std::uint32_t>(place(points[i][k], k)) << 10 * k;
            cell_[i] = packed;
        }
    });
}

std::vector<char> CellGrid::with_neighbours(const std::vector<std::size_t>& cells) const
{
    std::vector<char> flags(n_cells(), 0);
    for (std::size_t cell : cells) {
        std::array<int, 3> low;
        std::array<int, 3> high;
        for (int k = 0; k < 3; ++k) {
            const int at = static_cast<int>(cell % static_cast<std::size_t>(count_[k]));
            cell /= static_cast<std::size_t>(count_[k]);
            low[k] = std::max(at - 1, 0);
            high[k] = std::min(at + 1, count_[k] - 1);
        }
        for (int z = low[2]; z <= high[2]; ++z)
            for (int y = low[1]; y <= high[1]; ++y)
                for (int x = low[0]; x <= high[0]; ++x) flags[cell_at({x, y, z})] = 1;
    }
    return flags;
}

CellGrid::Range CellGrid::range(const Triangle& t, double reach) const
{
    Range r;
    for (int k = 0; k < 3; ++k) {
        const double a = points_[t[0]][k];
        const double b = points_[t[1]][k];
        const double c = points_[t[2]][k];
        r.low[k] = place(std::min({a, b, c}) - reach, k);
        r.high[k] = place(std::max({a, b, c}) + reach, k);
    }
    return r;
}

CellGrid::Slab CellGrid::slab_of(const Triangle& t, double reach) const
{
    const Vec3 a = scale_ * (points_[t[0]] - low_);
    const Vec3 ab = scale_ * (points_[t[1]] - points_[t[0]]);
    const Vec3 ac = scale_ * (points_[t[2]] - points_[t[0]]);
    const Vec3 bc = ac - ab;
    const Vec3 n = cross(ab, ac);
    const double longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
    Slab slab;
    if (!(norm(n) > kThin * longest)) return slab;
    slab.axis = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(n[k]) > std::abs(n[slab.axis])) slab.axis = k;
    const int u = (slab.axis + 1) % 3;
    const int v = (slab.axis + 2) % 3;
    slab.slope = {-n[u] / n[slab.axis], -n[v] / n[slab.axis]};
    slab.height = a[slab.axis] - slab.slope[0] * a[u] - slab.slope[1] * a[v];
    // Half a column each way, what the reach moves, and one cell for all rounding.
    slab.half = (0.5 + reach * scale_) * (std::abs(slab.slope[0]) + std::abs(slab.slope[1])) +
                reach * scale_ + 1.0;
    return slab;
}

}  // namespace genus::exact
