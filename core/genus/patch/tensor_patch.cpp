#include "genus/patch/tensor_patch.h"

#include <limits>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/patch/bulk.h"
#include "genus/patch/control_points.h"

namespace genus {

namespace {

std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

// A control net of any kind of point.
template <class V>
struct Net {
    int m, n;
    std::vector<V> c;

    std::vector<V> row(int i) const
    {
        const auto first = c.begin() + static_cast<std::ptrdiff_t>(i) * (n + 1);
        return std::vector<V>(first, first + n + 1);
    }
    Net transposed() const
    {
        Net t{n, m, std::vector<V>(c.size())};
        for (int i = 0; i <= m; ++i)
            for (int j = 0; j <= n; ++j)
                t.c[at(j) * at(m + 1) + at(i)] = c[at(i) * at(n + 1) + at(j)];
        return t;
    }
};

// Applies `f`, which maps n + 1 coefficients to others, to each row.
template <class V, class F>
Net<V> by_rows(const Net<V>& net, const F& f)
{
    Net<V> result{net.m, 0, {}};
    for (int i = 0; i <= net.m; ++i) {
        const std::vector<V> row = f(net.row(i));
        result.n = static_cast<int>(row.size()) - 1;
        result.c.insert(result.c.end(), row.begin(), row.end());
    }
    return result;
}

template <class V, class F>
Net<V> by_columns(const Net<V>& net, const F& f)
{
    return by_rows(net.transposed(), f).transposed();
}

// Partial derivatives (i, j) for i <= a, j <= b at [i (b + 1) + j].
template <class V>
std::vector<V> all_partials(const Net<V>& net, double u, double v, int a, int b)
{
    const auto rows = by_rows(
        net, [&](const std::vector<V>& row) { return bernstein::derivatives<V>(row, v, b); });
    return by_columns(rows,
                      [&](const std::vector<V>& column) {
                          return bernstein::derivatives<V>(column, u, a);
                      })
        .c;
}

template <class V>
Net<V> part_of(Net<V> net, double u0, double u1, double v0, double v1)
{
    if (v0 != 0.0 || v1 != 1.0)
        net = by_rows(
            net, [&](const std::vector<V>& row) { return bernstein::segment<V>(row, v0, v1); });
    if (u0 != 0.0 || u1 != 1.0)
        net = by_columns(net, [&](const std::vector<V>& column) {
            return bernstein::segment<V>(column, u0, u1);
        });
    return net;
}

// Runs `f` on the net of the patch, homogeneous if it is rational, and makes a patch of the result.
template <class F>
TensorPatch with_net(const TensorPatch& p, const F& f)
{
    if (p.rational()) {
        const Net<Vec4> net = f(Net<Vec4>{p.degree_u(), p.degree_v(), p.homogeneous()});
        return TensorPatch::from_homogeneous(net.m, net.n, net.c);
    }
    Net<Vec3> net = f(Net<Vec3>{p.degree_u(), p.degree_v(), p.points()});
    return TensorPatch(net.m, net.n, std::move(net.c));
}

}  // namespace

TensorPatch::TensorPatch(int m, int n, std::vector<Vec3> points, std::vector<double> weights)
    : m_(m), n_(n), points_(std::move(points)), weights_(std::move(weights))
{
    require(m >= 0 && m <= kMaxDegree, "TensorPatch: degree in u", m, "in [0, 512]");
    require(n >= 0 && n <= kMaxDegree, "TensorPatch: degree in v", n, "in [0, 512]");
    require(points_.size() == at(m + 1) * at(n + 1), "TensorPatch: number of points",
            static_cast<double>(points_.size()), "(m + 1) (n + 1)");
    control::check("TensorPatch", points_, weights_);
}

TensorPatch TensorPatch::from_homogeneous(int m, int n, std::span<const Vec4> points)
{
    auto [p, w] = control::projected("TensorPatch", points);
    return TensorPatch(m, n, std::move(p), std::move(w));
}

std::vector<Vec4> TensorPatch::homogeneous() const
{
    return control::homogeneous(points_, weights_);
}

Vec3 TensorPatch::value(double u, double v) const
{
    if (!rational()) return all_partials(Net<Vec3>{m_, n_, points_}, u, v, 0, 0)[0];
    const Vec4 h = all_partials(Net<Vec4>{m_, n_, homogeneous()}, u, v, 0, 0)[0];
    return {{h[0] / h[3], h[1] / h[3], h[2] / h[3]}};
}

Bounded<3> TensorPatch::value_with_bound(double u, double v) const
{
    if (!rational()) return bernstein::tensor_value_with_bound(points_, m_, n_, u, v);
    return bernstein::tensor_value_with_bound(homogeneous(), m_, n_, u, v,
                                              0.5 * std::numeric_limits<double>::epsilon());
}

SurfacePoint TensorPatch::partials(double u, double v) const
{
    if (!rational()) {
        const auto d = all_partials(Net<Vec3>{m_, n_, points_}, u, v, 2, 2);
        return {d[0], d[3], d[1], d[6], d[4], d[2]};
    }
    const auto d = all_partials(Net<Vec4>{m_, n_, homogeneous()}, u, v, 2, 2);
    return projected(d[0], d[3], d[1], d[6], d[4], d[2]);
}

Vec3 TensorPatch::normal(double u, double v) const
{
    if (auto usual = control::of_usual_size(points_))
        return TensorPatch(m_, n_, std::move(*usual), weights_).normal(u, v);
    const SurfacePoint s = partials(u, v);
    const Vec3 n = cross(s.pu, s.pv);
    const double tangents = norm(s.pu) * norm(s.pv);
    const double size = bounds().diagonal();
    const double least = 1e-9 * size;
    if (norm(n) > 1e-9 * tangents && norm(s.pu) > least && norm(s.pv) > least) return normalized(n);
    return limit(u, v);
}

// Taylor coefficients along the line to the middle (or, from there, along any).
Vec3 TensorPatch::limit(double u, double v) const
{
    Vec2 d = {{0.5 - u, 0.5 - v}};
    if (norm(d) < 0.1) d = {{0.4, 0.3}};
    const int terms = m_ + n_ + 2;
    const auto p = all_partials(Net<Vec4>{m_, n_, homogeneous()}, u, v, m_ + 1, n_ + 1);
    std::vector<Vec4> a(at(terms)), au(at(terms)), av(at(terms));
    double power_u = 1.0;
    for (int i = 0; i <= m_; ++i) {
        double factor = power_u;
        for (int j = 0; j <= n_; ++j) {
            const auto partial = [&](int r, int s) {
                return p[at(i + r) * at(n_ + 2) + at(j + s)];
            };
            a[at(i + j)] += factor * partial(0, 0);
            au[at(i + j)] += factor * partial(1, 0);
            av[at(i + j)] += factor * partial(0, 1);
            factor *= d[1] / (j + 1);
        }
        power_u *= d[0] / (i + 1);
    }
    return limit_normal(a, au, av);
}

namespace {

// Without normals where that span is empty.
void run_bulk(const TensorPatch& patch, std::span<const double> u, std::span<const double> v,
              std::span<Vec3> points, std::span<Vec3> normals)
{
    const std::vector<Vec4> h = patch.rational() ? patch.homogeneous() : std::vector<Vec4>();
    const double* c = patch.rational() ? h[0].c.data() : patch.points()[0].c.data();
    parallel_for(u.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
        bulk::tensor(c, patch.degree_u(), patch.degree_v(), patch.rational() ? 4 : 3,
                     u.data() + begin, v.data() + begin, end - begin, points[begin].c.data(),
                     normals.empty() ? nullptr : normals[begin].c.data());
        for (std::size_t i = begin; i < end && !normals.empty(); ++i)
            if (normals[i] == Vec3{}) normals[i] = patch.normal(u[i], v[i]);
    });
}

}  // namespace

void TensorPatch::evaluate(std::span<const double> u, std::span<const double> v,
                           std::span<Vec3> points) const
{
    require(u.size() == v.size() && u.size() == points.size(),
            "TensorPatch::evaluate: u, v and points must be equally long");
    run_bulk(*this, u, v, points, {});
}

void TensorPatch::evaluate(std::span<const double> u, std::span<const double> v,
                           std::span<Vec3> points, std::span<Vec3> normals) const
{
    require(u.size() == v.size() && u.size() == points.size() && u.size() == normals.size(),
            "TensorPatch::evaluate: u, v, points and normals must be equally long");
    if (m_ == 0 || n_ == 0)
        return elevated(m_ == 0 ? 1 : 0, n_ == 0 ? 1 : 0).evaluate(u, v, points, normals);
    run_bulk(*this, u, v, points, normals);
    if (auto usual = control::of_usual_size(points_)) {
        std::vector<Vec3> elsewhere(points.size());
        run_bulk(TensorPatch(m_, n_, std::move(*usual), weights_), u, v, elsewhere, normals);
    }
}

BezierCurve TensorPatch::edge(int k) const
{
    require(k >= 0 && k < 4, "TensorPatch::edge: number", k, "in [0, 3]");
    std::vector<Vec3> p;
    std::vector<double> w;
    const int last = k % 2 == 0 ? m_ : n_;
    for (int s = 0; s <= last; ++s) {
        const int t = k < 2 ? s : last - s;
        const std::size_t i = k % 2 == 0 ? index(t, k == 0 ? 0 : n_) : index(k == 1 ? m_ : 0, t);
        p.push_back(points_[i]);
        if (rational()) w.push_back(weights_[i]);
    }
    return BezierCurve(std::move(p), std::move(w));
}

Vec2 TensorPatch::on_edge(int k, double s)
{
    switch (k) {
        case 0:
            return {{s, 0.0}};
        case 1:
            return {{1.0, s}};
        case 2:
            return {{1.0 - s, 1.0}};
        default:
            return {{0.0, 1.0 - s}};
    }
}

BezierCurve TensorPatch::curve_u(double v) const
{
    const auto fixed = [&](const auto& net) {
        using V = typename std::decay_t<decltype(net.c)>::value_type;
        return by_rows(net,
                       [&](const std::vector<V>& row) {
                           return std::vector<V>{bernstein::value<V>(row, v)};
                       })
            .c;
    };
    if (rational()) return BezierCurve::from_homogeneous(fixed(Net<Vec4>{m_, n_, homogeneous()}));
    return BezierCurve(fixed(Net<Vec3>{m_, n_, points_}));
}

BezierCurve TensorPatch::curve_v(double u) const
{
    return transposed().curve_u(u);
}

std::pair<TensorPatch, TensorPatch> TensorPatch::split_u(double u) const
{
    return {part(0.0, u, 0.0, 1.0), part(u, 1.0, 0.0, 1.0)};
}

std::pair<TensorPatch, TensorPatch> TensorPatch::split_v(double v) const
{
    return {part(0.0, 1.0, 0.0, v), part(0.0, 1.0, v, 1.0)};
}

TensorPatch TensorPatch::part(double u0, double u1, double v0, double v1) const
{
    for (const double x : {u0, u1, v0, v1})
        require(std::isfinite(x), "TensorPatch::part: limit", x, "finite");
    require(u0 != u1 && v0 != v1, "TensorPatch::part: the part is empty");
    return with_net(*this, [&](auto net) { return part_of(std::move(net), u0, u1, v0, v1); });
}

TensorPatch TensorPatch::elevated(int by_u, int by_v) const
{
    require(by_u >= 0 && m_ + by_u <= kMaxDegree && by_v >= 0 && n_ + by_v <= kMaxDegree,
            "TensorPatch::elevated: the degrees must stay in [0, 512] and not fall");
    TensorPatch result = with_net(*this, [&](auto net) {
        using V = typename decltype(net.c)::value_type;
        const auto up = [](int by) {
            return [by](std::vector<V> c) {
                for (int k = 0; k < by; ++k) c = bernstein::elevated<V>(c);
                return c;
            };
        };
        return by_columns(by_rows(net, up(by_v)), up(by_u));
    });
    // (x w) / w need not be x; neighbours are recognised by their corners.
    for (const int i : {0, 1})
        for (const int j : {0, 1})
            result.points_[result.index(i * result.m_, j * result.n_)] = point(i * m_, j * n_);
    return result;
}

TensorPatch TensorPatch::transposed() const
{
    const Net<Vec3> net = Net<Vec3>{m_, n_, points_}.transposed();
    if (!rational()) return TensorPatch(n_, m_, net.c);
    return TensorPatch(n_, m_, net.c, Net<double>{m_, n_, weights_}.transposed().c);
}

Box3 TensorPatch::bounds() const
{
    return control::bounds(points_);
}

TensorPatch transformed(const TensorPatch& patch, const Transform& map)
{
    return TensorPatch(patch.degree_u(), patch.degree_v(),
                       control::transformed(patch.points(), map), patch.weights());
}

std::vector<std::vector<Vec3>> continuation(const TensorPatch& a, int order, double ratio)
{
    require(!a.rational(), "continuation: the patch must be polynomial");
    require(order >= 0 && order <= a.degree_u(), "continuation: order", order,
            "in [0, degree in u]");
    std::vector<std::vector<Vec3>> rows(at(order) + 1);
    for (int j = 0; j <= a.degree_v(); ++j) {
        std::vector<Vec3> column;
        for (int i = 0; i <= a.degree_u(); ++i) column.push_back(a.point(i, j));
        const auto next = continuation(BezierCurve(std::move(column)), order, ratio);
        for (std::size_t r = 0; r < rows.size(); ++r) rows[r].push_back(next[r]);
    }
    return rows;
}

}  // namespace genus
