#pragma once

#include <cstdint>
#include <map>
#include <tuple>

#include "genus/base/box.h"
#include "genus/implicit/expression.h"

namespace genus {

/// Floor, Ceil, Round or Sign.
bool is_step(Operation operation);

/// Has it no value in a whole piece of space? No number, and analytic but for being an absolute
/// value. O(nodes).
bool is_nowhere_flat(const Expression& expression);

/// Makes equal parts one, so that all uses of floor(x) are the same node. O(nodes log nodes) each.
class Rewriter {
public:
    /// A reference to the box is kept.
    explicit Rewriter(const Box3& box) : box_(box) {}

    /// With `by` in place of `node`, if that is given.
    Expression rewritten(const Expression& expression, const Expression::Node* node,
                         const Expression& by);

private:
    using Key =
        std::tuple<Operation, std::uint64_t, const Expression::Node*, const Expression::Node*>;

    bool is_nothing(const Expression& a, const Expression& b) const;
    Expression binary(Operation o, const Expression& a, const Expression& b) const;
    Expression one_of(const Expression& e);

    const Box3& box_;
    std::map<Key, Expression> known_;
};

}  // namespace genus
