#include "genus/mesh/indexed_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "cases/meshes.h"
#include "cases/polygons.h"
#include "genus/base/error.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"

using namespace genus;

namespace {

PolygonMesh one_face(std::vector<Vec3> points)
{
    PolygonMesh mesh;
    mesh.vertices = std::move(points);
    std::vector<std::int32_t> face(mesh.vertices.size());
    std::iota(face.begin(), face.end(), 0);
    mesh.add_face(face);
    return mesh;
}

double signed_area_along_z(const IndexedMesh& mesh)
{
    double sum = 0;
    for (const auto& [a, b, c] : mesh.faces)
        sum += cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a])[2];
    return sum / 2;
}

}  // namespace

TEST(IndexedMesh, BoundsHoldAllVertices)
{
    EXPECT_TRUE(bounds(IndexedMesh{}).empty());
    EXPECT_EQ(bounds(cases::box({{2, 3, 4}})), (Box3{{{0, 0, 0}}, {{2, 3, 4}}}));
    EXPECT_EQ(bounds(cases::box_polygons({{2, 3, 4}})).max, (Vec3{{2, 3, 4}}));
}

TEST(IndexedMesh, TrianglesGoThroughPolygonsUnchanged)
{
    const IndexedMesh mesh = cases::torus(9, 7);
    EXPECT_EQ(to_triangles(to_polygons(mesh)), mesh);
}

TEST(IndexedMesh, ConcaveFacesKeepTheirArea)
{
    // An L, turned to look every way: area 3, four triangles, none of them turned over.
    const std::vector<Vec3> ell{{{0, 0, 0}}, {{2, 0, 0}}, {{2, 1, 0}},
                                {{1, 1, 0}}, {{1, 2, 0}}, {{0, 2, 0}}};
    std::mt19937 random(1);
    for (int i = 0; i < 50; ++i) {
        SCOPED_TRACE(i);
        const Transform turn = i == 0 ? Transform{} : cases::random_rotation(random);
        std::vector<Vec3> points = ell;
        for (Vec3& p : points) p = apply(turn, p);
        const IndexedMesh mesh = to_triangles(one_face(points));
        ASSERT_EQ(mesh.n_faces(), 4u);
        EXPECT_NEAR(area(mesh), 3, 1e-12);
        EXPECT_NEAR(signed_area_along_z(cases::moved(mesh, inverse(turn))), 3, 1e-12);
    }
}

TEST(IndexedMesh, StarFacesOfManyPointsKeepTheirArea)
{
    std::mt19937 random(2);
    for (int i = 0; i < 200; ++i) {
        SCOPED_TRACE(i);
        const int n = 4 + static_cast<int>(random() % 60);
        std::vector<Vec3> points;
        double exact = 0;
        for (int k = 0; k < n; ++k) {
            const double angle = 2 * std::numbers::pi * k / n, r = cases::uniform(random, 0.1, 1);
            points.push_back({{r * std::cos(angle), r * std::sin(angle), 0}});
        }
        for (int k = 0; k < n; ++k) exact += cross(points[k], points[(k + 1) % n])[2] / 2;
        const IndexedMesh mesh = to_triangles(one_face(points));
        ASSERT_EQ(mesh.n_faces(), points.size() - 2);
        EXPECT_NEAR(area(mesh), exact, 1e-12);
    }
}

TEST(IndexedMesh, FlatCornersMakeNoFlatTriangles)
{
    // A triangle with a point on each side.
    const IndexedMesh mesh = to_triangles(
        one_face({{{0, 0, 0}}, {{1, 0, 0}}, {{2, 0, 0}}, {{1, 1, 0}}, {{0, 2, 0}}, {{0, 1, 0}}}));
    ASSERT_EQ(mesh.n_faces(), 4u);
    for (const auto& [a, b, c] : mesh.faces)
        EXPECT_GT(
            cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a])[2], 0);
}

TEST(IndexedMesh, RepeatedCornersKeepTheRestInShape)
{
    // The L with every point given twice: sides stay sides of triangles, area stays 3.
    std::vector<Vec3> points;
    for (const Vec3& p : {Vec3{{0, 0, 0}}, Vec3{{2, 0, 0}}, Vec3{{2, 1, 0}}, Vec3{{1, 1, 0}},
                          Vec3{{1, 2, 0}}, Vec3{{0, 2, 0}}})
        points.insert(points.end(), 2, p);
    for (std::size_t shift = 0; shift < 2; ++shift) {
        const IndexedMesh mesh = to_triangles(one_face(points));
        EXPECT_EQ(mesh.n_faces(), points.size() - 2);
        EXPECT_DOUBLE_EQ(area(mesh), 3);
        const Topology t = topology(mesh);
        EXPECT_EQ(t.boundary_edges, 12);
        EXPECT_EQ(t.euler, 1);
        std::rotate(points.begin(), points.begin() + 1, points.end());
    }
}

TEST(IndexedMesh, CrossedAndFlatFacesBecomeFans)
{
    EXPECT_EQ(
        to_triangles(one_face({{{0, 0, 0}}, {{1, 1, 0}}, {{1, 0, 0}}, {{0, 1, 0}}})).n_faces(), 2u);
    EXPECT_EQ(
        to_triangles(one_face({{{0, 0, 0}}, {{1, 1, 1}}, {{2, 2, 2}}, {{3, 3, 3}}})).n_faces(), 2u);
}

TEST(IndexedMesh, QuadsAreCutAlongTheShorterDiagonal)
{
    const IndexedMesh mesh =
        to_triangles(one_face({{{0, 0, 0}}, {{2, 0, 0}}, {{3, 1, 0}}, {{1, 1, 0}}}));
    // 1-3 is shorter than 0-2: both triangles hold 1 and 3.
    for (const Triangle& t : mesh.faces) {
        EXPECT_NE(std::find(t.begin(), t.end(), 1), t.end());
        EXPECT_NE(std::find(t.begin(), t.end(), 3), t.end());
    }
}

TEST(IndexedMesh, ClosedMeshesStayClosed)
{
    const IndexedMesh cube = cases::box({{1, 2, 3}});
    EXPECT_EQ(cube.n_faces(), 12u);
    EXPECT_DOUBLE_EQ(volume(cube), 6);
    EXPECT_TRUE(is_closed(cube) && is_oriented(cube));
}

TEST(IndexedMesh, DropsFacesWithoutThreeCorners)
{
    PolygonMesh mesh = cases::box_polygons();
    mesh.add_face(std::array<std::int32_t, 2>{0, 1});
    mesh.add_face({});
    EXPECT_EQ(to_triangles(mesh).n_faces(), 12u);
}

TEST(IndexedMesh, RefusesIndicesOutOfRange)
{
    PolygonMesh mesh = cases::box_polygons();
    mesh.corners[7] = 8;
    EXPECT_THROW(to_triangles(mesh), InvalidInput);
}

TEST(IndexedMesh, LargeConvexFacesAreCutInLinearTime)
{
    std::vector<Vec3> points;
    constexpr int kN = 200'000;
    for (int k = 0; k < kN; ++k) {
        const double angle = 2 * std::numbers::pi * k / kN;
        points.push_back({{std::cos(angle), std::sin(angle), 0}});
    }
    const IndexedMesh mesh = to_triangles(one_face(points));
    EXPECT_EQ(mesh.n_faces(), points.size() - 2);
    EXPECT_NEAR(area(mesh), std::numbers::pi, 1e-8);
}

TEST(IndexedMesh, LargeConcaveFacesAreCutFast)
{
    constexpr int kN = 60'000;
    std::vector<Vec3> points;
    double exact = 0;
    for (const Vec2& p : cases::star(kN)) points.push_back({{p[0], p[1], 7}});
    for (int k = 0; k < kN; ++k) exact += cross(points[k], points[(k + 1) % kN])[2] / 2;
    const IndexedMesh mesh = to_triangles(one_face(points));
    EXPECT_EQ(mesh.n_faces(), points.size() - 2);
    EXPECT_NEAR(signed_area_along_z(mesh), exact, 1e-9);
    EXPECT_NEAR(area(mesh), exact, 1e-9);
}
