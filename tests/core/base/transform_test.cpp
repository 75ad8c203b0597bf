#include "genus/base/transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "genus/base/error.h"

namespace genus {
namespace {

void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-14)
{
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "axis " << i;
}

Vec3 random_point(std::mt19937& random)
{
    std::uniform_real_distribution<double> coordinate(-2.0, 2.0);
    return {{coordinate(random), coordinate(random), coordinate(random)}};
}

TEST(DegreeTrigonometry, IsExactWhereTheAnswerIsADouble)
{
    for (int turn = -3; turn <= 3; ++turn) {
        const double a = 360.0 * turn;
        EXPECT_EQ(sin_degrees(a), 0.0);
        EXPECT_EQ(sin_degrees(a + 30), 0.5);
        EXPECT_EQ(sin_degrees(a + 90), 1.0);
        EXPECT_EQ(sin_degrees(a + 150), 0.5);
        EXPECT_EQ(sin_degrees(a + 180), 0.0);
        EXPECT_EQ(sin_degrees(a + 210), -0.5);
        EXPECT_EQ(sin_degrees(a + 270), -1.0);
        EXPECT_EQ(cos_degrees(a), 1.0);
        EXPECT_EQ(cos_degrees(a + 60), 0.5);
        EXPECT_EQ(cos_degrees(a + 90), 0.0);
        EXPECT_EQ(cos_degrees(a + 120), -0.5);
        EXPECT_EQ(cos_degrees(a + 180), -1.0);
        EXPECT_EQ(cos_degrees(a + 300), 0.5);
    }
}

TEST(DegreeTrigonometry, IsWithinOneUnitInTheLastPlace)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> angle(-720.0, 720.0);
    const long double pi = 3.141592653589793238462643383279502884L;
    for (int trial = 0; trial < 100000; ++trial) {
        const double d = angle(random);
        // The reduced angle is exact, so only the last conversion rounds.
        const long double radians = std::fmod(d, 360.0) * pi / 180;
        const long double s = std::sin(radians), c = std::cos(radians);
        EXPECT_LE(std::fabs(sin_degrees(d) - s), 0x1p-52L * std::fabs(s) + 1e-18L) << d;
        EXPECT_LE(std::fabs(cos_degrees(d) - c), 0x1p-52L * std::fabs(c) + 1e-18L) << d;
    }
}

TEST(DegreeTrigonometry, HasTheSymmetriesOfTheCircle)
{
    std::mt19937 random(4);
    std::uniform_real_distribution<double> angle(0.0, 90.0);
    for (int trial = 0; trial < 10000; ++trial) {
        // Multiples of 2^-40: sums with 90, 180, 360 are exact.
        const double d = std::ldexp(std::floor(std::ldexp(angle(random), 40)), -40);
        EXPECT_EQ(sin_degrees(d), cos_degrees(90 - d));
        EXPECT_EQ(sin_degrees(180 - d), sin_degrees(d));
        EXPECT_EQ(sin_degrees(-d), -sin_degrees(d));
        EXPECT_EQ(cos_degrees(180 - d), -cos_degrees(d));
        EXPECT_EQ(cos_degrees(d + 360), cos_degrees(d));
    }
}

TEST(DegreeTrigonometry, OfAnInfiniteAngleIsNotANumber)
{
    EXPECT_TRUE(std::isnan(sin_degrees(INFINITY)));
    EXPECT_TRUE(std::isnan(cos_degrees(NAN)));
}

TEST(Transform, PointsMoveVectorsDoNot)
{
    const Transform t = translation({{1, 2, 3}});
    expect_near(apply(t, Vec3{{1, 1, 1}}), {{2, 3, 4}}, 0);
    expect_near(apply_vector(t, {{1, 1, 1}}), {{1, 1, 1}}, 0);
}

TEST(Transform, QuarterTurnsAreExact)
{
    expect_near(apply(rotation_x(90), Vec3{{0, 1, 0}}), {{0, 0, 1}}, 0);
    expect_near(apply(rotation_y(90), Vec3{{0, 0, 1}}), {{1, 0, 0}}, 0);
    expect_near(apply(rotation_z(90), Vec3{{1, 0, 0}}), {{0, 1, 0}}, 0);
}

TEST(Transform, EulerAnglesTurnAboutXThenYThenZ)
{
    const Vec3 p{{0.3, -0.7, 1.1}};
    const Vec3 step = apply(rotation_z(50), apply(rotation_y(40), apply(rotation_x(30), p)));
    expect_near(apply(rotation({{30, 40, 50}}), p), step);
}

TEST(Transform, RodriguesAgreesWithTheAxisRotations)
{
    for (const double angle : {0.0, 12.5, 90.0, 180.0, -75.0}) {
        const Vec3 p{{0.3, -0.7, 1.1}};
        expect_near(apply(rotation(angle, {{2, 0, 0}}), p), apply(rotation_x(angle), p));
        expect_near(apply(rotation(angle, {{0, 5, 0}}), p), apply(rotation_y(angle), p));
        expect_near(apply(rotation(angle, {{0, 0, 1}}), p), apply(rotation_z(angle), p));
    }
    // A third of a turn about the diagonal permutes the axes.
    expect_near(apply(rotation(120, {{1, 1, 1}}), Vec3{{1, 2, 3}}), {{3, 1, 2}});
}

TEST(Transform, MirrorTwiceIsNothing)
{
    const Transform t = mirror({{1, 2, 2}});
    EXPECT_NEAR(determinant(t), -1.0, 1e-15);
    const Vec3 p{{0.3, -0.7, 1.1}};
    expect_near(apply(t, apply(t, p)), p);
    expect_near(apply(t, Vec3{{1, 2, 2}}), {{-1, -2, -2}});
}

TEST(Transform, ShearKeepsVolume)
{
    const Transform t = shear({2, 0, 0, 0, 0, 0});
    EXPECT_EQ(determinant(t), 1.0);
    expect_near(apply(t, Vec3{{1, 1, 0}}), {{3, 1, 0}}, 0);
}

TEST(Transform, InverseUndoesAffineMapsAndProjections)
{
    std::mt19937 random(5);
    const Transform maps[] = {
        translation({{1e6, -3, 0.5}}) * rotation({{10, 20, 30}}) * scaling({{1e-3, 2, 700}}),
        shear({1, 2, 3, -1, 0.5, 4}), perspective(60, 1.5, 0.1, 100),
        orthographic({{{-1, -2, -30}}, {{4, 5, -1}}}),
        look_at({{3, 4, 5}}, {{0, 0, 1}}, {{0, 0, 1}})};
    for (const Transform& t : maps) {
        const Transform product = t * inverse(t);
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                EXPECT_NEAR(product.m[i][j], i == j ? 1.0 : 0.0, 1e-9) << i << "," << j;
    }
}

TEST(Transform, ConditionNotSizeMakesAMapSingular)
{
    EXPECT_NO_THROW(inverse(scaling({{1e-60, 1e-60, 1e-60}})));
    EXPECT_NO_THROW(inverse(scaling({{1e12, 1, 1e-12}})));
    EXPECT_THROW(inverse(scaling({{1, 0, 1}})), InvalidInput);
    Transform flat;
    flat.m[2] = {1, 1, 0, 0};
    EXPECT_THROW(inverse(flat), InvalidInput);
    Transform no_projection = perspective(60, 1, 1, 2);
    no_projection.m[1] = {0, 0, 0, 0};
    EXPECT_THROW(inverse(no_projection), InvalidInput);
}

TEST(Transform, NormalsStayPerpendicularToImagesOfTangents)
{
    std::mt19937 random(6);
    const Transform t =
        rotation({{10, 20, 30}}) * scaling({{1, -3, 0.2}}) * shear({1, 0, 0, 0.5, 0, 0});
    for (int trial = 0; trial < 100; ++trial) {
        const Vec3 a = random_point(random), b = random_point(random);
        const Vec3 n = cross(a, b);
        const Vec3 image = apply_normal(t, n);
        EXPECT_NEAR(dot(image, apply_vector(t, a)), 0.0, 1e-12);
        EXPECT_NEAR(dot(image, apply_vector(t, b)), 0.0, 1e-12);
        EXPECT_GT(dot(image, apply_vector(t, n)), 0.0);  // still on the same side
    }
}

TEST(Transform, LargestStretchIsExactForRotationsAndBoundsTheRest)
{
    EXPECT_NEAR(largest_stretch(rotation({{10, 20, 30}})), 1.0, 1e-15);
    EXPECT_EQ(largest_stretch(scaling({{1, -3, 0.5}})), 3.0);
    std::mt19937 random(9);
    const Transform t =
        rotation({{10, 20, 30}}) * scaling({{1, 3, 0.2}}) * shear({1, 0, 2, 0.5, 0, 0});
    double found = 0.0;
    for (int trial = 0; trial < 20000; ++trial) {
        const Vec3 v = random_point(random);
        found = std::max(found, norm(apply_vector(t, v)) / norm(v));
    }
    EXPECT_LE(found, largest_stretch(t));
    EXPECT_GE(std::sqrt(3.0) * found, largest_stretch(t));
}

TEST(Transform, LookAtPutsTheTargetOnTheNegativeZAxis)
{
    const Transform t = look_at({{3, 4, 5}}, {{0, 0, 1}}, {{0, 0, 1}});
    expect_near(apply(t, Vec3{{3, 4, 5}}), {{0, 0, 0}});
    const Vec3 target = apply(t, Vec3{{0, 0, 1}});
    expect_near(target, {{0, 0, -std::sqrt(41.0)}});
    EXPECT_GT(apply(t, Vec3{{0, 0, 2}})[1], target[1]);
}

TEST(Transform, ProjectionsMapTheViewVolumeToTheCube)
{
    const Transform p = perspective(90, 2, 1, 10);
    expect_near(apply(p, Vec3{{2, 1, -1}}), {{1, 1, -1}});
    expect_near(apply(p, Vec3{{-20, -10, -10}}), {{-1, -1, 1}});
    const Transform o = orthographic({{{0, 0, -9}}, {{4, 2, -1}}});
    expect_near(apply(o, Vec3{{0, 0, -1}}), {{-1, -1, -1}});
    expect_near(apply(o, Vec3{{4, 2, -9}}), {{1, 1, 1}});
}

TEST(Transform, ImageOfABoxHoldsTheImagesOfItsPoints)
{
    std::mt19937 random(8);
    const Box3 box{{{-1, -2, 0}}, {{2, 2, 1}}};
    const Transform t = rotation({{10, 20, 30}}) * scaling({{1, 3, 0.2}});
    const Box3 image = apply(t, box);
    for (int corner = 0; corner < 8; ++corner) {
        Vec3 p;
        for (int i = 0; i < 3; ++i) p[i] = corner >> i & 1 ? box.max[i] : box.min[i];
        EXPECT_TRUE(image.inflated(1e-15).contains(apply(t, p)));
    }
    Box3 slab = Box3::everything();
    slab.min[2] = 0.0;
    slab.max[2] = 1.0;
    const Box3 turned = apply(rotation_z(90), slab);
    EXPECT_EQ(turned.min[2], 0.0);
    EXPECT_EQ(turned.max[2], 1.0);
    EXPECT_TRUE(std::isinf(turned.max[0]));
}

TEST(Transform, BadArgumentsAreNamed)
{
    EXPECT_THROW(translation({{NAN, 0, 0}}), InvalidInput);
    EXPECT_THROW(rotation_x(INFINITY), InvalidInput);
    EXPECT_THROW(rotation(30, {{0, 0, 0}}), InvalidInput);
    EXPECT_THROW(mirror({{0, 0, 0}}), InvalidInput);
    EXPECT_THROW(look_at({{1, 1, 1}}, {{1, 1, 1}}, {{0, 0, 1}}), InvalidInput);
    EXPECT_THROW(look_at({{0, 0, 1}}, {{0, 0, 0}}, {{0, 0, 1}}), InvalidInput);
    EXPECT_THROW(perspective(180, 1, 1, 2), InvalidInput);
    try {
        perspective(60, 1, -2, 2);
        FAIL();
    } catch (const InvalidInput& error) {
        EXPECT_STREQ(error.what(), "perspective: near_plane is -2, must be positive");
    }
}

}  // namespace
}  // namespace genus
