#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "genus/base/error.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/certificate.h"
#include "genus/model/coarse_shell.h"
#include "genus/model/embedding.h"
#include "genus/model/fans.h"
#include "genus/model/fibres.h"
#include "genus/model/fine_certificate.h"
#include "genus/model/fine_mesh.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/refine.h"
#include "genus/model/solid.h"
#include "genus/model/widen.h"

namespace genus {
namespace {

// The steps from a solid to a coarse mesh with its sandwich.
struct Coarse {
    explicit Coarse(const Solid& solid, double width)
        : field(solid), formula(field), cube(cell_cube(solid.bounds()))
    {
        for (const Surface& s : field.surfaces()) forms.emplace_back(s, cube);
        CellMesher mesher(formula, forms, cube);
        CellDemands demands;
        demands.max_error = cube.diagonal();
        demands.touch = 0.0025;
        mesher.refine(demands, 1'000'000);
        mesh = mesher.extract();
        EXPECT_TRUE(separate_fans(mesh));
        settle_all(mesh, forms, 1e-4);
        FlexibleMesh flexible(std::move(mesh));
        widen(flexible, forms, 0.5 * width, 0.0);
        std::vector<double> factors;
        subdivide(flexible, forms, 0.5 * width, factors, 100'000, {0.15, 0.0005});
        mesh = flexible.release();
        proof = certify(mesh, formula, forms, cube, width, &sandwich);
        shell = shell_round(mesh, sandwich);
    }

    FineMesh cut(double tolerance, std::int64_t max_triangles) const
    {
        return cut_finely(mesh, sandwich, shell, forms, tolerance, max_triangles);
    }

    CsgField field;
    SignFormula formula;
    Box3 cube;
    std::vector<SurfaceForm> forms;
    SurfaceMesh mesh;
    Sandwich sandwich;
    Certificate proof;
    CoarseShell shell;
};

Solid bored_ball()
{
    return subtract({sphere(10), cylinder(40, 3, 3, true)});
}

TEST(FineMesh, CutsAClosedMeshWithinTheToleranceOfItsSurfaces)
{
    const Coarse c(bored_ball(), 0.4);
    for (const double tolerance : {0.04, 0.01, 0.0025}) {
        SCOPED_TRACE(tolerance);
        const FineMesh fine = c.cut(tolerance, 1'000'000);
        ASSERT_TRUE(fine.stuck.empty());
        const IndexedMesh& mesh = fine.surface.mesh;
        EXPECT_TRUE(validate(mesh).ok());
        EXPECT_EQ(topology(mesh).euler, 0);
        ASSERT_EQ(fine.first_face.size(), c.mesh.mesh.n_faces() + 1);
        EXPECT_EQ(fine.first_face.back(), static_cast<std::int64_t>(mesh.n_faces()));
        ASSERT_EQ(fine.first_vertex.size(), fine.first_face.size());
        EXPECT_EQ(fine.first_vertex.back(), static_cast<std::int64_t>(mesh.n_vertices()));
        for (std::size_t f = 0; f + 1 < fine.first_face.size(); ++f)
            for (std::int64_t k = fine.first_face[f]; k < fine.first_face[f + 1]; ++k)
                for (const std::int32_t v : mesh.faces[k])
                    EXPECT_TRUE(v < fine.first_vertex[0] ||
                                (v >= fine.first_vertex[f] && v < fine.first_vertex[f + 1]));
        for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
            EXPECT_LE(std::max(fine.reach[v][0], fine.reach[v][1]), tolerance);
            for (const std::int32_t s : fine.surface.surfaces_of_vertex[v])
                if (s >= 0) {
                    EXPECT_LE(std::fabs(c.forms[s].value(mesh.vertices[v])), c.forms[s].slack());
                }
        }
    }
}

TEST(FineMesh, PlanesAcrossAnAxisAreMetExactly)
{
    // An eighth of a ball moved off its middle, on both roads.
    const Solid ball = transformed(sphere(1), translation({{0.3, 0.1, 0.7}}));
    const Solid part =
        intersect({ball, transformed(cube({{3, 3, 3}}), translation({{0.3, 0.1, 0.7}}))});
    const Vec3 at{{0.3, 0.1, 0.7}};
    for (const double tolerance : {0.1, 0.001}) {
        MeshOptions options;
        options.tolerance = tolerance;
        const IndexedMesh mesh = mesh_solid(part, options).mesh;
        for (std::size_t k = 0; k < 3; ++k) {
            std::size_t on = 0;
            for (const Vec3& p : mesh.vertices) {
                EXPECT_TRUE(p[k] == at[k] || p[k] > at[k] + 1e-9) << p[k] - at[k];
                on += p[k] == at[k];
            }
            EXPECT_GT(on, 3u);
        }
    }
}

TEST(FineMesh, NeedsAsManyFacesAsTheoryAsksFor)
{
    // Sagitta r h^2 / 8: a quarter of the tolerance takes four times the faces.
    const Coarse c(sphere(10), 0.4);
    const auto faces = [&](double tolerance) {
        return static_cast<double>(c.cut(tolerance, 10'000'000).surface.mesh.n_faces());
    };
    const double few = faces(0.002), many = faces(0.0005);
    EXPECT_NEAR(many / few, 4.0, 0.4);
    // Equilateral faces whose middle is off by the tolerance t have sides of sqrt(6 r t).
    const double least = 4.0 * 3.14159 * 100.0 / (std::sqrt(0.1875) * 6.0 * 10.0 * 0.0005);
    EXPECT_LE(many, 1.6 * least);
    // Rulings of a cylinder need no vertices: its faces grow with the root of that.
    const Coarse pipe(cylinder(20, 5, 5, true), 0.4);
    const auto pipe_faces = [&](double tolerance) {
        return static_cast<double>(pipe.cut(tolerance, 10'000'000).surface.mesh.n_faces());
    };
    EXPECT_LT(pipe_faces(0.0005) / pipe_faces(0.002), 2.2);
}

TEST(FineMesh, WideFacesAreFewAndStayOnTheirSurfaces)
{
    const CsgField field(bored_ball());
    const SignFormula formula(field);
    const Box3 cube = cell_cube(bored_ball().bounds());
    std::vector<SurfaceForm> forms;
    for (const Surface& s : field.surfaces()) forms.emplace_back(s, cube);
    CellMesher mesher(formula, forms, cube);
    CellDemands demands;
    demands.max_error = cube.diagonal();
    mesher.refine(demands, 1'000'000);
    SurfaceMesh mesh = mesher.extract();
    settle_all(mesh, forms, 1e-4);
    const std::size_t before = mesh.mesh.n_faces();
    FlexibleMesh flexible(std::move(mesh));
    widen(flexible, forms, 0.4, 0.0);
    mesh = flexible.release();
    EXPECT_LT(3 * mesh.mesh.n_faces(), before);
    EXPECT_TRUE(validate(mesh.mesh).ok());
    EXPECT_EQ(topology(mesh.mesh).euler, 0);
    for (std::size_t v = 0; v < mesh.mesh.n_vertices(); ++v)
        for (const std::int32_t s : mesh.surfaces_of_vertex[v]) {
            if (s < 0) continue;
            EXPECT_LE(forms[s].distance(mesh.mesh.vertices[v]), 1e-12 * 10.0);
        }
    for (std::size_t f = 0; f < mesh.mesh.n_faces(); ++f) {
        const Triangle& t = mesh.mesh.faces[f];
        const Vec3 &a = mesh.mesh.vertices[t[0]], &b = mesh.mesh.vertices[t[1]],
                   &c = mesh.mesh.vertices[t[2]];
        const std::int32_t label = mesh.surface_of_face[f];
        const double turn = (label & 1) != 0 ? -1.0 : 1.0;
        for (const Vec3& p : {a, b, c})
            EXPECT_GT(turn * dot(normalized(cross(b - a, c - a)),
                                 normalized(forms[label >> 1].gradient(p))),
                      0.7);
    }
}

// Two equal bores that cross touch each other where they meet: the way through a coarse mesh holds
// there too, and the number of faces grows no faster than one over the tolerance.
TEST(FineMesh, GrowsWithOneOverTheToleranceWhereSurfacesTouch)
{
    const Solid bore = cylinder(120, 15, 15, true);
    const Solid part =
        subtract({sphere(50), bore, transformed(bore, rotation(Vec3{{90.0, 0.0, 0.0}}))});
    double before = 0.0;
    for (double tolerance = 1.0; tolerance > 0.015; tolerance *= 0.5) {
        MeshOptions options;
        options.tolerance = tolerance;
        options.measure = false;
        const MeshedSolid made = mesh_solid(part, options);
        EXPECT_TRUE(made.error.certified);
        EXPECT_LE(made.error.bound, tolerance);
        EXPECT_EQ(topology(made.mesh).euler, -4);
        const auto faces = static_cast<double>(made.mesh.n_faces());
        if (before > 0.0) {
            EXPECT_LT(faces, 2.1 * before) << tolerance;
        }
        before = faces;
    }
}

TEST(FineMesh, StopsAtTheLimit)
{
    const Coarse c(sphere(10), 0.4);
    EXPECT_THROW(c.cut(1e-9, 100'000), ToleranceNotMet);
    EXPECT_THROW(c.cut(1e-3, 10'000), ToleranceNotMet);
}

TEST(FineCertificate, AgreesWithTheOneThatNeedsNoCoarseMesh)
{
    for (const Solid& solid :
         {bored_ball(), unite({sphere(5), transformed(cylinder(20, 2, 2, true), rotation_x(30))}),
          intersect(
              {cylinder(20, 4, 4, true), transformed(cylinder(20, 3, 3, true), rotation_x(90))})}) {
        const Coarse c(solid, 0.2);
        ASSERT_EQ(c.proof.n_failed, 0);
        EXPECT_TRUE(doubtful_prisms(c.mesh, c.sandwich, c.formula, c.forms, 0.0).faces.empty());
        const double tolerance = 0.01;
        const FineMesh fine = c.cut(tolerance, 1'000'000);
        ASSERT_TRUE(fine.stuck.empty());
        const Certificate short_way =
            certify_within(c.sandwich, c.mesh, fine, c.formula, c.forms, tolerance, 0.0);
        ASSERT_EQ(short_way.n_failed, 0);
        const Certificate long_way = certify(fine.surface, c.formula, c.forms, c.cube, tolerance);
        EXPECT_EQ(long_way.n_failed, 0);
        EXPECT_LE(short_way.bound, tolerance);
        EXPECT_NEAR(short_way.bound / long_way.bound, 1.0, 0.25);
    }
}

TEST(FineCertificate, IsReachedWhereAQuarticMeetsAQuadric)
{
    const Solid bitten =
        subtract({torus(10, 3), transformed(sphere(4), translation({{10, 0, 0}}))});
    MeshOptions options;
    options.tolerance = 0.005;
    const MeshedSolid made = mesh_solid(bitten, options);
    EXPECT_TRUE(made.error.certified);
    EXPECT_LE(made.error.measured, made.error.bound);
    EXPECT_LE(made.error.bound, 0.005);
    EXPECT_EQ(topology(made.mesh).euler, 2);
}

TEST(FineCertificate, RefusesAMeshThatIsOff)
{
    const Coarse c(bored_ball(), 0.4);
    const double tolerance = 0.01;
    const FineMesh good = c.cut(tolerance, 1'000'000);
    ASSERT_TRUE(good.stuck.empty());
    // Vertices on an edge of the coarse mesh and inside its faces, on the ball and in the bore.
    std::vector<std::size_t> tried;
    for (std::size_t v = 0; tried.empty(); ++v)
        if (good.surface.surfaces_of_vertex[v][1] < 0) tried.push_back(v);
    for (std::size_t f = 0; f < c.mesh.mesh.n_faces(); f += 7)
        if (good.first_vertex[f] < good.first_vertex[f + 1])
            tried.push_back(
                static_cast<std::size_t>(good.first_vertex[f] + good.first_vertex[f + 1]) / 2);
    ASSERT_GT(tried.size(), 5u);
    for (const std::size_t v : tried)
        for (const double off : {3.0, 1.2, -1.2, -3.0}) {
            SCOPED_TRACE(v);
            FineMesh fine = good;
            fine.surface.mesh.vertices[v] += off * tolerance * fine.direction[v];
            const Certificate bad =
                certify_within(c.sandwich, c.mesh, fine, c.formula, c.forms, tolerance, 0.0);
            EXPECT_GT(bad.n_failed, 0);
            std::set<std::int32_t> expected;
            for (std::size_t f = 0; f < c.mesh.mesh.n_faces(); ++f)
                for (std::int64_t k = fine.first_face[f]; k < fine.first_face[f + 1]; ++k)
                    for (const std::int32_t corner : fine.surface.mesh.faces[k])
                        if (corner == static_cast<std::int32_t>(v))
                            expected.insert(static_cast<std::int32_t>(f));
            for (const std::int32_t f : bad.failed_faces) EXPECT_TRUE(expected.count(f)) << f;
        }
}

// Directions that are no normals are as good, if longer: none is taken for one.
TEST(FineCertificate, HoldsAlongSlantingDirections)
{
    const Coarse c(bored_ball(), 0.4);
    const double tolerance = 0.01;
    FineMesh fine = c.cut(0.8 * tolerance, 1'000'000);
    ASSERT_TRUE(fine.stuck.empty());
    const double straight =
        certify_within(c.sandwich, c.mesh, fine, c.formula, c.forms, tolerance, 0.0).bound;
    const unsigned seed = 20261123;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    for (std::size_t v = 0; v < fine.direction.size(); ++v)
        for (double& x : fine.direction[v].c)
            x += 0.2 * (static_cast<double>(random() >> 5) * 0x1p-26 - 1.0);
    const Certificate slanting =
        certify_within(c.sandwich, c.mesh, fine, c.formula, c.forms, tolerance, 0.0);
    EXPECT_EQ(slanting.n_failed, 0);
    EXPECT_GT(slanting.bound, straight);
    EXPECT_LE(slanting.bound, tolerance);
}

TEST(FineCertificate, CountsTurns)
{
    // The fine mesh inside out: signs hold nowhere.
    const Coarse c(sphere(10), 0.4);
    FineMesh fine = c.cut(0.01, 1'000'000);
    ASSERT_TRUE(fine.stuck.empty());
    for (Triangle& t : fine.surface.mesh.faces) std::swap(t[1], t[2]);
    const Certificate turned =
        certify_within(c.sandwich, c.mesh, fine, c.formula, c.forms, 0.01, 0.0);
    EXPECT_EQ(turned.n_failed, static_cast<std::int64_t>(c.mesh.mesh.n_faces()));
}

TEST(Embedding, IsShownWithoutLookingAtPairsOfFaces)
{
    for (const Solid& solid :
         {bored_ball(), intersect({cylinder(20, 4, 4, true),
                                   transformed(cylinder(20, 3, 3, true), rotation_x(90))})}) {
        const Coarse c(solid, 0.2);
        for (const double tolerance : {0.01, 0.001}) {
            const FineMesh fine = c.cut(tolerance, 1'000'000);
            ASSERT_TRUE(fine.stuck.empty());
            EXPECT_TRUE(proven_embedded(c.shell, fine));
            EXPECT_TRUE(validate(fine.surface.mesh).ok());
        }
    }
}

TEST(Embedding, IsNotShownOfAMeshThatCrossesItself)
{
    const Coarse c(bored_ball(), 0.4);
    const FineMesh good = c.cut(0.04, 100'000);
    ASSERT_TRUE(good.stuck.empty());
    const unsigned seed = 20261122;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    int shown = 0, crossing = 0;
    for (int trial = 0; trial < 60; ++trial) {
        FineMesh bad = good;
        const double size = std::pow(10.0, -2.0 + 0.05 * trial);
        for (int k = 0; k < 3; ++k)
            for (double& x : bad.surface.mesh.vertices[random() % good.direction.size()].c)
                x += size * (static_cast<double>(random() >> 5) * 0x1p-26 - 1.0);
        const bool ok = validate(bad.surface.mesh).ok(), proven = proven_embedded(c.shell, bad);
        if (!ok) {
            ++crossing;
            EXPECT_FALSE(proven) << trial;
        }
        shown += proven ? 1 : 0;
    }
    EXPECT_GT(shown, 5);
    EXPECT_GT(crossing, 5);
    // Valid as a mesh, but turned inside out.
    FineMesh turned = good;
    for (Triangle& t : turned.surface.mesh.faces) std::swap(t[1], t[2]);
    EXPECT_FALSE(proven_embedded(c.shell, turned));
}

TEST(Fibres, ThickPrismsRoundACurveAreDoubtful)
{
    // M+ and M- a whole radius from a bore: fibres leave the solid into the bore and enter again.
    const Coarse c(bored_ball(), 0.4);
    EXPECT_TRUE(doubtful_prisms(c.mesh, c.sandwich, c.formula, c.forms, 0.0).faces.empty());
    Sandwich thick = c.sandwich;
    for (std::size_t v = 0; v < c.mesh.mesh.n_vertices(); ++v) {
        const Vec3& p = c.mesh.mesh.vertices[v];
        thick.outer.vertices[v] = p + 30.0 * (c.sandwich.outer.vertices[v] - p);
        thick.inner.vertices[v] = p + 30.0 * (c.sandwich.inner.vertices[v] - p);
    }
    EXPECT_FALSE(doubtful_prisms(c.mesh, thick, c.formula, c.forms, 0.0).faces.empty());
}

TEST(SurfaceForm, SlopesRangesAndRootsHold)
{
    const Box3 box{{{-8, -8, -8}}, {{8, 8, 8}}};
    const CsgField field(unite({sphere(3), torus(5, 1), cylinder(4, 2, 1)}));
    for (const Surface& surface : field.surfaces()) {
        const SurfaceForm form(surface, box);
        const std::vector<Vec3> hull{
            {{1, 2, 0.5}}, {{1.2, 2.1, 0.4}}, {{0.9, 2.2, 0.7}}, {{1.1, 1.9, 0.9}}};
        const Vec3 way{{0.2, 0.9, 0.1}};
        const Interval range = form.range(std::span<const Vec3>(hull));
        const double slope = form.least_slope(hull, way, 1.0);
        for (int i = 0; i <= 8; ++i)
            for (int j = 0; i + j <= 8; ++j)
                for (int k = 0; i + j + k <= 8; ++k) {
                    const Vec3 p =
                        (i * hull[0] + j * hull[1] + k * hull[2] + (8 - i - j - k) * hull[3]) / 8.0;
                    EXPECT_LE(range.lo, form.value(p));
                    EXPECT_GE(range.hi, form.value(p));
                    EXPECT_LE(slope, dot(form.gradient(p), way));
                }
        if (const auto t = form.root_along(hull[0], way)) {
            EXPECT_LE(std::fabs(form.value(hull[0] + *t * way)), form.slack());
        }
    }
}

TEST(TwoLanes, ComeOutAsEachAlone)
{
    const unsigned seed = 20261122;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto number = [&] { return static_cast<double>(random() >> 5) * 0x1p-26 - 1.0; };
    const auto point = [&] { return Vec3{{number(), number(), number()}}; };
    const Box3 box{{{-8, -8, -8}}, {{8, 8, 8}}};
    const CsgField field(
        unite({sphere(3), transformed(ellipsoid({{3, 2, 1}}), rotation_x(30)), cylinder(4, 2, 1)}));
    for (const Surface& surface : field.surfaces()) {
        const SurfaceForm form(surface, box);
        double stiffest = 0.0;
        for (int trial = 0; trial < 1000; ++trial) {
            const Vec3 p = point(), q = point();
            const TwoVec both_of(p, q);
            const Two value = form.value(both_of), bend = form.bend(both_of);
            const TwoVec gradient = form.gradient(both_of);
            EXPECT_EQ(value[0], form.value(p));
            EXPECT_EQ(value[1], form.value(q));
            EXPECT_EQ(bend[1], form.bend(q));
            EXPECT_EQ(gradient[0], form.gradient(p));
            EXPECT_EQ(gradient[1], form.gradient(q));
            stiffest = std::max(stiffest, std::fabs(form.bend(normalized(p))));
        }
        EXPECT_LE(stiffest, form.most_bend() * (1.0 + 1e-12));
        EXPECT_GE(4.0 * stiffest, form.most_bend());
    }
    for (int trial = 0; trial < 1000; ++trial) {
        const std::array<double, 3> k{number(), 0.3 + number(), 0.3 + number()},
            l{1.0 + 0.1 * number(), 1.0 + 0.1 * number(), 1.0};
        const Two most = most_between({Two{k[0], l[0]}, Two{k[1], l[1]}, Two{k[2], l[2]}});
        EXPECT_DOUBLE_EQ(most[0], most_between(k));
        EXPECT_DOUBLE_EQ(most[1], most_between(l));
    }
}

}  // namespace
}  // namespace genus
