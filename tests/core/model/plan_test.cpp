#include "genus/model/plan.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>

#include "core/model/random_trees.h"
#include "genus/model/csg_field.h"

namespace genus {
namespace {

Solid at(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

std::int64_t count(const Plan& planned, const std::string& what)
{
    for (const Explanation::Entry& entry : planned.explanation.entries)
        if (entry.what == what) return entry.count;
    return 0;
}

TEST(Plan, DescribesTheSamePoints)
{
    RandomShapes random(51);
    const bool longer = std::getenv("GENUS_LONG") != nullptr;
    std::int64_t before = 0, after = 0;
    int decided = 0, inside = 0;
    for (int trial = 0; trial < (longer ? 30000 : 1000); ++trial) {
        SCOPED_TRACE(trial);
        const Solid tree = random_tree(random, 1 + trial % 14, trial % 2 == 0);
        const Plan planned = plan(tree);
        before += count_leaves(tree);
        after += count_leaves(planned.solid);
        MembershipOracle side, planned_side;
        for (int sample = 0; sample < 60; ++sample) {
            const Vec3 p = random.point(3);
            const double expected = side(tree, p);
            if (side.nearest < 1e-9) continue;
            ++decided;
            inside += expected < 0;
            ASSERT_EQ(planned_side(planned.solid, p) < 0.0, expected < 0.0);
        }
    }
    EXPECT_GT(inside, decided / 20);
    EXPECT_LT(after, before);
    if (longer) std::printf("%lld of %lld leaves kept\n", (long long)after, (long long)before);
}

TEST(Plan, KeepsTheRegionAskedFor)
{
    RandomShapes random(52);
    for (int trial = 0; trial < 500; ++trial) {
        SCOPED_TRACE(trial);
        const Solid tree = random_tree(random, 1 + trial % 14, trial % 2 == 0);
        PlanOptions options;
        options.region = random.box();
        const Plan planned = plan(tree, options);
        MembershipOracle side, planned_side;
        for (int sample = 0; sample < 60; ++sample) {
            const Vec3 p = random.point_in(options.region);
            const double expected = side(tree, p);
            if (side.nearest < 1e-9) continue;
            ASSERT_EQ(planned_side(planned.solid, p) < 0.0, expected < 0.0);
        }
    }
}

TEST(Plan, PartsThatLeanOnEachOtherAreNotBothDropped)
{
    // Each half's outer wall is of no effect inside the box of the other half; without both walls
    // the result would be the long bar.
    const Solid bar = cube({{10, 1, 1}});
    const auto half = [&](double low, double high) {
        const Solid cut = intersect({bar, at(cube({{high - low, 3, 3}}), low, -1, -1)});
        return unite({cut, at(sphere(0.1), low + 0.5, 0.5, 3)});
    };
    const Plan planned = plan(intersect({half(0, 5), half(4, 10)}));
    MembershipOracle side;
    EXPECT_LT(side(planned.solid, {{4.5, 0.5, 0.5}}), 0.0);
    EXPECT_GT(side(planned.solid, {{2, 0.5, 0.5}}), 0.0);
    EXPECT_GT(side(planned.solid, {{8, 0.5, 0.5}}), 0.0);
}

TEST(Plan, ChangesNoBitOfTheFunctionWhereNothingIsDropped)
{
    const Solid part =
        transformed(subtract({cube({{4, 4, 4}}, true), sphere(2.3)}), rotation({{10, 20, 30}}));
    const Solid tree = transformed(unite({part, at(torus(3, 0.5), 0, 0, 1)}),
                                   translation({{0.1, 0.2, 0.3}}) * rotation_z(17));
    const CsgField plain(tree), planned(plan(tree).solid);
    RandomShapes random(53);
    for (int sample = 0; sample < 1000; ++sample) {
        const Vec3 p = random.point(4);
        EXPECT_EQ(std::bit_cast<std::uint64_t>(plain.value(p)),
                  std::bit_cast<std::uint64_t>(planned.value(p)));
    }
}

TEST(Plan, DropsAndCountsWhatHasNoEffect)
{
    const Solid block = cube({{10, 10, 10}});
    const Plan missing = plan(subtract({block, at(sphere(1), 20, 0, 0), at(sphere(1), 5, 5, 5)}));
    EXPECT_EQ(count(missing, "subtracted part misses the solid") +
                  count(missing, "part outside the reach of the operators above"),
              1);
    EXPECT_EQ(count_leaves(missing.solid), 2);

    // Boxes overlap, the balls do not.
    const Plan corners = plan(subtract({sphere(1), at(sphere(1), 1.5, 1.5, 0)}));
    EXPECT_EQ(count(corners, "subtracted part misses the solid"), 1);
    EXPECT_EQ(corners.solid, sphere(1));

    const Plan within =
        plan(unite({at(sphere(1), 5, 5, 5), block, at(cube({{1, 1, 1}}), 2, 2, 2)}));
    EXPECT_EQ(count(within, "united part inside another"), 2);
    EXPECT_EQ(within.solid, block);

    const Plan apart = plan(intersect({block, at(sphere(1), 20, 0, 0)}));
    EXPECT_TRUE(apart.solid.is_empty());
    EXPECT_TRUE(plan(intersect({sphere(1), at(sphere(1), 1.5, 1.5, 0)})).solid.is_empty());
    // Bodies that only touch have no volume in common.
    EXPECT_TRUE(plan(intersect({block, at(block, 10, 0, 0)})).solid.is_empty());

    const Plan swallowed = plan(subtract({at(sphere(1), 5, 5, 5), block}));
    EXPECT_TRUE(swallowed.solid.is_empty());
    EXPECT_TRUE(plan(subtract({block, block})).solid.is_empty());

    const Plan held =
        plan(intersect({at(sphere(1), 5, 5, 5), block, half_space({{0, 0, 1}}, 100)}));
    EXPECT_EQ(count(held, "intersected part holds the rest"), 2);

    const Plan twice = plan(unite({sphere(1), at(sphere(1), 3, 0, 0), sphere(1)}));
    EXPECT_EQ(count(twice, "united part given twice"), 1);

    const Plan nothing = plan(unite({sphere(1), at(sphere(1), 1.5, 0, 0)}));
    EXPECT_EQ(nothing.explanation.to_text(), "nothing was left out");
}

TEST(Plan, FlattensNestedOperators)
{
    const Solid a = cube({{9, 9, 9}});
    Solid chain = a;
    for (int i = 0; i < 5; ++i) chain = subtract({chain, at(sphere(0.4), i, i, i)});
    const Plan planned = plan(chain);
    EXPECT_EQ(parts_of(planned.solid.node()).size(), 6U);
    EXPECT_EQ(count(planned, "nested operators flattened"), 4);
    const Plan grouped =
        plan(subtract({a, unite({at(sphere(1), 1, 1, 1), at(sphere(1), 7, 7, 7)})}));
    EXPECT_EQ(parts_of(grouped.solid.node()).size(), 3U);
    const Plan moved = plan(
        unite({at(unite({sphere(1), at(sphere(1), 1, 0, 0)}), 5, 0, 0), at(sphere(1), 2, 0, 0)}));
    EXPECT_EQ(parts_of(moved.solid.node()).size(), 3U);
}

TEST(Plan, EqualSubtreesBecomeOneNode)
{
    const auto hole = [] { return subtract({sphere(1), at(sphere(1), 0.5, 0, 0)}); };
    const Plan planned = plan(unite({subtract({cube({{3, 3, 3}}), hole()}),
                                     at(subtract({cube({{3, 3, 3}}), hole()}), 0, 0, 0)}));
    EXPECT_EQ(count(planned, "united part given twice"), 3);  // leaves
    EXPECT_GT(count(planned, "equal subtrees shared"), 0);
}

TEST(Plan, TakesAnyDepthAndSharing)
{
    Solid deep = cube({{40, 4, 4}});
    for (int i = 0; i < 20000; ++i)
        deep = i % 2 ? unite({deep, at(sphere(0.1), 0.001 * i, 4, 0)})
                     : subtract({deep, at(sphere(0.1), 0.001 * i, 0, 0)});
    EXPECT_LE(count_leaves(plan(deep).solid), 20001);
    Solid tower = sphere(1);
    for (int i = 0; i < 60; ++i) tower = unite({tower, at(tower, 1, 0, 0)});
    EXPECT_EQ(count_leaves(tower), std::int64_t{1} << 60);
    const Plan planned = plan(tower);
    EXPECT_EQ(planned.solid.bounds(), tower.bounds());
}

TEST(Plan, LongChainsTakeTimeInProportion)
{
    Solid chain = cube({{4000, 10, 10}});
    for (int i = 0; i < 20000; ++i) chain = subtract({chain, at(sphere(0.1), 0.2 * i, 5, 10)});
    const Plan planned = plan(chain);
    EXPECT_EQ(parts_of(planned.solid.node()).size(), 20001U);
}

TEST(Explanation, AddsUpAndTells)
{
    Explanation e;
    e.add("cells skipped", 3, "cells");
    e.add("cells skipped", 4, "cells");
    e.add("nothing of this kind", 0, "leaves");
    EXPECT_EQ(e.to_text(), "cells skipped: 7 cells");
}

}  // namespace
}  // namespace genus
