#include "genus/volume/grid_field.h"

#include <algorithm>
#include <cmath>

namespace genus {

// Interpolation takes means of samples, so the samples of all cells that the box may touch hold it,
// but for the rounding of the means.
Interval GridField::bound(const Box3& box) const
{
    std::array<std::int32_t, 3> low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double last = grid_.size()[axis] - 1;
        const auto place = [&](double x) {
            return (x - grid_.frame().origin[axis]) / grid_.frame().spacing[axis];
        };
        const double a = std::floor(place(box.min[axis]) - 1e-9 * last);
        const double b = std::ceil(place(box.max[axis]) + 1e-9 * last);
        low[axis] = static_cast<std::int32_t>(std::clamp(a, 0.0, last));
        high[axis] = static_cast<std::int32_t>(std::clamp(b, 0.0, last));
    }
    Interval range(grid_.at(low[0], low[1], low[2]));
    for (std::int32_t k = low[2]; k <= high[2]; ++k)
        for (std::int32_t j = low[1]; j <= high[1]; ++j)
            for (std::int32_t i = low[0]; i <= high[0]; ++i)
                range = hull(range, Interval(grid_.at(i, j, k)));
    const double rounding = 1e-14 * range.magnitude();
    return {range.lo - rounding, range.hi + rounding};
}

}  // namespace genus
