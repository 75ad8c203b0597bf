#include "genus/model/certificate.h"
#include "genus/model/fans.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>

#include "genus/base/parallel.h"
#include "genus/mesh/topology.h"
#include "genus/model/deviation.h"
#include "genus/model/refine.h"

namespace genus {
namespace {

// A solid with all that a certificate needs.
struct Scene {
    explicit Scene(const Solid& solid)
        : field(solid), formula(field), cube(cell_cube(solid.bounds()))
    {
        for (const Surface& s : field.surfaces()) forms.emplace_back(s, cube);
    }
    SurfaceMesh mesh(double cosine) const
    {
        CellMesher mesher(formula, forms, cube);
        CellDemands demands;
        demands.max_error = cube.diagonal();
        demands.min_cosine = demands.min_cosine_several = cosine;
        mesher.refine(demands, 1'000'000);
        SurfaceMesh result = mesher.extract();
        EXPECT_TRUE(separate_fans(result));
        FlexibleMesh shaped(std::move(result));
        coarsen(shaped, forms);
        result = shaped.release();
        settle(result, forms);
        return result;
    }
    Certificate certify(const SurfaceMesh& m, double tolerance) const
    {
        return genus::certify(m, formula, forms, cube, tolerance);
    }

    CsgField field;
    SignFormula formula;
    Box3 cube;
    std::vector<SurfaceForm> forms;
};

Solid moved(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

TEST(Certificate, BoundsTheDeviationOfMeshesOfAnyCoarseness)
{
    for (const Solid& solid : {sphere(5), subtract({sphere(5), cylinder(20, 2, 2, true)}),
                               torus(5, 2), intersect({cube({{8, 8, 8}}, true), sphere(5)})}) {
        const Scene scene(solid);
        for (const double cosine : {0.8, 0.95, 0.99}) {
            SCOPED_TRACE(cosine);
            const SurfaceMesh mesh = scene.mesh(cosine);
            const double measured = measure_deviation(mesh, scene.formula, scene.forms, scene.cube);
            const Certificate c = scene.certify(mesh, 3.0 * measured);
            EXPECT_EQ(c.n_failed, 0);
            EXPECT_LE(measured, c.bound);
            EXPECT_LE(c.bound, 3.0 * measured);
        }
    }
}

TEST(Certificate, SeesAVertexOutOfPlace)
{
    const Scene scene(sphere(5));
    SurfaceMesh mesh = scene.mesh(0.98);
    const double sound = scene.certify(mesh, 1.0).bound;
    for (const double by : {0.3, -0.3}) {
        SurfaceMesh bad = mesh;
        bad.mesh.vertices[7] = (1.0 + by / 5.0) * bad.mesh.vertices[7];
        const Certificate c = scene.certify(bad, 1.0);
        EXPECT_GT(c.bound, 0.299);
        EXPECT_LT(sound, 0.15);
        EXPECT_GT(scene.certify(bad, 0.25).n_failed, 0);
    }
}

TEST(Certificate, SeesAPartThatTheMeshLacks)
{
    // The mesh is of the large sphere alone; the solid has a small one beside it, or a bubble.
    const SurfaceMesh mesh = Scene(sphere(5)).mesh(0.98);
    for (const Solid& solid : {unite({sphere(5), moved(sphere(0.3), 7, 0, 0)}),
                               subtract({sphere(5), moved(sphere(0.3), 2, 1, 0)})}) {
        const Scene scene(solid);
        SurfaceMesh lacking = mesh;
        for (std::int32_t& label : lacking.surface_of_face) {
            const double outer = scene.forms[0].value({{0, 0, 5}});
            label = std::fabs(outer) < 1e-9 ? 0 : 2;
        }
        for (auto& on : lacking.surfaces_of_vertex) on[0] = lacking.surface_of_face[0] / 2;
        EXPECT_GT(scene.certify(lacking, 0.2).n_failed, 0);
    }
}

TEST(Certificate, SeesAPartThatTheSolidLacks)
{
    const Scene both(unite({sphere(5), moved(sphere(1), 7, 0, 0)}));
    const SurfaceMesh mesh = both.mesh(0.98);
    const Scene one(sphere(5));
    SurfaceMesh more = mesh;
    for (std::int32_t& label : more.surface_of_face) label = 0;
    for (auto& on : more.surfaces_of_vertex) on = {0, -1, -1};
    EXPECT_GT(one.certify(more, 0.2).n_failed, 0);
}

TEST(SignFormula, KeepsItsTruthWhenSignsBecomeKnown)
{
    std::mt19937 random(5);
    const auto between = [&](double lo, double hi) {
        return lo + (hi - lo) * static_cast<double>(random() >> 5) / (1u << 27);
    };
    for (int seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        std::vector<Solid> parts;
        for (int i = 0; i < 3; ++i)
            parts.push_back(moved(cube({{4, 4, 4}}), std::floor(between(-3, 3)),
                                  std::floor(between(-3, 3)), 0));
        const Solid solid =
            unite({subtract({parts[0], parts[1]}), intersect({parts[1], parts[2]})});
        const CsgField field(solid);
        const SignFormula formula(field);
        const std::size_t n = field.surfaces().size();
        for (int trial = 0; trial < 50; ++trial) {
            const Vec3 p{{between(-4, 8), between(-4, 8), between(-1, 5)}};
            std::vector<Sign> all(n), some(n, Sign{0});
            for (std::size_t s = 0; s < n; ++s) {
                all[s] = field.surfaces()[s].value(p) <= 0.0 ? Sign{-1} : Sign{1};
                if (random() % 2 == 0) some[s] = all[s];
            }
            const Sign truth = field.value(p) <= 0.0 ? Sign{-1} : Sign{1};
            EXPECT_EQ(formula.sign(all), truth);
            const SignFormula rest = formula.simplified(some);
            EXPECT_EQ(rest.sign(all), truth);
            const Sign by_cases = formula.sign_by_cases(some);
            if (by_cases != 0) {
                EXPECT_EQ(by_cases, truth);
            }
        }
    }
}

// Of five surfaces, one of them used both ways, all 3^5 sets of known signs, in pieces and from
// several threads at once: what is remembered from before is what is found anew.
TEST(SignFormula, RemembersTheTruthInParallel)
{
    std::vector<Solid> s;
    for (int i = 0; i < 5; ++i) s.push_back(moved(sphere(2), i, 0, 0));
    const CsgField field(
        subtract({unite({s[0], intersect({s[1], s[2]})}), unite({s[3], intersect({s[1], s[4]})})}));
    const SignFormula formula(field);
    ASSERT_EQ(field.surfaces().size(), 5u);
    constexpr std::size_t kSets = 243, kTimes = 3;
    std::atomic<int> wrong{0}, decided{0};
    parallel_for(kTimes * kSets, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            std::vector<Sign> some(5), fewer(5, Sign{0}), all(5);
            for (std::size_t i = 0, rest = n % kSets; i < 5; ++i, rest /= 3) {
                some[i] = static_cast<Sign>(rest % 3) - 1;
                if (i % 2 == 0) fewer[i] = some[i];
            }
            const SignFormula at_once = formula.simplified(some);
            const SignFormula by_steps = formula.simplified(fewer).simplified(some);
            bool any = false, both = false;
            Sign first = 0;
            for (unsigned bits = 0; bits < 32; ++bits) {
                for (std::size_t i = 0; i < 5; ++i)
                    all[i] = some[i] != 0 ? some[i] : (bits >> i & 1) != 0 ? Sign{1} : Sign{-1};
                const Sign truth = formula.sign(all);
                if (at_once.sign(all) != truth || by_steps.sign(all) != truth) ++wrong;
                both = both || (any && truth != first);
                first = any ? first : truth;
                any = true;
            }
            if (at_once.constant() != (both ? 0 : first) ||
                by_steps.constant() != at_once.constant())
                ++wrong;
            decided += both ? 0 : 1;
        }
    });
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(decided, 100);
}

TEST(SurfaceForm, RangesHoldAllValuesAndAreSharpForQuadrics)
{
    std::mt19937 random(9);
    const auto between = [&](double lo, double hi) {
        return lo + (hi - lo) * static_cast<double>(random() >> 5) / (1u << 27);
    };
    const auto point = [&] { return Vec3{{between(-6, 6), between(-6, 6), between(-6, 6)}}; };
    const Scene scene(unite({transformed(ellipsoid({{1, 2, 3}}), rotation({{10, 20, 30}})),
                             transformed(torus(4, 1), rotation({{50, 60, 10}})), cylinder(4, 2, 1),
                             cube({{3, 3, 3}})}));
    for (int trial = 0; trial < 300; ++trial) {
        const std::array<Vec3, 3> t{point(), point(), point()};
        const std::array<Vec3, 4> tet{t[0], t[1], t[2], point()};
        Box3 box;
        for (const Vec3& p : tet) box.add(p);
        for (const SurfaceForm& form : scene.forms) {
            const Interval over_triangle = form.range(t), over_tet = form.range(tet);
            const Interval over_box = form.range(box);
            const IntervalVec3 slopes = form.gradient_range(box);
            Interval seen(form.value(t[0]));
            for (int i = 0; i < 200; ++i) {
                double a = between(0, 1), b = between(0, 1), c = between(0, 1);
                if (i < 60) c = 0.0;
                const double sum = a + b + c;
                const Vec3 p = (a * t[0] + b * t[1] + c * t[2]) / sum;
                const double value = form.value(p);
                seen = hull(seen, Interval(value));
                EXPECT_TRUE(over_triangle.contains(value));
                EXPECT_TRUE(over_tet.contains(value));
                EXPECT_TRUE(over_box.contains(value));
                const Vec3 q = 0.7 * p + 0.3 * tet[3];
                EXPECT_TRUE(over_tet.contains(form.value(q)));
                for (std::size_t k = 0; k < 3; ++k)
                    EXPECT_TRUE(slopes[k].contains(form.gradient(q)[k]));
            }
            if (form.is_plane()) {
                EXPECT_LE(over_triangle.width(), 1.6 * seen.width() + 1e-9);
            }
        }
    }
}

TEST(ShortestDirection, MeetsAllDemandsAndIsShortest)
{
    std::mt19937 random(3);
    const auto between = [&](double lo, double hi) {
        return lo + (hi - lo) * static_cast<double>(random() >> 5) / (1u << 27);
    };
    for (int trial = 0; trial < 300; ++trial) {
        std::vector<Vec3> normals;
        std::vector<double> demands;
        for (unsigned i = 0; i < 1 + random() % 5; ++i) {
            normals.push_back(normalized(Vec3{{between(-1, 1), between(-1, 1), between(0.1, 1)}}));
            demands.push_back(between(-0.5, 1));
        }
        const auto d = shortest_direction(normals, demands);
        ASSERT_TRUE(d.has_value());
        for (std::size_t i = 0; i < normals.size(); ++i)
            EXPECT_GE(dot(normals[i], *d), demands[i] - 1e-8 * (1.0 + norm(*d)));
        // No other feasible vector is shorter: d is the projection of the origin, so that
        // d . (x - d) >= 0 for feasible x.
        for (int i = 0; i < 100; ++i) {
            const Vec3 x{{between(-3, 3), between(-3, 3), between(-3, 3)}};
            bool feasible = true;
            for (std::size_t k = 0; k < normals.size(); ++k)
                feasible = feasible && dot(normals[k], x) >= demands[k];
            if (feasible) {
                EXPECT_GE(dot(*d, x - *d), -1e-7 * (1.0 + dot(*d, *d)));
            }
        }
    }
    const std::vector<Vec3> opposite{{{0, 0, 1}}, {{0, 0, -1}}};
    EXPECT_FALSE(shortest_direction(opposite, std::vector<double>{1.0, 1.0}));
}

TEST(FlexibleMesh, KeepsTheSurfaceThroughRandomChanges)
{
    const Scene scene(subtract({sphere(5), cylinder(20, 2, 2, true)}));
    FlexibleMesh mesh(scene.mesh(0.9));
    std::mt19937 random(11);
    for (int step = 0; step < 3000; ++step) {
        const auto s = static_cast<std::int32_t>(random() % static_cast<unsigned>(mesh.n_sides()));
        if (!mesh.alive(s)) continue;
        switch (random() % 3) {
            case 0:
                mesh.split(s, 0.5 * (mesh.point(mesh.from(s)) + mesh.point(mesh.to(s))),
                           mesh.surfaces(mesh.from(s)));
                break;
            case 1:
                mesh.flip(s);
                break;
            default:
                if (mesh.can_collapse(s)) mesh.collapse(s);
        }
    }
    const SurfaceMesh result = mesh.release();
    const Topology t = topology(result.mesh);
    EXPECT_TRUE(t.closed && t.oriented && t.manifold);
    EXPECT_EQ(t.euler, 0);
}

TEST(SeparateFans, MakesACheckerboardManifold)
{
    const Solid a = cube({{10, 10, 10}}), b = moved(cube({{10, 10, 10}}), 5, 5, -1);
    const Scene scene(unite({subtract({a, b}), subtract({b, a})}));
    const SurfaceMesh mesh = scene.mesh(0.9);
    const Topology t = topology(mesh.mesh);
    EXPECT_TRUE(t.closed && t.oriented && t.manifold);
}

}  // namespace
}  // namespace genus
