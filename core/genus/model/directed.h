#pragma once

#include <cmath>
#include <limits>

#include "genus/base/interval.h"

namespace genus {

/// Interval arithmetic that moves a bound only if the operation was inexact, and then by one unit
/// in the last place: sums and products of short numbers stay what they are, so the bounds of
/// sphere(10) are -10 and 10. Slower than Interval's own; used for bounds of solids.
namespace directed {

constexpr double kBig = std::numeric_limits<double>::max();
constexpr double kInf = std::numeric_limits<double>::infinity();
// Below this size the error of a product may itself underflow.
constexpr double kSmall = 1e-280;

/// The largest double not above the exact value `rounded + error`.
inline double below(double rounded, double error)
{
    return error < 0.0 ? std::nextafter(rounded, -kInf) : rounded;
}

inline double add_down(double a, double b)
{
    const double s = a + b;
    if (std::isnan(s)) return -kInf;
    if (std::isinf(s)) return s > 0.0 && !std::isinf(a) && !std::isinf(b) ? kBig : s;
    const double t = s - a;
    return below(s, (a - (s - t)) + (b - t));
}
inline double add_up(double a, double b)
{
    return -add_down(-a, -b);
}

inline double multiply_down(double a, double b)
{
    if (a == 0.0 || b == 0.0) return 0.0;
    const double p = a * b;
    if (std::isinf(p)) return p > 0.0 && !std::isinf(a) && !std::isinf(b) ? kBig : p;
    if (std::fabs(p) < kSmall) return std::nextafter(p, -kInf);
    return below(p, std::fma(a, b, -p));
}
inline double multiply_up(double a, double b)
{
    return -multiply_down(-a, b);
}

inline Interval add(const Interval& a, const Interval& b)
{
    return {add_down(a.lo, b.lo), add_up(a.hi, b.hi)};
}
inline Interval multiply(double a, const Interval& b)
{
    return a >= 0.0 ? Interval(multiply_down(a, b.lo), multiply_up(a, b.hi))
                    : Interval(multiply_down(a, b.hi), multiply_up(a, b.lo));
}

/// Not below the root of x >= 0.
inline double root_up(double x)
{
    const double s = std::sqrt(x);
    if (std::isinf(s) || s == 0.0) return s;
    const bool enough = x >= kSmall && std::fma(s, s, -x) >= 0.0;
    return enough ? s : std::nextafter(s, kInf);
}

/// Not below the length of (a, b, c); |a| itself where the others are zero.
inline double length_up(double a, double b, double c = 0.0)
{
    const double squares = add_up(add_up(multiply_up(a, a), multiply_up(b, b)), multiply_up(c, c));
    if (b == 0.0 && c == 0.0) return std::fabs(a);
    if (a == 0.0 && c == 0.0) return std::fabs(b);
    if (a == 0.0 && b == 0.0) return std::fabs(c);
    return root_up(squares);
}

}  // namespace directed
}  // namespace genus
