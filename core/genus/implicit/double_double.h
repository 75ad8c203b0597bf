#pragma once

#include <cmath>

namespace genus {

/// An unevaluated sum hi + lo of two doubles, |lo| at most half a unit in the last place of hi:
/// about 106 bits. Used where coefficients are formed once and evaluated millions of times, so
/// that each of them is as good as a double can be. Plain data; no invariant beyond the above.
///
/// Implements [dekker1971] (add, multiply), with the product's error by fused multiply-add.
struct DoubleDouble {
    double hi = 0.0;
    double lo = 0.0;

    constexpr DoubleDouble() = default;
    constexpr DoubleDouble(double value) : hi(value) {}  // NOLINT: a double is one of these
    constexpr DoubleDouble(double high, double low) : hi(high), lo(low) {}

    double rounded() const { return hi + lo; }
};

/// a + b without error.
inline DoubleDouble two_sum(double a, double b)
{
    const double s = a + b;
    const double t = s - a;
    return {s, (a - (s - t)) + (b - t)};
}

/// a * b without error, unless it under- or overflows.
inline DoubleDouble two_product(double a, double b)
{
    const double p = a * b;
    return {p, std::fma(a, b, -p)};
}

inline DoubleDouble operator-(const DoubleDouble& a)
{
    return {-a.hi, -a.lo};
}
inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b)
{
    const DoubleDouble s = two_sum(a.hi, b.hi), t = two_sum(a.lo, b.lo);
    const DoubleDouble u = two_sum(s.hi, s.lo + t.hi);
    return two_sum(u.hi, u.lo + t.lo);
}
inline DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b)
{
    return a + -b;
}
inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b)
{
    const DoubleDouble p = two_product(a.hi, b.hi);
    return two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
inline DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b)
{
    // Two corrections of the quotient by its remainder.
    const double q = a.hi / b.hi;
    const DoubleDouble r = a - b * DoubleDouble(q);
    const double q2 = r.hi / b.hi;
    const DoubleDouble r2 = r - b * DoubleDouble(q2);
    const DoubleDouble s = two_sum(q, q2);
    return two_sum(s.hi, s.lo + r2.hi / b.hi);
}

}  // namespace genus
