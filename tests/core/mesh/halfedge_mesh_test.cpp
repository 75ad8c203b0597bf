#include "genus/mesh/halfedge_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/mesh/topology.h"

using namespace genus;

namespace {

std::string refusal(const PolygonMesh& mesh)
{
    try {
        HalfedgeMesh halfedges(mesh);
    } catch (const InvalidInput& e) {
        return e.what();
    }
    return "accepted";
}

}  // namespace

TEST(HalfedgeMesh, GivesBackWhatItWasMadeFrom)
{
    for (const IndexedMesh& mesh : {cases::box(), cases::octasphere(3), cases::torus(9, 6),
                                    cases::sheet(3, 4), cases::shuffled(cases::torus(20, 9), 4)}) {
        const HalfedgeMesh halfedges(mesh);
        halfedges.check();
        EXPECT_EQ(halfedges.to_polygons(), to_polygons(mesh));
        EXPECT_EQ(halfedges.to_polygons(), HalfedgeMesh(to_polygons(mesh)).to_polygons());
        const Topology t = topology(mesh);
        EXPECT_EQ(static_cast<std::int64_t>(halfedges.n_edges()), t.edges);
        EXPECT_EQ(static_cast<std::int64_t>(halfedges.boundary_loops().size()), t.boundary_loops);
    }
    const PolygonMesh cube = cases::box_polygons();
    EXPECT_EQ(HalfedgeMesh(cube).to_polygons(), cube);
}

TEST(HalfedgeMesh, RingsAreWhatTheFacesSay)
{
    const PolygonMesh cube = cases::box_polygons();
    const HalfedgeMesh mesh(cube);
    for (std::size_t f = 0; f < 6; ++f) EXPECT_EQ(mesh.degree(Face(f)), 4);
    for (std::size_t v = 0; v < 8; ++v) {
        EXPECT_EQ(mesh.valence(Vertex(v)), 3);
        EXPECT_FALSE(mesh.is_boundary(Vertex(v)));
        std::set<std::int32_t> ring;
        for (const Halfedge h : mesh.outgoing(Vertex(v))) {
            EXPECT_EQ(mesh.from(h), Vertex(v));
            EXPECT_EQ(mesh.next(mesh.previous(h)), h);
            ring.insert(mesh.to(h).index);
            EXPECT_EQ(mesh.find(Vertex(v), mesh.to(h)), h);
        }
        for (int bit : {1, 2, 4}) EXPECT_TRUE(ring.count(static_cast<std::int32_t>(v) ^ bit));
    }
    EXPECT_FALSE(mesh.find(Vertex(0), Vertex(7)).valid());
}

TEST(HalfedgeMesh, BoundaryRunsOnceRound)
{
    IndexedMesh sheet = cases::sheet(4, 3);
    sheet.vertices.push_back({{9, 9, 9}});
    const HalfedgeMesh mesh(sheet);
    mesh.check();
    ASSERT_EQ(mesh.boundary_loops().size(), 1u);
    std::size_t n = 0;
    for (const Halfedge h : mesh.around(mesh.boundary_loops()[0])) {
        EXPECT_TRUE(mesh.is_boundary(h));
        EXPECT_EQ(mesh.next(mesh.previous(h)), h);
        ++n;
    }
    EXPECT_EQ(n, 14u);
    const Vertex lonely(sheet.n_vertices() - 1);
    EXPECT_FALSE(mesh.halfedge(lonely).valid());
    EXPECT_EQ(mesh.valence(lonely), 0);
    EXPECT_EQ(mesh.valence(Vertex(std::int32_t{0})), 3);
}

TEST(HalfedgeMesh, RefusesWhatIsNoManifoldAndNamesIt)
{
    PolygonMesh mesh = cases::box_polygons();
    mesh.add_face(std::array{0, 1, 7});
    EXPECT_EQ(refusal(mesh), "halfedges: edge 0-1 has 3 faces");

    mesh = cases::box_polygons();
    std::reverse(mesh.corners.begin() + 4, mesh.corners.begin() + 8);
    EXPECT_NE(refusal(mesh).find("run the same way along edge"), std::string::npos);

    mesh = cases::box_polygons();
    mesh.add_face(std::array{1, 2, 1});
    EXPECT_EQ(refusal(mesh), "halfedges: face 6 has fewer than three corners or a vertex twice");

    mesh = cases::box_polygons();
    for (int i = 0; i < 2; ++i) mesh.vertices.push_back({{5.0, 1.0 * i, 5}});
    mesh.add_face(std::array{7, 8, 9});
    EXPECT_EQ(refusal(mesh), "halfedges: vertex 7 has 2 fans of faces");

    mesh = cases::box_polygons();
    mesh.corners[2] = 8;
    EXPECT_NE(refusal(mesh).find("names vertex 8 of 8"), std::string::npos);

    // Two fans that both end in the boundary, in both layouts.
    IndexedMesh bow{{{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{-1, 0, 0}}, {{-1, -1, 0}}},
                    {{0, 1, 2}, {0, 3, 4}}};
    EXPECT_EQ(refusal(to_polygons(bow)), "halfedges: vertex 0 has 2 fans of faces");
    EXPECT_THROW(TriangleHalfedgeMesh{bow}, InvalidInput);
}

TEST(HalfedgeMesh, PropertiesFollowTheElements)
{
    HalfedgeMesh mesh(cases::box_polygons());
    auto weight = mesh.add_vertex_property<double>("weight", 2.5);
    auto label = mesh.add_face_property<std::string>("label");
    weight[Vertex(std::int32_t{3})] = 7;
    label[Face(std::int32_t{5})] = "right";
    const HalfedgeMesh copy = mesh;
    weight[Vertex(std::int32_t{3})] = 8;
    EXPECT_EQ(copy.vertex_properties().get<double>("weight")[Vertex(std::int32_t{3})], 7);
    EXPECT_EQ(copy.vertex_properties().get<double>("weight")[Vertex(std::int32_t{0})], 2.5);
    EXPECT_EQ(copy.face_properties().get<std::string>("label")[Face(std::int32_t{5})], "right");
    EXPECT_THROW(mesh.add_vertex_property<int>("weight"), InvalidInput);
    EXPECT_THROW(copy.vertex_properties().get<float>("weight"), InvalidInput);
}

TEST(HalfedgeMesh, TakesTheMemoryOfTheNotes)
{
    // 100,000 vertices, closed: 120 bytes a vertex at 4-byte numbers; directed edges 76 at 8-byte
    // coordinates.
    const IndexedMesh mesh = cases::torus(400, 250);
    const double n = static_cast<double>(mesh.n_vertices());
    EXPECT_NEAR(HalfedgeMesh(mesh).memory_bytes(4) / n, 120, 6);
    EXPECT_LE(TriangleHalfedgeMesh(mesh).memory_bytes() / n, 76);
}

TEST(TriangleHalfedgeMesh, HasTheRingsOfTheExplicitLayout)
{
    for (const IndexedMesh& mesh :
         {cases::octasphere(3), cases::sheet(5, 4), cases::shuffled(cases::sheet(9, 9), 2)}) {
        const HalfedgeMesh explicit_layout(mesh);
        const TriangleHalfedgeMesh directed(mesh);
        for (std::size_t i = 0; i < mesh.n_vertices(); ++i) {
            const Vertex v(i);
            std::vector<std::int32_t> a, b;
            for (const Halfedge h : explicit_layout.outgoing(v))
                a.push_back(explicit_layout.to(h).index);
            directed.visit_ring(v, [&](Vertex w) { b.push_back(w.index); });
            EXPECT_EQ(directed.is_boundary(v), explicit_layout.is_boundary(v));
            // One turns clockwise, the other counterclockwise.
            std::reverse(b.begin(), b.end());
            ASSERT_EQ(a.size(), b.size());
            std::rotate(b.begin(), std::find(b.begin(), b.end(), a[0]), b.end());
            EXPECT_EQ(a, b);
        }
        for (std::size_t i = 0; i < directed.n_halfedges(); ++i) {
            const Halfedge h(i), o = directed.opposite(h);
            if (!o.valid()) continue;
            EXPECT_EQ(directed.opposite(o), h);
            EXPECT_EQ(directed.from(o), directed.to(h));
        }
    }
}

TEST(TriangleHalfedgeMesh, IsBuiltAndWalkedFast)
{
    const bool full = std::getenv("GENUS_LONG") != nullptr;
    IndexedMesh mesh = full ? cases::torus(1000, 1000) : cases::torus(200, 200);
    const double t0 = seconds_now();
    const TriangleHalfedgeMesh halfedges(std::move(mesh));
    const double t1 = seconds_now();
    Vec3 sum;
    for (std::size_t v = 0; v < halfedges.n_vertices(); ++v)
        halfedges.visit_ring(Vertex(v), [&](Vertex w) { sum += halfedges.point(w); });
    RecordProperty("build", std::to_string(t1 - t0));
    RecordProperty("rings", std::to_string(seconds_now() - t1));
    EXPECT_NEAR(norm(sum), 0, 1e-6);
}
