#include "genus/volume/crossing.h"

#include <utility>

namespace genus {

double find_root(const std::function<double(double)>& f, double f0, double f1)
{
    double low = 0.0, high = 1.0, f_low = f0, f_high = f1;
    double weight_low = f0, weight_high = f1;  // as the Illinois rule halves them
    double width = 1.0;
    for (int step = 1; high - low > 0x1p-52 && f_low != 0.0 && f_high != 0.0; ++step) {
        double t = low + (high - low) * (weight_low / (weight_low - weight_high));
        if (step % 3 == 0) {
            if (high - low > 0.5 * width) t = 0.5 * (low + high);
            width = high - low;
        }
        if (!(t > low && t < high)) t = 0.5 * (low + high);
        if (t == low || t == high) break;
        const double value = f(t);
        if ((value < 0.0) == (f_low < 0.0)) {
            low = t;
            f_low = weight_low = value;
            weight_high *= 0.5;
        } else {
            high = t;
            f_high = weight_high = value;
            weight_low *= 0.5;
        }
    }
    return std::fabs(f_low) <= std::fabs(f_high) ? low : high;
}

Vec3 ExactCrossings::operator()(int axis, std::int32_t i, std::int32_t j, std::int32_t k) const
{
    GridIndex end{i, j, k};
    ++end[axis];
    const double a = samples_.relative(i, j, k);
    const double b = samples_.relative(end[0], end[1], end[2]);
    Vec3 p = samples_.point(i, j, k);
    const GridFrame& frame = samples_.frame();
    const std::int32_t at = GridIndex{i, j, k}[axis] - samples_.pad();
    const auto place = [&](double t) {
        return frame.origin[axis] + (at + t) * frame.spacing[axis];
    };
    const bool within = samples_.is_true(i, j, k) && samples_.is_true(end[0], end[1], end[2]);
    const auto value = [&](double t) {
        p[axis] = place(t);
        return samples_.field().value(p) - samples_.level();
    };
    p[axis] = place(within ? find_root(value, a, b) : linear_root(a, b));
    return p;
}

}  // namespace genus
