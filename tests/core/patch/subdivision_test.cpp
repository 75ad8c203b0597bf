#include "genus/patch/subdivision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/patch/reference.h"
#include "genus/base/error.h"
#include "genus/patch/bspline_surface.h"

namespace genus {
namespace {

using reference::random_vec;

PolygonMesh cube()
{
    PolygonMesh m;
    for (int i = 0; i < 8; ++i)
        m.vertices.push_back({{double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1)}});
    for (const auto& f : {std::array{0, 2, 3, 1},
                          {4, 5, 7, 6},
                          {0, 1, 5, 4},
                          {2, 6, 7, 3},
                          {0, 4, 6, 2},
                          {1, 3, 7, 5}})
        m.add_face(f);
    return m;
}

PolygonMesh octahedron()
{
    PolygonMesh m;
    m.vertices = {{{1, 0, 0}}, {{-1, 0, 0}}, {{0, 1, 0}}, {{0, -1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}};
    for (const auto& f : {std::array{0, 2, 4},
                          {2, 1, 4},
                          {1, 3, 4},
                          {3, 0, 4},
                          {2, 0, 5},
                          {1, 2, 5},
                          {3, 1, 5},
                          {0, 3, 5}})
        m.add_face(f);
    return m;
}

// A wavy grid with border, of quadrilaterals or triangles.
PolygonMesh grid(std::mt19937_64& random, int n, bool triangles)
{
    std::uniform_real_distribution<double> height(-0.3, 0.3);
    PolygonMesh m;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) m.vertices.push_back({{double(i), double(j), height(random)}});
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const int a = i * (n + 1) + j, b = a + n + 1;
            if (triangles) {
                m.add_face(std::array{a, b, b + 1});
                m.add_face(std::array{a, b + 1, a + 1});
            } else {
                m.add_face(std::array{a, b, b + 1, a + 1});
            }
        }
    return m;
}

TEST(Subdivision, CountsAndEulerNumberAreThoseOfTheScheme)
{
    const auto quads = catmull_clark({cube(), {}, {}}, 3);
    EXPECT_EQ(quads.mesh.n_faces(), 24u * 16u);
    EXPECT_EQ(quads.mesh.n_vertices(), 24u * 16u + 2u);
    const auto triangles = loop_subdivision({octahedron(), {}, {}}, 3);
    EXPECT_EQ(triangles.mesh.n_faces(), 8u * 64u);
    EXPECT_EQ(triangles.mesh.n_vertices(), 8u * 64u / 2u + 2u);
}

// In the regular part Catmull-Clark is knot insertion of uniform bicubic splines.
TEST(Subdivision, RegularMeshIsTheBicubicSpline)
{
    std::mt19937_64 random(151);
    const int n = 6;
    const PolygonMesh m = grid(random, n, false);
    const BSplineSurface spline(KnotVector::uniform(3, n + 1), KnotVector::uniform(3, n + 1),
                                m.vertices);
    const auto limit = limit_surface({m, {}, {}}, SubdivisionScheme::CatmullClark);
    for (int i = 1; i < n; ++i)
        for (int j = 1; j < n; ++j) {
            const std::size_t v = static_cast<std::size_t>(i * (n + 1) + j);
            if (i < 2 || j < 2 || i > n - 2 || j > n - 2) continue;
            EXPECT_LE(distance(limit.points[v], spline.value(i - 1.0, j - 1.0)), 1e-13);
            EXPECT_LE(distance(limit.normals[v], spline.normal(i - 1.0, j - 1.0)), 1e-12);
        }
}

// The limit does not change under subdivision, and deep meshes come to it.
TEST(Subdivision, LimitIsWhereSubdivisionGoes)
{
    std::mt19937_64 random(152);
    for (const bool loop : {false, true})
        for (int variant = 0; variant < 4; ++variant) {
            SCOPED_TRACE(testing::Message() << "loop " << loop << " variant " << variant);
            SubdivisionMesh m{
                variant < 2 ? (loop ? octahedron() : cube()) : grid(random, 3, loop), {}, {}};
            if (variant < 2)
                for (Vec3& p : m.mesh.vertices) p += 0.3 * random_vec(random);
            const auto f = m.mesh.face(0);
            if (variant == 1) m.creases = {{f[0], f[1], 1.5}};
            if (variant == 3) m.corners = {f[0]};
            const auto scheme = loop ? SubdivisionScheme::Loop : SubdivisionScheme::CatmullClark;
            const auto limit = limit_surface(m, scheme);
            SubdivisionMesh deep = m;
            for (int level = 0; level < 6; ++level)
                deep = loop ? loop_subdivision(deep) : catmull_clark(deep);
            const auto later = limit_surface(deep, scheme);
            for (std::size_t v = 0; v < m.mesh.n_vertices(); ++v) {
                EXPECT_LE(distance(limit.points[v], later.points[v]), 1e-12) << v;
                EXPECT_LE(distance(limit.points[v], deep.mesh.vertices[v]), 2e-2) << v;
                if (limit.normals[v] != Vec3{}) {
                    EXPECT_LE(distance(limit.normals[v], later.normals[v]), 1e-9) << v;
                }
            }
            // Normals of the faces at a vertex, six levels down, are close to the limit's.
            for (std::size_t k = 0; k < deep.mesh.n_faces(); ++k) {
                const auto face = deep.mesh.face(k);
                for (std::size_t c = 0; c < face.size(); ++c) {
                    const auto v = static_cast<std::size_t>(face[c]);
                    if (v >= m.mesh.n_vertices() || limit.normals[v] == Vec3{}) continue;
                    const Vec3& p = deep.mesh.vertices[v];
                    const Vec3 a = deep.mesh.vertices[face[(c + 1) % face.size()]] - p;
                    const Vec3 b =
                        deep.mesh.vertices[face[(c + face.size() - 1) % face.size()]] - p;
                    EXPECT_GE(dot(normalized(cross(a, b)), limit.normals[v]), 0.98) << v;
                }
            }
        }
}

TEST(Subdivision, LimitAtTheEndOfACreaseStaysUnderSubdivision)
{
    for (const auto scheme : {SubdivisionScheme::CatmullClark, SubdivisionScheme::Loop}) {
        const bool loop = scheme == SubdivisionScheme::Loop;
        const SubdivisionMesh m{loop ? octahedron() : cube(), {{0, 2}}, {}};
        const auto limit = limit_surface(m, scheme);
        for (const int levels : {1, 4}) {
            const auto later = limit_surface(
                loop ? loop_subdivision(m, levels) : catmull_clark(m, levels), scheme);
            for (std::size_t v = 0; v < m.mesh.n_vertices(); ++v)
                EXPECT_LT(distance(limit.points[v], later.points[v]), 1e-13);
        }
    }
}

TEST(Subdivision, SharpCreasesFollowTheCubicSpline)
{
    SubdivisionMesh m{cube(), {}, {}};
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 3}, {3, 2}, {2, 0}})
        m.creases.push_back({a, b});
    const auto deep = catmull_clark(m, 4);
    // The crease stays in its plane, and its points are those of the closed cubic spline.
    const auto limit = limit_surface(m, SubdivisionScheme::CatmullClark);
    for (const int v : {0, 1, 2, 3}) {
        EXPECT_EQ(limit.points[v][2], 0.0);
        EXPECT_EQ(deep.mesh.vertices[v][2], 0.0);
        EXPECT_EQ(limit.normals[v], Vec3{});
    }
    EXPECT_LE(distance(limit.points[0], {{1.0 / 6, 1.0 / 6, 0}}), 1e-15);
    // All edges sharp: a cube stays a cube.
    SubdivisionMesh sharp{cube(), {}, {}};
    for (int a = 0; a < 8; ++a)
        for (const int bit : {1, 2, 4})
            if ((a & bit) == 0) sharp.creases.push_back({a, a | bit});
    for (const Vec3& p : catmull_clark(sharp, 3).mesh.vertices) {
        double face = 1.0;
        for (int k = 0; k < 3; ++k) face = std::min({face, std::fabs(p[k]), std::fabs(p[k] - 1.0)});
        EXPECT_LE(face, 1e-15);
    }
}

TEST(Subdivision, FractionalSharpnessLiesBetween)
{
    SubdivisionMesh m{cube(), {{0, 1, 0.0}}, {}};
    const auto at_edge = [&](double sharpness) {
        m.creases[0].sharpness = sharpness;
        const auto fine = catmull_clark(m);
        return fine.mesh.vertices[8];  // the first edge is 0-1
    };
    const Vec3 smooth = at_edge(0.0), sharp = at_edge(1.0), half = at_edge(0.5);
    EXPECT_LE(distance(half, 0.5 * (smooth + sharp)), 1e-15);
    EXPECT_LE(distance(sharp, {{0.5, 0, 0}}), 1e-15);
}

TEST(Subdivision, ReproducesPlanes)
{
    std::mt19937_64 random(153);
    for (const bool loop : {false, true}) {
        PolygonMesh m = grid(random, 4, loop);
        for (Vec3& p : m.vertices) p[2] = 2.0 * p[0] - p[1];
        const auto fine = loop ? loop_subdivision({m, {}, {}}, 3) : catmull_clark({m, {}, {}}, 3);
        for (const Vec3& p : fine.mesh.vertices) EXPECT_NEAR(p[2], 2.0 * p[0] - p[1], 1e-13);
    }
}

TEST(Subdivision, RefusesBadMeshes)
{
    PolygonMesh m = cube();
    EXPECT_THROW(loop_subdivision({m, {}, {}}), InvalidInput);
    EXPECT_THROW(catmull_clark({m, {{0, 7}}, {}}), InvalidInput);
    EXPECT_THROW(catmull_clark({m, {{0, 1, -1.0}}, {}}), InvalidInput);
    EXPECT_THROW(catmull_clark({m, {}, {9}}), InvalidInput);
    EXPECT_THROW(catmull_clark({m, {}, {}}, 13), InvalidInput);
    m.add_face(std::array{0, 1, 99});
    EXPECT_THROW(catmull_clark({m, {}, {}}), InvalidInput);
    PolygonMesh twice;
    twice.vertices.resize(3);
    twice.add_face(std::array{0, 1, 1});
    EXPECT_THROW(catmull_clark({twice, {}, {}}), InvalidInput);
    EXPECT_TRUE(catmull_clark({}).mesh.vertices.empty());
}

}  // namespace
}  // namespace genus
