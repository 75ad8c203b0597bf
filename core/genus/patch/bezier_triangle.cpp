#include "genus/patch/bezier_triangle.h"

#include <limits>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/patch/bulk.h"
#include "genus/patch/control_points.h"

namespace genus {

namespace {

std::size_t size_of(int n)
{
    return static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n + 2) / 2;
}

// One step of de Casteljau: degree n to n - 1, at barycentric coordinates (u, v, w).
template <class V>
std::vector<V> step(std::span<const V> c, int n, double u, double v, double w)
{
    std::vector<V> r(size_of(n - 1));
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n - i; ++j)
            r[BezierTriangle::index(n - 1, i, j)] = c[BezierTriangle::index(n, i + 1, j)] * u +
                                                    c[BezierTriangle::index(n, i, j + 1)] * v +
                                                    c[BezierTriangle::index(n, i, j)] * w;
    return r;
}

// `times` steps with the same coordinates; with u + v + w = 0 these are derivatives up to a factor.
template <class V>
std::vector<V> steps(std::vector<V> c, int n, int times, double u, double v, double w)
{
    for (int k = 0; k < times; ++k) c = step<V>(c, n - k, u, v, w);
    return c;
}

// Partial derivatives (a, b) by u and v; zero above the degree.
template <class V>
V partial(const std::vector<V>& c, int n, double u, double v, int a, int b)
{
    if (a + b > n) return V{};
    double factor = 1.0;
    for (int k = 0; k < a + b; ++k) factor *= n - k;
    auto d = steps(c, n, a, 1.0, 0.0, -1.0);
    d = steps(std::move(d), n - a, b, 0.0, 1.0, -1.0);
    return steps(std::move(d), n - a - b, n - a - b, u, v, 1.0 - u - v)[0] * factor;
}

template <class V>
V triangle_value(const std::vector<V>& c, int n, double u, double v)
{
    return steps(c, n, n, u, v, 1.0 - u - v)[0];
}

template <class F>
BezierTriangle with_points(const BezierTriangle& t, int n, const F& f)
{
    if (t.rational()) return BezierTriangle::from_homogeneous(n, f(t.homogeneous()));
    return BezierTriangle(n, f(t.points()));
}

}  // namespace

BezierTriangle::BezierTriangle(int n, std::vector<Vec3> points, std::vector<double> weights)
    : n_(n), points_(std::move(points)), weights_(std::move(weights))
{
    require(n >= 0 && n <= kMaxDegree, "BezierTriangle: degree", n, "in [0, 512]");
    require(points_.size() == size_of(n), "BezierTriangle: number of points",
            static_cast<double>(points_.size()), "(n + 1) (n + 2) / 2");
    control::check("BezierTriangle", points_, weights_);
}

BezierTriangle BezierTriangle::from_homogeneous(int n, std::span<const Vec4> points)
{
    auto [p, w] = control::projected("BezierTriangle", points);
    return BezierTriangle(n, std::move(p), std::move(w));
}

std::vector<Vec4> BezierTriangle::homogeneous() const
{
    return control::homogeneous(points_, weights_);
}

Vec3 BezierTriangle::value(double u, double v) const
{
    if (!rational()) return triangle_value(points_, n_, u, v);
    const Vec4 h = triangle_value(homogeneous(), n_, u, v);
    return {{h[0] / h[3], h[1] / h[3], h[2] / h[3]}};
}

Bounded<3> BezierTriangle::value_with_bound(double u, double v) const
{
    if (!rational()) return bernstein::triangle_value_with_bound(points_, n_, u, v);
    return bernstein::triangle_value_with_bound(homogeneous(), n_, u, v,
                                                0.5 * std::numeric_limits<double>::epsilon());
}

SurfacePoint BezierTriangle::partials(double u, double v) const
{
    if (!rational()) {
        const auto d = [&](int a, int b) { return partial(points_, n_, u, v, a, b); };
        return {d(0, 0), d(1, 0), d(0, 1), d(2, 0), d(1, 1), d(0, 2)};
    }
    const auto h = homogeneous();
    const auto d = [&](int a, int b) { return partial(h, n_, u, v, a, b); };
    return projected(d(0, 0), d(1, 0), d(0, 1), d(2, 0), d(1, 1), d(0, 2));
}

Vec3 BezierTriangle::normal(double u, double v) const
{
    if (auto usual = control::of_usual_size(points_))
        return BezierTriangle(n_, std::move(*usual), weights_).normal(u, v);
    const SurfacePoint s = partials(u, v);
    const Vec3 n = cross(s.pu, s.pv);
    const double least = 1e-9 * bounds().diagonal();
    if (norm(n) > 1e-9 * norm(s.pu) * norm(s.pv) && norm(s.pu) > least && norm(s.pv) > least)
        return normalized(n);
    return limit(u, v);
}

// Taylor coefficients along the line to the middle: the k-th is binomial(n, k) times the polar
// form at k copies of the direction and n - k of the point.
Vec3 BezierTriangle::limit(double u, double v) const
{
    Vec2 d = {{1.0 / 3 - u, 1.0 / 3 - v}};
    if (norm(d) < 0.1) d = {{0.3, 0.2}};
    const auto taylor = [&](const std::vector<Vec4>& c, int n) {
        std::vector<Vec4> t;
        std::vector<Vec4> along = c;
        for (int k = 0; k <= n; ++k) {
            t.push_back(bernstein::binomial(n, k) *
                        steps(along, n - k, n - k, u, v, 1.0 - u - v)[0]);
            if (k < n) along = step<Vec4>(along, n - k, d[0], d[1], -d[0] - d[1]);
        }
        return t;
    };
    if (n_ == 0) return {};
    const auto h = homogeneous();
    return limit_normal(taylor(h, n_), taylor(step<Vec4>(h, n_, 1.0, 0.0, -1.0), n_ - 1),
                        taylor(step<Vec4>(h, n_, 0.0, 1.0, -1.0), n_ - 1));
}

namespace {

void run_bulk(const BezierTriangle& t, std::span<const double> u, std::span<const double> v,
              std::span<Vec3> points, std::span<Vec3> normals)
{
    const std::vector<Vec4> h = t.rational() ? t.homogeneous() : std::vector<Vec4>();
    const double* c = t.rational() ? h[0].c.data() : t.points()[0].c.data();
    parallel_for(u.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
        bulk::triangle(c, t.degree(), t.rational() ? 4 : 3, u.data() + begin, v.data() + begin,
                       end - begin, points[begin].c.data(),
                       normals.empty() ? nullptr : normals[begin].c.data());
        for (std::size_t i = begin; i < end && !normals.empty(); ++i)
            if (normals[i] == Vec3{}) normals[i] = t.normal(u[i], v[i]);
    });
}

}  // namespace

void BezierTriangle::evaluate(std::span<const double> u, std::span<const double> v,
                              std::span<Vec3> points) const
{
    require(u.size() == v.size() && u.size() == points.size(),
            "BezierTriangle::evaluate: u, v and points must be equally long");
    if (n_ == 0) return elevated().evaluate(u, v, points);
    run_bulk(*this, u, v, points, {});
}

void BezierTriangle::evaluate(std::span<const double> u, std::span<const double> v,
                              std::span<Vec3> points, std::span<Vec3> normals) const
{
    require(u.size() == v.size() && u.size() == points.size() && u.size() == normals.size(),
            "BezierTriangle::evaluate: u, v, points and normals must be equally long");
    if (n_ == 0) return elevated().evaluate(u, v, points, normals);
    run_bulk(*this, u, v, points, normals);
    if (auto usual = control::of_usual_size(points_)) {
        std::vector<Vec3> elsewhere(points.size());
        run_bulk(BezierTriangle(n_, std::move(*usual), weights_), u, v, elsewhere, normals);
    }
}

BezierCurve BezierTriangle::edge(int k) const
{
    require(k >= 0 && k < 3, "BezierTriangle::edge: number", k, "in [0, 2]");
    std::vector<Vec3> p;
    std::vector<double> w;
    for (int s = 0; s <= n_; ++s) {
        const std::size_t i = k == 0   ? index(n_, s, 0)
                              : k == 1 ? index(n_, n_ - s, s)
                                       : index(n_, 0, n_ - s);
        p.push_back(points_[i]);
        if (rational()) w.push_back(weights_[i]);
    }
    return BezierCurve(std::move(p), std::move(w));
}

Vec2 BezierTriangle::on_edge(int k, double s)
{
    switch (k) {
        case 0:
            return {{s, 0.0}};
        case 1:
            return {{1.0 - s, s}};
        default:
            return {{0.0, 1.0 - s}};
    }
}

BezierTriangle BezierTriangle::part(const Vec2& a, const Vec2& b, const Vec2& c) const
{
    require(is_finite(a) && is_finite(b) && is_finite(c),
            "BezierTriangle::part: a corner is not finite");
    return with_points(*this, n_, [&](const auto& points) {
        using V = typename std::decay_t<decltype(points)>::value_type;
        std::vector<V> result(points.size());
        const auto times = [](const std::vector<V>& p, int n, int k, const Vec2& at) {
            return steps(p, n, k, at[0], at[1], 1.0 - at[0] - at[1]);
        };
        for (int i = 0; i <= n_; ++i) {
            const auto with_b = times(points, n_, i, b);
            for (int j = 0; j <= n_ - i; ++j) {
                const auto with_c = times(with_b, n_ - i, j, c);
                result[index(n_, i, j)] = times(with_c, n_ - i - j, n_ - i - j, a)[0];
            }
        }
        return result;
    });
}

std::array<BezierTriangle, 4> BezierTriangle::quartered() const
{
    const Vec2 o = {{0, 0}}, u = {{1, 0}}, v = {{0, 1}};
    const Vec2 ou = {{0.5, 0}}, uv = {{0.5, 0.5}}, vo = {{0, 0.5}};
    return {part(o, ou, vo), part(ou, u, uv), part(vo, uv, v), part(uv, vo, ou)};
}

BezierTriangle BezierTriangle::elevated(int by) const
{
    require(by >= 0 && n_ + by <= kMaxDegree, "BezierTriangle::elevated: new degree", n_ + by,
            "in [0, 512] and not below the old");
    if (by == 0) return *this;
    BezierTriangle once = with_points(*this, n_ + 1, [&](const auto& points) {
        using V = typename std::decay_t<decltype(points)>::value_type;
        const int n = n_ + 1;
        std::vector<V> result(size_of(n));
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n - i; ++j) {
                const int k = n - i - j;
                V sum{};
                if (i > 0) sum += points[index(n_, i - 1, j)] * (double(i) / n);
                if (j > 0) sum += points[index(n_, i, j - 1)] * (double(j) / n);
                if (k > 0) sum += points[index(n_, i, j)] * (double(k) / n);
                result[index(n, i, j)] = sum;
            }
        return result;
    });
    // (x w) / w need not be x; neighbours are recognised by their corners.
    once.points_.front() = points_.front();
    once.points_.back() = points_.back();
    once.points_[static_cast<std::size_t>(n_) + 1] = points_[static_cast<std::size_t>(n_)];
    return once.elevated(by - 1);
}

Box3 BezierTriangle::bounds() const
{
    return control::bounds(points_);
}

BezierTriangle transformed(const BezierTriangle& patch, const Transform& map)
{
    return BezierTriangle(patch.degree(), control::transformed(patch.points(), map),
                          patch.weights());
}

double c1_defect(const BezierTriangle& a, int ea, const BezierTriangle& b, int eb,
                 const Vec2& across)
{
    require(ea >= 0 && ea < 3 && eb >= 0 && eb < 3, "c1_defect: an edge number is not in [0, 2]");
    require(!a.rational() && !b.rational(), "c1_defect: the patches must be polynomial");
    require(a.degree() == b.degree() && a.degree() >= 1,
            "c1_defect: the patches must have the same degree, at least 1");
    const int n = a.degree();
    // b, turned so that the common edge is its edge 0, as a part of a's polynomial.
    const auto corner = [&](int e) { return BezierTriangle::on_edge(e, 0.0); };
    const BezierTriangle turned = b.part(corner(eb), corner((eb + 1) % 3), corner((eb + 2) % 3));
    const BezierTriangle wanted = a.part(corner((ea + 1) % 3), corner(ea), across);
    double worst = 0.0;
    for (int j = 0; j <= 1; ++j)
        for (int i = 0; i <= n - j; ++i)
            worst = std::max(worst, distance(turned.point(i, j), wanted.point(i, j)));
    return worst;
}

}  // namespace genus
