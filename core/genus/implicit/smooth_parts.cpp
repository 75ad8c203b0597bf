#include "genus/implicit/smooth_parts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

#include "genus/implicit/function.h"
#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using Kind = SmoothParts::Kind;

constexpr std::size_t kMostLeaves = 64;
constexpr int kMostDepth = 64;  // operations on the way from the result to a leaf
// Operations looked at: an expression that uses parts of itself twice, time and again, has more
// ways through it than anyone can go.
constexpr int kMostSteps = 1 << 14;

// Which nodes have a min, max or abs below them.
class Creases {
public:
    explicit Creases(const Expression& expression)
    {
        visit_nodes(expression, [&](const Expression::Node& node) {
            const Operation o = node.operation;
            bool any = o == Operation::Min || o == Operation::Max || o == Operation::Abs;
            for (const auto& operand : node.operands)
                any = any || (operand && known_.at(operand.get()));
            known_[&node] = any;
        });
    }
    bool below(const Expression& e) const { return known_.at(&e.node()); }

private:
    std::unordered_map<const Expression::Node*, bool> known_;
};

SmoothParts as_leaf(const Expression& e)
{
    return {Kind::Leaf, e, {}};
}

std::size_t count_leaves(const SmoothParts& p)
{
    if (p.kind == Kind::Leaf) return 1;
    std::size_t n = 0;
    for (const SmoothParts& part : p.parts) n += count_leaves(part);
    return n;
}

// Every leaf through a monotone function, a falling one turning minima to maxima.
template <typename F>
SmoothParts mapped(const SmoothParts& p, bool falls, const F& f)
{
    if (p.kind == Kind::Leaf) return as_leaf(f(p.leaf));
    SmoothParts out{p.kind, {}, {}};
    if (falls) out.kind = p.kind == Kind::Min ? Kind::Max : Kind::Min;
    for (const SmoothParts& part : p.parts) out.parts.push_back(mapped(part, falls, f));
    return out;
}

SmoothParts sum(const SmoothParts& a, const SmoothParts& b)
{
    if (a.kind == Kind::Leaf)
        return mapped(b, false, [&](const Expression& e) { return a.leaf + e; });
    SmoothParts out{a.kind, {}, {}};
    for (const SmoothParts& part : a.parts) out.parts.push_back(sum(part, b));
    return out;
}

class Lifter {
public:
    explicit Lifter(const Expression& expression) : creases_(expression) {}

    // Nothing if some min, max or abs stays inside, or there is too much of them.
    std::optional<SmoothParts> lift(const Expression& e, int depth)
    {
        if (!creases_.below(e)) return as_leaf(e);
        if (depth == 0 || ++n_steps_ > kMostSteps) return std::nullopt;
        const auto& [first, second] = e.node().operands;
        const Expression a = Expression::of(first);
        const std::optional<SmoothParts> p = lift(a, depth - 1);
        const Operation operation = e.node().operation;
        const bool falls = operation == Operation::Negate || operation == Operation::Acos;
        switch (operation) {
            case Operation::Negate:
            case Operation::Sqrt:
            case Operation::Cbrt:
            case Operation::Exp:
            case Operation::Log:
            case Operation::Asin:
            case Operation::Acos:
            case Operation::Atan:
            case Operation::Sinh:
            case Operation::Tanh:
                if (!p) return std::nullopt;
                return mapped(*p, falls, [&](const Expression& x) {
                    return operation == Operation::Negate ? -x : Expression::apply(operation, x);
                });
            case Operation::Abs:
                if (!p) return std::nullopt;
                return limited({Kind::Max, {}, {*p, mapped(*p, true, [](const Expression& x) {
                                                    return -x;
                                                })}});
            default:
                break;
        }
        if (!second) return std::nullopt;
        const Expression b = Expression::of(second);
        const std::optional<SmoothParts> q = lift(b, depth - 1);
        switch (operation) {
            case Operation::Min:
            case Operation::Max:
                // An operand is a solid of its own, whatever is in it.
                return limited({operation == Operation::Min ? Kind::Min : Kind::Max,
                                {},
                                {p ? *p : as_leaf(a), q ? *q : as_leaf(b)}});
            case Operation::Add:
                if (p && q && fits(*p, *q)) return sum(*p, *q);
                return std::nullopt;
            case Operation::Subtract:
                if (p && q && fits(*p, *q))
                    return sum(*p, mapped(*q, true, [](const Expression& x) { return -x; }));
                return std::nullopt;
            case Operation::Multiply:
                if (p && b.number()) return scaled(*p, *b.number());
                if (q && a.number()) return scaled(*q, *a.number());
                return std::nullopt;
            case Operation::Divide:
                if (!p || !b.number() || *b.number() == 0.0) return std::nullopt;
                return mapped(*p, *b.number() < 0.0, [&](const Expression& x) { return x / b; });
            default:
                return std::nullopt;
        }
    }

private:
    static bool fits(const SmoothParts& p, const SmoothParts& q)
    {
        return count_leaves(p) * count_leaves(q) <= kMostLeaves;
    }
    static std::optional<SmoothParts> limited(SmoothParts&& p)
    {
        if (count_leaves(p) > kMostLeaves) return std::nullopt;
        return std::move(p);
    }
    static std::optional<SmoothParts> scaled(const SmoothParts& p, double factor)
    {
        if (factor == 0.0 || std::isnan(factor)) return std::nullopt;
        return mapped(p, factor < 0.0, [&](const Expression& x) { return Expression(factor) * x; });
    }

    Creases creases_;
    int n_steps_ = 0;
};

}  // namespace

SmoothParts lifted_parts(const Expression& expression)
{
    const auto parts = Lifter(expression).lift(expression, kMostDepth);
    return parts ? *parts : as_leaf(expression);
}

bool all_finite(const SmoothParts& parts, const Box3& box)
{
    if (parts.kind == Kind::Leaf) {
        const Interval range = Function(parts.leaf).bound(box);
        return std::isfinite(range.lo) && std::isfinite(range.hi);
    }
    return std::all_of(parts.parts.begin(), parts.parts.end(),
                       [&](const SmoothParts& part) { return all_finite(part, box); });
}

SmoothParts smooth_parts(const Expression& expression, const Box3& box)
{
    SmoothParts parts = lifted_parts(expression);
    return all_finite(parts, box) ? parts : as_leaf(expression);
}

}  // namespace genus
