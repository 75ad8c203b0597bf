#include "genus/mesh/measure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"

using namespace genus;

TEST(Measure, BoxByItsFormulas)
{
    const Measures m = measure(cases::box({{2, 3, 5}}));
    EXPECT_DOUBLE_EQ(m.volume, 30);
    EXPECT_DOUBLE_EQ(m.area, 62);
    EXPECT_DOUBLE_EQ(m.centroid[0], 1);
    EXPECT_DOUBLE_EQ(m.centroid[1], 1.5);
    EXPECT_DOUBLE_EQ(m.centroid[2], 2.5);
    EXPECT_NEAR(m.inertia[0][0], 30.0 / 12 * (9 + 25), 1e-12);
    EXPECT_NEAR(m.inertia[1][1], 30.0 / 12 * (4 + 25), 1e-12);
    EXPECT_NEAR(m.inertia[2][2], 30.0 / 12 * (4 + 9), 1e-12);
    EXPECT_NEAR(m.inertia[0][1], 0, 1e-12);
    EXPECT_NEAR(m.inertia[1][2], 0, 1e-12);
}

TEST(Measure, TetrahedronByItsFormulas)
{
    // int x^2 = 1/60, int xy = 1/120 about the corner; centroid (1/4, 1/4, 1/4).
    const Measures m = measure(cases::tetrahedron());
    EXPECT_DOUBLE_EQ(m.volume, 1.0 / 6);
    EXPECT_DOUBLE_EQ(m.centroid[2], 0.25);
    const double second = 1.0 / 60 - 1.0 / 6 / 16, mixed = 1.0 / 120 - 1.0 / 6 / 16;
    EXPECT_NEAR(m.inertia[0][0], 2 * second, 1e-15);
    EXPECT_NEAR(m.inertia[0][1], -mixed, 1e-15);
}

TEST(Measure, KeepsItsDigitsFarFromTheOrigin)
{
    // Coordinates stay exact under this move, so the volume must be exact too.
    for (const double far : {1e6, 1e12, 1e15}) {
        const IndexedMesh mesh =
            cases::moved(cases::box({{2, 4, 8}}), translation({{far, -far, far}}));
        const Measures m = measure(mesh);
        EXPECT_DOUBLE_EQ(m.volume, 64);
        EXPECT_DOUBLE_EQ(m.area, 112);
        EXPECT_DOUBLE_EQ(m.centroid[0], far + 1);
        EXPECT_NEAR(m.inertia[2][2], 64.0 / 12 * 20, 1e-10);
    }
}

TEST(Measure, IsTurnedAndScaledWithTheMesh)
{
    std::mt19937 random(5);
    const IndexedMesh mesh = cases::torus(30, 20);
    const Measures before = measure(mesh);
    for (int i = 0; i < 20; ++i) {
        const Measures after =
            measure(cases::moved(mesh, cases::random_rotation(random) * scaling({{2, 2, 2}})));
        EXPECT_NEAR(after.volume, 8 * before.volume, 1e-11 * after.volume);
        EXPECT_NEAR(after.area, 4 * before.area, 1e-11 * after.area);
        double trace_before = 0, trace_after = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            trace_before += before.inertia[k][k];
            trace_after += after.inertia[k][k];
        }
        EXPECT_NEAR(trace_after, 32 * trace_before, 1e-10 * trace_after);
    }
}

TEST(Measure, SphereConvergesQuadratically)
{
    const double exact = 4.0 / 3 * std::numbers::pi;
    double previous = 0;
    for (int level = 2; level <= 6; ++level) {
        const double error = exact - volume(cases::octasphere(level));
        EXPECT_GT(error, 0);
        if (level > 3) {
            EXPECT_NEAR(previous / error, 4, 0.15);
        }
        previous = error;
    }
    EXPECT_NEAR(area(cases::octasphere(6)), 4 * std::numbers::pi, 0.01);
}

TEST(Measure, InsideOutIsNegative)
{
    EXPECT_DOUBLE_EQ(volume(cases::turned_inside_out(cases::box())), -1);
    const Measures m = measure(cases::turned_inside_out(cases::box()));
    EXPECT_DOUBLE_EQ(m.centroid[0], 0.5);
}

TEST(Measure, FlatMeshHasTheCentroidOfItsSurface)
{
    const Measures m = measure(cases::sheet(4, 2));
    EXPECT_EQ(m.volume, 0);
    EXPECT_DOUBLE_EQ(m.area, 8);
    EXPECT_DOUBLE_EQ(m.centroid[0], 2);
    EXPECT_DOUBLE_EQ(m.centroid[1], 1);
}

TEST(Measure, OfNothingIsZero)
{
    const Measures m = measure({});
    EXPECT_EQ(m.volume, 0);
    EXPECT_EQ(m.area, 0);
    EXPECT_EQ(m.centroid, Vec3{});
}

TEST(Measure, SameBitsOnAnyNumberOfThreads)
{
    const IndexedMesh mesh = cases::torus(200, 150);
    set_thread_count(1);
    const Measures one = measure(mesh);
    set_thread_count(8);
    const Measures eight = measure(mesh);
    set_thread_count(2);
    EXPECT_EQ(one.volume, eight.volume);
    EXPECT_EQ(one.area, eight.area);
    EXPECT_EQ(one.inertia, eight.inertia);
}

TEST(Measure, RefusesIndicesOutOfRange)
{
    IndexedMesh mesh = cases::box();
    mesh.faces[0][0] = 99;
    EXPECT_THROW(measure(mesh), InvalidInput);
}
