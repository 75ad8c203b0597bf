#include "genus/volume/marching_cubes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/implicit/quadric.h"
#include "genus/implicit/torus.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/volume/cube_cases.h"

namespace genus {
namespace {

void expect_closed_manifold(const IndexedMesh& mesh)
{
    const Topology t = topology(mesh);
    EXPECT_TRUE(t.closed && t.oriented && t.manifold);
    EXPECT_TRUE(t.degenerate_faces.empty());
}

TEST(CubeCases, EveryCrossedEdgeIsOnOneLoop)
{
    for (int inside = 0; inside < 256; ++inside)
        for (int joined = 0; joined < 64; ++joined) {
            std::array<int, 12> visits{};
            for (const auto& loop : cube_cases().at(inside, joined).loops)
                for (const int e : loop.edges) ++visits[e];
            for (int e = 0; e < 12; ++e) {
                const bool crossed =
                    (inside >> kCubeEdges[e].from & 1) != (inside >> kCubeEdges[e].to & 1);
                ASSERT_EQ(visits[e], crossed ? 1 : 0) << inside << " " << joined << " edge " << e;
            }
        }
}

// Cells rotate: a pattern turned about an axis has its loops turned with it.
TEST(CubeCases, LoopLengthsDoNotChangeWhenTheCubeIsTurned)
{
    const auto turned = [](int inside) {  // a quarter turn about z: (x, y) to (y, 1 - x)
        int result = 0;
        for (int c = 0; c < 8; ++c) {
            const int x = c & 1, y = c >> 1 & 1;
            if ((inside >> c & 1) != 0) result |= 1 << (y + 2 * (1 - x) + (c & 4));
        }
        return result;
    };
    for (int inside = 0; inside < 256; ++inside) {
        std::multiset<std::size_t> before, after;
        for (const auto& loop : cube_cases().at(inside, 0).loops) before.insert(loop.edges.size());
        for (const auto& loop : cube_cases().at(turned(inside), 0).loops)
            after.insert(loop.edges.size());
        EXPECT_EQ(before, after) << inside;
    }
}

TEST(MarchingCubes, VolumeAndAreaOfABallConvergeWithTheSquareOfTheCell)
{
    const Quadric ball = Quadric::sphere(1.0);
    const Box3 box{{{-1.13, -1.21, -1.17}}, {{1.19, 1.11, 1.23}}};
    const double exact = 4 * std::numbers::pi / 3;
    double last = 0.0;
    for (const double h : {0.2, 0.1, 0.05}) {
        MarchingCubesOptions options;
        options.cell_size = h;
        const IndexedMesh mesh = marching_cubes(ball, box, options);
        expect_closed_manifold(mesh);
        EXPECT_EQ(topology(mesh).euler, 2);
        // Vertices lie on the surface itself.
        for (const Vec3& v : mesh.vertices) ASSERT_NEAR(norm(v), 1.0, 1e-15);
        const double error = exact - volume(mesh);
        EXPECT_GT(error, 0.0);  // inscribed
        if (last > 0.0) {
            EXPECT_NEAR(last / error, 4.0, 0.3);
        }
        last = error;
    }
}

TEST(MarchingCubes, ATorusHasGenusOne)
{
    MarchingCubesOptions options;
    options.cell_size = 0.2;
    const IndexedMesh mesh = marching_cubes(Torus(2, 0.7), {{{-3, -3, -1}}, {{3, 3, 1}}}, options);
    expect_closed_manifold(mesh);
    EXPECT_EQ(topology(mesh).genus, 1);
}

TEST(MarchingCubes, CapsWhatReachesTheBorder)
{
    MarchingCubesOptions options;
    options.cell_size = 0.25;
    const Box3 box{{{-1, -1, -1}}, {{1, 1, 1}}};
    const IndexedMesh half = marching_cubes(Quadric::half_space({{0, 0, 1}}, 0.3), box, options);
    expect_closed_manifold(half);
    EXPECT_NEAR(volume(half), 2 * 2 * 1.3, 1e-12);
    options.close_border = false;
    EXPECT_FALSE(
        topology(marching_cubes(Quadric::half_space({{0, 0, 1}}, 0.3), box, options)).closed);
}

TEST(MarchingCubes, GivesTheSameBitsOnAnyNumberOfThreads)
{
    const int before = thread_count();
    std::vector<IndexedMesh> meshes;
    for (const int threads : {1, 2, 8}) {
        set_thread_count(threads);
        meshes.push_back(marching_cubes(Torus(2, 0.7), {{{-3, -3, -1}}, {{3, 3, 1}}}));
    }
    set_thread_count(before);
    EXPECT_EQ(meshes[0], meshes[1]);
    EXPECT_EQ(meshes[0], meshes[2]);
}

TEST(MarchingCubes, FloatsAndDoublesAgreeOnIntegers)
{
    std::mt19937 random(5);
    std::uniform_int_distribution<int> number(-3, 3);
    const GridSize size{70, 5, 6};
    std::vector<double> values(70 * 5 * 6);
    for (double& v : values) v = number(random) + 0.5;
    const std::vector<float> narrow(values.begin(), values.end());
    EXPECT_EQ(marching_cubes(std::span<const double>(values), size, {}),
              marching_cubes(std::span<const float>(narrow), size, {}));
}

TEST(Grid, IsTrilinearAndDifferentiatesQuadraticsExactlyInside)
{
    const Quadric f({1, 2, -1, 0.5, -1, 3, 1, 2, -2, 4});
    const Box3 box{{{0, 0, 0}}, {{4, 4, 4}}};
    const Grid grid = sample(f, box, 0.5);
    for (const Vec3& p : {Vec3{{1, 1.5, 2}}, Vec3{{3, 3.5, 0.5}}}) {
        EXPECT_DOUBLE_EQ(grid.value(p), f.value(p));
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(grid.gradient(p)[i], f.gradient(p)[i], 1e-12);
    }
    // Half-way along an edge: the mean of its ends.
    const Vec3 middle{{1.25, 1, 1}};
    EXPECT_NEAR(grid.value(middle), 0.5 * (f.value({{1, 1, 1}}) + f.value({{1.5, 1, 1}})), 1e-12);
}

TEST(Grid, RefusesBadSizesAndNumbers)
{
    EXPECT_THROW(Grid({2, 2, 1}, std::vector<double>(4)), InvalidInput);
    EXPECT_THROW(Grid({2, 2, 2}, std::vector<double>(7)), InvalidInput);
    EXPECT_THROW(Grid({2, 2, 2}, std::vector<double>(8, NAN)), InvalidInput);
    EXPECT_THROW(sample(Quadric::sphere(1), Box3{}, 0.1), InvalidInput);
    EXPECT_THROW(sample(Quadric::sphere(1), {{{0, 0, 0}}, {{1, 1, 1}}}, 0.0), InvalidInput);
    EXPECT_THROW(sample(Quadric::sphere(1), {{{0, 0, 0}}, {{1, 1, 1}}}, 1e-9), InvalidInput);
}

}  // namespace
}  // namespace genus
