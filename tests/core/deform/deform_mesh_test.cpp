#include "genus/deform/deform_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/patch/reference.h"
#include "genus/base/error.h"

namespace genus {
namespace {

using reference::random_points;

// A box from -1 to 1 of two triangles a side.
IndexedMesh box_mesh(double half = 1.0)
{
    IndexedMesh m;
    for (int i = 0; i < 8; ++i)
        m.vertices.push_back(half *
                             Vec3{{i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0}});
    m.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
               {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return m;
}

Lattice lattice(int degree, double size, unsigned seed, bool spline, double half = 2.0)
{
    const Columns3 axes = {Vec3{{2 * half, 0, 0}}, Vec3{{0, 2 * half, 0}}, Vec3{{0, 0, 2 * half}}};
    const Vec3 origin = {{-half, -half, -half}};
    std::mt19937_64 random(seed);
    Lattice l = spline ? Lattice::bspline(origin, axes, {6, 6, 6}, degree)
                       : Lattice(origin, axes, {degree, degree, degree});
    l.set_moves(random_points(random, static_cast<int>(l.n_points()), size));
    return l;
}

bool is_closed(const IndexedMesh& mesh)
{
    std::map<std::pair<int, int>, int> count;
    for (const Triangle& t : mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            ++count[{t[k], t[(k + 1) % 3]}];
            --count[{t[(k + 1) % 3], t[k]}];
        }
    return std::all_of(count.begin(), count.end(), [](const auto& c) { return c.second == 0; });
}

Vec3 random_in(std::mt19937_64& random, const Box3& box)
{
    std::uniform_real_distribution<double> x(0.0, 1.0);
    const Vec3 s = box.size();
    return box.min + Vec3{{x(random) * s[0], x(random) * s[1], x(random) * s[2]}};
}

TEST(LatticeBounds, HoldImageStretchAndSecondDerivatives)
{
    std::mt19937_64 random(201);
    for (const bool spline : {false, true})
        for (const int degree : {1, 2, 3, 5}) {
            const Lattice l = lattice(degree, 0.3, 202, spline);
            const Box3 box{{{-1.1, -0.4, 0.2}}, {{0.3, 1.0, 1.9}}};
            const Box3 image = l.image_bounds(box);
            const double stretch = l.stretch(box);
            double most = 0.0;
            for (int i = 0; i < 300; ++i) {
                const Vec3 a = random_in(random, box), b = random_in(random, box);
                EXPECT_TRUE(image.contains(l.apply(a)));
                most = std::max(most, distance(l.apply(a), l.apply(b)) / distance(a, b));
                const Vec3 near = a + 1e-6 * reference::random_vec(random);
                most = std::max(most, distance(l.apply(a), l.apply(near)) / distance(a, near));
            }
            EXPECT_LE(most, stretch * (1.0 + 1e-6));
            EXPECT_LE(stretch, 4.0 * most);
        }
}

TEST(LatticeBounds, SecondBoundsHoldAgainstDifferences)
{
    const int n = 4;
    std::mt19937_64 random(203);
    for (const bool spline : {false, true}) {
        const Lattice l = lattice(3, 0.3, 204, spline);
        const auto bounds = l.second_bounds(n);
        for (int trial = 0; trial < 300; ++trial) {
            std::uniform_int_distribution<int> cell(0, n - 1);
            const int i = cell(random), j = cell(random), k = cell(random);
            const double h = 1e-3;
            const Box3 inner{{{(i + 0.01) / n, (j + 0.01) / n, (k + 0.01) / n}},
                             {{(i + 0.99) / n, (j + 0.99) / n, (k + 0.99) / n}}};
            const Vec3 s = random_in(random, inner);
            for (std::size_t a = 0; a < 3; ++a) {
                Vec3 step{};
                step[a] = h;
                const Vec3 d = (l.apply(l.global(s + step)) - 2.0 * l.apply(l.global(s)) +
                                l.apply(l.global(s - step))) /
                               (h * h);
                EXPECT_LE(norm(d), bounds[static_cast<std::size_t>((i * n + j) * n + k)][a] + 1e-6);
            }
        }
    }
}

TEST(DeformedWithin, IsClosedWithinItsBoundAndConverges)
{
    const Lattice l = lattice(3, 0.4, 205, false);
    std::size_t last = 0;
    for (const double tolerance : {1e-1, 1e-2, 1e-3}) {
        const DeformedMesh made = deformed_within(box_mesh(), l, tolerance, 1'000'000);
        EXPECT_TRUE(is_closed(made.mesh));
        EXPECT_LE(made.bound, tolerance);
        EXPECT_LE(made.measured, made.bound);
        // A tenth of the tolerance: about ten times the triangles.
        if (last > 0) {
            EXPECT_GT(made.mesh.n_faces(), 4 * last);
            EXPECT_LT(made.mesh.n_faces(), 25 * last);
        }
        last = made.mesh.n_faces();
    }
}

// Points of the exact image, each near the triangles.
TEST(DeformedWithin, TheExactImageIsNearTheMesh)
{
    const Lattice l = lattice(4, 0.4, 206, false);
    const DeformedMesh made = deformed_within(box_mesh(), l, 0.02, 1'000'000);
    std::mt19937_64 random(207);
    std::uniform_real_distribution<double> x(-1.0, 1.0);
    for (int i = 0; i < 60; ++i) {
        const Vec3 y = l.apply({{x(random), x(random), 1.0}});
        double nearest = 1e9;
        for (const Triangle& t : made.mesh.faces) {
            // Of many points of the triangle: an upper bound of its distance.
            const auto& v = made.mesh.vertices;
            for (int a = 0; a <= 4; ++a)
                for (int b = 0; a + b <= 4; ++b)
                    nearest = std::min(
                        nearest,
                        distance(y, (double(a) * v[static_cast<std::size_t>(t[0])] +
                                     double(b) * v[static_cast<std::size_t>(t[1])] +
                                     double(4 - a - b) * v[static_cast<std::size_t>(t[2])]) /
                                        4.0));
        }
        EXPECT_LE(nearest, 0.02 + 0.15);  // samples of the triangles are that far apart
    }
}

TEST(DeformedWithin, CutsAtKinksAndRefusesTears)
{
    // Across a border that only holds together: no triangle lies on both sides.
    Lattice c0 = lattice(3, 0.3, 208, false, 0.7);
    c0.keep_border(0);
    EXPECT_EQ(c0.border_continuity(), 0);
    IndexedMesh mesh = box_mesh(0.6);
    for (Vec3& v : mesh.vertices) v[0] += 0.4;
    const DeformedMesh made = deformed_within(mesh, c0, 0.01, 1'000'000);
    EXPECT_TRUE(is_closed(made.mesh));
    for (const Triangle& t : made.mesh.faces) {
        double low = 1e9, high = -1e9;
        for (const std::int32_t v : t) {
            low = std::min(low, made.mesh.vertices[static_cast<std::size_t>(v)][0]);
            high = std::max(high, made.mesh.vertices[static_cast<std::size_t>(v)][0]);
        }
        EXPECT_FALSE(low < 0.7 - 0.01 && high > 0.7 + 0.01);
    }
    const Lattice torn = lattice(3, 0.3, 208, false, 0.7);
    EXPECT_THROW(deformed_within(mesh, torn, 0.01, 1'000'000), InvalidInput);
    // Degree 1: kinks at the knots, flat in between but for the twist.
    const Lattice linear = lattice(1, 0.2, 209, true);
    EXPECT_EQ(linear.kinks(0).size(), 4u);
    const DeformedMesh bent = deformed_within(box_mesh(), linear, 0.01, 1'000'000);
    EXPECT_TRUE(is_closed(bent.mesh));
    EXPECT_LE(bent.measured, bent.bound);
}

TEST(DeformedWithin, SaysWhatItCannot)
{
    const Lattice l = lattice(3, 0.3, 210, false);
    EXPECT_THROW(deformed_within(box_mesh(), l, 0.0, 1000), InvalidInput);
    EXPECT_THROW(deformed_within(box_mesh(), l, 1e-18, 1000), ToleranceNotMet);
    EXPECT_THROW(deformed_within(box_mesh(), l, 1e-6, 1000), ToleranceNotMet);
}

// A corner of a box that is the lattice's own may be outside it by rounding.
TEST(Lattice, WhatIsOutsideByRoundingIsOnTheBorder)
{
    std::mt19937_64 random(211);
    for (int trial = 0; trial < 200; ++trial) {
        Box3 box;
        box.add(reference::random_vec(random, 100.0));
        box.add(reference::random_vec(random, 100.0));
        Lattice l = Lattice::over(box, {2, 2, 2});
        const Vec3 move = {{1, 2, 3}};
        l.set_moves(std::vector<Vec3>(l.n_points(), move));
        for (int corner = 0; corner < 8; ++corner) {
            Vec3 p;
            for (std::size_t k = 0; k < 3; ++k)
                p[k] = (corner >> k & 1) != 0 ? box.max[k] : box.min[k];
            EXPECT_LE(distance(l.apply(p), p + move), 1e-12) << trial;
        }
    }
}

}  // namespace
}  // namespace genus
