#include "genus/model/first_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/fans.h"
#include "genus/model/flat_faces.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/refine.h"
#include "genus/model/sign_formula.h"

namespace genus {
namespace {

constexpr double kPi = 3.14159265358979323846;

Solid moved(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

Solid turned(const Solid& s, double x, double y, double z)
{
    return transformed(s, rotation({{x, y, z}}));
}

Solid bore(double r)
{
    return cylinder(200, r, r, true);
}

Solid plate_with_holes(int n, int m)
{
    std::vector<Solid> parts{cube({{20.0 * n, 20.0 * m, 10}})};
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) parts.push_back(moved(bore(4), 20 * i + 10, 20 * j + 10, 0));
    return subtract(parts);
}

struct Case {
    std::string name;
    Solid solid;
    std::int64_t euler;
};

// Features are larger than the sagittas of a dozen sides; Euler numbers by counting tunnels.
std::vector<Case> cases()
{
    const Solid ball = sphere(50);
    const Solid tunnels = subtract({ball, bore(15), turned(bore(15), 90, 0, 0)});
    return {
        {"ball", ball, 2},
        {"mirrored egg", transformed(ellipsoid({{30, 20, 15}}), scaling({{1, 1, -1}})), 2},
        {"ball less a bore", subtract({ball, turned(bore(12), 20, 30, 0)}), 0},
        {"ball less two bores that touch", tunnels, -4},
        {"three bores", subtract({tunnels, turned(bore(10), 0, 90, 0)}), -8},
        {"two cylinders",
         intersect({cylinder(90, 15, 15, true), turned(cylinder(90, 15, 15, true), 90, 0, 0)}), 2},
        {"frustum on a plate, bored",
         subtract({unite({cylinder(30, 20, 8), cube({{60, 60, 6}}, true)}), bore(5)}), 0},
        {"torus", torus(30, 10), 0},
        {"half a ball", intersect({sphere(10), half_space({{1, 2, 3}}, 1.0)}), 2},
        {"ball without a half-space", subtract({sphere(10), half_space({{1, 2, 3}}, 1.0)}), 2},
        {"plate with six holes", plate_with_holes(3, 2), -10},
    };
}

struct Scene {
    explicit Scene(const Solid& solid) : field(solid), cube(cell_cube(solid.bounds()))
    {
        for (const Surface& s : field.surfaces()) forms.emplace_back(s, cube);
    }
    CsgField field;
    Box3 cube;
    std::vector<SurfaceForm> forms;
};

TEST(FirstMesh, HasTheFormOfTheSolidAndNearbySurfaces)
{
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        const Scene scene(c.solid);
        auto mesh = first_mesh(c.solid, scene.forms, scene.cube);
        ASSERT_TRUE(mesh.has_value());
        ASSERT_TRUE(separate_fans(*mesh));
        EXPECT_TRUE(mesh->touch_of_vertex.empty());
        EXPECT_EQ(topology(mesh->mesh).euler, c.euler);
        EXPECT_TRUE(validate(mesh->mesh).ok());
        const double size = scene.cube.diagonal();
        for (std::size_t f = 0; f < mesh->mesh.n_faces(); ++f) {
            const Triangle& t = mesh->mesh.faces[f];
            const std::vector<Vec3>& v = mesh->mesh.vertices;
            const std::int32_t label = mesh->surface_of_face[f];
            const SurfaceForm& form = scene.forms[label >> 1];
            const Vec3 normal = cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
            const Vec3 out = form.gradient((v[t[0]] + v[t[1]] + v[t[2]]) / 3.0);
            EXPECT_GT((label & 1) != 0 ? -dot(normal, out) : dot(normal, out), 0.0);
            for (const std::int32_t i : t) {
                EXPECT_LT(form.distance(v[i]), 0.02 * size);
                const auto& on = mesh->surfaces_of_vertex[i];
                EXPECT_NE(std::find(on.begin(), on.end(), label >> 1), on.end());
            }
        }
    }
}

TEST(FirstMesh, IsNotMadeOfLeavesWithoutOne)
{
    const Solid bowl = quadric(Quadric::from_polynomial({1, 1, 0, 0, 0, 0, 0, 0, -1, 0}),
                               Box3{{{-2, -2, 0}}, {{2, 2, 3}}});
    const Scene scene(bowl);
    EXPECT_FALSE(first_mesh(bowl, scene.forms, scene.cube).has_value());
    // A formula is none, also where its surfaces are quadrics.
    const Expression x = Expression::x(), y = Expression::y(), z = Expression::z();
    const Solid ball = unite(
        {implicit(x * x + y * y + z * z - 1.0, Box3{{{-2, -2, -2}}, {{2, 2, 2}}}), sphere(1.5)});
    const Scene both(ball);
    EXPECT_FALSE(first_mesh(ball, both.forms, both.cube).has_value());
    MeshOptions options;
    options.tolerance = 1e-3;
    EXPECT_TRUE(mesh_solid(ball, options).error.certified);
}

// What is proven does not depend on how good the guess is.
TEST(FirstMesh, LeadsToCertifiedMeshes)
{
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        MeshOptions options;
        options.tolerance = 0.05;
        const MeshedSolid made = mesh_solid(c.solid, options);
        EXPECT_TRUE(made.error.certified);
        EXPECT_LE(made.error.measured, made.error.bound);
        EXPECT_LE(made.error.bound, 0.05);
        EXPECT_EQ(topology(made.mesh).euler, c.euler);
        EXPECT_TRUE(validate(made.mesh).ok());
    }
}

TEST(FirstMesh, GivesPlatesTheirVolume)
{
    for (const int n : {1, 3, 6}) {
        const Solid plate = plate_with_holes(n, n);
        MeshOptions options;
        options.tolerance = 0.01;
        const MeshedSolid made = mesh_solid(plate, options);
        const double exact = n * n * (20.0 * 20.0 * 10.0 - kPi * 16.0 * 10.0);
        const double walls = n * n * 2.0 * kPi * 4.0 * 10.0;
        EXPECT_TRUE(made.error.certified);
        EXPECT_EQ(topology(made.mesh).euler, 2 - 2 * n * n);
        EXPECT_NEAR(volume(made.mesh), exact, 0.01 * walls);
    }
}

// Two beams without ends that cross, cut by a box or a ball.
TEST(FirstMesh, IsMadeOfUnboundedPartsToo)
{
    const auto beam = [](const Vec3& u, const Vec3& v, double half) {
        return intersect(
            {half_space(u, half), half_space(-u, half), half_space(v, half), half_space(-v, half)});
    };
    const Vec3 x{{1, 0, 0}}, y{{0, 1, 0}}, z{{0, 0, 1}};
    const Solid beams = unite({beam(x, y, 1.0), beam(x, z, 0.5)});
    MeshOptions options;
    options.tolerance = 0.01;
    const MeshedSolid made = mesh_solid(intersect({beams, cube({{4, 4, 4}}, true)}), options);
    EXPECT_TRUE(made.error.certified);
    EXPECT_NEAR(volume(made.mesh), 16.0 + 4.0 - 2.0, 1e-12);
    EXPECT_EQ(topology(made.mesh).euler, 2);
    EXPECT_TRUE(mesh_solid(intersect({beams, sphere(3)}), options).error.certified);
}

TEST(HalveFaces, PutsNewVerticesOnTheirSurfaces)
{
    const Solid solid = subtract({sphere(50), bore(15)});
    const Scene scene(solid);
    auto mesh = first_mesh(solid, scene.forms, scene.cube);
    ASSERT_TRUE(mesh && separate_fans(*mesh));
    settle(*mesh, scene.forms);
    const std::size_t before = mesh->mesh.n_vertices();
    FlexibleMesh flexible(std::move(*mesh));
    const std::int64_t n = halve_faces(flexible, scene.forms, {0, 1, 2, 3});
    EXPECT_GT(n, 0);
    const SurfaceMesh after = flexible.release();
    EXPECT_GE(after.mesh.n_vertices(), before + static_cast<std::size_t>(n));
    EXPECT_EQ(topology(after.mesh).euler, 0);
    for (std::size_t v = before; v < after.mesh.n_vertices(); ++v)
        for (const std::int32_t s : after.surfaces_of_vertex[v])
            if (s >= 0) {
                EXPECT_LT(scene.forms[s].distance(after.mesh.vertices[v]), 1e-12 * 50);
            }
}

// Holes near the border: flips alone do not do.
TEST(FlatFaces, HaveNoNarrowAnglesBesideCurves)
{
    const Solid plate = subtract({cube({{100, 30, 5}}), moved(bore(4), 20, 6, 0),
                                  moved(bore(6), 45, 8, 0), moved(bore(3), 80, 4, 0)});
    const Scene scene(plate);
    auto mesh = first_mesh(plate, scene.forms, scene.cube);
    ASSERT_TRUE(mesh && separate_fans(*mesh));
    settle(*mesh, scene.forms);
    const double before = volume(mesh->mesh);
    FlexibleMesh flexible(std::move(*mesh));
    round_flat_faces(flexible, scene.forms);
    int n_obtuse = 0, n_not_delaunay = 0;
    for (std::int32_t s = 0; s < flexible.n_sides(); ++s) {
        if (!flexible.alive(s) || !scene.forms[flexible.label(s) >> 1].is_plane()) continue;
        const auto cotangent = [&](std::int32_t side) {
            const Vec3 c = flexible.point(flexible.apex(side));
            const Vec3 a = flexible.point(flexible.from(side)) - c;
            const Vec3 b = flexible.point(flexible.to(side)) - c;
            return dot(a, b) / norm(cross(a, b));
        };
        if (flexible.is_crease(s))
            n_obtuse += cotangent(s) < -1e-9;
        else
            n_not_delaunay += cotangent(s) + cotangent(flexible.twin(s)) < -1e-6;
    }
    EXPECT_EQ(n_obtuse, 0);
    EXPECT_EQ(n_not_delaunay, 0);
    const SurfaceMesh after = flexible.release();
    EXPECT_EQ(topology(after.mesh).euler, 2 - 2 * 3);
    // Only curves change it, towards the circle.
    EXPECT_LE(volume(after.mesh), before * (1.0 + 1e-12));
    EXPECT_GE(volume(after.mesh), 5.0 * (100.0 * 30.0 - kPi * (16.0 + 36.0 + 9.0)));
}

TEST(SurfaceForm, SagittasAreThoseOfTheCurvatures)
{
    const Scene ball(sphere(50));
    const Vec3 p{{50, 0, 0}}, q{{50 * std::cos(0.02), 50 * std::sin(0.02), 0}};
    EXPECT_NEAR(ball.forms[0].sagitta(p, q), 50 * (1 - std::cos(0.01)), 1e-6);
    // On a saddle z = (x^2 - y^2) / 20 curvatures are 0.1 and -0.1: what matters is their size, in
    // all directions, along its straight lines too.
    const Scene saddle(quadric(Quadric::from_polynomial({0.05, -0.05, 0, 0, 0, 0, 0, 0, -1, 0}),
                               Box3{{{-3, -3, -2}}, {{3, 3, 2}}}));
    ASSERT_TRUE(saddle.forms[0].may_be_saddle());
    for (const double angle : {0.0, 0.3, 0.7853981633974483, 1.2}) {
        const double x = 0.1 * std::cos(angle), y = 0.1 * std::sin(angle);
        const double z = 0.05 * (x * x - y * y);
        EXPECT_NEAR(saddle.forms[0].sagitta({{-x, -y, z}}, {{x, y, z}}), 0.125 * 0.2 * 0.2 * 0.1,
                    1e-6);
    }
    for (const Solid& flat : {cylinder(10, 3, 3), cylinder(10, 3, 1), ellipsoid({{1, 2, 3}})})
        for (const double angle : {0.0, 13.0, 27.0, 31.0, 44.0, 71.0}) {
            const Scene scene(moved(turned(flat, angle, 2 * angle, 30), 5, 7, 11));
            EXPECT_FALSE(scene.forms[0].may_be_saddle()) << angle;
        }
}

TEST(SignFormula, DropsWhatDoesNotMatterBesideOthers)
{
    // a or (a and b) is a.
    const Solid a = sphere(2), b = moved(sphere(2), 1, 0, 0);
    const CsgField field(unite({a, intersect({a, b})}));
    const SignFormula formula(field);
    const SignFormula simplified = formula.simplified(std::vector<Sign>(2, Sign{0}));
    EXPECT_EQ(simplified.surfaces(), std::vector<std::int32_t>{0});
    EXPECT_EQ(simplified.sign(std::vector<Sign>{-1, 0}), -1);
    EXPECT_EQ(simplified.sign(std::vector<Sign>{1, 0}), 1);
}

}  // namespace
}  // namespace genus
