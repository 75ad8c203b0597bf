#pragma once

#include <vector>

#include "genus/base/box.h"
#include "genus/implicit/expression.h"

namespace genus {

/// An expression as minima and maxima of others, by which the solid it describes is a union and
/// intersection of theirs: edges between them are then those of surfaces that meet.
struct SmoothParts {
    enum class Kind { Leaf, Min, Max };
    Kind kind = Kind::Leaf;
    Expression leaf;                 // of a Leaf
    std::vector<SmoothParts> parts;  // of the others
    bool negated = false;            // a Leaf that enters as its negative
};

/// Brings min, max and abs outward through what is monotone: -min(a, b) is max(-a, -b), min(a, b) +
/// c is min(a + c, b + c), abs(a) is max(a, -a). What stays inside, as in smooth_min, stays in a
/// leaf.
///
/// The expression is a single leaf if there would be more than 64, or one of them is not
/// shown to be defined and finite in the box: then it is not the same. O(nodes) for each leaf.
SmoothParts smooth_parts(const Expression& expression, const Box3& box);

/// The same without a look at where the leaves are defined.
SmoothParts lifted_parts(const Expression& expression);
/// Are all leaves shown to be defined and finite in the box?
bool all_finite(const SmoothParts& parts, const Box3& box);

}  // namespace genus
