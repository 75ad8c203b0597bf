#include "genus/patch/patch_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/patch/reference.h"
#include "genus/base/error.h"

namespace genus {
namespace {

int open_edges(const IndexedMesh& mesh)
{
    std::map<std::pair<int, int>, int> count;
    for (const Triangle& t : mesh.faces)
        for (int k = 0; k < 3; ++k) {
            ++count[{t[k], t[(k + 1) % 3]}];
            --count[{t[(k + 1) % 3], t[k]}];
        }
    int open = 0;
    for (const auto& [edge, n] : count) open += n != 0;
    return open;
}

// Octahedron split `levels` times, its vertices on the unit sphere.
IndexedMesh ball(int levels)
{
    IndexedMesh m;
    m.vertices = {{{1, 0, 0}}, {{-1, 0, 0}}, {{0, 1, 0}}, {{0, -1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}};
    m.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
               {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int l = 0; l < levels; ++l) {
        std::map<std::pair<int, int>, int> middle;
        std::vector<Triangle> faces;
        const auto split = [&](int a, int b) {
            const auto [at, added] = middle.emplace(std::minmax(a, b), int(m.vertices.size()));
            if (added) m.vertices.push_back(normalized(m.vertices[a] + m.vertices[b]));
            return at->second;
        };
        for (const Triangle& t : m.faces) {
            const int a = split(t[0], t[1]), b = split(t[1], t[2]), c = split(t[2], t[0]);
            faces.insert(faces.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
        }
        m.faces = faces;
    }
    return m;
}

TEST(PnTriangles, AreClosedTangentAndNearTheSphere)
{
    double last = 0.0;
    for (int levels = 1; levels <= 3; ++levels) {
        const IndexedMesh mesh = ball(levels);
        const PatchModel model = pn_triangles(mesh, mesh.vertices);
        EXPECT_TRUE(model.is_closed());
        EXPECT_TRUE(model.is_oriented());
        EXPECT_EQ(model.edges().size(), mesh.faces.size() * 3 / 2);
        double worst = 0.0;
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
            const auto& p = std::get<BezierTriangle>(model.patches()[f]);
            EXPECT_LE(distance(p.normal(0, 0), mesh.vertices[mesh.faces[f][0]]), 1e-12);
            EXPECT_LE(distance(p.normal(1, 0), mesh.vertices[mesh.faces[f][1]]), 1e-12);
            worst = std::max(worst, std::fabs(norm(p.value(1.0 / 3, 1.0 / 3)) - 1.0));
        }
        for (const PatchJoin& j : model.joins()) EXPECT_LE(j.gap, 1e-15);
        // The flat mesh is away by the square of its edges, the patches by the fourth power.
        if (last > 0.0) {
            EXPECT_NEAR(std::log2(last / worst), 4.0, 0.7);
        }
        last = worst;
        const auto t = model.tessellate({1e-3});
        EXPECT_EQ(open_edges(t.mesh), 0);
    }
}

TEST(PatchModel, MeasuresJoins)
{
    // Two bilinear squares at a right angle, and one turned over.
    const TensorPatch floor(1, 1, {{{0, 0, 0}}, {{0, 1, 0}}, {{1, 0, 0}}, {{1, 1, 0}}});
    const TensorPatch wall(1, 1, {{{1, 0, 0}}, {{1, 1, 0}}, {{1, 0, 1}}, {{1, 1, 1}}});
    const PatchModel model({floor, wall});
    EXPECT_FALSE(model.is_closed());
    EXPECT_TRUE(model.is_oriented());
    ASSERT_EQ(model.joins().size(), 1u);
    EXPECT_NEAR(model.joins()[0].turn, 1.57079632679489662, 1e-14);
    EXPECT_EQ(model.joins()[0].gap, 0.0);
    EXPECT_FALSE(PatchModel({floor, wall.transposed()}).is_oriented());
    // Halves of one smooth patch join without a turn.
    std::mt19937_64 random(161);
    const TensorPatch smooth(3, 3, reference::random_points(random, 16));
    const auto [a, b] = smooth.split_u(0.5);
    const PatchModel halves({a, b});
    ASSERT_EQ(halves.joins().size(), 1u);
    EXPECT_LE(halves.joins()[0].turn, 1e-9);
}

TEST(PatchModel, StaysClosedUnderAffineMaps)
{
    const IndexedMesh mesh = ball(1);
    const PatchModel model = transformed(pn_triangles(mesh), rotation(33.0, {{1, 2, 3}}));
    EXPECT_TRUE(model.is_closed());
    EXPECT_EQ(open_edges(model.tessellate({1e-2}).mesh), 0);
}

TEST(PnTriangles, RefuseBadMeshes)
{
    IndexedMesh mesh = ball(0);
    EXPECT_THROW(pn_triangles(mesh, std::vector<Vec3>(2)), InvalidInput);
    mesh.faces.push_back({0, 1, 77});
    EXPECT_THROW(pn_triangles(mesh), InvalidInput);
    EXPECT_TRUE(pn_triangles(IndexedMesh{}).patches().empty());
}

}  // namespace
}  // namespace genus
