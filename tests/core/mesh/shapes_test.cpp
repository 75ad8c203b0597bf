#include "genus/mesh/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/rings.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"

using namespace genus;

TEST(Shapes, IcosphereIsRegularAndTendsToTheSphere)
{
    double last_error = 1;
    for (const std::int32_t parts : {1, 2, 4, 8, 16, 32}) {
        SCOPED_TRACE(parts);
        const IndexedMesh mesh = icosphere(parts, 2.0);
        EXPECT_EQ(mesh.n_faces(), 20u * parts * parts);
        EXPECT_EQ(mesh.n_vertices(), 10u * parts * parts + 2);
        for (const Vec3& p : mesh.vertices) EXPECT_NEAR(norm(p), 2, 1e-15 * 4);
        const Topology t = topology(mesh);
        EXPECT_TRUE(t.closed && t.manifold && t.oriented);
        EXPECT_EQ(t.euler, 2);
        EXPECT_EQ(t.valences[5], 12);
        EXPECT_EQ(t.valences[6], t.vertices - 12);
        const double error = 1 - volume(mesh) / (4.0 / 3 * std::numbers::pi * 8);
        EXPECT_GT(error, 0);
        if (parts > 4) {
            EXPECT_NEAR(last_error / error, 4, 0.2);  // quadratic
        }
        last_error = error;
    }
    EXPECT_TRUE(validate(icosphere(5)).ok());
    EXPECT_THROW(icosphere(0), InvalidInput);
    EXPECT_THROW(icosphere(3, -1.0), InvalidInput);
    EXPECT_THROW(icosphere(5001), InvalidInput);
}

TEST(Shapes, GridPrismAndTorusMeasureWhatTheyShould)
{
    const PolygonMesh sheet = grid_mesh(7, 4, 3.5, 2.0);
    EXPECT_EQ(sheet.n_faces(), 28u);
    EXPECT_EQ(sheet.vertices.back(), (Vec3{{3.5, 2, 0}}));
    EXPECT_EQ(area(to_triangles(sheet)), 7);
    EXPECT_EQ(topology(sheet).boundary_loops, 1);
    EXPECT_EQ(topology(sheet).euler, 1);

    for (const std::int32_t n : {3, 4, 7, 100}) {
        const PolygonMesh mesh = prism(n, 3, 2, n % 2 == 0);
        const Topology t = topology(mesh);
        EXPECT_EQ((std::array{t.vertices, t.edges, t.faces}),
                  (std::array<std::int64_t, 3>{2 * n, 3 * n, n + 2}));
        EXPECT_TRUE(t.closed && t.oriented && t.manifold);
        const double base = 0.5 * n * 4 * std::sin(2 * std::numbers::pi / n);
        EXPECT_NEAR(volume(to_triangles(mesh)), 3 * base, 1e-13 * base);
        EXPECT_EQ(mesh.vertices[0][2], n % 2 == 0 ? -1.5 : 0);
    }

    const PolygonMesh ring = torus_mesh(3, 1, 60, 40);
    const Topology t = topology(ring);
    EXPECT_EQ(t.euler, 0);
    EXPECT_EQ(t.genus, 1);
    const double exact = 2 * std::numbers::pi * std::numbers::pi * 3;
    EXPECT_NEAR(volume(to_triangles(ring)), exact, 0.01 * exact);
    EXPECT_TRUE(validate(to_triangles(ring)).ok());

    EXPECT_THROW(grid_mesh(0, 1), InvalidInput);
    EXPECT_THROW(grid_mesh(100'000, 100'000), InvalidInput);
    EXPECT_THROW(prism(2, 1), InvalidInput);
    EXPECT_THROW(prism(3, 0), InvalidInput);
    EXPECT_THROW(torus_mesh(1, 2, 10, 10), InvalidInput);
    EXPECT_THROW(torus_mesh(2, 1, 2, 10), InvalidInput);
}

TEST(Rings, BothHalfedgeFormsGiveTheSameNeighbours)
{
    for (const IndexedMesh& mesh : {icosphere(3), cases::torus(9, 7), cases::sheet(5, 4)}) {
        const HalfedgeMesh explicit_form(mesh);
        const TriangleHalfedgeMesh directed(mesh);
        const OneRings a = one_rings(explicit_form), b = one_rings(directed);
        ASSERT_EQ(a.starts, b.starts);
        std::vector<double> sums(3 * mesh.n_vertices(), 0.0), lone(mesh.n_vertices(), 0.0);
        for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
            // The same cycle of neighbours, begun anywhere.
            std::vector<std::int32_t> ring(a.vertices.begin() + a.starts[v],
                                           a.vertices.begin() + a.starts[v + 1]);
            std::vector<std::int32_t> other(b.vertices.begin() + b.starts[v],
                                            b.vertices.begin() + b.starts[v + 1]);
            std::rotate(ring.begin(), std::find(ring.begin(), ring.end(), other[0]), ring.end());
            EXPECT_EQ(ring, other);
            for (const std::int32_t w : ring) {
                for (std::size_t i = 0; i < 3; ++i) sums[3 * v + i] += mesh.vertices[w][i];
                lone[v] += w;
            }
        }
        const std::span<const double> points(mesh.vertices[0].c.data(), 3 * mesh.n_vertices());
        std::vector<double> numbers, pairs;
        for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
            numbers.push_back(static_cast<double>(v));
            pairs.insert(pairs.end(), {static_cast<double>(v), -1.0});
        }
        for (const bool of_triangles : {false, true}) {
            const auto add = [&](std::span<const double> values, std::size_t width) {
                return of_triangles ? ring_sums(directed, values, width)
                                    : ring_sums(explicit_form, values, width);
            };
            const std::vector<double> found = add(points, 3);
            for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], sums[i], 1e-12);
            EXPECT_EQ(add(numbers, 1), lone);
            const std::vector<double> both = add(pairs, 2);
            for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
                EXPECT_EQ(both[2 * v], lone[v]);
                EXPECT_EQ(-both[2 * v + 1], static_cast<double>(a.starts[v + 1] - a.starts[v]));
            }
            EXPECT_THROW(add(points, 2), InvalidInput);
        }
    }
}
