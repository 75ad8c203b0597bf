#include "genus/volume/bisection_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

namespace genus {
namespace {

using Face = std::array<std::uint64_t, 3>;

std::int64_t six_volumes(const LatticeTet& t)
{
    std::array<std::array<std::int64_t, 3>, 3> e;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) e[i][j] = t.corner[i + 1].c[j] - t.corner[0].c[j];
    return std::abs(e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                    e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                    e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]));
}

void collect(const BisectionTree& tree, const LatticeTet& tet, std::vector<LatticeTet>& leaves)
{
    if (!tree.is_split(tet)) {
        leaves.push_back(tet);
        return;
    }
    const auto [a, b] = BisectionTree::children(tet);
    collect(tree, a, leaves);
    collect(tree, b, leaves);
}

std::vector<LatticeTet> leaves(const BisectionTree& tree)
{
    std::vector<LatticeTet> all;
    for (const LatticeTet& root : BisectionTree::roots()) collect(tree, root, all);
    return all;
}

bool on_border(const LatticePoint& p, int axis, std::int32_t side)
{
    return p.c[axis] == side;
}

// Every face of a leaf lies on the border of the cube or belongs to exactly one other leaf.
bool conforming(const std::vector<LatticeTet>& tets)
{
    std::map<Face, int> uses;
    std::set<Face> border;
    for (const LatticeTet& t : tets)
        for (int omit = 0; omit < 4; ++omit) {
            Face face;
            std::array<const LatticePoint*, 3> points;
            for (int i = 0, n = 0; i < 4; ++i)
                if (i != omit) points[n++] = &t.corner[i];
            for (int i = 0; i < 3; ++i) face[i] = points[i]->code();
            std::sort(face.begin(), face.end());
            ++uses[face];
            for (int axis = 0; axis < 3; ++axis)
                for (const std::int32_t side : {0, BisectionTree::kSize})
                    if (std::all_of(points.begin(), points.end(),
                                    [&](const auto* p) { return on_border(*p, axis, side); }))
                        border.insert(face);
        }
    return std::all_of(uses.begin(), uses.end(), [&](const auto& entry) {
        return entry.second == (border.count(entry.first) ? 1 : 2);
    });
}

TEST(BisectionTree, StaysConformingAndFillsTheCubeUnderRandomSplits)
{
    for (unsigned seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        BisectionTree tree;
        for (int step = 0; step < 30; ++step) {
            LatticeTet tet = BisectionTree::roots()[random() % 6];
            while (tree.is_split(tet)) {
                const auto [a, b] = BisectionTree::children(tet);
                tet = random() % 4 ? a : b;
            }
            tree.split(BisectionTree::midpoint(tet));
        }
        const std::vector<LatticeTet> all = leaves(tree);
        EXPECT_TRUE(conforming(all));
        // kSize^3 = 2^60, so six times the volume of the cube still fits.
        std::int64_t sum = 0;
        for (const LatticeTet& t : all) sum += six_volumes(t);
        EXPECT_EQ(sum, 6 * (std::int64_t{1} << 60));
    }
}

TEST(BisectionTree, ThreeHalvingsGiveTheFirstShapeAtHalfTheSize)
{
    LatticeTet tet = BisectionTree::roots()[0];
    const std::int64_t volume = six_volumes(tet);
    for (int i = 0; i < 3; ++i) tet = BisectionTree::children(tet).first;
    EXPECT_EQ(tet.k, 3);
    EXPECT_EQ(six_volumes(tet) * 8, volume);
}

TEST(BisectionTree, DescendsToTheFinestLattice)
{
    BisectionTree tree;
    LatticeTet tet = BisectionTree::roots()[0];
    int depth = 0;
    while (!BisectionTree::is_finest(tet)) {
        tree.split(BisectionTree::midpoint(tet));
        tet = BisectionTree::children(tet).second;
        ++depth;
    }
    EXPECT_EQ(depth, 3 * BisectionTree::kLevels);
    EXPECT_TRUE(conforming(leaves(tree)));
}

}  // namespace
}  // namespace genus
