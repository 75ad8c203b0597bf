#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/mesh/face_mesh.h"
#include "genus/mesh/halfedge_mesh.h"
#include "genus/mesh/strips.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/triangle_list.h"
#include "genus/mesh/winged_edge_mesh.h"

using namespace genus;

namespace {

// The faces as points, each begun with its smallest corner, sorted: equal for equal surfaces.
std::vector<std::array<std::array<double, 3>, 3>> surface(const IndexedMesh& mesh)
{
    std::vector<std::array<std::array<double, 3>, 3>> faces;
    for (const Triangle& t : mesh.faces) {
        std::array<std::array<double, 3>, 3> face;
        for (int i = 0; i < 3; ++i) face[i] = mesh.vertices[t[i]].c;
        std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
        faces.push_back(face);
    }
    std::sort(faces.begin(), faces.end());
    return faces;
}

std::vector<IndexedMesh> some_meshes()
{
    return {cases::tetrahedron(), cases::box(),
            cases::octasphere(4), cases::torus(30, 20),
            cases::sheet(7, 5),   cases::shuffled(cases::torus(25, 14), 5),
            cases::globe(50, 20), cases::shuffled(cases::sheet(20, 20), 6)};
}

}  // namespace

TEST(StorageForms, TakeTheMemoryOfTheNotes)
{
    // At 4-byte numbers on a closed mesh of 100,000 vertices, within 5 in 100.
    const IndexedMesh mesh = cases::torus(400, 250);
    const double n = static_cast<double>(mesh.n_vertices());
    const auto expect = [&](std::size_t bytes, double notes) {
        EXPECT_NEAR(static_cast<double>(bytes) / n, notes, 0.05 * notes);
    };
    expect(to_triangle_list(mesh).memory_bytes(4), 72);
    expect(memory_bytes(mesh, 4), 36);
    expect(FaceMesh(mesh).memory_bytes(4), 64);
    expect(WingedEdgeMesh(to_polygons(mesh)).memory_bytes(4), 120);
    expect(HalfedgeMesh(mesh).memory_bytes(4), 120);
    const TriangleStrips strips = to_strips(mesh);
    expect(strips.memory_bytes(4), 24 + 24 * static_cast<double>(strips.n_strips()) / n);
}

TEST(TriangleList, ComesBackAsTheSameSurface)
{
    for (const IndexedMesh& mesh : some_meshes()) {
        const IndexedMesh back = to_indexed(to_triangle_list(mesh));
        EXPECT_EQ(surface(back), surface(mesh));
        EXPECT_EQ(back.n_vertices(), mesh.n_vertices());
        EXPECT_EQ(topology(back).genus, topology(mesh).genus);
    }
}

TEST(TriangleList, JoinsZeroAndMinusZeroAndRefusesNaN)
{
    TriangleList list;
    list.triangles.push_back({{{{0.0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}}});
    list.triangles.push_back({{{{-0.0, 0, -0.0}}, {{0, 1, 0}}, {{-1, 0, 0}}}});
    EXPECT_EQ(to_indexed(list).n_vertices(), 4u);
    list.triangles[0][1][2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(to_indexed(list), InvalidInput);
}

TEST(TriangleStrips, KeepEveryFaceAsItTurns)
{
    for (const IndexedMesh& mesh : some_meshes()) {
        const TriangleStrips strips = to_strips(mesh);
        EXPECT_EQ(strips.n_faces(), mesh.n_faces());
        EXPECT_EQ(surface(to_indexed(strips)), surface(mesh));
    }
    // Not manifold, not oriented, a face twice: kept all the same.
    IndexedMesh odd = cases::octasphere(2);
    std::swap(odd.faces[5][0], odd.faces[5][1]);
    odd.faces.push_back(odd.faces[9]);
    odd.faces.push_back({0, 1, 2});
    EXPECT_EQ(surface(to_indexed(to_strips(odd))), surface(odd));
    EXPECT_EQ(to_strips({}).n_strips(), 0u);
    EXPECT_EQ(to_strips({}).n_faces(), 0u);
}

TEST(TriangleStrips, AreFew)
{
    // A regular torus falls into long strips; an icosphere-like mesh still into some dozens a
    // strip.
    EXPECT_GT(to_strips(cases::torus(100, 100)).triangles_per_strip(), 100);
    const double sphere = to_strips(cases::octasphere(6)).triangles_per_strip();
    RecordProperty("octasphere", std::to_string(sphere));
    EXPECT_GT(sphere, 20);
}

TEST(FaceMesh, NeighboursShareTheirSide)
{
    for (const IndexedMesh& mesh : some_meshes()) {
        const FaceMesh faces(mesh);
        std::int64_t open = 0;
        for (std::size_t f = 0; f < mesh.n_faces(); ++f)
            for (std::size_t i = 0; i < 3; ++i) {
                const Face g = faces.neighbour(Face(f), i);
                open += !g.valid();
                if (!g.valid()) continue;
                const Vertex a = faces.corner(Face(f), i), b = faces.corner(Face(f), (i + 1) % 3);
                bool found = false;
                for (std::size_t j = 0; j < 3; ++j)
                    found |= faces.corner(g, j) == b && faces.corner(g, (j + 1) % 3) == a &&
                             faces.neighbour(g, j) == Face(f);
                EXPECT_TRUE(found);
            }
        EXPECT_EQ(open, topology(mesh).boundary_edges);
    }
}

TEST(FaceMesh, FansHoldAllFacesOfAVertex)
{
    for (const IndexedMesh& mesh : some_meshes()) {
        std::vector<std::set<std::int32_t>> expected(mesh.n_vertices());
        for (std::size_t f = 0; f < mesh.n_faces(); ++f)
            for (const std::int32_t v : mesh.faces[f])
                expected[v].insert(static_cast<std::int32_t>(f));
        const FaceMesh faces(mesh);
        for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
            std::vector<std::int32_t> fan;
            faces.visit_faces(Vertex(v), [&](Face f) { fan.push_back(f.index); });
            std::sort(fan.begin(), fan.end());
            EXPECT_TRUE(std::equal(fan.begin(), fan.end(), expected[v].begin(), expected[v].end()));
        }
    }
}

TEST(FaceMesh, IsBuiltFromAStreamOfTriangles)
{
    const IndexedMesh mesh = cases::shuffled(cases::torus(30, 21), 8);
    FaceMeshBuilder builder;
    std::size_t most_open = 0;
    for (const auto& triangle : to_triangle_list(mesh).triangles) {
        builder.add(triangle);
        most_open = std::max(most_open, builder.n_open_sides());
    }
    EXPECT_EQ(builder.n_open_sides(), 0u);
    EXPECT_GT(most_open, 0u);
    const FaceMesh faces = builder.finish();
    EXPECT_EQ(surface(faces.indexed()), surface(mesh));
    EXPECT_EQ(faces.n_vertices(), mesh.n_vertices());
}

TEST(FaceMesh, RefusesFacesThatDisagree)
{
    IndexedMesh mesh = cases::box();
    std::swap(mesh.faces[3][0], mesh.faces[3][1]);
    EXPECT_THROW(FaceMesh{mesh}, InvalidInput);
    FaceMeshBuilder builder;
    const Vec3 a{{0, 0, 0}}, b{{1, 0, 0}}, c{{0, 1, 0}}, d{{0, 0, 1}};
    builder.add({a, b, c});
    EXPECT_THROW(builder.add({a, b, d}), InvalidInput);
    EXPECT_THROW(builder.add({a, a, d}), InvalidInput);
    builder.add({b, a, d});
    EXPECT_EQ(builder.n_open_sides(), 4u);
    EXPECT_EQ(builder.finish().n_faces(), 2u);
}

TEST(WingedEdgeMesh, GivesBackWhatItWasMadeFrom)
{
    for (const IndexedMesh& mesh : some_meshes()) {
        const PolygonMesh polygons = to_polygons(mesh);
        const WingedEdgeMesh winged(polygons);
        EXPECT_EQ(static_cast<std::int64_t>(winged.n_edges()), topology(mesh).edges);
        const PolygonMesh back = winged.to_polygons();
        EXPECT_EQ(surface(to_triangles(back)), surface(mesh));
    }
    const WingedEdgeMesh cube(cases::box_polygons());
    EXPECT_EQ(cube.n_edges(), 12u);
    EXPECT_EQ(topology(cube.to_polygons()).euler, 2);
}

TEST(WingedEdgeMesh, WingsFollowEachOther)
{
    for (const PolygonMesh& mesh : {cases::box_polygons(), to_polygons(cases::sheet(4, 3))}) {
        const WingedEdgeMesh winged(mesh);
        const HalfedgeMesh halfedges(mesh);
        for (std::size_t i = 0; i < winged.n_edges(); ++i) {
            const auto& w = winged.wings(Edge(i));
            for (int k = 0; k < 2; ++k) {
                const auto& next = winged.wings(Edge(w.next[k]));
                const int side = next.vertices[0] == w.vertices[1 - k] ? 0 : 1;
                EXPECT_EQ(next.vertices[side], w.vertices[1 - k]);
                EXPECT_EQ(next.faces[side], w.faces[k]);
                EXPECT_EQ(next.previous[side], static_cast<std::int32_t>(i));
            }
        }
        for (std::size_t v = 0; v < winged.n_vertices(); ++v) {
            std::int32_t n = 0;
            winged.visit_vertex(Vertex(v), [&](Edge e) {
                const auto& ends = winged.wings(e).vertices;
                EXPECT_TRUE(ends[0] == static_cast<std::int32_t>(v) ||
                            ends[1] == static_cast<std::int32_t>(v));
                ++n;
            });
            EXPECT_EQ(n, halfedges.valence(Vertex(v)));
        }
    }
}
