#include "genus/mesh/slice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/mesh/measure.h"

using namespace genus;

TEST(Slice, OfABoxIsItsGroundPlan)
{
    const IndexedMesh box = cases::box({{2, 3, 4}});
    for (const double z : {1e-9, 1.0, 2.5, 4.0}) {
        const Region region = slice(box, z);
        ASSERT_EQ(region.rings.size(), 1u);
        EXPECT_DOUBLE_EQ(area(region), 6);
    }
    // The lid belongs to it, the floor not, nor what is beyond.
    EXPECT_TRUE(slice(box, 0).empty());
    EXPECT_TRUE(slice(box, 4.5).empty());
    EXPECT_TRUE(slice(box, -1).empty());
    EXPECT_TRUE(slice({}, 1).empty());
}

TEST(Slice, OfASphereAndATorusAreCirclesAndRings)
{
    const IndexedMesh sphere = cases::octasphere(6);
    for (const double z : {-0.9, -0.3, 0.0, 0.5}) {
        EXPECT_NEAR(area(slice(sphere, z)), std::numbers::pi * (1 - z * z), 0.01);
    }
    const Region ring = slice(cases::torus(200, 100), 0.5);
    EXPECT_EQ(ring.rings.size(), 2u);
    const double outer = 2 + std::sqrt(0.75), inner = 2 - std::sqrt(0.75);
    EXPECT_NEAR(area(ring), std::numbers::pi * (outer * outer - inner * inner), 0.05);
}

TEST(Slice, AreasAddUpToTheVolume)
{
    // Cavalieri: the mean slice at random heights is volume over height.
    std::mt19937 random(12);
    const IndexedMesh mesh = cases::moved(cases::torus(24, 16), cases::random_rotation(random));
    const Box3 box = bounds(mesh);
    const double height = box.size()[2];
    double sum = 0;
    constexpr int kSlices = 400;
    for (int i = 0; i < kSlices; ++i)
        sum += area(slice(mesh, box.min[2] + height * (i + 0.5) / kSlices));
    EXPECT_NEAR(sum * height / kSlices, volume(mesh), 1e-3 * volume(mesh));
}

TEST(Slice, ThroughVerticesIsExact)
{
    // Every height of a vertex layer of an octahedron-like mesh.
    const IndexedMesh mesh = cases::octahedron();
    const Region middle = slice(mesh, 0);
    ASSERT_EQ(middle.rings.size(), 1u);
    EXPECT_EQ(middle.rings[0].size(), 4u);
    EXPECT_EQ(area(middle), 2);
    EXPECT_TRUE(slice(mesh, 1).empty());  // only a point of it is in the plane
}

TEST(Slice, KnowsCavitiesAndPartsInsideOut)
{
    const IndexedMesh shell = cases::together(
        cases::box({{4, 4, 4}}),
        cases::turned_inside_out(cases::moved(cases::box(), translation({{1, 1, 1}}))));
    EXPECT_DOUBLE_EQ(area(slice(shell, 1.5)), 15);
    EXPECT_DOUBLE_EQ(area(slice(cases::turned_inside_out(shell), 1.5)), 15);
    // Two that overlap count once.
    const IndexedMesh two =
        cases::together(cases::box(), cases::moved(cases::box(), translation({{0.5, 0, 0}})));
    EXPECT_DOUBLE_EQ(area(slice(two, 0.5)), 1.5);
}

TEST(Slice, RefusesOpenMeshesWhereTheyAreCut)
{
    IndexedMesh open = cases::box();
    std::erase_if(open.faces, [&](const Triangle& t) {
        return open.vertices[t[0]][0] == 1 && open.vertices[t[1]][0] == 1 &&
               open.vertices[t[2]][0] == 1;
    });
    EXPECT_THROW(slice(open, 0.5), InvalidInput);
    EXPECT_TRUE(slice(open, 2).empty());
    EXPECT_THROW(slice(cases::box(), std::nan("")), InvalidInput);
}

TEST(Project, IsTheShadow)
{
    EXPECT_DOUBLE_EQ(area(project(cases::box({{2, 3, 4}}))), 6);
    EXPECT_NEAR(area(project(cases::octasphere(4))), std::numbers::pi, 0.02);
    const Region ring = project(cases::torus(60, 30));
    EXPECT_EQ(ring.rings.size(), 2u);
    EXPECT_NEAR(area(ring), std::numbers::pi * (9 - 1), 0.2);
    EXPECT_TRUE(project({}).empty());
    // A box on its corner casts a hexagon of area sqrt(3).
    const IndexedMesh box = cases::moved(
        cases::box(),
        rotation(std::acos(1 / std::sqrt(3.0)) * 180 / std::numbers::pi, {{1, -1, 0}}));
    EXPECT_NEAR(area(project(box)), std::sqrt(3.0), 1e-9);
}
