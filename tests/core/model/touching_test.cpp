// Solids that touch themselves along lines and curves: meshed so that each wedge of matter keeps
// its own edge, at the same coordinates as the other's.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/mesh_solid.h"

namespace genus {
namespace {

constexpr double kPi = std::numbers::pi;

struct Form {
    std::size_t components;
    std::int64_t euler;
};

Measures expect_certified(const Solid& solid, double tolerance, const Form& form)
{
    MeshOptions options;
    options.tolerance = tolerance;
    const MeshedSolid made = mesh_solid(solid, options);
    EXPECT_TRUE(made.error.certified);
    EXPECT_LE(made.error.measured, made.error.bound);
    EXPECT_LE(made.error.bound, tolerance);
    const Validation validation = validate(made.mesh);
    EXPECT_TRUE(validation.ok()) << validation.findings[0].text;
    EXPECT_EQ(validation.topology.components.size(), form.components);
    EXPECT_EQ(validation.topology.euler, form.euler);
    return measure(made.mesh);
}

// x y <= 0 in a box: a quarter on either side of the z axis.
Solid two_quarters(double sign = 1.0)
{
    const Box3 box{Box3::filled(-1.0), Box3::filled(1.0)};
    return quadric(Quadric::from_polynomial({0, 0, 0, sign, 0, 0, 0, 0, 0, 0}), box);
}

TEST(Touching, PlanesThatCrossBoundTwoWedges)
{
    EXPECT_NEAR(expect_certified(two_quarters(), 0.05, {2, 4}).volume, 4.0, 1e-12);
    const Solid turned = transformed(two_quarters(), rotation({{20, 30, 40}}));
    EXPECT_NEAR(expect_certified(turned, 0.05, {2, 4}).volume, 4.0, 1e-12);
    const Solid rest = subtract({cube({{2, 2, 2}}, true), two_quarters()});
    EXPECT_NEAR(expect_certified(rest, 0.05, {2, 4}).volume, 4.0, 1e-12);
}

TEST(Touching, EdgesEndWhereTheSolidGoesOn)
{
    const double ball = 4.0 / 3.0 * kPi * 0.125;
    const double error = 0.04 * 4.0;  // bound times the area of both halves of the ball, about
    const Measures joined = expect_certified(unite({two_quarters(), sphere(0.5)}), 0.04, {1, 2});
    EXPECT_NEAR(joined.volume, 4.0 + ball / 2, error);
    const Measures bitten = expect_certified(subtract({two_quarters(), sphere(0.5)}), 0.04, {2, 4});
    EXPECT_NEAR(bitten.volume, 4.0 - ball / 2, error);
    const Measures cut = expect_certified(intersect({two_quarters(), sphere(0.5)}), 0.04, {2, 4});
    EXPECT_NEAR(cut.volume, ball / 2, error);
}

// The solid goes on round both ends of an edge that no cell cuts: once a mesh whose vertices there
// could not tell the two wedges apart.
TEST(Touching, AShortEdgeTouchesBetweenEndsThatDoNot)
{
    for (const double height : {0.3, 0.01, 0.001}) {
        SCOPED_TRACE(height);
        const Solid slab = cube({{2.0, 2.0, 1.0 - height}});
        const Solid above = transformed(slab, translation({{-1.0, -1.0, height}}));
        const Solid below = transformed(slab, translation({{-1.0, -1.0, -1.0}}));
        const Measures whole =
            expect_certified(unite({two_quarters(), above, below}), 0.05, {1, 0});
        EXPECT_NEAR(whole.volume, 8.0 - 4.0 * height, 1e-12);
    }
}

TEST(Touching, OctantsMeetInThreeAxesAndOnePoint)
{
    const Solid above = half_space({{0, 0, -1}}, 0.0), below = half_space({{0, 0, 1}}, 0.0);
    const Solid four =
        unite({intersect({two_quarters(), above}), intersect({two_quarters(-1.0), below})});
    EXPECT_NEAR(expect_certified(four, 0.05, {4, 8}).volume, 4.0, 1e-12);
}

TEST(Touching, WhatOneOfTwoBallsHoldsTouchesAlongACircle)
{
    const Solid a = transformed(sphere(1.0), translation({{-0.4, 0, 0}}));
    const Solid b = transformed(sphere(1.0), translation({{0.4, 0, 0}}));
    const Solid either = unite({subtract({a, b}), subtract({b, a})});
    const double cap = 0.6, lens = 2.0 * kPi * cap * cap * (3.0 - cap) / 3.0;
    const double volume = 2.0 * (4.0 / 3.0 * kPi - lens);
    for (const double tolerance : {0.05, 0.01}) {
        const Measures measures = expect_certified(either, tolerance, {2, 4});
        EXPECT_NEAR(measures.volume, volume, tolerance * measures.area);
    }
}

}  // namespace
}  // namespace genus
