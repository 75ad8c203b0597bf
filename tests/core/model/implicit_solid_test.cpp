#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>

#include "genus/base/error.h"
#include "genus/implicit/parse_expression.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/csg_field.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/queries.h"
#include "genus/model/solid.h"

namespace genus {
namespace {

constexpr double kPi = std::numbers::pi;

Box3 around(double half)
{
    return {{{-half, -half, -half}}, {{half, half, half}}};
}

Solid formula(const std::string& text, double half)
{
    return implicit(parse_expression(text), around(half));
}

MeshedSolid meshed(const Solid& solid, double tolerance, MeshMethod method = MeshMethod::Auto)
{
    MeshOptions options;
    options.tolerance = tolerance;
    options.method = method;
    MeshedSolid made = mesh_solid(solid, options);
    EXPECT_TRUE(validate(made.mesh).ok());
    EXPECT_LE(made.error.measured, made.error.bound);
    EXPECT_LE(made.error.bound, tolerance);
    return made;
}

TEST(ImplicitSolid, ABallFromItsFormulaIsProvenWithinTheTolerance)
{
    const MeshedSolid made = meshed(formula("x^2 + y^2 + z^2 - 1", 1.5), 1e-2);
    EXPECT_TRUE(made.error.certified);
    EXPECT_EQ(topology(made.mesh).euler, 2);
    for (const Vec3& v : made.mesh.vertices) EXPECT_NEAR(norm(v), 1.0, made.error.bound);
}

TEST(ImplicitSolid, MixesWithQuadrics)
{
    const Solid cut = subtract({formula("x^2 + y^2 + z^2 - 1", 1.5), cylinder(4, 0.4, 0.4, true)});
    const MeshedSolid made = meshed(cut, 2e-2);
    EXPECT_EQ(topology(made.mesh).genus, 1);
    const double h = std::sqrt(1.0 - 0.16);
    EXPECT_NEAR(volume(made.mesh), 4.0 / 3.0 * kPi * h * h * h, 4 * kPi * made.error.bound);
}

TEST(ImplicitSolid, IsMovedScaledAndMirrored)
{
    const Solid egg =
        transformed(formula("x^2 + y^2 + z^2 - 1", 1.5),
                    translation({{5, 0, 0}}) * rotation({{10, 20, 30}}) * scaling({{1, 2, -1}}));
    const CsgField field(egg);
    EXPECT_LT(field.value({{5, 0, 0}}), 0.0);
    EXPECT_GT(field.value({{0, 0, 0}}), 0.0);
    const MeshedSolid made = meshed(egg, 5e-2);
    EXPECT_NEAR(volume(made.mesh), 8.0 / 3.0 * kPi, 0.6);
}

TEST(ImplicitSolid, RaysAreOrdered)
{
    const Solid waves = formula("sin(3*x)", 2.0);
    const auto hits = ray_cast(waves, {{-3, 0.1, 0.2}}, {{1, 0, 0}});
    // Inside where sin(3x) <= 0: from -1.047 to 0, 1.047 to 2, and before -1.047 down to -2 not.
    ASSERT_EQ(hits.size(), 4u);
    const double expected[] = {-kPi / 3, 0.0, kPi / 3, 2.0};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(hits[i].point[0], expected[i], 1e-12);
        EXPECT_EQ(hits[i].entering, i % 2 == 0);
    }
}

// Volumes by symmetry, by Pappus' theorem or for balls; the mesh is within the bound of each.
TEST(ImplicitSolid, SmoothFunctionsAreProvenWithTheRightGenus)
{
    const struct {
        const char* text;
        double half, tolerance;
        int euler;
        double volume, area;  // about
        bool always = false;
    } cases[] = {
        // F(-p) = -F(p): half the box is inside.
        {"sin(x)*cos(y) + sin(y)*cos(z) + sin(z)*cos(x)", 1.7, 0.1, 4, 19.652, 45, true},
        {"sin(x)*cos(y) + sin(y)*cos(z) + sin(z)*cos(x)", 3.3, 0.1, 0, 143.748, 350},
        {"(sqrt(x^2 + y^2) - 2)^2 + z^2 - 0.25", 3, 0.05, 0, kPi * kPi, 40, true},
        {"(x^2 + y^2 + z^2 + 3.75)^2 - 16*(x^2 + y^2)", 3, 0.05, 0, kPi * kPi, 40},
        {"hypot(hypot(x, y) - 2, z) - 0.5", 3, 0.05, 0, kPi * kPi, 40},
        {"sqrt(x^2 + y^2 + z^2) - 1", 1.5, 0.02, 2, 4 * kPi / 3, 13, true},
        {"1 <= 1/(x^2 + y^2 + z^2)", 1.5, 0.02, 2, 4 * kPi / 3, 13, true},
        {"repeat(x, 1)^2 + y^2 + z^2 - 0.09", 1.45, 0.1, 6, 3 * 4 * kPi / 3 * 0.027, 3.5, true},
        {"repeat(x, 1)^2 + repeat(y, 1)^2 + repeat(z, 1)^2 - 0.09", 1.45, 0.1, 54,
         27 * 4 * kPi / 3 * 0.027, 31},
    };
    for (const auto& c : cases) {
        if (!c.always && !std::getenv("GENUS_LONG")) continue;
        SCOPED_TRACE(c.text);
        const MeshedSolid made = meshed(formula(c.text, c.half), c.tolerance);
        EXPECT_TRUE(made.error.certified);
        EXPECT_EQ(made.error.doubt, "");
        EXPECT_EQ(topology(made.mesh).euler, c.euler);
        EXPECT_NEAR(volume(made.mesh), c.volume, c.area * made.error.bound);
    }
}

TEST(ImplicitSolid, BlendsAreProvenAcrossTheBordersOfTheirBands)
{
    const std::string one = "sqrt((x - 0.7)^2 + y^2 + z^2) - 1";
    const std::string two = "sqrt((x + 0.7)^2 + y^2 + z^2) - 1";
    const MeshedSolid blend = meshed(formula("smin(" + one + ", " + two + ", 0.3)", 2), 0.05);
    const MeshedSolid crease = meshed(formula("min(" + one + ", " + two + ")", 2), 0.05);
    for (const MeshedSolid* made : {&blend, &crease}) {
        EXPECT_TRUE(made->error.certified);
        EXPECT_EQ(topology(made->mesh).euler, 2);
    }
    // Two balls less their lens, and a little more along the circle where they meet.
    const double lens = kPi * (4 + 1.4) * (2 - 1.4) * (2 - 1.4) / 12;
    EXPECT_NEAR(volume(crease.mesh), 8 * kPi / 3 - lens, 22 * crease.error.bound);
    EXPECT_GT(volume(blend.mesh), volume(crease.mesh));
    const MeshedSolid drops = meshed(
        formula("0.5 - exp(-((x - 0.8)^2 + y^2 + z^2)) - exp(-((x + 0.8)^2 + y^2 + z^2))", 2.5),
        0.05);
    EXPECT_TRUE(drops.error.certified);
    EXPECT_EQ(topology(drops.mesh).euler, 2);
}

// Minima and maxima in a formula are unions and intersections, with exact edges.
TEST(ImplicitSolid, EdgesOfAFormulaAreExact)
{
    const MeshedSolid box =
        meshed(formula("max(abs(x) - 1, abs(y) - 0.8, abs(z) - 0.6)", 1.5), 0.1);
    EXPECT_TRUE(box.error.certified);
    EXPECT_NEAR(volume(box.mesh), 8 * 0.48, 1e-12);
    const MeshedSolid plate = meshed(
        formula("max(abs(z) - 0.5, abs(x) - 1.4, abs(y) - 0.5, 0.3 - hypot(repeat(x, 1), y))", 2),
        0.1);
    EXPECT_TRUE(plate.error.certified);
    EXPECT_EQ(topology(plate.mesh).genus, 3);
    EXPECT_NEAR(volume(plate.mesh), 2.8 - 3 * kPi * 0.09, 17 * plate.error.bound);
    if (!std::getenv("GENUS_LONG")) return;
    const MeshedSolid sheet =
        meshed(formula("abs(cos(x) + cos(y) + cos(z)) - 0.5", 0.5 * kPi), 0.1);
    EXPECT_TRUE(sheet.error.certified);
}

// A jump or a pole is a border like any other, and exact where it is plane.
TEST(ImplicitSolid, JumpsAndPolesAreExactPlaces)
{
    const struct {
        const char* text;
        double volume;
        int euler;
    } planes[] = {
        {"1/x", 32, 2},
        {"1/x - 1", 48, 4},
        {"mod(x, 1) - 0.5", 32, 8},
        {"floor(x)", 48, 2},
        {"x/abs(x)", 32, 2},
        {"sqrt(x) - 1", 16, 2},
        {"log(x)", 16, 2},
        {"floor(x) + floor(y)", 52, 2},
        {"ceil(x)*y", 40, 2},
    };
    for (const auto& c : planes) {
        SCOPED_TRACE(c.text);
        const MeshedSolid made = meshed(formula(c.text, 2), 0.05);
        EXPECT_TRUE(made.error.certified);
        EXPECT_NEAR(volume(made.mesh), c.volume, 1e-9);
        EXPECT_EQ(topology(made.mesh).euler, c.euler);
    }
    // Wedges that touch along lines and in corners, three and more of them.
    const struct {
        const char* text;
        double volume;
        int wedges;
    } touching[] = {{"mod(x, 1) + mod(y, 1) - 1", 32, 16},
                    {"mod(x, 1) + mod(y, 1) + mod(z, 1) - 1", 64.0 / 6.0, 64}};
    for (const auto& c : touching) {
        SCOPED_TRACE(c.text);
        const MeshedSolid made = meshed(formula(c.text, 2), 0.05);
        EXPECT_TRUE(made.error.certified);
        EXPECT_NEAR(volume(made.mesh), c.volume, 1e-9);
        EXPECT_EQ(topology(made.mesh).euler, 2 * c.wedges);
    }
    // Two half balls of different size.
    const MeshedSolid step = meshed(formula("x^2 + y^2 + z^2 - 1 - 0.1*sign(x)", 1.5), 0.05);
    EXPECT_TRUE(step.error.certified);
    const double expected =
        2.0 / 3.0 * kPi * (std::pow(std::sqrt(1.1), 3) + std::pow(std::sqrt(0.9), 3));
    EXPECT_NEAR(volume(step.mesh), expected, 14 * step.error.bound);
}

// Planes of a jump that touch a ball from outside cut nothing off it, and leave nothing of it.
TEST(ImplicitSolid, JumpsThatTouchOtherSurfacesAreNoTrouble)
{
    const MeshedSolid slices =
        meshed(formula("max(mod(x, 1) - 0.5, x^2 + y^2 + z^2 - 1)", 2), 0.05);
    EXPECT_TRUE(slices.error.certified);
    EXPECT_EQ(topology(slices.mesh).euler, 4);
    // The halves of the ball on either side of x = 1/2.
    EXPECT_NEAR(volume(slices.mesh), 2.0 / 3.0 * kPi, 8 * kPi * slices.error.bound);
    const MeshedSolid drum = meshed(formula("round(x)^2 + y^2 + z^2 - 1", 2), 0.05);
    EXPECT_TRUE(drum.error.certified);
    EXPECT_EQ(topology(drum.mesh).euler, 2);
    EXPECT_NEAR(volume(drum.mesh), kPi, 4 * kPi * drum.error.bound);
}

// Of planes alone the exact boolean has all corners.
TEST(ImplicitSolid, PlanesAreMeshedExactly)
{
    const MeshedSolid diamond = meshed(formula("abs(x) + abs(y) + abs(z) - 1", 1.5), 0.1);
    EXPECT_EQ(diamond.method, "boolean");
    EXPECT_EQ(diamond.mesh.n_faces(), 8u);
    EXPECT_DOUBLE_EQ(volume(diamond.mesh), 4.0 / 3.0);
    const MeshedSolid moved =
        meshed(transformed(subtract({formula("abs(x) + abs(y) - 1", 1), cube({{1, 1, 1}})}),
                           translation({{8, 0, 0}})),
               0.1);
    EXPECT_EQ(moved.method, "boolean");
    EXPECT_DOUBLE_EQ(volume(moved.mesh), 4.0 - 0.5);
    // Corners that are no doubles are for the cells.
    const MeshedSolid slanted = meshed(formula("x/3 + y/7 + z/11 - 0.1", 1), 0.1);
    EXPECT_TRUE(slanted.error.certified);
    EXPECT_EQ(slanted.method, "cells");
}

// Poles without end, and jumps inside other functions: a mesh of plain marching cubes whose
// vertices are where the side changes, or an error that says where.
TEST(ImplicitSolid, WhatJumpsAndCannotBeCutIsMeasuredBySides)
{
    const MeshedSolid made = meshed(formula("exp(1/x) - 2", 2), 0.3);
    EXPECT_FALSE(made.error.certified);
    EXPECT_EQ(made.method, "mc");
    EXPECT_NEAR(volume(made.mesh), 32 + 16 * (2 - 1 / std::log(2.0)), 96 * made.error.bound);
    MeshOptions options;
    options.tolerance = 1e-3;
    try {
        mesh_solid(formula("exp(1/x) - 2", 2), options);
        FAIL();
    } catch (const ToleranceNotMet& error) {
        ASSERT_EQ(error.where().size(), 1u);
        EXPECT_TRUE(error.where()[0].min[0] < 0.0 && error.where()[0].max[0] > 0.0);
        EXPECT_NE(std::string(error.what()).find("without a zero"), std::string::npos);
    }
}

TEST(ImplicitSolid, WhatCannotBeProvenIsEstimated)
{
    // The function jumps at many places where it is zero; roots without a bounded slope at their
    // ends.
    const MeshedSolid jump =
        meshed(formula("sqrt(x^2 + y^2 + z^2) - 1 + 1e-4*floor(50*x)", 1.5), 0.1);
    EXPECT_EQ(topology(jump.mesh).euler, 2);
    EXPECT_FALSE(jump.error.certified);
    EXPECT_NE(jump.error.doubt, "");
    EXPECT_NEAR(volume(jump.mesh), 4.0 / 3.0 * kPi, 1.3);
    if (!std::getenv("GENUS_LONG")) return;
    const MeshedSolid star =
        meshed(formula("sqrt(abs(x)) + sqrt(abs(y)) + sqrt(abs(z)) - 1.2", 1.6), 0.05);
    EXPECT_EQ(topology(star.mesh).euler, 2);
    EXPECT_FALSE(star.error.certified);
}

TEST(ImplicitSolid, RefusesBadBounds)
{
    const Expression ball = parse_expression("x^2 + y^2 + z^2 - 1");
    EXPECT_THROW(implicit(ball, Box3{}), InvalidInput);
    EXPECT_THROW(implicit(ball, Box3::everything()), InvalidInput);
    EXPECT_TRUE(implicit(parse_expression("1"), around(1)).is_empty());
    // Zero is inside, also where it is so everywhere.
    for (const char* text : {"0", "-1", "x^2 + y^2 + z^2 - 4"})
        EXPECT_EQ(volume(meshed(formula(text, 1.0), 0.1).mesh), 8.0) << text;
    EXPECT_EQ(implicit(ball, around(2)), implicit(ball, around(2)));
    EXPECT_FALSE(implicit(ball, around(2)) == implicit(ball, around(3)));
}

}  // namespace
}  // namespace genus
