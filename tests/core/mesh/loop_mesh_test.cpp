#include "genus/mesh/loop_mesh.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "genus/base/error.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"

using namespace genus;

namespace {

// Lifts the face at the left of h by a wall: the sweep of [mantyla1988], as mev and mef.
void sweep(LoopMesh& mesh, Face f, const Vec3& by)
{
    const Halfedge first = mesh.halfedge(mesh.outer(f));
    std::vector<Halfedge> sides;
    for (Halfedge h = first; sides.empty() || h != first; h = mesh.next(h)) sides.push_back(h);
    std::vector<Halfedge> up;
    for (const Halfedge h : sides) up.push_back(mesh.mev(h, mesh.point(mesh.from(h)) + by));
    // Each wall is cut off the face by an edge from tip to tip; f stays on top.
    Halfedge rim;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const bool last = i + 1 == sides.size();
        const Halfedge next = last ? rim : LoopMesh::opposite(up[i + 1]);
        const Halfedge h = mesh.mef(LoopMesh::opposite(up[i]), next);
        if (i == 0) rim = h;
    }
}

// A square sheet of two faces; the first is the one seen from above.
LoopMesh sheet(double size, const Vec3& origin, Face& top)
{
    LoopMesh mesh;
    const Vertex a = mesh.mvfs(origin);
    const Halfedge ab = mesh.mev(a, origin + Vec3{{size, 0, 0}});
    const Halfedge bc = mesh.mev(LoopMesh::opposite(ab), origin + Vec3{{size, size, 0}});
    const Halfedge cd = mesh.mev(LoopMesh::opposite(bc), origin + Vec3{{0, size, 0}});
    const Halfedge da = mesh.mef(LoopMesh::opposite(cd), ab);
    top = mesh.face(da);
    return mesh;
}

void expect_counts(const LoopMesh& mesh, const EulerCounts& expected)
{
    mesh.check();
    const EulerCounts c = mesh.counts();
    EXPECT_EQ(c, expected) << c.vertices << " " << c.edges << " " << c.faces << " " << c.loops
                           << " " << c.shells;
}

}  // namespace

TEST(LoopMesh, BuildsABlockAndTakesItApart)
{
    Face top;
    LoopMesh mesh = sheet(2, {}, top);
    expect_counts(mesh, {4, 4, 2, 2, 1});
    sweep(mesh, top, {{0, 0, 3}});
    expect_counts(mesh, {8, 12, 6, 6, 1});
    const PolygonMesh block = mesh.to_polygons();
    EXPECT_EQ(volume(to_triangles(block)), 12);
    EXPECT_TRUE(validate(to_triangles(block)).ok());
    // Inverses, edge by edge, until one vertex is left.
    while (mesh.n_edges() > 0) {
        for (std::size_t i = 0; i < mesh.halfedge_slots(); ++i) {
            const Halfedge h(i);
            if (!mesh.is_alive(h)) continue;
            if (mesh.face(h) != mesh.face(LoopMesh::opposite(h)))
                mesh.kef(h);
            else if (mesh.from(h) != mesh.to(h))
                mesh.kev(h);
            mesh.check();
            EXPECT_EQ(mesh.counts().genus(), 0);
        }
    }
    expect_counts(mesh, {1, 0, 1, 1, 1});
    for (std::size_t i = 0; i < mesh.vertex_slots(); ++i)
        if (mesh.is_alive(Vertex(i))) mesh.kvfs(Vertex(i));
    expect_counts(mesh, {});
}

TEST(LoopMesh, BoresAHoleThroughABlock)
{
    Face top;
    LoopMesh mesh = sheet(4, {}, top);
    sweep(mesh, top, {{0, 0, 1}});
    // A square drawn on the top: an edge to it, the square, and the edge gone again.
    const Halfedge corner = mesh.halfedge(mesh.outer(top));
    const Halfedge bridge = mesh.mev(corner, {{1, 1, 1}});
    const Halfedge side = mesh.mev(LoopMesh::opposite(bridge), {{3, 1, 1}});
    const Halfedge second = mesh.mev(LoopMesh::opposite(side), {{3, 3, 1}});
    const Halfedge third = mesh.mev(LoopMesh::opposite(second), {{1, 3, 1}});
    const Halfedge last = mesh.mef(side, LoopMesh::opposite(third));
    const Face inner = mesh.face(LoopMesh::opposite(last));
    EXPECT_EQ(mesh.face(last), top);
    const Loop ring = mesh.kemr(bridge);
    EXPECT_EQ(mesh.face(ring), top);
    expect_counts(mesh, {12, 16, 7, 8, 1});
    EXPECT_EQ(mesh.loops(top).size(), 2u);
    // Sunk down to the bottom, where its floor becomes a ring of the bottom face: a handle.
    sweep(mesh, inner, {{0, 0, -1}});
    expect_counts(mesh, {16, 24, 11, 12, 1});
    Face bottom;
    for (std::size_t f = 0; f < mesh.face_slots(); ++f) {
        bool below = Face(f) != inner;
        for (const Loop l : mesh.loops(Face(f))) {
            Halfedge h = mesh.halfedge(l);
            for (int i = 0; i < 4; ++i, h = mesh.next(h)) below &= mesh.point(mesh.from(h))[2] == 0;
        }
        if (below) bottom = Face(f);
    }
    ASSERT_TRUE(bottom.valid());
    mesh.kfmrh(bottom, inner);
    expect_counts(mesh, {16, 24, 10, 12, 1});
    EXPECT_EQ(mesh.counts().genus(), 1);
    const IndexedMesh triangles = to_triangles(mesh.to_polygons());
    EXPECT_EQ(volume(triangles), 12);
    EXPECT_TRUE(validate(triangles).ok());
    EXPECT_EQ(topology(triangles).genus, 1);
    // And back: the ring is a face again, the bore a hole with a floor.
    const Face floor = mesh.mfkrh(mesh.loops(bottom)[1]);
    expect_counts(mesh, {16, 24, 11, 12, 1});
    EXPECT_EQ(mesh.counts().genus(), 0);
    EXPECT_EQ(mesh.loops(floor).size(), 1u);
    // The ring on the top is joined to its outer loop again.
    mesh.mekr(mesh.halfedge(mesh.outer(top)), mesh.halfedge(mesh.loops(top)[1]));
    expect_counts(mesh, {16, 25, 11, 11, 1});
}

TEST(LoopMesh, TwoShellsBecomeOne)
{
    LoopMesh mesh;
    const Vertex a = mesh.mvfs({}), b = mesh.mvfs({{1, 0, 0}});
    expect_counts(mesh, {2, 0, 2, 2, 2});
    const Face f = mesh.face(mesh.loop(a)), g = mesh.face(mesh.loop(b));
    mesh.kfmrh(f, g);
    expect_counts(mesh, {2, 0, 1, 2, 1});
    const Halfedge h = mesh.mekr(b, a);  // the loop of a, the outer one, goes
    expect_counts(mesh, {2, 1, 1, 1, 1});
    EXPECT_EQ(mesh.from(h), b);
    const Loop ring = mesh.kemr(h);
    EXPECT_EQ(mesh.vertex(ring), a);
    mesh.mfkrh(ring);
    expect_counts(mesh, {2, 0, 2, 2, 2});
    // An edge from a vertex to itself cuts the sphere in two.
    const Halfedge round = mesh.mef(a, a);
    expect_counts(mesh, {2, 1, 3, 3, 2});
    EXPECT_THROW(mesh.kev(round), InvalidInput);
    mesh.kef(round);
    expect_counts(mesh, {2, 0, 2, 2, 2});
}

TEST(LoopMesh, SplitsAVertexAndJoinsItAgain)
{
    Face top;
    LoopMesh mesh = sheet(2, {}, top);
    sweep(mesh, top, {{0, 0, 2}});
    const Halfedge a = mesh.halfedge(mesh.outer(top));
    const Halfedge b = mesh.next(LoopMesh::opposite(a));
    const Vertex v = mesh.from(a);
    const Halfedge h = mesh.mev(a, b, {{5, 5, 5}});
    expect_counts(mesh, {9, 13, 6, 6, 1});
    EXPECT_EQ(mesh.from(h), v);
    EXPECT_EQ(mesh.from(a), mesh.to(h));
    EXPECT_EQ(mesh.from(b), v);
    mesh.kev(h);
    expect_counts(mesh, {8, 12, 6, 6, 1});
    EXPECT_EQ(volume(to_triangles(mesh.to_polygons())), 8);
}

TEST(LoopMesh, RefusesWithTheReason)
{
    Face top;
    LoopMesh mesh = sheet(2, {}, top);
    const Halfedge h = mesh.halfedge(mesh.outer(top));
    EXPECT_THROW(mesh.kemr(h), InvalidInput);  // different faces
    EXPECT_THROW(mesh.mekr(h, mesh.next(h)), InvalidInput);
    EXPECT_THROW(mesh.mef(h, LoopMesh::opposite(h)), InvalidInput);
    EXPECT_THROW(mesh.kfmrh(top, top), InvalidInput);
    EXPECT_THROW(mesh.mfkrh(mesh.outer(top)), InvalidInput);
    EXPECT_THROW(mesh.mev(mesh.from(h), Vec3{}), InvalidInput);
    EXPECT_THROW(mesh.kvfs(mesh.from(h)), InvalidInput);
    EXPECT_THROW(mesh.mev(Halfedge(99), Vec3{}), InvalidInput);
    EXPECT_THROW(mesh.mev(h, mesh.next(h), Vec3{}), InvalidInput);
    EXPECT_THROW(mesh.kfmrh(top, Face(7)), InvalidInput);
    expect_counts(mesh, {4, 4, 2, 2, 1});
    const Vertex lone = mesh.mvfs({});
    EXPECT_THROW(mesh.to_polygons(), InvalidInput);
    mesh.kvfs(lone);
    EXPECT_EQ(mesh.to_polygons().n_faces(), 2u);
}

namespace {

struct Walker {
    LoopMesh mesh;
    std::mt19937 random;
    std::int64_t shells_less_handles = 0;

    template <class H>
    H any(std::size_t slots)
    {
        // The next one alive from a random number on.
        const std::size_t first = slots > 0 ? random() % slots : 0;
        for (std::size_t i = 0; i < slots; ++i) {
            const H h((first + i) % slots);
            if (mesh.is_alive(h)) return h;
        }
        return {};
    }
    LoopMesh::Corner corner()
    {
        const Halfedge h = any<Halfedge>(mesh.halfedge_slots());
        const Vertex v = any<Vertex>(mesh.vertex_slots());
        const bool lone = v.valid() && mesh.is_lone(v);
        return lone || !h.valid() ? LoopMesh::Corner(v) : LoopMesh::Corner(h);
    }
    // Some steps along the loop.
    Halfedge along(Halfedge h)
    {
        for (unsigned n = random() % 6; n > 0; --n) h = mesh.next(h);
        return h;
    }
    Vec3 point() { return {{random() * 0x1p-32, random() * 0x1p-32, random() * 0x1p-32}}; }

    // False if the operator was refused.
    bool step(bool grow)
    {
        const Halfedge h = any<Halfedge>(mesh.halfedge_slots());
        try {
            switch (random() % (grow ? 14 : 9)) {
                case 0:
                case 1:
                    mesh.kev(h);
                    break;
                case 2:
                    mesh.kef(h);
                    break;
                case 3:
                    mesh.kemr(h);
                    break;
                case 4:
                    mesh.kfmrh(any<Face>(mesh.face_slots()), any<Face>(mesh.face_slots()));
                    --shells_less_handles;
                    break;
                case 5:
                case 6:
                    mesh.mfkrh(any<Loop>(mesh.loop_slots()));
                    ++shells_less_handles;
                    break;
                case 7: {
                    const LoopMesh::Corner a = corner();
                    if (!a.halfedge.valid() && !a.vertex.valid()) return false;
                    const Face f =
                        mesh.face(a.halfedge.valid() ? mesh.loop(a.halfedge) : mesh.loop(a.vertex));
                    const std::vector<Loop> loops = mesh.loops(f);
                    const Loop l = loops[random() % loops.size()];
                    const Halfedge b = mesh.halfedge(l);
                    mesh.mekr(a, b.valid() ? LoopMesh::Corner(b) : mesh.vertex(l));
                    break;
                }
                case 8:
                    mesh.kvfs(any<Vertex>(mesh.vertex_slots()));
                    --shells_less_handles;
                    break;
                case 9:
                    mesh.mvfs(point());
                    ++shells_less_handles;
                    break;
                case 10:
                    mesh.mev(corner(), point());
                    break;
                case 11: {
                    if (!h.valid()) return false;
                    Halfedge b = h;
                    for (unsigned n = random() % 4; n > 0; --n)
                        b = mesh.next(LoopMesh::opposite(b));
                    mesh.mev(h, b, point());
                    break;
                }
                default: {
                    const LoopMesh::Corner a = corner();
                    if (a.halfedge.valid())
                        mesh.mef(a, along(a.halfedge));
                    else
                        mesh.mef(a, a);
                }
            }
            return true;
        } catch (const InvalidInput&) {
            return false;
        }
    }
};

}  // namespace

TEST(LoopMesh, RandomSequencesKeepEulerPoincare)
{
    const int steps = std::getenv("GENUS_LONG") ? 1'000'000 : 20'000;
    for (std::uint32_t seed = 0; seed < 3; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Walker walker{{}, std::mt19937(seed), 0};
        LoopMesh& mesh = walker.mesh;
        int done = 0;
        std::int64_t most_handles = 0;
        for (int i = 0; i < steps; ++i) {
            done += walker.step(mesh.n_edges() < 150);
            const auto n = [](std::size_t count) { return static_cast<std::int64_t>(count); };
            const std::int64_t faces = n(mesh.n_faces());
            ASSERT_EQ(
                n(mesh.n_vertices()) - n(mesh.n_edges()) + faces - (n(mesh.n_loops()) - faces),
                2 * walker.shells_less_handles)
                << "step " << i;
            if (i % 50 != 0) continue;
            ASSERT_NO_THROW(mesh.check()) << "step " << i;
            // Shell by shell the formula must give a number of handles: whole, not negative.
            EulerCounts sum;
            for (const EulerCounts& c : mesh.shells()) {
                const std::int64_t rings = c.loops - c.faces;
                ASSERT_EQ((c.vertices - c.edges + c.faces - rings) % 2, 0);
                ASSERT_GE(c.genus(), 0);
                most_handles = std::max(most_handles, c.genus());
                ++sum.shells;
            }
            const EulerCounts all = mesh.counts();
            ASSERT_EQ(all.shells - all.genus(), walker.shells_less_handles);
            ASSERT_EQ(all.vertices, n(mesh.n_vertices()));
            ASSERT_EQ(all.edges, n(mesh.n_edges()));
            ASSERT_EQ(all.loops, n(mesh.n_loops()));
        }
        EXPECT_GT(done, steps / 4);
        EXPECT_GT(most_handles, 1);
    }
}
