#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "genus/base/vec.h"
#include "genus/model/quadratic_polynomial.h"

namespace genus {

/// The same sum done for two things at once, as the inner and the outer side of a face: two doubles
/// of which each comes out as it would alone, to the last bit.
using Two = double __attribute__((vector_size(16)));

inline Two both(double x)
{
    return Two{x, x};
}
inline Two greater(const Two& a, const Two& b)
{
    return a > b ? a : b;
}
inline Two lesser(const Two& a, const Two& b)
{
    return a < b ? a : b;
}

inline Two root(const Two& x)
{
    return Two{std::sqrt(x[0]), std::sqrt(x[1])};
}
/// The first with the sign of the second.
inline Two with_sign(const Two& size, const Two& sign)
{
    return Two{std::copysign(size[0], sign[0]), std::copysign(size[1], sign[1])};
}

/// Two points or vectors.
struct TwoVec {
    Two x, y, z;

    TwoVec(const Two& first, const Two& second, const Two& third) : x(first), y(second), z(third) {}
    TwoVec(const Vec3& one, const Vec3& other)
        : x{one[0], other[0]}, y{one[1], other[1]}, z{one[2], other[2]}
    {
    }
    Vec3 operator[](std::size_t i) const { return {{x[i], y[i], z[i]}}; }
};

inline TwoVec operator+(const TwoVec& a, const TwoVec& b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline TwoVec operator-(const TwoVec& a, const TwoVec& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline TwoVec operator-(const TwoVec& a, const Vec3& b)
{
    return {a.x - b[0], a.y - b[1], a.z - b[2]};
}
inline TwoVec operator*(const Two& s, const TwoVec& v)
{
    return {s * v.x, s * v.y, s * v.z};
}
inline Two dot(const TwoVec& a, const TwoVec& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline TwoVec cross(const TwoVec& a, const TwoVec& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// The largest coordinate of each, without its sign.
inline Two largest(const TwoVec& v)
{
    const auto size = [](const Two& t) { return greater(t, -t); };
    return greater(size(v.x), greater(size(v.y), size(v.z)));
}
inline Two evaluate(const QuadraticPolynomial& c, const TwoVec& p)
{
    return c[0] + p.x * (c[1] + c[4] * p.x + c[7] * p.y + c[8] * p.z) +
           p.y * (c[2] + c[5] * p.y + c[9] * p.z) + p.z * (c[3] + c[6] * p.z);
}
inline TwoVec slope(const QuadraticPolynomial& c, const TwoVec& p)
{
    return {c[1] + 2.0 * c[4] * p.x + c[7] * p.y + c[8] * p.z,
            c[2] + c[7] * p.x + 2.0 * c[5] * p.y + c[9] * p.z,
            c[3] + c[8] * p.x + c[9] * p.y + 2.0 * c[6] * p.z};
}
inline Two bend(const QuadraticPolynomial& c, const TwoVec& e)
{
    return e.x * (c[4] * e.x + c[7] * e.y + c[8] * e.z) + e.y * (c[5] * e.y + c[9] * e.z) +
           c[6] * e.z * e.z;
}

}  // namespace genus
