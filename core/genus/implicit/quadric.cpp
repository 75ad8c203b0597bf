#include "genus/implicit/quadric.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/error.h"
#include "genus/implicit/double_double.h"

namespace genus {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kMinNormal = std::numeric_limits<double>::min();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where the entry (row, column) of Q stands among the ten.
constexpr std::array<std::array<int, 4>, 4> kPlace{
    {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}}};

using Matrix4 = std::array<std::array<DoubleDouble, 4>, 4>;

bool all_finite(const std::array<double, 10>& q)
{
    return std::all_of(q.begin(), q.end(), [](double c) { return std::isfinite(c); });
}

/// N^T Q N for the affine map N, whose last row is (0, 0, 0, 1).
std::array<double, 10> congruent(const std::array<double, 10>& q, const Matrix4& n)
{
    Matrix4 qn;
    for (int row = 0; row < 4; ++row)
        for (int col = 0; col < 4; ++col)
            for (int k = 0; k < 4; ++k)
                qn[row][col] = qn[row][col] + DoubleDouble(q[kPlace[row][k]]) * n[k][col];
    std::array<double, 10> result{};
    for (int row = 0; row < 4; ++row)
        for (int col = row; col < 4; ++col) {
            DoubleDouble sum;
            for (int k = 0; k < 4; ++k) sum = sum + n[k][row] * qn[k][col];
            result[kPlace[row][col]] = sum.rounded();
        }
    return result;
}

Matrix4 shift(const std::array<DoubleDouble, 3>& by)
{
    Matrix4 n;
    for (int i = 0; i < 4; ++i) n[i][i] = 1.0;
    for (int i = 0; i < 3; ++i) n[i][3] = by[i];
    return n;
}

/// Inverse of the linear part of `t` by cofactors, in double the precision.
std::array<std::array<DoubleDouble, 3>, 3> inverse_linear(const Transform& t)
{
    const auto entry = [&](int row, int col) { return DoubleDouble(t.m[row % 3][col % 3]); };
    const auto cofactor = [&](int r, int c) {
        return entry(r + 1, c + 1) * entry(r + 2, c + 2) -
               entry(r + 1, c + 2) * entry(r + 2, c + 1);
    };
    DoubleDouble det;
    for (int c = 0; c < 3; ++c) det = det + entry(0, c) * cofactor(0, c);
    std::array<std::array<DoubleDouble, 3>, 3> inverse;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) inverse[c][r] = cofactor(r, c) / det;
    return inverse;
}

void drop_rounding_of_mixed_terms(std::array<double, 10>& q)
{
    for (int i = 0; i < 3; ++i)
        for (int j = i + 1; j < 3; ++j) {
            const double squares =
                std::sqrt(std::fabs(q[kPlace[i][i]])) * std::sqrt(std::fabs(q[kPlace[j][j]]));
            double& mixed = q[kPlace[i][j]];
            if (std::fabs(mixed) <= 4.0 * kEps * squares) mixed = 0.0;
        }
}

/// Least and greatest value of g d + a d^2 over |d| <= h.
Interval parabola_range(double g, double a, double h)
{
    const double slope = std::fabs(g) * h, bend = a * h * h;
    double lo = std::min(bend - slope, bend + slope), hi = std::max(bend - slope, bend + slope);
    lo = std::min(lo, 0.0);
    hi = std::max(hi, 0.0);
    // The apex at d = -g / 2a, written so that nothing underflows before it matters.
    if (std::fabs(g) < 2.0 * std::fabs(a) * h) {
        const double apex = -0.5 * (g / (2.0 * a)) * g;
        lo = std::min(lo, apex);
        hi = std::max(hi, apex);
    }
    return {lo, hi};
}

/// F about the middle of a box: f + g.d + sum a_i d_i^2 + sum over pairs b d_i d_j, |d_i| <= h_i.
struct Centred {
    double f;
    Vec3 g, a, b;  // b[k] belongs to the pair of axes other than k
    Vec3 h;
};

/// Lower bound of `c`. Variables in which it is monotone are set to the end where it is least,
/// which shifts the slopes of the others; the rest is bounded term by term.
double least(Centred c)
{
    std::array<bool, 3> free{true, true, true};
    for (bool again = true; again;) {
        again = false;
        for (int i = 0; i < 3; ++i) {
            if (!free[i]) continue;
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            double spread = 2.0 * std::fabs(c.a[i]) * c.h[i];
            if (free[j]) spread += std::fabs(c.b[k]) * c.h[j];
            if (free[k]) spread += std::fabs(c.b[j]) * c.h[k];
            if (std::fabs(c.g[i]) < spread) continue;
            const double d = c.g[i] > 0.0 ? -c.h[i] : c.h[i];
            c.f += d * (c.g[i] + c.a[i] * d);
            if (free[j]) c.g[j] += c.b[k] * d;
            if (free[k]) c.g[k] += c.b[j] * d;
            free[i] = false;
            again = true;
        }
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        if (free[i]) c.f += parabola_range(c.g[i], c.a[i], c.h[i]).lo;
        if (free[j] && free[k]) c.f -= std::fabs(c.b[i]) * c.h[j] * c.h[k];
    }
    return c.f;
}

Centred negated(const Centred& c)
{
    return {-c.f, -c.g, -c.a, -c.b, c.h};
}

/// Bound by interval arithmetic, per variable by completing the square where that is narrower.
/// Serves boxes that reach to infinity or overflow.
Interval natural_bound(const std::array<double, 10>& q, const IntervalVec3& x)
{
    const std::array<double, 3> a{q[0], q[4], q[7]}, b{q[3], q[6], q[8]};
    Interval sum(q[9]);
    for (int i = 0; i < 3; ++i) {
        if (a[i] == 0.0) {
            if (b[i] != 0.0) sum = sum + Interval(2.0 * b[i]) * x[i];
        } else {
            const Interval middle = Interval(b[i]) / Interval(a[i]);
            sum = sum + Interval(a[i]) * square(x[i] + middle) - Interval(b[i]) * middle;
        }
    }
    // Factors of zero are left out: their rounding times infinity would be everything.
    if (q[1] != 0.0) sum = sum + Interval(2.0 * q[1]) * x[0] * x[1];
    if (q[2] != 0.0) sum = sum + Interval(2.0 * q[2]) * x[0] * x[2];
    if (q[5] != 0.0) sum = sum + Interval(2.0 * q[5]) * x[1] * x[2];
    return sum;
}

IntervalVec3 relative_to(const Box3& box, const Vec3& origin)
{
    IntervalVec3 x = to_intervals(box);
    for (int i = 0; i < 3; ++i)
        if (origin[i] != 0.0) x[i] = x[i] - Interval(origin[i]);
    return x;
}

}  // namespace

Quadric::Quadric(const std::array<double, 10>& upper_triangle, const Vec3& origin)
    : q_(upper_triangle), origin_(origin)
{
    require(all_finite(q_) && is_finite(origin_), "quadric: a coefficient is not finite");
    const bool mixed = q_[1] != 0.0 || q_[2] != 0.0 || q_[5] != 0.0;
    const bool squares = q_[0] != 0.0 || q_[4] != 0.0 || q_[7] != 0.0;
    form_ = mixed ? Form::General : squares ? Form::Separable : Form::Linear;
    if (form_ == Form::Linear && origin_ != Vec3{}) *this = about({});
}

Quadric Quadric::from_polynomial(const std::array<double, 10>& c)
{
    return Quadric({c[0], 0.5 * c[3], 0.5 * c[4], 0.5 * c[6], c[1], 0.5 * c[5], 0.5 * c[7], c[2],
                    0.5 * c[8], c[9]});
}

Quadric Quadric::from_matrix(const std::array<std::array<double, 4>, 4>& q)
{
    double largest = 0.0, gap = 0.0;
    std::array<double, 10> upper{};
    for (int row = 0; row < 4; ++row)
        for (int col = row; col < 4; ++col) {
            largest = std::max({largest, std::fabs(q[row][col]), std::fabs(q[col][row])});
            gap = std::max(gap, std::fabs(q[row][col] - q[col][row]));
            upper[kPlace[row][col]] = 0.5 * q[row][col] + 0.5 * q[col][row];
        }
    const Quadric quadric(upper);
    require(gap <= 1e-12 * largest, "quadric: the matrix is not symmetric");
    return quadric;
}

Quadric Quadric::sphere(double r)
{
    return Quadric({1, 0, 0, 0, 1, 0, 0, 1, 0, -r * r});
}

Quadric Quadric::ellipsoid(const Vec3& radii)
{
    const auto part = [](double r) { return 1.0 / (r * r); };
    return Quadric({part(radii[0]), 0, 0, 0, part(radii[1]), 0, 0, part(radii[2]), 0, -1});
}

Quadric Quadric::cylinder(double r)
{
    return Quadric({1, 0, 0, 0, 1, 0, 0, 0, 0, -r * r});
}

Quadric Quadric::cone(double r0, double slope)
{
    return Quadric({1, 0, 0, 0, 1, 0, 0, -slope * slope, -r0 * slope, -r0 * r0});
}

Quadric Quadric::half_space(const Vec3& normal, double offset)
{
    return Quadric({0, 0, 0, 0.5 * normal[0], 0, 0, 0.5 * normal[1], 0, 0.5 * normal[2], -offset});
}

Quadric Quadric::about(const Vec3& origin) const
{
    std::array<DoubleDouble, 3> by;
    for (int i = 0; i < 3; ++i) by[i] = DoubleDouble(origin[i]) - DoubleDouble(origin_[i]);
    // f(p - o) = f((p - o') + (o' - o)); kept apart from the constructor, which calls this.
    Quadric moved = *this;
    moved.q_ = congruent(q_, shift(by));
    moved.origin_ = origin;
    require(all_finite(moved.q_), "quadric: a coefficient overflows");
    return moved;
}

Quadric Quadric::scaled(double factor) const
{
    std::array<double, 10> q = q_;
    for (double& c : q) c *= factor;
    return Quadric(q, origin_);
}

std::array<double, 10> Quadric::upper_triangle() const
{
    return origin_ == Vec3{} ? q_ : about({}).q_;
}

std::array<double, 10> Quadric::polynomial() const
{
    const std::array<double, 10> q = upper_triangle();
    return {q[0],       q[4],       q[7],       2.0 * q[1], 2.0 * q[2],
            2.0 * q[5], 2.0 * q[3], 2.0 * q[6], 2.0 * q[8], q[9]};
}

std::array<std::array<double, 4>, 4> Quadric::matrix() const
{
    const std::array<double, 10> q = upper_triangle();
    std::array<std::array<double, 4>, 4> m{};
    for (int row = 0; row < 4; ++row)
        for (int col = 0; col < 4; ++col) m[row][col] = q[kPlace[row][col]];
    return m;
}

std::array<Vec3, 3> Quadric::hessian() const
{
    std::array<Vec3, 3> h;
    for (int row = 0; row < 3; ++row)
        for (int col = 0; col < 3; ++col) h[row][col] = 2.0 * q_[kPlace[row][col]];
    return h;
}

Interval Quadric::bound(const Box3& box) const
{
    // Middle and half sizes of the box, these rounded up so that the box is covered.
    Vec3 c, h, m;
    for (int i = 0; i < 3; ++i) {
        const double middle = 0.5 * box.min[i] + 0.5 * box.max[i];
        const double half = std::max(box.max[i] - middle, middle - box.min[i]);
        c[i] = middle - origin_[i];
        // The step to the origin is rounded, too.
        h[i] = half + kEps * (half + std::fabs(c[i])) + kMinNormal;
        m[i] = std::fabs(c[i]) + h[i];
    }
    const auto& q = q_;
    Centred e;
    e.h = h;
    e.g = {{2.0 * (q[0] * c[0] + q[1] * c[1] + q[2] * c[2] + q[3]),
            2.0 * (q[1] * c[0] + q[4] * c[1] + q[5] * c[2] + q[6]),
            2.0 * (q[2] * c[0] + q[5] * c[1] + q[7] * c[2] + q[8])}};
    e.f = c[0] * (q[0] * c[0] + 2.0 * (q[1] * c[1] + q[2] * c[2] + q[3])) +
          c[1] * (q[4] * c[1] + 2.0 * (q[5] * c[2] + q[6])) + c[2] * (q[7] * c[2] + 2.0 * q[8]) +
          q[9];
    // Every term above and below is at most its share of this sum, and passes through fewer than
    // 24 roundings of half a unit each; underflow adds at most a denormal times a factor in m. The
    // rest of the slack covers the rounding of value(), so that its results are held, too.
    const auto term = [](double a) { return std::fabs(a); };
    const double magnitude =
        m[0] * (term(q[0]) * m[0] + 2.0 * (term(q[1]) * m[1] + term(q[2]) * m[2] + term(q[3]))) +
        m[1] * (term(q[4]) * m[1] + 2.0 * (term(q[5]) * m[2] + term(q[6]))) +
        m[2] * (term(q[7]) * m[2] + 2.0 * term(q[8])) + term(q[9]);
    const double slack = 32.0 * kEps * magnitude + kMinNormal * (1.0 + m[0] + m[1] + m[2]);
    if (!(slack <= 1e300)) return natural_bound(q_, relative_to(box, origin_));

    if (form_ == Form::Linear) {
        const double reach =
            std::fabs(e.g[0]) * h[0] + std::fabs(e.g[1]) * h[1] + std::fabs(e.g[2]) * h[2];
        return {e.f - reach - slack, e.f + reach + slack};
    }
    e.a = {{q[0], q[4], q[7]}};
    if (form_ == Form::Separable) {
        Interval range(e.f - slack, e.f + slack);
        for (int i = 0; i < 3; ++i) {
            const Interval part = parabola_range(e.g[i], e.a[i], h[i]);
            range = {range.lo + part.lo, range.hi + part.hi};
        }
        return range;
    }
    e.b = {{2.0 * q[5], 2.0 * q[2], 2.0 * q[1]}};
    return {least(e) - slack, slack - least(negated(e))};
}

IntervalVec3 Quadric::gradient_bound(const Box3& box) const
{
    if (form_ == Form::Linear) return {2.0 * q_[3], 2.0 * q_[6], 2.0 * q_[8]};
    const IntervalVec3 x = relative_to(box, origin_);
    IntervalVec3 g;
    for (int i = 0; i < 3; ++i) {
        double lo = q_[kPlace[i][3]], hi = lo, magnitude = std::fabs(lo);
        for (int j = 0; j < 3; ++j) {
            const double a = q_[kPlace[i][j]];
            if (a == 0.0) continue;
            lo += a * (a > 0.0 ? x[j].lo : x[j].hi);
            hi += a * (a > 0.0 ? x[j].hi : x[j].lo);
            magnitude += std::fabs(a) * x[j].magnitude();
        }
        // At most 7 roundings a term.
        const double slack = 4.0 * kEps * magnitude + kMinNormal;
        g[i] = slack <= 1e300 ? Interval(2.0 * (lo - slack), 2.0 * (hi + slack))
                              : Interval(std::isnan(lo) ? -kInfinity : 2.0 * lo,
                                         std::isnan(hi) ? kInfinity : 2.0 * hi);
    }
    return g;
}

Quadric transformed(const Quadric& quadric, const Transform& t)
{
    require(t.is_affine(), "quadric: the transform is not affine");
    inverse(t);  // refuses singular maps
    const auto n = inverse_linear(t);
    // The origin goes to the rounded image of the old one; what rounding took away is put back
    // into the coefficients: p' - o' = L (p - o) + rest.
    const Vec3& o = quadric.origin();
    Vec3 origin;
    std::array<DoubleDouble, 3> rest;
    for (int i = 0; i < 3; ++i) {
        DoubleDouble image(t.m[i][3]);
        for (int j = 0; j < 3; ++j) image = image + two_product(t.m[i][j], o[j]);
        origin[i] = quadric.is_linear() ? 0.0 : image.hi;
        rest[i] = image - DoubleDouble(origin[i]);
    }
    Matrix4 map;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            map[i][j] = n[i][j];
            map[i][3] = map[i][3] - n[i][j] * rest[j];
        }
    }
    map[3][3] = 1.0;
    std::array<double, 10> q = congruent(quadric.local(), map);
    require(all_finite(q) && is_finite(origin), "quadric: a coefficient overflows");
    drop_rounding_of_mixed_terms(q);
    return Quadric(q, origin);
}

double curvature_bound(const Quadric& quadric, const Box3& box)
{
    const IntervalVec3 g = quadric.gradient_bound(box);
    const Interval length = sqrt(square(g[0]) + square(g[1]) + square(g[2]));
    // The largest row sum of absolute values bounds the spectral norm.
    double largest = 0.0;
    for (const Vec3& row : quadric.hessian())
        largest = std::max(largest, std::fabs(row[0]) + std::fabs(row[1]) + std::fabs(row[2]));
    if (largest == 0.0) return 0.0;
    if (!(length.lo > 0.0)) return kInfinity;
    return rounding::up(rounding::up(largest * (1.0 + 4.0 * kEps)) / length.lo);
}

}  // namespace genus
