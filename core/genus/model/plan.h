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

/// The same solid with less work in it: nested operators of one kind flattened, transforms folded
/// into shapes that can take them, equal subtrees shared, parts dropped that boxes or interval
/// bounds prove to have no effect. O(n log n) for n nodes.
Plan plan(const Solid& solid);

}  // namespace genus
