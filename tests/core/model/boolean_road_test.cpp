#include "genus/model/boolean_road.h"

#include <gtest/gtest.h>

#include "genus/base/error.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/mesh_solid.h"

namespace genus {
namespace {

Solid at(double x, double y, double z, const Solid& solid)
{
    return transformed(solid, translation({{x, y, z}}));
}

TEST(BooleanRoad, AFrameOfCubesIsExact)
{
    const Solid frame = subtract(
        {cube({{10, 10, 10}}), at(2, 2, -1, cube({{6, 6, 12}})), at(-1, 2, 2, cube({{12, 6, 6}}))});
    const MeshedSolid made = mesh_solid(frame);
    EXPECT_EQ(made.method, "boolean");
    EXPECT_TRUE(validate(made.mesh).ok());
    EXPECT_EQ(volume(made.mesh), 1000 - 2 * 360 + 216);
    EXPECT_EQ(topology(made.mesh).genus, 3);
    EXPECT_TRUE(made.error.certified);
    EXPECT_LE(made.error.measured, made.error.bound);
    EXPECT_LT(made.error.bound, 1e-13);
}

TEST(BooleanRoad, TwoHundredTouchingCubesAreOnePiece)
{
    std::vector<Solid> parts;
    for (int i = 0; i < 200; ++i) parts.push_back(at(0.1 * i, 0, 0, cube({{0.1, 0.1, 0.1}})));
    const MeshedSolid made = mesh_solid(unite(parts));
    const Topology t = topology(made.mesh);
    EXPECT_EQ(t.components.size(), 1u);
    EXPECT_EQ(t.genus, 0);
    EXPECT_NEAR(volume(made.mesh), 0.2, 1e-13);
}

TEST(BooleanRoad, MirrorImagesStayOutward)
{
    const Solid wedge = cylinder(3, 2, 1, false, 7);
    const Solid image = transformed(wedge, mirror({{1, 2, 0}}));
    EXPECT_NEAR(volume(mesh_solid(image).mesh), volume(mesh_solid(wedge).mesh), 1e-12);
}

TEST(BooleanRoad, FacetedBallLessItsBores)
{
    // The text language's sphere with three bores, $fn = 50.
    const Solid bore = cylinder(30, 4, 4, true, 50);
    const Solid ball = subtract({sphere(10, 50), bore, transformed(bore, rotation_x(90)),
                                 transformed(bore, rotation_y(90))});
    const MeshedSolid made = mesh_solid(ball);
    EXPECT_TRUE(validate(made.mesh).ok());
    EXPECT_EQ(topology(made.mesh).genus, 5);
}

TEST(BooleanRoad, PlanningDoesNotChangeTheSet)
{
    const Solid scene = subtract({unite({cube({{4, 4, 4}}), at(10, 0, 0, cube({{4, 4, 4}}))}),
                                  at(1, 1, 1, cube({{1, 1, 9}})), at(50, 0, 0, cube({{1, 1, 1}}))});
    MeshOptions unplanned;
    unplanned.plan = false;
    const MeshedSolid with = mesh_solid(scene), without = mesh_solid(scene, unplanned);
    EXPECT_EQ(volume(with.mesh), volume(without.mesh));
    EXPECT_EQ(topology(with.mesh).euler, topology(without.mesh).euler);
    EXPECT_FALSE(with.explanation.entries.empty());
}

// An L-shaped prism: not convex, so no function of planes.
Solid angle_profile()
{
    PolygonMesh mesh;
    const double xy[6][2] = {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}};
    for (const double z : {0.0, 3.0})
        for (const auto& p : xy) mesh.vertices.push_back({{p[0], p[1], z}});
    const std::int32_t bottom[] = {5, 4, 3, 2, 1, 0}, top[] = {6, 7, 8, 9, 10, 11};
    mesh.add_face(bottom);
    mesh.add_face(top);
    for (std::int32_t i = 0; i < 6; ++i) {
        const std::int32_t j = (i + 1) % 6;
        const std::int32_t wall[] = {i, j, j + 6, i + 6};
        mesh.add_face(wall);
    }
    return polyhedron(mesh);
}

TEST(BooleanRoad, RoundBoresGoThroughAnyPolyhedron)
{
    const Solid bored = subtract({angle_profile(), at(2.5, 0.5, -1, cylinder(5, 0.25, 0.25)),
                                  at(0.5, 2.5, -1, cylinder(5, 0.25, 0.25))});
    MeshOptions options;
    options.tolerance = 1e-3;
    const MeshedSolid made = mesh_solid(bored, options);
    EXPECT_EQ(made.method, "boolean");
    EXPECT_TRUE(validate(made.mesh).ok());
    EXPECT_EQ(topology(made.mesh).genus, 2);
    EXPECT_NEAR(volume(made.mesh), 21 - 2 * 3 * 0.0625 * 3.14159265358979, 1e-3 * 2 * 3 * 1.6);
    // The bores cross the walls at right angles: that is proven.
    EXPECT_TRUE(made.error.certified) << made.error.doubt;
    EXPECT_LE(made.error.bound, 1e-3);
    EXPECT_GE(made.error.bound, made.error.measured);
    EXPECT_GT(made.error.measured, 0.0);
}

TEST(BooleanRoad, UnboundedPartsAreCutOffAtTheSolid)
{
    const Solid part =
        intersect({angle_profile(), half_space({{0, 0, 1}}, 1.0), quadric(Quadric::cylinder(3.0))});
    MeshOptions options;
    options.tolerance = 1e-3;
    const MeshedSolid made = mesh_solid(part, options);
    EXPECT_TRUE(validate(made.mesh).ok());
    const Box3 box = bounds(made.mesh);
    EXPECT_NEAR(box.max[2], 1.0, 1e-12);
    EXPECT_NEAR(box.max[0], 3.0, 1e-3);
}

TEST(BooleanRoad, BadPolyhedraAreRefused)
{
    PolygonMesh open;
    open.vertices = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    for (const Triangle& f : {Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{1, 2, 3}})
        open.add_face(f);
    EXPECT_THROW(mesh_solid(polyhedron(open)), InvalidInput);
}

TEST(BooleanRoad, DisjointPartsIntersectToNothing)
{
    const MeshedSolid made =
        mesh_solid(intersect({cube({{1, 1, 1}}), at(5, 0, 0, cube({{1, 1, 1}}))}));
    EXPECT_EQ(made.mesh.n_faces(), 0u);
}

}  // namespace
}  // namespace genus
