#include "genus/model/surface_form.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/error.h"

namespace genus {

namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kFlattest = 0.125;  // curvature along a chord on a saddle, of the greatest

// Sum of the absolute values of all terms for points whose coordinates do not exceed `m`.
double magnitude(const std::array<double, 10>& c, const Vec3& m)
{
    std::array<double, 10> a;
    for (std::size_t i = 0; i < 10; ++i) a[i] = std::fabs(c[i]);
    return evaluate(a, m);
}

Vec3 magnitude_of_slope(const std::array<double, 10>& c, const Vec3& m)
{
    std::array<double, 10> a;
    for (std::size_t i = 0; i < 10; ++i) a[i] = std::fabs(c[i]);
    return slope(a, m);
}

Interval range_of(const std::array<double, 10>& c, const IntervalVec3& b)
{
    return Interval(c[0]) + b[0] * c[1] + b[1] * c[2] + b[2] * c[3] + square(b[0]) * c[4] +
           square(b[1]) * c[5] + square(b[2]) * c[6] + b[0] * b[1] * c[7] + b[0] * b[2] * c[8] +
           b[1] * b[2] * c[9];
}

// Over the box with this centre and these half sides, but for rounding: exact in each coordinate
// for itself, products of two coordinates apart from their linear terms by their largest values.
Interval range_round(const std::array<double, 10>& q, const Vec3& centre, const Vec3& half)
{
    const Vec3 g = slope(q, centre);
    double lo = evaluate(q, centre), hi = lo;
    for (std::size_t i = 0; i < 3; ++i) {
        // g t + q t^2 for |t| <= h, with its vertex if that is inside.
        const double a = std::fabs(g[i]) * half[i], s = q[4 + i] * half[i] * half[i];
        const bool vertex = a < 2.0 * std::fabs(s);
        lo += vertex && s > 0.0 ? -a * a / (4.0 * s) : s - a;
        hi += vertex && s < 0.0 ? -a * a / (4.0 * s) : s + a;
    }
    const double mixed = std::fabs(q[7]) * half[0] * half[1] + std::fabs(q[8]) * half[0] * half[2] +
                         std::fabs(q[9]) * half[1] * half[2];
    return {lo - mixed, hi + mixed};
}

IntervalVec3 slope_range(const std::array<double, 10>& c, const IntervalVec3& b)
{
    return {b[0] * (2.0 * c[4]) + b[1] * c[7] + b[2] * c[8] + Interval(c[1]),
            b[0] * c[7] + b[1] * (2.0 * c[5]) + b[2] * c[9] + Interval(c[2]),
            b[0] * c[8] + b[1] * c[9] + b[2] * (2.0 * c[6]) + Interval(c[3])};
}

// Quadratics over a simplex with N corners: coefficient (i, j), i <= j, at place pair[i][j].
template <std::size_t N>
struct Tables {
    static constexpr std::size_t kPairs = N * (N + 1) / 2;
    static constexpr std::size_t kQuartic = N == 3 ? 15 : 35;

    std::array<std::array<std::size_t, N>, N> pair{};
    // Product of two quadratics: coefficient (a, b) of the first and second goes to `slot` with
    // `weight`.
    std::array<std::array<std::size_t, kPairs>, kPairs> slot{};
    std::array<std::array<double, kPairs>, kPairs> weight{};
    std::array<std::array<int, N>, kQuartic> exponent{};

    Tables()
    {
        std::array<std::array<int, N>, kPairs> of_pair{};
        std::size_t n = 0;
        for (std::size_t i = 0; i < N; ++i)
            for (std::size_t j = i; j < N; ++j, ++n) {
                pair[i][j] = pair[j][i] = n;
                ++of_pair[n][i];
                ++of_pair[n][j];
            }
        std::size_t n_quartic = 0;
        for (std::size_t a = 0; a < kPairs; ++a)
            for (std::size_t b = 0; b < kPairs; ++b) {
                std::array<int, N> e{};
                for (std::size_t i = 0; i < N; ++i) e[i] = of_pair[a][i] + of_pair[b][i];
                std::size_t s = 0;
                while (s < n_quartic && exponent[s] != e) ++s;
                if (s == n_quartic) exponent[n_quartic++] = e;
                slot[a][b] = s;
                weight[a][b] =
                    multinomial(2, of_pair[a]) * multinomial(2, of_pair[b]) / multinomial(4, e);
            }
    }

private:
    static double factorial(int n) { return n <= 1 ? 1.0 : n * factorial(n - 1); }
    static double multinomial(int degree, const std::array<int, N>& e)
    {
        double m = factorial(degree);
        for (const int k : e) m /= factorial(k);
        return m;
    }
};

template <std::size_t N>
const Tables<N>& tables()
{
    static const Tables<N> instance;
    return instance;
}

// Bernstein coefficients from the values at corners and the bends of edges.
template <std::size_t N>
std::array<double, Tables<N>::kPairs> coefficients(const std::array<double, 10>& c,
                                                   const std::array<Vec3, N>& p)
{
    std::array<double, Tables<N>::kPairs> b;
    std::array<double, N> corner;
    for (std::size_t i = 0; i < N; ++i) corner[i] = evaluate(c, p[i]);
    std::size_t n = 0;
    for (std::size_t i = 0; i < N; ++i) {
        b[n++] = corner[i];
        for (std::size_t j = i + 1; j < N; ++j)
            b[n++] = 0.5 * (corner[i] + corner[j] - bend(c, p[j] - p[i]));
    }
    return b;
}

template <std::size_t N>
std::array<double, Tables<N>::kQuartic> torus_coefficients(const std::array<double, 10>& s,
                                                           const std::array<double, 10>& t,
                                                           const std::array<Vec3, N>& p)
{
    const Tables<N>& table = tables<N>();
    const auto bs = coefficients<N>(s, p), bt = coefficients<N>(t, p);
    std::array<double, Tables<N>::kQuartic> b{};
    for (std::size_t i = 0; i < bs.size(); ++i)
        for (std::size_t j = 0; j < bs.size(); ++j)
            b[table.slot[i][j]] += table.weight[i][j] * (bs[i] * bs[j] - bt[i]);
    return b;
}

// Range of a quadratic over a triangle from its Bernstein coefficients, without the slack of their
// hull: a quadratic is extreme at a corner, at the middle of a side's parabola, or at its one
// critical point inside.
Interval exact_range(const std::array<double, 6>& b)
{
    // b: 00, 01, 02, 11, 12, 22.
    Interval range(std::min({b[0], b[3], b[5]}), std::max({b[0], b[3], b[5]}));
    const auto add = [&range](double x) {
        range.lo = std::min(range.lo, x);
        range.hi = std::max(range.hi, x);
    };
    // With weights u, v of corners 1 and 2: b00 + 2 u g1 + 2 v g2 + u^2 h11 + 2 u v h12 + v^2 h22.
    const double g1 = b[1] - b[0], g2 = b[2] - b[0];
    const double h11 = b[0] - 2.0 * b[1] + b[3], h22 = b[0] - 2.0 * b[2] + b[5];
    const double h12 = b[0] - b[1] - b[2] + b[4];
    const double det = h11 * h22 - h12 * h12;
    const double u = (h12 * g2 - h22 * g1) / det, v = (h12 * g1 - h11 * g2) / det;
    if (u > 0.0 && v > 0.0 && u + v < 1.0) {
        add(b[0] + u * (2.0 * g1 + u * h11 + 2.0 * v * h12) + v * (2.0 * g2 + v * h22));
        // Bent one way only, it is extreme the other way at corners.
        constexpr double kWellBent = 1e-12;
        if (det > kWellBent * h11 * h22) return range;
    }
    const auto add_side = [&add](double p, double m, double q) {
        // p (1-t)^2 + 2 m t (1-t) + q t^2
        const double from = p - m, to = q - m;
        if (from * to > 0.0) add(p - from * from / (from + to));
    };
    add_side(b[0], b[1], b[3]);
    add_side(b[3], b[4], b[5]);
    add_side(b[5], b[2], b[0]);
    return range;
}

// Range of s^2 - t over a triangle: exactly that of the quadratic with the same values at corners
// and middles of sides, and the hull of what is left, which falls with the third power of the size.
Interval torus_range(const std::array<double, 10>& s, const std::array<double, 10>& t,
                     const std::array<Vec3, 3>& p)
{
    const Tables<3>& table = tables<3>();
    const auto bs = coefficients<3>(s, p), bt = coefficients<3>(t, p);
    std::array<double, 6> q{};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t at = table.pair[i][i];
        q[at] = bs[at] * bs[at] - bt[at];
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, ij = table.pair[i][j];
        const std::size_t ii = table.pair[i][i], jj = table.pair[j][j];
        const double sm = 0.25 * (bs[ii] + 2.0 * bs[ij] + bs[jj]);
        const double tm = 0.25 * (bt[ii] + 2.0 * bt[ij] + bt[jj]);
        q[ij] = 2.0 * (sm * sm - tm) - 0.5 * (q[ii] + q[jj]);
    }
    std::array<double, Tables<3>::kQuartic> rest{};
    for (std::size_t i = 0; i < bs.size(); ++i)
        for (std::size_t j = 0; j < bs.size(); ++j)
            rest[table.slot[i][j]] += table.weight[i][j] * (bs[i] * bs[j] - bt[i] - q[i]);
    const auto [lo, hi] = std::minmax_element(rest.begin(), rest.end());
    const Interval range = exact_range(q);
    return {range.lo + *lo, range.hi + *hi};
}

template <class Coefficients>
Interval hull_of(const Coefficients& b, double scale, double slack)
{
    const auto [lo, hi] = std::minmax_element(b.begin(), b.end());
    return {*lo * scale - slack, *hi * scale + slack};
}

// Range of a quadratic over a triangle: where the critical point comes out wrong by e of the
// simplex, the value does by e^2 of the spread; where the equations are too close to singular for
// that, the hull stands.
Interval quadratic_range(const std::array<double, 10>& q, const std::array<Vec3, 3>& p,
                         double slack)
{
    const auto b = coefficients<3>(q, p);
    const Interval hull = hull_of(b, 1.0, slack);
    if (hull.lo > 0.0 || hull.hi < 0.0) return hull;
    const Interval range = exact_range(b);
    const double margin = slack + 1e-9 * (hull.hi - hull.lo);
    return {std::max(hull.lo, range.lo - margin), std::min(hull.hi, range.hi + margin)};
}

// The same over the hull of up to eight points: a quadratic form at a mean of points is the same
// mean of its polar form at their pairs.
Interval quadratic_range(const std::array<double, 10>& q, std::span<const Vec3> p, bool is_linear,
                         double slack)
{
    std::array<double, 8> value{};
    require(p.size() <= value.size(), "range: at most eight points");
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    const auto add = [&](double x) {
        lo = std::min(lo, x);
        hi = std::max(hi, x);
    };
    for (std::size_t i = 0; i < p.size(); ++i) add(value[i] = evaluate(q, p[i]));
    if (!is_linear)
        for (std::size_t i = 0; i < p.size(); ++i)
            for (std::size_t j = i + 1; j < p.size(); ++j)
                add(2.0 * evaluate(q, 0.5 * (p[i] + p[j])) - 0.5 * (value[i] + value[j]));
    return {lo - slack, hi + slack};
}

template <std::size_t N>
std::array<Vec3, N> about(const Vec3& origin, std::array<Vec3, N> p)
{
    for (Vec3& v : p) v -= origin;
    return p;
}

// Largest difference between a quadratic and its linear interpolant: F - L has the edge
// coefficients e_ij alone, and the sum of 2 l_i l_j over pairs is at most 3/4.
double linear_error_of(const std::array<double, 10>& q, const std::array<Vec3, 4>& p)
{
    const auto b = coefficients<4>(q, p);
    const auto& pair = tables<4>().pair;
    double most = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j)
            most = std::max(most, std::fabs(b[pair[i][j]] - 0.5 * (b[pair[i][i]] + b[pair[j][j]])));
    return 0.75 * most;
}

std::array<double, 10> polynomial_of(const QuadraticModel& m)
{
    const auto& h = m.hessian;
    return {m.value,    m.gradient[0], m.gradient[1], m.gradient[2], 0.5 * h[0],
            0.5 * h[1], 0.5 * h[2],    h[3],          h[4],          h[5]};
}

// How far points of the box are from the middle of the model along each axis, at most.
Vec3 reach_of(const QuadraticModel& m, const Box3& box)
{
    Vec3 reach;
    for (std::size_t i = 0; i < 3; ++i)
        reach[i] = std::max(box.max[i] - m.at[i], m.at[i] - box.min[i]);
    return reach;
}

// How far the function may be from its model, with the rounding of the latter.
double slack_of(const QuadraticModel& m, const Box3& box)
{
    return m.rest + 64.0 * kEps * magnitude(polynomial_of(m), reach_of(m, box));
}

// The gradient of the function over the box.
IntervalVec3 slope_of(const QuadraticModel& m, const Box3& box)
{
    const std::array<double, 10> q = polynomial_of(m);
    const Vec3 reach = reach_of(m, box), size = magnitude_of_slope(q, reach);
    constexpr std::array<std::array<std::size_t, 3>, 3> place{{{4, 7, 8}, {7, 5, 9}, {8, 9, 6}}};
    IntervalVec3 slope;
    for (std::size_t i = 0; i < 3; ++i) {
        double change = m.slope_rest[i] + 64.0 * kEps * size[i];
        for (std::size_t j = 0; j < 3; ++j)
            change += (i == j ? 2.0 : 1.0) * std::fabs(q[place[i][j]]) * reach[j];
        slope[i] = {std::max(m.slope[i].lo, m.gradient[i] - change),
                    std::min(m.slope[i].hi, m.gradient[i] + change)};
    }
    return slope;
}

// Of a function with several pieces: L has the values of any of them at the corners.
double linear_error_of(const std::vector<QuadraticModel>& models, const Box3& box,
                       const std::array<Vec3, 4>& tet)
{
    const std::array<Vec3, 4> p = about(models[0].at, tet);
    double most = 0.0, apart = 0.0, slack = 0.0;
    for (const QuadraticModel& m : models) {
        std::array<double, 10> q = polynomial_of(m);
        most = std::max(most, linear_error_of(q, p));
        slack = std::max(slack, slack_of(m, box));
        const std::array<double, 10> first = polynomial_of(models[0]);
        for (std::size_t i = 0; i < q.size(); ++i) q[i] -= first[i];
        for (const double b : coefficients<4>(q, p)) apart = std::max(apart, std::fabs(b));
    }
    return most + 2.0 * (apart + slack);
}

// Rounding of the function at most points of the box, with a reserve.
double typical_slack(const Function& function, const Box3& box)
{
    constexpr int kSteps = 4;
    constexpr double kReserve = 16.0;
    std::vector<double> found;
    for (int n = 0; n < kSteps * kSteps * kSteps; ++n) {
        const std::array<int, 3> at{n % kSteps, n / kSteps % kSteps, n / (kSteps * kSteps)};
        Vec3 p;
        for (std::size_t i = 0; i < 3; ++i)
            p[i] = box.min[i] + (at[i] + 0.5) / kSteps * (box.max[i] - box.min[i]);
        const double error = function.rounding_error({p, p});
        if (std::isfinite(error)) found.push_back(error);
    }
    if (found.empty()) return kEps * box.diagonal();
    const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
    std::nth_element(found.begin(), middle, found.end());
    return kReserve * *middle + kEps * kEps * box.diagonal();
}

Box3 box_round(std::span<const Vec3> hull)
{
    Box3 box;
    for (const Vec3& p : hull) box.add(p);
    return box;
}

// The Gaussian curvature of a quadric has the sign opposite to that of its 4 by 4 matrix
// everywhere.
bool is_saddle(const QuadraticPolynomial& c)
{
    const Vec3 x{{c[4], 0.5 * c[7], 0.5 * c[8]}}, y{{0.5 * c[7], c[5], 0.5 * c[9]}},
        z{{0.5 * c[8], 0.5 * c[9], c[6]}}, w{{0.5 * c[1], 0.5 * c[2], 0.5 * c[3]}};
    // c0 det A - w.adj(A) w, A symmetric with columns x, y, z.
    const double det = c[0] * dot(x, cross(y, z)) -
                       dot(w, w[0] * cross(y, z) + w[1] * cross(z, x) + w[2] * cross(x, y));
    const double size = std::max({norm(x), norm(y), norm(z)});
    return det > 1e-9 * size * size * (std::fabs(c[0]) * size + dot(w, w));
}

}  // namespace

SurfaceForm::SurfaceForm(const Surface& surface, const Box3& box)
    : kind_(surface.kind), function_(surface.function), origin_(box.center())
{
    if (function_) {
        slack_ = typical_slack(*function_, box);
        return;
    }
    if (kind_ == Surface::Kind::Torus) {
        may_be_saddle_ = true;
        const Torus& torus = *surface.torus;
        const auto& place = torus.placement().m;
        const auto& local = torus.to_local().m;
        origin_ = {{place[0][3], place[1][3], place[2][3]}};
        // Squares of the local coordinates as quadratics.
        for (int axis = 0; axis < 3; ++axis) {
            const double a = local[axis][0], b = local[axis][1], c = local[axis][2];
            const Quadratic sq{0, 0, 0, 0, a * a, b * b, c * c, 2 * a * b, 2 * a * c, 2 * b * c};
            for (std::size_t i = 0; i < 10; ++i) {
                s_[i] += sq[i];
                if (axis < 2) t_[i] += 4.0 * torus.R() * torus.R() * sq[i];
            }
        }
        s_[0] = (torus.R() - torus.r()) * (torus.R() + torus.r());
        const double stretch = std::cbrt(std::fabs(determinant(torus.to_local())));
        scale_ = 1.0 / (8.0 * torus.R() * torus.R() * torus.r() * stretch);
    } else {
        const Quadric moved = transformed(surface.quadric, translation(-origin_));
        const auto p = moved.polynomial();
        q_ = {p[9], p[6], p[7], p[8], p[0], p[1], p[2], p[3], p[4], p[5]};
        if (is_plane()) note_axis(surface.quadric.polynomial());
        may_be_saddle_ = !is_plane() && is_saddle(q_);
    }
    Vec3& m = reach_;
    for (std::size_t i = 0; i < 3; ++i)
        m[i] = std::max(std::fabs(box.min[i] - origin_[i]), std::fabs(box.max[i] - origin_[i]));
    const double ms = magnitude(s_, m);
    const double all =
        kind_ == Surface::Kind::Torus ? scale_ * (ms * ms + magnitude(t_, m)) : magnitude(q_, m);
    // A point's coordinates are themselves rounded when the origin is taken off.
    slack_ = 64.0 * kEps * all;
    for (std::size_t i = 0; i < 3; ++i) {
        const double slope_s = magnitude_of_slope(s_, m)[i];
        const double slope_t = magnitude_of_slope(t_, m)[i];
        gradient_slack_ =
            std::max({gradient_slack_, 64.0 * kEps * scale_ * (2.0 * ms * slope_s + slope_t),
                      64.0 * kEps * magnitude_of_slope(q_, m)[i]});
    }
}

void SurfaceForm::note_axis(const std::array<double, 10>& polynomial)
{
    const double* slope = &polynomial[6];
    for (int k = 0; k < 3; ++k)
        if (slope[k] != 0.0 && slope[(k + 1) % 3] == 0.0 && slope[(k + 2) % 3] == 0.0) {
            across_ = k;
            place_ = 0.0 - polynomial[9] / slope[k];
        }
}

// The second derivatives at p times a step.
Vec3 SurfaceForm::second_along(const Vec3& p, const Vec3& step) const
{
    if (is_quadratic()) return slope(second_order(q_), step);
    const Vec3 u = p - origin_, s = slope(s_, u);
    return scale_ * (2.0 * evaluate(s_, u) * slope(second_order(s_), step) +
                     2.0 * dot(s, step) * s - slope(second_order(t_), step));
}

// With the second fundamental form M in the plane at the middle, det M < 0: |M| is
// (M M - det M) / |difference of the curvatures|. Where a torus changes its side one of them is
// zero, and is so at this place alone.
double SurfaceForm::sagitta_on_saddle(const Vec3& p, const Vec3& q) const
{
    const Vec3 middle = 0.5 * (p + q), e = q - p, g = gradient(middle);
    const double size = norm(g);
    const Vec3 across = cross(g, e);
    const double turn = norm(across);
    if (!(turn > 0.0)) return distance(middle);
    // Along the chord, as far as it is in the plane, and across.
    const Vec3 u = cross(across, g) / (turn * size), v = across / turn;
    const Vec3 at_u = second_along(middle, u), at_v = second_along(middle, v);
    const double a = dot(u, at_u) / size, b = dot(u, at_v) / size, c = dot(v, at_v) / size;
    const double det = a * c - b * b, spread = std::hypot(a - c, 2.0 * b);
    const double most = 0.5 * (std::fabs(a + c) + spread);
    const double curvature =
        std::max(kFlattest * most, det < 0.0 ? (a * a + b * b - det) / spread : 0.0);
    const double along = turn / size;  // the length of the chord in the plane
    return std::max(distance(middle), 0.125 * along * along * curvature);
}

double SurfaceForm::other_value(const Vec3& p) const
{
    if (function_) return function_->value(p);
    const Vec3 u = p - origin_;
    const double s = evaluate(s_, u);
    return scale_ * (s * s - evaluate(t_, u));
}

Sign SurfaceForm::sign(const Vec3& p) const
{
    const Interval at = function_ ? function_->bound({p, p}) : Interval(value(p));
    const double margin = function_ ? 0.0 : slack_;
    return at.lo > margin ? Sign{1} : at.hi < -margin ? Sign{-1} : Sign{0};
}

Vec3 SurfaceForm::other_gradient(const Vec3& p) const
{
    if (function_) return function_->gradient(p);
    const Vec3 u = p - origin_;
    return scale_ * (2.0 * evaluate(s_, u) * slope(s_, u) - slope(t_, u));
}

template <class RangeOf>
Interval SurfaceForm::function_range(std::span<const Vec3> hull, const RangeOf& range_of) const
{
    const Box3 box = box_round(hull);
    const Interval natural = function_->bound(box);
    if (natural.lo > 0.0 || natural.hi < 0.0) return natural;
    const std::vector<QuadraticModel> models = function_->quadratic_models(box);
    Interval range = models.empty() ? mean_range(hull, box)
                                    : Interval(std::numeric_limits<double>::infinity(),
                                               -std::numeric_limits<double>::infinity());
    for (const QuadraticModel& m : models)
        range = genus::hull(range, range_of(polynomial_of(m), m.at, slack_of(m, box)));
    return {std::max(natural.lo, range.lo), std::min(natural.hi, range.hi)};
}

// F over a hull is F at its middle and the gradient times the way to the corners, as what is linear
// on the hull is extreme there.
Interval SurfaceForm::mean_range(std::span<const Vec3> hull, const Box3& box) const
{
    const Vec3 middle = box.center();
    const IntervalVec3 g = function_->gradient_bound(box);
    const Interval centre = function_->bound({middle, middle});
    Interval mean(std::numeric_limits<double>::infinity(),
                  -std::numeric_limits<double>::infinity());
    for (const Vec3& p : hull) {
        Interval change = centre;
        for (std::size_t i = 0; i < 3; ++i)
            change = change + g[i] * (Interval(p[i]) - Interval(middle[i]));
        mean = genus::hull(mean, change);
    }
    return mean;
}

Interval SurfaceForm::range(const std::array<Vec3, 3>& triangle) const
{
    if (function_)
        return function_range(triangle, [&](const Quadratic& q, const Vec3& at, double slack) {
            return quadratic_range(q, about(at, triangle), slack);
        });
    const std::array<Vec3, 3> p{triangle[0] - origin_, triangle[1] - origin_,
                                triangle[2] - origin_};
    if (is_plane()) {
        const std::array<double, 3> b{evaluate(q_, p[0]), evaluate(q_, p[1]), evaluate(q_, p[2])};
        return hull_of(b, 1.0, slack_);
    }
    if (kind_ == Surface::Kind::Quadric)
        return range(triangle, {evaluate(q_, p[0]), evaluate(q_, p[1]), evaluate(q_, p[2])});
    const Interval hull = hull_of(torus_coefficients<3>(s_, t_, p), scale_, slack_);
    if (hull.lo > 0.0 || hull.hi < 0.0) return hull;
    const Interval range = torus_range(s_, t_, p);
    const double margin = slack_ + 1e-9 * (hull.hi - hull.lo);
    return {std::max(hull.lo, scale_ * range.lo - margin),
            std::min(hull.hi, scale_ * range.hi + margin)};
}

Interval SurfaceForm::range(const std::array<Vec3, 3>& triangle,
                            const std::array<double, 3>& values) const
{
    if (!is_quadratic()) return range(triangle);
    const std::array<double, 3> k = bends(triangle);
    const std::array<double, 6> b{
        values[0], 0.5 * (values[0] + values[1] - k[0]), 0.5 * (values[0] + values[2] - k[2]),
        values[1], 0.5 * (values[1] + values[2] - k[1]), values[2]};
    const Interval hull = hull_of(b, 1.0, 0.0);
    double lo = hull.lo, hi = hull.hi;
    const double margin = 1e-9 * (hi - lo);
    if (lo <= margin && hi >= -margin) {
        // Where the critical point comes out wrong by e of the simplex, the value does by e^2 of
        // the spread.
        const Interval exact = exact_range(b);
        lo = std::max(lo, exact.lo - margin);
        hi = std::min(hi, exact.hi + margin);
    }
    return {lo - slack_, hi + slack_};
}

std::array<double, 3> SurfaceForm::other_bends(const std::array<Vec3, 3>& triangle) const
{
    constexpr double kReserve = 1.05;
    const std::array<double, 3> at{value(triangle[0]), value(triangle[1]), value(triangle[2])};
    std::array<double, 3> k;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        const double middle = value(0.5 * (triangle[i] + triangle[j]));
        k[i] = kReserve * (2.0 * (at[i] + at[j]) - 4.0 * middle);
    }
    return k;
}

Interval SurfaceForm::range(const std::array<Vec3, 4>& tet) const
{
    if (function_)
        return function_range(tet, [&](const Quadratic& q, const Vec3& at, double slack) {
            return hull_of(coefficients<4>(q, about(at, tet)), 1.0, slack);
        });
    const std::array<Vec3, 4> p{tet[0] - origin_, tet[1] - origin_, tet[2] - origin_,
                                tet[3] - origin_};
    if (is_plane()) {
        const std::array<double, 4> b{evaluate(q_, p[0]), evaluate(q_, p[1]), evaluate(q_, p[2]),
                                      evaluate(q_, p[3])};
        return hull_of(b, 1.0, slack_);
    }
    if (kind_ == Surface::Kind::Quadric) return hull_of(coefficients<4>(q_, p), 1.0, slack_);
    return hull_of(torus_coefficients<4>(s_, t_, p), scale_, slack_);
}

Interval SurfaceForm::range(std::span<const Vec3> hull) const
{
    std::array<Vec3, 8> p;
    require(hull.size() <= p.size(), "range: at most eight points");
    const auto about_point = [&](const Vec3& origin) {
        for (std::size_t i = 0; i < hull.size(); ++i) p[i] = hull[i] - origin;
        return std::span<const Vec3>(p).first(hull.size());
    };
    if (function_)
        return function_range(hull, [&](const Quadratic& q, const Vec3& at, double slack) {
            return quadratic_range(q, about_point(at), false, slack);
        });
    if (kind_ == Surface::Kind::Torus) return range(box_round(hull));
    return quadratic_range(q_, about_point(origin_), is_plane(), slack_);
}

double SurfaceForm::least_slope(std::span<const Vec3> hull, const Vec3& direction,
                                double sign) const
{
    const double margin = 2.0 * gradient_slack_ * norm(direction);
    if (!is_quadratic()) {
        const IntervalVec3 g = gradient_range(box_round(hull));
        const Interval slope = (g[0] * direction[0] + g[1] * direction[1] + g[2] * direction[2]);
        return (slope * sign).lo - margin;
    }
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3& p : hull) least = std::min(least, sign * dot(gradient(p), direction));
    return least - margin;
}

// From c + x after a share t of the way to c + s up, s = 1 or -1, the way goes on along s up - x.
// With gradient g at c and second derivatives H, F grows there at s times the rate
//   g.up - g.y + s (1 - t) (y.H up - y.H y) + s t (up.H up - up.H y),   y = s x,
// which is linear in t and, but for y.H y, in y.
bool SurfaceForm::grows_towards(const Vec3& c, const Vec3& half, const Vec3& up, const Box3& hull,
                                double sign) const
{
    if (!is_quadratic()) {
        const IntervalVec3 g = gradient_range(hull), way = to_intervals({up - half, up + half});
        return ((g[0] * way[0] + g[1] * way[1] + g[2] * way[2]) * sign).lo > 0.0;
    }
    const Quadratic bends = second_order(q_);
    const Vec3 g = sign * gradient(c), h = sign * slope(bends, up);
    const double along = dot(g, up), bent = dot(h, up);
    // The least of v.y + k y.H y over the box.
    const auto least_of = [&](const Vec3& v, double k) {
        Quadratic q = bends;
        for (double& x : q) x *= 2.0 * k * sign;
        for (std::size_t i = 0; i < 3; ++i) q[1 + i] = v[i];
        return range_round(q, Vec3{}, half).lo;
    };
    const double least = along + std::min({least_of(h - g, -1.0), bent + least_of(-(g + h), 0.0),
                                           least_of(-(g + h), 1.0), -bent + least_of(h - g, 0.0)});
    Vec3 most;
    for (std::size_t i = 0; i < 3; ++i)
        most[i] = std::fabs(c[i] - origin_[i]) + half[i] + std::fabs(up[i]);
    const Vec3 slopes = magnitude_of_slope(q_, most);
    double rounding = 0.0;
    for (std::size_t i = 0; i < 3; ++i) rounding += slopes[i] * (half[i] + std::fabs(up[i]));
    return least > 256.0 * kEps * rounding;
}

std::optional<double> SurfaceForm::root_along(const Vec3& p, const Vec3& direction) const
{
    double t = 0.0;
    if (is_quadratic()) {
        // F(p + t d) = f + g t + h t^2; the root nearest to 0 without cancellation.
        const double f = value(p), g = dot(gradient(p), direction);
        const double h = bend(direction);
        const double discriminant = g * g - 4.0 * f * h;
        if (!(discriminant >= 0.0)) return std::nullopt;
        const double sum = g + std::copysign(std::sqrt(discriminant), g);
        if (sum == 0.0) return std::nullopt;
        t = -2.0 * f / sum;
    }
    // The closed form is polished; others are all Newton.
    const int steps = is_quadratic() ? 2 : 20;
    for (int step = 0; step < steps; ++step) {
        const Vec3 at = p + t * direction;
        const double f = value(at);
        if (std::fabs(f) <= 0.0625 * slack_) return t;
        const double move = f / dot(gradient(at), direction);
        if (!std::isfinite(move)) return std::nullopt;
        t -= move;
    }
    if (!(std::fabs(value(p + t * direction)) <= slack_)) return std::nullopt;
    return t;
}

Interval SurfaceForm::range(const Box3& box) const
{
    if (function_) {
        const std::array<Vec3, 2> ends{box.min, box.max};
        return function_range(ends, [&](const Quadratic& q, const Vec3& at, double slack) {
            Vec3 half;
            for (std::size_t i = 0; i < 3; ++i)
                half[i] = std::max(box.max[i] - at[i], at[i] - box.min[i]);
            const Interval r = range_round(q, Vec3{}, half);
            return Interval(r.lo - slack, r.hi + slack);
        });
    }
    if (kind_ != Surface::Kind::Torus) {
        const Vec3 c = box.center() - origin_, half = 0.5 * box.size();
        Vec3 most;
        for (std::size_t i = 0; i < 3; ++i) most[i] = std::fabs(c[i]) + half[i];
        const bool within = most[0] <= reach_[0] && most[1] <= reach_[1] && most[2] <= reach_[2];
        const double margin = within ? slack_ : std::max(slack_, 64.0 * kEps * magnitude(q_, most));
        const Interval r = range_round(q_, c, half);
        return {r.lo - margin, r.hi + margin};
    }
    // Mean value form beside the natural one.
    const IntervalVec3 b = to_intervals({box.min - origin_, box.max - origin_});
    const Vec3 half = 0.5 * box.size();
    const IntervalVec3 g = gradient_range(box);
    const Interval natural = (square(range_of(s_, b)) - range_of(t_, b)) * scale_;
    const Interval mean = Interval(value(box.center())) + g[0] * Interval(-half[0], half[0]) +
                          g[1] * Interval(-half[1], half[1]) + g[2] * Interval(-half[2], half[2]);
    return {std::max(natural.lo, mean.lo) - slack_, std::min(natural.hi, mean.hi) + slack_};
}

IntervalVec3 SurfaceForm::gradient_range(const Box3& box) const
{
    if (function_) {
        const std::vector<QuadraticModel> models = function_->quadratic_models(box);
        if (models.empty()) return function_->gradient_bound(box);
        IntervalVec3 slope = slope_of(models[0], box);
        for (const QuadraticModel& m : models) {
            const IntervalVec3 other = slope_of(m, box);
            for (std::size_t i = 0; i < 3; ++i) slope[i] = hull(slope[i], other[i]);
        }
        return slope;
    }
    const IntervalVec3 b = to_intervals({box.min - origin_, box.max - origin_});
    if (kind_ != Surface::Kind::Torus) return slope_range(q_, b);
    const Interval s = range_of(s_, b);
    const IntervalVec3 gs = slope_range(s_, b), gt = slope_range(t_, b);
    // Beside the natural form the gradient at the centre plus Hessian times step, the Hessian
    // being 2 gs gs^T + 2 s Hs - Ht.
    const Vec3 at_centre = gradient(box.center()), half = 0.5 * box.size();
    constexpr std::array<std::array<std::size_t, 3>, 3> mixed{{{4, 7, 8}, {7, 5, 9}, {8, 9, 6}}};
    IntervalVec3 g;
    for (std::size_t i = 0; i < 3; ++i) {
        const Interval natural = (s * gs[i] * 2.0 - gt[i]) * scale_;
        Interval mean(at_centre[i] - gradient_slack_, at_centre[i] + gradient_slack_);
        for (std::size_t j = 0; j < 3; ++j) {
            const double twice = i == j ? 2.0 : 1.0;
            const Interval h = gs[i] * gs[j] * 2.0 + s * (2.0 * twice * s_[mixed[i][j]]) -
                               Interval(twice * t_[mixed[i][j]]);
            mean = mean + h * Interval(-half[j], half[j]) * scale_;
        }
        g[i] = {std::max(natural.lo, mean.lo), std::min(natural.hi, mean.hi)};
    }
    return g;
}

double SurfaceForm::linear_error(const std::array<Vec3, 4>& tet) const
{
    if (is_plane()) return 0.0;
    if (function_) {
        const Box3 box = box_round(tet);
        const std::vector<QuadraticModel> models = function_->quadratic_models(box);
        if (!models.empty()) return linear_error_of(models, box, tet);
        // F - L is a mean of (g - g0) . (p - corner), g in the bounds of the gradient and g0 its
        // middle; along an axis the mean of |p - corner| is at most half the width.
        const IntervalVec3 g = function_->gradient_bound(box);
        double error = 0.0;
        for (std::size_t i = 0; i < 3; ++i) error += 0.25 * g[i].width() * box.size()[i];
        return error * (1.0 + 8.0 * kEps) + slack_;
    }
    const std::array<Vec3, 4> p{tet[0] - origin_, tet[1] - origin_, tet[2] - origin_,
                                tet[3] - origin_};
    double most = 0.0;
    if (kind_ == Surface::Kind::Quadric) return linear_error_of(q_, p);
    const auto b = torus_coefficients<4>(s_, t_, p);
    const auto& table = tables<4>();
    std::array<double, 4> corner{};
    for (std::size_t s = 0; s < b.size(); ++s)
        for (std::size_t i = 0; i < 4; ++i)
            if (table.exponent[s][i] == 4) corner[i] = b[s];
    for (std::size_t s = 0; s < b.size(); ++s) {
        double linear = 0.0;
        for (std::size_t i = 0; i < 4; ++i) linear += 0.25 * table.exponent[s][i] * corner[i];
        most = std::max(most, std::fabs(b[s] - linear));
    }
    return scale_ * most;
}

namespace {

// Solves the k x k system a x = b by elimination with full row pivoting; false if it is singular
// to rounding.
bool solve_small(std::array<std::array<double, 3>, 3> a, std::array<double, 3>& b, std::size_t k)
{
    double largest = 0.0;
    for (std::size_t i = 0; i < k; ++i) largest = std::max(largest, std::fabs(a[i][i]));
    for (std::size_t col = 0; col < k; ++col) {
        std::size_t pivot = col;
        for (std::size_t r = col + 1; r < k; ++r)
            if (std::fabs(a[r][col]) > std::fabs(a[pivot][col])) pivot = r;
        if (!(std::fabs(a[pivot][col]) > 1e-13 * largest)) return false;
        std::swap(a[pivot], a[col]);
        std::swap(b[pivot], b[col]);
        for (std::size_t r = col + 1; r < k; ++r) {
            const double f = a[r][col] / a[col][col];
            for (std::size_t c = col; c < k; ++c) a[r][c] -= f * a[col][c];
            b[r] -= f * b[col];
        }
    }
    for (std::size_t i = k; i-- > 0;) {
        for (std::size_t c = i + 1; c < k; ++c) b[i] -= a[i][c] * b[c];
        b[i] /= a[i][i];
    }
    return true;
}

}  // namespace

std::optional<Vec3> shortest_direction(std::span<const Vec3> normals,
                                       std::span<const double> demands)
{
    // By the optimality conditions d is a combination of at most three normals with factors >= 0,
    // each of whose demands it just meets.
    const std::size_t n = normals.size();
    std::optional<Vec3> best;
    double best_length = 1000.0;
    const auto attempt = [&](const std::array<std::size_t, 3>& pick, std::size_t k) {
        std::array<std::array<double, 3>, 3> gram{};
        std::array<double, 3> factor{};
        for (std::size_t i = 0; i < k; ++i) {
            factor[i] = demands[pick[i]];
            for (std::size_t j = 0; j < k; ++j)
                gram[i][j] = dot(normals[pick[i]], normals[pick[j]]);
        }
        if (!solve_small(gram, factor, k)) return;
        Vec3 d;
        for (std::size_t i = 0; i < k; ++i) {
            if (factor[i] < 0.0) return;
            d += factor[i] * normals[pick[i]];
        }
        const double length = norm(d);
        if (!(length < best_length)) return;
        for (std::size_t i = 0; i < n; ++i)
            if (dot(normals[i], d) < demands[i] - 1e-9 * (1.0 + length)) return;
        best = d;
        best_length = length;
    };
    attempt({}, 0);
    for (std::size_t i = 0; i < n; ++i) {
        attempt({i}, 1);
        for (std::size_t j = i + 1; j < n; ++j) {
            attempt({i, j}, 2);
            for (std::size_t k = j + 1; k < n; ++k) attempt({i, j, k}, 3);
        }
    }
    return best;
}

std::optional<Vec3> project(std::span<const SurfaceForm* const> surfaces, const Vec3& start,
                            double reach)
{
    const std::size_t k = surfaces.size();
    const auto settled = [&](Vec3 p) {
        for (const SurfaceForm* s : surfaces) p = s->straightened(p);
        return p;
    };
    Vec3 p = start;
    double before = std::numeric_limits<double>::infinity();
    for (int step = 0; step < 40; ++step) {
        std::array<double, 3> f{};
        std::array<Vec3, 3> g;
        std::array<std::array<double, 3>, 3> gram{};
        bool there = true;
        for (std::size_t i = 0; i < k; ++i) {
            f[i] = surfaces[i]->value(p);
            g[i] = surfaces[i]->gradient(p);
            there = there && std::fabs(f[i]) <= 0.0625 * surfaces[i]->slack();
        }
        if (there && step > 0) return settled(p);
        for (std::size_t i = 0; i < k; ++i)
            for (std::size_t j = 0; j < k; ++j) gram[i][j] = dot(g[i], g[j]);
        if (!solve_small(gram, f, k)) return std::nullopt;
        Vec3 move;
        for (std::size_t i = 0; i < k; ++i) move -= f[i] * g[i];
        const double length = norm(move);
        if (!std::isfinite(length)) return std::nullopt;
        // At rounding level the steps no longer shrink.
        if (length >= 0.5 * before && there) return settled(p);
        before = length;
        p += move;
        if (!(distance(p, start) <= reach)) return std::nullopt;
    }
    for (std::size_t i = 0; i < k; ++i)
        if (std::fabs(surfaces[i]->value(p)) > surfaces[i]->slack()) return std::nullopt;
    return settled(p);
}

}  // namespace genus
