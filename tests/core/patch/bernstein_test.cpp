#include "genus/patch/bernstein.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/patch/reference.h"
#include "genus/base/error.h"

namespace genus {
namespace {

using bernstein::Root;
using reference::Quad;

TEST(Bernstein, BasisIsAPartitionOfUnityAndSymmetric)
{
    for (const int n : {0, 1, 2, 3, 7, 20, 40, 100})
        for (const double t : {0.0, 0.125, 0.25, 0.5, 0.875, 1.0}) {
            const auto b = bernstein::basis(n, t), mirrored = bernstein::basis(n, 1.0 - t);
            EXPECT_NEAR(std::accumulate(b.begin(), b.end(), 0.0), 1.0, 1e-14);
            for (int k = 0; k <= n; ++k) {
                EXPECT_GE(b[k], 0.0);
                EXPECT_NEAR(b[k], mirrored[n - k], 1e-15);
                const double power = std::pow(t, k) * std::pow(1.0 - t, n - k);
                EXPECT_NEAR(b[k], bernstein::binomial(n, k) * power, 1e-13 * b[k] + 1e-300);
            }
        }
}

TEST(Bernstein, BinomialsAreThoseOfPascal)
{
    for (int n = 1; n <= 56; ++n)
        for (int k = 0; k <= n; ++k)
            EXPECT_EQ(bernstein::binomial(n, k),
                      bernstein::binomial(n - 1, k - 1) + bernstein::binomial(n - 1, k));
    EXPECT_TRUE(std::isfinite(bernstein::binomial(kMaxDegree, kMaxDegree / 2)));
}

TEST(Bernstein, ElevationSplitSegmentAndProductKeepTheFunction)
{
    std::mt19937_64 random(41);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    for (const int n : {1, 2, 5, 12}) {
        std::vector<double> c(n + 1), d(4);
        for (double& x : c) x = number(random);
        for (double& x : d) x = number(random);
        const auto up = bernstein::elevated<double>(c);
        const auto part = bernstein::segment<double>(c, 0.2, 0.7);
        const auto backwards = bernstein::segment<double>(c, 0.9, 0.1);
        const auto product = bernstein::product(c, d);
        std::vector<double> left, right;
        bernstein::split<double>(c, 0.3, left, right);
        for (const double t : {0.0, 0.1, 0.5, 0.77, 1.0}) {
            const auto value = [&](double s) { return bernstein::value<double>(c, s); };
            EXPECT_NEAR(bernstein::value<double>(up, t), value(t), 1e-14);
            EXPECT_NEAR(bernstein::value<double>(part, t), value(0.2 + 0.5 * t), 1e-13);
            EXPECT_NEAR(bernstein::value<double>(backwards, t), value(0.9 - 0.8 * t), 1e-13);
            EXPECT_NEAR(bernstein::value<double>(left, t), value(0.3 * t), 1e-14);
            EXPECT_NEAR(bernstein::value<double>(right, t), value(0.3 + 0.7 * t), 1e-14);
            EXPECT_NEAR(bernstein::value<double>(product, t),
                        value(t) * bernstein::value<double>(d, t), 1e-14);
        }
    }
}

// Coefficients of the product of all (t - r) for the given r.
std::vector<double> with_roots(const std::vector<double>& r)
{
    std::vector<double> c = {1.0};
    for (const double x : r) c = bernstein::product(c, std::vector<double>{-x, 1.0 - x});
    return c;
}

TEST(BernsteinRoots, FindsTheRootsOfWilkinson)
{
    std::vector<double> expected;
    for (int k = 1; k <= 20; ++k) expected.push_back(k / 21.0);
    const auto found = bernstein::roots(with_roots(expected));
    ASSERT_EQ(found.size(), 20u);
    for (std::size_t k = 0; k < 20; ++k) {
        EXPECT_TRUE(found[k].simple);
        EXPECT_NEAR(found[k].t, expected[k], 1e-9);
    }
}

TEST(BernsteinRoots, FindsRandomRootsAndNoOthers)
{
    std::mt19937_64 random(42);
    std::uniform_real_distribution<double> inside(0.0, 1.0), outside(1.1, 3.0);
    for (int trial = 0; trial < 2000; ++trial) {
        std::vector<double> r;
        while (r.size() < 4) {
            const double x = inside(random);
            bool apart = true;
            for (const double y : r) apart = apart && std::fabs(x - y) > 1e-3;
            if (apart) r.push_back(x);
        }
        std::sort(r.begin(), r.end());
        auto all = r;
        all.push_back(outside(random));
        all.push_back(-outside(random));
        const auto found = bernstein::roots(with_roots(all));
        ASSERT_EQ(found.size(), r.size()) << "trial " << trial;
        for (std::size_t k = 0; k < r.size(); ++k) ASSERT_NEAR(found[k].t, r[k], 1e-9);
    }
}

TEST(BernsteinRoots, ReportsRepeatedRootsOnceAndAsNotSimple)
{
    for (const int times : {2, 3, 4, 20}) {
        std::vector<double> r(times, 0.375);
        const auto found = bernstein::roots(with_roots(r));
        ASSERT_GE(found.size(), 1u) << times;
        // Rounding may break up a root of very high order.
        if (times <= 4) {
            ASSERT_EQ(found.size(), 1u) << times;
        }
        // A root of order k is known to the k-th root of rounding.
        for (const Root& root : found)
            EXPECT_NEAR(root.t, 0.375, 2.0 * std::pow(1e-15, 1.0 / times)) << times;
        if (times == 2 || times == 4) {
            EXPECT_FALSE(found[0].simple);
        }
    }
}

TEST(BernsteinRoots, FindsRootsAtEndsAndCuts)
{
    const auto found = bernstein::roots(with_roots({0.0, 0.5, 1.0}));
    ASSERT_EQ(found.size(), 3u);
    EXPECT_EQ(found[0].t, 0.0);
    EXPECT_NEAR(found[1].t, 0.5, 1e-15);
    EXPECT_EQ(found[2].t, 1.0);
    for (const Root& r : found) EXPECT_TRUE(r.simple);
    EXPECT_TRUE(bernstein::roots(std::vector<double>{1.0, 0.1, 1.0}).empty());
    EXPECT_TRUE(bernstein::roots(std::vector<double>{0.0, 0.0}).empty());
    EXPECT_THROW(bernstein::roots(std::vector<double>{}), InvalidInput);
    EXPECT_THROW(bernstein::roots(std::vector<double>{1.0, std::nan("")}), InvalidInput);
}

// The ill-conditioned families: Wilkinson-like polynomials, and coefficients from 1e-12 to 1e12
// of either sign, up to degree 40.
std::vector<Vec3> hard_points(std::mt19937_64& random, int n)
{
    std::uniform_real_distribution<double> exponent(-12.0, 12.0), sign(-1.0, 1.0);
    std::vector<Vec3> points(n + 1);
    for (std::size_t k = 0; k < 3; ++k) {
        if (k == 0) {
            std::vector<double> r;
            for (int i = 1; i <= n; ++i) r.push_back(i / (n + 1.0));
            const auto c = with_roots(r);
            for (int i = 0; i <= n; ++i) points[i][k] = c[i];
            continue;
        }
        for (int i = 0; i <= n; ++i)
            points[i][k] = std::copysign(std::pow(10.0, exponent(random)), sign(random));
    }
    return points;
}

TEST(BernsteinBounds, AlwaysHoldAndAreTightInTheMedian)
{
    const int per_degree = reference::long_run() ? 250000 : 1500;
    std::mt19937_64 random(43);
    std::uniform_real_distribution<double> parameter(0.0, 1.0);
    for (const int n : {3, 10, 20, 40}) {
        SCOPED_TRACE(testing::Message() << "degree " << n << " seed 43");
        std::vector<double> ratios;
        std::vector<Vec3> points;
        for (int trial = 0; trial < per_degree; ++trial) {
            if (trial % 50 == 0) points = hard_points(random, n);
            const double t = parameter(random);
            const auto ours = bernstein::value_with_bound<3>(points, t);
            const auto truth = reference::value<3>(points, t);
            for (std::size_t k = 0; k < 3; ++k) {
                const Quad error = reference::magnitude(truth[k] - Quad(ours.value[k]));
                ASSERT_LE(error, Quad(ours.bound[k])) << "t " << t << " coordinate " << k;
                if (error > 0) ratios.push_back(double(Quad(ours.bound[k]) / error));
            }
        }
        std::nth_element(ratios.begin(), ratios.begin() + ratios.size() / 2, ratios.end());
        const double median = ratios[ratios.size() / 2];
        EXPECT_LE(median, 10.0);
        RecordProperty("median_ratio_degree_" + std::to_string(n), std::to_string(median));
    }
}

TEST(BernsteinBounds, HoldForRationalCurves)
{
    std::mt19937_64 random(44);
    std::uniform_real_distribution<double> weight(0.01, 100.0), parameter(0.0, 1.0);
    for (int trial = 0; trial < 2000; ++trial) {
        std::vector<Vec4> c;
        for (const Vec3& p : hard_points(random, 1 + trial % 12))
            c.push_back({{p[0], p[1], p[2], weight(random)}});
        const double t = parameter(random);
        const auto ours = bernstein::rational_value_with_bound(c, t);
        const auto truth = reference::value<4>(c, t);
        for (std::size_t k = 0; k < 3; ++k) {
            const Quad error = reference::magnitude(truth[k] / truth[3] - Quad(ours.value[k]));
            ASSERT_LE(error, Quad(ours.bound[k])) << trial;
            ASSERT_LE(ours.bound[k], 1e-15 * std::fabs(ours.value[k]) + 1e-14 * 1e12);
        }
    }
}

}  // namespace
}  // namespace genus
