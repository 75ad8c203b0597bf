#include "genus/deform/ffd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/patch/reference.h"
#include "genus/base/error.h"
#include "genus/patch/bulk.h"

namespace genus {
namespace {

using reference::random_points;
using reference::random_vec;

const Vec3 kOrigin = {{-1, 0.5, 2}};
const Columns3 kAxes = {Vec3{{2, 0.3, 0}}, Vec3{{-0.2, 3, 0.1}}, Vec3{{0.4, 0, 1.5}}};

Lattice random_lattice(std::mt19937_64& random, const std::array<int, 3>& degree, double size,
                       bool spline = false)
{
    Lattice l =
        spline ? Lattice::bspline(kOrigin, kAxes, {degree[0] + 4, degree[1] + 4, degree[2] + 5})
               : Lattice(kOrigin, kAxes, degree);
    l.set_moves(random_points(random, static_cast<int>(l.n_points()), size));
    return l;
}

Vec3 random_inside(std::mt19937_64& random, const Lattice& l)
{
    std::uniform_real_distribution<double> x(0.0, 1.0);
    return l.global({{x(random), x(random), x(random)}});
}

TEST(Lattice, UndeformedIsTheIdentityToTheLastBit)
{
    std::mt19937_64 random(111);
    for (const bool spline : {false, true}) {
        const Lattice l = random_lattice(random, {3, 2, 4}, 0.0, spline);
        for (const Vec3& x : random_points(random, 100, 4.0)) EXPECT_EQ(l.apply(x), x);
        EXPECT_EQ(l.folds().kind, FoldReport::Kind::None);
        EXPECT_NEAR(l.folds().determinant, 1.0, 1e-9);
        // Putting the control points where they are changes nothing but rounding.
        Lattice again = l;
        again.set_points(l.points());
        for (const Vec3& d : again.moves()) EXPECT_LE(norm(d), 1e-15);
    }
}

// The sum over all control points of the book's formula.
TEST(Lattice, AgreesWithTheSumOverControlPoints)
{
    std::mt19937_64 random(112);
    for (const bool spline : {false, true})
        for (const auto& degree :
             {std::array{1, 1, 1}, {3, 3, 3}, {7, 7, 7}, {2, 5, 4}, {20, 3, 1}}) {
            const Lattice l = random_lattice(random, degree, 1.0, spline);
            const auto points = l.points();
            std::vector<Vec3> x(37), y(37);
            for (Vec3& p : x) p = random_inside(random, l);
            l.apply(x, y);
            for (std::size_t i = 0; i < x.size(); ++i) {
                const auto w = l.weights(x[i]);
                Vec3 sum;
                double unity = 0.0;
                for (std::size_t k = 0; k < w.size(); ++k) {
                    sum += w[k] * points[k];
                    unity += w[k];
                }
                ASSERT_NEAR(unity, 1.0, 1e-13);
                ASSERT_LE(distance(sum, y[i]), 1e-12);
                ASSERT_EQ(l.apply(x[i]), y[i]);
            }
        }
}

TEST(Lattice, AffineMovesOfTheControlPointsAreAffineMaps)
{
    std::mt19937_64 random(113);
    for (const bool spline : {false, true}) {
        Lattice l = random_lattice(random, {4, 2, 3}, 0.0, spline);
        const Transform map = rotation(40.0, {{1, 2, 3}}) * scaling({{1.5, 0.7, 2}});
        auto points = l.points();
        for (Vec3& p : points) p = apply(map, p);
        l.set_points(points);
        for (int i = 0; i < 50; ++i) {
            const Vec3 x = random_inside(random, l);
            EXPECT_LE(distance(l.apply(x), apply(map, x)), 1e-13);
        }
    }
}

TEST(Lattice, JacobianAgreesWithDifferenceQuotients)
{
    std::mt19937_64 random(114);
    for (const bool spline : {false, true}) {
        const Lattice l = random_lattice(random, {3, 4, 2}, 0.4, spline);
        for (int i = 0; i < 20; ++i) {
            const Vec3 x =
                l.global(0.5 * l.local(random_inside(random, l)) + Vec3{{0.2, 0.2, 0.2}});
            const Columns3 j = l.jacobian(x);
            for (std::size_t a = 0; a < 3; ++a) {
                Vec3 h;
                h[a] = 1e-5;
                EXPECT_LE(distance((l.apply(x + h) - l.apply(x - h)) / 2e-5, j[a]), 1e-6);
                Vec3 direction;
                direction[a] = 1.0;
                const auto w = l.weights(x, direction);
                Vec3 sum = direction;
                for (std::size_t k = 0; k < w.size(); ++k) sum += w[k] * l.moves()[k];
                EXPECT_LE(distance(sum, j[a]), 1e-12);
            }
        }
    }
}

// What sticks out of the lattice joins C^k if the outer k + 1 layers stay.
TEST(Lattice, BorderIsAsSmoothAsItsFixedLayers)
{
    std::mt19937_64 random(115);
    for (int k = 0; k <= 2; ++k) {
        Lattice l = random_lattice(random, {7, 7, 7}, 1.0);
        EXPECT_EQ(l.border_continuity(), -1);
        l.keep_border(k);
        EXPECT_EQ(l.border_continuity(), k);
        // Distance from the identity near a face falls like the (k + 1)-th power.
        std::vector<double> away;
        for (const double depth : {4e-3, 2e-3, 1e-3}) {
            const Vec3 x = l.global({{0.4, 0.6, depth}});
            away.push_back(distance(l.apply(x), x));
        }
        EXPECT_NEAR(std::log2(away[1] / away[2]), k + 1.0, 0.1) << k;
        const Vec3 outside = l.global({{0.4, 0.6, -1e-9}});
        EXPECT_EQ(l.apply(outside), outside);
    }
}

TEST(Lattice, FindsFoldsAndProvesTheirAbsence)
{
    std::mt19937_64 random(116);
    int folded = 0, clear = 0;
    for (const bool spline : {false, true})
        for (int trial = 0; trial < 30; ++trial) {
            const double size = 0.05 + 0.06 * trial;
            const Lattice l = random_lattice(random, {2, 3, 2}, size, spline && trial < 12);
            const FoldReport r = l.folds(3000);
            const auto sampled = [&] {
                double least = 1e300;
                for (int i = 0; i < 300; ++i) {
                    const Columns3 j = l.jacobian(random_inside(random, l));
                    least = std::min(least, dot(j[0], cross(j[1], j[2])));
                }
                return least;
            };
            if (r.kind == FoldReport::Kind::Folded) {
                ++folded;
                const Columns3 j = l.jacobian(r.where);
                EXPECT_LT(dot(j[0], cross(j[1], j[2])), 0.0);
                EXPECT_NEAR(dot(j[0], cross(j[1], j[2])), r.determinant, 1e-9);
            } else if (r.kind == FoldReport::Kind::None) {
                ++clear;
                EXPECT_GT(r.determinant, 0.0);
                EXPECT_GE(sampled(), r.determinant);
            }
        }
    EXPECT_GT(folded, 5);
    EXPECT_GT(clear, 5);
}

TEST(Lattice, InverseUndoesTheDeformation)
{
    std::mt19937_64 random(117);
    for (const bool spline : {false, true})
        for (int trial = 0; trial < 40; ++trial) {
            Lattice l = random_lattice(random, {3, 3, 3}, 0.12, spline);
            if (l.folds(3000).kind != FoldReport::Kind::None) continue;
            const Vec3 x =
                l.global(0.9 * l.local(random_inside(random, l)) + Vec3{{0.05, 0.05, 0.05}});
            const Vec3 y = l.apply(x);
            const InversePoint back = l.inverse(y);
            ASSERT_TRUE(back.found) << trial;
            EXPECT_TRUE(back.certified) << trial;
            EXPECT_LE(distance(back.point, x), back.bound);
            EXPECT_LE(back.bound, 1e-8);
            EXPECT_LE(distance(l.apply(back.point), y), 1e-12);
        }
}

TEST(Lattice, InverseFindsItsWayInStrongBends)
{
    // A quarter of a turn: the point itself is a bad start.
    Lattice l({{0, -0.5, -0.5}}, {Vec3{{6, 0, 0}}, Vec3{{0, 1, 0}}, Vec3{{0, 0, 1}}}, {7, 1, 1});
    for (int i = 0; i <= 7; ++i)
        for (int j = 0; j <= 1; ++j)
            for (int k = 0; k <= 1; ++k) {
                const double angle = 1.5707963 * i / 7.0, r = 4.0 - (j - 0.5);
                l.set_point(i, j, k, {{r * std::sin(angle), 4.0 - r * std::cos(angle), k - 0.5}});
            }
    ASSERT_EQ(l.folds().kind, FoldReport::Kind::None);
    std::mt19937_64 random(118);
    for (int trial = 0; trial < 100; ++trial) {
        const Vec3 x = random_inside(random, l);
        const auto back = l.inverse(l.apply(x));
        ASSERT_TRUE(back.found);
        EXPECT_LE(distance(back.point, x), 1e-9);
    }
    const auto nowhere = l.inverse({{5.9, -0.4, 0.0}});
    EXPECT_FALSE(nowhere.found);
    const Vec3 far = {{100, 0, 0}};
    EXPECT_EQ(l.inverse(far).point, far);
    EXPECT_TRUE(l.inverse(far).found);
}

// A bar of 6 x 1 x 1 bent round an axis at distance `radius` from its middle.
Lattice bent_bar(double degrees, double radius, int n)
{
    Lattice l({{0, -0.5, -0.5}}, {Vec3{{6, 0, 0}}, Vec3{{0, 1, 0}}, Vec3{{0, 0, 1}}}, {n, 1, 1});
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= 1; ++j)
            for (int k = 0; k <= 1; ++k) {
                const double angle = degrees * 0.017453292519943295 * i / n, r = radius - (j - 0.5);
                l.set_point(i, j, k,
                            {{r * std::sin(angle), radius - r * std::cos(angle), k - 0.5}});
            }
    return l;
}

void expect_to_meet(const Lattice& l, const OneToOneReport& r)
{
    ASSERT_EQ(r.kind, OneToOneReport::Kind::No);
    const double apart = distance(r.points[0], r.points[1]);
    EXPECT_GT(apart, 5.0 * r.bound);
    EXPECT_LE(distance(l.apply(r.points[0]), l.apply(r.points[1])), 8.0 * l.rounding());
}

TEST(LatticeOneToOne, ShowsThatBendsDoNotMeet)
{
    const Box3 all{{{0, -0.5, -0.5}}, {{6, 0.5, 0.5}}};
    for (const double degrees : {30.0, 90.0, 180.0, 270.0, 330.0}) {
        SCOPED_TRACE(degrees);
        const Lattice l = bent_bar(degrees, 2.0, 12);
        ASSERT_EQ(l.folds().kind, FoldReport::Kind::None);
        EXPECT_EQ(l.one_to_one(all).kind, OneToOneReport::Kind::Yes);
    }
    // Its ends touch.
    expect_to_meet(bent_bar(360.0, 2.0, 12), bent_bar(360.0, 2.0, 12).one_to_one(all));
    // Once round and more: no fold, but the ends run into each other, of the bar and not of half.
    const Lattice round = bent_bar(560.0, 2.0, 24);
    ASSERT_EQ(round.folds().kind, FoldReport::Kind::None);
    expect_to_meet(round, round.one_to_one(all));
    EXPECT_EQ(round.one_to_one({{{0, -0.5, -0.5}}, {{3, 0.5, 0.5}}}).kind,
              OneToOneReport::Kind::Yes);
    EXPECT_EQ(bent_bar(330.0, 2.0, 12).one_to_one(all, 20).kind, OneToOneReport::Kind::Undecided);
}

TEST(LatticeOneToOne, AgreesWithTheInverse)
{
    std::mt19937_64 random(122);
    int yes = 0, no = 0;
    for (const bool spline : {false, true})
        for (int trial = 0; trial < 24; ++trial) {
            SCOPED_TRACE(trial);
            const Lattice l = random_lattice(random, {3, 2, 3}, 0.05 + 0.05 * trial, spline);
            Box3 all;
            for (int i = 0; i < 8; ++i)
                all.add(l.global({{double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1)}}));
            const OneToOneReport r = l.one_to_one(all, 20000);
            if (r.kind == OneToOneReport::Kind::Yes) {
                ++yes;
                EXPECT_NE(l.folds().kind, FoldReport::Kind::Folded);
                for (int i = 0; i < 20; ++i) {
                    const Vec3 x = random_inside(random, l);
                    const InversePoint back = l.inverse(l.apply(x));
                    ASSERT_TRUE(back.found);
                    EXPECT_LE(distance(back.point, x), 1e-9);
                }
            } else if (r.kind == OneToOneReport::Kind::No) {
                ++no;
                expect_to_meet(l, r);
            }
        }
    EXPECT_GE(yes, 8);
    EXPECT_GE(no, 20);
}

TEST(LatticeOneToOne, MirrorsAndFoldsElsewhereDoNotCount)
{
    Lattice l = Lattice::over(Box3{{}, {{1, 1, 1}}}, {3, 3, 3});
    std::vector<Vec3> points = l.points();
    for (Vec3& p : points) p[0] = -p[0];
    l.set_points(points);
    EXPECT_EQ(l.one_to_one({{}, {{1, 1, 1}}}).kind, OneToOneReport::Kind::Yes);

    Lattice folded = Lattice::over(Box3{{}, {{1, 1, 1}}}, {7, 2, 2});
    for (int j = 0; j <= 2; ++j)
        for (int k = 0; k <= 2; ++k)
            folded.set_point(7, j, k, folded.point(7, j, k) - Vec3{{0.6, 0, 0}});
    ASSERT_EQ(folded.folds().kind, FoldReport::Kind::Folded);
    expect_to_meet(folded, folded.one_to_one({{}, {{1, 1, 1}}}));
    EXPECT_EQ(folded.one_to_one({{}, {{0.5, 1, 1}}}).kind, OneToOneReport::Kind::Yes);
    // A flat box, a point, and none at all.
    EXPECT_EQ(folded.one_to_one({{{0.2, 0, 0}}, {{0.2, 1, 1}}}).kind, OneToOneReport::Kind::Yes);
    EXPECT_EQ(folded.one_to_one({{{0.2, 1, 1}}, {{0.2, 1, 1}}}).kind, OneToOneReport::Kind::Yes);
    EXPECT_EQ(folded.one_to_one({{{5, 5, 5}}, {{6, 6, 6}}}).kind, OneToOneReport::Kind::Yes);
}

// Products of coefficients would cost too much there.
TEST(LatticeOneToOne, GoesBySlopesAtHighDegrees)
{
    Lattice l = Lattice::over(Box3{{}, {{1, 1, 1}}}, {24, 24, 24});
    std::mt19937_64 random(123);
    l.set_moves(random_points(random, static_cast<int>(l.n_points()), 0.0005));
    const FoldReport r = l.folds();
    ASSERT_EQ(r.kind, FoldReport::Kind::None);
    for (int i = 0; i < 50; ++i) {
        const Columns3 j = l.jacobian(random_inside(random, l));
        EXPECT_GE(dot(j[0], cross(j[1], j[2])), r.determinant);
    }
    EXPECT_GT(r.determinant, 0.1);
}

TEST(Lattice, CurvesAndPatchesGoByTheirControlPoints)
{
    std::mt19937_64 random(119);
    const Lattice l = random_lattice(random, {3, 3, 3}, 0.3);
    std::vector<Vec3> points;
    for (int i = 0; i < 4; ++i) points.push_back(random_inside(random, l));
    const BezierCurve c = deformed(BezierCurve(points), l);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(c.points()[i], l.apply(points[i]));
    const IndexedMesh mesh = deformed(IndexedMesh{points, {{0, 1, 2}}}, l);
    EXPECT_EQ(mesh.vertices, c.points());
}

TEST(Lattice, RefusesBadArguments)
{
    EXPECT_THROW(Lattice({}, {Vec3{}, Vec3{}, Vec3{}}, {1, 1, 1}), InvalidInput);
    EXPECT_THROW(Lattice({}, kAxes, {0, 1, 1}), InvalidInput);
    EXPECT_THROW(Lattice({}, kAxes, {65, 1, 1}), InvalidInput);
    EXPECT_THROW(Lattice({}, {kAxes[0], kAxes[0], kAxes[2]}, {1, 1, 1}), InvalidInput);
    EXPECT_THROW(Lattice::bspline({}, kAxes, {3, 4, 4}), InvalidInput);
    EXPECT_THROW(Lattice::bspline({}, kAxes, {1 << 20, 1 << 20, 1 << 20}), InvalidInput);
    EXPECT_THROW(Lattice::over(Box3{}, {1, 1, 1}), InvalidInput);
    Lattice l({}, kAxes, {1, 1, 1});
    EXPECT_THROW(l.set_point(2, 0, 0, {}), InvalidInput);
    EXPECT_THROW(l.set_moves(std::vector<Vec3>(7)), InvalidInput);
    EXPECT_THROW(l.inverse({{std::nan(""), 0, 0}}), InvalidInput);
    // Not a number is nowhere, so it stays.
    EXPECT_TRUE(std::isnan(l.apply({{std::nan(""), 0, 0}})[0]));
}

TEST(Lattice, GivesTheSameBitsWithAnyVectorWidth)
{
    std::mt19937_64 random(121);
    for (const auto& degree : {std::array{3, 3, 3}, {7, 7, 7}, {1, 2, 5}}) {
        const Lattice l = random_lattice(random, degree, 0.5);
        std::vector<Vec3> x(101), wide(101), narrow(101);
        for (Vec3& p : x) p = random_vec(random, 3.0);
        l.apply(x, wide);
        bulk::force_narrow_vectors(true);
        l.apply(x, narrow);
        bulk::force_narrow_vectors(false);
        EXPECT_EQ(wide, narrow);
    }
}

}  // namespace
}  // namespace genus
