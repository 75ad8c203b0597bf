#include "genus/mesh/extrude.h"

#include <gtest/gtest.h>

#include <numbers>

#include "genus/base/error.h"
#include "genus/base/transform.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"

namespace genus {
namespace {

Ring rectangle(double x, double y, double width, double height)
{
    return {{{x, y}}, {{x + width, y}}, {{x + width, y + height}}, {{x, y + height}}};
}

// A plate with two round holes.
Region plate()
{
    const auto disc = [](double x) {
        Ring ring;
        for (int i = 0; i < 40; ++i)
            ring.push_back({{x + cos_degrees(9.0 * i), 2 + sin_degrees(9.0 * i)}});
        return ring;
    };
    const Region parts[] = {{{rectangle(0, 0, 10, 4)}}, {{disc(3)}}, {{disc(7)}}};
    return subtract(parts);
}

void expect_solid(const PolygonMesh& mesh)
{
    const Validation found = validate(to_triangles(mesh));
    EXPECT_TRUE(found.ok()) << (found.findings.empty() ? "" : found.findings[0].text);
}

TEST(LinearExtrude, HasTheVolumeOfAPrism)
{
    LinearExtrudeOptions options;
    options.height = 3;
    for (const bool center : {false, true}) {
        options.center = center;
        const PolygonMesh mesh = linear_extrude(plate(), options);
        expect_solid(mesh);
        EXPECT_NEAR(volume(to_triangles(mesh)), 3 * area(plate()), 1e-10);
        EXPECT_EQ(topology(mesh).genus, 2);
        EXPECT_EQ(bounds(mesh).min[2], center ? -1.5 : 0.0);
    }
}

TEST(LinearExtrude, ScaledHasTheVolumeOfAFrustum)
{
    LinearExtrudeOptions options;
    options.height = 3;
    for (const double s : {0.5, 0.0, 2.0}) {
        options.scale = {{s, s}};
        const PolygonMesh mesh = linear_extrude({{rectangle(-1, -1, 2, 2)}}, options);
        expect_solid(mesh);
        EXPECT_NEAR(volume(to_triangles(mesh)), 4 * 3 * (1 + s + s * s) / 3, 1e-12);
    }
    EXPECT_EQ(linear_extrude({{rectangle(-1, -1, 2, 2)}}, options).n_vertices(), 8u);
}

TEST(LinearExtrude, TwistedTendsToTheVolumeOfThePrism)
{
    // A twist turns every section and keeps its area; all diagonals lean to one side, so the walls
    // approach the twisted ones with about the first power of the step.
    LinearExtrudeOptions options;
    options.height = 3;
    for (const double twist : {90.0, -90.0, 400.0}) {
        options.twist = twist;
        double last = 0.0;
        for (const int slices : {20, 40, 80}) {
            options.slices = slices;
            const PolygonMesh mesh = linear_extrude({{rectangle(-1, -1, 2, 2)}}, options);
            expect_solid(mesh);
            const double error = std::fabs(volume(to_triangles(mesh)) - 12.0);
            if (last > 0.0) {
                EXPECT_NEAR(error / last, 0.5, 0.08);
            }
            last = error;
        }
    }
}

TEST(RotateExtrude, HasTheVolumeOfPappus)
{
    // Profile off the axis: area times the way of its centre, less what facets cut off.
    const Region profile{{rectangle(2, 0, 1, 1)}};
    RotateExtrudeOptions options;
    for (const double angle : {360.0, 90.0, -270.0}) {
        options.angle = angle;
        options.fragments = 240;
        const PolygonMesh mesh = rotate_extrude(profile, options);
        expect_solid(mesh);
        const double way = 2.5 * std::fabs(angle) / 180 * std::numbers::pi;
        EXPECT_NEAR(volume(to_triangles(mesh)), way, 3e-4 * way);
        EXPECT_EQ(topology(mesh).genus, angle == 360.0 ? 1 : 0);
    }
}

TEST(RotateExtrude, ClosesOnTheAxis)
{
    const Region half_disc = [] {
        Ring ring;
        for (int i = 0; i <= 90; ++i)
            ring.push_back(
                {{i == 0 || i == 90 ? 0.0 : cos_degrees(2.0 * i - 90), sin_degrees(2.0 * i - 90)}});
        return Region{{ring}};
    }();
    RotateExtrudeOptions options;
    for (const double angle : {360.0, 200.0, -30.0}) {
        options.angle = angle;
        options.fragments = 90;
        const PolygonMesh mesh = rotate_extrude(half_disc, options);
        expect_solid(mesh);
        const double ball = 4 * std::numbers::pi / 3 * std::fabs(angle) / 360;
        EXPECT_NEAR(volume(to_triangles(mesh)), ball, 4e-3 * ball);
        EXPECT_EQ(topology(mesh).euler, 2);
    }
}

TEST(RotateExtrude, LeftOfTheAxisIsTheMirrorImage)
{
    RotateExtrudeOptions options;
    options.angle = 100;
    const double right = volume(to_triangles(rotate_extrude({{rectangle(2, 0, 1, 1)}}, options)));
    const PolygonMesh mesh = rotate_extrude({{rectangle(-3, 0, 1, 1)}}, options);
    expect_solid(mesh);
    EXPECT_NEAR(volume(to_triangles(mesh)), right, 1e-12);
}

TEST(Extrude, RegionsThatTouchInAPointGiveAClosedBalancedMesh)
{
    const Region parts[] = {{{rectangle(0, 0, 1, 1)}}, {{rectangle(1, 1, 1, 1)}}};
    const PolygonMesh mesh = linear_extrude(unite(parts), {});
    const Topology t = topology(mesh);
    EXPECT_TRUE(t.closed);
    EXPECT_EQ(t.complex_edges.size(), 1u);  // the common upright edge
    EXPECT_NEAR(volume(to_triangles(mesh)), 2.0, 1e-15);
}

TEST(Extrude, RefusesBadNumbersAndGivesNothingForNothing)
{
    EXPECT_EQ(linear_extrude({}, {}).n_faces(), 0u);
    EXPECT_EQ(rotate_extrude({}, {}).n_faces(), 0u);
    LinearExtrudeOptions linear;
    linear.height = 0;
    EXPECT_THROW(linear_extrude(plate(), linear), InvalidInput);
    linear = {};
    linear.scale = {{0, 1}};
    EXPECT_THROW(linear_extrude(plate(), linear), InvalidInput);
    EXPECT_THROW(rotate_extrude({{rectangle(-1, 0, 2, 1)}}, {}), InvalidInput);
    RotateExtrudeOptions turn;
    turn.angle = 400;
    EXPECT_THROW(rotate_extrude(plate(), turn), InvalidInput);
}

}  // namespace
}  // namespace genus
