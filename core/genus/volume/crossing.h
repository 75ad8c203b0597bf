#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "genus/base/vec.h"
#include "genus/volume/grid.h"

namespace genus {

using GridIndex = std::array<std::int32_t, 3>;

/// A root of f in [0, 1], where f(0) and f(1), given, have different signs (zero counts with the
/// positive ones). The returned t is one of two neighbouring doubles, or the two are within
/// 2^-52, between which the sign changes; the one with the smaller |f|. At most some 120 calls,
/// usually about ten.
///
/// Implements [ford1995] (Illinois rule), with a bisection wherever three steps did not halve the
/// interval.
double find_root(const std::function<double(double)>& f, double f0, double f1);

/// The point on the grid edge from `at` along `axis` where the linear interpolant crosses zero;
/// the true sample itself where the other end lies in the padding.
template <typename Samples>
Vec3 linear_crossing(const Samples& samples, const GridFrame& frame, int axis, GridIndex at)
{
    GridIndex end = at;
    ++end[axis];
    const double a = samples.relative(at[0], at[1], at[2]);
    const double b = samples.relative(end[0], end[1], end[2]);
    double t = a / (a - b);
    if (std::isinf(a)) t = 1.0;
    if (std::isinf(b)) t = 0.0;
    Vec3 p = frame.point(at[0] - samples.pad(), at[1] - samples.pad(), at[2] - samples.pad());
    p[axis] = frame.origin[axis] + (at[axis] - samples.pad() + t) * frame.spacing[axis];
    return p;
}

/// The same where the field of the samples itself crosses the level; see FieldSamples.
template <typename Samples>
Vec3 exact_crossing(const Samples& samples, int axis, GridIndex at)
{
    GridIndex end = at;
    ++end[axis];
    if (!samples.is_true(at[0], at[1], at[2]) || !samples.is_true(end[0], end[1], end[2]))
        return linear_crossing(samples, samples.frame(), axis, at);
    const double a = samples.relative(at[0], at[1], at[2]);
    const double b = samples.relative(end[0], end[1], end[2]);
    Vec3 p = samples.point(at[0], at[1], at[2]);
    const GridFrame& frame = samples.frame();
    const auto place = [&](double t) {
        return frame.origin[axis] + (at[axis] - samples.pad() + t) * frame.spacing[axis];
    };
    const auto value = [&](double t) {
        p[axis] = place(t);
        return samples.field().value(p) - samples.level();
    };
    p[axis] = place(find_root(value, a, b));
    return p;
}

}  // namespace genus
