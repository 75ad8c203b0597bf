#include "genus/implicit/quadric.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/implicit/random_shapes.h"
#include "genus/base/error.h"

namespace genus {
namespace {

Quadric random_quadric(RandomShapes& random)
{
    std::array<double, 10> q{};
    for (double& c : q) c = random.below(4) == 0 ? 0.0 : random.in(-3.0, 3.0);
    const int kind = random.below(4);
    if (kind == 0) q[1] = q[2] = q[5] = 0.0;
    if (kind == 1) q[0] = q[1] = q[2] = q[4] = q[5] = q[7] = 0.0;
    return Quadric(q, kind == 2 ? random.point() : Vec3{});
}

long double value_in_long(const Quadric& quadric, const Vec3& p)
{
    const auto& q = quadric.local();
    const long double x = (long double)p[0] - quadric.origin()[0];
    const long double y = (long double)p[1] - quadric.origin()[1];
    const long double z = (long double)p[2] - quadric.origin()[2];
    return x * (q[0] * x + 2 * (q[1] * y + q[2] * z + q[3])) +
           y * (q[4] * y + 2 * (q[5] * z + q[6])) + z * (q[7] * z + 2 * (long double)q[8]) + q[9];
}

TEST(Quadric, SaysTheSameInAllThreeForms)
{
    RandomShapes random(1);
    for (int trial = 0; trial < 200; ++trial) {
        const Quadric quadric(random_quadric(random).upper_triangle());
        EXPECT_EQ(Quadric::from_polynomial(quadric.polynomial()), quadric);
        EXPECT_EQ(Quadric::from_matrix(quadric.matrix()), quadric);
        const Vec3 p = random.point();
        const auto c = quadric.polynomial();
        const double x = p[0], y = p[1], z = p[2];
        const double polynomial = c[0] * x * x + c[1] * y * y + c[2] * z * z + c[3] * x * y +
                                  c[4] * x * z + c[5] * y * z + c[6] * x + c[7] * y + c[8] * z +
                                  c[9];
        EXPECT_NEAR(quadric.value(p), polynomial, 1e-13);
        const std::array<double, 4> extended{x, y, z, 1.0};
        double symmetric = 0.0;
        for (int row = 0; row < 4; ++row)
            for (int col = 0; col < 4; ++col)
                symmetric += extended[row] * quadric.matrix()[row][col] * extended[col];
        EXPECT_NEAR(quadric.value(p), symmetric, 1e-13);
    }
}

TEST(Quadric, RefusesBadNumbers)
{
    auto m = Quadric::sphere(1).matrix();
    m[0][2] = 0.5;
    EXPECT_THROW(Quadric::from_matrix(m), InvalidInput);
    EXPECT_THROW(Quadric({1, 0, 0, 0, 1, 0, 0, 1, 0, std::nan("")}), InvalidInput);
    EXPECT_THROW(Quadric::sphere(1e200), InvalidInput);
    EXPECT_THROW(transformed(Quadric::sphere(1), scaling({{1, 1, 0}})), InvalidInput);
    EXPECT_THROW(transformed(Quadric::sphere(1), perspective(90, 1, 1, 2)), InvalidInput);
}

TEST(Quadric, GradientIsTheCentralDifference)
{
    // For polynomials of degree two the central difference is exact.
    RandomShapes random(2);
    for (int trial = 0; trial < 500; ++trial) {
        const Quadric quadric = random_quadric(random);
        const Vec3 p = random.point(), g = quadric.gradient(p);
        for (int i = 0; i < 3; ++i) {
            Vec3 step;
            step[i] = 0.25;
            const double difference = (quadric.value(p + step) - quadric.value(p - step)) / 0.5;
            EXPECT_NEAR(g[i], difference, 1e-12);
        }
    }
}

TEST(Quadric, MovedByAMapHasTheValuesOfTheOriginal)
{
    RandomShapes random(3);
    for (int trial = 0; trial < 2000; ++trial) {
        SCOPED_TRACE(trial);
        const Quadric quadric = random_quadric(random);
        const Transform t = random.affine();
        const Quadric moved = transformed(quadric, t);
        EXPECT_EQ(moved.is_linear(), quadric.is_linear());
        const Vec3 p = random.point();
        EXPECT_NEAR(moved.value(apply(t, p)), quadric.value(p), 1e-11);
        const Vec3 n = apply_normal(t, quadric.gradient(p));
        const Vec3 g = moved.gradient(apply(t, p));
        EXPECT_NEAR(norm(cross(n, g)), 0.0, 1e-10 * (1.0 + norm(n) * norm(g)));
        EXPECT_GE(dot(n, g), 0.0);
    }
}

TEST(Quadric, KeepsItsShapeToTheLastBitFarFromTheOrigin)
{
    // Coefficients about (0, 0, 0) could not even hold the radius at 10^12.
    const Vec3 far{{1e12, -1e12, 3e11}};
    const Quadric moved = transformed(Quadric::sphere(1), translation(far));
    EXPECT_EQ(moved.local(), Quadric::sphere(1).local());
    EXPECT_EQ(moved.value(far + Vec3{{1, 0, 0}}), 0.0);
    EXPECT_LT(moved.value(far + Vec3{{0, 0.5, 0}}), 0.0);
    EXPECT_EQ(moved.gradient(far + Vec3{{0, 0, -1}}), (Vec3{{0, 0, -2}}));
    const Quadric back = transformed(moved, translation(-far));
    EXPECT_EQ(back, Quadric::sphere(1));
}

TEST(Quadric, SphereStaysWithoutMixedTermsUnderRotation)
{
    RandomShapes random(4);
    for (int trial = 0; trial < 100; ++trial) {
        const Quadric moved = transformed(Quadric::sphere(2), rotation(random.point(180)));
        EXPECT_EQ(moved.local()[1], 0.0);
        EXPECT_EQ(moved.local()[2], 0.0);
        EXPECT_EQ(moved.local()[5], 0.0);
        EXPECT_NEAR(moved.local()[0], 1.0, 1e-15);
    }
}

TEST(Quadric, HalfSpacesStayExactlyLinear)
{
    const Quadric plane = Quadric::half_space({{0, 0, 1}}, 1.0);
    const Quadric moved = transformed(plane, translation({{0, 0, 1e12}}));
    EXPECT_TRUE(moved.is_linear());
    EXPECT_EQ(moved.value({{5, 7, 1e12 + 1}}), 0.0);
    EXPECT_EQ(transformed(plane, rotation_x(90)).gradient({}), (Vec3{{0, -1, 0}}));
}

TEST(QuadricBound, HoldsEveryValueInTheBox)
{
    RandomShapes random(5);
    for (int trial = 0; trial < 2000; ++trial) {
        SCOPED_TRACE(trial);
        const Quadric quadric = random_quadric(random);
        const Box3 box = random.box();
        const Interval bound = quadric.bound(box);
        const IntervalVec3 slopes = quadric.gradient_bound(box);
        for (int sample = 0; sample < 50; ++sample) {
            const Vec3 p = random.point_in(box);
            EXPECT_TRUE(bound.contains(quadric.value(p)));
            const long double exact = value_in_long(quadric, p);
            EXPECT_LE(bound.lo, exact);
            EXPECT_GE(bound.hi, exact);
            for (int i = 0; i < 3; ++i) EXPECT_TRUE(slopes[i].contains(quadric.gradient(p)[i]));
        }
    }
}

TEST(QuadricBound, IsExactWithoutMixedTerms)
{
    RandomShapes random(6);
    for (int trial = 0; trial < 500; ++trial) {
        SCOPED_TRACE(trial);
        std::array<double, 10> q{};
        for (int i : {0, 3, 4, 6, 7, 8, 9}) q[i] = random.in(-2, 2);
        const Quadric quadric(q);
        const Box3 box = random.box();
        // Per variable the extremes are at the ends or at the apex.
        double lo = q[9], hi = q[9];
        const std::array<double, 3> a{q[0], q[4], q[7]}, b{q[3], q[6], q[8]};
        for (int i = 0; i < 3; ++i) {
            const auto part = [&](double x) { return x * (a[i] * x + 2.0 * b[i]); };
            double least = std::min(part(box.min[i]), part(box.max[i]));
            double most = std::max(part(box.min[i]), part(box.max[i]));
            const double apex = -b[i] / a[i];
            if (box.min[i] < apex && apex < box.max[i]) {
                least = std::min(least, part(apex));
                most = std::max(most, part(apex));
            }
            lo += least;
            hi += most;
        }
        const Interval bound = quadric.bound(box);
        EXPECT_NEAR(bound.lo, lo, 1e-12);
        EXPECT_NEAR(bound.hi, hi, 1e-12);
    }
}

TEST(QuadricBound, IsExactWhereFIsMonotoneAndQuadraticallyGoodElsewhere)
{
    RandomShapes random(7);
    for (int trial = 0; trial < 500; ++trial) {
        SCOPED_TRACE(trial);
        const Quadric quadric = random_quadric(random);
        const Vec3 p = random.point();
        for (const double size : {0.1, 0.01, 0.001}) {
            Box3 box;
            box.add(p - Vec3{{size, size, size}});
            box.add(p + Vec3{{size, size, size}});
            const Interval bound = quadric.bound(box);
            // Sampled extremes are at most the second-order terms away from the bound.
            Interval sampled(1e300, -1e300);
            for (int i = 0; i < 27; ++i) {
                const Vec3 d{{i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0}};
                const double f = quadric.value(p + size * d);
                sampled = hull(sampled, Interval(f));
            }
            EXPECT_LE(sampled.lo - bound.lo, 60.0 * size * size);
            EXPECT_LE(bound.hi - sampled.hi, 60.0 * size * size);
            const IntervalVec3 g = quadric.gradient_bound(box);
            if (!g[0].contains(0) && !g[1].contains(0) && !g[2].contains(0)) {
                EXPECT_NEAR(sampled.lo, bound.lo, 1e-12);
                EXPECT_NEAR(sampled.hi, bound.hi, 1e-12);
            }
        }
    }
}

TEST(QuadricBound, TakesBoxesWithoutEnd)
{
    const double inf = std::numeric_limits<double>::infinity();
    const Interval ball = Quadric::sphere(2).bound(Box3::everything());
    EXPECT_LE(ball.lo, -4.0);
    EXPECT_GE(ball.lo, -4.0 - 1e-12);
    EXPECT_EQ(ball.hi, inf);
    const Box3 above{{{-inf, -inf, 5.0}}, {{inf, inf, inf}}};
    EXPECT_GT(Quadric::half_space({{0, 0, 1}}, 4.0).bound(above).lo, 0.0);
    EXPECT_GT(Quadric::sphere(4).bound(above).lo, 8.9);
    EXPECT_GT(Quadric::sphere(4).gradient_bound(above)[2].lo, 9.9);
    EXPECT_EQ(Quadric::sphere(4).gradient_bound(above)[0], Interval::everything());
}

TEST(QuadricBound, SurvivesTheLargestAndSmallestNumbers)
{
    for (const double size : {1e-150, 1e-100, 1e-30, 1e30, 1e100, 1e150}) {
        const Quadric ball = Quadric::sphere(size);
        Box3 box;
        box.add(Vec3{{-size, -size, -size}});
        box.add(Vec3{{size, size, 0.5 * size}});
        const Interval bound = ball.bound(box);
        EXPECT_LE(bound.lo, -size * size);
        EXPECT_GE(bound.lo, -size * size * (1 + 1e-12) - 1e-306);
        EXPECT_GE(bound.hi, 2.0 * size * size);
        EXPECT_LE(bound.hi, 2.0 * size * size * (1 + 1e-12) + 1e-306);
    }
}

TEST(QuadricCurvature, BoundsThatOfKnownSurfaces)
{
    // A ball of radius 2 has curvature 1/2; near its surface the bound tends to it.
    const Quadric ball = Quadric::sphere(2);
    Box3 box;
    box.add(Vec3{{2, 0, 0}});
    box = box.inflated(1e-6);
    EXPECT_GE(curvature_bound(ball, box), 0.5);
    EXPECT_LE(curvature_bound(ball, box), 0.5 + 1e-5);
    EXPECT_EQ(curvature_bound(Quadric::half_space({{1, 2, 3}}, 4), box), 0.0);
    EXPECT_EQ(curvature_bound(ball, Box3{{{-1, -1, -1}}, {{1, 1, 1}}}),
              std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace genus
