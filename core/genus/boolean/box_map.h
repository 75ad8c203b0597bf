#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "genus/boolean/box_tree.h"

namespace genus::exact {

/// Which of 32^3 places round some boxes are taken by any of them: for questions about many boxes
/// most of which are far from all of these, sooner answered than by a tree.
class BoxMap {
public:
    explicit BoxMap(const std::vector<FloatBox>& boxes)
    {
        for (const FloatBox& box : boxes) all_.add(box);
        for (int k = 0; k < 3; ++k) {
            const double extent = static_cast<double>(all_.high[k]) - all_.low[k];
            scale_[k] = extent > 0.0 ? kSide / extent : 0.0;
        }
        for (const FloatBox& box : boxes) add(box);
    }

    /// False only if it overlaps none of the boxes.
    bool may_overlap(const FloatBox& box) const
    {
        if (!box.overlaps(all_)) return false;
        const Places at = places_of(box);
        for (int z = at[2].first; z <= at[2].second; ++z)
            for (int y = at[1].first; y <= at[1].second; ++y)
                if ((rows_[kSide * z + y] & bits(at[0])) != 0) return true;
        return false;
    }

private:
    static constexpr int kSide = 32;
    using Range = std::pair<int, int>;  // of places, both included
    using Places = std::array<Range, 3>;

    Places places_of(const FloatBox& box) const
    {
        Places at;
        for (int k = 0; k < 3; ++k) {
            const auto place = [&](float v) {
                const double steps = (static_cast<double>(v) - all_.low[k]) * scale_[k];
                return static_cast<int>(std::clamp(steps, 0.0, kSide - 1.0));
            };
            at[k] = {place(box.low[k]), place(box.high[k])};
        }
        return at;
    }

    static std::uint32_t bits(const Range& x)
    {
        return (~0u << x.first) & (~0u >> (kSide - 1 - x.second));
    }

    void add(const FloatBox& box)
    {
        const Places at = places_of(box);
        for (int z = at[2].first; z <= at[2].second; ++z)
            for (int y = at[1].first; y <= at[1].second; ++y) rows_[kSide * z + y] |= bits(at[0]);
    }

    FloatBox all_;
    std::array<double, 3> scale_{};
    std::array<std::uint32_t, kSide * kSide> rows_{};  // a bit a place along x
};

}  // namespace genus::exact
