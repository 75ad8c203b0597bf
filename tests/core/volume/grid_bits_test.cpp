#include "genus/volume/grid_bits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "genus/mesh/topology.h"
#include "genus/volume/crossed_cells.h"
#include "genus/volume/cube_cases.h"
#include "genus/volume/extended_marching_cubes.h"
#include "genus/volume/field_samples.h"
#include "genus/volume/marching_cubes.h"

namespace genus {
namespace {

// The same samples in both ways: tiles that are inside, outside or anything.
struct Both {
    Both(const GridSize& size, std::mt19937& random) : dense(size), tiled(size)
    {
        std::uniform_int_distribution<int> kind(0, 3);
        const auto& n = tiled.n_tiles();
        for (std::int32_t k = 0; k < n[2]; ++k)
            for (std::int32_t j = 0; j < n[1]; ++j)
                for (std::int32_t i = 0; i < n[0]; ++i) fill({i, j, k}, kind(random), random);
        tiled.find_slots();
    }

    DenseBits dense;
    TiledBits tiled;

private:
    void fill(const std::array<std::int32_t, 3>& at, int kind, std::mt19937& random)
    {
        const GridSize& size = dense.size();
        const std::int32_t width = std::min(64, size[0] - 64 * at[0]);
        const SampleWord mask = width == 64 ? ~SampleWord{0} : (SampleWord{1} << width) - 1;
        TiledBits::Tile words{};
        std::size_t n_full = 0;
        for (std::int32_t z = 0; z < 16 && 16 * at[2] + z < size[2]; ++z)
            for (std::int32_t y = 0; y < 16 && 16 * at[1] + y < size[1]; ++y) {
                SampleWord word = 0;
                if (kind == 1) word = mask;
                if (kind >= 2) word = (SampleWord{random()} << 32 | random()) & mask;
                words[static_cast<std::size_t>(y + 16 * z)] = word;
                n_full += word == ~SampleWord{0};
                const std::size_t row = static_cast<std::size_t>(16 * at[1] + y) +
                                        static_cast<std::size_t>(size[1]) * (16 * at[2] + z);
                dense.words_of(row)[at[0]] = word;
            }
        const std::size_t tile = tiled.number(at[0], at[1], at[2]);
        if (kind == 0) return;
        if (n_full == TiledBits::kTileWords)
            tiled.set_inside(tile);
        else
            tiled.store(tile, words);
    }
};

template <typename Bits>
std::vector<std::int64_t> all_numbers(const Bits& bits)
{
    CrossedCells<Bits> cells(bits);
    using Counts = typename CrossedCells<Bits>::RowCounts;
    cells.number([](const CrossedCell& c) { return Counts{c.cube % 3, c.cube % 5}; });
    std::vector<std::int64_t> out{cells.n_vertices(), cells.n_triangles()};
    for (std::size_t slot = 0; slot < cells.n_slots(); ++slot) {
        cells.visit_edges(slot, [&](std::int64_t number, int axis, int i, int j, int k) {
            out.insert(out.end(), {number, axis, i, j, k});
        });
        cells.template visit_row<true>(slot, [&](const CrossedCell& c) {
            out.insert(out.end(), {c.i, c.j, c.k, c.cube});
            for (std::size_t e = 0; e < 12; ++e) {
                if ((c.cube >> kCubeEdges[e].from & 1) != (c.cube >> kCubeEdges[e].to & 1))
                    out.push_back(c.vertex[e]);
            }
            out.push_back(cells.first_inner_vertex(slot));
            out.push_back(cells.first_triangle(slot));
        });
    }
    return out;
}

TEST(TiledBits, NumberCellsAndEdgesAsDenseBitsDo)
{
    std::mt19937 random(31);
    for (const GridSize size : {GridSize{130, 35, 40}, GridSize{64, 16, 16}, GridSize{65, 17, 33},
                                GridSize{2, 2, 2}, GridSize{200, 50, 3}})
        for (int trial = 0; trial < 4; ++trial) {
            const Both bits(size, random);
            EXPECT_EQ(all_numbers(bits.tiled), all_numbers(bits.dense)) << size[0] << " " << trial;
        }
}

TEST(TiledBits, SlotsAreRowsInOrder)
{
    std::mt19937 random(32);
    const Both bits({70, 90, 45}, random);
    std::size_t last = 0;
    for (std::size_t slot = 0; slot < bits.tiled.n_slots(); ++slot) {
        const std::size_t row = bits.tiled.row_of(slot);
        if (slot > 0) {
            ASSERT_GT(row, last);
        }
        ASSERT_EQ(bits.tiled.slot_of(row), static_cast<std::ptrdiff_t>(slot));
        last = row;
    }
}

// The nearest of several balls; in a box only those that may be.
class Balls final : public Implicit {
public:
    explicit Balls(std::vector<Vec3> centers, double radius)
        : centers_(std::move(centers)), radius_(radius)
    {
    }
    double value(const Vec3& p) const override
    {
        double least = std::numeric_limits<double>::infinity();
        for (const Vec3& c : centers_) least = std::min(least, distance(p, c) - radius_);
        return least;
    }
    Vec3 gradient(const Vec3& p) const override
    {
        const Vec3* nearest = &centers_[0];
        for (const Vec3& c : centers_)
            if (distance(p, c) < distance(p, *nearest)) nearest = &c;
        return normalized(p - *nearest);
    }
    Interval bound(const Box3& box) const override
    {
        Interval all(std::numeric_limits<double>::infinity());
        for (const Vec3& c : centers_) all = min(all, bound_of(c, box));
        return all;
    }
    IntervalVec3 gradient_bound(const Box3&) const override
    {
        return {Interval(-1, 1), Interval(-1, 1), Interval(-1, 1)};
    }
    std::shared_ptr<const Implicit> within(const Box3& box) const override
    {
        const double most = bound(box).hi;
        std::vector<Vec3> kept;
        for (const Vec3& c : centers_)
            if (bound_of(c, box).lo <= most) kept.push_back(c);
        if (kept.size() == centers_.size()) return nullptr;
        return std::make_shared<const Balls>(std::move(kept), radius_);
    }

private:
    Interval bound_of(const Vec3& c, const Box3& box) const
    {
        const IntervalVec3 b = to_intervals({box.min - c, box.max - c});
        return sqrt(square(b[0]) + square(b[1]) + square(b[2])) - Interval(radius_);
    }

    std::vector<Vec3> centers_;
    double radius_;
};

TEST(FieldSamples, AWideSceneIsTheSameWithAndWithoutSkipping)
{
    std::mt19937 random(33);
    std::uniform_real_distribution<double> place(-0.9, 0.9);
    std::vector<Vec3> centers(12);
    for (Vec3& c : centers) c = {{place(random), place(random), place(random)}};
    const Balls balls(centers, 0.07);
    const Box3 box{{{-1, -1, -1}}, {{1, 1, 1}}};
    for (const double level : {0.0, -0.02, 0.05}) {
        MarchingCubesOptions options;
        SamplingReport report;
        options.cell_size = 0.019;
        options.level = level;
        options.report = &report;
        const IndexedMesh mesh = marching_cubes(balls, box, options);
        EXPECT_GT(report.decided, 0.97 * static_cast<double>(report.samples));
        options.skip = false;
        EXPECT_EQ(marching_cubes(balls, box, options), mesh);
        EXPECT_EQ(report.decided, 0);
        EXPECT_TRUE(topology(mesh).closed);
        ExtendedMarchingCubesOptions extended;
        extended.cell_size = 0.019;
        extended.level = level;
        const IndexedMesh sharp = extended_marching_cubes(balls, box, extended);
        extended.skip = false;
        EXPECT_EQ(extended_marching_cubes(balls, box, extended), sharp);
    }
}

TEST(FieldSamples, WhatIsStoredGrowsWithTheSurface)
{
    const Balls ball({{{0.1, -0.2, 0.05}}}, 0.7);
    const Box3 box{{{-1, -1, -1}}, {{1, 1, 1}}};
    std::vector<double> stored;
    for (const double cell : {1.0 / 64, 1.0 / 128, 1.0 / 256}) {
        const FieldSamples samples(ball, cover(box, cell), 0.0, true);
        stored.push_back(static_cast<double>(samples.bits().n_stored()));
    }
    EXPECT_LT(stored[1], 5.0 * stored[0]);
    EXPECT_LT(stored[2], 4.6 * stored[1]);
    // A grid far beyond what one bit a sample would let fit into memory.
    const FieldSamples wide(ball, cover({{{-30, -30, -30}}, {{30, 30, 30}}}, 1.0 / 64), 0.0, true);
    EXPECT_GT(wide.n_samples(), std::int64_t{56'000'000'000});
    EXPECT_LT(static_cast<double>(wide.bits().n_stored()), 1.5 * stored[0]);
}

}  // namespace
}  // namespace genus
