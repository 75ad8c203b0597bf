#include "genus/patch/bspline_surface.h"

#include <algorithm>
#include <numeric>

#include "genus/base/error.h"
#include "genus/base/transform.h"
#include "genus/patch/control_points.h"

namespace genus {

namespace {

std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

// Lines of points, those of one line `stride` apart, lines `line_stride` apart.
struct Lines {
    std::span<const Vec4> c;
    std::size_t count, stride, line_stride;
};

// Refines each line. The results stand one after another if `lines_outer`, else side by side.
std::vector<Vec4> refine_lines(const KnotRefinement& r, const Lines& lines, bool lines_outer)
{
    std::vector<Vec4> result(lines.count * r.rows.size());
    for (std::size_t line = 0; line < lines.count; ++line)
        for (std::size_t i = 0; i < r.rows.size(); ++i) {
            Vec4 sum{};
            const auto& row = r.rows[i];
            for (std::size_t j = 0; j < row.weights.size(); ++j)
                sum += row.weights[j] *
                       lines.c[line * lines.line_stride + (at(row.first) + j) * lines.stride];
            result[lines_outer ? line * r.rows.size() + i : i * lines.count + line] = sum;
        }
    return result;
}

BSplineSurface from_homogeneous(const KnotVector& u, const KnotVector& v, std::span<const Vec4> h,
                                bool rational)
{
    std::vector<Vec3> points;
    std::vector<double> weights;
    for (const Vec4& p : h) {
        points.push_back({{p[0] / p[3], p[1] / p[3], p[2] / p[3]}});
        if (rational) weights.push_back(p[3]);
    }
    return BSplineSurface(u, v, std::move(points), std::move(weights));
}

// Every inner knot, and both ends of the domain, as often as the degree asks for Bezier pieces.
KnotVector bezier_knots(const KnotVector& knots)
{
    const int p = knots.degree();
    std::vector<double> values;
    double last = 0.0;
    bool any = false;
    for (const double t : knots.values()) {
        if (t < knots.begin() || t > knots.end() || (any && t == last)) continue;
        const bool end = t == knots.begin() || t == knots.end();
        values.insert(values.end(), at(end ? p + 1 : p), t);
        last = t;
        any = true;
    }
    return KnotVector(p, std::move(values));
}

// Weights that take the points of a spline to those over its bezier_knots.
KnotRefinement to_bezier(const KnotVector& from, const KnotVector& to)
{
    KnotRefinement r;
    const std::size_t p = at(from.degree());
    for (int i = 0; i < to.n_points(); ++i) {
        const double lo = std::max(to[at(i)], from.begin());
        const double hi = std::min(to[at(i) + p + 1], from.end());
        const int k = from.span(0.5 * lo + 0.5 * hi);
        r.rows.push_back({k - from.degree(),
                          from.blossom_weights(k, std::span(to.values()).subspan(at(i) + 1, p))});
    }
    return r;
}

}  // namespace

BSplineSurface::BSplineSurface(KnotVector knots_u, KnotVector knots_v, std::vector<Vec3> points,
                               std::vector<double> weights)
    : u_(std::move(knots_u)),
      v_(std::move(knots_v)),
      points_(std::move(points)),
      weights_(std::move(weights))
{
    require(points_.size() == at(u_.n_points()) * at(v_.n_points()),
            "BSplineSurface: number of points", static_cast<double>(points_.size()),
            "the product of those of both knot vectors");
    control::check("BSplineSurface", points_, weights_);
}

std::vector<Vec4> BSplineSurface::homogeneous() const
{
    return control::homogeneous(points_, weights_);
}

SurfacePoint BSplineSurface::partials(double u, double v) const
{
    const int ku = u_.span(u), kv = v_.span(v);
    const auto bu = u_.basis_derivatives(ku, u, 2), bv = v_.basis_derivatives(kv, v, 2);
    const auto sum = [&](std::size_t a, std::size_t b) {
        Vec4 total{};
        for (int i = 0; i <= u_.degree(); ++i)
            for (int j = 0; j <= v_.degree(); ++j) {
                const std::size_t k =
                    at(ku - u_.degree() + i) * at(v_.n_points()) + at(kv - v_.degree() + j);
                const double w = rational() ? weights_[k] : 1.0;
                const double factor = bu[a][at(i)] * bv[b][at(j)] * w;
                total += factor * Vec4{{points_[k][0], points_[k][1], points_[k][2], 1.0}};
            }
        // Without weights the sum of the basis is 1 exactly, and its derivatives 0.
        if (!rational()) total[3] = a + b == 0 ? 1.0 : 0.0;
        return total;
    };
    return projected(sum(0, 0), sum(1, 0), sum(0, 1), sum(2, 0), sum(1, 1), sum(0, 2));
}

Vec3 BSplineSurface::normal(double u, double v) const
{
    const SurfacePoint s = partials(u, v);
    const Vec3 n = cross(s.pu, s.pv);
    const double least_u = 1e-9 * bounds().diagonal() / (u_.end() - u_.begin());
    const double least_v = 1e-9 * bounds().diagonal() / (v_.end() - v_.begin());
    if (norm(n) > 1e-9 * norm(s.pu) * norm(s.pv) && norm(s.pu) > least_u && norm(s.pv) > least_v)
        return normalized(n);
    const int ku = u_.span(u), kv = v_.span(v);
    std::size_t piece = 0;
    for (const int k : u_.spans()) {
        if (k == ku) break;
        piece += v_.spans().size();
    }
    for (const int k : v_.spans()) {
        if (k == kv) break;
        ++piece;
    }
    const auto local = [](const KnotVector& knots, int k, double t) {
        return (t - knots[at(k)]) / (knots[at(k) + 1] - knots[at(k)]);
    };
    return bezier_patches()[piece].normal(local(u_, ku, u), local(v_, kv, v));
}

namespace {

struct Places {
    std::vector<std::size_t> order, first;  // points by piece, and where each piece starts
    std::vector<double> u, v;               // parameters within the piece, in that order
};

// Local parameter of t, and the number of its piece among the spans.
std::size_t locate(const KnotVector& knots, const std::vector<std::size_t>& number, double t,
                   double& local)
{
    const double x = std::clamp(t, knots.begin(), knots.end());
    const int k = knots.span(x);
    local = (x - knots[at(k)]) / (knots[at(k) + 1] - knots[at(k)]);
    return number[at(k)];
}

std::vector<std::size_t> span_numbers(const KnotVector& knots)
{
    std::vector<std::size_t> number(knots.values().size());
    std::size_t n = 0;
    for (const int k : knots.spans()) number[at(k)] = n++;
    return number;
}

Places sorted_by_piece(const BSplineSurface& s, std::span<const double> u,
                       std::span<const double> v)
{
    const auto number_u = span_numbers(s.knots_u()), number_v = span_numbers(s.knots_v());
    const std::size_t n_v = s.knots_v().spans().size();
    const std::size_t pieces = s.knots_u().spans().size() * n_v;
    std::vector<double> lu(u.size()), lv(u.size());
    std::vector<std::size_t> piece(u.size());
    Places p;
    p.first.assign(pieces + 1, 0);
    for (std::size_t i = 0; i < u.size(); ++i) {
        require(std::isfinite(u[i]) && std::isfinite(v[i]),
                "BSplineSurface::evaluate: a parameter is not finite");
        piece[i] = locate(s.knots_u(), number_u, u[i], lu[i]) * n_v +
                   locate(s.knots_v(), number_v, v[i], lv[i]);
        ++p.first[piece[i] + 1];
    }
    std::partial_sum(p.first.begin(), p.first.end(), p.first.begin());
    p.order.resize(u.size());
    p.u.resize(u.size());
    p.v.resize(u.size());
    auto next = p.first;
    for (std::size_t i = 0; i < u.size(); ++i) {
        const std::size_t k = next[piece[i]]++;
        p.order[k] = i;
        p.u[k] = lu[i];
        p.v[k] = lv[i];
    }
    return p;
}

void run_bulk(const BSplineSurface& s, std::span<const double> u, std::span<const double> v,
              std::span<Vec3> points, std::span<Vec3> normals)
{
    const Places places = sorted_by_piece(s, u, v);
    const auto patches = s.bezier_patches();
    std::vector<Vec3> p(u.size()), n(normals.size());
    for (std::size_t k = 0; k < patches.size(); ++k) {
        const std::size_t from = places.first[k], count = places.first[k + 1] - from;
        if (count == 0) continue;
        const auto pu = std::span(places.u).subspan(from, count);
        const auto pv = std::span(places.v).subspan(from, count);
        if (normals.empty())
            patches[k].evaluate(pu, pv, std::span(p).subspan(from, count));
        else
            patches[k].evaluate(pu, pv, std::span(p).subspan(from, count),
                                std::span(n).subspan(from, count));
    }
    for (std::size_t k = 0; k < u.size(); ++k) {
        points[places.order[k]] = p[k];
        if (!normals.empty()) normals[places.order[k]] = n[k];
    }
}

}  // namespace

void BSplineSurface::evaluate(std::span<const double> u, std::span<const double> v,
                              std::span<Vec3> points) const
{
    require(u.size() == v.size() && u.size() == points.size(),
            "BSplineSurface::evaluate: u, v and points must be equally long");
    run_bulk(*this, u, v, points, {});
}

void BSplineSurface::evaluate(std::span<const double> u, std::span<const double> v,
                              std::span<Vec3> points, std::span<Vec3> normals) const
{
    require(u.size() == v.size() && u.size() == points.size() && u.size() == normals.size(),
            "BSplineSurface::evaluate: u, v, points and normals must be equally long");
    run_bulk(*this, u, v, points, normals);
}

namespace {

std::vector<Vec4> refine_both(const BSplineSurface& s, const KnotRefinement& ru,
                              const KnotRefinement& rv)
{
    const std::size_t nu = at(s.knots_u().n_points()), nv = at(s.knots_v().n_points());
    const auto h = s.homogeneous();
    const auto along_v = refine_lines(rv, {h, nu, 1, nv}, true);
    const std::size_t mv = rv.rows.size();
    return refine_lines(ru, {along_v, mv, mv, 1}, false);
}

}  // namespace

BSplineSurface BSplineSurface::refined(const KnotVector& knots_u, const KnotVector& knots_v) const
{
    const auto h = refine_both(*this, refinement(u_, knots_u), refinement(v_, knots_v));
    return from_homogeneous(knots_u, knots_v, h, rational());
}

BSplineSurface BSplineSurface::elevated(bool in_u, bool in_v) const
{
    return refined(in_u ? u_.elevated() : u_, in_v ? v_.elevated() : v_);
}

std::pair<BSplineSurface, BSplineSurface> BSplineSurface::split_u(double u) const
{
    const KnotVector::Split knots = u_.split(u);
    const std::vector<Vec4> all = refined(knots.whole, v_).homogeneous();
    const std::span<const Vec4> h = all;
    const std::size_t row = at(v_.n_points()), n = at(knots.before.n_points());
    return {from_homogeneous(knots.before, v_, h.first(n * row), rational()),
            from_homogeneous(knots.after, v_, h.subspan((n - 1) * row), rational())};
}

std::pair<BSplineSurface, BSplineSurface> BSplineSurface::split_v(double v) const
{
    const KnotVector::Split knots = v_.split(v);
    const std::vector<Vec4> h = refined(u_, knots.whole).homogeneous();
    const std::size_t row = at(knots.whole.n_points()), n = at(knots.before.n_points());
    std::vector<Vec4> before, after;
    for (std::size_t start = 0; start < h.size(); start += row)
        for (std::size_t j = 0; j < row; ++j) {
            if (j < n) before.push_back(h[start + j]);
            if (j + 1 >= n) after.push_back(h[start + j]);
        }
    return {from_homogeneous(u_, knots.before, before, rational()),
            from_homogeneous(u_, knots.after, after, rational())};
}

std::vector<TensorPatch> BSplineSurface::bezier_patches() const
{
    const KnotVector bu = bezier_knots(u_), bv = bezier_knots(v_);
    const auto h = refine_both(*this, to_bezier(u_, bu), to_bezier(v_, bv));
    const int p = u_.degree(), q = v_.degree();
    const std::size_t width = at(bv.n_points());
    std::vector<TensorPatch> result;
    for (int a = 0; a + p < bu.n_points(); a += p)
        for (int b = 0; b + q < bv.n_points(); b += q) {
            std::vector<Vec4> c;
            for (int i = 0; i <= p; ++i)
                for (int j = 0; j <= q; ++j) c.push_back(h[at(a + i) * width + at(b + j)]);
            if (rational()) {
                result.push_back(TensorPatch::from_homogeneous(p, q, c));
                continue;
            }
            std::vector<Vec3> points;
            for (const Vec4& x : c) points.push_back({{x[0], x[1], x[2]}});
            result.emplace_back(p, q, std::move(points));
        }
    return result;
}

Box3 BSplineSurface::bounds() const
{
    return control::bounds(points_);
}

BSplineSurface transformed(const BSplineSurface& surface, const Transform& map)
{
    return BSplineSurface(surface.knots_u(), surface.knots_v(),
                          control::transformed(surface.points(), map), surface.weights());
}

BSplineSurface surface_of_revolution(const BSpline& profile, double sweep)
{
    const BSpline arc = elliptic_arc({}, {{1, 0, 0}}, {{0, 1, 0}}, 0.0, sweep);
    std::vector<Vec3> points;
    std::vector<double> weights;
    for (std::size_t i = 0; i < profile.points().size(); ++i) {
        const Vec3& p = profile.points()[i];
        const double w = profile.rational() ? profile.weights()[i] : 1.0;
        for (std::size_t j = 0; j < arc.points().size(); ++j) {
            const Vec3& a = arc.points()[j];
            points.push_back({{p[0] * a[0] - p[1] * a[1], p[0] * a[1] + p[1] * a[0], p[2]}});
            weights.push_back(w * arc.weights()[j]);
        }
    }
    return BSplineSurface(profile.knots(), arc.knots(), std::move(points), std::move(weights));
}

}  // namespace genus
