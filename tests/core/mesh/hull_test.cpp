#include "genus/mesh/hull.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/transform.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"

namespace genus {
namespace {

// Closed, genus 0, and no point outside any face.
void expect_hull_of(const PolygonMesh& hull, const std::vector<Vec3>& points)
{
    const IndexedMesh mesh = to_triangles(hull);
    EXPECT_TRUE(validate(mesh).findings.empty());
    for (const Triangle& f : mesh.faces)
        for (const Vec3& p : points)
            ASSERT_GE(orient3d(mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]], p),
                      0);
}

std::vector<Vec3> lattice(int n)
{
    std::vector<Vec3> points;
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            for (int z = 0; z < n; ++z) points.push_back({{double(x), double(y), double(z)}});
    return points;
}

TEST(ConvexHull3d, OfALatticeIsItsCubeWithSixSquares)
{
    auto points = lattice(6);
    std::shuffle(points.begin(), points.end(), std::mt19937(1));
    const PolygonMesh hull = convex_hull(points);
    EXPECT_EQ(hull.n_vertices(), 8u);
    ASSERT_EQ(hull.n_faces(), 6u);
    for (std::size_t f = 0; f < 6; ++f) EXPECT_EQ(hull.face(f).size(), 4u);
    expect_hull_of(hull, points);
    EXPECT_EQ(volume(to_triangles(hull)), 125.0);
}

TEST(ConvexHull3d, OfPointsOnASphereUsesThemAll)
{
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    std::vector<Vec3> points;
    for (int i = 0; i < 3000; ++i)
        points.push_back(normalized(Vec3{{normal(random), normal(random), normal(random)}}));
    const PolygonMesh hull = convex_hull(points);
    EXPECT_EQ(hull.n_vertices(), 3000u);
    EXPECT_EQ(hull.n_faces(), 2u * 3000 - 4);  // Euler, all triangles
    const double v = volume(to_triangles(hull)), ball = 4 * std::numbers::pi / 3;
    EXPECT_LT(v, ball);
    EXPECT_GT(v, 0.99 * ball);
}

TEST(ConvexHull3d, IsRightOnSmallLatticesFullOfCoplanarPoints)
{
    for (unsigned seed = 1; seed <= 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_int_distribution<int> coordinate(0, 2 + static_cast<int>(seed % 4));
        const auto number = [&] { return 0.1 * coordinate(random); };
        std::vector<Vec3> points;
        for (unsigned i = 0; i < 4 + seed % 60; ++i)
            points.push_back({{number(), number(), number()}});
        const PolygonMesh hull = convex_hull(points);
        expect_hull_of(hull, points);
        // The hull of its own vertices is itself, in any order of the points.
        std::vector<Vec3> turned(hull.vertices.rbegin(), hull.vertices.rend());
        const PolygonMesh again = convex_hull(turned);
        EXPECT_EQ(again.n_vertices(), hull.n_vertices());
        EXPECT_EQ(again.n_faces(), hull.n_faces());
    }
}

TEST(ConvexHull3d, OfFlatOrFewPointsIsEmpty)
{
    EXPECT_EQ(convex_hull({}).n_faces(), 0u);
    std::vector<Vec3> flat;
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j) flat.push_back({{double(i), double(j), 1.0 * i + 2.0 * j}});
    EXPECT_EQ(convex_hull(flat).n_faces(), 0u);
    const std::vector<Vec3> line{{{0, 0, 0}}, {{1, 1, 1}}, {{2, 2, 2}}, {{3, 3, 3}}, {{4, 4, 4}}};
    EXPECT_EQ(convex_hull(line).n_faces(), 0u);
    const std::vector<Vec3> same(9, Vec3{{1, 2, 3}});
    EXPECT_EQ(convex_hull(same).n_faces(), 0u);
}

TEST(ConvexHull3d, RefusesPointsThatAreNotFinite)
{
    const std::vector<Vec3> points{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, NAN}}};
    EXPECT_THROW(convex_hull(points), InvalidInput);
}

}  // namespace
}  // namespace genus
