#include "genus/patch/bezier_curve.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/patch/reference.h"
#include "genus/base/error.h"

namespace genus {
namespace {

using reference::random_points;
using reference::random_vec;

constexpr double kPi = 3.14159265358979323846;

BezierCurve random_curve(std::mt19937_64& random, int degree, bool rational = false)
{
    std::uniform_real_distribution<double> weight(0.3, 3.0);
    std::vector<double> w;
    for (int i = 0; rational && i <= degree; ++i) w.push_back(weight(random));
    return BezierCurve(random_points(random, degree + 1), w);
}

// Quarter of the unit circle.
BezierCurve quarter_circle()
{
    return BezierCurve({{{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}}}, {1.0, std::sqrt(0.5), 1.0});
}

void expect_same_curve(const BezierCurve& a, const BezierCurve& b, double tolerance)
{
    for (int i = 0; i <= 10; ++i)
        EXPECT_LE(distance(a.value(i / 10.0), b.value(i / 10.0)), tolerance) << i;
}

TEST(BezierCurve, HasItsEndsAndEndTangents)
{
    std::mt19937_64 random(51);
    for (const bool rational : {false, true})
        for (const int n : {1, 2, 3, 8, 25}) {
            const BezierCurve c = random_curve(random, n, rational);
            const auto& p = c.points();
            EXPECT_LE(distance(c.value(0.0), p.front()), 1e-15);
            EXPECT_LE(distance(c.value(1.0), p.back()), 1e-15);
            const double w = rational ? c.weights()[1] / c.weights()[0] : 1.0;
            EXPECT_LE(distance(c.derivative(0.0), n * w * (p[1] - p[0])), 1e-12 * n);
        }
}

TEST(BezierCurve, DerivativesAgreeWithDifferenceQuotients)
{
    std::mt19937_64 random(52);
    for (const bool rational : {false, true})
        for (const int n : {2, 3, 6}) {
            const BezierCurve c = random_curve(random, n, rational);
            const double h = 1e-4, t = 0.43;
            const auto d = c.derivatives(t, 3);
            for (int order = 0; order < 3; ++order) {
                const Vec3 quotient =
                    (c.derivative(t + h, order) - c.derivative(t - h, order)) / (2 * h);
                EXPECT_LE(distance(quotient, d[order + 1]), 1e-3) << order << rational;
            }
            if (!rational) {
                EXPECT_EQ(norm(c.derivative(t, n + 1)), 0.0);
            }
        }
}

TEST(BezierCurve, RationalQuarterCircleIsTheCircle)
{
    const BezierCurve c = quarter_circle();
    for (int i = 0; i <= 20; ++i) {
        EXPECT_NEAR(norm(c.value(i / 20.0)), 1.0, 1e-15);
        EXPECT_NEAR(c.curvature(i / 20.0), 1.0, 1e-13);
    }
    const auto length = c.length(1e-12);
    EXPECT_NEAR(length.length, kPi / 2, length.bound);
    EXPECT_LE(length.bound, 1e-12);
}

TEST(BezierCurve, BulkAgreesWithCertifiedValuesWithinItsBound)
{
    std::mt19937_64 random(53);
    std::uniform_real_distribution<double> parameter(0.0, 1.0);
    for (const bool rational : {false, true})
        for (const int n : {0, 1, 2, 3, 4, 20, 100, 512}) {
            const BezierCurve c = random_curve(random, n, rational);
            std::vector<double> t = {0.0, 1.0, 0x1p-60};
            while (t.size() < 101) t.push_back(parameter(random));
            std::vector<Vec3> out(t.size());
            c.evaluate(t, out);
            for (std::size_t i = 0; i < t.size(); ++i) {
                const auto exact = c.value_with_bound(t[i]);
                ASSERT_LE(distance(out[i], exact.value), c.bulk_bound() + norm(exact.bound))
                    << n << " " << t[i];
                if (n <= 100) {
                    ASSERT_LE(distance(c.value(t[i]), exact.value), 1e-13);
                }
            }
        }
}

TEST(BezierCurve, BulkGivesTheSameBitsWhereverAPointStands)
{
    std::mt19937_64 random(54);
    const BezierCurve c = random_curve(random, 7);
    std::vector<double> t;
    for (int i = 0; i < 37; ++i) t.push_back(i / 36.0);
    std::vector<Vec3> all(t.size()), one(1);
    c.evaluate(t, all);
    for (std::size_t i = 0; i < t.size(); ++i) {
        c.evaluate(std::span(t).subspan(i, 1), one);
        EXPECT_EQ(one[0], all[i]);
    }
    EXPECT_THROW(c.evaluate(t, one), InvalidInput);
}

TEST(BezierCurve, SplitSegmentReverseAndElevateKeepTheCurve)
{
    std::mt19937_64 random(55);
    for (const bool rational : {false, true})
        for (const int n : {1, 3, 9}) {
            const BezierCurve c = random_curve(random, n, rational);
            const auto [left, right] = c.split(0.3);
            for (const double t : {0.0, 0.4, 1.0}) {
                EXPECT_LE(distance(left.value(t), c.value(0.3 * t)), 1e-13);
                EXPECT_LE(distance(right.value(t), c.value(0.3 + 0.7 * t)), 1e-13);
                EXPECT_LE(distance(c.reversed().value(t), c.value(1 - t)), 1e-13);
            }
            expect_same_curve(c.elevated(3), c, 1e-13);
            EXPECT_EQ(c.elevated(3).degree(), n + 3);
        }
}

TEST(BezierCurve, ReductionUndoesElevationAndReportsItsError)
{
    std::mt19937_64 random(56);
    for (const bool rational : {false, true})
        for (const int n : {2, 5, 10}) {
            const BezierCurve c = random_curve(random, n, rational);
            const auto [back, none] = c.elevated(2).reduced(n);
            EXPECT_LE(none, 1e-12);
            expect_same_curve(back, c, 1e-12);
        }
    for (int trial = 0; trial < 50; ++trial) {
        const BezierCurve c = random_curve(random, 6);
        for (int m = 1; m <= 6; ++m) {
            const auto [low, bound] = c.reduced(m);
            EXPECT_EQ(low.degree(), m);
            EXPECT_LE(distance(low.value(0), c.value(0)), 1e-15);
            for (int i = 0; i <= 40; ++i)
                ASSERT_LE(distance(low.value(i / 40.0), c.value(i / 40.0)), bound);
        }
    }
}

double distance_to_polyline(const Vec3& p, const std::vector<Vec3>& line)
{
    double least = 1e300;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Vec3 d = line[i] - line[i - 1];
        const double s = std::clamp(dot(p - line[i - 1], d) / dot(d, d), 0.0, 1.0);
        least = std::min(least, distance(p, line[i - 1] + s * d));
    }
    return least;
}

TEST(BezierCurve, FlatteningStaysWithinItsBoundBothWays)
{
    std::mt19937_64 random(57);
    for (const bool rational : {false, true})
        for (const int n : {1, 2, 3, 7})
            for (const double tolerance : {1e-1, 1e-3}) {
                const BezierCurve c = random_curve(random, n, rational);
                const auto flat = c.flatten(tolerance);
                EXPECT_LE(flat.bound, tolerance);
                ASSERT_EQ(flat.points.size(), flat.parameters.size());
                for (int i = 0; i <= 200; ++i)
                    ASSERT_LE(distance_to_polyline(c.value(i / 200.0), flat.points), flat.bound);
                for (std::size_t i = 1; i < flat.points.size(); i += 1 + flat.points.size() / 20) {
                    const Vec3 middle = 0.5 * (flat.points[i - 1] + flat.points[i]);
                    ASSERT_LE(c.nearest(middle, 1e-9).distance, flat.bound + 1e-9);
                }
            }
}

// Halving a curve quarters its distance from the control polygon and from the chord.
TEST(BezierCurve, SubdivisionConvergesQuadratically)
{
    std::mt19937_64 random(58);
    for (const int n : {2, 3, 5, 8}) {
        const BezierCurve c = random_curve(random, n);
        std::vector<double> error;
        for (int level = 4; level <= 8; ++level) {
            const int pieces = 1 << level;
            double worst = 0.0;
            for (int i = 0; i < pieces; ++i) {
                const BezierCurve part = c.segment(double(i) / pieces, double(i + 1) / pieces);
                for (int k = 0; k <= n; ++k)
                    worst = std::max(worst, distance(part.points()[k], part.value(double(k) / n)));
            }
            error.push_back(worst);
        }
        for (std::size_t i = 1; i < error.size(); ++i)
            EXPECT_NEAR(std::log2(error[i - 1] / error[i]), 2.0, 0.15) << "degree " << n;
    }
}

TEST(BezierCurve, FlatteningNeedsRootOfToleranceManyPoints)
{
    std::mt19937_64 random(59);
    const BezierCurve c = random_curve(random, 3);
    const double coarse = double(c.flatten(1e-4).points.size());
    const double fine = double(c.flatten(1e-8).points.size());
    EXPECT_NEAR(std::log10(fine / coarse), 2.0, 0.2);
    EXPECT_THROW(c.flatten(1e-18), ToleranceNotMet);
    EXPECT_THROW(c.flatten(0.0), InvalidInput);
    EXPECT_THROW(c.flatten(-1.0), InvalidInput);
    EXPECT_THROW(c.flatten(std::nan("")), InvalidInput);
}

TEST(BezierCurve, LengthOfAParabolaIsItsClosedForm)
{
    // y = x^2 over [0, 1].
    const BezierCurve c({{{0, 0, 0}}, {{0.5, 0, 0}}, {{1, 1, 0}}});
    const double exact = 0.5 * std::sqrt(5.0) + 0.25 * std::asinh(2.0);
    const auto length = c.length(1e-11);
    EXPECT_LE(length.bound, 1e-11);
    EXPECT_LE(std::fabs(length.length - exact), length.bound);
    const auto parts = c.length(1e-11, 0.0, 0.3).length + c.length(1e-11, 0.3, 1.0).length;
    EXPECT_NEAR(parts, exact, 1e-11);
}

TEST(BezierCurve, LengthHoldsAtCuspsAndForRandomCurves)
{
    // (t^2, t^3): speed t sqrt(4 + 9 t^2), a cusp at 0 and, mirrored, inside.
    const BezierCurve cusp({{{0, 0, 0}}, {{0, 0, 0}}, {{1.0 / 3, 0, 0}}, {{1, 1, 0}}});
    const double exact = (13.0 * std::sqrt(13.0) - 8.0) / 27.0;
    const auto length = cusp.length(1e-9);
    EXPECT_LE(std::fabs(length.length - exact), length.bound);
    const auto both = cusp.segment(-1.0, 1.0).length(1e-8);
    EXPECT_LE(std::fabs(both.length - 2.0 * exact), both.bound);
    std::mt19937_64 random(60);
    for (const bool rational : {false, true})
        for (const int n : {3, 6, 20}) {
            const BezierCurve c = random_curve(random, n, rational);
            const auto rough = c.length(1e-4), fine = c.length(1e-10);
            EXPECT_LE(std::fabs(rough.length - fine.length), rough.bound + fine.bound);
            double polyline = 0.0;
            const auto flat = c.flatten(1e-7).points;
            for (std::size_t i = 1; i < flat.size(); ++i)
                polyline += distance(flat[i - 1], flat[i]);
            EXPECT_LE(polyline, fine.length + 1e-9);
            EXPECT_GE(polyline, fine.length * (1.0 - 1e-4));
        }
}

TEST(BezierCurve, NearestBeatsEverySample)
{
    std::mt19937_64 random(61);
    for (const bool rational : {false, true})
        for (const int n : {1, 2, 3, 5, 12})
            for (int trial = 0; trial < 20; ++trial) {
                const BezierCurve c = random_curve(random, n, rational);
                const Vec3 p = random_vec(random, 1.5);
                const auto nearest = c.nearest(p, 1e-9);
                EXPECT_LE(nearest.bound, 1.3e-9);
                EXPECT_LE(distance(c.value(nearest.parameter), nearest.point), 1e-14);
                for (int i = 0; i <= 200; ++i)
                    ASSERT_GE(distance(c.value(i / 200.0), p), nearest.distance - nearest.bound);
            }
    // Every point of the arc is as near to the centre as every other.
    const auto centre = quarter_circle().nearest({{0, 0, 0}}, 1e-8);
    EXPECT_NEAR(centre.distance, 1.0, 1e-8);
}

TEST(BezierCurve, MeetsPlanesWhereItShould)
{
    std::mt19937_64 random(62);
    for (const bool rational : {false, true})
        for (int trial = 0; trial < 200; ++trial) {
            const BezierCurve c = random_curve(random, 1 + trial % 6, rational);
            const Vec3 normal = random_vec(random);
            const double offset = dot(normal, c.value(0.3));
            const auto roots = intersect_plane(c, normal, offset);
            bool found = false;
            for (const auto& r : roots) {
                EXPECT_NEAR(dot(normal, c.value(r.t)), offset, 1e-12);
                found = found || std::fabs(r.t - 0.3) < 1e-6;
            }
            EXPECT_TRUE(found) << trial;
        }
    EXPECT_THROW(intersect_plane(quarter_circle(), {}, 0.0), InvalidInput);
}

TEST(BezierCurve, PlaneCurvesCrossAsOftenAsBezoutAllows)
{
    // Two cubics y = f(x), x = f(y) with f(x) = 4 (x - 1/2)^3 * 4 - ... crossing nine times.
    const auto wave = [](double y0, double y1, double y2, double y3) {
        return BezierCurve({{{-1, y0, 0}}, {{-1.0 / 3, y1, 0}}, {{1.0 / 3, y2, 0}}, {{1, y3, 0}}});
    };
    // Chebyshev: f(x) = 4 x^3 - 3 x on [-1, 1] has Bernstein coefficients -1, 5, -5, 1.
    const BezierCurve a = wave(-1, 5, -5, 1);
    std::vector<Vec3> swapped;
    for (const Vec3& p : a.points()) swapped.push_back({{p[1], p[0], 0}});
    const auto result = intersect(a, BezierCurve(swapped), 1e-9);
    EXPECT_FALSE(result.overlap);
    ASSERT_EQ(result.crossings.size(), 9u);
    for (const auto& c : result.crossings) {
        EXPECT_LE(c.distance, 1e-12);
        EXPECT_LE(distance(a.value(c.s), c.point), 1e-9);
    }
}

TEST(BezierCurve, CurvesInSpaceMeetOnlyWhereTheyMeet)
{
    std::mt19937_64 random(63);
    for (int trial = 0; trial < 100; ++trial) {
        const BezierCurve a = random_curve(random, 3, trial % 2 == 1);
        BezierCurve b = random_curve(random, 4);
        EXPECT_TRUE(intersect(a, b, 1e-9).crossings.empty());
        const Vec3 by = a.value(0.37) - b.value(0.81);
        b = transformed(b, translation(by));
        const auto met = intersect(a, b, 1e-9);
        ASSERT_EQ(met.crossings.size(), 1u) << trial;
        EXPECT_NEAR(met.crossings[0].s, 0.37, 1e-6);
        EXPECT_NEAR(met.crossings[0].t, 0.81, 1e-6);
    }
}

TEST(BezierCurve, CoincidentCurvesAreReportedAsOverlap)
{
    std::mt19937_64 random(64);
    const BezierCurve c = random_curve(random, 3);
    EXPECT_TRUE(intersect(c, c.segment(0.2, 0.9), 1e-9).overlap);
}

TEST(CurveJoin, ContinuationsAreSmoothToTheirOrder)
{
    std::mt19937_64 random(65);
    for (const int n : {2, 3, 6})
        for (int order = 0; order <= 2; ++order)
            for (const double ratio : {0.5, 1.0, 3.0}) {
                const BezierCurve a = random_curve(random, n);
                auto points = continuation(a, order, ratio);
                ASSERT_EQ(points.size(), order + 1u);
                while (points.size() < n + 1u) points.push_back(random_vec(random));
                const CurveJoin j = join(a, BezierCurve(points), ratio);
                EXPECT_TRUE(j.continuous(order, 1e-11)) << n << " " << order << " " << ratio;
                if (order < 2 && n > order) {
                    EXPECT_FALSE(j.continuous(order + 1, 1e-3));
                }
                if (order >= 1) {
                    EXPECT_LE(j.turn, 1e-12);
                }
                if (order >= 2) {
                    EXPECT_LE(j.curvature, 1e-9);
                }
            }
}

TEST(CurveJoin, BothSidesOfAC2JoinShareTheApexOfTheAFrame)
{
    std::mt19937_64 random(66);
    for (const double ratio : {0.5, 1.0, 2.0}) {
        const BezierCurve a = random_curve(random, 3);
        auto points = continuation(a, 2, ratio);
        points.push_back(random_vec(random));
        const BezierCurve b(points);
        EXPECT_LE(distance(a_frame_apex(a, ratio), a_frame_apex(b.reversed(), 1.0 / ratio)), 1e-13);
    }
}

TEST(BezierCurve, RefusesBadArguments)
{
    EXPECT_THROW(BezierCurve({}), InvalidInput);
    EXPECT_THROW(BezierCurve(std::vector<Vec3>(kMaxDegree + 2)), InvalidInput);
    EXPECT_THROW(BezierCurve(std::vector<Vec3>{{{std::nan(""), 0, 0}}}), InvalidInput);
    EXPECT_THROW(BezierCurve({Vec3{}, Vec3{}}, {1.0}), InvalidInput);
    EXPECT_THROW(BezierCurve({Vec3{}, Vec3{}}, {1.0, 0.0}), InvalidInput);
    EXPECT_THROW(BezierCurve({Vec3{}, Vec3{}}, {1.0, -1.0}), InvalidInput);
    const BezierCurve c({Vec3{}, {{1, 0, 0}}});
    EXPECT_THROW(c.derivatives(0.5, -1), InvalidInput);
    EXPECT_THROW(c.elevated(1000), InvalidInput);
    EXPECT_THROW(c.reduced(0), InvalidInput);
    EXPECT_THROW(c.segment(0.5, 0.5), InvalidInput);
    EXPECT_THROW(continuation(c, 2), InvalidInput);
    EXPECT_THROW(join(c, c, 0.0), InvalidInput);
}

}  // namespace
}  // namespace genus
