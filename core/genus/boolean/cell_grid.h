#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "genus/boolean/exact_point.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus::exact {

/// Cells of an even grid over points, by which triangles of these find out which others may be
/// close. A coordinate falls into cells in order, so two triangles with a common point have a
/// common cell.
class CellGrid {
public:
    /// About `n_cells` cubes, 1023 at most along an axis. O(points).
    CellGrid(const std::vector<Vec3>& points, std::size_t n_cells);

    std::size_t n_cells() const
    {
        return static_cast<std::size_t>(count_[0]) * count_[1] * count_[2];
    }

    /// The first and the last cell along each axis.
    struct Range {
        std::array<int, 3> low;
        std::array<int, 3> high;

        std::int64_t n_cells() const
        {
            std::int64_t n = 1;
            for (int k = 0; k < 3; ++k) n *= high[k] - low[k] + 1;
            return n;
        }
        /// All within a cell and its neighbours, whichever of them that is.
        bool is_small() const
        {
            return high[0] - low[0] <= 1 && high[1] - low[1] <= 1 && high[2] - low[2] <= 1;
        }
    };
    /// The cells of the box of a triangle.
    Range range(const Triangle& t) const
    {
        Range r;
        for (int k = 0; k < 3; ++k) {
            const auto at = [&](int i) { return static_cast<int>(cell_[t[i]] >> 10 * k & 1023u); };
            r.low[k] = std::min(std::min(at(0), at(1)), at(2));
            r.high[k] = std::max(std::max(at(0), at(1)), at(2));
        }
        return r;
    }
    /// The same with a box grown by `reach` all round.
    Range range(const Triangle& t, double reach) const;

    std::size_t cell_of(std::int32_t point) const
    {
        const std::uint32_t packed = cell_[point];
        return cell_at({static_cast<int>(packed & 1023u), static_cast<int>(packed >> 10 & 1023u),
                        static_cast<int>(packed >> 20)});
    }
    /// Some cells and their neighbours, as flags.
    std::vector<char> with_neighbours(const std::vector<std::size_t>& cells) const;

    /// The cells of a line along an axis.
    struct Column {
        int u;  // axes across it, and the cells there
        int v;
        int at_u;
        int at_v;
    };
    Column column(int axis, const Vec3& p) const
    {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        return {u, v, place(p[u], u), place(p[v], v)};
    }
    bool may_touch(const Column& c, const Triangle& t) const
    {
        const Range r = range(t);
        return r.low[c.u] <= c.at_u && c.at_u <= r.high[c.u] && r.low[c.v] <= c.at_v &&
               c.at_v <= r.high[c.v];
    }

    /// Calls visit(cell) for those of the cells that the triangle, moved by no more than `reach`,
    /// may touch, until one says true; returns whether one did. Of a range of many cells only those
    /// along the plane of the triangle are gone through.
    template <class Visit>
    bool visit_until(const Triangle& t, const Range& r, double reach, const Visit& visit) const
    {
        if (r.n_cells() > kManyCells)
            if (const Slab slab = slab_of(t, reach); slab.axis >= 0) return follow(slab, r, visit);
        for (int z = r.low[2]; z <= r.high[2]; ++z)
            for (int y = r.low[1]; y <= r.high[1]; ++y)
                for (int x = r.low[0]; x <= r.high[0]; ++x)
                    if (visit(cell_at({x, y, z}))) return true;
        return false;
    }

private:
    static constexpr std::int64_t kManyCells = 64;

    // A plane in steps of cells, thickened: height along `axis` over the middles of columns.
    struct Slab {
        int axis = -1;  // -1: the triangle is too thin to tell
        double height = 0.0;
        std::array<double, 2> slope{};  // along the next two axes
        double half = 0.0;
    };
    Slab slab_of(const Triangle& t, double reach) const;

    template <class Visit>
    bool follow(const Slab& slab, const Range& r, const Visit& visit) const
    {
        const int u = (slab.axis + 1) % 3;
        const int v = (slab.axis + 2) % 3;
        std::array<int, 3> at;
        for (at[u] = r.low[u]; at[u] <= r.high[u]; ++at[u])
            for (at[v] = r.low[v]; at[v] <= r.high[v]; ++at[v]) {
                const double middle =
                    slab.height + slab.slope[0] * (at[u] + 0.5) + slab.slope[1] * (at[v] + 0.5);
                const double low = std::max<double>(r.low[slab.axis], middle - slab.half - 1.0);
                const double high = std::min<double>(r.high[slab.axis], middle + slab.half);
                for (at[slab.axis] = static_cast<int>(std::ceil(low)); at[slab.axis] <= high;
                     ++at[slab.axis])
                    if (visit(cell_at(at))) return true;
            }
        return false;
    }

    std::size_t cell_at(const std::array<int, 3>& at) const
    {
        return (static_cast<std::size_t>(at[2]) * count_[1] + at[1]) * count_[0] + at[0];
    }
    int place(double x, int k) const
    {
        return static_cast<int>(std::clamp((x - low_[k]) * scale_, 0.0, count_[k] - 1.0));
    }

    const std::vector<Vec3>& points_;
    Vec3 low_;
    double scale_ = 0.0;
    std::array<int, 3> count_{1, 1, 1};
    std::vector<std::uint32_t> cell_;  // of each point, ten bits an axis
};

}  // namespace genus::exact
