#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <vector>

#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/volume/cell_tunnel.h"
#include "genus/volume/marching_cubes.h"

namespace genus {
namespace {

bool is_long()
{
    return std::getenv("GENUS_LONG") != nullptr;
}

bool is_closed_manifold(const IndexedMesh& mesh)
{
    const Topology t = topology(mesh);
    return t.closed && t.oriented && t.manifold && t.degenerate_faces.empty();
}

std::size_t count_samples(const GridSize& size)
{
    return static_cast<std::size_t>(size[0]) * size[1] * size[2];
}

// Components of the surface and its Euler number.
struct Kind {
    std::int64_t euler;
    std::size_t components;
    bool operator==(const Kind&) const = default;
};
Kind kind(const IndexedMesh& mesh)
{
    const Topology t = topology(mesh);
    return {t.euler, t.components.size()};
}

// The trilinear interpolant of a grid, sampled n times as densely along each axis.
Grid refined(const Grid& grid, int n)
{
    GridSize size = grid.size();
    for (auto& s : size) s = (s - 1) * n + 1;
    std::vector<double> values;
    values.reserve(count_samples(size));
    for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i)
                values.push_back(
                    grid.value({{static_cast<double>(i) / n, static_cast<double>(j) / n,
                                 static_cast<double>(k) / n}}));
    return Grid(size, values);
}

Grid random_grid(const GridSize& size, std::mt19937& random)
{
    std::uniform_real_distribution<double> number(-1, 1);
    std::vector<double> values(count_samples(size));
    for (double& v : values) v = number(random);
    return Grid(size, values);
}

Grid integer_grid(const GridSize& size, int largest, std::mt19937& random)
{
    std::uniform_int_distribution<int> number(-largest, largest);
    std::vector<double> values(count_samples(size));
    for (double& v : values) v = number(random);
    return Grid(size, values);
}

// Values of the corners with a tunnel between corners 0 and 7.
constexpr std::array<double, 8> kTunnel{-1.0, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, -1.0};

TEST(CellTunnel, JoinsOppositeCornersThatAreApartOnAllFaces)
{
    ASSERT_TRUE(cell_tunnel(kTunnel));
    const IndexedMesh joined =
        marching_cubes(Grid({2, 2, 2}, std::vector<double>(kTunnel.begin(), kTunnel.end())));
    EXPECT_TRUE(is_closed_manifold(joined));
    EXPECT_EQ(kind(joined), (Kind{2, 1}));  // capped at the corners: one ball

    std::array<double, 8> apart = kTunnel;
    for (double& v : apart)
        if (v > 0) v = 0.9;
    EXPECT_FALSE(cell_tunnel(apart));
    const IndexedMesh two =
        marching_cubes(Grid({2, 2, 2}, std::vector<double>(apart.begin(), apart.end())));
    EXPECT_EQ(kind(two), (Kind{4, 2}));
}

// F(t, t, t) = -(1-t)^3 + 3 v (1-t)^2 t + 3 v (1-t) t^2 - t^3 touches zero in the middle where
// -2 + 6 v = 0; exactly there the corners count as apart, and one last digit decides.
TEST(CellTunnel, IsDecidedToTheLastDigit)
{
    const auto with = [](double v) {
        return cell_tunnel({-1.0, v, v, v, v, v, v, -1.0}).has_value();
    };
    const double third = 1.0 / 3.0;  // rounded down: below the exact value
    EXPECT_TRUE(with(third));
    EXPECT_FALSE(with(std::nextafter(third, 1.0)));
    // The tie, with numbers that say it exactly.
    EXPECT_FALSE(cell_tunnel({-3.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -3.0}));
    // Common factors do not count.
    for (const double scale : {1e-300, 1e-30, 1e30, 1e300}) {
        std::array<double, 8> values = kTunnel;
        for (double& v : values) v *= scale;
        EXPECT_TRUE(cell_tunnel(values)) << scale;
    }
}

TEST(CellTunnel, WaistLiesOnTheTrilinearSurface)
{
    std::mt19937 random(11);
    int found = 0;
    for (int trial = 0; trial < 20'000; ++trial) {
        const Grid grid = random_grid({2, 2, 2}, random);
        std::array<double, 8> values;
        std::copy(grid.values().begin(), grid.values().end(), values.begin());
        const auto tunnel = cell_tunnel(values);
        if (!tunnel) continue;
        ++found;
        for (const Vec3& p : tunnel->waist) ASSERT_NEAR(grid.value(p), 0.0, 1e-9) << trial;
    }
    EXPECT_GT(found, 50);
}

TEST(CellTopology, IsThatOfTheTrilinearInterpolantInOneCell)
{
    std::mt19937 random(12);
    const int trials = is_long() ? 20'000 : 400;
    int several = 0;
    for (int trial = 0; trial < trials; ++trial) {
        const Grid grid = random_grid({2, 2, 2}, random);
        const Kind ours = kind(marching_cubes(grid));
        several += ours.components > 1 || ours.euler != 2;
        // Nearly touching sheets need many samples to be told apart.
        bool agrees = false;
        for (int n = 6; n <= 192 && !agrees; n *= 2)
            agrees = kind(marching_cubes(refined(grid, n))) == ours;
        ASSERT_TRUE(agrees) << "trial " << trial << " of seed 12";
    }
    EXPECT_GT(several, trials / 20);
}

TEST(CellTopology, IsThatOfTheTrilinearInterpolantOnGrids)
{
    std::mt19937 random(13);
    const int trials = is_long() ? 300 : 12;
    for (int trial = 0; trial < trials; ++trial) {
        const Grid grid = random_grid({4, 4, 4}, random);
        const Kind ours = kind(marching_cubes(grid));
        bool agrees = false;
        for (int n = 8; n <= 128 && !agrees; n *= 2)
            agrees = kind(marching_cubes(refined(grid, n))) == ours;
        EXPECT_TRUE(agrees) << "trial " << trial << " of seed 13";
    }
}

// The decision inside a cell sweeps it along z; nothing may depend on that.
TEST(CellTopology, DoesNotChangeWhenAxesAreExchanged)
{
    std::mt19937 random(14);
    const int trials = is_long() ? 20'000 : 1'000;
    for (int trial = 0; trial < trials; ++trial) {
        const Grid grid = trial % 2 == 0 ? random_grid({3, 3, 3}, random)
                                         : integer_grid({3, 3, 3}, 1 + trial % 4, random);
        const Kind as_is = kind(marching_cubes(grid));
        constexpr std::array<std::array<int, 3>, 2> turns{{{1, 2, 0}, {2, 1, 0}}};
        for (const auto& turn : turns) {
            std::vector<double> values(27);
            for (int n = 0; n < 27; ++n) {
                const std::array<int, 3> at{n % 3, n / 3 % 3, n / 9};
                values[n] = grid.at(at[turn[0]], at[turn[1]], at[turn[2]]);
            }
            ASSERT_EQ(kind(marching_cubes(Grid({3, 3, 3}, values))), as_is)
                << "trial " << trial << " of seed 14";
        }
    }
}

// Corner values whose signs are given and whose sizes are random, zeros among those outside.
void expect_sound_patterns(const GridSize& size, std::mt19937& random)
{
    std::uniform_int_distribution<int> number(0, 5);
    const std::size_t n = count_samples(size);
    for (unsigned pattern = 0; pattern < 1U << n; ++pattern) {
        std::vector<double> values;
        for (std::size_t c = 0; c < n; ++c)
            values.push_back((pattern >> c & 1) != 0 ? -number(random) - 1 : number(random));
        ASSERT_TRUE(is_closed_manifold(marching_cubes(Grid(size, values)))) << pattern;
    }
}

TEST(CellTopology, EveryPatternIsClosedAndManifold)
{
    std::mt19937 random(15);
    for (int repeat = 0; repeat < 20; ++repeat) expect_sound_patterns({2, 2, 2}, random);
}

TEST(CellTopology, EveryPairOfPatternsIsClosedAndManifold)
{
    std::mt19937 random(16);
    for (int repeat = 0; repeat < (is_long() ? 50 : 1); ++repeat)
        for (const GridSize& size : {GridSize{3, 2, 2}, {2, 3, 2}, {2, 2, 3}})
            ASSERT_NO_FATAL_FAILURE(expect_sound_patterns(size, random));
}

TEST(CellTopology, IntegerGridsWithZerosAreClosedAndManifold)
{
    const int trials = is_long() ? 3000 : 100;
    for (int n = 2; n <= 6; ++n)
        for (int trial = 0; trial < trials; ++trial) {
            std::mt19937 random(trial);
            const int largest = 1 + trial % 4;
            const IndexedMesh mesh = marching_cubes(integer_grid({n, n, n}, largest, random));
            ASSERT_TRUE(is_closed_manifold(mesh)) << n << "^3, seed " << trial;
            for (const Vec3& v : mesh.vertices) ASSERT_TRUE(is_finite(v)) << n << " " << trial;
        }
}

TEST(CellTopology, ValuesThatAreNotFiniteLeaveNoHole)
{
    constexpr double inf = std::numeric_limits<double>::infinity();
    const std::array<double, 5> odd{inf, -inf, std::nan(""), 1e308, -1e308};
    for (int trial = 0; trial < 500; ++trial) {
        std::mt19937 random(trial);
        std::uniform_int_distribution<int> number(-2, 2), which(0, 9);
        std::vector<double> values(64);
        for (double& v : values) {
            const int n = which(random);
            v = n < 5 ? odd[n] : number(random);
        }
        ASSERT_TRUE(is_closed_manifold(
            marching_cubes(std::span<const double>(values), {4, 4, 4}, GridFrame{})))
            << trial;
    }
}

// The same surface from an array in either order, turned outward both times.
TEST(CellTopology, OrderOfTheArrayDoesNotMatter)
{
    std::mt19937 random(17);
    const GridSize size{3, 5, 4};
    const GridFrame frame{{{1, 2, 3}}, {{0.5, 0.25, 2}}};
    const Grid source = random_grid(size, random);
    const Grid grid(size, {source.values().begin(), source.values().end()}, frame);
    std::vector<double> turned;
    for (int i = 0; i < size[0]; ++i)
        for (int j = 0; j < size[1]; ++j)
            for (int k = 0; k < size[2]; ++k) turned.push_back(grid.at(i, j, k));
    MarchingCubesOptions options;
    options.order = SampleOrder::LastFastest;
    const IndexedMesh a = marching_cubes(grid);
    const IndexedMesh b = marching_cubes(std::span<const double>(turned), size, frame, options);
    EXPECT_EQ(kind(a), kind(b));
    EXPECT_TRUE(is_closed_manifold(b));
    EXPECT_NEAR(volume(a), volume(b), 0.1 * volume(a));  // inner vertices apart
    EXPECT_EQ(bounds(a), bounds(b));
}

}  // namespace
}  // namespace genus
