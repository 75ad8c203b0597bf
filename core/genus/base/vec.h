#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace genus {

/// A vector of `N` doubles; a point is a vector from the origin. Plain data: no invariant.
template <std::size_t N>
struct Vec {
    std::array<double, N> c{};

    constexpr double& operator[](std::size_t i) { return c[i]; }
    constexpr double operator[](std::size_t i) const { return c[i]; }
    constexpr bool operator==(const Vec&) const = default;

    constexpr Vec& operator+=(const Vec& o)
    {
        for (std::size_t i = 0; i < N; ++i) c[i] += o.c[i];
        return *this;
    }
    constexpr Vec& operator-=(const Vec& o)
    {
        for (std::size_t i = 0; i < N; ++i) c[i] -= o.c[i];
        return *this;
    }
    constexpr Vec& operator*=(double s)
    {
        for (std::size_t i = 0; i < N; ++i) c[i] *= s;
        return *this;
    }
};

using Vec2 = Vec<2>;
using Vec3 = Vec<3>;
using Vec4 = Vec<4>;

template <std::size_t N>
constexpr Vec<N> operator+(Vec<N> a, const Vec<N>& b)
{
    return a += b;
}
template <std::size_t N>
constexpr Vec<N> operator-(Vec<N> a, const Vec<N>& b)
{
    return a -= b;
}
template <std::size_t N>
constexpr Vec<N> operator-(Vec<N> a)
{
    return a *= -1.0;
}
template <std::size_t N>
constexpr Vec<N> operator*(Vec<N> a, double s)
{
    return a *= s;
}
template <std::size_t N>
constexpr Vec<N> operator*(double s, Vec<N> a)
{
    return a *= s;
}
template <std::size_t N>
constexpr Vec<N> operator/(Vec<N> a, double s)
{
    for (std::size_t i = 0; i < N; ++i) a.c[i] /= s;
    return a;
}

template <std::size_t N>
constexpr double dot(const Vec<N>& a, const Vec<N>& b)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < N; ++i) sum += a.c[i] * b.c[i];
    return sum;
}

constexpr Vec3 cross(const Vec3& a, const Vec3& b)
{
    return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

template <std::size_t N>
double norm(const Vec<N>& a)
{
    return std::sqrt(dot(a, a));
}

template <std::size_t N>
double distance(const Vec<N>& a, const Vec<N>& b)
{
    return norm(a - b);
}

/// `a` at length 1; the zero vector stays zero.
template <std::size_t N>
Vec<N> normalized(const Vec<N>& a)
{
    const double length = norm(a);
    return length > 0.0 ? a / length : a;
}

template <std::size_t N>
bool is_finite(const Vec<N>& a)
{
    for (std::size_t i = 0; i < N; ++i)
        if (!std::isfinite(a.c[i])) return false;
    return true;
}

}  // namespace genus
