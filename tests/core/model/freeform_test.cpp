#include "genus/model/freeform.h"

#include <gtest/gtest.h>

#include <cmath>

#include "genus/base/error.h"
#include "genus/mesh/distance.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/deformed.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/patch_solid.h"
#include "genus/patch/bspline_surface.h"

namespace genus {
namespace {

// A ball as a NURBS surface turned about z.
PatchModel ball_of_patches(double r)
{
    const BSpline half = elliptic_arc({}, {{0, 0, -r}}, {{r, 0, 0}}, 0.0, 180.0);
    const BSplineSurface surface = surface_of_revolution(half);
    std::vector<Patch> patches;
    for (TensorPatch& p : surface.bezier_patches()) patches.emplace_back(std::move(p));
    return oriented(PatchModel(std::move(patches)));
}

Lattice bulge()
{
    Lattice l({{-2, -2, -2}}, {Vec3{{4, 0, 0}}, Vec3{{0, 4, 0}}, Vec3{{0, 0, 4}}}, {4, 4, 4});
    std::vector<Vec3> moves(l.n_points());
    for (int i = 1; i < 4; ++i)
        for (int j = 1; j < 4; ++j)
            for (int k = 1; k < 4; ++k)
                moves[l.index(i, j, k)] = {{0.1 * j, 0.05 * k, 0.15 * i - 0.25}};
    l.set_moves(std::move(moves));
    return l;
}

MeshOptions within(double tolerance, MeshMethod method = MeshMethod::Auto)
{
    MeshOptions options;
    options.tolerance = tolerance;
    options.method = method;
    return options;
}

TEST(PatchSolid, ABallOfPatchesIsABall)
{
    const Solid ball = patch_solid(ball_of_patches(2.0));
    const MeshedSolid made = mesh_solid(ball, within(0.01));
    EXPECT_TRUE(validate(made.mesh).ok());
    EXPECT_TRUE(made.error.certified);
    EXPECT_LE(made.error.measured, made.error.bound);
    EXPECT_LE(made.error.bound, 0.01);
    for (const Vec3& v : made.mesh.vertices) EXPECT_NEAR(norm(v), 2.0, 1e-13);
    // Less the exact ball of half the size, and in its place.
    const MeshedSolid shell =
        mesh_solid(subtract({transformed(ball, translation({{9, 0, 0}})),
                             transformed(sphere(1.0), translation({{9, 0, 0}}))}),
                   within(0.01));
    EXPECT_TRUE(validate(shell.mesh).ok());
    EXPECT_EQ(topology(shell.mesh).components.size(), 2u);
    EXPECT_NEAR(volume(shell.mesh), 4.0 / 3.0 * 3.14159265358979 * 7.0, 0.01 * 63.0);
}

TEST(PatchSolid, EqualPatchesAreOneLeaf)
{
    const Solid a = patch_solid(ball_of_patches(2.0)), b = patch_solid(ball_of_patches(2.0));
    EXPECT_EQ(a, b);
    EXPECT_EQ(a.hash(), b.hash());
    EXPECT_FALSE(a == patch_solid(ball_of_patches(2.5)));
    const MeshedSolid made = mesh_solid(unite({a, b}), within(0.05));
    EXPECT_EQ(made.mesh.n_faces(), mesh_solid(a, within(0.05)).mesh.n_faces());
}

TEST(PatchSolid, RefusesWhatIsOpenOrTurned)
{
    const PatchModel ball = ball_of_patches(1.0);
    std::vector<Patch> some(ball.patches().begin(), ball.patches().end() - 1);
    EXPECT_THROW(patch_solid(PatchModel(some)), InvalidInput);
    std::vector<Patch> turned = ball.patches();
    turned[0] = std::get<TensorPatch>(turned[0]).transposed();
    EXPECT_THROW(patch_solid(PatchModel(turned)), InvalidInput);
    // Turned back by what is done for text models.
    EXPECT_EQ(oriented(PatchModel(turned)).patches(), ball.patches());
    std::vector<Patch> inside_out;
    for (const Patch& p : ball.patches())
        inside_out.emplace_back(std::get<TensorPatch>(p).transposed());
    EXPECT_EQ(oriented(PatchModel(inside_out)).patches(), ball.patches());
    EXPECT_THROW(mesh_solid(patch_solid(PatchModel(inside_out)), within(0.1)), InvalidInput);
    EXPECT_THROW(patch_solid(PatchModel({})), InvalidInput);
}

TEST(Deformed, BothWaysAgree)
{
    const Solid bored = subtract({sphere(1.3), cylinder(5, 0.5, 0.5, true)});
    const Solid bent = deformed(bored, bulge());
    const MeshedSolid a = mesh_solid(bent, within(0.04));
    EXPECT_TRUE(a.error.certified);
    EXPECT_LE(a.error.measured, a.error.bound);
    EXPECT_EQ(topology(a.mesh).genus, 1);
    const MeshedSolid b = mesh_solid(bent, within(0.1, MeshMethod::Emc));
    EXPECT_TRUE(b.error.certified);
    EXPECT_LE(b.error.measured, b.error.bound);
    EXPECT_LE(b.error.bound, 0.1);
    EXPECT_EQ(topology(b.mesh).genus, 1);
    const double apart = mesh_distance(a.mesh, b.mesh).max;
    EXPECT_LE(apart, a.error.bound + b.error.bound);
    EXPECT_GT(apart, 0.0);
}

TEST(Deformed, TheFunctionIsThatOfTheSolidAtTheSource)
{
    const Solid part = intersect({sphere(1.2), cube({{2, 2, 2}}, true)});
    const Lattice lattice = bulge();
    const Solid bent = deformed(part, lattice);
    const auto field = std::get<Freeform>(bent.node().shape).source->field();
    ASSERT_TRUE(field);
    for (double x = -1.9; x < 2.0; x += 0.37)
        for (double y = -1.9; y < 2.0; y += 0.41)
            for (double z = -1.9; z < 2.0; z += 0.43) {
                const Vec3 p = {{x, y, z}}, q = lattice.apply(p);
                const bool inside =
                    norm(p) <= 1.2 && std::fabs(x) <= 1 && std::fabs(y) <= 1 && std::fabs(z) <= 1;
                EXPECT_EQ(field->value(q) <= 0.0, inside) << x << " " << y << " " << z;
                const Box3 box = Box3{q, q}.inflated(0.1);
                EXPECT_TRUE(field->bound(box).contains(field->value(q)));
                EXPECT_LE(field->bound(box).lo, field->value(q + Vec3{{0.1, -0.1, 0.05}}));
            }
}

TEST(Deformed, BoxesHoldTheSolid)
{
    const Solid bent = deformed(cube({{2, 2, 2}}, true), bulge());
    const MeshedSolid made = mesh_solid(bent, within(0.05));
    for (const Vec3& v : made.mesh.vertices) EXPECT_TRUE(bent.bounds().contains(v));
    // Twice: a deformed solid has no formula, but it can be deformed and cut.
    const Solid twice = subtract({deformed(bent, bulge()), cylinder(6, 0.3, 0.3, true)});
    const MeshedSolid cut = mesh_solid(twice, within(0.05));
    EXPECT_TRUE(validate(cut.mesh).ok());
    EXPECT_EQ(topology(cut.mesh).genus, 1);
    // By the inverse map the mesh of the bent one stands for its formula.
    const MeshedSolid again = mesh_solid(deformed(bent, bulge()), within(0.1, MeshMethod::Emc));
    EXPECT_TRUE(validate(again.mesh).ok());
    EXPECT_LE(again.error.measured, again.error.bound);
    EXPECT_LE(again.error.bound, 0.1);
}

TEST(Deformed, AFoldIsNamed)
{
    Lattice fold({}, {Vec3{{1, 0, 0}}, Vec3{{0, 1, 0}}, Vec3{{0, 0, 1}}}, {3, 3, 3});
    for (int j = 1; j < 3; ++j)
        for (int k = 1; k < 3; ++k) fold.set_point(1, j, k, {{4, j / 3.0, k / 3.0}});
    const Solid bent = deformed(cube({{1, 1, 1}}), fold);
    EXPECT_THROW(mesh_solid(bent, within(0.01)), InvalidInput);
    EXPECT_THROW(deformed(half_space({{0, 0, 1}}, 0.0), fold), UnboundedSolid);
}

}  // namespace
}  // namespace genus
