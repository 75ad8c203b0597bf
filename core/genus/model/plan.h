#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "genus/model/solid.h"

namespace genus {

/// What was left out of a scene, and why.
struct Explanation {
    struct Entry {
        std::string what;  // "subtracted part misses the solid", "equal subtrees shared", ...
        std::int64_t count;
        std::string unit;  // "leaves", "nodes", "cells"
    };
    std::vector<Entry> entries;

    /// Adds to the entry of that name, or starts it. A count of zero is not kept.
    void add(const std::string& what, std::int64_t count, const std::string& unit);
    /// One line an entry, "nothing was left out" if there is none.
    std::string to_text() const;
};

struct Plan {
    Solid solid;
    Explanation explanation;
};

struct PlanOptions {
    /// Leave out what cannot matter outside this box: the result is the same inside it.
    Box3 region = Box3::everything();
    /// Where a tree of shared parts has more leaves than this once written out, sharing is kept
    /// and transforms stay where they are.
    std::int64_t most_leaves = 2'000'000;
};

/// The same solid with less work in it. The set of points is the same up to pieces without volume
/// (the regularised set); coordinates do not change by a bit.
///
/// - nested operators of one kind are flattened, (A - B) - C becomes A - B - C;
/// - transforms are multiplied out and stand right above the leaves; colours likewise;
/// - parts that lie outside what the operators above let through are dropped;
/// - subtracted parts that miss, united parts inside others, intersected parts that hold the rest
///   are dropped, shown by boxes and by interval bounds on up to 256 cells of the boxes;
/// - what is proven empty becomes empty; equal subtrees become one node.
///
/// O(n log n) for n leaves, with interval tests against up to 16 larger neighbours each. No
/// recursion: any depth will do.
Plan plan(const Solid& solid, const PlanOptions& options = {});

/// Leaves of the tree, shared ones counted each time; at most 2^62.
std::int64_t count_leaves(const Solid& solid);

}  // namespace genus
