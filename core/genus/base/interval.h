#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "genus/base/box.h"
#include "genus/base/vec.h"

namespace genus {

/// Closed interval of reals; every operation rounds outward, so the result holds the exact
/// image of its operands. Bounds may be infinite. Nothing depends on the rounding mode:
/// a bound is moved by at least one unit in the last place after a rounded operation.
struct Interval {
    double lo = 0.0;
    double hi = 0.0;

    constexpr Interval() = default;
    constexpr Interval(double value) : lo(value), hi(value) {}  // NOLINT: a number is an interval
    constexpr Interval(double low, double high) : lo(low), hi(high) {}

    static constexpr Interval everything()
    {
        return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    }

    constexpr bool operator==(const Interval&) const = default;
    constexpr bool contains(double value) const { return lo <= value && value <= hi; }
    constexpr double mid() const { return 0.5 * lo + 0.5 * hi; }
    constexpr double width() const { return hi - lo; }
    /// Largest absolute value in it.
    constexpr double magnitude() const { return std::max(lo < 0 ? -lo : lo, hi < 0 ? -hi : hi); }
};

namespace rounding {

// |x| 2^-52 is at least one unit in the last place of x, so one subtraction, itself rounded to
// nearest, still ends below the exact value. An overflow to infinity is pulled back to the
// largest finite number on the inner side; not-a-number becomes "unknown".
inline double down(double x)
{
    constexpr double eps = std::numeric_limits<double>::epsilon();
    constexpr double tiny = std::numeric_limits<double>::denorm_min();
    if (!(x <= std::numeric_limits<double>::max()))
        return std::isnan(x) ? -std::numeric_limits<double>::infinity()
                             : std::numeric_limits<double>::max();
    return x - (std::fabs(x) * eps + tiny);
}

inline double up(double x)
{
    return -down(-x);
}

}  // namespace rounding

inline Interval operator-(const Interval& a)
{
    return {-a.hi, -a.lo};
}
inline Interval operator+(const Interval& a, const Interval& b)
{
    return {rounding::down(a.lo + b.lo), rounding::up(a.hi + b.hi)};
}
inline Interval operator-(const Interval& a, const Interval& b)
{
    return {rounding::down(a.lo - b.hi), rounding::up(a.hi - b.lo)};
}
inline Interval operator*(const Interval& a, const Interval& b)
{
    // 0 * infinity counts as 0 here: the infinite bound is a limit, never a value taken.
    const auto times = [](double x, double y) { return x == 0.0 || y == 0.0 ? 0.0 : x * y; };
    const double p = times(a.lo, b.lo), q = times(a.lo, b.hi);
    const double r = times(a.hi, b.lo), s = times(a.hi, b.hi);
    return {rounding::down(std::min({p, q, r, s})), rounding::up(std::max({p, q, r, s}))};
}
inline Interval operator/(const Interval& a, const Interval& b)
{
    if (b.contains(0.0)) return Interval::everything();
    const double p = a.lo / b.lo, q = a.lo / b.hi, r = a.hi / b.lo, s = a.hi / b.hi;
    return {rounding::down(std::min({p, q, r, s})), rounding::up(std::max({p, q, r, s}))};
}

inline Interval square(const Interval& a)
{
    const double p = a.lo * a.lo, q = a.hi * a.hi;
    const double least = a.contains(0.0) ? 0.0 : rounding::down(std::min(p, q));
    return {std::max(0.0, least), rounding::up(std::max(p, q))};
}
/// The root of the part of `a` that is not negative.
inline Interval sqrt(const Interval& a)
{
    const double lo = std::max(a.lo, 0.0), hi = std::max(a.hi, 0.0);
    return {std::max(0.0, rounding::down(std::sqrt(lo))), rounding::up(std::sqrt(hi))};
}
inline Interval abs(const Interval& a)
{
    if (a.lo >= 0.0) return a;
    if (a.hi <= 0.0) return -a;
    return {0.0, a.magnitude()};
}
constexpr Interval min(const Interval& a, const Interval& b)
{
    return {std::min(a.lo, b.lo), std::min(a.hi, b.hi)};
}
constexpr Interval max(const Interval& a, const Interval& b)
{
    return {std::max(a.lo, b.lo), std::max(a.hi, b.hi)};
}
/// Smallest interval that holds both.
constexpr Interval hull(const Interval& a, const Interval& b)
{
    return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

using IntervalVec3 = std::array<Interval, 3>;

inline IntervalVec3 to_intervals(const Box3& box)
{
    return {Interval(box.min[0], box.max[0]), Interval(box.min[1], box.max[1]),
            Interval(box.min[2], box.max[2])};
}

inline Interval dot(const IntervalVec3& a, const Vec3& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace genus
