#include "genus/patch/tessellate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// ---- Bounds of second derivatives -------------------------------------------------------------

// Magnitudes of the coefficients of a polynomial over a rectangle or triangle.
struct Magnitudes {
    bool triangle;
    int m, n;  // degrees; a triangle has m == n
    std::vector<double> c;

    /// Largest (or least) coefficient in each row parallel to an edge, that of the edge first.
    std::vector<double> rows(int edge, bool least = false) const
    {
        const int last = triangle || edge % 2 == 0 ? n : m;
        std::vector<double> r(static_cast<std::size_t>(last) + 1,
                              least ? std::numeric_limits<double>::infinity() : 0.0);
        std::size_t index = 0;
        for (int i = 0; i <= m; ++i)
            for (int j = 0; j <= (triangle ? n - i : n); ++j, ++index) {
                const int away = triangle ? (edge == 0   ? j
                                             : edge == 1 ? n - i - j
                                                         : i)
                                          : (edge == 0   ? j
                                             : edge == 1 ? m - i
                                             : edge == 2 ? n - j
                                                         : i);
                double& x = r[static_cast<std::size_t>(away)];
                x = least ? std::min(x, c[index]) : std::max(x, c[index]);
            }
        return r;
    }
};

// Row maxima are coefficients of a polynomial in the distance from the edge that stays above the
// magnitude: the basis functions of a row sum to the basis function of that distance.
double most_within(const Magnitudes& x, int edge, double reach)
{
    const auto r = bernstein::segment<double>(x.rows(edge), 0.0, reach);
    return *std::max_element(r.begin(), r.end());
}

double least_within(const Magnitudes& x, int edge, double reach)
{
    const auto r = bernstein::segment<double>(x.rows(edge, true), 0.0, reach);
    return *std::min_element(r.begin(), r.end());
}

// Coefficients of a polynomial with values V, and its derivatives.
struct Net {
    bool triangle;
    int m, n;
    std::vector<Vec4> c;

    std::size_t index(int i, int j) const
    {
        return triangle ? BezierTriangle::index(n, i, j)
                        : static_cast<std::size_t>(i * (n + 1) + j);
    }
    Net du() const
    {
        if (m == 0) return zero();
        Net d{triangle, m - 1, triangle ? n - 1 : n, {}};
        for (int i = 0; i <= d.m; ++i)
            for (int j = 0; j <= (triangle ? d.n - i : d.n); ++j)
                d.c.push_back(static_cast<double>(m) * (c[index(i + 1, j)] - c[index(i, j)]));
        return d;
    }
    Net dv() const
    {
        if (n == 0) return zero();
        Net d{triangle, triangle ? m - 1 : m, n - 1, {}};
        for (int i = 0; i <= d.m; ++i)
            for (int j = 0; j <= (triangle ? d.n - i : d.n); ++j)
                d.c.push_back(static_cast<double>(n) * (c[index(i, j + 1)] - c[index(i, j)]));
        return d;
    }
    Net zero() const { return {triangle, 0, 0, {Vec4{}}}; }

    Magnitudes points() const
    {
        Magnitudes x{triangle, m, n, {}};
        for (const Vec4& p : c) x.c.push_back(std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]));
        return x;
    }
    Magnitudes weights() const
    {
        Magnitudes x{triangle, m, n, {}};
        for (const Vec4& p : c) x.c.push_back(std::fabs(p[3]));
        return x;
    }
};

struct SecondBounds {
    double uu = 0.0, uv = 0.0, vv = 0.0;

    double error(double x, double y) const
    {
        return (uu * x * x + 2.0 * uv * x * y + vv * y * y) / 8.0;
    }
};

// Bounds of the second derivatives of A / w on strips along an edge of the domain.
class DerivativeBounds {
public:
    DerivativeBounds(bool triangle, int m, int n, std::vector<Vec4> h, bool rational,
                     const Vec3& center)
        : rational_(rational)
    {
        // A is taken round `center`: the bounds of a quotient grow with |A / w|.
        for (Vec4& p : h)
            for (std::size_t k = 0; k < 3; ++k) p[k] -= center[k] * p[3];
        const Net a{triangle, m, n, std::move(h)};
        const Net u = a.du(), v = a.dv();
        for (const Net& x : {a, u, v, u.du(), u.dv(), v.dv()}) {
            points_.push_back(x.points());
            weights_.push_back(x.weights());
        }
    }

    SecondBounds within(int edge, double reach) const
    {
        std::array<double, 6> p, w;  // of A and w: value, u, v, uu, uv, vv
        for (std::size_t k = 0; k < 6; ++k) {
            p[k] = most_within(points_[k], edge, reach);
            w[k] = rational_ ? most_within(weights_[k], edge, reach) : 0.0;
        }
        if (!rational_) return {p[3], p[4], p[5]};
        const double least = least_within(weights_[0], edge, reach);
        const double r = p[0] / least;
        // (A/w)_uu = (A_uu - 2 w_u (A/w)_u - w_uu A/w) / w and its like, by their magnitudes.
        const double u = (p[1] + w[1] * r) / least, v = (p[2] + w[2] * r) / least;
        return {(p[3] + 2.0 * w[1] * u + w[3] * r) / least,
                (p[4] + w[1] * v + w[2] * u + w[4] * r) / least,
                (p[5] + 2.0 * w[2] * v + w[5] * r) / least};
    }
    SecondBounds everywhere() const { return within(0, 1.0); }

private:
    bool rational_;
    std::vector<Magnitudes> points_, weights_;
};

// ---- Edges ------------------------------------------------------------------------------------

struct EdgeClass {
    BezierCurve curve;  // in its own direction
    int segments = 1;
    double mismatch = 0.0;  // how far its members are away from `curve`
    std::vector<std::int32_t> vertices;
};

struct EdgeUse {
    std::size_t edge_class;
    bool forward;
};

using Key = std::array<double, 3>;

// -0 and 0 are the same coordinate.
Key key_of(const Vec3& p)
{
    return {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0};
}

// A total order on curve data that two patches agree on.
std::vector<double> order_key(const BezierCurve& c)
{
    std::vector<double> k = {static_cast<double>(c.degree())};
    for (const Vec4& p : c.homogeneous()) k.insert(k.end(), {p[0], p[1], p[2], p[3]});
    return k;
}

// How far two curves are apart at equal parameters, by their control points; scaled weights are
// the same curve.
double coefficient_distance(const BezierCurve& a, const BezierCurve& b)
{
    const int n = std::max(a.degree(), b.degree());
    const BezierCurve x = a.elevated(n - a.degree()), y = b.elevated(n - b.degree());
    const auto weight = [](const BezierCurve& c, std::size_t i) {
        return c.rational() ? c.weights()[i] / c.weights()[0] : 1.0;
    };
    double worst = 0.0;
    const double size = x.bounds().diagonal();
    for (std::size_t i = 0; i < x.points().size(); ++i) {
        worst = std::max(worst, distance(x.points()[i], y.points()[i]));
        worst = std::max(worst, size * std::fabs(weight(x, i) / weight(y, i) - 1.0));
    }
    return worst;
}

constexpr double kSameEdge = 1e-12;

class EdgeTable {
public:
    EdgeUse add(const BezierCurve& edge)
    {
        const Key a = key_of(edge.points().front()), b = key_of(edge.points().back());
        auto& group = by_ends_[a < b ? std::pair(a, b) : std::pair(b, a)];
        const double size = edge.bounds().diagonal();
        const BezierCurve back = edge.reversed();
        for (const std::size_t k : group) {
            EdgeClass& known = classes_[k];
            const double same = coefficient_distance(known.curve, edge);
            const double turned = coefficient_distance(known.curve, back);
            if (std::min(same, turned) > kSameEdge * size) continue;
            known.mismatch += std::min(same, turned);
            offer(known, same <= turned ? edge : back);
            return {k, same <= turned};
        }
        group.push_back(classes_.size());
        classes_.push_back({edge, 1, 0.0, {}});
        return {classes_.size() - 1, true};
    }

    std::vector<EdgeClass>& classes() { return classes_; }

    /// Brings every class into the direction that its data alone prescribe, and tells which were
    /// turned.
    std::vector<bool> settle()
    {
        std::vector<bool> turned;
        for (EdgeClass& e : classes_) {
            const BezierCurve back = e.curve.reversed();
            turned.push_back(order_key(back) < order_key(e.curve));
            if (turned.back()) e.curve = back;
        }
        return turned;
    }

private:
    // The member of least degree, then of least data, speaks for all, whoever came first.
    static void offer(EdgeClass& known, const BezierCurve& edge)
    {
        const auto least = [](const BezierCurve& c) {
            return std::min(order_key(c), order_key(c.reversed()));
        };
        if (least(edge) < least(known.curve)) known.curve = edge;
    }

    std::vector<EdgeClass> classes_;
    std::map<std::pair<Key, Key>, std::vector<std::size_t>> by_ends_;
};

bool collapsed(const BezierCurve& c)
{
    return std::all_of(c.points().begin(), c.points().end(),
                       [&](const Vec3& p) { return key_of(p) == key_of(c.points()[0]); });
}

// A curve is a patch of degree (n, 0).
SecondBounds curve_bounds(const BezierCurve& c)
{
    return DerivativeBounds(false, c.degree(), 0, c.homogeneous(), c.rational(),
                            c.bounds().center())
        .everywhere();
}

constexpr std::int64_t kMaxSegments = std::int64_t{1} << 24;

// Segments of length 1 / n with error `d` / (8 n^2) at most `tolerance`.
int segments_for(double d, double tolerance)
{
    const double n = std::ceil(std::sqrt(d / (8.0 * tolerance)) * (1.0 - 1e-12));
    return static_cast<int>(std::clamp(n, 1.0, static_cast<double>(kMaxSegments)));
}

// ---- One patch --------------------------------------------------------------------------------

// A vertex of the domain: an edge vertex or one of the inside.
struct Place {
    Vec2 uv;
    std::int32_t vertex;  // below 0: inner vertex number -1 - vertex
};

using Corner = std::array<Place, 3>;

double span_of(const Corner& t, std::size_t k)
{
    const auto [lo, hi] = std::minmax({t[0].uv[k], t[1].uv[k], t[2].uv[k]});
    return hi - lo;
}

// Triangles between an outer and an inner row of vertices that run in the same direction; `at`
// gives the position along the edge.
template <class At>
void zip(const std::vector<Place>& outer, const std::vector<Place>& inner, const At& at,
         std::vector<Corner>& triangles)
{
    std::size_t o = 0, i = 0;
    while (o + 1 < outer.size() || i + 1 < inner.size()) {
        const bool step_outer = i + 1 == inner.size() ||
                                (o + 1 < outer.size() && at(outer[o].uv) + at(outer[o + 1].uv) <=
                                                             at(inner[i].uv) + at(inner[i + 1].uv));
        if (step_outer) {
            triangles.push_back({outer[o], outer[o + 1], inner[i]});
            ++o;
        } else {
            triangles.push_back({outer[o], inner[i + 1], inner[i]});
            ++i;
        }
    }
}

double error_of(const std::vector<Corner>& triangles, const SecondBounds& d)
{
    double worst = 0.0;
    for (const Corner& t : triangles)
        worst = std::max(worst, d.error(span_of(t, 0), span_of(t, 1)));
    return worst;
}

// Coordinates in which edge k of a triangle is its edge 0: u along it, v away from it.
Vec2 turned(const Vec2& p, int k)
{
    const double w = 1.0 - p[0] - p[1];
    return k == 0 ? p : k == 1 ? Vec2{{p[1], w}} : Vec2{{w, p[0]}};
}

std::vector<Vec4> turned(const std::vector<Vec4>& c, int n, int k)
{
    std::vector<Vec4> t;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n - i; ++j)
            t.push_back(c[k == 0   ? BezierTriangle::index(n, i, j)
                          : k == 1 ? BezierTriangle::index(n, n - i - j, i)
                                   : BezierTriangle::index(n, j, n - i - j)]);
    return t;
}

// The triangulation of one patch: regular inside, joined to given edge vertices by a ring.
struct Layout {
    std::vector<Vec2> inner;
    std::vector<Corner> triangles;
    double bound = 0.0;
};

struct PatchEdge {
    std::vector<Place> places;  // counterclockwise along the edge
    DerivativeBounds bounds;
};

struct Density {
    int u, v;                       // cells per unit of parameter
    std::array<double, 4> reach{};  // width of the ring along each edge
};

std::int32_t inner_vertex(std::size_t k)
{
    return -1 - static_cast<std::int32_t>(k);
}

// Position along edge k of a rectangle or triangle, ascending counterclockwise.
double along(bool triangle, int k, const Vec2& p)
{
    if (triangle)
        return k == 0   ? p[0] + 0.5 * p[1]
               : k == 1 ? 0.5 * (1.0 - p[0] + p[1])
                        : 1.0 - p[1] - 0.5 * p[0];
    return k == 0 ? p[0] : k == 1 ? p[1] : k == 2 ? 1.0 - p[0] : 1.0 - p[1];
}

// Inner rows along each edge, counterclockwise, and the regular cells.
std::vector<std::vector<Place>> rectangle_inside(const Density& d, Layout& layout)
{
    const double u0 = d.reach[3], u1 = 1.0 - d.reach[1], v0 = d.reach[0], v1 = 1.0 - d.reach[2];
    const auto cells = [](double width, int density) {
        return width > 1e-9 ? std::max(1, static_cast<int>(std::ceil(width * density - 1e-9))) : 0;
    };
    const int a = cells(u1 - u0, d.u), b = cells(v1 - v0, d.v);
    const auto share = [](double lo, double hi, int i, int n) {
        return n == 0 ? lo : lo + (hi - lo) * (static_cast<double>(i) / n);
    };
    for (int i = 0; i <= a; ++i)
        for (int j = 0; j <= b; ++j)
            layout.inner.push_back({{share(u0, u1, i, a), share(v0, v1, j, b)}});
    const auto place = [&](int i, int j) {
        const auto k = static_cast<std::size_t>(i * (b + 1) + j);
        return Place{layout.inner[k], inner_vertex(k)};
    };
    for (int i = 0; i < a; ++i)
        for (int j = 0; j < b; ++j) {
            layout.triangles.push_back({place(i, j), place(i + 1, j), place(i + 1, j + 1)});
            layout.triangles.push_back({place(i, j), place(i + 1, j + 1), place(i, j + 1)});
        }
    std::vector<std::vector<Place>> rows(4);
    for (int i = 0; i <= a; ++i) {
        rows[0].push_back(place(i, 0));
        rows[2].push_back(place(a - i, b));
    }
    for (int j = 0; j <= b; ++j) {
        rows[1].push_back(place(a, j));
        rows[3].push_back(place(0, b - j));
    }
    return rows;
}

std::vector<std::vector<Place>> triangle_inside(const Density& d, Layout& layout)
{
    const double width = 1.0 - d.reach[0] - d.reach[1] - d.reach[2];
    const int n = width > 1e-9 ? std::max(1, static_cast<int>(std::ceil(width * d.u - 1e-9))) : 0;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n - i; ++j) {
            const double step = n == 0 ? 0.0 : width / n;
            layout.inner.push_back({{d.reach[2] + step * i, d.reach[0] + step * j}});
        }
    const auto place = [&](int i, int j) {
        const std::size_t k = BezierTriangle::index(n, i, j);
        return Place{layout.inner[k], inner_vertex(k)};
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n - i; ++j) {
            layout.triangles.push_back({place(i, j), place(i + 1, j), place(i, j + 1)});
            if (i + j + 1 < n)
                layout.triangles.push_back({place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)});
        }
    std::vector<std::vector<Place>> rows(3);
    for (int s = 0; s <= n; ++s) {
        rows[0].push_back(place(s, 0));
        rows[1].push_back(place(n - s, s));
        rows[2].push_back(place(0, n - s));
    }
    return rows;
}

// All edges have as many segments as the grid: no ring.
Layout regular_layout(bool triangle, int nu, int nv, const std::vector<PatchEdge>& edges)
{
    Layout layout;
    std::map<std::pair<int, int>, Place> border;
    const auto put = [&](std::size_t k, int from_i, int from_j, int di, int dj) {
        for (std::size_t s = 0; s < edges[k].places.size(); ++s)
            border[{from_i + di * static_cast<int>(s), from_j + dj * static_cast<int>(s)}] =
                edges[k].places[s];
    };
    put(0, 0, 0, 1, 0);
    if (triangle) {
        put(1, nu, 0, -1, 1);
        put(2, 0, nv, 0, -1);
    } else {
        put(1, nu, 0, 0, 1);
        put(2, nu, nv, -1, 0);
        put(3, 0, nv, 0, -1);
    }
    std::vector<std::vector<Place>> grid(static_cast<std::size_t>(nu) + 1);
    for (int i = 0; i <= nu; ++i)
        for (int j = 0; j <= (triangle ? nu - i : nv); ++j) {
            const auto known = border.find({i, j});
            if (known != border.end()) {
                grid[static_cast<std::size_t>(i)].push_back(known->second);
                continue;
            }
            const Vec2 uv = {{static_cast<double>(i) / nu, static_cast<double>(j) / nv}};
            grid[static_cast<std::size_t>(i)].push_back({uv, inner_vertex(layout.inner.size())});
            layout.inner.push_back(uv);
        }
    const auto at = [&](int i, int j) {
        return grid[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    };
    for (int i = 0; i < nu; ++i)
        for (int j = 0; j < (triangle ? nu - i : nv); ++j) {
            if (!triangle) {
                layout.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                layout.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
                continue;
            }
            layout.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
            if (i + j + 1 < nu)
                layout.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return layout;
}

class PatchTriangulator {
public:
    PatchTriangulator(bool triangle, const DerivativeBounds& inside, std::vector<PatchEdge> edges,
                      double tolerance, std::int64_t max_triangles)
        : triangle_(triangle),
          inside_(inside.everywhere()),
          edges_(std::move(edges)),
          tolerance_(tolerance),
          max_triangles_(max_triangles)
    {
    }

    Layout run()
    {
        Density d = density();
        const auto segments = [&](std::size_t k) {
            return static_cast<int>(edges_[k].places.size()) - 1;
        };
        const bool regular = triangle_
                                 ? segments(0) == d.u && segments(1) == d.u && segments(2) == d.u
                                 : segments(0) == d.u && segments(2) == d.u && segments(1) == d.v &&
                                       segments(3) == d.v;
        if (regular) {
            check_size(d);
            Layout layout = regular_layout(triangle_, d.u, d.v, edges_);
            layout.bound = error_of(layout.triangles, inside_);
            if (layout.bound <= tolerance_) return layout;
        }
        if (const auto layout = lens(d)) return *layout;
        return with_ring(d);
    }

private:
    // Cells in proportion to the root of the bounds, so that both directions err alike.
    Density density() const
    {
        const SecondBounds& b = inside_;
        if (triangle_) {
            const int n = segments_for(b.uu + 2.0 * b.uv + b.vv, tolerance_);
            return {n, n};
        }
        const double u = std::sqrt(b.uu), v = std::sqrt(b.vv);
        // With X = 1 / (k u), Y = 1 / (k v) the error is (2 + 2 uv / (u v)) / (8 k^2).
        if (u > 0.0 && v > 0.0) {
            const double k = std::sqrt((2.0 + 2.0 * b.uv / (u * v)) / (8.0 * tolerance_));
            const double nu = std::max(1.0, std::ceil(k * u)), nv = std::max(1.0, std::ceil(k * v));
            if (nu * nv < 1e9 && nu < 1e8 && nv < 1e8 && b.error(1.0 / nu, 1.0 / nv) <= tolerance_)
                return {static_cast<int>(nu), static_cast<int>(nv)};
        }
        // Flat in one direction (or nearly): the twist alone asks for cells.
        double nu = std::max(1.0, std::ceil(u / std::sqrt(4.0 * tolerance_)));
        double nv = std::max(1.0, std::ceil(v / std::sqrt(4.0 * tolerance_)));
        while (b.error(1.0 / nu, 1.0 / nv) > tolerance_ && nu * nv < 1e9) {
            const double in_u = b.uu / (nu * nu), in_v = b.vv / (nv * nv);
            double& finer = in_u > in_v || (in_u == in_v && nu <= nv) ? nu : nv;
            finer = std::ceil(1.2 * finer + 0.5);
        }
        return {static_cast<int>(std::min(nu, 1e8)), static_cast<int>(std::min(nv, 1e8))};
    }

    void check_size(const Density& d) const
    {
        const double cells = static_cast<double>(d.u) * d.v;
        if (cells > static_cast<double>(max_triangles_) || cells > 1e9)
            throw ToleranceNotMet("tessellate: tolerance " + to_text(tolerance_) +
                                      " needs more triangles than allowed",
                                  tolerance_, std::numeric_limits<double>::infinity(), {});
    }

    // A patch between two curves with the same ends: its other edges have shrunk to a point each.
    // In rows from curve to curve, with the points of the curves for ends, it does not fold where
    // the curves meet at a small angle, as a ring beside a coarser curve might.
    std::optional<Layout> lens(Density d) const
    {
        if (triangle_) return std::nullopt;
        for (std::size_t along = 0; along < 2; ++along) {
            const auto shrunk = [&](std::size_t k) {
                return edges_[k].places.front().vertex == edges_[k].places.back().vertex;
            };
            const std::size_t rows = edges_[along].places.size() - 1;
            if (!shrunk(1 - along) || !shrunk(3 - along) ||
                edges_[along + 2].places.size() != rows + 1)
                continue;
            int& cells = along == 0 ? d.u : d.v;
            int& across = along == 0 ? d.v : d.u;
            cells = static_cast<int>(rows);
            across = 1;
            const auto error = [&] { return inside_.error(1.0 / d.u, 1.0 / d.v); };
            while (error() > tolerance_ && across < kMaxSegments) across *= 2;
            if (error() > tolerance_) continue;
            check_size(d);
            std::vector<PatchEdge> edges = edges_;
            for (const std::size_t k : {1 - along, 3 - along}) {
                const std::int32_t vertex = edges[k].places.front().vertex;
                edges[k].places.clear();
                for (int s = 0; s <= across; ++s)
                    edges[k].places.push_back(
                        {TensorPatch::on_edge(static_cast<int>(k), static_cast<double>(s) / across),
                         vertex});
            }
            Layout layout = regular_layout(false, d.u, d.v, edges);
            layout.bound = error_of(layout.triangles, inside_);
            if (layout.bound <= tolerance_) return layout;
        }
        return std::nullopt;
    }

    Layout with_ring(Density d) const
    {
        const std::size_t n = edges_.size();
        d.u = std::max(d.u, triangle_ ? 3 : 2);
        d.v = std::max(d.v, triangle_ ? 3 : 2);
        // A ring as wide as a cell, or narrower: its corners are as wide as the rings beside it.
        const auto limit_reach = [&] {
            for (std::size_t k = 0; k < n; ++k)
                d.reach[k] = std::min(d.reach[k], 1.0 / (k % 2 == 0 || triangle_ ? d.v : d.u));
        };
        d.reach.fill(1.0);
        limit_reach();
        for (int round = 0; round < 200; ++round) {
            current_progress().check();
            check_size(d);
            Layout layout;
            const auto rows = triangle_ ? triangle_inside(d, layout) : rectangle_inside(d, layout);
            layout.bound = error_of(layout.triangles, inside_);
            bool finer = layout.bound > tolerance_, narrower = false;
            for (std::size_t k = 0; k < n; ++k) {
                const int edge = static_cast<int>(k);
                std::vector<Corner> ring;
                zip(
                    edges_[k].places, rows[k],
                    [&](const Vec2& p) { return along(triangle_, edge, p); }, ring);
                const double error = strip_error(ring, edge, d.reach[k]);
                layout.bound = std::max(layout.bound, error);
                layout.triangles.insert(layout.triangles.end(), ring.begin(), ring.end());
                if (error <= tolerance_) continue;
                // However narrow, a ring keeps the error along the edge. The edge's own segments
                // take half of the tolerance; cells inside may have to make room for them.
                if (strip_error(ring, edge, 0.0) > tolerance_) {
                    finer = true;
                } else {
                    narrower = true;
                    d.reach[k] *= 0.5;
                }
            }
            if (!finer && !narrower) return layout;
            if (finer) {
                d.u = static_cast<int>(1.25 * d.u) + 1;
                d.v = static_cast<int>(1.25 * d.v) + 1;
                limit_reach();
            }
        }
        throw ToleranceNotMet(
            "tessellate: tolerance " + to_text(tolerance_) + " is not reached along an edge",
            tolerance_, std::numeric_limits<double>::infinity(), {});
    }

    // Of ring triangles, from derivatives within `reach` of the edge; with reach 0 from what
    // remains of them as the ring narrows.
    double strip_error(const std::vector<Corner>& ring, int edge, double reach) const
    {
        const DerivativeBounds& bounds = edges_[static_cast<std::size_t>(edge)].bounds;
        const SecondBounds d = bounds.within(triangle_ ? 0 : edge, reach);
        double worst = 0.0;
        for (Corner t : ring) {
            if (triangle_)
                for (Place& p : t) p.uv = turned(p.uv, edge);
            double x = span_of(t, 0), y = span_of(t, 1);
            if (reach == 0.0) (triangle_ || edge % 2 == 0 ? y : x) = 0.0;
            worst = std::max(worst, d.error(x, y));
        }
        return worst;
    }

    bool triangle_;
    SecondBounds inside_;
    std::vector<PatchEdge> edges_;
    double tolerance_;
    std::int64_t max_triangles_;
};

// ---- All patches ------------------------------------------------------------------------------

struct PatchView {
    bool triangle, rational;
    int m, n, edges;
    std::vector<Vec4> h;
    Box3 box;

    explicit PatchView(const TensorPatch& p)
        : triangle(false),
          rational(p.rational()),
          m(p.degree_u()),
          n(p.degree_v()),
          edges(4),
          h(p.homogeneous()),
          box(p.bounds())
    {
    }
    explicit PatchView(const BezierTriangle& p)
        : triangle(true),
          rational(p.rational()),
          m(p.degree()),
          n(p.degree()),
          edges(3),
          h(p.homogeneous()),
          box(p.bounds())
    {
    }
    DerivativeBounds derivative_bounds(const Vec3& center) const
    {
        return DerivativeBounds(triangle, m, n, h, rational, center);
    }
    /// Of evaluation, in bulk or by de Casteljau.
    double rounding() const
    {
        return 16.0 * kEpsilon * (m + n + 4) * (norm(box.min) + norm(box.max));
    }
    /// In coordinates along and across edge k of a triangle.
    DerivativeBounds strip_bounds(int k, const Vec3& center) const
    {
        if (!triangle) return derivative_bounds(center);
        return DerivativeBounds(true, m, n, turned(h, n, k), rational, center);
    }
};

class Tessellation {
public:
    Tessellation(std::span<const Patch> patches, const TessellateOptions& options)
        : patches_(patches), options_(options)
    {
    }

    TessellatedPatches run()
    {
        find_edges();
        place_edge_vertices();
        for (std::size_t k = 0; k < patches_.size(); ++k) add_patch(k);
        if (result_.bound > options_.tolerance) below_rounding(result_.bound);
        return std::move(result_);
    }

private:
    [[noreturn]] void below_rounding(double reached) const
    {
        throw ToleranceNotMet(
            "tessellate: tolerance " + to_text(options_.tolerance) + " is below rounding",
            options_.tolerance, reached, {});
    }

    void find_edges()
    {
        for (const Patch& patch : patches_) {
            uses_.emplace_back();
            std::visit(
                [&](const auto& p) {
                    const PatchView view(p);
                    if (view.rounding() >= options_.tolerance) below_rounding(view.rounding());
                    for (int k = 0; k < view.edges; ++k)
                        uses_.back().push_back(table_.add(p.edge(k)));
                },
                patch);
        }
        const auto turned = table_.settle();
        for (auto& patch : uses_)
            for (EdgeUse& use : patch)
                if (turned[use.edge_class]) use.forward = !use.forward;
    }

    // Half of the tolerance: the rest is for what the ring adds across the edge.
    void place_edge_vertices()
    {
        for (EdgeClass& e : table_.classes()) {
            e.segments = collapsed(e.curve)
                             ? 1
                             : segments_for(curve_bounds(e.curve).uu, 0.5 * options_.tolerance);
            require_room(static_cast<double>(result_.mesh.vertices.size()) + e.segments);
            e.vertices.push_back(corner(e.curve.points().front()));
            for (int s = 1; s < e.segments; ++s)
                e.vertices.push_back(
                    add_vertex(e.curve.value(static_cast<double>(s) / e.segments)));
            e.vertices.push_back(corner(e.curve.points().back()));
        }
    }

    std::int32_t add_vertex(const Vec3& p)
    {
        result_.mesh.vertices.push_back(p);
        return static_cast<std::int32_t>(result_.mesh.vertices.size() - 1);
    }

    std::int32_t corner(const Vec3& p)
    {
        const auto [place, added] = corners_.emplace(key_of(p), 0);
        if (added) place->second = add_vertex(p);
        return place->second;
    }

    void require_room(double vertices) const
    {
        if (vertices < static_cast<double>(options_.max_triangles) && vertices < 2e9) return;
        throw ToleranceNotMet("tessellate: tolerance " + to_text(options_.tolerance) +
                                  " needs more triangles than allowed",
                              options_.tolerance, std::numeric_limits<double>::infinity(), {});
    }

    void add_patch(std::size_t number)
    {
        std::visit(
            [&](const auto& patch) {
                const PatchView view(patch);
                std::vector<PatchEdge> edges;
                double mismatch = 0.0;
                for (int k = 0; k < view.edges; ++k) {
                    const EdgeUse use = uses_[number][static_cast<std::size_t>(k)];
                    const EdgeClass& e = table_.classes()[use.edge_class];
                    mismatch = std::max(mismatch, e.mismatch);
                    edges.push_back({{}, view.strip_bounds(k, e.curve.bounds().center())});
                    for (int s = 0; s <= e.segments; ++s) {
                        const int t = use.forward ? s : e.segments - s;
                        edges.back().places.push_back(
                            {patch.on_edge(k, static_cast<double>(s) / e.segments),
                             e.vertices[static_cast<std::size_t>(t)]});
                    }
                }
                PatchTriangulator triangulator(
                    view.triangle, view.derivative_bounds(view.box.center()), std::move(edges),
                    options_.tolerance * (1.0 - 1e-9), options_.max_triangles);
                // Rounding of the evaluation and of merged edges.
                const double slack = mismatch + 16.0 * kEpsilon * (view.m + view.n + 4) *
                                                    (norm(view.box.min) + norm(view.box.max));
                Layout layout = triangulator.run();
                layout.bound += slack;
                append(number, patch, layout);
            },
            patches_[number]);
    }

    template <class P>
    void append(std::size_t number, const P& patch, const Layout& layout)
    {
        const std::size_t first = result_.mesh.vertices.size();
        require_room(static_cast<double>(result_.mesh.faces.size() + layout.triangles.size()));
        std::vector<double> u, v;
        for (const Vec2& p : layout.inner) {
            u.push_back(p[0]);
            v.push_back(p[1]);
        }
        result_.mesh.vertices.resize(first + u.size());
        patch.evaluate(u, v, std::span(result_.mesh.vertices).subspan(first));
        for (const Corner& t : layout.triangles) {
            Triangle face;
            for (std::size_t k = 0; k < 3; ++k)
                face[k] = t[k].vertex >= 0 ? t[k].vertex
                                           : static_cast<std::int32_t>(first) - 1 - t[k].vertex;
            // At a collapsed edge a triangle may have lost a side.
            if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;
            result_.mesh.faces.push_back(face);
            result_.patch_of_face.push_back(static_cast<std::int32_t>(number));
            result_.corners.push_back({t[0].uv, t[1].uv, t[2].uv});
        }
        result_.bound = std::max(result_.bound, layout.bound);
    }

    std::span<const Patch> patches_;
    const TessellateOptions& options_;
    EdgeTable table_;
    std::vector<std::vector<EdgeUse>> uses_;
    std::map<Key, std::int32_t> corners_;
    TessellatedPatches result_;
};

}  // namespace

TessellatedPatches tessellate(std::span<const Patch> patches, const TessellateOptions& options)
{
    require(options.tolerance > 0.0 && std::isfinite(options.tolerance), "tessellate: tolerance",
            options.tolerance, "positive and finite");
    return Tessellation(patches, options).run();
}

std::vector<std::vector<PatchEdgeUse>> common_edges(std::span<const Patch> patches)
{
    EdgeTable table;
    std::vector<std::vector<PatchEdgeUse>> uses;
    for (std::size_t p = 0; p < patches.size(); ++p)
        std::visit(
            [&](const auto& patch) {
                for (int k = 0; k < PatchView(patch).edges; ++k) {
                    const EdgeUse use = table.add(patch.edge(k));
                    uses.resize(table.classes().size());
                    uses[use.edge_class].push_back({static_cast<std::int32_t>(p), k, use.forward});
                }
            },
            patches[p]);
    std::vector<std::vector<PatchEdgeUse>> result;
    for (std::size_t e = 0; e < uses.size(); ++e)
        if (!collapsed(table.classes()[e].curve)) result.push_back(std::move(uses[e]));
    return result;
}

TessellatedPatches tessellate(const BSplineSurface& surface, const TessellateOptions& options)
{
    std::vector<Patch> patches;
    for (auto& p : surface.bezier_patches()) patches.emplace_back(std::move(p));
    return tessellate(patches, options);
}

namespace {

// Points of the faces in given shares of the corners, and their parameters.
struct FacePoints {
    std::vector<double> u, v;
    std::vector<Vec3> on_mesh;
};

double largest_distance(const Patch& patch, const FacePoints& points)
{
    std::vector<Vec3> on_patch(points.u.size());
    std::visit([&](const auto& p) { p.evaluate(points.u, points.v, on_patch); }, patch);
    double largest = 0.0;
    for (std::size_t i = 0; i < on_patch.size(); ++i)
        largest = std::max(largest, distance(on_patch[i], points.on_mesh[i]));
    return largest;
}

}  // namespace

double measured_deviation(std::span<const Patch> patches, const TessellatedPatches& made)
{
    constexpr double kThird = 1.0 / 3.0;
    constexpr std::array<std::array<double, 3>, 4> kShares = {
        {{kThird, kThird, kThird}, {0.5, 0.5, 0.0}, {0.0, 0.5, 0.5}, {0.5, 0.0, 0.5}}};
    double largest = 0.0;
    // The faces of a patch stand together.
    for (std::size_t f = 0; f < made.mesh.n_faces();) {
        current_progress().check();
        const std::int32_t patch = made.patch_of_face[f];
        FacePoints points;
        for (; f < made.mesh.n_faces() && made.patch_of_face[f] == patch; ++f)
            for (const auto& share : kShares) {
                Vec2 uv{};
                Vec3 p{};
                for (std::size_t k = 0; k < 3; ++k) {
                    uv += share[k] * made.corners[f][k];
                    p += share[k] *
                         made.mesh.vertices[static_cast<std::size_t>(made.mesh.faces[f][k])];
                }
                points.u.push_back(std::clamp(uv[0], 0.0, 1.0));
                points.v.push_back(std::clamp(uv[1], 0.0, 1.0));
                points.on_mesh.push_back(p);
            }
        largest =
            std::max(largest, largest_distance(patches[static_cast<std::size_t>(patch)], points));
    }
    return largest;
}

}  // namespace genus
