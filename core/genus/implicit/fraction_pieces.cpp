#include "genus/implicit/fraction_pieces.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <unordered_map>
#include <utility>

#include "genus/implicit/equal_parts.h"
#include "genus/implicit/function.h"
#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using Node = Expression::Node;
using NodePtr = std::shared_ptr<const Node>;

// num / (den[0] den[1] ...)
struct Fraction {
    Expression num;
    std::vector<Expression> den;
};

class Fractions {
public:
    Fractions(const Expression& expression, const Box3& box)
    {
        visit_nodes(expression, [&](const Node& n) {
            bool any = false;
            for (const NodePtr& operand : n.operands)
                any = any || (operand && has_pole_.at(operand.get()));
            const bool divides = n.operation == Operation::Divide;
            if (divides || n.operation == Operation::Tan ||
                (n.operation == Operation::Power && n.number < 0.0)) {
                const Interval range = Function(n.operation == Operation::Tan
                                                    ? cosine(Expression::of(n.operands[0]))
                                                    : Expression::of(n.operands[divides ? 1 : 0]))
                                           .bound(box);
                any = any || (range.lo <= 0.0 && range.hi >= 0.0);
            }
            has_pole_[&n] = any;
        });
    }

    bool any(const Expression& e) const { return has_pole_.at(&e.node()); }

    // Nothing where a pole is inside another function.
    std::optional<Fraction> fraction(const Expression& e, int depth = kMostDepth) const
    {
        if (!any(e)) return Fraction{e, {}};
        if (depth == 0) return std::nullopt;
        const Node& n = e.node();
        const Expression first = Expression::of(n.operands[0]);
        if (n.operation == Operation::Tan && !any(first))
            return Fraction{Expression::apply(Operation::Sin, first), {cosine(first)}};
        const auto a = fraction(first, depth - 1);
        if (!a) return std::nullopt;
        switch (n.operation) {
            case Operation::Negate:
                return Fraction{-a->num, a->den};
            case Operation::Square:
                return product(*a, *a);
            case Operation::Power:
                return power(*a, static_cast<int>(n.number));
            default:
                break;
        }
        if (!n.operands[1]) return std::nullopt;
        const auto b = fraction(Expression::of(n.operands[1]), depth - 1);
        if (!b) return std::nullopt;
        switch (n.operation) {
            case Operation::Add:
                return sum(*a, *b);
            case Operation::Subtract:
                return sum(*a, {-b->num, b->den});
            case Operation::Multiply:
                return product(*a, *b);
            case Operation::Divide:
                return product(*a, inverse(*b));
            default:
                return std::nullopt;
        }
    }

private:
    static constexpr int kMostDepth = 64, kMostPower = 8;

    static Expression cosine(const Expression& e) { return Expression::apply(Operation::Cos, e); }

    static void add_factors(const Expression& e, std::vector<Expression>& to)
    {
        const Node& n = e.node();
        const auto operand = [&](std::size_t i) { return Expression::of(n.operands[i]); };
        if (n.operation == Operation::Multiply) {
            add_factors(operand(0), to);
            add_factors(operand(1), to);
        } else if (n.operation == Operation::Square) {
            add_factors(operand(0), to);
            add_factors(operand(0), to);
        } else {
            to.push_back(e);
        }
    }
    static Fraction inverse(const Fraction& f)
    {
        Fraction result{1.0, {}};
        for (const Expression& d : f.den) result.num = result.num * d;
        add_factors(f.num, result.den);
        return result;
    }
    static Fraction product(const Fraction& a, const Fraction& b)
    {
        Fraction result{a.num * b.num, a.den};
        result.den.insert(result.den.end(), b.den.begin(), b.den.end());
        return result;
    }
    static std::optional<Fraction> power(const Fraction& f, int n)
    {
        if (std::abs(n) > kMostPower) return std::nullopt;
        Fraction result{1.0, {}};
        for (int i = 0; i < std::abs(n); ++i) result = product(result, f);
        return n < 0 ? inverse(result) : result;
    }
    // Over the denominator that both need.
    static Fraction sum(const Fraction& a, const Fraction& b)
    {
        Fraction result{0.0, a.den};
        Expression more_a = 1.0, more_b = 1.0;
        std::vector<Expression> left = a.den;
        for (const Expression& d : b.den) {
            const auto same = std::find_if(left.begin(), left.end(), [&](const Expression& x) {
                return &x.node() == &d.node();
            });
            if (same != left.end()) {
                left.erase(same);
                continue;
            }
            result.den.push_back(d);
            more_a = more_a * d;
        }
        for (const Expression& d : left) more_b = more_b * d;
        result.num = a.num * more_a + b.num * more_b;
        return result;
    }

    std::unordered_map<const Node*, bool> has_pole_;
};

// The denominators whose sign is open; `sign` is that of the others together. Nothing if one is
// zero in a piece of space.
std::optional<std::vector<Expression>> open_factors(const std::vector<Expression>& den,
                                                    const Box3& box, double& sign)
{
    std::vector<std::pair<Expression, int>> powers;
    for (const Expression& d : den) {
        const auto at = std::find_if(powers.begin(), powers.end(), [&](const auto& known) {
            return &known.first.node() == &d.node();
        });
        if (at == powers.end())
            powers.emplace_back(d, 1);
        else
            ++at->second;
    }
    std::vector<Expression> open;
    for (const auto& [d, n] : powers) {
        if (n % 2 == 0) continue;
        if (!is_nowhere_flat(d)) return std::nullopt;
        const Interval range = Function(d).bound(box);
        if (range.hi <= 0.0) sign = -sign;
        if (range.lo < 0.0 && range.hi > 0.0) open.push_back(d);
    }
    return open;
}

}  // namespace

std::optional<std::vector<JumpPiece>> pieces_by_sign(const Expression& e, const Box3& box,
                                                     std::size_t most)
{
    const Fractions fractions(e, box);
    if (!fractions.any(e)) return std::nullopt;
    const auto f = fractions.fraction(e);
    if (!f) return std::nullopt;
    double sign = 1.0;
    const auto factors = open_factors(f->den, box, sign);
    if (!factors) return std::nullopt;
    const std::vector<Expression>& open = *factors;
    if (open.size() > 8 || std::size_t{1} << open.size() > most) return std::nullopt;
    std::vector<JumpPiece> pieces;
    for (std::size_t negative = 0; negative < std::size_t{1} << open.size(); ++negative) {
        JumpPiece piece;
        const bool turned = (std::popcount(negative) % 2 != 0) != (sign < 0.0);
        piece.function = turned ? -f->num : f->num;
        const Interval values = Function(piece.function).bound(box);
        if (values.lo > 0.0) continue;
        if (values.hi <= 0.0) piece.function = -1.0;
        for (std::size_t i = 0; i < open.size(); ++i)
            piece.sides.push_back({open[i], (negative >> i & 1) == 0});
        pieces.push_back(std::move(piece));
    }
    return pieces;
}

}  // namespace genus
