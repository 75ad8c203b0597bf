#include "genus/model/nearest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "core/model/random_quadrics.h"
#include "genus/base/error.h"
#include "genus/model/queries.h"

namespace genus {
namespace {

Solid at(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

SurfacePoint one(const Solid& solid, const Vec3& p)
{
    return nearest_points(solid, std::vector<Vec3>{p})[0];
}

int n_surfaces(const SurfacePoint& found)
{
    int n = 0;
    for (const std::int32_t s : found.surfaces) n += s >= 0;
    return n;
}

TEST(Nearest, FacesEdgesAndCornersOfABlock)
{
    const Solid block = cube({{2, 2, 2}}, true);
    const SurfacePoint face = one(block, {{0.2, 0.3, 3}}), edge = one(block, {{0.2, 2, 3}}),
                       corner = one(block, {{4, 2, 3}}), inside = one(block, {{0.2, 0.3, 0.9}});
    EXPECT_NEAR(distance(face.point, {{0.2, 0.3, 1}}), 0.0, 1e-14);
    EXPECT_NEAR(distance(edge.point, {{0.2, 1, 1}}), 0.0, 1e-14);
    EXPECT_NEAR(distance(corner.point, {{1, 1, 1}}), 0.0, 1e-14);
    EXPECT_NEAR(distance(inside.point, {{0.2, 0.3, 1}}), 0.0, 1e-14);
    EXPECT_EQ(n_surfaces(face), 1);
    EXPECT_EQ(n_surfaces(edge), 2);
    EXPECT_EQ(n_surfaces(corner), 3);
    EXPECT_NEAR(corner.distance, std::sqrt(14.0), 1e-14);
    for (const SurfacePoint& found : {face, edge, corner, inside}) EXPECT_LE(found.bound, 1e-9);
}

TEST(Nearest, EdgesAndCornersOfAnyKindAreProven)
{
    // Where faces meet outwards and inwards, flat and curved.
    const Solid corner = subtract({cube({{4, 4, 4}}, true), cube({{4, 4, 4}})});
    const Solid cap = intersect({sphere(2), half_space({{0, 0, -1}}, -1.0)});
    const SurfacePoint reflex = one(corner, {{-0.1, -0.2, -0.5}}), edge = one(corner, {{3, 3, -1}}),
                       rim = one(cap, {{3, 0, 0.5}});
    EXPECT_NEAR(reflex.distance, std::sqrt(0.3), 1e-12);
    EXPECT_NEAR(edge.distance, std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(distance(rim.point, {{std::sqrt(3.0), 0, 1}}), 0.0, 1e-12);
    for (const SurfacePoint& found : {reflex, edge, rim}) EXPECT_LE(found.bound, 1e-8);
}

TEST(Nearest, PointsAtTheSameDistanceFromAllOfAFace)
{
    const SurfacePoint middle = one(sphere(2), {});
    EXPECT_NEAR(middle.distance, 2.0, 1e-12);
    EXPECT_NEAR(norm(middle.point), 2.0, 1e-12);
    EXPECT_LE(middle.bound, 1e-8);
    EXPECT_NEAR(one(cylinder(9, 1, 1, true), {{0, 0, 1}}).distance, 1.0, 1e-12);
    EXPECT_NEAR(one(torus(3, 1), {{3, 0, 0}}).distance, 1.0, 1e-12);
    EXPECT_NEAR(one(torus(3, 1), {{0, 0, 0}}).distance, 2.0, 1e-12);
}

TEST(Nearest, TrimmedFacesEndAtTheirEdges)
{
    // A ball with a bore: above the bore the rim is nearest, not the ball that was there.
    const Solid bored = subtract({sphere(5), cylinder(20, 3, 3, true)});
    const SurfacePoint rim = one(bored, {{0.1, 0, 6}});
    EXPECT_NEAR(distance(rim.point, {{3, 0, 4}}), 0.0, 1e-12);
    EXPECT_EQ(n_surfaces(rim), 2);
    const SurfacePoint wall = one(bored, {{0.5, 0, 0}});
    EXPECT_NEAR(distance(wall.point, {{3, 0, 0}}), 0.0, 1e-12);
}

TEST(Nearest, NoPointOfTheSurfaceIsNearer)
{
    // Hits of random rays lie on the surface: none may be nearer than what was found, and what was
    // found lies on the border.
    const int n = std::getenv("GENUS_LONG") ? 300 : 12;
    RandomShapes random(81);
    for (int trial = 0; trial < n; ++trial) {
        SCOPED_TRACE(trial);
        const Solid tree = random_quadric_tree(random, 1 + trial % 5);
        const CsgField field(tree);
        std::vector<Vec3> on;
        for (int ray = 0; ray < 300; ++ray) {
            const Vec3 from = random.point(3);
            for (const SolidHit& hit : ray_cast(field, from, random.point(1.5) - from))
                on.push_back(hit.point);
        }
        if (on.empty()) continue;
        std::vector<Vec3> points;
        for (int i = 0; i < 4; ++i) points.push_back(random.point(2));
        const std::vector<SurfacePoint> found = nearest_points(tree, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_NEAR(distance(found[i].point, points[i]), found[i].distance, 1e-12);
            for (const Vec3& p : on)
                EXPECT_GE(distance(p, points[i]), found[i].distance - found[i].bound - 1e-12);
            // Both sides are within a step, unless it is the tip of something thin.
            bool in = false, out = false;
            for (int k = 0; k < 200 && !(in && out); ++k)
                (field.value(found[i].point + random.point(1e-5)) <= 0.0 ? in : out) = true;
            EXPECT_TRUE((in && out) || n_surfaces(found[i]) > 1);
            EXPECT_NEAR(field.value(found[i].point), 0.0, 1e-9);
        }
    }
}

TEST(Nearest, RefusesWhatHasNoSurface)
{
    EXPECT_THROW(one(Solid(), {}), InvalidInput);
    EXPECT_THROW(one(sphere(1), {{std::nan(""), 0, 0}}), InvalidInput);
    EXPECT_THROW(one(half_space({{0, 0, 1}}, 0), {}), UnboundedSolid);
    EXPECT_THROW(one(intersect({sphere(1), at(sphere(1), 3, 0, 0)}), {}), InvalidInput);
}

}  // namespace
}  // namespace genus
