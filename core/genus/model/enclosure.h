#pragma once

#include <cmath>

#include "genus/implicit/double_double.h"

namespace genus {

/// A real number within `radius` of a double-double: what coefficients are formed in that arise as
/// differences of large numbers. Every operation adds its own rounding to the radius; a number that
/// overflows has a radius that is not finite.
struct Enclosure {
    DoubleDouble middle;
    double radius = 0.0;

    Enclosure() = default;
    Enclosure(double value) : middle(value) {}  // NOLINT: a number encloses itself
    Enclosure(const DoubleDouble& m, double r) : middle(m), radius(r) {}

    /// Largest absolute value in it.
    double magnitude() const { return kUp * (std::fabs(middle.hi) + radius); }
    /// The nearest double, which is within `error` of the number.
    double rounded(double& error) const
    {
        const double m = middle.rounded();
        error = kUp * (radius + std::fabs((middle.hi - m) + middle.lo));
        return m;
    }

    // Sum and product of double-doubles err by less than 8 units of 2^-106; radii are sums of
    // positive numbers, whose own rounding kUp covers. Below kTiny products lose digits.
    static constexpr double kUnit = 0x1p-102, kUp = 1.0 + 0x1p-48, kTiny = 1e-285;
};

inline Enclosure operator-(const Enclosure& a)
{
    return {-a.middle, a.radius};
}
inline Enclosure operator+(const Enclosure& a, const Enclosure& b)
{
    const DoubleDouble m = a.middle + b.middle;
    return {m, Enclosure::kUp * (a.radius + b.radius + Enclosure::kUnit * std::fabs(m.hi))};
}
inline Enclosure operator-(const Enclosure& a, const Enclosure& b)
{
    return a + -b;
}
inline Enclosure operator*(const Enclosure& a, const Enclosure& b)
{
    const DoubleDouble m = a.middle * b.middle;
    const double spread = a.radius * b.magnitude() + std::fabs(a.middle.hi) * b.radius;
    const bool is_zero = a.magnitude() == 0.0 || b.magnitude() == 0.0;
    const double rounding = Enclosure::kUnit * std::fabs(m.hi) + (is_zero ? 0.0 : Enclosure::kTiny);
    return {m, Enclosure::kUp * (spread + rounding)};
}

}  // namespace genus
