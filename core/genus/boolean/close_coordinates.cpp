#include "genus/boolean/close_coordinates.h"

#include <algorithm>
#include <cmath>

namespace genus::exact {

namespace {

// Values of one coordinate at which faces lie; of values within `reach` of a first one only that.
std::vector<double> plane_values(std::span<const Vec3> points, std::span<const Triangle> faces,
                                 int axis, double reach)
{
    std::vector<double> values;
    for (const Triangle& t : faces) {
        const double v = points[t[0]][axis];
        if (points[t[1]][axis] == v && points[t[2]][axis] == v) values.push_back(v);
    }
    std::sort(values.begin(), values.end());
    std::vector<double> first;
    for (const double v : values)
        if (first.empty() || v - first.back() > reach) first.push_back(v);
    return first;
}

}  // namespace

std::vector<double> merge_close_coordinates(std::span<Vec3> points, std::span<const Triangle> faces,
                                            const Vec3& reach)
{
    std::vector<double> moved;
    for (int axis = 0; axis < 3; ++axis) {
        const std::vector<double> planes = plane_values(points, faces, axis, reach[axis]);
        if (planes.empty()) continue;
        moved.resize(points.size(), 0.0);
        for (std::size_t n = 0; n < points.size(); ++n) {
            double& value = points[n][axis];
            const auto next = std::upper_bound(planes.begin(), planes.end(), value);
            double target = value;
            if (next != planes.begin() && value - *(next - 1) <= reach[axis])
                target = *(next - 1);
            else if (next != planes.end() && *next - value <= reach[axis])
                target = *next;
            moved[n] = std::max(moved[n], std::abs(value - target));
            value = target;
        }
    }
    return moved;
}

}  // namespace genus::exact
