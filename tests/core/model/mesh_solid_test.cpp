#include "genus/model/mesh_solid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/mesh_bound.h"

namespace genus {
namespace {

constexpr double kPi = std::numbers::pi;

bool long_form()
{
    return std::getenv("GENUS_LONG") != nullptr;
}

MeshedSolid meshed(const Solid& solid, double tolerance)
{
    MeshOptions options;
    options.tolerance = tolerance;
    return mesh_solid(solid, options);
}

Solid moved(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

void expect_promises(const MeshedSolid& m, double tolerance)
{
    EXPECT_LE(m.error.measured, m.error.bound * (1.0 + 1e-9) + 1e-13);
    EXPECT_LE(m.error.bound, tolerance);
    EXPECT_TRUE(m.error.certified);
    EXPECT_TRUE(validate(m.mesh).ok());
}

Solid sphere_minus_two_cylinders()
{
    return subtract({sphere(50), cylinder(200, 15, 15, true),
                     transformed(cylinder(200, 10, 10, true), rotation_x(90))});
}

Solid steinmetz(double r)
{
    const Solid c = cylinder(4 * r, r, r, true);
    return intersect({c, transformed(c, rotation_x(90))});
}

TEST(MeshSolid, KeepsTheToleranceOverTenHalvings)
{
    const Solid solid = sphere_minus_two_cylinders();
    double tolerance = 1.28;
    for (int i = 0; i < (long_form() ? 10 : 6); ++i, tolerance *= 0.5) {
        SCOPED_TRACE(tolerance);
        const MeshedSolid m = meshed(solid, tolerance);
        expect_promises(m, tolerance);
        EXPECT_GE(m.error.measured, 0.3 * m.error.bound);
        EXPECT_EQ(topology(m.mesh).euler, -4);
    }
}

TEST(MeshSolid, VolumesTendToTheClosedForms)
{
    struct Case {
        const char* name;
        Solid solid;
        double volume;
    };
    const double d = 3.0, r = 5.0, cap = r - d;  // two spheres, centres 2d apart
    const std::vector<Case> cases{
        {"sphere", sphere(r), 4.0 / 3.0 * kPi * r * r * r},
        {"steinmetz", steinmetz(5), 16.0 / 3.0 * 125.0},
        {"lens", intersect({moved(sphere(r), -d, 0, 0), moved(sphere(r), d, 0, 0)}),
         2.0 * kPi * cap * cap * (3.0 * r - cap) / 3.0},
        {"torus", torus(6, 2), 2.0 * kPi * kPi * 6.0 * 4.0},
        {"half torus", intersect({torus(6, 2), half_space({{1, 0, 0}}, 0)}), kPi * kPi * 6.0 * 4.0},
        {"cone", cylinder(9, 4, 0), kPi * 16.0 * 9.0 / 3.0},
        {"ellipsoid", ellipsoid({{2, 3, 5}}), 4.0 / 3.0 * kPi * 30.0},
    };
    for (const Case& c : cases) {
        double before = 0.0;
        for (const double tolerance : {0.04, 0.01}) {
            SCOPED_TRACE(std::string(c.name) + " " + std::to_string(tolerance));
            const MeshedSolid m = meshed(c.solid, tolerance);
            expect_promises(m, tolerance);
            const Measures measures = measure(m.mesh);
            const double error = std::fabs(measures.volume - c.volume);
            EXPECT_LE(error, 1.05 * measures.area * m.error.bound);
            if (tolerance == 0.01) {
                EXPECT_LT(error, 0.6 * before);
            }
            before = error;
        }
    }
}

TEST(MeshSolid, FindsTheRightNumberOfHandles)
{
    std::vector<Solid> block{
        unite({cube({{100, 60, 12}}), moved(cube({{60, 60, 28}}), 20, 0, 12)})};
    for (const double x : {10.0, 90.0})
        for (const double y : {12.0, 48.0}) {
            block.push_back(moved(cylinder(20, 4, 4), x, y, -1));
            block.push_back(moved(cylinder(20, 7, 7), x, y, 8));
        }
    block.push_back(
        transformed(cylinder(80, 13, 13, true), translation({{50, 30, 26}}) * rotation_x(90)));
    const MeshedSolid bored = meshed(subtract(block), 0.05);
    expect_promises(bored, 0.05);
    EXPECT_EQ(topology(bored.mesh).euler, 2 - 2 * 5);

    const Solid arm = transformed(cylinder(60, 12, 12), rotation_x(90));
    const Solid bore = transformed(cylinder(80, 9, 9), rotation_x(90));
    const Solid tee = subtract({cylinder(100, 15, 15, true), cylinder(120, 12, 12, true), bore});
    const MeshedSolid pipe =
        meshed(unite({tee, subtract({arm, bore, cylinder(120, 12, 12, true)})}), 0.05);
    expect_promises(pipe, 0.05);
    EXPECT_EQ(topology(pipe.mesh).euler, 2 - 2 * 2);

    std::vector<Solid> die{intersect({cube({{20, 20, 20}}, true), sphere(14)})};
    for (const double s : {-1.0, 1.0}) {
        die.push_back(moved(sphere(2.2), 5 * s, 5 * s, 10.8));
        die.push_back(moved(sphere(2.2), 10.8, 5 * s, 0));
        die.push_back(moved(sphere(2.2), -10.8, 0, 5 * s));
    }
    const MeshedSolid pips = meshed(subtract(die), 0.05);
    expect_promises(pips, 0.05);
    EXPECT_EQ(topology(pips.mesh).euler, 2);
}

TEST(MeshSolid, DoesNotDependOnTheFrame)
{
    const Solid solid = subtract({sphere(10), cylinder(40, 4, 4, true)});
    // A sphere with a bore through its centre: 4/3 pi (R^2 - r^2)^(3/2).
    const double exact = 4.0 / 3.0 * kPi * std::pow(100.0 - 16.0, 1.5);
    for (const Transform& t :
         {Transform{}, rotation({{20, 40, 70}}),
          translation({{1000, -300, 77}}) * rotation({{1, 2, 3}}), mirror({{1, 2, 3}})}) {
        const MeshedSolid m = meshed(transformed(solid, t), 0.02);
        expect_promises(m, 0.02);
        const Measures measures = measure(m.mesh);
        EXPECT_NEAR(measures.volume, exact, 1.05 * measures.area * m.error.bound);
        EXPECT_EQ(topology(m.mesh).euler, 0);
    }
}

TEST(MeshSolid, JoinsPartsThatShareAFace)
{
    // A pin fills its hole and sticks out; its surface is that of the hole.
    const Solid bore = moved(cylinder(30, 4, 4, true), 10, 10, 0);
    const Solid pin = moved(cylinder(15, 4, 4), 10, 10, 0);
    const MeshedSolid m = meshed(unite({subtract({cube({{20, 20, 10}}), bore}), pin}), 0.01);
    expect_promises(m, 0.01);
    EXPECT_EQ(topology(m.mesh).euler, 2);
    const Measures measures = measure(m.mesh);
    EXPECT_NEAR(measures.volume, 4000.0 + kPi * 16.0 * 5.0, measures.area * m.error.bound);

    // Two halves of a sphere, put together again.
    const Solid half = intersect({sphere(5), half_space({{0, 0, 1}}, 0)});
    const Solid other = intersect({sphere(5), half_space({{0, 0, -1}}, 0)});
    const MeshedSolid whole = meshed(unite({half, other}), 0.02);
    expect_promises(whole, 0.02);
    EXPECT_EQ(topology(whole.mesh).euler, 2);
    EXPECT_EQ(topology(whole.mesh).components.size(), 1u);
}

TEST(MeshSolid, TouchingPartsEndInAMeshOrAnError)
{
    const std::vector<Solid> scenes{
        unite({sphere(5), moved(sphere(5), 10, 0, 0)}),
        subtract({cylinder(10, 5, 5, true), moved(cylinder(20, 2, 2, true), 3, 0, 0)}),
        unite({cylinder(10, 3, 3, true), moved(cylinder(10, 2, 2, true), 5, 0, 0)}),
        subtract({sphere(5), moved(sphere(2.5), 2.5, 0, 0)}),
        intersect({sphere(5), moved(sphere(5), 10, 0, 0)}),
    };
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        SCOPED_TRACE(i);
        try {
            const MeshedSolid m = meshed(scenes[i], 0.2);
            EXPECT_LE(m.error.measured, m.error.bound * (1.0 + 1e-9) + 1e-13);
            EXPECT_LE(m.error.bound, 0.2);
            EXPECT_TRUE(validate(m.mesh).ok());
        } catch (const ToleranceNotMet& e) {
            EXPECT_EQ(e.asked(), 0.2);
            EXPECT_FALSE(e.where().empty());
        }
    }
}

TEST(MeshSolid, KeepsWallsAsThinAsTheTolerance)
{
    const Solid cup = subtract({cylinder(8, 6, 6), moved(cylinder(20, 5.8, 5.8), 0, 0, 0.2)});
    const MeshedSolid m = meshed(cup, 0.2);
    expect_promises(m, 0.2);
    EXPECT_EQ(topology(m.mesh).euler, 2);
}

TEST(MeshSolid, AnEmptySolidIsAnEmptyMesh)
{
    const MeshedSolid m = meshed(intersect({sphere(1), moved(sphere(1), 1.5, 1.5, 0)}), 0.01);
    EXPECT_EQ(m.mesh.n_faces(), 0u);
    EXPECT_EQ(meshed(Solid(), 0.01).mesh.n_faces(), 0u);
}

TEST(MeshSolid, SharpEdgesAreExact)
{
    const MeshedSolid m =
        meshed(subtract({cube({{20, 20, 20}}, true), cylinder(40, 6, 6, true)}), 0.05);
    expect_promises(m, 0.05);
    int on_rim = 0;
    for (const Vec3& p : m.mesh.vertices) {
        const double r = std::hypot(p[0], p[1]);
        const double box = std::max({std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])});
        EXPECT_TRUE(std::fabs(r - 6.0) < 1e-11 || std::fabs(box - 10.0) < 1e-11);
        on_rim += std::fabs(r - 6.0) < 1e-11 && std::fabs(box - 10.0) < 1e-11;
    }
    EXPECT_GE(on_rim, 2 * 20);
}

TEST(MeshSolid, GridRoadsMeetTheToleranceToo)
{
    // The bore's rims are cut off by plain marching cubes, where only boxes can prove anything.
    const Solid solid = subtract({sphere(5), cylinder(20, 2, 2, true)});
    for (const MeshMethod method : {MeshMethod::Emc, MeshMethod::Mc}) {
        MeshOptions options;
        options.tolerance = 0.2;
        options.method = method;
        const MeshedSolid m = mesh_solid(solid, options);
        EXPECT_LE(m.error.measured, m.error.bound);
        EXPECT_LE(m.error.bound, 0.2);
        EXPECT_TRUE(m.error.certified);
        EXPECT_TRUE(validate(m.mesh).ok());
        EXPECT_EQ(topology(m.mesh).euler, 0);
        const Measures measures = measure(m.mesh);
        EXPECT_NEAR(measures.volume, 4.0 / 3.0 * kPi * std::pow(21.0, 1.5), 0.2 * measures.area);
    }
}

// A mesh against a solid, by boxes.
MeshBound by_boxes(const IndexedMesh& mesh, const Solid& solid, double enough, double most)
{
    const CsgField field(solid);
    const Box3 box = solid.bounds().inflated(0.1);
    std::vector<SurfaceForm> forms;
    for (const Surface& s : field.surfaces()) forms.emplace_back(s, box);
    return bound_by_boxes(mesh, SignFormula(field), forms, box, enough, most, 200'000);
}

TEST(MeshSolid, BoxesBoundWhatNoSampleFinds)
{
    // A cone's tip cut off: the distance is that from the apex to the lid, along the axis.
    const Solid cone = cylinder(4, 1, 0);
    const double cut = 0.25;
    MeshOptions options;
    options.tolerance = 0.01;
    const IndexedMesh blunt =
        mesh_solid(intersect({cone, half_space({{0, 0, 1}}, 4 - cut)}), options).mesh;
    const MeshBound found = by_boxes(blunt, cone, 0.26, 0.3);
    ASSERT_TRUE(found.bound);
    EXPECT_GE(*found.bound, cut - 0.01);
    EXPECT_LE(*found.bound, 0.3);
    const double exceeded = by_boxes(blunt, cone, 0.1, 0.2).exceeded;
    EXPECT_GT(exceeded, 0.2);
    EXPECT_LE(exceeded, cut + 0.01);
    // The other way: a mesh that has what the solid has not.
    const IndexedMesh whole = mesh_solid(cone, options).mesh;
    const Solid blunt_solid = intersect({cone, half_space({{0, 0, 1}}, 4 - cut)});
    EXPECT_FALSE(by_boxes(whole, blunt_solid, 0.1, 0.2).bound);
    const MeshBound back = by_boxes(whole, blunt_solid, 0.26, 0.3);
    ASSERT_TRUE(back.bound);
    EXPECT_GE(*back.bound, cut - 0.01);
    // And a mesh that is right.
    const MeshBound right = by_boxes(whole, cone, 0.05, 0.1);
    ASSERT_TRUE(right.bound);
    EXPECT_LE(*right.bound, 0.05);
}

TEST(MeshSolid, GivesTheSameBitsOnAnyNumberOfThreads)
{
    const Solid solid = sphere_minus_two_cylinders();
    const int before = thread_count();
    set_thread_count(1);
    const MeshedSolid one = meshed(solid, 0.3);
    for (const int threads : {2, 8}) {
        set_thread_count(threads);
        const MeshedSolid many = meshed(solid, 0.3);
        EXPECT_EQ(one.mesh, many.mesh);
        EXPECT_EQ(one.error.bound, many.error.bound);
        EXPECT_EQ(one.error.measured, many.error.measured);
    }
    set_thread_count(before);
}

TEST(MeshSolid, RefusesWhatItCannotDo)
{
    EXPECT_THROW(meshed(sphere(1), 0.0), InvalidInput);
    EXPECT_THROW(meshed(sphere(1), -1.0), InvalidInput);
    EXPECT_THROW(meshed(sphere(1), std::nan("")), InvalidInput);
    EXPECT_THROW(meshed(half_space({{0, 0, 1}}, 0), 0.1), UnboundedSolid);
    MeshOptions options;
    options.tolerance = 1e-6;
    options.max_triangles = 1000;
    EXPECT_THROW(mesh_solid(sphere(1), options), ToleranceNotMet);
}

TEST(MeshSolid, StopsWhenToldTo)
{
    Progress progress;
    progress.cancel();
    const ProgressScope scope(progress);
    EXPECT_THROW(meshed(sphere(1), 0.01), Cancelled);
}

// Random trees over all kinds of leaves.
class RandomTree {
public:
    explicit RandomTree(unsigned seed) : random_(seed) {}

    double between(double lo, double hi)
    {
        return lo + (hi - lo) * static_cast<double>(random_() >> 5) / (1u << 27);
    }
    Solid tree(unsigned n)
    {
        if (n == 1) return leaf();
        const unsigned k = 1 + random_() % (n - 1);
        const Solid a = tree(k), b = tree(n - k);
        switch (random_() % 3) {
            case 0:
                return unite({a, b});
            case 1:
                return subtract({a, b});
            default:
                return intersect({a, b});
        }
    }
    unsigned size() { return 2 + random_() % 5; }

private:
    Solid shape()
    {
        switch (random_() % 6) {
            case 0:
                return cube({{between(2, 10), between(2, 10), between(2, 10)}});
            case 1:
                return sphere(between(2, 6));
            case 2:
                return cylinder(between(2, 12), between(1, 5), between(1, 5), true);
            case 3:
                return cylinder(between(4, 20), 3, 3, true);
            case 4:
                return torus(between(3, 6), between(0.5, 2.5));
            default:
                return ellipsoid({{between(2, 6), between(2, 6), between(2, 6)}});
        }
    }
    Solid leaf()
    {
        const Solid s = shape();
        // Half of them stand straight on whole numbers, so that faces coincide and touch.
        if (random_() % 2 == 0)
            return moved(s, std::floor(between(-4, 4)), std::floor(between(-4, 4)),
                         std::floor(between(-4, 4)));
        const Vec3 by{{between(-4, 4), between(-4, 4), between(-4, 4)}};
        const Vec3 turn{{between(0, 360), between(0, 360), between(0, 360)}};
        return transformed(s, translation(by) * rotation(turn));
    }

    std::mt19937 random_;
};

TEST(MeshSolid, RandomTreesGiveSoundMeshesOrSayWhereNot)
{
    const unsigned n = long_form() ? 400 : 24;
    unsigned met = 0;
    for (unsigned seed = 1; seed <= n; ++seed) {
        SCOPED_TRACE(seed);
        RandomTree random(seed);
        const double tolerance = random.between(0.02, 0.1);
        const Solid solid = random.tree(random.size());
        try {
            const MeshedSolid m = meshed(solid, tolerance);
            EXPECT_LE(m.error.measured, m.error.bound * (1.0 + 1e-9) + 1e-12);
            EXPECT_LE(m.error.bound, tolerance);
            EXPECT_TRUE(validate(m.mesh).ok());
            ++met;
        } catch (const ToleranceNotMet& e) {
            EXPECT_FALSE(e.where().empty());
        }
    }
    RecordProperty("met", static_cast<int>(met));
    EXPECT_GE(met, n - n / 20 - 1) << met << " of " << n;
}

// A cell h errs by h^2 / (8 R). Where a rim runs along a plane of samples a grid errs by a share of
// h, and another has to be tried, not ever finer ones.
TEST(MeshSolid, AGridIsNoFinerThanCurvatureAsks)
{
    const Solid bored = subtract({sphere(50), cylinder(120, 20, 20, true),
                                  transformed(cylinder(120, 15, 15, true), rotation_x(90))});
    MeshOptions options;
    options.tolerance = 0.05;
    options.method = MeshMethod::Emc;
    const MeshedSolid made = mesh_solid(bored, options);
    EXPECT_TRUE(made.error.certified);
    EXPECT_LE(made.error.bound, 0.05);
    // The area in cells, three faces for each, a third of the tolerance being kept in reserve;
    // twice as fine a grid is allowed.
    const double cells = area(made.mesh) * 1.5 / (8.0 * 0.05 * 15.0);
    EXPECT_LT(static_cast<double>(made.mesh.n_faces()), 4 * 3 * cells);
}

}  // namespace
}  // namespace genus
