#include "genus/mesh/aabb_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "cases/meshes.h"
#include "genus/base/error.h"

using namespace genus;

namespace {

std::vector<Box3> random_boxes(std::mt19937& random, std::size_t n, double size)
{
    std::vector<Box3> boxes(n);
    for (Box3& box : boxes) {
        const Vec3 p = cases::point_in_cube(random, 0, 1);
        box.add(p);
        box.add(p + cases::point_in_cube(random, 0, size));
    }
    return boxes;
}

using Pairs = std::vector<std::array<std::int32_t, 2>>;

Pairs all_self_pairs(const BoxTree& tree)
{
    Pairs pairs;
    for (const Pairs& part : tree.visit_self_pairs<Pairs>([](auto i, auto j, Pairs&out) {
             out.push_back({i, j});
             return true;
         }))
        pairs.insert(pairs.end(), part.begin(), part.end());
    return pairs;
}

}  // namespace

TEST(BoxTree, FindsWhatBruteForceFinds)
{
    std::mt19937 random(11);
    for (const std::size_t n : {1u, 2u, 5u, 300u, 6000u}) {
        SCOPED_TRACE(n);
        const std::vector<Box3> boxes = random_boxes(random, n, 0.05);
        const BoxTree tree(boxes);
        for (int i = 0; i < 20; ++i) {
            const Box3 query = random_boxes(random, 1, 0.3)[0];
            std::vector<std::int32_t> expected;
            for (std::size_t k = 0; k < n; ++k)
                if (overlap(query, boxes[k])) expected.push_back(static_cast<std::int32_t>(k));
            EXPECT_EQ(tree.overlapping(query), expected);
        }
    }
}

TEST(BoxTree, FindsEachOverlappingPairOnce)
{
    std::mt19937 random(12);
    for (const std::size_t n : {2u, 40u, 3000u}) {
        const std::vector<Box3> boxes = random_boxes(random, n, 0.04);
        const BoxTree tree(boxes);
        Pairs found = all_self_pairs(tree);
        std::sort(found.begin(), found.end());
        Pairs expected;
        for (std::int32_t i = 0; i < static_cast<std::int32_t>(n); ++i)
            for (std::int32_t j = i + 1; j < static_cast<std::int32_t>(n); ++j)
                if (overlap(boxes[i], boxes[j])) expected.push_back({i, j});
        EXPECT_EQ(found, expected);
    }
}

TEST(BoxTree, FindsPairsOfTwoTrees)
{
    std::mt19937 random(13);
    const std::vector<Box3> a = random_boxes(random, 700, 0.1), b = random_boxes(random, 900, 0.02);
    const BoxTree tree_a(a), tree_b(b);
    Pairs found;
    for (const Pairs& part : tree_a.visit_pairs<Pairs>(tree_b, [](auto i, auto j, Pairs&out) {
             out.push_back({i, j});
             return true;
         }))
        found.insert(found.end(), part.begin(), part.end());
    std::sort(found.begin(), found.end());
    Pairs expected;
    for (std::int32_t i = 0; i < 700; ++i)
        for (std::int32_t j = 0; j < 900; ++j)
            if (overlap(a[i], b[j])) expected.push_back({i, j});
    EXPECT_EQ(found, expected);
}

TEST(BoxTree, OrderOfPairsDoesNotDependOnThreads)
{
    std::mt19937 random(14);
    const BoxTree tree(random_boxes(random, 9000, 0.02));
    set_thread_count(1);
    const Pairs one = all_self_pairs(tree);
    set_thread_count(7);
    const Pairs seven = all_self_pairs(tree);
    set_thread_count(2);
    EXPECT_EQ(one, seven);
}

TEST(BoxTree, HoldsManyEqualBoxesAndNone)
{
    const BoxTree tree(std::vector<Box3>(10'000, Box3{{{1, 1, 1}}, {{2, 2, 2}}}));
    EXPECT_EQ(tree.overlapping(Box3{{{2, 2, 2}}, {{3, 3, 3}}}).size(), 10'000u);
    const BoxTree none(std::vector<Box3>{});
    EXPECT_TRUE(none.bounds().empty());
    EXPECT_TRUE(none.overlapping(Box3::everything()).empty());
    EXPECT_EQ(none.nearest(Vec3{}, [](std::int32_t) { return 0.0; }).item, -1);
    EXPECT_TRUE(all_self_pairs(none).empty());
}

TEST(BoxTree, RefusesBoxesWithoutBounds)
{
    EXPECT_THROW(BoxTree(std::vector<Box3>{Box3{}}), InvalidInput);
    EXPECT_THROW(BoxTree(std::vector<Box3>{Box3::everything()}), InvalidInput);
    EXPECT_NO_THROW(BoxTree(std::vector<Box3>{{{{-1e308, 0, 0}}, {{1e308, 1, 1}}},
                                              {{{1e308, 0, 0}}, {{1e308, 1, 1}}}}));
}

TEST(MeshTree, NearestPointAgreesWithBruteForce)
{
    std::mt19937 random(15);
    const IndexedMesh mesh = cases::torus(40, 30);
    const MeshTree tree(mesh);
    for (int i = 0; i < 300; ++i) {
        const Vec3 p = cases::point_in_cube(random, -4, 4);
        double expected = 1e300;
        for (const auto& [a, b, c] : mesh.faces)
            expected =
                std::min(expected, distance(p, closest_point(p, mesh.vertices[a], mesh.vertices[b],
                                                             mesh.vertices[c])));
        const ClosestPoint found = tree.nearest(p);
        EXPECT_EQ(found.distance, expected);
        EXPECT_EQ(distance(p, found.point), expected);
        EXPECT_EQ(tree.nearest(p, 0.5 * expected).face, -1);
    }
}

TEST(MeshTree, ClosestPointMeetsItsConditions)
{
    // The closest point q of a convex set: (p - q) . (x - q) <= 0 for all its points x.
    std::mt19937 random(16);
    for (int i = 0; i < 20'000; ++i) {
        Vec3 a = cases::point_in_cube(random, -1, 1), b = cases::point_in_cube(random, -1, 1);
        Vec3 c = cases::point_in_cube(random, -1, 1);
        if (i % 5 == 1) b = a;                    // a segment
        if (i % 5 == 2) c = 0.25 * a + 0.75 * b;  // on one line, rounded
        if (i % 5 == 3) c = a + 1e-9 * c;         // a needle
        if (i % 50 == 4) b = c = a;
        const Vec3 p = cases::point_in_cube(random, -2, 2);
        const Vec3 q = closest_point(p, a, b, c);
        for (const Vec3& x : {a, b, c}) EXPECT_LE(dot(p - q, x - q), 1e-7) << i;
    }
}

TEST(MeshTree, RaysGoInAsOftenAsOut)
{
    std::mt19937 random(17);
    const IndexedMesh mesh = cases::torus(24, 16);
    const MeshTree tree(mesh);
    int hits_seen = 0;
    for (int i = 0; i < 2000; ++i) {
        // Aim from outside at a vertex, the middle of an edge or anywhere: edges must not leak.
        const Triangle& t = mesh.faces[random() % mesh.n_faces()];
        Vec3 target = mesh.vertices[t[0]];
        if (i % 3 == 1) target = 0.5 * mesh.vertices[t[0]] + 0.5 * mesh.vertices[t[1]];
        if (i % 3 == 2) target = cases::point_in_cube(random, -2, 2);
        const Vec3 origin = 20.0 * normalized(cases::point_in_cube(random, -1, 1));
        const std::vector<RayHit> hits = tree.ray_hits(origin, target - origin);
        int depth = 0;
        for (const RayHit& hit : hits) {
            depth += hit.leaves ? -1 : 1;
            const auto& [a, b, c] = mesh.faces[hit.face];
            const Vec3 there = hit.weights[0] * mesh.vertices[a] +
                               hit.weights[1] * mesh.vertices[b] +
                               hit.weights[2] * mesh.vertices[c];
            EXPECT_LT(distance(there, origin + hit.t * (target - origin)), 1e-11);
        }
        EXPECT_EQ(depth, 0);
        hits_seen += static_cast<int>(hits.size());
    }
    EXPECT_GT(hits_seen, 2000);
}

TEST(MeshTree, RaysAlongAxesAndEdgesOfABox)
{
    const IndexedMesh mesh = cases::box();
    const MeshTree tree(mesh);
    const auto inside = tree.ray_hits({{0.5, 0.5, 0.5}}, {{0, 0, -2}});
    ASSERT_EQ(inside.size(), 1u);
    EXPECT_DOUBLE_EQ(inside[0].t, 0.25);
    EXPECT_TRUE(inside[0].leaves);
    // Through a diagonal of two faces, through corners, within a side.
    for (const Vec3& d : {Vec3{{0, 0, 1}}, Vec3{{1, 1, 1}}, Vec3{{1, 0, 0}}, Vec3{{0, 1, 1}}})
        EXPECT_EQ(tree.ray_hits(Vec3{{0.25, 0.25, 0.25}} - 3.0 * d, d).size(), 2u);
    EXPECT_EQ(tree.ray_hits({{-1, 0, 0}}, {{1, 0, 0}}).size() % 2, 0u);
    EXPECT_THROW(tree.ray_hits({}, {}), InvalidInput);
}

TEST(MeshTree, WindingNumbersTellInsideFromOutside)
{
    IndexedMesh mesh = cases::together(cases::torus(32, 24), cases::octasphere(2, 8));
    const MeshTree tree(mesh);
    std::mt19937 random(18);
    for (int i = 0; i < 3000; ++i) {
        const Vec3 p = cases::point_in_cube(random, -9, 9);
        const double ring = std::hypot(std::hypot(p[0], p[1]) - 2, p[2]);
        const double r = norm(p);
        if ((ring > 0.95 && ring < 1.05) || (r > 7 && r < 8)) continue;
        EXPECT_EQ(tree.winding_number(p), (ring < 1) + (r < 7.5));
    }
}

TEST(MeshTree, WindingNumbersAreExactBesideAndOnTheSurface)
{
    const IndexedMesh mesh = cases::box();
    const MeshTree tree(mesh);
    const double under = std::nextafter(1.0, 0.0), over = std::nextafter(1.0, 2.0);
    for (const double x : {0.0, 0.25, 0.5, 1.0}) {  // rays through edges and corners too
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Vec3 p{{0.5, 0.5, 0.5}};
            p[(axis + 1) % 3] = std::clamp(x, 5e-324, under);
            p[axis] = under;
            EXPECT_EQ(tree.winding_number(p), 1);
            p[axis] = over;
            EXPECT_EQ(tree.winding_number(p), 0);
        }
    }
    EXPECT_EQ(tree.winding_number({{1, 0.25, 0.75}}), std::nullopt);
}
