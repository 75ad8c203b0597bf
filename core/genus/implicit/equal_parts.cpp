#include "genus/implicit/equal_parts.h"

#include <bit>
#include <cmath>
#include <unordered_map>

#include "genus/implicit/function.h"
#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using Node = Expression::Node;

Expression leaf(const Node& n)
{
    switch (n.operation) {
        case Operation::X:
            return Expression::x();
        case Operation::Y:
            return Expression::y();
        case Operation::Z:
            return Expression::z();
        default:
            return n.number;
    }
}

}  // namespace

bool is_step(Operation o)
{
    return o == Operation::Floor || o == Operation::Ceil || o == Operation::Round ||
           o == Operation::Sign;
}

bool is_nowhere_flat(const Expression& e)
{
    if (e.number()) return false;
    const Node& top = e.node();
    bool analytic = true;
    visit_nodes(e, [&](const Node& n) {
        const Operation o = n.operation;
        const bool creases = o == Operation::Min || o == Operation::Max || o == Operation::Abs;
        if (is_step(o) || (creases && !(o == Operation::Abs && &n == &top))) analytic = false;
    });
    return analytic;
}

Expression Rewriter::rewritten(const Expression& expression, const Node* node, const Expression& by)
{
    std::unordered_map<const Node*, Expression> done;
    visit_nodes(expression, [&](const Node& n) {
        const auto operand = [&](std::size_t i) { return done.at(n.operands[i].get()); };
        if (&n == node)
            done.emplace(&n, by);
        else if (!n.operands[0])
            done.emplace(&n, one_of(leaf(n)));
        else if (n.operation == Operation::Power)
            done.emplace(&n, one_of(pow(operand(0), n.number)));
        else if (!n.operands[1])
            done.emplace(&n, one_of(Expression::apply(n.operation, operand(0))));
        else
            done.emplace(&n, one_of(binary(n.operation, operand(0), operand(1))));
    });
    return done.at(&expression.node());
}

// Zero times something is zero, but where that is infinite or nothing.
bool Rewriter::is_nothing(const Expression& a, const Expression& b) const
{
    if (!a.number() || *a.number() != 0.0) return false;
    const Interval range = Function(b).bound(box_);
    return std::isfinite(range.lo) && std::isfinite(range.hi);
}

Expression Rewriter::binary(Operation o, const Expression& a, const Expression& b) const
{
    if (o == Operation::Multiply && (is_nothing(a, b) || is_nothing(b, a))) return 0.0;
    return Expression::apply(o, a, b);
}

Expression Rewriter::one_of(const Expression& e)
{
    const Node& n = e.node();
    const Key key{n.operation, std::bit_cast<std::uint64_t>(n.number), n.operands[0].get(),
                  n.operands[1].get()};
    return known_.emplace(key, e).first->second;
}

}  // namespace genus
