#include "genus/patch/bspline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/patch/reference.h"
#include "genus/base/error.h"
#include "genus/patch/cubic_spline.h"

namespace genus {
namespace {

using reference::random_points;
using reference::random_vec;

constexpr double kPi = 3.14159265358979323846;

// Random knots with repeated ones inside; clamped or not.
KnotVector random_knots(std::mt19937_64& random, int degree, int n_points, bool clamped)
{
    std::uniform_real_distribution<double> step(0.1, 1.0);
    std::vector<double> knots;
    double t = 0.0;
    int run = 0;
    for (int i = 0; i < n_points + degree + 1; ++i) {
        const bool end = i <= degree || i >= n_points;
        const bool repeat = !end && random() % 3 == 0 && run + 1 < degree && i > degree + 1;
        if (i > 0 && !repeat && !(clamped && end && i != n_points)) t += step(random);
        run = repeat ? run + 1 : 0;
        knots.push_back(t);
    }
    return KnotVector(degree, knots);
}

BSpline random_spline(std::mt19937_64& random, int degree, int n, bool clamped, bool rational)
{
    std::uniform_real_distribution<double> weight(0.3, 3.0);
    std::vector<double> w;
    for (int i = 0; rational && i < n; ++i) w.push_back(weight(random));
    return BSpline(random_points(random, n), random_knots(random, degree, n, clamped), w);
}

std::vector<double> sample(const BSpline& c, int n = 37)
{
    std::vector<double> t;
    for (int i = 0; i <= n; ++i) {
        const double s = double(i) / n;
        t.push_back((1.0 - s) * c.knots().begin() + s * c.knots().end());
    }
    return t;
}

void expect_same(const BSpline& a, const BSpline& b, double tolerance)
{
    for (const double t : sample(a)) EXPECT_LE(distance(a.value(t), b.value(t)), tolerance) << t;
}

// Basis functions straight from the recursion over single functions.
double cox_de_boor(const KnotVector& u, int i, int p, double t)
{
    const auto k = [&](int j) { return u[static_cast<std::size_t>(j)]; };
    if (p == 0) return k(i) <= t && t < k(i + 1) ? 1.0 : 0.0;
    double sum = 0.0;
    if (k(i + p) > k(i)) sum += (t - k(i)) / (k(i + p) - k(i)) * cox_de_boor(u, i, p - 1, t);
    if (k(i + p + 1) > k(i + 1))
        sum += (k(i + p + 1) - t) / (k(i + p + 1) - k(i + 1)) * cox_de_boor(u, i + 1, p - 1, t);
    return sum;
}

TEST(KnotVector, BasisIsThatOfCoxAndDeBoor)
{
    std::mt19937_64 random(71);
    for (int trial = 0; trial < 40; ++trial) {
        const int p = 1 + trial % 5;
        const KnotVector u = random_knots(random, p, p + 6, trial % 2 == 0);
        std::uniform_real_distribution<double> parameter(u.begin(), u.end());
        for (int i = 0; i < 10; ++i) {
            const double t = parameter(random);
            const int k = u.span(t);
            const auto b = u.basis(k, t);
            EXPECT_NEAR(std::accumulate(b.begin(), b.end(), 0.0), 1.0, 1e-14);
            for (int j = 0; j <= p; ++j) {
                EXPECT_GE(b[j], -1e-17);
                EXPECT_NEAR(b[j], cox_de_boor(u, k - p + j, p, t), 1e-13);
            }
        }
    }
}

TEST(BSpline, ValueAgreesWithTheSumOfBasisFunctionsAndWithBulk)
{
    std::mt19937_64 random(72);
    for (const bool rational : {false, true})
        for (const int p : {1, 2, 3, 4, 7})
            for (const bool clamped : {false, true}) {
                const BSpline c = random_spline(random, p, p + 9, clamped, rational);
                auto t = sample(c, 101);
                std::shuffle(t.begin(), t.end(), random);
                std::vector<Vec3> out(t.size());
                c.evaluate(t, out);
                for (std::size_t i = 0; i < t.size(); ++i) {
                    const int k = c.knots().span(t[i]);
                    const auto b = c.knots().basis(k, t[i]);
                    Vec3 sum;
                    double w = 0.0;
                    for (int j = 0; j <= p; ++j) {
                        const std::size_t at = static_cast<std::size_t>(k - p + j);
                        const double weight = rational ? c.weights()[at] : 1.0;
                        sum += b[j] * weight * c.points()[at];
                        w += b[j] * weight;
                    }
                    ASSERT_LE(distance(c.value(t[i]), sum / w), 1e-12);
                    ASSERT_LE(distance(out[i], sum / w), 1e-11) << p << " " << t[i];
                }
            }
}

TEST(BSpline, DerivativesAgreeWithDifferenceQuotientsAndWithBezier)
{
    std::mt19937_64 random(73);
    for (const bool rational : {false, true})
        for (const int p : {2, 3, 5}) {
            const BSpline c = random_spline(random, p, p + 5, true, rational);
            const auto spans = c.knots().spans();
            const auto pieces = c.bezier_segments();
            ASSERT_EQ(pieces.size(), spans.size());
            for (std::size_t i = 0; i < spans.size(); ++i) {
                const double a = c.knots()[spans[i]], b = c.knots()[spans[i] + 1];
                const auto ours = c.derivatives(0.7 * a + 0.3 * b, 3);
                const auto theirs = pieces[i].derivatives(0.3, 3);
                double scale = 1.0;
                for (int r = 0; r <= 3; ++r, scale *= b - a)
                    EXPECT_LE(distance(scale * ours[r], theirs[r]), 1e-9 * (1 + norm(theirs[r])));
            }
        }
}

TEST(BSpline, KnotInsertionRefinementAndElevationKeepTheCurve)
{
    std::mt19937_64 random(74);
    for (const bool rational : {false, true})
        for (const int p : {1, 2, 3, 5})
            for (const bool clamped : {false, true}) {
                SCOPED_TRACE(testing::Message() << p << " " << clamped << rational);
                const BSpline c = random_spline(random, p, p + 6, clamped, rational);
                const double middle = 0.4 * c.knots().begin() + 0.6 * c.knots().end();
                const BSpline more = c.with_knot(middle, p);
                EXPECT_EQ(more.points().size(), c.points().size() + p);
                expect_same(c, more, 1e-12);
                // A knot of multiplicity p is a point of the curve.
                bool there = false;
                for (const Vec3& q : more.points())
                    there = there || distance(q, c.value(middle)) < 1e-12;
                EXPECT_TRUE(there);
                const BSpline up = c.elevated();
                EXPECT_EQ(up.degree(), p + 1);
                expect_same(c, up, 1e-12);
                expect_same(c, up.elevated(), 1e-11);
            }
}

TEST(BSpline, IsSmoothToDegreeLessMultiplicity)
{
    std::mt19937_64 random(75);
    const int p = 4;
    for (int multiplicity = 1; multiplicity <= p; ++multiplicity) {
        std::vector<double> knots = {0, 0, 0, 0, 0};
        knots.insert(knots.end(), multiplicity, 1.0);
        knots.insert(knots.end(), 5, 2.0);
        const BSpline c(random_points(random, 5 + multiplicity), KnotVector(p, knots));
        const auto pieces = c.bezier_segments();
        ASSERT_EQ(pieces.size(), 2u);
        const auto left = pieces[0].derivatives(1.0, p), right = pieces[1].derivatives(0.0, p);
        for (int r = 0; r <= p - multiplicity; ++r)
            EXPECT_LE(distance(left[r], right[r]), 1e-12 * (1.0 + norm(left[r])));
        EXPECT_GT(distance(left[p - multiplicity + 1], right[p - multiplicity + 1]), 1e-6);
    }
}

TEST(BSpline, ClosedCurveIsSmoothAcrossItsSeam)
{
    std::mt19937_64 random(76);
    for (const int p : {1, 2, 3, 5}) {
        const BSpline c = BSpline::closed(random_points(random, 6), p);
        const auto first = c.derivatives(c.knots().begin(), p - 1);
        const auto last = c.derivatives(c.knots().end(), p - 1);
        for (int r = 0; r < p; ++r) EXPECT_LE(distance(first[r], last[r]), 1e-12);
    }
}

TEST(BSpline, CircleAndEllipseAreExact)
{
    std::mt19937_64 random(77);
    for (const double sweep : {360.0, -360.0, 90.0, 100.0, 271.5, 1e-3})
        for (const double from : {0.0, 45.0, 123.4}) {
            const Vec3 a{{3, 0, 0}}, b{{0, 2, 0}}, center{{1, 2, 3}};
            const BSpline c = elliptic_arc(center, a, b, from, sweep);
            for (const double t : sample(c)) {
                const Vec3 p = c.value(t) - center;
                EXPECT_NEAR(p[0] * p[0] / 9.0 + p[1] * p[1] / 4.0, 1.0, 1e-14);
            }
            const Vec3 end = c.value(1.0) - center;
            const double x = (from + sweep) * kPi / 180.0;
            EXPECT_LE(distance(end, {{3 * std::cos(x), 2 * std::sin(x), 0}}), 1e-14);
        }
    const auto length = elliptic_arc({}, {{1, 0, 0}}, {{0, 1, 0}}).length(1e-10);
    EXPECT_NEAR(length.length, 2 * kPi, 1e-10);
    // Hyperbola x y = 1 from (1/2, 2) to (2, 1/2): tangents meet in (0.8, 0.8).
    const BezierCurve h = conic({{0.5, 2, 0}}, {{0.8, 0.8, 0}}, {{2, 0.5, 0}}, 1.25);
    for (int i = 0; i <= 10; ++i) {
        const Vec3 p = h.value(i / 10.0);
        EXPECT_NEAR(p[0] * p[1], 1.0, 1e-14);
    }
}

TEST(Interpolate, GoesThroughThePointsWithItsEndConditions)
{
    std::mt19937_64 random(78);
    for (const int n : {2, 3, 4, 5, 8, 200})
        for (const auto kind :
             {Parametrization::Uniform, Parametrization::ChordLength, Parametrization::Centripetal})
            for (const auto ends : {SplineEnds::NotAKnot, SplineEnds::Natural, SplineEnds::Clamped,
                                    SplineEnds::Periodic}) {
                const bool closed = ends == SplineEnds::Periodic;
                if (closed && n < 3) continue;
                SCOPED_TRACE(testing::Message() << n << " ends " << int(ends));
                const auto points = random_points(random, n);
                InterpolationOptions o;
                o.ends = ends;
                o.parametrization = kind;
                o.start_tangent = {{1, 2, 3}};
                o.end_tangent = {{-3, 2, 1}};
                const BSpline c = interpolate(points, o);
                const auto t = parameters(points, kind, closed);
                for (int i = 0; i < n; ++i)
                    ASSERT_LE(distance(c.value(t[i]), points[i]), 1e-11) << i;
                const double largest = norm(c.derivative(0.5 * t[0] + 0.5 * t[1], 2)) + 1.0;
                if (ends == SplineEnds::Natural) {
                    EXPECT_LE(norm(c.derivative(0.0, 2)), 1e-9 * largest);
                    EXPECT_LE(norm(c.derivative(1.0, 2)), 1e-9 * largest);
                } else if (ends == SplineEnds::Clamped) {
                    EXPECT_LE(distance(c.derivative(0.0), o.start_tangent), 1e-9 * largest);
                    EXPECT_LE(distance(c.derivative(1.0), o.end_tangent), 1e-9 * largest);
                } else if (closed) {
                    for (int r = 0; r <= 2; ++r)
                        EXPECT_LE(distance(c.derivative(0.0, r), c.derivative(1.0, r)),
                                  1e-8 * largest * n);
                }
            }
}

// Interpolation reproduces cubics, and its error on a smooth curve falls sixteenfold per halving.
TEST(Interpolate, IsExactForCubicsAndOfOrderFour)
{
    const auto cubic = [](double t) { return Vec3{{t, 1 - t * t, t * t * t - 2 * t}}; };
    InterpolationOptions o;
    o.parametrization = Parametrization::Uniform;
    std::vector<Vec3> points;
    for (int i = 0; i <= 9; ++i) points.push_back(cubic(i / 9.0));
    const BSpline exact = interpolate(points, o);
    for (int i = 0; i <= 50; ++i)
        EXPECT_LE(distance(exact.value(i / 50.0), cubic(i / 50.0)), 1e-13);

    const auto smooth = [](double t) {
        return Vec3{{std::cos(3 * t), std::sin(5 * t), std::exp(t)}};
    };
    std::vector<double> error;
    for (const int n : {20, 40, 80}) {
        points.clear();
        for (int i = 0; i <= n; ++i) points.push_back(smooth(double(i) / n));
        const BSpline c = interpolate(points, o);
        double worst = 0.0;
        for (int i = 0; i <= 1000; ++i)
            worst = std::max(worst, distance(c.value(i / 1000.0), smooth(i / 1000.0)));
        error.push_back(worst);
    }
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(std::log2(error[i] / error[i + 1]), 4.0, 0.4);
}

TEST(Fit, FindsASplineThatIsThereAndIsBestAmongItsNeighbours)
{
    std::mt19937_64 random(79);
    const auto points = random_points(random, 30);
    const SplineFit f = fit(points, 8, 3);
    EXPECT_LE(distance(f.curve.value(0.0), points.front()), 1e-14);
    EXPECT_LE(distance(f.curve.value(1.0), points.back()), 1e-14);
    const auto t = parameters(points, Parametrization::ChordLength);
    const auto sum = [&](const BSpline& c) {
        double s = 0.0;
        for (std::size_t i = 0; i < t.size(); ++i)
            s += std::pow(distance(c.value(t[i]), points[i]), 2);
        return s;
    };
    EXPECT_NEAR(sum(f.curve), 30 * f.rms * f.rms, 1e-12);
    for (int trial = 0; trial < 100; ++trial) {
        auto moved = f.curve.points();
        moved[1 + trial % 6] += 1e-3 * random_vec(random);
        EXPECT_GE(sum(BSpline(moved, f.curve.knots())), sum(f.curve));
    }
    // As many control points as points: interpolation.
    EXPECT_LE(fit(std::span(points).subspan(0, 9), 9).largest, 1e-11);
}

TEST(CubicSpline, BezierPointsByTheAFrameAreThoseOfTheBSpline)
{
    std::mt19937_64 random(80);
    for (const auto ends : {CubicEnds::Natural, CubicEnds::Free, CubicEnds::Closed})
        for (const int n : {4, 5, 9}) {
            const CubicSpline c(random_points(random, n), ends);
            const auto ours = c.bezier_segments();
            const auto theirs = c.to_bspline().bezier_segments();
            ASSERT_EQ(ours.size(), theirs.size());
            ASSERT_EQ(ours.size(), c.n_pieces());
            for (std::size_t i = 0; i < ours.size(); ++i) {
                for (int k = 0; k < 4; ++k)
                    EXPECT_LE(distance(ours[i].points()[k], theirs[i].points()[k]), 1e-14);
                if (i > 0) {
                    EXPECT_TRUE(join(ours[i - 1], ours[i]).continuous(2, 1e-12));
                }
                EXPECT_LE(distance(c.value(i + 0.25), ours[i].value(0.25)), 1e-14);
            }
            if (ends == CubicEnds::Closed) {
                EXPECT_TRUE(join(ours.back(), ours.front()).continuous(2, 1e-12));
            }
            if (ends == CubicEnds::Natural) {
                EXPECT_LE(distance(c.value(0), c.a_frame_points().front()), 1e-14);
                EXPECT_LE(norm(c.derivative(0, 2)), 1e-13);
            }
        }
}

TEST(CubicSpline, ThroughPointsHasItsJointsThere)
{
    std::mt19937_64 random(81);
    for (const auto ends : {CubicEnds::Natural, CubicEnds::Closed})
        for (const int n : {3, 4, 50}) {
            const auto points = random_points(random, n);
            const CubicSpline c = cubic_spline_through(points, ends);
            for (int i = 0; i < n; ++i) EXPECT_LE(distance(c.value(i), points[i]), 1e-13);
        }
}

TEST(BSpline, RefusesBadArguments)
{
    const std::vector<double> good = {0, 0, 0, 0, 1, 1, 1, 1};
    EXPECT_NO_THROW(KnotVector(3, good));
    EXPECT_THROW(KnotVector(0, good), InvalidInput);
    EXPECT_THROW(KnotVector(4, good), InvalidInput);
    EXPECT_THROW(KnotVector(3, {0, 0, 0, 0, 0, 0, 0, 0}), InvalidInput);
    EXPECT_THROW(KnotVector(3, {0, 0, 0, 1, 0, 1, 1, 1}), InvalidInput);
    EXPECT_THROW(KnotVector(3, {0, 0, 0, 0, 0, 1, 1, 1, 1}), InvalidInput);
    EXPECT_THROW(KnotVector(1, {0, 0, 1, 1, 2, std::nan("")}), InvalidInput);
    EXPECT_THROW(KnotVector(1, {0, 0, 1, 1, 2, 2}), InvalidInput);
    EXPECT_THROW(BSpline(std::vector<Vec3>(3), KnotVector(3, good)), InvalidInput);
    EXPECT_THROW(BSpline(std::vector<Vec3>(4), KnotVector(3, good), {1, 1, 0, 1}), InvalidInput);
    const BSpline c(std::vector<Vec3>(4), 3);
    EXPECT_THROW(c.with_knot(0.0), InvalidInput);
    EXPECT_THROW(c.with_knot(0.5, 4), InvalidInput);
    EXPECT_THROW(c.refined(KnotVector(3, {0, 0, 0, 0, 2, 2, 2, 2})), InvalidInput);
    EXPECT_THROW(interpolate(std::vector<Vec3>(1)), InvalidInput);
    EXPECT_THROW(interpolate(std::vector<Vec3>(5)), InvalidInput);  // coincident points
    EXPECT_THROW(elliptic_arc({}, {}, {}, 0, 361), InvalidInput);
    EXPECT_THROW(CubicSpline({Vec3{}}), InvalidInput);
}

}  // namespace
}  // namespace genus
