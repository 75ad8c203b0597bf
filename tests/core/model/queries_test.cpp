#include "genus/model/queries.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/model/random_trees.h"
#include "genus/base/error.h"
#include "genus/model/leaves.h"
#include "genus/model/ray_roots.h"

namespace genus {
namespace {

const double kInf = std::numeric_limits<double>::infinity();

Solid at(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

std::vector<double> parameters(const std::vector<SolidHit>& hits)
{
    std::vector<double> t;
    for (const SolidHit& hit : hits) t.push_back(hit.t);
    return t;
}

TEST(RayCast, FindsTheCrossingsOfASphere)
{
    const std::vector<SolidHit> hits = ray_cast(sphere(2), {{-5, 0, 0}}, {{1, 0, 0}});
    EXPECT_EQ(parameters(hits), (std::vector<double>{3, 7}));
    EXPECT_TRUE(hits[0].entering);
    EXPECT_FALSE(hits[1].entering);
    EXPECT_EQ(hits[0].normal, (Vec3{{-1, 0, 0}}));
    EXPECT_EQ(hits[1].normal, (Vec3{{1, 0, 0}}));
    EXPECT_EQ(parameters(ray_cast(sphere(2), {{0, 0, 0}}, {{0, 0, 2}})), std::vector<double>{1});
    EXPECT_TRUE(ray_cast(sphere(2), {{5, 0, 0}}, {{1, 0, 0}}).empty());
    EXPECT_TRUE(ray_cast(sphere(2), {{-5, 2, 0}}, {{1, 0, 0}}).empty());  // touches
    EXPECT_THROW(ray_cast(sphere(2), {{0, 0, 0}}, {{0, 0, 0}}), InvalidInput);
    EXPECT_THROW(ray_cast(sphere(2), {{kInf, 0, 0}}, {{1, 0, 0}}), InvalidInput);
}

TEST(RayCast, KeepsItsDigitsFromFarAway)
{
    const std::vector<SolidHit> hits = ray_cast(sphere(1), {{-1e9, 0.6, 0}}, {{1, 0, 0}});
    ASSERT_EQ(hits.size(), 2U);
    EXPECT_NEAR(hits[0].t, 1e9 - 0.8, 2e-7);  // half a unit in the last place of 1e9 is 6e-8
    EXPECT_NEAR(hits[1].t - hits[0].t, 1.6, 4e-7);
}

TEST(RayCast, HollowSolidHasAllCrossingsInOrder)
{
    const Solid bowl = subtract({sphere(3), sphere(2), at(cylinder(9, 0.5, 0.5, true), 0, 0, 0)});
    const std::vector<SolidHit> hits = ray_cast(bowl, {{-9, 0, 0}}, {{1, 0, 0}});
    EXPECT_EQ(parameters(hits), (std::vector<double>{6, 7, 11, 12}));
    EXPECT_EQ(hits[1].normal, (Vec3{{1, 0, 0}}));  // out of the wall, into the hollow
    EXPECT_TRUE(ray_cast(bowl, {{0, 0, -9}}, {{0, 0, 1}}).empty());
}

std::vector<std::int32_t> leaves(const std::vector<SolidHit>& hits)
{
    std::vector<std::int32_t> numbers;
    for (const SolidHit& hit : hits) numbers.push_back(hit.leaf);
    return numbers;
}

TEST(RayCast, TellsTheLeafInTheOrderOfTheTree)
{
    const Solid ball = sphere(3), bar = cylinder(9, 1, 1, true);
    // The bar comes twice, once across; empty parts, moves and colours do not count.
    const Solid tree =
        subtract({colored(unite({Solid(), at(ball, 0, 0, 1)}), {{1, 0, 0, 1}}), bar,
                  transformed(bar, rotation_y(90)), at(cube({{9, 9, 9}}), 2, -4, -4)});
    EXPECT_EQ(leaf_names(tree),
              (std::vector<std::string>{"sphere(r = 3)", "cylinder(h = 9, r = 1)",
                                        "cylinder(h = 9, r = 1)", "cube([9, 9, 9])"}));
    EXPECT_EQ(leaves(ray_cast(tree, {{-5, 0.1, 1.9}}, {{1, 0, 0}})),
              (std::vector<std::int32_t>{0, 1, 1, 3}));
    EXPECT_EQ(leaves(ray_cast(tree, {{-2, 0.1, -5}}, {{0, 0, 1}})),
              (std::vector<std::int32_t>{0, 2, 2, 0}));
    EXPECT_EQ(leaves(ray_cast(sphere(1), {{-5, 0, 0}}, {{1, 0, 0}})),
              (std::vector<std::int32_t>{0, 0}));
    // From far away, where the point itself has but seven digits.
    EXPECT_EQ(leaves(ray_cast(tree, {{-5e8, 0.1, 1.9}}, {{1, 0, 0}})),
              (std::vector<std::int32_t>{0, 1, 1, 3}));
}

TEST(RayCast, OfLeavesThatShareASurfaceTheOneThatIsThereCounts)
{
    // A pin fills the lower half of its hole, with the same wall; above it the wall is the hole's.
    const Solid part = unite({subtract({cube({{6, 6, 4}}, true), cylinder(9, 1, 1, true)}),
                              at(cylinder(2, 1, 1), 0, 0, -2)});
    EXPECT_EQ(leaves(ray_cast(part, {{-9, 0, 1}}, {{1, 0, 0}})),
              (std::vector<std::int32_t>{0, 1, 1, 0}));
    EXPECT_EQ(leaves(ray_cast(part, {{0.1, 0, 9}}, {{0, 0, -1}})),
              (std::vector<std::int32_t>{2, 2}));
    // Two bricks side by side under one plane.
    const Solid bricks = unite({cube({{1, 1, 1}}), at(cube({{1, 1, 1}}), 1, 0, 0)});
    EXPECT_EQ(leaves(ray_cast(bricks, {{1.5, 0.5, 9}}, {{0, 0, -1}})),
              (std::vector<std::int32_t>{1, 1}));
}

TEST(RayCast, TheLeafHasItsBorderWhereTheHitIs)
{
    RandomShapes random(93);
    int n_hits = 0;
    for (int trial = 0; trial < 20; ++trial) {
        SCOPED_TRACE(trial);
        const Solid tree = random_tree(random, 3);
        const std::vector<PlacedLeaf> all = leaves_of(tree);
        for (int ray = 0; ray < 20; ++ray) {
            const Vec3 from = random.point(6);
            for (const SolidHit& hit : ray_cast(tree, from, random.point(1.5) - from)) {
                ASSERT_GE(hit.leaf, 0);
                ASSERT_LT(hit.leaf, static_cast<std::int32_t>(all.size()));
                const PlacedLeaf& leaf = all[static_cast<std::size_t>(hit.leaf)];
                const CsgField field(transformed(leaf.leaf, leaf.map));
                const Vec3 g = field.gradient(hit.point);
                EXPECT_NEAR(field.value(hit.point), 0.0, 1e-9);
                EXPECT_NEAR(std::fabs(dot(g, hit.normal)), norm(g), 1e-6 * norm(g));
                ++n_hits;
            }
        }
    }
    EXPECT_GT(n_hits, 100);
}

TEST(RayCast, TellsTheLeafOfTreesWithoutAFormula)
{
    // A ball beside two tetrahedra in one polyhedron, which is not convex.
    PolygonMesh pair;
    for (const double x : {0.0, 2.0}) {
        const auto first = static_cast<std::int32_t>(pair.vertices.size());
        for (const Vec3& v : {Vec3{}, Vec3{{1, 0, 0}}, Vec3{{0, 1, 0}}, Vec3{{0, 0, 1}}})
            pair.vertices.push_back(v + Vec3{{x, 0, 0}});
        for (const Triangle& f : {Triangle{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
            pair.add_face(Triangle{first + f[0], first + f[1], first + f[2]});
    }
    const Solid tree = unite({at(sphere(1), 5, 0, 0), polyhedron(std::move(pair))});
    EXPECT_EQ(leaves(ray_cast(tree, {{-9, 0.3, 0.2}}, {{1, 0, 0}})),
              (std::vector<std::int32_t>{1, 1, 1, 1, 0, 0}));
}

TEST(RayCast, ParticipantsSharingASurfaceDoNotInterrupt)
{
    // Two blocks face to face, and a pin in its hole, are one body for the ray.
    const Solid blocks = unite({cube({{1, 1, 1}}), at(cube({{1, 1, 1}}), 1, 0, 0)});
    EXPECT_EQ(parameters(ray_cast(blocks, {{-1, 0.5, 0.5}}, {{1, 0, 0}})),
              (std::vector<double>{1, 3}));
    const Solid plate = cube({{10, 10, 2}}, true);
    const Solid filled =
        unite({subtract({plate, cylinder(9, 1, 1, true)}), cylinder(2, 1, 1, true)});
    EXPECT_EQ(parameters(ray_cast(filled, {{-7, 0, 0}}, {{1, 0, 0}})),
              (std::vector<double>{2, 12}));
}

TEST(RayCast, TorusHasUpToFourCrossings)
{
    const std::vector<double> t = parameters(ray_cast(torus(3, 1), {{-9, 0, 0}}, {{1, 0, 0}}));
    ASSERT_EQ(t.size(), 4U);
    const std::vector<double> expected{5, 7, 11, 13};
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(t[i], expected[i], 1e-14);
    EXPECT_TRUE(ray_cast(torus(3, 1), {{0, 0, -9}}, {{0, 0, 1}}).empty());
    EXPECT_EQ(ray_cast(torus(3, 1), {{3, 0, -9}}, {{0, 0, 1}}).size(), 2U);
}

TEST(RayCast, RootsLieOnTheSurfaceAndNoneIsMissed)
{
    RandomShapes random(61);
    for (int trial = 0; trial < 2000; ++trial) {
        SCOPED_TRACE(trial);
        const CsgField field(transformed(random_leaf(random, false), random.affine()));
        const Vec3 origin = random.point(20), aim = random.point(2) - origin;
        for (const Surface& surface : field.surfaces()) {
            const std::vector<double> roots = ray_roots(surface, origin, aim);
            for (double t : roots) {
                const Vec3 p = origin + t * aim;
                const double slope = norm(surface.gradient(p));
                EXPECT_LE(std::fabs(surface.value(p)), 1e-11 * slope + 1e-13);
            }
            // Signs alternate: an odd number of roots between samples of unlike sign.
            for (int i = 0; i < 200; ++i) {
                const double a = 0.01 * i, b = 0.01 * (i + 1);
                const double fa = surface.value(origin + a * aim);
                const double fb = surface.value(origin + b * aim);
                if (std::fmin(std::fabs(fa), std::fabs(fb)) < 1e-9) continue;
                int between = 0;
                for (double t : roots) between += a < t && t <= b;
                EXPECT_EQ(between % 2 == 1, (fa < 0.0) != (fb < 0.0));
            }
        }
    }
}

TEST(RayCast, AgreesWithMembershipAlongTheRay)
{
    RandomShapes random(62);
    std::size_t found = 0;
    for (int trial = 0; trial < 500; ++trial) {
        SCOPED_TRACE(trial);
        const Solid tree = random_tree(random, 1 + trial % 10);
        const Vec3 origin = random.point(4), aim = random.point(1.5) - origin;
        const std::vector<SolidHit> hits = ray_cast(tree, origin, aim);
        found += hits.size();
        for (std::size_t i = 0; i < hits.size(); ++i) {
            EXPECT_NEAR(norm(hits[i].normal), 1.0, 1e-12);
            EXPECT_EQ(hits[i].entering, dot(hits[i].normal, aim) < 0.0);
            if (i > 0) {
                EXPECT_NE(hits[i].entering, hits[i - 1].entering);
                EXPECT_GE(hits[i].t, hits[i - 1].t);
            }
        }
        MembershipOracle side;
        for (int sample = 0; sample < 100; ++sample) {
            const double t = random.in(0, 3);
            const double expected = side(tree, origin + t * aim);
            if (side.nearest < 1e-7) continue;
            std::size_t next = 0;
            while (next < hits.size() && hits[next].t < t) ++next;
            const bool inside =
                next < hits.size() ? !hits[next].entering : !hits.empty() && hits.back().entering;
            EXPECT_EQ(inside, expected < 0.0);
        }
    }
    EXPECT_GT(found, 300U);
}

TEST(Queries, ManyPointsAndRaysAtOnceGiveWhatOneDoes)
{
    const CsgField field(subtract({sphere(2), cylinder(5, 1, 0.5, true)}));
    RandomShapes random(63);
    std::vector<Vec3> points, aims;
    for (int i = 0; i < 5000; ++i) {
        points.push_back(random.point(3));
        aims.push_back(random.point());
    }
    const std::vector<char> inside = contains(field, points);
    const std::vector<double> f = values(field, points);
    const std::vector<Vec3> g = gradients(field, points);
    const auto hits = ray_cast(field, points, aims);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(inside[i] != 0, field.value(points[i]) <= 0.0);
        EXPECT_EQ(f[i], field.value(points[i]));
        EXPECT_EQ(g[i], field.gradient(points[i]));
        if (i % 100 == 0) {
            EXPECT_EQ(parameters(hits[i]), parameters(ray_cast(field, points[i], aims[i])));
        }
    }
    aims.pop_back();
    EXPECT_THROW(ray_cast(field, points, aims), InvalidInput);
}

std::string complaint(const Solid& solid)
{
    try {
        require_bounded(solid);
    } catch (const UnboundedSolid& error) {
        return error.what();
    }
    return "";
}

TEST(Bounded, NamesTheLeafThatReachesToInfinity)
{
    const Solid pipe = quadric(Quadric::cylinder(1));
    EXPECT_NE(complaint(half_space({{0, 0, 1}}, 5)).find("half_space([0, 0, 1], 5)"),
              std::string::npos);
    EXPECT_NE(complaint(unite({sphere(3), pipe})).find("quadric("), std::string::npos);
    EXPECT_NE(complaint(unite({sphere(3), pipe})).find("[0, 0, "), std::string::npos);
    EXPECT_NE(complaint(intersect({pipe, half_space({{0, 0, 1}}, 5)})).find("quadric("),
              std::string::npos);
    EXPECT_NE(complaint(subtract({half_space({{1, 0, 0}}, 0), sphere(1)})).find("half_space"),
              std::string::npos);
    // A slanted pipe that no wall ends; a wall along the pipe does not help.
    const Solid slanted = transformed(pipe, rotation({{30, 40, 50}}));
    EXPECT_NE(complaint(slanted).find("quadric("), std::string::npos);
    EXPECT_NE(complaint(transformed(intersect({pipe, half_space({{1, 0, 0}}, 0)}),
                                    rotation({{30, 40, 50}}))),
              "");
}

TEST(Bounded, FindsBoxesWhereTheTreeAloneShowsNone)
{
    RandomShapes random(64);
    const Solid pipe = quadric(Quadric::cylinder(1));
    const Quadric bowl = Quadric::from_polynomial({1, 2, 0, 0, 0, 0, 0, 0, -1, 0});
    for (int trial = 0; trial < 20; ++trial) {
        SCOPED_TRACE(trial);
        const Transform t = trial == 0 ? Transform{} : rotation(random.point(180));
        const std::vector<Solid> solids{
            intersect({pipe, half_space({{0, 0.3, 1}}, 5), half_space({{0.2, 0, -1}}, 5)}),
            intersect({half_space({{1, 1, 1}}, 1), half_space({{-1, 1, 1}}, 1),
                       half_space({{0, -1, 1}}, 1), half_space({{0, 0, -1}}, 1)}),
            subtract({pipe, half_space({{0, 0, 1}}, -3), half_space({{0, 0, -1}}, -3)}),
        };
        for (const Solid& solid : solids) {
            const Solid turned = transformed(solid, t);
            const Box3 box = require_bounded(turned);
            EXPECT_TRUE(box.bounded());
            const CsgField field(turned);
            for (int sample = 0; sample < 300; ++sample) {
                const Vec3 p = random.point(20);
                EXPECT_TRUE(field.value(p) > 0.0 || box.contains(p));
            }
        }
    }
    // A bowl opens without end, but one wall closes it.
    const Box3 box = require_bounded(intersect({quadric(bowl), half_space({{0, 0, 1}}, 4)}));
    EXPECT_TRUE(box.contains(Box3{{{-2, -1.4, 0}}, {{2, 1.4, 4}}}));
    EXPECT_NE(complaint(quadric(bowl)), "");
}

TEST(Bounded, TightBoxesAreTightAndNeverTooSmall)
{
    const auto expect_box = [](const Solid& solid, const Box3& exact, double tolerance) {
        const Box3 box = tight_bounds(solid, tolerance);
        EXPECT_TRUE(box.inflated(1e-13).contains(exact));
        EXPECT_TRUE(exact.inflated(tolerance + 1e-13).contains(box));
    };
    // A lens: the tree's box is the cube between the balls.
    const double h = std::sqrt(1.0 - 0.36);
    expect_box(intersect({at(sphere(1), -0.6, 0, 0), at(sphere(1), 0.6, 0, 0)}),
               {{{-0.4, -h, -h}}, {{0.4, h, h}}}, 1e-3);
    expect_box(subtract({cube({{4, 4, 4}}), at(cube({{5, 5, 5}}), 1, -0.5, -0.5)}),
               {{{0, 0, 0}}, {{1, 4, 4}}}, 1e-6);
    expect_box(intersect({quadric(Quadric::cone(0, 1)), half_space({{0, 0, 1}}, 2),
                          half_space({{0, 0, -1}}, 0)}),
               {{{-2, -2, 0}}, {{2, 2, 2}}}, 1e-3);
    EXPECT_TRUE(tight_bounds(intersect({sphere(1), at(sphere(1), 1.5, 1.5, 0)}), 1e-3).empty());
    EXPECT_THROW(tight_bounds(sphere(1), 0), InvalidInput);
}

}  // namespace
}  // namespace genus
