#include "genus/mesh/repair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/triangle_list.h"
#include "genus/mesh/validate.h"

using namespace genus;

namespace {

// Every face with vertices of its own.
IndexedMesh soup(const IndexedMesh& mesh)
{
    IndexedMesh out;
    for (const auto& triangle : to_triangle_list(mesh).triangles) {
        const auto n = static_cast<std::int32_t>(out.n_vertices());
        out.vertices.insert(out.vertices.end(), triangle.begin(), triangle.end());
        out.faces.push_back({n, n + 1, n + 2});
    }
    return out;
}

void turn_some(IndexedMesh& mesh, std::mt19937& random)
{
    for (Triangle& t : mesh.faces)
        if (random() % 2) std::swap(t[0], t[1]);
}

}  // namespace

TEST(Weld, JoinsEqualPointsOfASoup)
{
    const IndexedMesh mesh = cases::octasphere(3);
    const IndexedMesh welded = weld(soup(mesh));
    EXPECT_EQ(welded.n_vertices(), mesh.n_vertices());
    EXPECT_TRUE(validate(welded).ok());
}

TEST(Weld, MovesNoPointFartherThanTheTolerance)
{
    std::mt19937 random(5);
    IndexedMesh noisy = soup(cases::octasphere(3));
    for (Vec3& p : noisy.vertices) p += cases::point_in_cube(random, -1e-7, 1e-7);
    const IndexedMesh welded = weld(noisy, 1e-6);
    EXPECT_EQ(welded.n_vertices(), cases::octasphere(3).n_vertices());
    EXPECT_TRUE(is_closed(welded));
    for (std::size_t f = 0; f < noisy.n_faces(); ++f)
        for (std::size_t i = 0; i < 3; ++i)
            EXPECT_LE(
                distance(noisy.vertices[noisy.faces[f][i]], welded.vertices[welded.faces[f][i]]),
                1e-6);
    // Kept points are farther apart than the tolerance.
    const IndexedMesh coarse = weld(cases::octasphere(4), 0.2);
    for (std::size_t a = 0; a < coarse.n_vertices(); ++a)
        for (std::size_t b = 0; b < a; ++b)
            EXPECT_GT(distance(coarse.vertices[a], coarse.vertices[b]), 0.2);
}

TEST(Weld, DropsUnusedVerticesAndRefusesNonsense)
{
    IndexedMesh mesh = cases::box();
    mesh.vertices.insert(mesh.vertices.begin(), Vec3{{9, 9, 9}});
    for (Triangle& t : mesh.faces)
        for (std::int32_t& v : t) ++v;
    EXPECT_EQ(weld(mesh).n_vertices(), 8u);
    EXPECT_EQ(weld({}, 1).n_vertices(), 0u);
    EXPECT_THROW(weld(mesh, -1), InvalidInput);
    EXPECT_THROW(weld(mesh, std::nan("")), InvalidInput);
    EXPECT_THROW(weld(mesh, 1e-300), InvalidInput);
    mesh.vertices[3][0] = std::numeric_limits<double>::infinity();
    EXPECT_THROW(weld(mesh), InvalidInput);
}

TEST(Repair, MendsAShatteredSphere)
{
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const IndexedMesh good = cases::octasphere(3);
        IndexedMesh mesh = soup(good);
        turn_some(mesh, random);
        mesh.faces.push_back({0, 0, 1});
        mesh.faces.push_back(mesh.faces[7]);
        // A hole of one face, far from another of a whole fan round a vertex.
        const Vec3 pole{{0, 0, 1}};
        const std::size_t before = mesh.n_faces();
        std::erase_if(mesh.faces, [&](const Triangle& t) {
            return mesh.vertices[t[0]] == pole || mesh.vertices[t[1]] == pole ||
                   mesh.vertices[t[2]] == pole;
        });
        const std::size_t missing = before - mesh.n_faces();
        const RepairedMesh repaired = repair(mesh);
        const Validation v = validate(repaired.mesh);
        EXPECT_TRUE(v.ok()) << v.findings.front().text;
        EXPECT_EQ(v.topology.genus, 0);
        EXPECT_EQ(repaired.report.degenerate_faces, 1);
        EXPECT_EQ(repaired.report.duplicate_faces, 1);
        EXPECT_EQ(repaired.report.closed_holes, 1);
        EXPECT_EQ(repaired.report.added_faces, static_cast<std::int64_t>(missing) - 2);
        EXPECT_EQ(repaired.report.open_edges, 0);
        EXPECT_NEAR(volume(repaired.mesh), volume(good), 0.01);
    }
}

TEST(Repair, TurnsShellsOutwardAndCavitiesInward)
{
    std::mt19937 random(3);
    IndexedMesh mesh = cases::together(cases::octasphere(3, 3), cases::octasphere(3, 2));
    mesh = cases::together(mesh, cases::octasphere(2, 1));
    mesh = cases::together(mesh, cases::moved(cases::box(), translation({{9, 0, 0}})));
    turn_some(mesh, random);
    const RepairedMesh repaired = repair(mesh);
    EXPECT_TRUE(validate(repaired.mesh).ok());
    const double third = volume(cases::octasphere(3, 3)) - volume(cases::octasphere(3, 2)) +
                         volume(cases::octasphere(2, 1)) + 1;
    EXPECT_NEAR(volume(repaired.mesh), third, 1e-10);
}

TEST(Repair, LeavesGoodMeshesAsTheyAre)
{
    for (const IndexedMesh& mesh : {cases::box(), cases::torus(12, 9), cases::octasphere(3)}) {
        const RepairedMesh repaired = repair(mesh);
        EXPECT_EQ(repaired.mesh, mesh);
        EXPECT_EQ(repaired.report.turned_faces, 0);
        EXPECT_EQ(repaired.report.split_vertices, 0);
    }
    EXPECT_EQ(repair({}).mesh.n_faces(), 0u);
}

TEST(Repair, CutsApartAtComplexEdgesAndVertices)
{
    // Two boxes that share an edge: welded it has four faces.
    const IndexedMesh two =
        cases::together(cases::box(), cases::moved(cases::box(), translation({{1, 1, 0}})));
    EXPECT_EQ(topology(weld(two)).complex_edges.size(), 1u);
    RepairOptions options;
    options.max_hole = 0;
    const Topology t = topology(repair(two, options).mesh);
    EXPECT_TRUE(t.manifold);
    EXPECT_EQ(t.faces, 24);
    // Two that share a corner come apart as two closed boxes.
    const IndexedMesh corner =
        cases::together(cases::box(), cases::moved(cases::box(), translation({{1, 1, 1}})));
    const RepairedMesh apart = repair(corner);
    EXPECT_EQ(apart.report.split_vertices, 1);
    EXPECT_TRUE(validate(apart.mesh).ok());
    EXPECT_EQ(topology(apart.mesh).components.size(), 2u);
}

TEST(Repair, LeavesOneSidedSurfacesAlone)
{
    const IndexedMesh strip = cases::moebius(11);
    RepairOptions options;
    options.max_hole = 0;
    options.non_manifold = NonManifold::Keep;
    const RepairedMesh repaired = repair(strip, options);
    EXPECT_EQ(repaired.mesh, strip);
    EXPECT_FALSE(topology(repaired.mesh).orientable);
}

TEST(Repair, ClosesOnlyHolesThatAreShortEnough)
{
    RepairOptions options;
    options.max_hole = 19;
    EXPECT_EQ(repair(cases::sheet(5, 5), options).report.open_edges, 20);
    options.max_hole = 20;
    const RepairedMesh closed = repair(cases::sheet(5, 5), options);
    EXPECT_EQ(closed.report.open_edges, 0);
    EXPECT_EQ(closed.report.added_faces, 18);
    EXPECT_EQ(topology(closed.mesh).euler, 2);
    options.max_hole = 501;
    EXPECT_THROW(repair(cases::box(), options), InvalidInput);
}

TEST(Repair, FillsAHoleWithTheLeastArea)
{
    // A cup: a box without its lid, the rim bent to a saddle; the two ways to close it differ.
    IndexedMesh cup = cases::box();
    std::erase_if(cup.faces, [&](const Triangle& t) {
        return cup.vertices[t[0]][2] == 1 && cup.vertices[t[1]][2] == 1 &&
               cup.vertices[t[2]][2] == 1;
    });
    ASSERT_EQ(cup.n_faces(), 10u);
    cup.vertices[4][0] = -1;  // stretch one diagonal
    const RepairedMesh repaired = repair(cup);
    EXPECT_EQ(repaired.report.added_faces, 2);
    EXPECT_TRUE(validate(repaired.mesh).topology.closed);
    EXPECT_NEAR(area(repaired.mesh) - area(cup), 1.5, 1e-12);
}

TEST(Repair, CutsFacesAtTJunctions)
{
    // A box whose top is cut finer than its walls: the points on the rim lie within wall edges.
    IndexedMesh box = cases::box();
    IndexedMesh top = cases::moved(cases::sheet(3, 4), scaling({{1.0 / 4, 1.0 / 4, 1}}));
    for (Vec3& p : top.vertices) p[0] *= 4.0 / 3;
    for (Vec3& p : top.vertices)
        if (p[0] > 0.9) p[0] = 1;
    std::erase_if(box.faces, [&](const Triangle& t) {
        return box.vertices[t[0]][2] == 1 && box.vertices[t[1]][2] == 1 &&
               box.vertices[t[2]][2] == 1;
    });
    const IndexedMesh mesh = cases::together(box, cases::moved(top, translation({{0, 0, 1}})));
    EXPECT_FALSE(is_closed(weld(mesh)));
    const RepairedMesh repaired = repair(mesh);
    EXPECT_EQ(repaired.report.t_junctions, 2 * 2 + 2 * 3);
    EXPECT_EQ(repaired.report.closed_holes, 0);
    const Validation v = validate(repaired.mesh);
    EXPECT_TRUE(v.ok()) << v.findings.front().text;
    EXPECT_NEAR(volume(repaired.mesh), 1, 1e-15);

    // Turned, the points are beside the edges by roundings: exact tests say no, a tolerance yes.
    std::mt19937 random(8);
    const IndexedMesh turned = cases::moved(mesh, cases::random_rotation(random));
    RepairOptions options;
    options.max_hole = 0;
    options.weld = 1e-10;
    const RepairedMesh near = repair(turned, options);
    EXPECT_EQ(near.report.t_junctions, 10);
    EXPECT_EQ(near.report.open_edges, 0);
    EXPECT_NEAR(volume(near.mesh), 1, 1e-12);
    options.t_junctions = false;
    EXPECT_GT(repair(turned, options).report.open_edges, 0);
}

TEST(Repair, DropsNonManifoldElements)
{
    RepairOptions options;
    options.non_manifold = NonManifold::Drop;
    // A fin on an edge of a sphere goes, the sphere stays.
    IndexedMesh fin = cases::octasphere(3);
    const IndexedMesh good = fin;
    const Triangle t = fin.faces[17];
    fin.vertices.push_back(1.01 * fin.vertices[t[0]]);
    fin.faces.push_back({t[0], t[1], static_cast<std::int32_t>(fin.n_vertices() - 1)});
    const RepairedMesh without = repair(fin, options);
    EXPECT_EQ(without.report.dropped_faces, 1);
    EXPECT_EQ(without.mesh.faces, good.faces);
    EXPECT_TRUE(topology(without.mesh).manifold);
    // Of two boxes joined at a corner one loses its faces there, and its hole is closed again.
    const IndexedMesh corner =
        weld(cases::together(cases::box(), cases::moved(cases::box(), translation({{1, 1, 1}}))));
    ASSERT_EQ(topology(corner).complex_vertices.size(), 1u);
    const RepairedMesh one = repair(corner, options);
    EXPECT_GT(one.report.dropped_faces, 0);
    EXPECT_EQ(one.report.split_vertices, 0);
    const Topology after = topology(one.mesh);
    EXPECT_TRUE(after.manifold && after.closed && after.oriented);
    // Four faces at an edge: two stay.
    const IndexedMesh edge =
        weld(cases::together(cases::box(), cases::moved(cases::box(), translation({{1, 1, 0}}))));
    options.max_hole = 0;
    const RepairedMesh thinned = repair(edge, options);
    EXPECT_EQ(topology(edge).complex_edges.size(), 1u);
    EXPECT_TRUE(topology(thinned.mesh).manifold);
    EXPECT_LT(thinned.mesh.n_faces(), edge.n_faces());
}
