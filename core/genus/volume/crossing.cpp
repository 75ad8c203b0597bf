#include "genus/volume/crossing.h"

#include <algorithm>
#include <utility>

namespace genus {

double find_root(const std::function<double(double)>& f, double f0, double f1)
{
    constexpr double kStep = 0x1p-53;  // the least step, and half of the width that is enough
    constexpr int kMostSteps = 60;     // after them only halving
    // b is the best so far, the root lies between b and c, and a was before b.
    double a = 0.0, b = 1.0, c = 0.0;
    double fa = f0, fb = f1, fc = f0;
    double step = 1.0, before = 1.0;
    for (int n = 0;; ++n) {
        if ((fb < 0.0) == (fc < 0.0)) {
            c = a;
            fc = fa;
            step = before = b - a;
        }
        if (std::fabs(fc) < std::fabs(fb)) {
            a = std::exchange(b, c);
            c = a;
            fa = std::exchange(fb, fc);
            fc = fa;
        }
        const double half = 0.5 * (c - b);
        if (std::fabs(half) <= kStep || fb == 0.0) return b;
        const double last = before, previous = step;
        before = step = half;
        if (n < kMostSteps && std::fabs(last) >= kStep && std::fabs(fa) > std::fabs(fb)) {
            // Through two points a line, through three a parabola on its side. Comparisons with
            // what is not a number fail, and the interval is halved.
            const double s = fb / fa;
            double p = 2.0 * half * s, q = 1.0 - s;
            if (a != c) {
                const double t = fa / fc, r = fb / fc;
                p = s * (2.0 * half * t * (t - r) - (b - a) * (r - 1.0));
                q = (t - 1.0) * (r - 1.0) * (s - 1.0);
            }
            if (p > 0.0) q = -q;
            p = std::fabs(p);
            if (2.0 * p < std::min(3.0 * half * q - std::fabs(kStep * q), std::fabs(last * q))) {
                before = previous;
                step = p / q;
            }
        }
        a = b;
        fa = fb;
        b += std::fabs(step) > kStep ? step : std::copysign(kStep, half);
        fb = f(b);
    }
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
    const Implicit& field = samples_.field_at(i, j, k);
    const auto value = [&](double t) {
        p[axis] = place(t);
        return field.value(p) - samples_.level();
    };
    p[axis] = place(within ? find_root(value, a, b) : linear_root(a, b));
    return p;
}

}  // namespace genus
