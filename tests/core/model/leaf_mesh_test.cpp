#include "genus/model/leaf_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/model/random_trees.h"
#include "genus/base/error.h"

namespace genus {
namespace {

/// V - E + F, or a failure if some edge has not exactly one face on either side.
std::int64_t euler_of_closed(const PolygonMesh& mesh)
{
    std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        for (std::size_t i = 0; i < face.size(); ++i)
            ++edges[{face[i], face[(i + 1) % face.size()]}];
    }
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_EQ(edges.count({edge.second, edge.first}), 1U);
    }
    return std::int64_t(mesh.n_vertices()) - std::int64_t(edges.size() / 2) +
           std::int64_t(mesh.n_faces());
}

double volume_of(const PolygonMesh& mesh)
{
    double six = 0.0;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        for (std::size_t i = 1; i + 1 < face.size(); ++i)
            six += dot(mesh.vertices[face[0]],
                       cross(mesh.vertices[face[i]], mesh.vertices[face[i + 1]]));
    }
    return six / 6.0;
}

TEST(FacetMesh, IsClosedOutwardAndHasTheLanguagesCounts)
{
    for (int n : {3, 4, 5, 6, 7, 8, 30, 100}) {
        SCOPED_TRACE(n);
        const int rings = (n + 1) / 2;
        const PolygonMesh ball = facet_mesh(Sphere{2.0, n});
        EXPECT_EQ(ball.n_vertices(), std::size_t(n * rings));
        EXPECT_EQ(ball.n_faces(), std::size_t(n * (rings - 1) + 2));
        EXPECT_EQ(euler_of_closed(ball), 2);
        EXPECT_GT(volume_of(ball), 0.0);
        for (const Vec3& v : ball.vertices) EXPECT_NEAR(norm(v), 2.0, 1e-15 * 4);
        for (const Cylinder& c : {Cylinder{3, 2, 2, false, n}, Cylinder{3, 2, 1, true, n},
                                  Cylinder{3, 0, 2, true, n}, Cylinder{3, 2, 0, false, n}}) {
            const PolygonMesh mesh = facet_mesh(c);
            const bool cone = c.r1 == 0 || c.r2 == 0;
            EXPECT_EQ(mesh.n_vertices(), std::size_t(cone ? n + 1 : 2 * n));
            EXPECT_EQ(mesh.n_faces(), std::size_t(cone ? n + 1 : n + 2));
            EXPECT_EQ(euler_of_closed(mesh), 2);
            // A prismatoid: the area of the regular n-gon of radius 1, times this.
            const double polygon = 0.5 * n * std::sin(2 * 3.14159265358979323846 / n);
            const double mean = (c.r1 * c.r1 + c.r1 * c.r2 + c.r2 * c.r2) / 3.0;
            EXPECT_NEAR(volume_of(mesh), polygon * mean * c.h, 1e-12);
        }
    }
    EXPECT_EQ(euler_of_closed(facet_mesh(Cube{{{1, 2, 3}}, true})), 2);
    EXPECT_EQ(volume_of(facet_mesh(Cube{{{1, 2, 3}}, true})), 6.0);
}

TEST(FacetMesh, FirstPointLiesOnTheXAxisAndRightAnglesAreExact)
{
    const PolygonMesh mesh = facet_mesh(Cylinder{1, 2, 2, false, 4});
    EXPECT_EQ(mesh.vertices[0], (Vec3{{2, 0, 0}}));
    EXPECT_EQ(mesh.vertices[1], (Vec3{{0, 2, 0}}));
    EXPECT_EQ(mesh.vertices[2], (Vec3{{-2, 0, 0}}));
}

TEST(FacetMesh, RefusesWhatIsNoPolyhedronOrTooLarge)
{
    EXPECT_THROW(facet_mesh(Sphere{1.0, 0}), InvalidInput);
    EXPECT_THROW(facet_mesh(TorusShape{2, 1}), InvalidInput);
    EXPECT_THROW(facet_mesh(Sphere{1.0, 2000000000}), InvalidInput);
    EXPECT_THROW(facet_mesh(Cylinder{1, 1, 1, false, 2000000000}), InvalidInput);
}

/// Distance of a point from the surface of the shape, nearly exact close to it.
double distance_from(const Shape& shape, const Vec3& p)
{
    MembershipOracle oracle;
    return std::fabs(oracle(Solid(std::make_shared<const Node>(shape, Box3{}, 0)), p));
}

TEST(Tessellate, StaysWithinItsBoundAndTheBoundWithinTheTolerance)
{
    RandomShapes random(71);
    for (const Shape& shape :
         {Shape(Sphere{2.0}), Shape(Cylinder{3, 1, 1}), Shape(Cylinder{3, 2, 1, true}),
          Shape(Cylinder{3, 0, 1}), Shape(TorusShape{2, 0.5})})
        for (const double tolerance : {1.0, 0.3, 0.03, 0.003}) {
            SCOPED_TRACE(describe(shape) + " " + std::to_string(tolerance));
            const Tessellation t = tessellate(shape, tolerance);
            EXPECT_LE(t.bound, tolerance);
            const bool ring = std::holds_alternative<TorusShape>(shape);
            EXPECT_EQ(euler_of_closed(t.mesh), ring ? 0 : 2);
            EXPECT_GT(volume_of(t.mesh), 0.0);
            double farthest = 0.0;
            for (const Vec3& v : t.mesh.vertices) EXPECT_LT(distance_from(shape, v), 1e-14);
            for (int sample = 0; sample < 2000; ++sample) {
                const auto face = t.mesh.face(random.below(int(t.mesh.n_faces())));
                Vec3 p;
                double sum = 0.0;
                for (std::int32_t v : face) {
                    const double weight = random.in(0.0, 1.0);
                    p += weight * t.mesh.vertices[v];
                    sum += weight;
                }
                farthest = std::max(farthest, distance_from(shape, p / sum));
            }
            EXPECT_LE(farthest, t.bound);
            EXPECT_GE(farthest, 0.1 * t.bound);  // the bound says something
        }
}

TEST(Tessellate, FacesGrowAsTheToleranceAsks)
{
    // A surface curved both ways needs 1 / tolerance faces, a cylinder 1 / sqrt(tolerance).
    const auto ratio = [](const Shape& shape) {
        return double(tessellate(shape, 1e-4).mesh.n_faces()) /
               double(tessellate(shape, 1e-2).mesh.n_faces());
    };
    EXPECT_NEAR(ratio(Sphere{1.0}), 100.0, 20.0);
    EXPECT_NEAR(ratio(TorusShape{2, 0.5}), 100.0, 20.0);
    EXPECT_NEAR(ratio(Cylinder{1, 1, 1}), 10.0, 1.5);
}

TEST(Tessellate, RefusesWhatItCannotDo)
{
    EXPECT_THROW(tessellate(Sphere{1.0}, 0), InvalidInput);
    EXPECT_THROW(tessellate(Sphere{1.0}, 1e-30), InvalidInput);
    EXPECT_THROW(tessellate(TorusShape{2, 1}, 1e-14), InvalidInput);
    EXPECT_THROW(tessellate(Cube{{{1, 1, 1}}}, 1), InvalidInput);
    EXPECT_THROW(tessellate(Sphere{1.0, 8}, 1), InvalidInput);
}

}  // namespace
}  // namespace genus
