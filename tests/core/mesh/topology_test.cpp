#include "genus/mesh/topology.h"

#include <gtest/gtest.h>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"

using namespace genus;

namespace {

void expect_closed_of_genus(const IndexedMesh& mesh, std::int64_t genus)
{
    const Topology t = topology(mesh);
    EXPECT_TRUE(t.closed && t.oriented && t.orientable && t.manifold);
    EXPECT_EQ(t.components.size(), 1u);
    EXPECT_EQ(t.euler, 2 - 2 * genus);
    EXPECT_EQ(t.genus, genus);
    EXPECT_EQ(3 * t.faces, 2 * t.edges);
    EXPECT_EQ(t.boundary_loops, 0);
    EXPECT_DOUBLE_EQ(t.mean_valence, 2.0 * t.edges / t.vertices);
    EXPECT_TRUE(is_closed(mesh));
    EXPECT_TRUE(is_oriented(mesh));
}

}  // namespace

TEST(Topology, KnowsTheGenusOfClosedSurfaces)
{
    expect_closed_of_genus(cases::tetrahedron(), 0);
    expect_closed_of_genus(cases::box(), 0);
    expect_closed_of_genus(cases::octasphere(4), 0);
    expect_closed_of_genus(cases::globe(17, 9), 0);
    expect_closed_of_genus(cases::torus(7, 5), 1);
    expect_closed_of_genus(cases::shuffled(cases::torus(40, 30), 1), 1);
}

TEST(Topology, MeanValenceOfATorusIsSix)
{
    const Topology t = topology(cases::torus(12, 9));
    EXPECT_EQ(t.mean_valence, 6.0);
    EXPECT_EQ(t.least_valence, 6);
    EXPECT_EQ(t.greatest_valence, 6);
    EXPECT_EQ(t.valences[6], t.vertices);
    EXPECT_EQ(t.edges, 3 * t.vertices);
    EXPECT_EQ(t.faces, 2 * t.vertices);
}

TEST(Topology, CountsLongFansInTheLastValence)
{
    const Topology t = topology(cases::globe(100, 3));
    EXPECT_EQ(t.greatest_valence, 100);
    EXPECT_EQ(t.valences.back(), 2);  // the poles
    std::int64_t sum = 0;
    for (const std::int64_t n : t.valences) sum += n;
    EXPECT_EQ(sum, t.vertices);
}

TEST(Topology, AddsUpComponentsInOrderOfVertices)
{
    IndexedMesh mesh = cases::together(cases::torus(6, 5), cases::box());
    mesh = cases::together(mesh, cases::sheet(2, 3));
    mesh.vertices.push_back({{9, 9, 9}});
    const Topology t = topology(mesh);
    ASSERT_EQ(t.components.size(), 3u);
    EXPECT_EQ(t.components[0].genus, 1);
    EXPECT_EQ(t.components[1].genus, 0);
    EXPECT_EQ(t.components[2].genus, 0);
    EXPECT_FALSE(t.components[2].closed);
    EXPECT_EQ(t.components[2].boundary_loops, 1);
    EXPECT_EQ(t.components[2].boundary_edges, 10);
    EXPECT_EQ(t.genus, 1);
    EXPECT_EQ(t.euler, 0 + 2 + 1);
    EXPECT_EQ(t.isolated_vertices, 1);
    EXPECT_EQ(t.component_of_vertex.front(), 0);
    EXPECT_EQ(t.component_of_vertex.back(), -1);
}

TEST(Topology, CountsBoundaryLoops)
{
    IndexedMesh mesh = cases::torus(12, 12);
    // Faces far apart: no two holes share a vertex.
    for (const std::size_t face : {20u, 100u, 180u}) mesh.faces.erase(mesh.faces.begin() + face);
    const Topology t = topology(mesh);
    EXPECT_EQ(t.boundary_loops, 3);
    EXPECT_EQ(t.boundary_edges, 9);
    EXPECT_EQ(t.open_edges.size(), 9u);
    EXPECT_EQ(t.genus, 1);
    EXPECT_TRUE(t.manifold);
    EXPECT_FALSE(is_closed(mesh));
}

TEST(Topology, HolesThatTouchInAVertexAreTwoLoops)
{
    IndexedMesh mesh = cases::sheet(4, 4);
    // The upper left and lower right square at the middle vertex.
    std::erase_if(mesh.faces, [&](const Triangle& t) {
        const Vec3 c = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
        return (c[0] > 1 && c[0] < 2 && c[1] > 1 && c[1] < 2) ||
               (c[0] > 2 && c[0] < 3 && c[1] > 2 && c[1] < 3);
    });
    const Topology t = topology(mesh);
    ASSERT_EQ(t.complex_vertices.size(), 1u);
    EXPECT_EQ(t.complex_vertices[0], (ComplexVertex{12, 2}));
    // Seen from the faces, the way round goes from one hole on along the other.
    EXPECT_EQ(t.boundary_loops, 2);
    EXPECT_FALSE(t.manifold);
    EXPECT_FALSE(t.genus.has_value());
}

TEST(Topology, MoebiusStripIsOneSided)
{
    const Topology t = topology(cases::moebius(9));
    EXPECT_EQ(t.euler, 0);
    EXPECT_EQ(t.boundary_loops, 1);
    EXPECT_TRUE(t.manifold);
    EXPECT_FALSE(t.orientable);
    EXPECT_FALSE(t.oriented);
    EXPECT_FALSE(t.genus.has_value());
    EXPECT_EQ(t.flipped_edges.size(), 1u);
}

TEST(Topology, NamesAFlippedFace)
{
    IndexedMesh mesh = cases::octasphere(2);
    std::swap(mesh.faces[37][0], mesh.faces[37][1]);
    const Topology t = topology(mesh);
    EXPECT_FALSE(t.oriented);
    EXPECT_TRUE(t.orientable);
    EXPECT_EQ(t.genus, 0);
    ASSERT_EQ(t.flipped_edges.size(), 3u);
    for (const FlippedEdge& e : t.flipped_edges) EXPECT_TRUE(e.faces[0] == 37 || e.faces[1] == 37);
    EXPECT_FALSE(is_oriented(mesh));
}

TEST(Topology, NamesAComplexEdge)
{
    IndexedMesh mesh = cases::box();
    const Triangle t0 = mesh.faces[4];
    mesh.vertices.push_back({{5, 5, 5}});
    mesh.faces.push_back({t0[0], t0[1], 8});
    const Topology t = topology(mesh);
    ASSERT_EQ(t.complex_edges.size(), 1u);
    EXPECT_EQ(t.complex_edges[0].a, std::min(t0[0], t0[1]));
    EXPECT_EQ(t.complex_edges[0].b, std::max(t0[0], t0[1]));
    EXPECT_EQ(t.complex_edges[0].faces.size(), 3u);
    EXPECT_EQ(t.complex_edges[0].faces.back(), 12);
    EXPECT_TRUE(t.complex_vertices.empty());
    EXPECT_FALSE(t.manifold);
}

TEST(Topology, NamesAComplexVertex)
{
    // Two tetrahedra that share one vertex.
    IndexedMesh mesh = cases::tetrahedron();
    for (const Triangle& t : cases::tetrahedron().faces) {
        Triangle other;
        for (std::size_t i = 0; i < 3; ++i) other[i] = t[i] == 0 ? 0 : t[i] + 3;
        mesh.faces.push_back(other);
    }
    for (const Vec3& p : {Vec3{{-1, 0, 0}}, Vec3{{0, -1, 0}}, Vec3{{0, 0, -1}}})
        mesh.vertices.push_back(p);
    const Topology t = topology(mesh);
    ASSERT_EQ(t.complex_vertices.size(), 1u);
    EXPECT_EQ(t.complex_vertices[0], (ComplexVertex{0, 2}));
    EXPECT_TRUE(t.complex_edges.empty());
    EXPECT_TRUE(t.closed);
    EXPECT_FALSE(t.manifold);
    EXPECT_EQ(t.components.size(), 1u);
    EXPECT_EQ(t.euler, 3);
}

TEST(Topology, LeavesOutFacesThatNameAVertexTwice)
{
    IndexedMesh mesh = cases::box();
    mesh.faces.insert(mesh.faces.begin() + 3, Triangle{2, 2, 5});
    const Topology t = topology(mesh);
    EXPECT_EQ(t.degenerate_faces, std::vector<std::int32_t>{3});
    EXPECT_EQ(t.faces, 12);
    EXPECT_EQ(t.genus, 0);
    EXPECT_TRUE(t.closed && t.manifold);
}

TEST(Topology, TwoFacesBackToBackAreASphere)
{
    const IndexedMesh mesh{{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}}, {{0, 1, 2}, {0, 2, 1}}};
    expect_closed_of_genus(mesh, 0);
}

TEST(Topology, ReadsPolygonsLikeTriangles)
{
    const Topology cube = topology(cases::box_polygons());
    EXPECT_EQ(cube.vertices, 8);
    EXPECT_EQ(cube.edges, 12);
    EXPECT_EQ(cube.faces, 6);
    EXPECT_EQ(cube.genus, 0);
    EXPECT_TRUE(cube.closed && cube.oriented && cube.manifold);

    const IndexedMesh torus = cases::torus(8, 5);
    const Topology a = topology(torus), b = topology(to_polygons(torus));
    EXPECT_EQ(a.edges, b.edges);
    EXPECT_EQ(a.genus, b.genus);
    EXPECT_EQ(a.valences, b.valences);
}

TEST(Topology, RefusesIndicesOutOfRange)
{
    IndexedMesh mesh = cases::box();
    mesh.faces[5][1] = 8;
    EXPECT_THROW(topology(mesh), InvalidInput);
    mesh.faces[5][1] = -1;
    EXPECT_THROW(topology(mesh), InvalidInput);
    PolygonMesh polygons = cases::box_polygons();
    polygons.starts[3] = 1000;
    EXPECT_THROW(topology(polygons), InvalidInput);
}

TEST(Topology, OfNothing)
{
    const Topology t = topology(IndexedMesh{});
    EXPECT_EQ(t.vertices, 0);
    EXPECT_EQ(t.components.size(), 0u);
    EXPECT_TRUE(t.closed);
}

TEST(Topology, IsTheSameOnAnyNumberOfThreads)
{
    const IndexedMesh mesh = cases::shuffled(cases::octasphere(5), 7);
    set_thread_count(1);
    const Topology one = topology(mesh);
    set_thread_count(8);
    const Topology eight = topology(mesh);
    set_thread_count(2);
    EXPECT_EQ(one.euler, eight.euler);
    EXPECT_EQ(one.component_of_vertex, eight.component_of_vertex);
    EXPECT_EQ(one.valences, eight.valences);
}
