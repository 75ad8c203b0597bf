#include "genus/volume/extended_marching_cubes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

#include "genus/base/transform.h"
#include "genus/implicit/function.h"
#include "genus/implicit/parse_expression.h"
#include "genus/implicit/quadric.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/volume/marching_cubes.h"

namespace genus {
namespace {

// The common part of quadric solids, some of them turned inside out.
class Meet final : public Implicit {
public:
    struct Part {
        Quadric quadric;
        double sign = 1.0;
    };
    explicit Meet(std::vector<Part> parts) : parts_(std::move(parts)) {}

    double value(const Vec3& p) const override
    {
        const std::int32_t n = piece(p);
        return parts_[n].sign * parts_[n].quadric.value(p);
    }
    Vec3 gradient(const Vec3& p) const override
    {
        const std::int32_t n = piece(p);
        return parts_[n].quadric.gradient(p) * parts_[n].sign;
    }
    Interval bound(const Box3& box) const override
    {
        Interval range(-1e300, -1e300);
        for (const Part& part : parts_)
            range = max(range, part.quadric.bound(box) * Interval(part.sign));
        return range;
    }
    IntervalVec3 gradient_bound(const Box3&) const override
    {
        return {Interval::everything(), Interval::everything(), Interval::everything()};
    }
    std::int32_t piece(const Vec3& p) const override
    {
        std::int32_t best = 0;
        for (std::size_t n = 1; n < parts_.size(); ++n)
            if (signed_value(n, p) > signed_value(best, p)) best = static_cast<std::int32_t>(n);
        return best;
    }
    double piece_value(std::int32_t n, const Vec3& p) const override
    {
        return parts_[n].quadric.value(p);
    }
    Vec3 piece_gradient(std::int32_t n, const Vec3& p) const override
    {
        return parts_[n].quadric.gradient(p);
    }

private:
    double signed_value(std::size_t n, const Vec3& p) const
    {
        return parts_[n].sign * parts_[n].quadric.value(p);
    }
    std::vector<Part> parts_;
};

std::vector<Meet::Part> box_parts(double half)
{
    std::vector<Meet::Part> parts;
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            Vec3 normal;
            normal[axis] = sign;
            parts.push_back({Quadric::half_space(normal, half)});
        }
    return parts;
}

// Odd sides keep planes of the solid off the planes of the grid.
const Box3 kBox{{{-1.313, -1.271, -1.297}}, {{1.279, 1.307, 1.263}}};

ExtendedMarchingCubesOptions cells(double size)
{
    ExtendedMarchingCubesOptions options;
    options.cell_size = size;
    return options;
}

void expect_sound(const IndexedMesh& mesh)
{
    const Topology t = topology(mesh);
    EXPECT_TRUE(t.closed && t.oriented && t.manifold);
}

TEST(ExtendedMarchingCubes, MakesACubeWithItsTrueEdgesAndCorners)
{
    const IndexedMesh mesh = extended_marching_cubes(Meet(box_parts(1.0)), kBox, cells(0.11));
    expect_sound(mesh);
    EXPECT_EQ(topology(mesh).euler, 2);
    EXPECT_TRUE(validate(mesh).ok());
    EXPECT_NEAR(volume(mesh), 8.0, 1e-13);
    EXPECT_NEAR(measure(mesh).area, 24.0, 1e-12);
    int corners = 0;
    for (const Vec3& v : mesh.vertices)
        corners += std::fabs(v[0]) > 1 - 1e-14 && std::fabs(v[1]) > 1 - 1e-14 &&
                   std::fabs(v[2]) > 1 - 1e-14;
    EXPECT_EQ(corners, 8);
}

TEST(ExtendedMarchingCubes, MeetsTheEdgesOfABoredBoxToTheLastDigits)
{
    auto parts = box_parts(1.0);
    parts.push_back({Quadric::cylinder(0.6), -1.0});
    const Meet field(parts);
    const IndexedMesh mesh = extended_marching_cubes(field, kBox, cells(0.07));
    expect_sound(mesh);
    EXPECT_EQ(topology(mesh).genus, 1);
    // Along the rims of the bore, z = +-1 and x^2 + y^2 = 0.36.
    int rim = 0;
    double largest = 0.0;
    for (const Vec3& v : mesh.vertices) {
        const double bore = std::hypot(v[0], v[1]) - 0.6, face = std::fabs(v[2]) - 1.0;
        if (std::fabs(bore) > 1e-3 || std::fabs(face) > 1e-3) continue;
        ++rim;
        if (std::fabs(face) < 1e-6) largest = std::max(largest, std::fabs(bore));
    }
    EXPECT_GT(rim, 100);
    EXPECT_LT(largest, 1e-12);
}

TEST(ExtendedMarchingCubes, VolumeOfABoredBoxConvergesWithTheSquareOfTheCell)
{
    auto parts = box_parts(1.0);
    parts.push_back({Quadric::cylinder(0.6), -1.0});
    const Meet field(parts);
    const double exact = 8.0 - 2 * 0.36 * std::numbers::pi;
    const auto error = [&](double h) {
        return std::fabs(volume(extended_marching_cubes(field, kBox, cells(h))) - exact);
    };
    const double coarse = error(0.16), fine = error(0.04);
    EXPECT_NEAR(std::log2(coarse / fine) / 2, 2.0, 0.35);
}

TEST(ExtendedMarchingCubes, ReachesCornersThatMarchingCubesCutsOffByAShareOfACell)
{
    const Meet field(box_parts(1.0));
    const auto miss = [](const IndexedMesh& mesh) {
        double nearest = 1e9;
        for (const Vec3& v : mesh.vertices)
            nearest = std::min(nearest, distance(v, Vec3{{1, 1, 1}}));
        return nearest;
    };
    for (const double h : {0.2, 0.1, 0.05}) {
        MarchingCubesOptions plain;
        plain.cell_size = h;
        EXPECT_GT(miss(marching_cubes(field, kBox, plain)), 0.1 * h);
        EXPECT_LT(miss(extended_marching_cubes(field, kBox, cells(h))), 1e-14);
    }
}

// The largest angle, as a sine, between a face and the nearest in direction of the surfaces that
// pass within a cell of its middle.
double largest_turn(const IndexedMesh& mesh, const Meet& field, std::size_t n_parts, double h)
{
    double most = 0.0;
    for (const Triangle& t : mesh.faces) {
        const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        const Vec3 normal = cross(b - a, c - a);
        if (norm(normal) < 1e-6 * h * h) continue;
        const Vec3 middle = (a + b + c) / 3.0;
        double least = 1.0;
        for (std::size_t n = 0; n < n_parts; ++n) {
            const auto piece = static_cast<std::int32_t>(n);
            const Vec3 g = field.piece_gradient(piece, middle);
            if (std::fabs(field.piece_value(piece, middle)) > h * norm(g)) continue;
            least = std::min(least, norm(cross(normalized(normal), normalized(g))));
        }
        most = std::max(most, least);
    }
    return most;
}

TEST(ExtendedMarchingCubes, NormalsConvergeWherePlainOnesDoNot)
{
    auto parts = box_parts(1.0);
    parts.push_back({Quadric::cylinder(0.6), -1.0});
    const Meet field(parts);
    const auto plain = [&](double h) {
        MarchingCubesOptions options;
        options.cell_size = h;
        return largest_turn(marching_cubes(field, kBox, options), field, parts.size(), h);
    };
    const auto sharp = [&](double h) {
        return largest_turn(extended_marching_cubes(field, kBox, cells(h)), field, parts.size(), h);
    };
    EXPECT_GT(plain(0.16), 0.5);
    EXPECT_GT(plain(0.04), 0.5);
    const double coarse = sharp(0.16), fine = sharp(0.04);
    EXPECT_LT(fine, 0.1);
    EXPECT_GT(std::log2(coarse / fine) / 2, 0.7);  // first order in the cell
}

TEST(ExtendedMarchingCubes, SkippingLeavesTheMeshAsItIs)
{
    auto parts = box_parts(1.0);
    parts.push_back({Quadric::cylinder(0.6), -1.0});
    const Meet box(parts);
    const Function waves(parse_expression("sin(4*x)*cos(3*y) + max(z^2, abs(x)) - 0.8"));
    for (const Implicit* field :
         {static_cast<const Implicit*>(&box), static_cast<const Implicit*>(&waves)}) {
        SamplingReport report;
        MarchingCubesOptions plain, all;
        plain.cell_size = all.cell_size = 0.05;
        plain.report = &report;
        all.skip = false;
        EXPECT_EQ(marching_cubes(*field, kBox, plain), marching_cubes(*field, kBox, all));
        EXPECT_GT(report.decided, report.samples / 3);
        EXPECT_LT(report.decided, report.samples);
        ExtendedMarchingCubesOptions sharp = cells(0.05), every = cells(0.05);
        every.skip = false;
        every.report = &report;
        EXPECT_EQ(extended_marching_cubes(*field, kBox, sharp),
                  extended_marching_cubes(*field, kBox, every));
        EXPECT_EQ(report.decided, 0);
    }
}

TEST(ExtendedMarchingCubes, LeavesASmoothSurfaceToMarchingCubes)
{
    const Quadric ball = Quadric::sphere(1.0);
    MarchingCubesOptions plain;
    plain.cell_size = 0.1;
    EXPECT_EQ(volume(extended_marching_cubes(ball, kBox, cells(0.1))),
              volume(marching_cubes(ball, kBox, plain)));
}

TEST(ExtendedMarchingCubes, SteinmetzSolidHasTheVolumeOfArchimedes)
{
    // Two cylinders of radius 1 at a right angle: 16/3; and their tangent crossings.
    const Quadric upright = Quadric::cylinder(1.0);
    const Quadric lying = transformed(upright, rotation_x(90));
    const Meet field({{upright}, {lying}});
    const IndexedMesh mesh = extended_marching_cubes(field, kBox, cells(0.05));
    expect_sound(mesh);
    EXPECT_EQ(topology(mesh).euler, 2);
    EXPECT_NEAR(volume(mesh), 16.0 / 3.0, 5e-3);
}

// A ball less two bores of one size that cross at right angles: their edges cross on the axis, and
// with the ball they make rims. Features a little outside their cells used to fold fans.
TEST(ExtendedMarchingCubes, IsEmbeddedWhereSharpEdgesRunThroughCornersOfCells)
{
    const Quadric bore = Quadric::cylinder(15);
    const Quadric across({0, 0, 0, 0, 1, 0, 0, 1, 0, -225});
    const Meet field({{Quadric::sphere(50)}, {bore, -1.0}, {across, -1.0}});
    std::int64_t moved = 0;
    for (const double size : {12.7, 9.3, 5.1, 3.9, 2.8, 2.17}) {
        SCOPED_TRACE(size);
        ExtendedMarchingCubesOptions options = cells(size);
        SamplingReport report;
        options.report = &report;
        const IndexedMesh mesh =
            extended_marching_cubes(field, {{{-51, -51, -51}}, {{51, 51, 51}}}, options);
        EXPECT_TRUE(validate(mesh).ok());
        EXPECT_EQ(topology(mesh).genus, 3);
        EXPECT_EQ(report.left_out, 0);
        moved += report.confined;
        // What moved is on its edge still; the middle of a fan without one is a chord off.
        for (const Vec3& v : mesh.vertices) {
            const double off =
                std::min({std::fabs(norm(v) - 50), std::fabs(std::hypot(v[0], v[1]) - 15),
                          std::fabs(std::hypot(v[1], v[2]) - 15)});
            EXPECT_LE(off, 3 * size * size / (8 * 15));  // sagitta of a cell's diagonal
        }
    }
    EXPECT_GT(moved, 0);
}

// Any cut by planes in general position: several sharp edges and corners in a cell, or corners
// just outside it.
TEST(ExtendedMarchingCubes, IsEmbeddedForAnyCutsByPlanesAndBalls)
{
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const int trials = std::getenv("GENUS_LONG") ? 3000 : 25;
    for (int trial = 0; trial < trials; ++trial) {
        SCOPED_TRACE(trial);
        std::vector<Meet::Part> parts{{Quadric::sphere(1.1)}};
        for (int n = 0; n < 5; ++n) {
            const Vec3 direction =
                normalized(Vec3{{normal(random), normal(random), normal(random)}});
            parts.push_back({Quadric::half_space(direction, 0.2 * normal(random) + 0.5)});
        }
        for (int n = 0; n < 2; ++n)
            parts.push_back(
                {transformed(Quadric::sphere(0.35),
                             translation({{normal(random), normal(random), normal(random)}})),
                 -1.0});
        const IndexedMesh mesh = extended_marching_cubes(Meet(parts), kBox, cells(0.23));
        const Validation found = validate(mesh);
        EXPECT_TRUE(found.ok()) << found.findings[0].text;
    }
}

TEST(FeaturePoint, IsWhereThePlanesMeet)
{
    const TangentElement x{{{1, 5, 3}}, {{1, 0, 0}}}, y{{{4, 2, 7}}, {{0, 1, 0}}};
    const TangentElement z{{{0, 0, 3}}, {{0, 0, 1}}};
    const TangentElement corner[] = {x, y, z}, edge[] = {x, y}, plane[] = {x, x};
    const Vec3 c = *feature_point(corner);
    EXPECT_NEAR(distance(c, {{1, 2, 3}}), 0.0, 1e-12);
    const Vec3 e = *feature_point(edge);  // free along z: nearest to the mean of the points
    EXPECT_NEAR(distance(e, {{1, 2, 5}}), 0.0, 1e-12);
    EXPECT_FALSE(feature_point(plane));
}

}  // namespace
}  // namespace genus
