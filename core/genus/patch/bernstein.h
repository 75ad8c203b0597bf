#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "genus/base/vec.h"

namespace genus {

/// Highest degree of any curve or patch: up to here binomials times coordinates of 1e150 are
/// finite doubles.
inline constexpr int kMaxDegree = 512;

/// A point and how far each of its coordinates may be from the exact value.
template <std::size_t N>
struct Bounded {
    Vec<N> value;
    Vec<N> bound;
};

/// Polynomials by their Bernstein coefficients c_0 .. c_n over [0, 1],
/// p(t) = sum c_k B_k(t) with B_k(t) = binomial(n, k) t^k (1 - t)^(n - k).
/// Coefficients are doubles or vectors, called V below.
///
/// Implements [farin2002], chapters 4 to 6, and [farouki1988] for products.
namespace bernstein {

/// Binomial coefficient, exact up to n = 56 and to a few units in the last place beyond.
double binomial(int n, int k);

/// The n + 1 basis functions at t, by the recursion
/// B(n, k) = (1 - t) B(n - 1, k) + t B(n - 1, k - 1). Not negative and summing to 1 up to
/// rounding for t in [0, 1]. O(n^2).
std::vector<double> basis(int n, double t);

/// (1 - t) a + t b; exact at t = 0 and t = 1.
template <class V>
V mix(const V& a, const V& b, double t)
{
    return a * (1.0 - t) + b * t;
}

/// Value at t by de Casteljau's corner cutting: for t in [0, 1] it lies in the hull of the
/// coefficients. O(n^2).
template <class V>
V value(std::span<const V> c, double t)
{
    constexpr std::size_t kSmall = 16;
    std::array<V, kSmall> small;
    std::vector<V> large;
    V* work = small.data();
    if (c.size() > kSmall) {
        large.assign(c.begin(), c.end());
        work = large.data();
    } else {
        for (std::size_t i = 0; i < c.size(); ++i) work[i] = c[i];
    }
    for (std::size_t left = c.size() - 1; left > 0; --left)
        for (std::size_t i = 0; i < left; ++i) work[i] = mix(work[i], work[i + 1], t);
    return work[0];
}

/// Coefficients over [0, t] and over [t, 1], the outer points of de Casteljau's scheme. O(n^2).
template <class V>
void split(std::span<const V> c, double t, std::vector<V>& left, std::vector<V>& right)
{
    right.assign(c.begin(), c.end());
    left.resize(c.size());
    for (std::size_t k = 0; k < c.size(); ++k) {
        left[k] = right[0];
        for (std::size_t i = 0; i + 1 < c.size() - k; ++i)
            right[i] = mix(right[i], right[i + 1], t);
    }
}

/// Coefficients over [a, b], which may reach out of [0, 1].
template <class V>
std::vector<V> segment(std::span<const V> c, double a, double b)
{
    if (a > b) {
        auto backwards = segment<V>(c, b, a);
        return std::vector<V>(backwards.rbegin(), backwards.rend());
    }
    std::vector<V> left, right, part;
    // The longer cut first, so that the second ratio does not divide by a small number.
    if (std::fabs(b) >= std::fabs(1.0 - a)) {
        split<V>(c, b, left, right);
        split<V>(left, a / b, right, part);
        return part;
    }
    split<V>(c, a, left, right);
    split<V>(right, (b - a) / (1.0 - a), part, left);
    return part;
}

/// The same polynomial one degree higher. The new coefficients are convex combinations.
template <class V>
std::vector<V> elevated(std::span<const V> c)
{
    const std::size_t n = c.size();
    std::vector<V> e(n + 1);
    e[0] = c[0];
    e[n] = c[n - 1];
    for (std::size_t k = 1; k < n; ++k)
        e[k] = mix(c[k], c[k - 1], static_cast<double>(k) / static_cast<double>(n));
    return e;
}

/// Differences c_(k+1) - c_k; empty for a constant.
template <class V>
std::vector<V> differences(std::span<const V> c)
{
    std::vector<V> d(c.size() - 1);
    for (std::size_t k = 0; k < d.size(); ++k) d[k] = c[k + 1] - c[k];
    return d;
}

/// Coefficients of the derivative; that of a constant is the constant 0.
template <class V>
std::vector<V> derivative(std::span<const V> c)
{
    if (c.size() == 1) return {V{}};
    auto d = differences(c);
    for (V& x : d) x = x * static_cast<double>(c.size() - 1);
    return d;
}

/// Derivatives of order 0 to `order` at t. Those above the degree are 0. O(n^2 order).
template <class V>
std::vector<V> derivatives(std::span<const V> c, double t, int order)
{
    std::vector<V> result(static_cast<std::size_t>(order) + 1);
    std::vector<V> d(c.begin(), c.end());
    for (std::size_t r = 0; r < result.size() && r < c.size(); ++r) {
        result[r] = value<V>(d, t);
        d = derivative<V>(d);
    }
    return result;
}

/// Derivatives of C = A / w from those of (A, w), order by order (Leibniz's rule solved for C).
std::vector<Vec3> quotient_derivatives(std::span<const Vec4> a);

/// Coefficients of the product; its degree is the sum of both. O(n m).
std::vector<double> product(std::span<const double> a, std::span<const double> b);

/// Value with a bound on its rounding error, in twice the working precision: the bound exceeds
/// the true error only by what is lost beyond the 100th bit, also where terms cancel. Needs
/// |coordinates| < 1e150 and degree <= kMaxDegree. O(n).
///
/// Departs from the running error bounds of the books: those add up worst cases of each step and
/// overrate the error about n-fold.
template <std::size_t N>
Bounded<N> value_with_bound(std::span<const Vec<N>> c, double t);
/// The same for coefficients (x w, y w, z w, w) of a rational curve: value (x, y, z).
/// Coefficients may be off by `input_error` relative themselves. The bound is infinite where the
/// denominator may be zero.
Bounded<3> rational_value_with_bound(std::span<const Vec4> c, double t, double input_error = 0.0);

/// The same for tensor products of degree (m, n), c_ij at c[i (n + 1) + j], u going with i; and
/// for triangles of degree n, in the order of bezier_triangle.h. With Vec4 they are rational.
Bounded<3> tensor_value_with_bound(std::span<const Vec3> c, int m, int n, double u, double v);
Bounded<3> tensor_value_with_bound(std::span<const Vec4> c, int m, int n, double u, double v,
                                   double input_error);
Bounded<3> triangle_value_with_bound(std::span<const Vec3> c, int n, double u, double v);
Bounded<3> triangle_value_with_bound(std::span<const Vec4> c, int n, double u, double v,
                                     double input_error);

/// A place where a polynomial is zero.
struct Root {
    double t;
    /// True if the sign changes once there; false for a cluster: roots of even order, several
    /// closer than the tolerance, or a stretch where rounding hides the sign.
    bool simple;
};

/// All roots in [0, 1], ascending, each to `tolerance` (at least 2^-50); a cluster by its middle.
/// None is missed unless the polynomial stays within its rounding noise round it, where a root of
/// high order may also come as several. The zero polynomial has no isolated roots and gives none.
///
/// Implements [sederberg1990] (clipping by the hull); a stretch with one change of sign
/// among its coefficients is finished by bracketed regula falsi.
std::vector<Root> roots(std::span<const double> c, double tolerance = 0x1p-50);

}  // namespace bernstein
}  // namespace genus
