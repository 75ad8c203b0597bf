// A few random trees of leaves of all kinds; tests/stress/quadric_trees runs them by the ten
// thousand.

#include <gtest/gtest.h>

#include "stress/quadric_trees.h"

namespace genus {
namespace {

TEST(QuadricTrees, BoundsHoldOverBothRoads)
{
    quadric_trees::Request request;
    request.tolerance = 0.02;
    for (const std::uint32_t seed : {1u, 2u, 3u, 4u}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        request.grid.reset();
        if (seed == 1) request.grid = MeshMethod::Mc;
        const quadric_trees::Outcome outcome = quadric_trees::try_tree(seed, request);
        EXPECT_EQ(outcome.wrong, "");
        EXPECT_EQ(outcome.refused, "");
        if (outcome.grid && !outcome.touches) {
            EXPECT_EQ(outcome.grid->euler, outcome.euler);
        }
    }
}

}  // namespace
}  // namespace genus
