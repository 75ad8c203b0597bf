#include "genus/patch/bezier_curve.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "genus/base/error.h"
#include "genus/base/linear_solve.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/patch/bulk.h"
#include "genus/patch/control_points.h"

namespace genus {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxDepth = 48;  // halvings; a piece is then 2^-48 of the curve

Vec3 project(const Vec4& p)
{
    return {{p[0] / p[3], p[1] / p[3], p[2] / p[3]}};
}

Vec3 xyz(const Vec4& p)
{
    return {{p[0], p[1], p[2]}};
}

double largest_coordinate(std::span<const Vec3> points)
{
    double m = 0.0;
    for (const Vec3& p : points)
        for (std::size_t k = 0; k < 3; ++k) m = std::max(m, std::fabs(p[k]));
    return m;
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b)
{
    const Vec3 d = b - a;
    const double dd = dot(d, d);
    const double s = dd > 0.0 ? std::clamp(dot(p - a, d) / dd, 0.0, 1.0) : 0.0;
    return distance(p, a + s * d);
}

}  // namespace

BezierCurve::BezierCurve(std::vector<Vec3> points, std::vector<double> weights)
    : points_(std::move(points)), weights_(std::move(weights))
{
    require(!points_.empty() && points_.size() <= kMaxDegree + 1, "BezierCurve: number of points",
            static_cast<double>(points_.size()), "in [1, 513]");
    control::check("BezierCurve", points_, weights_);
}

BezierCurve BezierCurve::from_homogeneous(std::span<const Vec4> points)
{
    auto [p, w] = control::projected("BezierCurve", points);
    return BezierCurve(std::move(p), std::move(w));
}

std::vector<Vec4> BezierCurve::homogeneous() const
{
    return control::homogeneous(points_, weights_);
}

Vec3 BezierCurve::value(double t) const
{
    if (!rational()) return bernstein::value<Vec3>(points_, t);
    return project(bernstein::value<Vec4>(homogeneous(), t));
}

Bounded<3> BezierCurve::value_with_bound(double t) const
{
    if (!rational()) return bernstein::value_with_bound<3>(points_, t);
    // The products x w were rounded on the way in.
    return bernstein::rational_value_with_bound(homogeneous(), t, 0.5 * kEpsilon);
}

std::vector<Vec3> BezierCurve::derivatives(double t, int order) const
{
    require(order >= 0 && order <= kMaxDegree, "BezierCurve::derivatives: order", order,
            "in [0, 512]");
    if (!rational()) return bernstein::derivatives<Vec3>(points_, t, order);
    return bernstein::quotient_derivatives(bernstein::derivatives<Vec4>(homogeneous(), t, order));
}

Vec3 BezierCurve::derivative(double t, int order) const
{
    return derivatives(t, order).back();
}

double BezierCurve::curvature(double t) const
{
    const auto d = derivatives(t, 2);
    const double speed = norm(d[1]);
    return speed > 0.0 ? norm(cross(d[1], d[2])) / (speed * speed * speed) : kInfinity;
}

void BezierCurve::evaluate(std::span<const double> t, std::span<Vec3> out) const
{
    require(t.size() == out.size(), "BezierCurve::evaluate: out must be as long as t");
    const std::vector<Vec4> h = rational() ? homogeneous() : std::vector<Vec4>();
    const double* c = rational() ? h[0].c.data() : points_[0].c.data();
    const int dim = rational() ? 4 : 3;
    parallel_for(t.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
        bulk::curve(c, degree(), dim, t.data() + begin, end - begin, out[begin].c.data());
    });
}

double BezierCurve::bulk_bound() const
{
    // 3 n + 3 roundings a term and n + 1 sums, u each; the division doubles numerator and
    // denominator errors. sqrt(3) makes a distance of three coordinates.
    const double roundings = 4.0 * degree() + 8.0;
    return (rational() ? 2.5 : 1.0) * std::sqrt(3.0) * 0.5 * kEpsilon * roundings *
           largest_coordinate(points_) * (1.0 + 1e-9);
}

std::pair<BezierCurve, BezierCurve> BezierCurve::split(double t) const
{
    return {segment(0.0, t), segment(t, 1.0)};
}

BezierCurve BezierCurve::segment(double a, double b) const
{
    require(std::isfinite(a) && std::isfinite(b) && a != b,
            "BezierCurve::segment: the ends must be finite and differ");
    if (!rational()) return BezierCurve(bernstein::segment<Vec3>(points_, a, b));
    return from_homogeneous(bernstein::segment<Vec4>(homogeneous(), a, b));
}

BezierCurve BezierCurve::reversed() const
{
    BezierCurve r = *this;
    std::reverse(r.points_.begin(), r.points_.end());
    std::reverse(r.weights_.begin(), r.weights_.end());
    return r;
}

BezierCurve BezierCurve::elevated(int by) const
{
    require(by >= 0 && degree() + by <= kMaxDegree, "BezierCurve::elevated: new degree",
            degree() + by, "in [0, 512] and not below the old");
    if (!rational()) {
        std::vector<Vec3> p = points_;
        for (int k = 0; k < by; ++k) p = bernstein::elevated<Vec3>(p);
        return BezierCurve(std::move(p));
    }
    std::vector<Vec4> h = homogeneous();
    for (int k = 0; k < by; ++k) h = bernstein::elevated<Vec4>(h);
    BezierCurve result = from_homogeneous(h);
    // (x w) / w need not be x; neighbours are recognised by their ends.
    result.points_.front() = points_.front();
    result.points_.back() = points_.back();
    return result;
}

namespace {

// Row i, column j: what coefficient j of degree m gives to coefficient i of degree n.
std::vector<std::vector<double>> elevation_columns(int m, int n)
{
    std::vector<std::vector<double>> columns;
    for (int j = 0; j <= m; ++j) {
        std::vector<double> unit(static_cast<std::size_t>(m) + 1);
        unit[j] = 1.0;
        for (int k = m; k < n; ++k) unit = bernstein::elevated<double>(unit);
        columns.push_back(std::move(unit));
    }
    return columns;
}

// Coefficients of degree m whose elevation is nearest to `c`, both ends kept.
std::vector<Vec4> nearest_of_degree(std::span<const Vec4> c, int m)
{
    const int n = static_cast<int>(c.size()) - 1;
    std::vector<Vec4> low(static_cast<std::size_t>(m) + 1);
    low.front() = c.front();
    low.back() = c.back();
    if (m == 1 || m == n) {
        if (m == n) low.assign(c.begin(), c.end());
        return low;
    }
    const auto e = elevation_columns(m, n);
    const std::size_t rows = c.size() - 2, cols = low.size() - 2;
    std::vector<double> a(rows * cols), b(rows * 4);
    for (std::size_t i = 0; i < rows; ++i) {
        for (std::size_t j = 0; j < cols; ++j) a[i * cols + j] = e[j + 1][i + 1];
        const Vec4 rest = c[i + 1] - e.front()[i + 1] * low.front() - e.back()[i + 1] * low.back();
        for (std::size_t k = 0; k < 4; ++k) b[i * 4 + k] = rest[k];
    }
    const auto x = LinearSolver(rows, cols, a).solve(b, 4);
    for (std::size_t j = 0; j < cols; ++j)
        for (std::size_t k = 0; k < 4; ++k) low[j + 1][k] = x[j * 4 + k];
    return low;
}

}  // namespace

std::pair<BezierCurve, double> BezierCurve::reduced(int m) const
{
    require(m >= 1 && m <= degree(), "BezierCurve::reduced: degree", m,
            "at least 1 and not above that of the curve");
    const auto h = homogeneous();
    const auto low = nearest_of_degree(h, m);
    std::vector<Vec3> points;
    for (const Vec4& p : low) points.push_back(xyz(p));
    const BezierCurve result = rational() ? from_homogeneous(low) : BezierCurve(std::move(points));

    std::vector<Vec4> back = result.homogeneous();
    for (int k = m; k < degree(); ++k) back = bernstein::elevated<Vec4>(back);
    double point_error = 0.0, weight_error = 0.0, least = kInfinity;
    for (std::size_t i = 0; i < h.size(); ++i) {
        point_error = std::max(point_error, norm(xyz(h[i] - back[i])));
        weight_error = std::max(weight_error, std::fabs(h[i][3] - back[i][3]));
        least = std::min(least, h[i][3]);
    }
    // A/w - A'/w' = (A - A' - (A'/w') (w - w')) / w; all differences lie in their hulls.
    const double size =
        std::sqrt(3.0) * std::max(largest_coordinate(points_), largest_coordinate(result.points_));
    const double slack = 8.0 * kEpsilon * (degree() + 1) * size;
    return {result, (point_error + (rational() ? weight_error * size : 0.0)) / least + slack};
}

namespace {

// A part of a curve during subdivision, in homogeneous form.
struct Part {
    std::vector<Vec4> c;
    double lo = 0.0, hi = 1.0;
    int depth = 0;

    Vec3 point(std::size_t i) const { return project(c[i]); }
    std::pair<Part, Part> halves() const
    {
        const double middle = 0.5 * (lo + hi);
        std::pair<Part, Part> p;
        p.first = {{}, lo, middle, depth + 1};
        p.second = {{}, middle, hi, depth + 1};
        bernstein::split<Vec4>(c, 0.5, p.first.c, p.second.c);
        return p;
    }
};

// Distance of the part from its chord, both ways: the hull property gives one direction, and by
// continuity every chord point has a curve point straight above it.
double chord_bound(const Part& part, bool rational)
{
    const Vec3 a = part.point(0), b = part.point(part.c.size() - 1);
    double hull = 0.0;
    for (std::size_t i = 1; i + 1 < part.c.size(); ++i)
        hull = std::max(hull, distance_to_segment(part.point(i), a, b));
    if (rational || part.c.size() < 3) return hull;
    double second = 0.0;
    for (std::size_t i = 0; i + 2 < part.c.size(); ++i)
        second = std::max(second, norm(xyz(part.c[i] - 2.0 * part.c[i + 1] + part.c[i + 2])));
    const double n = static_cast<double>(part.c.size() - 1);
    return std::min(hull, n * (n - 1.0) / 8.0 * second);
}

// Rounding of up to kMaxDepth splits: each moves a point by at most n u times the largest.
double subdivision_rounding(const BezierCurve& curve)
{
    return (curve.rational() ? 3.0 : 1.0) * std::sqrt(3.0) * (kMaxDepth + 1) * 0.5 * kEpsilon *
           (curve.degree() + 1) * largest_coordinate(curve.points());
}

void require_tolerance(const char* name, double tolerance)
{
    require(tolerance > 0.0 && std::isfinite(tolerance), name, tolerance, "positive and finite");
}

[[noreturn]] void give_up(const char* what, double tolerance, double reached, const Box3& where)
{
    throw ToleranceNotMet(std::string(what) + ": tolerance " + to_text(tolerance) +
                              " is below rounding, reached " + to_text(reached),
                          tolerance, reached, {where});
}

}  // namespace

FlattenedCurve BezierCurve::flatten(double tolerance) const
{
    require_tolerance("BezierCurve::flatten: tolerance", tolerance);
    const double slack = subdivision_rounding(*this);
    if (slack >= tolerance) give_up("BezierCurve::flatten", tolerance, 2.0 * slack, bounds());
    FlattenedCurve result;
    result.parameters.push_back(0.0);
    result.points.push_back(points_.front());
    std::vector<Part> stack = {{homogeneous()}};
    while (!stack.empty()) {
        Part part = std::move(stack.back());
        stack.pop_back();
        const double bound = chord_bound(part, rational()) + slack;
        if (bound <= tolerance) {
            result.bound = std::max(result.bound, bound);
            result.parameters.push_back(part.hi);
            result.points.push_back(part.hi == 1.0 ? points_.back()
                                                   : part.point(part.c.size() - 1));
            continue;
        }
        if (part.depth == kMaxDepth) give_up("BezierCurve::flatten", tolerance, bound, bounds());
        current_progress().check();
        auto [left, right] = part.halves();
        stack.push_back(std::move(right));
        stack.push_back(std::move(left));
    }
    return result;
}

namespace {

constexpr std::size_t kGaussPoints = 12;

struct GaussRule {
    std::array<double, kGaussPoints> x, w;
};

// Zeros of the Legendre polynomial by Newton from points that interlace with them.
GaussRule make_gauss_rule()
{
    GaussRule rule{};
    const double n = kGaussPoints;
    const double pi = 3.14159265358979323846;
    for (std::size_t i = 0; i < kGaussPoints; ++i) {
        long double x = std::cos(pi * (static_cast<double>(i) + 0.75) / (n + 0.5)), slope = 1.0L;
        for (int step = 0; step < 8; ++step) {
            long double p = 1.0L, before = 0.0L;
            for (std::size_t k = 1; k <= kGaussPoints; ++k) {
                const long double kk = static_cast<long double>(k);
                const long double next = ((2.0L * kk - 1.0L) * x * p - (kk - 1.0L) * before) / kk;
                before = p;
                p = next;
            }
            slope = static_cast<long double>(n) * (x * p - before) / (x * x - 1.0L);
            x -= p / slope;
        }
        rule.x[i] = static_cast<double>(x);
        rule.w[i] = static_cast<double>(2.0L / ((1.0L - x * x) * slope * slope));
    }
    return rule;
}

using Powers = std::vector<double>;  // coefficients by ascending power

double at(const Powers& p, double x)
{
    double sum = 0.0;
    for (std::size_t k = p.size(); k-- > 0;) sum = sum * x + p[k];
    return sum;
}

Powers times(const Powers& a, const Powers& b)
{
    Powers c(a.size() + b.size() - 1);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < b.size(); ++j) c[i + j] += a[i] * b[j];
    return c;
}

Powers slope(const Powers& a)
{
    Powers d(std::max<std::size_t>(a.size() - 1, 1));
    for (std::size_t k = 1; k < a.size(); ++k) d[k - 1] = static_cast<double>(k) * a[k];
    return d;
}

void add_to(Powers& a, const Powers& b, double factor)
{
    a.resize(std::max(a.size(), b.size()));
    for (std::size_t k = 0; k < b.size(); ++k) a[k] += factor * b[k];
}

// Integrates the speed sqrt(q) / w^2 of a curve, piece by piece.
class SpeedIntegral {
public:
    explicit SpeedIntegral(const BezierCurve& curve) : rational_(curve.rational())
    {
        std::vector<Vec4> d = curve.homogeneous();
        // Centred, for the sake of the weights' products.
        const Vec3 center = curve.bounds().center();
        for (Vec4& p : d)
            for (std::size_t k = 0; k < 3; ++k) p[k] -= center[k] * p[3];
        while (true) {
            differences_.push_back(d);
            if (d.size() == 1) break;
            d = bernstein::differences<Vec4>(d);
        }
    }

    /// Over [c - r, c + r]; nothing if the speed may not be analytic on the ellipse.
    std::optional<CurveLength> piece(double c, double r) const
    {
        const auto [q, w] = speed_squared(c, r);
        constexpr double rho = 4.0, reach = 0.5 * (rho + 1.0 / rho);
        const double q_spread = spread(q, reach), w_spread = spread(w, reach);
        if (!(q_spread < q[0]) || !(w_spread < w[0])) return std::nullopt;
        // |speed| on the ellipse |z - 1| + |z + 1| = rho + 1/rho.
        const double most = std::sqrt(q[0] + q_spread) / ((w[0] - w_spread) * (w[0] - w_spread));
        static const GaussRule rule = make_gauss_rule();
        double sum = 0.0;
        for (std::size_t i = 0; i < kGaussPoints; ++i) {
            const double wi = at(w, rule.x[i]);
            sum += rule.w[i] * std::sqrt(std::max(0.0, at(q, rule.x[i]))) / (wi * wi);
        }
        // The rule is exact below degree 2 K. Chebyshev coefficients are at most 2 M rho^-j, and
        // integral and rule of T_j differ by at most 2 + 2 / (j^2 - 1) for even j, by 0 for odd.
        const double tail = std::pow(rho, -2.0 * kGaussPoints) / (1.0 - 1.0 / (rho * rho));
        return CurveLength{sum, 4.1 * most * tail + 40.0 * kEpsilon * most};
    }

private:
    // Numerator and denominator's root of the squared speed on [-1, 1].
    std::pair<Powers, Powers> speed_squared(double c, double r) const
    {
        const std::size_t n = differences_.size() - 1;
        std::array<Powers, 4> p;
        double scale = 1.0;
        for (std::size_t k = 0; k <= n; ++k, scale *= r) {
            const double factor =
                bernstein::binomial(static_cast<int>(n), static_cast<int>(k)) * scale;
            const Vec4 a = bernstein::value<Vec4>(differences_[k], c);
            for (std::size_t i = 0; i < 4; ++i) p[i].push_back(factor * a[i]);
        }
        if (!rational_) p[3] = {1.0};
        Powers q = {0.0};
        for (std::size_t i = 0; i < 3; ++i) {
            Powers numerator = times(slope(p[i]), p[3]);
            if (rational_) add_to(numerator, times(p[i], slope(p[3])), -1.0);
            add_to(q, times(numerator, numerator), 1.0);
        }
        return {q, p[3]};
    }

    static double spread(const Powers& p, double reach)
    {
        double sum = 0.0, power = 1.0;
        for (std::size_t k = 1; k < p.size(); ++k) sum += std::fabs(p[k]) * (power *= reach);
        return sum;
    }

    bool rational_;
    std::vector<std::vector<Vec4>> differences_;
};

// Chord and control polygon bracket the length.
CurveLength bracketed_length(const BezierCurve& curve)
{
    double polygon = 0.0;
    const auto& p = curve.points();
    for (std::size_t i = 1; i < p.size(); ++i) polygon += distance(p[i - 1], p[i]);
    const double chord = distance(p.front(), p.back());
    return {0.5 * (polygon + chord), 0.5 * (polygon - chord)};
}

}  // namespace

CurveLength BezierCurve::length(double tolerance, double a, double b) const
{
    require_tolerance("BezierCurve::length: tolerance", tolerance);
    require(std::isfinite(a) && std::isfinite(b) && a <= b,
            "BezierCurve::length: the ends must be finite and in order");
    if (a == b || degree() == 0) return {};
    const double n = degree() + 1.0;
    const double size = bounds().diagonal();
    CurveLength total{0.0, 4.0 * n * n * kEpsilon * size};
    // Below rounding no piece is short enough.
    if (total.bound > tolerance) give_up("BezierCurve::length", tolerance, total.bound, bounds());
    constexpr int kMostPieces = 1 << 17;
    int n_pieces = 0;
    const SpeedIntegral speed(*this);
    std::vector<Vec3> pieces = {{{a, b, 0.0}}};  // from, to, depth
    while (!pieces.empty()) {
        const Vec3 piece = pieces.back();
        pieces.pop_back();
        const double lo = piece[0], hi = piece[1], middle = 0.5 * (lo + hi);
        const double share = 0.5 * tolerance * (hi - lo) / (b - a);
        auto part = speed.piece(middle, 0.5 * (hi - lo));
        if (!part || part->bound > share) {
            const auto rough = bracketed_length(segment(lo, hi));
            if (!part || rough.bound < part->bound) part = rough;
        }
        if (part->bound > share && piece[2] < kMaxDepth && ++n_pieces < kMostPieces) {
            current_progress().check();
            pieces.push_back({{middle, hi, piece[2] + 1}});
            pieces.push_back({{lo, middle, piece[2] + 1}});
            continue;
        }
        total.length += part->length;
        total.bound += part->bound;
    }
    if (total.bound > tolerance) give_up("BezierCurve::length", tolerance, total.bound, bounds());
    return total;
}

namespace {

// A lower bound of the distance from p to a part: the coefficients of |C - p|^2, for rational
// parts the quotients of those of |A - p w|^2 and w^2. Formed from the part's own points, so that
// rounding stays small against the distance.
double least_distance(const Part& part, const Vec3& p, bool rational)
{
    std::vector<double> above, below, d(part.c.size());
    double reach = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < d.size(); ++i) {
            const double w = part.c[i][3];
            d[i] = part.c[i][k] - p[k] * w;
            reach = std::max(reach, std::fabs(d[i]) / w);
        }
        const auto square = bernstein::product(d, d);
        above.resize(square.size());
        for (std::size_t i = 0; i < square.size(); ++i) above[i] += square[i];
    }
    if (rational) {
        for (std::size_t i = 0; i < d.size(); ++i) d[i] = part.c[i][3];
        below = bernstein::product(d, d);
    }
    double least = kInfinity;
    for (std::size_t i = 0; i < above.size(); ++i)
        least = std::min(least, rational ? above[i] / below[i] : above[i]);
    least -= 8.0 * kEpsilon * static_cast<double>(above.size() + 4) * 3.0 * reach * reach;
    return std::sqrt(std::max(0.0, least));
}

// Newton for (C - p) . C' = 0, kept to [0, 1] and never farther than where it began.
double polish(const BezierCurve& curve, const Vec3& p, double t)
{
    double best = distance(curve.value(t), p);
    for (int step = 0; step < 20; ++step) {
        const auto d = curve.derivatives(t, 2);
        const Vec3 e = d[0] - p;
        const double f = dot(e, d[1]), slope_f = dot(d[1], d[1]) + dot(e, d[2]);
        if (!(slope_f > 0.0)) break;
        const double next = std::clamp(t - f / slope_f, 0.0, 1.0);
        const double there = distance(curve.value(next), p);
        if (there > best || next == t) break;
        best = there;
        t = next;
    }
    return t;
}

}  // namespace

NearestOnCurve BezierCurve::nearest(const Vec3& p, double tolerance) const
{
    require_tolerance("BezierCurve::nearest: tolerance", tolerance);
    require(is_finite(p), "BezierCurve::nearest: the point is not finite");
    NearestOnCurve best;
    best.distance = kInfinity;
    const auto offer = [&](double t) {
        const Vec3 point = value(t);
        const double d = distance(point, p);
        if (d < best.distance) best = {t, point, d, 0.0};
    };
    offer(0.0);
    offer(1.0);
    offer(polish(*this, p, 0.5));

    const double slack = subdivision_rounding(*this);
    double least = kInfinity;  // of all bounds at which a part was dropped
    std::vector<std::pair<Part, double>> stack = {{Part{homogeneous()}, 0.0}};
    while (!stack.empty()) {
        auto [part, low] = std::move(stack.back());
        stack.pop_back();
        const double keep = std::max(0.0, best.distance - tolerance);
        if (low < keep) low = std::max(0.0, least_distance(part, p, rational()) - slack);
        if (low >= keep || part.depth == kMaxDepth) {
            least = std::min(least, low);
            continue;
        }
        current_progress().check();
        auto [left, right] = part.halves();
        const double before = best.distance;
        offer(left.hi);
        if (best.distance < before) offer(polish(*this, p, left.hi));
        const Vec3 middle = right.point(0);
        // Too small to matter: no point of it is farther from its middle than its control points.
        double radius = 0.0;
        for (std::size_t i = 0; i < part.c.size(); ++i)
            radius = std::max(radius, distance(part.point(i), middle));
        if (radius <= 0.25 * tolerance) {
            least = std::min(least, distance(middle, p) - radius - slack);
            continue;
        }
        stack.emplace_back(std::move(right), low);
        stack.emplace_back(std::move(left), low);
    }
    best.bound = std::max(0.0, best.distance - least);
    return best;
}

Box3 BezierCurve::bounds() const
{
    return control::bounds(points_);
}

BezierCurve transformed(const BezierCurve& curve, const Transform& map)
{
    return BezierCurve(control::transformed(curve.points(), map), curve.weights());
}

std::vector<bernstein::Root> intersect_plane(const BezierCurve& curve, const Vec3& normal,
                                             double offset)
{
    require(norm(normal) > 0.0, "intersect_plane: the normal is zero");
    std::vector<double> d;
    for (std::size_t i = 0; i < curve.points().size(); ++i) {
        const double w = curve.rational() ? curve.weights()[i] : 1.0;
        d.push_back((dot(normal, curve.points()[i]) - offset) * w);
    }
    return bernstein::roots(d);
}

namespace {

struct Range {
    double lo, hi;
    double width() const { return hi - lo; }
};

// Where the hull of (i / n, d_i) lies below `limit`.
std::optional<Range> hull_below(std::span<const double> d, double limit)
{
    const std::size_t n = d.size() - 1;
    Range r{2.0, -1.0};
    const auto take = [&](double t) { r = {std::min(r.lo, t), std::max(r.hi, t)}; };
    for (std::size_t i = 0; i <= n; ++i) {
        const double ti = n == 0 ? 0.0 : static_cast<double>(i) / static_cast<double>(n);
        if (d[i] <= limit) take(ti);
        for (std::size_t j = i + 1; j <= n; ++j) {
            if ((d[i] <= limit) == (d[j] <= limit)) continue;
            const double tj = static_cast<double>(j) / static_cast<double>(n);
            take(ti + (tj - ti) * std::clamp((limit - d[i]) / (d[j] - d[i]), 0.0, 1.0));
        }
    }
    if (r.lo > r.hi) return std::nullopt;
    return Range{std::max(0.0, r.lo - 0x1p-40), std::min(1.0, r.hi + 0x1p-40)};
}

// Parameters of `a` at which it may lie between the two planes that enclose `b` along `normal`.
std::optional<Range> clip(const Part& a, const Part& b, const Vec3& normal, double tolerance)
{
    const Vec3 origin = b.point(0);
    double low = 0.0, high = 0.0;
    for (std::size_t i = 0; i < b.c.size(); ++i) {
        const double d = dot(normal, b.point(i) - origin);
        low = std::min(low, d);
        high = std::max(high, d);
    }
    // Homogeneous, so that the hull argument holds for rational curves: w (d - limit) <= 0.
    std::vector<double> above, below;
    for (std::size_t i = 0; i < a.c.size(); ++i) {
        const double w = a.c[i][3], d = dot(normal, a.point(i) - origin);
        above.push_back((d - high - tolerance) * w);
        below.push_back((low - tolerance - d) * w);
    }
    const auto first = hull_below(above, 0.0), second = hull_below(below, 0.0);
    if (!first || !second) return std::nullopt;
    const Range both{std::max(first->lo, second->lo), std::min(first->hi, second->hi)};
    if (both.lo > both.hi) return std::nullopt;
    return both;
}

// Two directions across the chord of b; a closed or tiny part takes any.
std::array<Vec3, 3> fat_plane_normals(const Part& b)
{
    const Vec3 chord = normalized(b.point(b.c.size() - 1) - b.point(0));
    std::size_t least = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::fabs(chord[k]) < std::fabs(chord[least])) least = k;
    Vec3 axis;
    axis[least] = 1.0;
    const Vec3 side = norm(chord) > 0.0 ? normalized(cross(chord, axis)) : Vec3{{1, 0, 0}};
    const Vec3 up = norm(chord) > 0.0 ? cross(chord, side) : Vec3{{0, 1, 0}};
    return {side, up, norm(chord) > 0.0 ? chord : Vec3{{0, 0, 1}}};
}

Part restricted(const Part& p, const Range& r)
{
    const double width = p.hi - p.lo;
    Part q{{}, p.lo + r.lo * width, p.lo + r.hi * width, p.depth};
    q.c = bernstein::segment<Vec4>(p.c, r.lo, r.hi);
    return q;
}

class CurveCurve {
public:
    CurveCurve(const BezierCurve& a, const BezierCurve& b, double tolerance)
        : a_(a), b_(b), tolerance_(tolerance)
    {
    }

    CurveCrossings run()
    {
        std::vector<std::pair<Part, Part>> stack = {{{a_.homogeneous()}, {b_.homogeneous()}}};
        // Pairs that stay undecided multiply only where the curves run together.
        for (int steps = 0; !stack.empty(); ++steps) {
            if (steps > kMaxSteps) {
                result_.overlap = true;
                break;
            }
            current_progress().check();
            auto [p, q] = std::move(stack.back());
            stack.pop_back();
            if (!shrink(p, q) || !shrink(q, p)) continue;
            if (size(p) <= 0.25 * tolerance_ && size(q) <= 0.25 * tolerance_) {
                offer(0.5 * (p.lo + p.hi), 0.5 * (q.lo + q.hi));
                continue;
            }
            cut(stack, std::move(p), std::move(q));
        }
        return finish();
    }

private:
    static constexpr int kMaxSteps = 20000;

    static double size(const Part& p)
    {
        Box3 box;
        for (std::size_t i = 0; i < p.c.size(); ++i) box.add(p.point(i));
        return box.diagonal();
    }

    // Clips `p` by the planes round `q` while that takes off a fifth or more.
    bool shrink(Part& p, const Part& q) const
    {
        for (int round = 0; round < 8; ++round) {
            Range range{0.0, 1.0};
            for (const Vec3& normal : fat_plane_normals(q)) {
                const auto r = clip(p, q, normal, tolerance_);
                if (!r) return false;
                range = {std::max(range.lo, r->lo), std::min(range.hi, r->hi)};
                if (range.lo > range.hi) return false;
            }
            if (range.width() > 0.8 || (p.hi - p.lo) * range.width() < 0x1p-50) return true;
            p = restricted(p, range);
        }
        return true;
    }

    void cut(std::vector<std::pair<Part, Part>>& stack, Part p, Part q) const
    {
        if (size(p) >= size(q)) {
            auto [left, right] = p.halves();
            stack.emplace_back(std::move(right), q);
            stack.emplace_back(std::move(left), std::move(q));
        } else {
            auto [left, right] = q.halves();
            stack.emplace_back(p, std::move(right));
            stack.emplace_back(std::move(p), std::move(left));
        }
    }

    // Gauss-Newton on |a(s) - b(t)|, then one entry for each place.
    void offer(double s, double t)
    {
        for (int step = 0; step < 10; ++step) {
            const auto da = a_.derivatives(s, 1), db = b_.derivatives(t, 1);
            const Vec3 e = da[0] - db[0];
            const double aa = dot(da[1], da[1]), bb = dot(db[1], db[1]), ab = dot(da[1], db[1]);
            const double det = aa * bb - ab * ab;
            if (!(det > 1e-12 * aa * bb)) break;
            const double ea = dot(e, da[1]), eb = dot(e, db[1]);
            const double s2 = std::clamp(s + (eb * ab - ea * bb) / det, 0.0, 1.0);
            const double t2 = std::clamp(t + (eb * aa - ea * ab) / det, 0.0, 1.0);
            if (distance(a_.value(s2), b_.value(t2)) > norm(e)) break;
            if (s2 == s && t2 == t) break;
            s = s2;
            t = t2;
        }
        const Vec3 pa = a_.value(s), pb = b_.value(t);
        if (distance(pa, pb) <= tolerance_)
            result_.crossings.push_back({s, t, 0.5 * (pa + pb), distance(pa, pb)});
    }

    CurveCrossings finish()
    {
        auto& all = result_.crossings;
        std::sort(all.begin(), all.end(), [](const CurveCrossing& x, const CurveCrossing& y) {
            return x.s != y.s ? x.s < y.s : x.t < y.t;
        });
        std::vector<CurveCrossing> kept;
        for (const CurveCrossing& c : all) {
            bool known = false;
            for (auto k = kept.rbegin(); k != kept.rend() && !known; ++k)
                known = distance(k->point, c.point) <= 4.0 * tolerance_ &&
                        std::fabs(k->s - c.s) < 1e-3 && std::fabs(k->t - c.t) < 1e-3;
            if (!known) kept.push_back(c);
        }
        all = std::move(kept);
        return std::move(result_);
    }

    const BezierCurve& a_;
    const BezierCurve& b_;
    double tolerance_;
    CurveCrossings result_;
};

}  // namespace

CurveCrossings intersect(const BezierCurve& a, const BezierCurve& b, double tolerance)
{
    require_tolerance("intersect: tolerance", tolerance);
    return CurveCurve(a, b, tolerance).run();
}

CurveJoin join(const BezierCurve& a, const BezierCurve& b, double ratio)
{
    require(ratio > 0.0 && std::isfinite(ratio), "join: ratio", ratio, "positive and finite");
    const auto da = a.derivatives(1.0, 2), db = b.derivatives(0.0, 2);
    const auto curvature_vector = [](const std::vector<Vec3>& d) {
        const double ss = dot(d[1], d[1]);
        return ss > 0.0 ? (d[2] - (dot(d[1], d[2]) / ss) * d[1]) / ss : Vec3{};
    };
    CurveJoin j;
    j.gap = distance(da[0], db[0]);
    j.kink = distance(da[1], db[1] / ratio);
    j.bend = distance(da[2], db[2] / (ratio * ratio));
    j.turn = std::atan2(norm(cross(da[1], db[1])), dot(da[1], db[1]));
    j.curvature = distance(curvature_vector(da), curvature_vector(db));
    return j;
}

std::vector<Vec3> continuation(const BezierCurve& a, int order, double ratio)
{
    require(order >= 0 && order <= a.degree(), "continuation: order", order,
            "in [0, degree of the curve]");
    require(ratio > 0.0 && std::isfinite(ratio), "continuation: ratio", ratio,
            "positive and finite");
    require(!a.rational(), "continuation: the curve must be polynomial");
    // The first k + 1 points of the part over [1, 1 + ratio] need the last k + 1 of a only.
    const std::span<const Vec3> last(a.points().end() - order - 1, a.points().end());
    std::vector<Vec3> before, after;
    bernstein::split<Vec3>(last, 1.0 + ratio, before, after);
    std::reverse(after.begin(), after.end());
    return after;
}

Vec3 a_frame_apex(const BezierCurve& a, double ratio)
{
    require(a.degree() >= 2, "a_frame_apex: degree", a.degree(), "at least 2");
    const auto& b = a.points();
    const std::size_t n = b.size() - 1;
    return b[n - 1] + ratio * (b[n - 1] - b[n - 2]);
}

}  // namespace genus
