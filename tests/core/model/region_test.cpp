// Meshes of a region: what is in a box, at the cost of that.

#include <gtest/gtest.h>

#include <cmath>

#include "genus/base/error.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/validate.h"
#include "genus/model/mesh_solid.h"

namespace genus {
namespace {

Solid at(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

// n by n bored balls, no two alike, on a square of side n.
Solid scene(int n)
{
    std::vector<Solid> parts;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double r = 0.3 + 0.1 * std::sin(1.0 + i + 0.37 * j);
            parts.push_back(at(subtract({sphere(r), cylinder(2, 0.4 * r, 0.4 * r, true)}), i + 0.5,
                               j + 0.5, 0));
        }
    return unite(std::move(parts));
}

TEST(Region, WorkIsDoneForWhatIsInItAlone)
{
    // Of 400 parts the box holds four; tests/bench/bench.py times one of 10,000.
    constexpr int n = 20, side = 2, low = 9;
    const Solid all = scene(n);
    MeshOptions options;
    options.tolerance = 0.02;
    options.measure = false;
    options.region = Box3{{{low, low, -1}}, {{low + side, low + side, 1}}};
    const MeshedSolid part = mesh_solid(all, options);
    // The same as the parts in it by themselves.
    std::vector<Solid> inside;
    for (const Solid& s : parts_of(all.node()))
        if (overlap(s.bounds(), *options.region)) inside.push_back(s);
    EXPECT_EQ(inside.size(), static_cast<std::size_t>(side * side));
    options.region.reset();
    const MeshedSolid alone = mesh_solid(unite(inside), options);
    EXPECT_EQ(part.mesh.n_faces(), alone.mesh.n_faces());
    EXPECT_NEAR(volume(part.mesh), volume(alone.mesh), 0.02 * area(alone.mesh));
    // Leaves elsewhere are left out before anything is meshed, and no stage sees them after that.
    std::int64_t left_out = 0, meshed = 0;
    for (const auto& entry : part.explanation.entries) {
        if (entry.unit == "leaves") left_out += entry.count;
        if (entry.unit == "parts") meshed += entry.count;
    }
    EXPECT_GE(left_out, 2 * (n * n - side * side));
    EXPECT_EQ(meshed, side * side);
}

TEST(Region, PartsAcrossItsBorderAreCutAndClosed)
{
    MeshOptions options;
    options.tolerance = 0.01;
    for (const bool use_plan : {true, false}) {
        options.plan = use_plan;
        options.region = Box3{{{0, 0, 0}}, {{2, 2, 2}}};
        const MeshedSolid made = mesh_solid(sphere(1), options);
        EXPECT_TRUE(validate(made.mesh).ok());
        EXPECT_TRUE(made.error.certified);
        EXPECT_NEAR(volume(made.mesh), 3.14159265358979 / 6, 0.02);
        options.region = Box3{{{5, 5, 5}}, {{6, 6, 6}}};
        EXPECT_TRUE(mesh_solid(sphere(1), options).mesh.faces.empty());
        // Unbounded outside, bounded in it.
        options.region = Box3{{{-1, -1, -1}}, {{1, 1, 1}}};
        const MeshedSolid half = mesh_solid(half_space({{1, 2, 3}}, 0.0), options);
        EXPECT_NEAR(volume(half.mesh), 4.0, 1e-6);
    }
}

TEST(Region, IsABox)
{
    MeshOptions options;
    options.region = Box3{{{0, 0, 0}}, {{1, 0, 1}}};
    EXPECT_THROW(mesh_solid(sphere(1), options), InvalidInput);
    options.region = Box3::everything();
    EXPECT_THROW(mesh_solid(sphere(1), options), InvalidInput);
    options.region = Box3{};
    EXPECT_THROW(mesh_solid(sphere(1), options), InvalidInput);
}

}  // namespace
}  // namespace genus
