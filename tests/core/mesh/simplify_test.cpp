#include "genus/mesh/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/mesh/collapse_mesh.h"
#include "genus/mesh/distance.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/shapes.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"

using namespace genus;

namespace {

SimplifyOptions within(double tolerance)
{
    SimplifyOptions options;
    options.tolerance = tolerance;
    return options;
}

void expect_same_topology(const IndexedMesh& a, const IndexedMesh& b)
{
    const Topology s = topology(a), t = topology(b);
    EXPECT_EQ(s.euler, t.euler);
    EXPECT_EQ(s.genus, t.genus);
    EXPECT_EQ(s.boundary_loops, t.boundary_loops);
    EXPECT_EQ(s.components.size(), t.components.size());
    EXPECT_TRUE(t.manifold && t.oriented);
    EXPECT_EQ(t.isolated_vertices, 0);
}

}  // namespace

TEST(CollapseMesh, DoesWhatTheHalfedgeMeshDoes)
{
    // Random edges drawn together in both, to the end: the same are refused, the same is left.
    using Faces = std::set<std::array<std::int32_t, 3>>;
    const auto turned = [](std::array<std::int32_t, 3> f) {
        std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
        return f;
    };
    const std::array<IndexedMesh, 3> meshes{cases::torus(9, 7), cases::sheet(6, 5), icosphere(3)};
    for (unsigned seed = 0; seed < 30; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const IndexedMesh& mesh = meshes[seed % meshes.size()];
        HalfedgeMesh halfedges(mesh);
        CollapseMesh sides{TriangleHalfedgeMesh(mesh)};
        for (int step = 0; step < 600; ++step) {
            const auto s = static_cast<std::int32_t>(random() % sides.n_sides());
            if (!sides.is_alive(s)) continue;
            const Halfedge h = halfedges.find(Vertex(sides.from(s)), Vertex(sides.to(s)));
            ASSERT_TRUE(h.valid());
            ASSERT_EQ(halfedges.try_collapse_edge(h), sides.collapse(s));
            ASSERT_EQ(halfedges.n_faces(), sides.n_faces());
        }
        Faces left, right;
        const PolygonMesh rest = halfedges.to_polygons();
        std::vector<std::int32_t> slot;
        for (std::size_t v = 0; v < halfedges.vertex_slots(); ++v)
            if (halfedges.is_alive(Vertex(v))) slot.push_back(static_cast<std::int32_t>(v));
        for (std::size_t f = 0; f < rest.n_faces(); ++f)
            left.insert(turned({slot[rest.corners[3 * f]], slot[rest.corners[3 * f + 1]],
                                slot[rest.corners[3 * f + 2]]}));
        for (std::int32_t s = 0; s < static_cast<std::int32_t>(sides.n_sides()); s += 3)
            if (sides.is_alive(s))
                right.insert(turned({sides.from(s), sides.from(s + 1), sides.from(s + 2)}));
        EXPECT_EQ(left, right);
        EXPECT_LT(left.size(), mesh.n_faces() / 2);
    }
}

TEST(Simplify, FlatFacesNeedNoMoreThanTheirCorners)
{
    IndexedMesh box = cases::box();
    for (int i = 0; i < 3; ++i) box = cases::split_in_four(box);
    const SimplifiedMesh s = simplify(box, within(1e-9));
    EXPECT_EQ(s.mesh.n_faces(), 12u);
    EXPECT_EQ(s.mesh.n_vertices(), 8u);
    EXPECT_NEAR(volume(s.mesh), 1, 1e-14);
    EXPECT_TRUE(s.certified);
    EXPECT_LE(s.bound, 1e-9);
    EXPECT_TRUE(validate(s.mesh).ok());
}

TEST(Simplify, StaysWithinTheToleranceWithFewFaces)
{
    // A sphere needs about 4.7 r / tolerance triangles at best, by its curvature, when the surface
    // lies on both sides; n vertices within it need more. Halving the tolerance doubles them.
    const IndexedMesh sphere = icosphere(16, 10.0);
    double last = 0;
    for (const double tolerance : {0.8, 0.4, 0.2}) {
        SCOPED_TRACE(tolerance);
        const SimplifiedMesh s = simplify(sphere, within(tolerance));
        EXPECT_TRUE(s.certified);
        EXPECT_LE(s.measured, s.bound);
        EXPECT_LE(s.bound, tolerance);
        // Seen by another measure of the same.
        DistanceOptions dense;
        dense.density = 8;
        EXPECT_LE(mesh_distance(sphere, s.mesh, dense).max, s.bound);
        expect_same_topology(sphere, s.mesh);
        EXPECT_TRUE(validate(s.mesh).ok());
        const auto n = static_cast<double>(s.mesh.n_faces());
        EXPECT_LT(n, 20 * 10 / tolerance);
        if (last > 0) {
            EXPECT_NEAR(n / last, 2, 1);
        }
        last = n;
    }
}

TEST(Simplify, KeepsHandlesPartsAndBoundaries)
{
    const IndexedMesh ring = cases::torus(40, 30, 5, 2);
    const SimplifiedMesh s = simplify(ring, within(0.2));
    expect_same_topology(ring, s.mesh);
    EXPECT_LT(s.mesh.n_faces(), ring.n_faces() / 4);
    EXPECT_EQ(topology(s.mesh).genus, 1);

    const IndexedMesh sheet = cases::sheet(20, 10);
    const SimplifiedMesh flat = simplify(sheet, within(1e-6));
    EXPECT_EQ(flat.attempts, 1);
    expect_same_topology(sheet, flat.mesh);
    EXPECT_EQ(flat.mesh.n_faces(), 2u);
    EXPECT_NEAR(area(flat.mesh), 200, 1e-9);

    const IndexedMesh two =
        cases::together(icosphere(6), cases::moved(icosphere(6), translation({{3, 0, 0}})));
    SimplifyOptions few;
    few.max_faces = 8;  // two tetrahedra: no less is possible
    const SimplifiedMesh least = simplify(two, few);
    expect_same_topology(two, least.mesh);
    EXPECT_EQ(topology(least.mesh).components.size(), 2u);
    EXPECT_LE(least.mesh.n_faces(), 60u);
}

TEST(Simplify, ReachesANumberOfFaces)
{
    const IndexedMesh sphere = icosphere(20);
    SimplifyOptions options;
    options.max_faces = 1000;
    const SimplifiedMesh s = simplify(sphere, options);
    EXPECT_EQ(s.mesh.n_faces(), 1000u);
    EXPECT_EQ(s.attempts, 1);
    EXPECT_LT(s.bound, 0.02);
    EXPECT_GT(s.measured, 0);
    options.certify = false;
    const SimplifiedMesh estimated = simplify(sphere, options);
    EXPECT_EQ(estimated.mesh, s.mesh);
    EXPECT_FALSE(estimated.certified);
    EXPECT_EQ(estimated.bound, estimated.measured);
    EXPECT_LE(estimated.measured, s.bound);
}

TEST(Simplify, IsTheSameFarFromTheOriginAndAtAnyThreadCount)
{
    const IndexedMesh ring = cases::torus(28, 20);
    const IndexedMesh far = cases::moved(ring, translation({{1024, -4096, 512}}));
    const SimplifiedMesh near = simplify(ring, within(0.05));
    // Other roundings, other ties: nearly as many faces, as good.
    const SimplifiedMesh there = simplify(far, within(0.05));
    EXPECT_NEAR(static_cast<double>(there.mesh.n_faces()), static_cast<double>(near.mesh.n_faces()),
                0.2 * near.mesh.n_faces());
    EXPECT_LE(there.bound, 0.05);
    const int threads = thread_count();
    for (const int n : {1, 3}) {
        set_thread_count(n);
        const SimplifiedMesh again = simplify(ring, within(0.05));
        EXPECT_EQ(again.mesh, near.mesh);
        EXPECT_EQ(again.bound, near.bound);
    }
    set_thread_count(threads);
}

TEST(Simplify, RefusesWithTheReason)
{
    const IndexedMesh mesh = cases::box();
    EXPECT_THROW(simplify(mesh, {}), InvalidInput);
    EXPECT_THROW(simplify(mesh, within(0)), InvalidInput);
    EXPECT_THROW(simplify(mesh, within(std::nan(""))), InvalidInput);
    SimplifyOptions negative;
    negative.max_faces = -1;
    EXPECT_THROW(simplify(mesh, negative), InvalidInput);
    IndexedMesh doubled = mesh;
    doubled.faces.push_back(mesh.faces[3]);
    EXPECT_THROW(simplify(doubled, within(1)), InvalidInput);
    IndexedMesh bad = mesh;
    bad.vertices[2][1] = std::numeric_limits<double>::infinity();
    EXPECT_THROW(simplify(bad, within(1)), InvalidInput);
    EXPECT_EQ(simplify({}, within(1)).mesh.n_faces(), 0u);
}
