#include "genus/implicit/quadric_form.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/implicit/random_shapes.h"
#include "genus/base/error.h"

namespace genus {
namespace {

using K = QuadricKind;

struct Sample {
    Quadric quadric;
    K kind;
};

/// One of each kind, as polynomials a x^2 + b y^2 + c z^2 + d xy + e xz + f yz + g x + h y + i z +
/// j.
std::vector<Sample> one_of_each()
{
    const auto q = [](std::array<double, 10> c) { return Quadric::from_polynomial(c); };
    return {
        {q({0, 0, 0, 0, 0, 0, 0, 0, 0, -1}), K::Everything},
        {q({0, 0, 0, 0, 0, 0, 0, 0, 0, 1}), K::Nothing},
        {q({1, 1, 1, 0, 0, 0, 0, 0, 0, 1}), K::Nothing},
        {q({-1, -1, 0, 0, 0, 0, 0, 0, 0, -1}), K::Everything},
        {q({0, 0, 0, 0, 0, 0, 1, 2, 3, 4}), K::HalfSpace},
        {q({1, -1, 0, 0, 0, 0, 0, 0, 0, 0}), K::PlanePair},
        {q({0, 0, 0, 1, 0, 0, 0, 0, 0, 0}), K::PlanePair},
        {q({1, 0, 0, 0, 0, 0, 0, 0, 0, -1}), K::ParallelPlanes},
        {q({1, 0, 0, 0, 0, 0, 0, 0, 0, 0}), K::DoublePlane},
        {q({1, 1, 0, 0, 0, 0, 0, 0, 0, 0}), K::Line},
        {q({1, 2, 3, 0, 0, 0, 0, 0, 0, 0}), K::Point},
        {Quadric::sphere(3), K::Ellipsoid},
        {Quadric::ellipsoid({{1, 2, 3}}), K::Ellipsoid},
        {q({-1, -2, -3, 0, 0, 0, 0, 0, 0, 4}), K::Ellipsoid},
        {Quadric::cylinder(2), K::EllipticCylinder},
        {q({1, -1, 0, 0, 0, 0, 0, 0, 0, 1}), K::HyperbolicCylinder},
        {q({1, 0, 0, 0, 0, 0, 0, 1, 0, 0}), K::ParabolicCylinder},
        {Quadric::cone(1, 0.5), K::Cone},
        {Quadric::cone(0, 2), K::Cone},
        {q({1, 2, 0, 0, 0, 0, 0, 0, 1, 0}), K::EllipticParaboloid},
        {q({-1, -2, 0, 0, 0, 0, 0, 0, 1, 3}), K::EllipticParaboloid},
        {q({1, -2, 0, 0, 0, 0, 0, 0, 1, 0}), K::HyperbolicParaboloid},
        {q({1, 1, -1, 0, 0, 0, 0, 0, 0, -1}), K::OneSheetHyperboloid},
        {q({-1, 1, 1, 0, 0, 0, 0, 0, 0, -1}), K::OneSheetHyperboloid},
        {q({-1, 1, -1, 0, 0, 0, 0, 0, 0, 1}), K::OneSheetHyperboloid},
        {q({1, 1, -1, 0, 0, 0, 0, 0, 0, 1}), K::TwoSheetHyperboloid},
        {q({-1, -1, 1, 0, 0, 0, 0, 0, 0, -1}), K::TwoSheetHyperboloid},
    };
}

/// |F(p)| over the sum of the absolute values of its terms.
double residual(const Quadric& quadric, const Vec3& p)
{
    std::array<double, 10> q = quadric.local();
    for (double& c : q) c = std::fabs(c);
    Vec3 d = p - quadric.origin();
    for (double& c : d.c) c = std::fabs(c);
    const double terms = Quadric(q).value(d);
    return terms > 0.0 ? std::fabs(quadric.value(p)) / terms : 0.0;
}

void expect_points_on_the_surface(const Quadric& quadric, RandomShapes& random)
{
    const QuadricForm form(quadric);
    for (int sample = 0; form.n_sheets() > 0 && sample < 20; ++sample) {
        const int sheet = sample % form.n_sheets();
        const double u = random.in(-2, 2), v = random.in(-2, 2);
        const Vec3 p = form.point(u, v, sheet);
        EXPECT_LT(residual(quadric, p), 1e-12) << to_string(form.kind());
        const Vec3 n = form.normal(u, v, sheet);
        // Degenerate kinds have no gradient on the surface.
        if (form.kind() == K::DoublePlane || form.kind() == K::Line || form.kind() == K::Point)
            continue;
        EXPECT_NEAR(norm(n), 1.0, 1e-12);
        const double step = 1e-4 * norm(form.axes()[0]);
        const bool peak = std::fabs(v) < 0.01;  // near an apex a step may leave the other side
        if (!peak) {
            EXPECT_GT(quadric.value(p + step * n), quadric.value(p - step * n));
        }
    }
}

TEST(QuadricForm, KnowsEveryKind)
{
    std::set<K> seen;
    for (const Sample& sample : one_of_each()) {
        EXPECT_EQ(to_string(classify(sample.quadric)), to_string(sample.kind));
        seen.insert(sample.kind);
    }
    EXPECT_EQ(seen.size(), 17U);
}

TEST(QuadricForm, KindDoesNotChangeUnderAffineMaps)
{
    RandomShapes random(11);
    for (const Sample& sample : one_of_each())
        for (int trial = 0; trial < 200; ++trial) {
            const Quadric moved = transformed(sample.quadric, random.affine());
            EXPECT_EQ(to_string(classify(moved)), to_string(sample.kind)) << "trial " << trial;
            EXPECT_EQ(to_string(classify(moved.scaled(1e-20))), to_string(sample.kind));
        }
}

TEST(QuadricForm, PointsLieOnTheSurfaceAndNormalsPointOutward)
{
    RandomShapes random(12);
    for (const Sample& sample : one_of_each()) {
        SCOPED_TRACE(to_string(sample.kind));
        expect_points_on_the_surface(sample.quadric, random);
        for (int trial = 0; trial < 50; ++trial)
            expect_points_on_the_surface(transformed(sample.quadric, random.affine()), random);
    }
}

TEST(QuadricForm, StandsAspectRatiosOf1e12)
{
    RandomShapes random(13);
    const Quadric needle = Quadric::ellipsoid({{1e-6, 1.0, 1e6}});
    EXPECT_EQ(classify(needle), K::Ellipsoid);
    expect_points_on_the_surface(needle, random);
    const QuadricForm form(needle);
    std::array<double, 3> reach{};
    for (const Vec3& axis : form.axes())
        for (int i = 0; i < 3; ++i) reach[i] = std::max(reach[i], std::fabs(axis[i]));
    EXPECT_NEAR(reach[0], 1e-6, 1e-18);
    EXPECT_NEAR(reach[1], 1.0, 1e-12);
    EXPECT_NEAR(reach[2], 1e6, 1e-6);
}

TEST(QuadricForm, RefusesSheetsThatAreNotThere)
{
    EXPECT_THROW(QuadricForm(Quadric::sphere(1)).point(0, 0, 1), InvalidInput);
    EXPECT_THROW(QuadricForm(Quadric({0, 0, 0, 0, 0, 0, 0, 0, 0, 1})).point(0, 0), InvalidInput);
}

}  // namespace
}  // namespace genus
