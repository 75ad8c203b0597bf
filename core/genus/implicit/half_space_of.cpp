#include "genus/implicit/half_space_of.h"

#include <array>
#include <cmath>
#include <unordered_map>

#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using Node = Expression::Node;
using Affine = std::array<double, 4>;  // times x, y, z and 1

bool is_constant(const Affine& a)
{
    return a[0] == 0.0 && a[1] == 0.0 && a[2] == 0.0;
}

Affine sum(const Affine& a, const Affine& b, double times)
{
    Affine result;
    for (std::size_t k = 0; k < result.size(); ++k) result[k] = a[k] + times * b[k];
    return result;
}

// Of operands that are affine, or not.
std::optional<Affine> affine(const Node& n, const std::optional<Affine>& a,
                             const std::optional<Affine>& b)
{
    if (n.operation == Operation::Number) return Affine{0.0, 0.0, 0.0, n.number};
    if (operand_count(n.operation) == 0) {
        Affine result{};
        result[static_cast<std::size_t>(n.operation) - static_cast<std::size_t>(Operation::X)] =
            1.0;
        return result;
    }
    if (!a) return std::nullopt;
    if (n.operation == Operation::Negate) return sum({}, *a, -1.0);
    if (!b) return std::nullopt;
    switch (n.operation) {
        case Operation::Add:
            return sum(*a, *b, 1.0);
        case Operation::Subtract:
            return sum(*a, *b, -1.0);
        case Operation::Multiply:
            if (is_constant(*a)) return sum({}, *b, (*a)[3]);
            if (is_constant(*b)) return sum({}, *a, (*b)[3]);
            return std::nullopt;
        case Operation::Divide: {
            if (!is_constant(*b)) return std::nullopt;
            Affine result;
            for (std::size_t k = 0; k < result.size(); ++k) result[k] = (*a)[k] / (*b)[3];
            return result;
        }
        default:
            return std::nullopt;
    }
}

}  // namespace

std::optional<Quadric> half_space_of(const Expression& expression)
{
    std::unordered_map<const Node*, std::optional<Affine>> done;
    visit_nodes(expression, [&](const Node& node) {
        const auto of = [&](std::size_t i) {
            return node.operands[i] ? done.at(node.operands[i].get()) : std::nullopt;
        };
        done.emplace(&node, affine(node, of(0), of(1)));
    });
    const std::optional<Affine>& a = done.at(&expression.node());
    if (!a || is_constant(*a)) return std::nullopt;
    for (const double c : *a)
        if (!std::isfinite(c)) return std::nullopt;
    return Quadric::half_space({{(*a)[0], (*a)[1], (*a)[2]}}, -(*a)[3]);
}

}  // namespace genus
