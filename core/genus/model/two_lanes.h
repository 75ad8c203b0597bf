#pragma once

#include <array>

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

/// Two points or vectors.
struct TwoVec {
    Two x, y, z;

    TwoVec(const Two& first, const Two& second, const Two& third) : x(first), y(second), z(third) {}
    TwoVec(const Vec3& one, const Vec3& other)
        : x{one[0], other[0]}, y{one[1], other[1]}, z{one[2], other[2]}
    {
    }
};

inline TwoVec operator-(const TwoVec& a, const TwoVec& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
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
inline Two bend(const QuadraticPolynomial& c, const TwoVec& e)
{
    return e.x * (c[4] * e.x + c[7] * e.y + c[8] * e.z) + e.y * (c[5] * e.y + c[9] * e.z) +
           c[6] * e.z * e.z;
}

}  // namespace genus
