#include "genus/model/quantities.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <numbers>

#include "core/model/random_trees.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/model/local_form.h"
#include "genus/model/queries.h"

namespace genus {
namespace {

using std::numbers::pi;

Solid at(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

struct ClosedForm {
    const char* name;
    Solid solid;
    double volume, area;
};

// The torus of radii 2 and 1/2 less the ball of radius 2, by Pappus from the first moments of what
// the tube's circle has in common with the ball's, two segments with the chord x = 31/16, and of
// the arcs that bound the rest.
ClosedForm torus_less_ball()
{
    const double r = 0.5, d = 2.0, chord = 31.0 / 16, u = d - chord;
    const double small = r * r * std::acos(u / r) - u * std::sqrt(r * r - u * u);
    const double common = 2.0 / 3 * std::pow(d * d - chord * chord, 1.5) + d * small -
                          2.0 / 3 * std::pow(r * r - u * u, 1.5);
    const double half_angle = std::acos(-u / r), half_chord = std::sqrt(r * r - u * u);
    const double outer = 2 * r * (d * half_angle + half_chord), inner = 2 * d * half_chord;
    return {"torus less ball", subtract({torus(d, r), sphere(d)}),
            2 * pi * (d * pi * r * r - common), 2 * pi * (outer + inner)};
}

std::vector<ClosedForm> closed_forms()
{
    const Solid pipe = cylinder(4, 1, 1, true);
    const Solid along_x = transformed(pipe, rotation_y(90)),
                along_y = transformed(pipe, rotation_x(90));
    const double cap = pi * 0.25 * (3.0 - 0.5) / 3.0;  // height 1/2 of the unit ball
    return {
        {"ball", sphere(1), 4 * pi / 3, 4 * pi},
        {"cylinder", pipe, 4 * pi, 10 * pi},
        {"cone", cylinder(1, 1, 0), pi / 3, pi * (1 + std::sqrt(2.0))},
        {"two cylinders", intersect({pipe, along_x}), 16.0 / 3, 16},
        {"three cylinders", intersect({pipe, along_x, along_y}), 8 * (2 - std::sqrt(2.0)),
         24 * (2 - std::sqrt(2.0))},
        {"cap", intersect({sphere(1), half_space({{0, 0, -1}}, -0.5)}), cap, pi + 0.75 * pi},
        {"lens", intersect({sphere(1), at(sphere(1), 1, 0, 0)}), 2 * cap, 2 * pi},
        {"Viviani", intersect({sphere(1), at(cylinder(4, 0.5, 0.5, true), 0.5, 0, 0)}),
         2 * pi / 3 - 8.0 / 9, 2 * pi},
        {"bored ball", subtract({sphere(5), cylinder(20, 3, 3, true)}), 4 * pi / 3 * 64, 128 * pi},
        {"cone through ball", intersect({sphere(1), cylinder(2, 0, 2)}),
         2 * pi / 3 * (1 - std::sqrt(0.5)), 2 * pi * (1 - std::sqrt(0.5)) + pi * std::sqrt(0.5)},
        {"torus", torus(2, 0.5), pi * pi, 4 * pi * pi},
        torus_less_ball(),
        {"turned brick",
         transformed(intersect({cube({{1, 2, 3}}), sphere(9)}), rotation(Vec3{{10, 20, 30}})), 6,
         22},
    };
}

void expect_within(const BoundedValue& found, double exact, double relative)
{
    EXPECT_TRUE(found.certified);
    EXPECT_LE(found.bound, relative * exact);
    EXPECT_LE(std::fabs(found.value - exact), found.bound + 2e-16 * exact);
}

// All of them to ten digits with GENUS_LONG, else the quick ones.
TEST(Quantities, ClosedFormsLieWithinTheBounds)
{
    const bool all = std::getenv("GENUS_LONG") != nullptr;
    for (const ClosedForm& form : closed_forms()) {
        const std::string name = form.name;
        const bool quick = name == "cap" || name == "turned brick";
        if (!all && !quick) continue;
        if (all) std::cerr << name << "\n";
        SCOPED_TRACE(name);
        QuantityOptions options;
        options.relative = 1e-10;
        expect_within(volume(form.solid, options), form.volume, 1e-10);
        expect_within(area(form.solid, options), form.area, 1e-10);
    }
}

// F in a small cell on a torus, where s^2 and t agree in all but their last digits.
TEST(Quantities, TheQuarticOfATorusKeepsItsDigitsInSmallCells)
{
    const CsgField field(torus(2, 0.5));
    const Frame frame{{}, {{{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}}}};
    const FramedSurface framed(field.surfaces()[0], frame);
    RandomShapes random(74);
    for (const double half : {0x1p-5, 0x1p-12, 0x1p-20, 0x1p-28}) {
        const Vec3 center = Torus(2, 0.5).point(random.point(3)[0], random.point(3)[1]);
        const LocalForm form(framed, center, half);
        const double size = norm(form.gradient({}));
        EXPECT_LE(form.slack(1.0), 1e-13 * size) << half;
        for (int i = 0; i < 20; ++i) {
            const Vec3 e = random.point(1);
            std::array<long double, 3> p;
            for (int k = 0; k < 3; ++k) p[k] = center[k] + static_cast<long double>(half) * e[k];
            const long double flat = p[0] * p[0] + p[1] * p[1];
            const long double s = flat + p[2] * p[2] + 3.75L;
            const double exact = static_cast<double>(s * s - 16.0L * flat);
            const double rounding = 1e-16;  // of the long doubles
            EXPECT_NEAR(form.value(e), exact, form.slack(1.0) + rounding);
            EXPECT_NEAR(form.along(1, e).value(e[1]), form.value(e), 2.0 * form.slack(1.0));
        }
    }
}

TEST(Quantities, ToleranceIsInModelUnitsAndMovesDoNotMatter)
{
    RandomShapes random(71);
    const Solid lens = intersect({sphere(1), at(sphere(1), 1, 0, 0)});
    QuantityOptions options;
    options.tolerance = 1e-3;
    for (int trial = 0; trial < 1; ++trial) {
        SCOPED_TRACE(trial);
        const Transform map = translation(random.point(100)) * random.affine(3.0, 1.0);
        const BoundedValue v = volume(transformed(lens, map), options);
        EXPECT_LE(v.bound, 1e-3);
        EXPECT_NEAR(v.value, 5 * pi / 12 * std::fabs(determinant(map)), v.bound + 1e-12);
    }
}

TEST(Quantities, VolumesOfPartsAddUp)
{
    // |A| = |A - B| + |A & B| for random trees: each side within its own bound.
    RandomShapes random(72);
    QuantityOptions options;
    options.tolerance = 0.3;
    for (int trial = 0; trial < (std::getenv("GENUS_LONG") ? 200 : 2); ++trial) {
        SCOPED_TRACE(trial);
        const Solid a = random_tree(random, 2), b = random_tree(random, 2);
        const BoundedValue whole = volume(a, options), less = volume(subtract({a, b}), options),
                           both = volume(intersect({a, b}), options);
        EXPECT_LE(std::fabs(whole.value - less.value - both.value),
                  whole.bound + less.bound + both.bound);
    }
}

TEST(Quantities, WallsBetweenPartsHaveNoArea)
{
    // A pin in its hole is one plate; so are two bricks side by side.
    const Solid hole = cylinder(9, 1, 1, true), plate = cube({{10, 10, 2}}, true);
    const Solid filled =
        intersect({unite({subtract({plate, hole}), cylinder(2, 1, 1, true)}), sphere(50)});
    QuantityOptions options;
    options.relative = 1e-6;
    expect_within(area(filled, options), 280, 1e-6);
    expect_within(volume(filled, options), 200, 1e-6);
}

TEST(Quantities, PolyhedraAreMeasuredOnTheirExactMesh)
{
    const Solid notch = subtract({cube({{3, 3, 3}}), cube({{2, 2, 2}})});
    expect_within(volume(notch), 19, 1e-6);
    expect_within(area(notch), 54, 1e-6);
    EXPECT_EQ(volume(Solid()).value, 0.0);
    EXPECT_EQ(volume(Solid()).bound, 0.0);
}

TEST(Quantities, PairsOfPlanesAreHalfSpaces)
{
    // Half of the cube, whichever half; the line where the planes cross is no obstacle.
    RandomShapes random(73);
    for (const double sign : {1.0, -1.0}) {
        const Quadric pair = Quadric::from_polynomial({sign, -sign, 0, 0, 0, 0, 0, 0, 0, 0});
        const Solid wedges = quadric(pair, Box3{{{-1, -1, -1}}, {{1, 1, 1}}});
        expect_within(volume(wedges), 4.0, 1e-6);
        const Transform map = random.affine();
        const CsgField field(transformed(wedges, map));
        for (int i = 0; i < 200; ++i) {
            const Vec3 p = random.point(1);
            if (std::fabs(pair.value(p)) < 1e-9) continue;
            EXPECT_EQ(field.value(apply(map, p)) <= 0.0, pair.value(p) <= 0.0);
        }
    }
}

TEST(Quantities, RefusesWhatItCannotDo)
{
    QuantityOptions options;
    options.tolerance = 0.0;
    EXPECT_THROW(volume(sphere(1), options), InvalidInput);
    options.tolerance = std::nan("");
    EXPECT_THROW(area(sphere(1), options), InvalidInput);
    options.tolerance = 1e-30;
    options.max_cells = 20'000;
    EXPECT_THROW(volume(sphere(1), options), ToleranceNotMet);
    EXPECT_THROW(volume(half_space({{0, 0, 1}}, 0)), UnboundedSolid);
}

TEST(Quantities, SameBitsOnAnyNumberOfThreads)
{
    const Solid solid = cylinder(2, 1, 0.5, true);
    QuantityOptions options;
    options.relative = 1e-2;
    const int before = thread_count();
    set_thread_count(1);
    const BoundedValue one = volume(solid, options);
    set_thread_count(3);
    const BoundedValue three = volume(solid, options);
    set_thread_count(before);
    EXPECT_EQ(one.value, three.value);
    EXPECT_EQ(one.bound, three.bound);
}

}  // namespace
}  // namespace genus
