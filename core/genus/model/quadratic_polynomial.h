#pragma once

#include <array>

#include "genus/base/vec.h"

namespace genus {

/// c0 + c1 x + c2 y + c3 z + c4 xx + c5 yy + c6 zz + c7 xy + c8 xz + c9 yz.
using QuadraticPolynomial = std::array<double, 10>;

inline double evaluate(const QuadraticPolynomial& c, const Vec3& p)
{
    const double x = p[0], y = p[1], z = p[2];
    return c[0] + x * (c[1] + c[4] * x + c[7] * y + c[8] * z) + y * (c[2] + c[5] * y + c[9] * z) +
           z * (c[3] + c[6] * z);
}

/// The gradient.
inline Vec3 slope(const QuadraticPolynomial& c, const Vec3& p)
{
    const double x = p[0], y = p[1], z = p[2];
    return {{c[1] + 2.0 * c[4] * x + c[7] * y + c[8] * z,
             c[2] + c[7] * x + 2.0 * c[5] * y + c[9] * z,
             c[3] + c[8] * x + c[9] * y + 2.0 * c[6] * z}};
}

/// The terms of the second order along a step.
inline double bend(const QuadraticPolynomial& c, const Vec3& e)
{
    const double x = e[0], y = e[1], z = e[2];
    return x * (c[4] * x + c[7] * y + c[8] * z) + y * (c[5] * y + c[9] * z) + c[6] * z * z;
}

/// What is of the second order alone.
inline QuadraticPolynomial second_order(const QuadraticPolynomial& c)
{
    return {0.0, 0.0, 0.0, 0.0, c[4], c[5], c[6], c[7], c[8], c[9]};
}

}  // namespace genus
