#include "genus/patch/bspline.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>

#include "genus/base/error.h"
#include "genus/base/linear_solve.h"
#include "genus/base/parallel.h"
#include "genus/base/transform.h"
#include "genus/patch/control_points.h"

namespace genus {

namespace {

std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

}  // namespace

KnotVector::KnotVector(int degree, std::vector<double> knots)
    : degree_(degree), knots_(std::move(knots))
{
    require(degree >= 1 && degree <= kMaxDegree, "KnotVector: degree", degree, "in [1, 512]");
    require(knots_.size() >= 2 * at(degree) + 2 && knots_.size() < (std::size_t{1} << 30),
            "KnotVector: number of knots", static_cast<double>(knots_.size()),
            "at least 2 degree + 2");
    for (std::size_t i = 0; i < knots_.size(); ++i) {
        require(std::isfinite(knots_[i]), "KnotVector: knot", knots_[i], "finite");
        require(i == 0 || knots_[i - 1] <= knots_[i], "KnotVector: the knots must ascend");
    }
    require(begin() < end(), "KnotVector: the domain is empty");
    for (std::size_t i = 0; i + at(degree) + 1 < knots_.size(); ++i)
        require(knots_[i] < knots_[i + at(degree) + 1],
                "KnotVector: a knot is there more than degree + 1 times");
    for (std::size_t i = at(degree) + 1; i + at(degree) < at(n_points()); ++i)
        require(knots_[i] < knots_[i + at(degree)] || knots_[i] == begin() || knots_[i] == end(),
                "KnotVector: an inner knot is there more than degree times");
}

KnotVector KnotVector::clamped(int degree, int n_points, double from, double to)
{
    require(degree >= 1 && n_points > degree, "KnotVector: number of points", n_points,
            "above the degree");
    std::vector<double> knots(at(degree) + 1, from);
    const int inner = n_points - degree;
    for (int i = 1; i < inner; ++i) knots.push_back(from + (to - from) * (double(i) / inner));
    knots.insert(knots.end(), at(degree) + 1, to);
    return KnotVector(degree, std::move(knots));
}

KnotVector KnotVector::uniform(int degree, int n_points)
{
    require(degree >= 1 && n_points > degree, "KnotVector: number of points", n_points,
            "above the degree");
    std::vector<double> knots;
    for (int i = 0; i <= n_points + degree; ++i) knots.push_back(i - degree);
    return KnotVector(degree, std::move(knots));
}

int KnotVector::span(double t) const
{
    const auto first = knots_.begin() + degree_ + 1, last = knots_.begin() + n_points();
    auto k = std::upper_bound(first, last, t) - knots_.begin() - 1;
    // At the end of the domain, or beyond a repeated last knot: back to a span that is not empty.
    while (k > degree_ && knots_[at(int(k))] == knots_[at(int(k)) + 1]) --k;
    while (knots_[at(int(k))] == knots_[at(int(k)) + 1]) ++k;
    return static_cast<int>(k);
}

std::vector<int> KnotVector::spans() const
{
    std::vector<int> result;
    for (int k = degree_; k < n_points(); ++k)
        if (knots_[at(k)] < knots_[at(k) + 1]) result.push_back(k);
    return result;
}

std::vector<double> KnotVector::basis(int k, double t) const
{
    return blossom_weights(k, std::vector<double>(at(degree_), t));
}

int KnotVector::multiplicity(double t) const
{
    const auto range = std::equal_range(knots_.begin(), knots_.end(), t);
    return static_cast<int>(range.second - range.first);
}

KnotVector KnotVector::with(double t, int times) const
{
    require(times >= 0 && times <= degree_ + 1, "KnotVector::with: times", times,
            "in [0, degree + 1]");
    auto knots = knots_;
    knots.insert(std::upper_bound(knots.begin(), knots.end(), t), at(times), t);
    return KnotVector(degree_, std::move(knots));
}

KnotVector KnotVector::elevated() const
{
    std::vector<double> knots;
    for (std::size_t i = 0; i < knots_.size(); ++i) {
        if (i == 0 || knots_[i] != knots_[i - 1]) knots.push_back(knots_[i]);
        knots.push_back(knots_[i]);
    }
    // Up to the begin of the domain one degree higher has use for degree + 2 knots, no more.
    const auto inner = std::upper_bound(knots.begin(), knots.end(), begin()) - knots.begin();
    const auto last = std::lower_bound(knots.begin(), knots.end(), end()) - knots.begin();
    const auto from = std::max<std::ptrdiff_t>(0, inner - (degree_ + 2));
    const auto to = std::min(std::ssize(knots), last + degree_ + 2);
    return KnotVector(degree_ + 1, std::vector<double>(knots.begin() + from, knots.begin() + to));
}

std::vector<double> KnotVector::blossom_weights(int k, std::span<const double> t) const
{
    require(t.size() == at(degree_), "KnotVector::blossom_weights: number of arguments",
            static_cast<double>(t.size()), "the degree");
    // Triangle of Cox and de Boor, one argument a round.
    std::vector<double> b(at(degree_) + 1);
    b[0] = 1.0;
    for (int d = 1; d <= degree_; ++d) {
        const double x = t[at(d) - 1];
        double carry = 0.0;
        for (int i = 0; i < d; ++i) {
            const double lo = knots_[at(k + 1 - d + i)], hi = knots_[at(k + 1 + i)];
            const double share = b[at(i)] / (hi - lo);
            b[at(i)] = carry + (hi - x) * share;
            carry = (x - lo) * share;
        }
        b[at(d)] = carry;
    }
    return b;
}

namespace {

// A span of `from` that is not empty and lies within [lo, hi], inside the domain.
int span_within(const KnotVector& from, double lo, double hi)
{
    const double a = std::max(lo, from.begin()), b = std::min(hi, from.end());
    return from.span(0.5 * a + 0.5 * b);
}

bool contains(const KnotVector& to, const KnotVector& from)
{
    return std::includes(to.values().begin(), to.values().end(), from.values().begin(),
                         from.values().end());
}

KnotRefinement same_degree_refinement(const KnotVector& from, const KnotVector& to)
{
    require(contains(to, from), "refinement: the new knots must contain the old ones");
    KnotRefinement result;
    const std::size_t p = at(from.degree());
    for (int i = 0; i < to.n_points(); ++i) {
        const int k = span_within(from, to[at(i)], to[at(i) + p + 1]);
        const std::span<const double> arguments(to.values().data() + i + 1, p);
        result.rows.push_back({k - from.degree(), from.blossom_weights(k, arguments)});
    }
    return result;
}

// A point of the elevated spline is the mean of the polar form with one argument left out.
KnotRefinement elevation(const KnotVector& from, const KnotVector& to)
{
    KnotRefinement result;
    const std::size_t p = at(from.degree());
    for (int i = 0; i < to.n_points(); ++i) {
        const int k = span_within(from, to[at(i)], to[at(i) + p + 2]);
        std::vector<double> sum(p + 1), arguments(p);
        for (std::size_t omit = 0; omit <= p; ++omit) {
            for (std::size_t j = 0, n = 0; j <= p; ++j)
                if (j != omit) arguments[n++] = to[at(i) + 1 + j];
            const auto w = from.blossom_weights(k, arguments);
            for (std::size_t j = 0; j <= p; ++j) sum[j] += w[j] / static_cast<double>(p + 1);
        }
        result.rows.push_back({k - from.degree(), std::move(sum)});
    }
    return result;
}

}  // namespace

KnotRefinement refinement(const KnotVector& from, const KnotVector& to)
{
    require(from.begin() == to.begin() && from.end() == to.end(),
            "refinement: the domains must agree");
    if (to.degree() == from.degree()) return same_degree_refinement(from, to);
    require(to.degree() == from.degree() + 1, "refinement: degree", to.degree(),
            "the same or one higher");
    for (const double t : from.values())
        require(to.multiplicity(t) > from.multiplicity(t) || t <= from.begin() || t >= from.end(),
                "refinement: the new knots must contain the old ones once more");
    return elevation(from, to);
}

namespace {

template <class V>
std::vector<V> refine(const KnotRefinement& r, const std::vector<V>& points)
{
    std::vector<V> result;
    result.reserve(r.rows.size());
    for (const auto& row : r.rows) {
        V sum{};
        for (std::size_t j = 0; j < row.weights.size(); ++j)
            sum += row.weights[j] * points[at(row.first) + j];
        result.push_back(sum);
    }
    return result;
}

BSpline from_homogeneous(const std::vector<Vec4>& h, const KnotVector& knots, bool rational)
{
    std::vector<Vec3> points;
    std::vector<double> weights;
    for (const Vec4& p : h) {
        points.push_back({{p[0] / p[3], p[1] / p[3], p[2] / p[3]}});
        if (rational) weights.push_back(p[3]);
    }
    return BSpline(std::move(points), knots, std::move(weights));
}

BSpline refined_to(const BSpline& curve, const KnotVector& knots)
{
    const auto r = refinement(curve.knots(), knots);
    if (!curve.rational()) return BSpline(refine(r, curve.points()), knots);
    return from_homogeneous(refine(r, curve.homogeneous()), knots, true);
}

}  // namespace

BSpline::BSpline(std::vector<Vec3> points, KnotVector knots, std::vector<double> weights)
    : points_(std::move(points)), weights_(std::move(weights)), knots_(std::move(knots))
{
    require(points_.size() == at(knots_.n_points()), "BSpline: number of points",
            static_cast<double>(points_.size()), "number of knots - degree - 1");
    control::check("BSpline", points_, weights_);
}

BSpline::BSpline(std::vector<Vec3> points, int degree)
    : BSpline(points, KnotVector::clamped(degree, static_cast<int>(points.size())))
{
}

BSpline BSpline::closed(const std::vector<Vec3>& ring, int degree)
{
    require(!ring.empty(), "BSpline::closed: no points");
    require(degree >= 1 && degree <= kMaxDegree, "BSpline::closed: degree", degree, "in [1, 512]");
    auto points = ring;
    for (int i = 0; i < degree; ++i) points.push_back(ring[at(i) % ring.size()]);
    const auto knots = KnotVector::uniform(degree, static_cast<int>(points.size()));
    return BSpline(std::move(points), knots);
}

std::vector<Vec4> BSpline::homogeneous() const
{
    return control::homogeneous(points_, weights_);
}

namespace {

// de Boor's triangle on the points k - p .. k.
template <class V>
V de_boor(const KnotVector& knots, int k, std::vector<V> d, double t)
{
    const int p = static_cast<int>(d.size()) - 1;
    for (int r = 1; r <= p; ++r)
        for (int i = p; i >= r; --i) {
            const double lo = knots[at(k - p + i)], hi = knots[at(k + 1 + i - r)];
            d[at(i)] = bernstein::mix(d[at(i) - 1], d[at(i)], (t - lo) / (hi - lo));
        }
    return d.back();
}

// Values and derivatives on span k; the r-th difference points form a spline of degree p - r.
template <class V>
std::vector<V> spline_derivatives(const KnotVector& knots, int k, std::vector<V> d, double t,
                                  int order)
{
    std::vector<V> result(at(order) + 1);
    const int p = knots.degree();
    for (int r = 0; r <= std::min(order, p); ++r) {
        result[at(r)] = de_boor(knots, k, d, t);
        const int q = p - r;
        for (int i = 0; i < q; ++i) {
            const double lo = knots[at(k - q + 1 + i)], hi = knots[at(k + 1 + i)];
            d[at(i)] = (d[at(i) + 1] - d[at(i)]) * (q / (hi - lo));
        }
        if (q > 0) d.pop_back();
    }
    return result;
}

template <class V>
std::vector<V> local_points(const std::vector<V>& points, int k, int p)
{
    return std::vector<V>(points.begin() + (k - p), points.begin() + k + 1);
}

}  // namespace

std::vector<std::vector<double>> KnotVector::basis_derivatives(int k, double t, int order) const
{
    require(order >= 0 && order <= kMaxDegree, "KnotVector::basis_derivatives: order", order,
            "in [0, 512]");
    std::vector<std::vector<double>> result(at(order) + 1, std::vector<double>(at(degree_) + 1));
    for (int i = 0; i <= degree_; ++i) {
        std::vector<double> unit(at(degree_) + 1);
        unit[at(i)] = 1.0;
        const auto d = spline_derivatives(*this, k, std::move(unit), t, order);
        for (int r = 0; r <= order; ++r) result[at(r)][at(i)] = d[at(r)];
    }
    return result;
}

Vec3 BSpline::value(double t) const
{
    return derivatives(t, 0)[0];
}

std::vector<Vec3> BSpline::derivatives(double t, int order) const
{
    require(order >= 0 && order <= kMaxDegree, "BSpline::derivatives: order", order, "in [0, 512]");
    const int k = knots_.span(t), p = degree();
    if (!rational()) return spline_derivatives(knots_, k, local_points(points_, k, p), t, order);
    std::vector<Vec4> h;
    for (int i = k - p; i <= k; ++i) {
        const Vec3& c = points_[at(i)];
        const double w = weights_[at(i)];
        h.push_back({{c[0] * w, c[1] * w, c[2] * w, w}});
    }
    return bernstein::quotient_derivatives(spline_derivatives(knots_, k, std::move(h), t, order));
}

Vec3 BSpline::derivative(double t, int order) const
{
    return derivatives(t, order).back();
}

namespace {

// Bernstein coefficients of all pieces, and a table that leads from a parameter to its piece.
class PieceTable {
public:
    explicit PieceTable(const BSpline& curve)
        : degree_(curve.degree()), begin_(curve.knots().begin()), end_(curve.knots().end())
    {
        const auto h = curve.homogeneous();
        const KnotVector& knots = curve.knots();
        for (const int k : knots.spans()) {
            const double a = knots[at(k)], b = knots[at(k) + 1];
            start_.push_back(a);
            inverse_.push_back(1.0 / (b - a));
            std::vector<double> arguments(at(degree_), a);
            for (int j = 0; j <= degree_; ++j) {
                if (j > 0) arguments[at(j) - 1] = b;
                const auto w = knots.blossom_weights(k, arguments);
                Vec4 sum{};
                for (int i = 0; i <= degree_; ++i) sum += w[at(i)] * h[at(k - degree_ + i)];
                coefficients_.push_back(bernstein::binomial(degree_, j) * sum);
            }
        }
        build_index();
    }

    template <int kDegree>
    void evaluate(const double* t, std::size_t count, bool rational, Vec3* out) const
    {
        const int n = kDegree > 0 ? kDegree : degree_;
        double powers[(kDegree > 0 ? kDegree : kMaxDegree) + 1];
        for (std::size_t i = 0; i < count; ++i) {
            // Not a number goes to the first piece and stays not a number.
            const double x = t[i] > begin_ ? (t[i] < end_ ? t[i] : end_) : begin_;
            const std::size_t piece = find(x);
            const double s = (x - start_[piece]) * inverse_[piece] + 0.0 * (t[i] - x);
            const double r = 1.0 - s;
            const Vec4* c = &coefficients_[piece * (at(n) + 1)];
            // Terms binomial s^k r^(n - k): powers of r first, then those of s on the way.
            powers[n] = 1.0;
            for (int k = n; k > 0; --k) powers[k - 1] = powers[k] * r;
            double power = 1.0;
            double sum[4] = {};
            for (int k = 0; k <= n; ++k) {
                const double b = power * powers[k];
                for (std::size_t d = 0; d < 4; ++d) sum[d] += b * c[k][d];
                power *= s;
            }
            const double w = rational ? sum[3] : 1.0;
            out[i] = {{sum[0] / w, sum[1] / w, sum[2] / w}};
        }
    }

private:
    void build_index()
    {
        const std::size_t cells = 4 * start_.size() + 1;
        scale_ = static_cast<double>(cells) / (end_ - begin_);
        if (!std::isfinite(scale_)) scale_ = 0.0;
        first_.resize(cells + 2);
        std::size_t piece = 0;
        for (std::size_t cell = 0; cell < first_.size(); ++cell) {
            while (piece + 1 < start_.size() &&
                   static_cast<double>(cell) >= (start_[piece + 1] - begin_) * scale_ + 1.0)
                ++piece;
            first_[cell] = static_cast<std::uint32_t>(piece);
        }
    }
    std::size_t find(double t) const
    {
        std::size_t piece = first_[static_cast<std::size_t>((t - begin_) * scale_)];
        while (piece + 1 < start_.size() && t >= start_[piece + 1]) ++piece;
        return piece;
    }

    int degree_;
    double begin_, end_, scale_ = 0.0;
    std::vector<double> start_, inverse_;
    std::vector<Vec4> coefficients_;
    std::vector<std::uint32_t> first_;
};

}  // namespace

void BSpline::evaluate(std::span<const double> t, std::span<Vec3> out) const
{
    require(t.size() == out.size(), "BSpline::evaluate: out must be as long as t");
    const PieceTable table(*this);
    parallel_for(t.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
        if (degree() == 3)
            table.evaluate<3>(t.data() + begin, end - begin, rational(), &out[begin]);
        else
            table.evaluate<0>(t.data() + begin, end - begin, rational(), &out[begin]);
    });
}

BSpline BSpline::with_knot(double t, int times) const
{
    require(t > knots_.begin() && t < knots_.end(), "BSpline::with_knot: knot", t,
            "inside the domain");
    require(times >= 0 && knots_.multiplicity(t) + times <= degree(),
            "BSpline::with_knot: multiplicity", knots_.multiplicity(t) + times,
            "at most the degree");
    return refined_to(*this, knots_.with(t, times));
}

KnotVector::Split KnotVector::split(double t) const
{
    require(t > begin() && t < end(), "KnotVector::split: t", t, "inside the domain");
    KnotVector whole = with(t, std::max(0, degree_ - multiplicity(t)));
    const std::vector<double>& k = whole.values();
    const auto at = std::lower_bound(k.begin(), k.end(), t);
    std::vector<double> before(k.begin(), at), after(1, t);
    before.insert(before.end(), static_cast<std::size_t>(degree_) + 1, t);
    after.insert(after.end(), at, k.end());
    KnotVector first(degree_, std::move(before)), second(degree_, std::move(after));
    return {std::move(whole), std::move(first), std::move(second)};
}

std::pair<BSpline, BSpline> BSpline::split(double t) const
{
    const KnotVector::Split knots = knots_.split(t);
    const BSpline whole = refined(knots.whole);
    const auto n = static_cast<std::ptrdiff_t>(knots.before.n_points());
    const auto first = [&](const auto& all) {
        return all.empty() ? all : std::decay_t<decltype(all)>(all.begin(), all.begin() + n);
    };
    const auto second = [&](const auto& all) {
        return all.empty() ? all : std::decay_t<decltype(all)>(all.begin() + n - 1, all.end());
    };
    return {BSpline(first(whole.points()), knots.before, first(whole.weights())),
            BSpline(second(whole.points()), knots.after, second(whole.weights()))};
}

BSpline BSpline::refined(const KnotVector& knots) const
{
    require(knots.degree() == degree(), "BSpline::refined: degree", knots.degree(),
            "that of the spline");
    return refined_to(*this, knots);
}

BSpline BSpline::elevated() const
{
    return refined_to(*this, knots_.elevated());
}

std::vector<BezierCurve> BSpline::bezier_segments() const
{
    std::vector<BezierCurve> result;
    const auto h = homogeneous();
    for (const int k : knots_.spans()) {
        std::vector<double> arguments(at(degree()), knots_[at(k)]);
        std::vector<Vec4> c;
        for (int j = 0; j <= degree(); ++j) {
            if (j > 0) arguments[at(j) - 1] = knots_[at(k) + 1];
            const auto w = knots_.blossom_weights(k, arguments);
            Vec4 sum{};
            for (int i = 0; i <= degree(); ++i) sum += w[at(i)] * h[at(k - degree() + i)];
            c.push_back(sum);
        }
        if (rational()) {
            result.push_back(BezierCurve::from_homogeneous(c));
            continue;
        }
        std::vector<Vec3> points;
        for (const Vec4& p : c) points.push_back({{p[0], p[1], p[2]}});
        result.emplace_back(std::move(points));
    }
    return result;
}

FlattenedCurve BSpline::flatten(double tolerance) const
{
    FlattenedCurve all;
    const auto pieces = bezier_segments();
    const auto spans = knots_.spans();
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const double a = knots_[at(spans[i])], b = knots_[at(spans[i]) + 1];
        const auto flat = pieces[i].flatten(tolerance);
        for (std::size_t j = i == 0 ? 0 : 1; j < flat.points.size(); ++j) {
            all.parameters.push_back(flat.parameters[j] == 1.0 ? b
                                                               : a + (b - a) * flat.parameters[j]);
            all.points.push_back(flat.points[j]);
        }
        all.bound = std::max(all.bound, flat.bound);
    }
    return all;
}

CurveLength BSpline::length(double tolerance) const
{
    CurveLength all;
    const auto pieces = bezier_segments();
    for (const BezierCurve& c : pieces) {
        const auto part = c.length(tolerance / static_cast<double>(pieces.size()));
        all.length += part.length;
        all.bound += part.bound;
    }
    return all;
}

Box3 BSpline::bounds() const
{
    return control::bounds(points_);
}

BSpline transformed(const BSpline& curve, const Transform& map)
{
    return BSpline(control::transformed(curve.points(), map), curve.knots(), curve.weights());
}

std::vector<double> parameters(std::span<const Vec3> points, Parametrization kind, bool closed)
{
    require(points.size() >= 2, "parameters: number of points", static_cast<double>(points.size()),
            "at least 2");
    std::vector<double> t = {0.0};
    for (std::size_t i = 1; i < points.size() + (closed ? 1 : 0); ++i) {
        const double chord = distance(points[i - 1], points[i % points.size()]);
        require(kind == Parametrization::Uniform || chord > 0.0,
                "parameters: neighbouring points coincide");
        t.push_back(t.back() + (kind == Parametrization::Uniform       ? 1.0
                                : kind == Parametrization::ChordLength ? chord
                                                                       : std::sqrt(chord)));
    }
    for (double& x : t) x /= t.back();
    return t;
}

namespace {

// Square band matrix, `reach` diagonals to either side, solved by elimination without pivoting.
class BandSystem {
public:
    BandSystem(std::size_t n, std::size_t reach)
        : n_(n), reach_(reach), width_(2 * reach + 1), a_(n * width_)
    {
    }
    double& operator()(std::size_t i, std::size_t j) { return a_[i * width_ + (j + reach_ - i)]; }
    void solve(std::vector<Vec3>& b)
    {
        for (std::size_t k = 0; k < n_; ++k) {
            require((*this)(k, k) != 0.0, "interpolate: the points do not determine a spline");
            for (std::size_t i = k + 1; i < std::min(n_, k + reach_ + 1); ++i) {
                const double f = (*this)(i, k) / (*this)(k, k);
                if (f == 0.0) continue;
                for (std::size_t j = k; j < std::min(n_, k + reach_ + 1); ++j)
                    (*this)(i, j) -= f * (*this)(k, j);
                b[i] -= f * b[k];
            }
        }
        for (std::size_t k = n_; k-- > 0;) {
            for (std::size_t j = k + 1; j < std::min(n_, k + reach_ + 1); ++j)
                b[k] -= (*this)(k, j) * b[j];
            b[k] = b[k] / (*this)(k, k);
        }
    }

private:
    std::size_t n_, reach_, width_;
    std::vector<double> a_;
};

// Weights of the outer points in the derivative of the given order at an end.
std::vector<double> end_derivative(const KnotVector& knots, bool at_end, int order)
{
    const double t = at_end ? knots.end() : knots.begin();
    return knots.basis_derivatives(knots.span(t), t, order).back();
}

std::vector<double> with_ends(std::span<const double> inner, int degree)
{
    std::vector<double> knots(at(degree) + 1, 0.0);
    knots.insert(knots.end(), inner.begin(), inner.end());
    knots.insert(knots.end(), at(degree) + 1, 1.0);
    return knots;
}

void put_values(BandSystem& system, const KnotVector& knots, double t, std::size_t row)
{
    const int k = knots.span(t);
    const auto b = knots.basis(k, t);
    for (std::size_t j = 0; j < b.size(); ++j)
        if (b[j] != 0.0) system(row, at(k - knots.degree()) + j) = b[j];
}

// Knots at all data parameters: n + 2 unknowns, a condition at either end.
BSpline with_end_conditions(std::span<const Vec3> points, const std::vector<double>& t,
                            const InterpolationOptions& options)
{
    const std::size_t n = points.size();
    const KnotVector knots(3, with_ends(std::span(t).subspan(1, n - 2), 3));
    const int order = options.ends == SplineEnds::Natural ? 2 : 1;
    BandSystem system(n + 2, 3);
    std::vector<Vec3> d(n + 2);
    const auto first = end_derivative(knots, false, order);
    const auto last = end_derivative(knots, true, order);
    for (std::size_t j = 0; j < 3; ++j) {
        system(1, j) = first[j];
        system(n, n - 1 + j) = last[j + 1];
    }
    if (options.ends == SplineEnds::Clamped) {
        d[1] = options.start_tangent;
        d[n] = options.end_tangent;
    }
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t row = i == 0 ? 0 : i == n - 1 ? n + 1 : i + 1;
        put_values(system, knots, t[i], row);
        d[row] = points[i];
    }
    system.solve(d);
    return BSpline(std::move(d), knots);
}

// All data parameters but the second and the last but one are knots.
BSpline not_a_knot(std::span<const Vec3> points, const std::vector<double>& t)
{
    const std::size_t n = points.size();
    const int degree = static_cast<int>(std::min<std::size_t>(3, n - 1));
    std::vector<double> inner;
    for (std::size_t i = 2; i + 2 < n; ++i) inner.push_back(t[i]);
    const KnotVector knots(degree, with_ends(inner, degree));
    BandSystem system(n, 3);
    std::vector<Vec3> d(points.begin(), points.end());
    for (std::size_t i = 0; i < n; ++i) put_values(system, knots, t[i], i);
    system.solve(d);
    return BSpline(std::move(d), knots);
}

// A cyclic system with three entries a row: a band plus a correction of rank one.
void solve_cyclic(const std::vector<Vec3>& row, std::vector<Vec3>& d)
{
    const std::size_t n = d.size();
    const double corner = row[0][0], other = row[n - 1][2], gamma = -row[0][1];
    const auto band = [&] {
        BandSystem system(n, 1);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                if (i + j >= 1 && i + j - 1 < n) system(i, i + j - 1) = row[i][j];
        system(0, 0) -= gamma;
        system(n - 1, n - 1) -= corner * other / gamma;
        return system;
    };
    std::vector<Vec3> u(n);
    u[0][0] = gamma;
    u[n - 1][0] = other;
    auto system = band();
    system.solve(d);
    system = band();
    system.solve(u);
    const double v = corner / gamma;
    const Vec3 above = d[0] + v * d[n - 1];
    const double below = 1.0 + u[0][0] + v * u[n - 1][0];
    for (std::size_t i = 0; i < n; ++i) d[i] -= (u[i][0] / below) * above;
}

BSpline periodic(std::span<const Vec3> points, const std::vector<double>& t)
{
    const int n = static_cast<int>(points.size());
    std::vector<double> knots;
    for (int i = -3; i <= n + 3; ++i) {
        const int turn = (i + 3 * n) / n - 3;
        knots.push_back(turn + t[at(i - turn * n)]);
    }
    const KnotVector ring(3, std::move(knots));
    std::vector<Vec3> rows, d(points.begin(), points.end());
    for (int i = 0; i < n; ++i) {
        // On the span that starts at t_i the points i .. i + 2 of the ring act.
        const auto b = ring.basis(3 + i, ring[at(i) + 3]);
        rows.push_back({{b[0], b[1], b[2]}});
    }
    // Row i has entries at i, i + 1, i + 2; shift so that the middle one is on the diagonal.
    solve_cyclic(rows, d);
    std::vector<Vec3> control;
    for (int i = 0; i < n + 3; ++i) control.push_back(d[at((i - 1 + n) % n)]);
    return BSpline(std::move(control), ring);
}

}  // namespace

BSpline interpolate(std::span<const Vec3> points, const InterpolationOptions& options)
{
    const bool closed = options.ends == SplineEnds::Periodic;
    const std::size_t least = closed ? 3 : 2;
    require(points.size() >= least && points.size() < (std::size_t{1} << 28),
            "interpolate: number of points", static_cast<double>(points.size()),
            closed ? "at least 3" : "at least 2");
    for (const Vec3& p : points) require(is_finite(p), "interpolate: a point is not finite");
    const auto t = parameters(points, options.parametrization, closed);
    if (closed) return periodic(points, t);
    if (options.ends == SplineEnds::NotAKnot ||
        (points.size() < 3 && options.ends == SplineEnds::Natural))
        return not_a_knot(points, t);
    return with_end_conditions(points, t, options);
}

SplineFit fit(std::span<const Vec3> points, int n_points, int degree, Parametrization kind)
{
    const int m = static_cast<int>(points.size()) - 1, n = n_points - 1;
    require(degree >= 1 && degree <= kMaxDegree && n >= degree && n <= m && m < (1 << 28),
            "fit: number of control points", n_points,
            "above the degree and not above the number of points");
    const auto t = parameters(points, kind);
    std::vector<double> inner;
    const double step = (m + 1.0) / (n - degree + 1.0);
    for (int j = 1; j <= n - degree; ++j) {
        const int i = static_cast<int>(j * step);
        const double share = j * step - i;
        inner.push_back((1.0 - share) * t[at(i) - 1] + share * t[at(i)]);
    }
    const KnotVector knots(degree, with_ends(inner, degree));

    std::vector<Vec3> d(at(n) + 1);
    d.front() = points.front();
    d.back() = points.back();
    if (n >= 2 && m >= 2) {
        const std::size_t rows = at(m) - 1, cols = at(n) - 1;
        require(rows <= (std::size_t{1} << 26) / cols, "fit: number of equations",
                static_cast<double>(rows) * static_cast<double>(cols), "at most 2^26");
        std::vector<double> a(rows * cols), b(rows * 3);
        for (std::size_t i = 0; i < rows; ++i) {
            const int k = knots.span(t[i + 1]);
            const auto w = knots.basis(k, t[i + 1]);
            Vec3 rest = points[i + 1];
            for (int j = 0; j <= degree; ++j) {
                const int column = k - degree + j;
                if (column == 0 || column == n)
                    rest -= w[at(j)] * d[at(column)];
                else
                    a[i * cols + at(column) - 1] = w[at(j)];
            }
            for (std::size_t c = 0; c < 3; ++c) b[i * 3 + c] = rest[c];
        }
        const auto x = LinearSolver(rows, cols, a).solve(b, 3);
        for (std::size_t j = 0; j < cols; ++j) d[j + 1] = {{x[3 * j], x[3 * j + 1], x[3 * j + 2]}};
    }
    SplineFit result{BSpline(std::move(d), knots), 0.0, 0.0};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double e = distance(result.curve.value(t[i]), points[i]);
        result.largest = std::max(result.largest, e);
        result.rms += e * e;
    }
    result.rms = std::sqrt(result.rms / static_cast<double>(points.size()));
    return result;
}

BSpline elliptic_arc(const Vec3& center, const Vec3& a, const Vec3& b, double from, double sweep)
{
    require(std::isfinite(from), "elliptic_arc: from", from, "finite");
    require(sweep != 0.0 && std::fabs(sweep) <= 360.0, "elliptic_arc: sweep", sweep,
            "in [-360, 360] and not 0");
    const int pieces = static_cast<int>(std::ceil(std::fabs(sweep) / 90.0));
    const double w = cos_degrees(sweep / (2.0 * pieces));
    const auto on_circle = [&](double degrees, double radius) {
        return center + (radius * cos_degrees(degrees)) * a + (radius * sin_degrees(degrees)) * b;
    };
    std::vector<Vec3> points = {on_circle(from, 1.0)};
    std::vector<double> weights = {1.0}, knots(3, 0.0);
    for (int i = 0; i < pieces; ++i) {
        const double middle = from + sweep * (2.0 * i + 1.0) / (2.0 * pieces);
        const double end = from + sweep * (i + 1.0) / pieces;
        points.push_back(on_circle(middle, 1.0 / w));
        points.push_back(std::fabs(sweep) == 360.0 && i + 1 == pieces ? points.front()
                                                                      : on_circle(end, 1.0));
        weights.insert(weights.end(), {w, 1.0});
        knots.insert(knots.end(), i + 1 == pieces ? 3 : 2, (i + 1.0) / pieces);
    }
    return BSpline(std::move(points), KnotVector(2, std::move(knots)), std::move(weights));
}

BezierCurve conic(const Vec3& a, const Vec3& apex, const Vec3& b, double weight)
{
    return BezierCurve({a, apex, b}, {1.0, weight, 1.0});
}

}  // namespace genus
