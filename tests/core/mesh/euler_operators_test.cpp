#include <gtest/gtest.h>

#include <cstdlib>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/mesh/halfedge_mesh.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"

using namespace genus;

namespace {

std::int64_t euler_number(const HalfedgeMesh& mesh)
{
    return static_cast<std::int64_t>(mesh.n_vertices()) -
           static_cast<std::int64_t>(mesh.n_edges()) + static_cast<std::int64_t>(mesh.n_faces());
}

Halfedge any_halfedge(const HalfedgeMesh& mesh, std::mt19937& random)
{
    while (true) {
        const Halfedge h(random() % mesh.halfedge_slots());
        if (mesh.is_alive(h)) return h;
    }
}

struct Counts {
    std::int64_t vertices, edges, faces;
    bool operator==(const Counts&) const = default;
};

Counts counts(const HalfedgeMesh& mesh)
{
    return {static_cast<std::int64_t>(mesh.n_vertices()), static_cast<std::int64_t>(mesh.n_edges()),
            static_cast<std::int64_t>(mesh.n_faces())};
}

// One random step if it is legal; the change of counts must be that of the operator.
bool step(HalfedgeMesh& mesh, std::mt19937& random, bool grow)
{
    const Counts c = counts(mesh);
    const Halfedge h = any_halfedge(mesh, random);
    const bool triangle = !mesh.is_boundary(h) && mesh.degree(mesh.face(h)) == 3;
    const Halfedge o = mesh.opposite(h);
    const bool opposite_triangle = !mesh.is_boundary(o) && mesh.degree(mesh.face(o)) == 3;
    const Vec3 middle = 0.5 * mesh.point(mesh.from(h)) + 0.5 * mesh.point(mesh.to(h));
    switch (random() % 8) {
        case 0: {
            if (mesh.is_boundary(h) || !grow) return false;
            const std::int64_t d = mesh.degree(mesh.face(h));
            mesh.split_face(mesh.face(h), middle);
            EXPECT_EQ(counts(mesh), (Counts{c.vertices + 1, c.edges + d, c.faces + d - 1}));
            return true;
        }
        case 1: {
            if (!grow) return false;
            mesh.split_edge(h, middle);
            const std::int64_t cuts = triangle + opposite_triangle;
            EXPECT_EQ(counts(mesh), (Counts{c.vertices + 1, c.edges + 1 + cuts, c.faces + cuts}));
            return true;
        }
        case 2:
            if (!mesh.can_join_faces(h)) return false;
            mesh.join_faces(h);
            EXPECT_EQ(counts(mesh), (Counts{c.vertices, c.edges - 1, c.faces - 1}));
            return true;
        case 3: {
            Halfedge other = h;
            for (unsigned n = 2 + random() % 3; n > 0; --n) other = mesh.next(other);
            if (!mesh.can_split_face(h, other)) return false;
            mesh.split_face(h, other);
            EXPECT_EQ(counts(mesh), (Counts{c.vertices, c.edges + 1, c.faces + 1}));
            return true;
        }
        case 4:
        case 5:
            if (!mesh.can_flip_edge(h)) return false;
            mesh.flip_edge(h);
            EXPECT_EQ(counts(mesh), c);
            return true;
        default: {
            if (!mesh.can_collapse_edge(h)) return false;
            mesh.collapse_edge(h);
            const std::int64_t gone = triangle + opposite_triangle;
            EXPECT_EQ(counts(mesh), (Counts{c.vertices - 1, c.edges - 1 - gone, c.faces - gone}));
            return true;
        }
    }
}

}  // namespace

TEST(EulerOperators, FlipAndBackIsTheSameMesh)
{
    HalfedgeMesh mesh(cases::octasphere(2));
    std::mt19937 random(1);
    for (int i = 0; i < 200; ++i) {
        const Halfedge h = any_halfedge(mesh, random);
        if (!mesh.can_flip_edge(h)) continue;
        const Vertex a = mesh.from(h), b = mesh.to(h);
        mesh.flip_edge(h);
        mesh.check();
        EXPECT_FALSE(mesh.find(a, b).valid());
        for (int k = 0; k < 3; ++k) mesh.flip_edge(h);
        EXPECT_EQ(mesh.from(h), a);
        EXPECT_EQ(mesh.to(h), b);
        mesh.check();
    }
}

TEST(EulerOperators, SplitsKeepShapeAndVolume)
{
    HalfedgeMesh mesh(cases::box());
    std::mt19937 random(2);
    for (int i = 0; i < 300; ++i) {
        const Halfedge h = any_halfedge(mesh, random);
        const Vec3 &p = mesh.point(mesh.from(h)), &q = mesh.point(mesh.to(h));
        if (i % 2 == 0) {
            mesh.split_edge(h, 0.5 * p + 0.5 * q);
        } else {
            const Vec3& r = mesh.point(mesh.to(mesh.next(h)));
            mesh.split_face(mesh.face(h), 0.25 * p + 0.25 * q + 0.5 * r);
        }
    }
    mesh.check();
    const IndexedMesh triangles = to_triangles(mesh.to_polygons());
    EXPECT_NEAR(volume(triangles), 1, 1e-12);
    EXPECT_NEAR(area(triangles), 6, 1e-12);
    EXPECT_EQ(topology(triangles).genus, 0);
}

TEST(EulerOperators, SplitAndJoinUndoEachOther)
{
    HalfedgeMesh mesh(cases::box_polygons());
    const PolygonMesh before = mesh.to_polygons();
    for (std::size_t f = 0; f < 6; ++f) {
        const Halfedge h = mesh.halfedge(Face(f));
        const Halfedge cut = mesh.split_face(h, mesh.next(mesh.next(h)));
        EXPECT_EQ(mesh.n_faces(), 7u);
        mesh.check();
        mesh.join_faces(cut);
        mesh.check();
    }
    mesh.compact();
    mesh.check();
    EXPECT_EQ(mesh.n_faces(), 6u);
    EXPECT_EQ(mesh.face_slots(), 6u);
    EXPECT_EQ(volume(to_triangles(mesh.to_polygons())), 1);
    EXPECT_EQ(topology(mesh.to_polygons()).edges, topology(before).edges);
}

TEST(EulerOperators, RefuseWhatWouldBreakTheMesh)
{
    // A tetrahedron: nothing can be flipped, collapsed or joined.
    HalfedgeMesh mesh(cases::tetrahedron());
    for (std::size_t i = 0; i < mesh.halfedge_slots(); ++i) {
        EXPECT_THROW(mesh.flip_edge(Halfedge(i)), InvalidInput);
        EXPECT_THROW(mesh.collapse_edge(Halfedge(i)), InvalidInput);
        EXPECT_THROW(mesh.split_face(Halfedge(i), mesh.next(Halfedge(i))), InvalidInput);
    }
    mesh.check();
    EXPECT_EQ(mesh.to_polygons(), to_polygons(cases::tetrahedron()));
    // An inner edge between two boundary vertices.
    HalfedgeMesh strip(cases::sheet(3, 1));
    for (std::size_t i = 0; i < strip.halfedge_slots(); ++i) {
        const Halfedge h(i);
        if (strip.is_boundary(h) || strip.is_boundary(strip.opposite(h))) continue;
        EXPECT_FALSE(strip.can_collapse_edge(h));
    }
    // The three-sided waist of a narrow torus.
    const HalfedgeMesh waist(cases::torus(8, 3));
    for (std::int32_t i = 0; i < 24; i += 3) {
        const Halfedge h = waist.find(Vertex(i), Vertex(i + 1));
        ASSERT_TRUE(h.valid());
        EXPECT_FALSE(waist.can_collapse_edge(h));
    }
}

TEST(EulerOperators, CollapseASphereToATetrahedron)
{
    HalfedgeMesh mesh(cases::octasphere(3));
    std::mt19937 random(4);
    for (int tries = 0; mesh.n_vertices() > 4 && tries < 200'000; ++tries) {
        const Halfedge h = any_halfedge(mesh, random);
        if (mesh.can_collapse_edge(h)) mesh.collapse_edge(h);
    }
    mesh.check();
    mesh.compact();
    mesh.check();
    EXPECT_EQ(counts(mesh), (Counts{4, 6, 4}));
}

TEST(EulerOperators, RandomSequencesKeepEveryInvariant)
{
    const int steps = std::getenv("GENUS_LONG") ? 1'000'000 : 20'000;
    const std::vector<PolygonMesh> starts{
        cases::box_polygons(), to_polygons(cases::torus(8, 6)), to_polygons(cases::sheet(6, 5)),
        to_polygons(cases::together(cases::torus(6, 5), cases::octasphere(1)))};
    for (std::size_t s = 0; s < starts.size(); ++s) {
        SCOPED_TRACE("start and seed " + std::to_string(s));
        std::mt19937 random(static_cast<std::uint32_t>(s));
        HalfedgeMesh mesh(starts[s]);
        const Topology before = topology(starts[s]);
        auto born = mesh.add_vertex_property<double>("x");
        for (std::size_t v = 0; v < mesh.vertex_slots(); ++v)
            born[Vertex(v)] = mesh.point(Vertex(v))[0];
        int done = 0;
        for (int i = 0; i < steps; ++i) {
            done += step(mesh, random, mesh.n_vertices() < 400);
            ASSERT_EQ(euler_number(mesh), before.euler);
            if (i % (steps / 20) == 0) {
                ASSERT_NO_THROW(mesh.check());
                mesh.compact();
                ASSERT_NO_THROW(mesh.check());
                ASSERT_EQ(mesh.vertex_slots(), mesh.n_vertices());
            }
        }
        EXPECT_GT(done, steps / 10);
        const Topology after = topology(mesh.to_polygons());
        EXPECT_EQ(after.euler, before.euler);
        EXPECT_EQ(after.genus, before.genus);
        EXPECT_EQ(after.boundary_loops, before.boundary_loops);
        EXPECT_EQ(after.components.size(), before.components.size());
        EXPECT_TRUE(after.manifold && after.oriented);
        EXPECT_TRUE(after.degenerate_faces.empty());
        // The property went along with its vertex, or is the default of a new one.
        for (std::size_t v = 0; v < mesh.vertex_slots(); ++v)
            if (mesh.is_alive(Vertex(v))) {
                EXPECT_TRUE(born[Vertex(v)] == 0 || born[Vertex(v)] == mesh.point(Vertex(v))[0]);
            }
    }
}
