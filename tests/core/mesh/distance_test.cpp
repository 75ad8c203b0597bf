#include "genus/mesh/distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"

using namespace genus;

TEST(MeshDistance, OfAMeshToItselfIsZero)
{
    for (const IndexedMesh& mesh : {cases::box(), cases::octasphere(3), cases::torus(20, 12)}) {
        const MeshDistance d = mesh_distance(mesh, cases::shuffled(mesh, 3));
        EXPECT_LT(d.max, 1e-15);
        EXPECT_LT(d.bound, 1e-14);
        EXPECT_LT(d.mean, 1e-15);
    }
}

TEST(MeshDistance, OfAMovedBox)
{
    const IndexedMesh box = cases::box();
    const MeshDistance d = mesh_distance(box, cases::moved(box, translation({{0.25, 0, 0}})));
    EXPECT_DOUBLE_EQ(d.max, 0.25);
    EXPECT_GE(d.bound, 0.25);
    EXPECT_LE(d.bound, 0.25 * 1.01);
    // One end is 0.25 away. Of the other, which lies inside, the border is nearer to the sides:
    // 0.0625 from the middle square and 1/12 from the frame. The four sides stick out by a
    // quarter, 0.125 in the mean.
    EXPECT_NEAR(d.a_to_b.mean, (0.25 + 0.0625 + 1.0 / 12 + 4 * 0.25 * 0.125) / 6, 1e-3);
}

TEST(MeshDistance, OfConcentricSpheres)
{
    // A vertex of the outer one lies straight above the same vertex of the inner one.
    const MeshDistance d = mesh_distance(cases::octasphere(3, 2), cases::octasphere(3, 1.5));
    EXPECT_NEAR(d.max, 0.5, 1e-12);
    EXPECT_GE(d.bound, d.max);
    EXPECT_LE(d.bound, 0.5 * 1.0101);
}

TEST(MeshDistance, IsNotTheSameBothWays)
{
    // A sheet and a corner of it: the corner lies on the sheet, the sheet leaves the corner.
    const IndexedMesh large = cases::sheet(4, 4), small = cases::sheet(1, 1);
    const MeshDistance d = mesh_distance(large, small);
    EXPECT_DOUBLE_EQ(d.a_to_b.max, std::hypot(3, 3));
    EXPECT_LT(d.b_to_a.max, 1e-15);
    EXPECT_EQ(d.max, d.a_to_b.max);
    EXPECT_EQ(d.a_to_b.where, (Vec3{{4, 4, 0}}));
}

TEST(MeshDistance, FindsAPeakBetweenTheSamples)
{
    // A flat square over a pit: the farthest point of the square is above the bottom of the pit,
    // and no vertex is there.
    const IndexedMesh square{{{{-1, -1, 0}}, {{1, -1, 0}}, {{1, 1, 0}}, {{-1, 1, 0}}},
                             {{0, 1, 2}, {0, 2, 3}}};
    IndexedMesh bowl = cases::sheet(2, 2);
    for (Vec3& p : bowl.vertices) p += Vec3{{-1, -1, 0}};
    bowl.vertices[4][2] = -0.5;
    DistanceOptions options;
    options.density = 1e-9;  // vertices only
    options.precision = 1e-6;
    const OneSidedDistance d = one_sided_distance(square, bowl, options);
    EXPECT_EQ(d.samples, 4);
    options.density = 1e5;
    const OneSidedDistance dense = one_sided_distance(square, bowl, options);
    EXPECT_GE(d.bound, dense.max);
    EXPECT_LE(d.bound, dense.max * 1.01);
    EXPECT_LE(d.max, d.bound);
    EXPECT_GE(d.max, d.bound * (1 - 2e-6));
}

TEST(MeshDistance, BoundHoldsForRandomMeshes)
{
    std::mt19937 random(77);
    for (int i = 0; i < 5; ++i) {
        SCOPED_TRACE(i);
        IndexedMesh a = cases::octasphere(2), b = cases::torus(9, 6);
        for (Vec3& p : a.vertices) p += cases::point_in_cube(random, -0.3, 0.3);
        for (Vec3& p : b.vertices) p += cases::point_in_cube(random, -0.3, 0.3);
        DistanceOptions coarse, dense;
        coarse.density = 1e-9;
        dense.density = 1e3;
        dense.precision = 0;
        const MeshDistance d = mesh_distance(a, b, coarse), s = mesh_distance(a, b, dense);
        EXPECT_GE(d.bound * (1 + 1e-12), s.max);
        EXPECT_LE(d.bound, s.max * 1.03);
        EXPECT_EQ(s.bound, std::numeric_limits<double>::infinity());
        EXPECT_GE(d.bound, d.max);
        EXPECT_LE(d.bound, d.max * (1.01 + 1e-12));
        // What is left out where no mean is wanted changes neither maxima nor bounds.
        dense.mean = coarse.mean = false;
        EXPECT_EQ(mesh_distance(a, b, dense).max, s.max);
        EXPECT_EQ(mesh_distance(a, b, dense).mean, 0);
        EXPECT_EQ(mesh_distance(a, b, coarse).max, d.max);
        EXPECT_EQ(mesh_distance(a, b, coarse).bound, d.bound);
    }
}

TEST(MeshDistance, MeasuresASphereAgainstItsLimit)
{
    // Sagitta of the octasphere: falls fourfold a level.
    const IndexedMesh fine = cases::octasphere(6);
    DistanceOptions options;
    options.density = 500;
    options.precision = 0;
    double previous = 0;
    for (int level = 2; level <= 4; ++level) {
        const double max = mesh_distance(cases::octasphere(level), fine, options).max;
        if (previous > 0) {
            EXPECT_NEAR(previous / max, 4, 0.4);
        }
        previous = max;
    }
}

TEST(MeshDistance, SameBitsOnAnyNumberOfThreads)
{
    const IndexedMesh a = cases::octasphere(3), b = cases::globe(30, 20);
    set_thread_count(1);
    const MeshDistance one = mesh_distance(a, b);
    set_thread_count(6);
    const MeshDistance six = mesh_distance(a, b);
    set_thread_count(2);
    EXPECT_EQ(one.max, six.max);
    EXPECT_EQ(one.mean, six.mean);
    EXPECT_EQ(one.bound, six.bound);
    EXPECT_EQ(one.a_to_b.where, six.a_to_b.where);
}

TEST(MeshDistance, OfNothing)
{
    EXPECT_EQ(mesh_distance({}, {}).bound, 0);
    EXPECT_THROW(mesh_distance(cases::box(), {}), InvalidInput);
    EXPECT_THROW(mesh_distance({}, cases::box()), InvalidInput);
}

TEST(MeshDistance, RefusesWhatItCannotMeasure)
{
    IndexedMesh bad = cases::box();
    bad.vertices[0][0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(mesh_distance(bad, cases::box()), InvalidInput);
    EXPECT_THROW(one_sided_distance(bad, cases::box()), InvalidInput);
    DistanceOptions options;
    options.precision = -1;
    EXPECT_THROW(mesh_distance(cases::box(), cases::box(), options), InvalidInput);
}

TEST(MeshDistance, SurfacesThatLieInEachOtherAreSettledWhereSidesCross)
{
    // One plane, cut in ways that share no points inside: without cuts along the sides, millions of
    // pieces would not do.
    const IndexedMesh fine = cases::moved(cases::sheet(21, 17), scaling({{1.0 / 21, 1.0 / 17, 1}}));
    const IndexedMesh coarse = cases::moved(cases::sheet(5, 8), scaling({{1.0 / 5, 1.0 / 8, 1}}));
    DistanceOptions options;
    options.max_pieces = 200'000;
    const MeshDistance d = mesh_distance(fine, coarse, options);
    EXPECT_LT(d.max, 1e-15);
    EXPECT_LT(d.bound, 1e-14);
    // A bound that is good enough ends the search, and is one all the same.
    options.sufficient = 0.5;
    const IndexedMesh lifted = cases::moved(coarse, translation({{0, 0, 0.25}}));
    const MeshDistance loose = mesh_distance(fine, lifted, options);
    EXPECT_EQ(loose.max, 0.25);
    EXPECT_GE(loose.bound, 0.25);
    EXPECT_LE(loose.bound, 0.5);
}
