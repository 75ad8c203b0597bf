#include "genus/implicit/torus.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/implicit/random_shapes.h"
#include "genus/base/error.h"

namespace genus {
namespace {

TEST(Torus, IsTheQuarticOfTheNotes)
{
    RandomShapes random(21);
    for (int trial = 0; trial < 500; ++trial) {
        const double R = random.in(1, 3), r = R * random.in(0.05, 0.95);
        const Torus torus(R, r);
        const Vec3 p = random.point(4);
        const long double xx = (long double)p[0] * p[0] + (long double)p[1] * p[1];
        const long double k =
            xx + (long double)p[2] * p[2] + (long double)R * R - (long double)r * r;
        const long double quartic = k * k - 4 * (long double)R * R * xx;
        EXPECT_NEAR(torus.value(p), double(quartic), 1e-13 * double(k * k));
    }
}

TEST(Torus, GradientIsTheLimitOfDifferences)
{
    RandomShapes random(22);
    for (int trial = 0; trial < 300; ++trial) {
        const Torus torus(2.0, 0.7, random.affine());
        const Vec3 p = random.point(3), g = torus.gradient(p);
        const double size = 1.0 + norm(g);
        for (int i = 0; i < 3; ++i) {
            const auto difference = [&](double h) {
                Vec3 step;
                step[i] = h;
                return (torus.value(p + step) - torus.value(p - step)) / (2 * h);
            };
            // The error of central differences falls with h^2: extrapolated, nothing is left but
            // rounding (F is of degree four).
            const double limit = (4 * difference(0.01) - difference(0.02)) / 3;
            EXPECT_NEAR(g[i], limit, 1e-7 * size * size);
        }
    }
}

TEST(Torus, ParametricPointsLieOnItWithOutwardNormals)
{
    RandomShapes random(23);
    for (int trial = 0; trial < 500; ++trial) {
        const Torus torus(2.0, random.in(0.1, 1.9), trial % 2 ? random.affine() : Transform{});
        const double u = random.in(-4, 4), v = random.in(-4, 4);
        const Vec3 p = torus.point(u, v), n = torus.normal(u, v), g = torus.gradient(p);
        EXPECT_NEAR(torus.value(p), 0.0, 1e-12 * (1.0 + norm(g)));
        EXPECT_NEAR(norm(n), 1.0, 1e-14);
        EXPECT_NEAR(dot(n, g), norm(g), 1e-8 * (1.0 + norm(g)));
    }
}

TEST(Torus, BoundsHoldValuesAndSlopes)
{
    RandomShapes random(24);
    for (int trial = 0; trial < 1000; ++trial) {
        SCOPED_TRACE(trial);
        const Torus torus(1.5, 0.5, trial % 2 ? random.affine() : Transform{});
        const Box3 box = random.box();
        const Interval bound = torus.bound(box);
        const IntervalVec3 slopes = torus.gradient_bound(box);
        for (int sample = 0; sample < 50; ++sample) {
            const Vec3 p = random.point_in(box);
            EXPECT_TRUE(bound.contains(torus.value(p)));
            for (int i = 0; i < 3; ++i) EXPECT_TRUE(slopes[i].contains(torus.gradient(p)[i]));
        }
    }
}

TEST(Torus, SignOfTheBoundIsSharpForBoxesAlongTheAxes)
{
    // The sign is that of (s - R)^2 + z^2 - r^2 in the half plane (s, z), where boxes stay boxes.
    const Torus torus(2.0, 0.5);
    EXPECT_LT(torus.bound({{{1.9, 0, -0.1}}, {{2.1, 0.1, 0.1}}}).hi, 0.0);
    EXPECT_GT(torus.bound({{{-1, -1, -1}}, {{1, 1, 1}}}).lo, 0.0);
    EXPECT_GT(torus.bound({{{-9, -9, 0.501}}, {{9, 9, 3}}}).lo, 0.0);
    EXPECT_GT(torus.bound(Box3{{{3, 3, 3}}, {{1e300, 1e300, 1e300}}}).lo, 0.0);
}

TEST(Torus, KeepsItsShapeFarFromTheOrigin)
{
    const Vec3 far{{1e12, -1e12, 1e11}};
    const Torus here(2, 0.5), there(2, 0.5, translation(far));
    for (const Vec3& p : {Vec3{{2.5, 0, 0}}, Vec3{{0, 1.5, 0}}, Vec3{{0.5, 2, 0.25}}})
        EXPECT_EQ(here.value(p), there.value(far + p));
}

TEST(Torus, RefusesRadiiThatMakeNone)
{
    EXPECT_THROW(Torus(1, 1), InvalidInput);
    EXPECT_THROW(Torus(1, 0), InvalidInput);
    EXPECT_THROW(Torus(1, -0.5), InvalidInput);
    EXPECT_THROW(Torus(std::nan(""), 0.5), InvalidInput);
    EXPECT_THROW(Torus(2, 1, scaling({{1, 0, 1}})), InvalidInput);
}

}  // namespace
}  // namespace genus
