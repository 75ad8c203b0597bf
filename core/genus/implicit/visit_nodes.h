#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "genus/implicit/expression.h"

namespace genus {

/// Calls visit(node) for each node of an expression once, operands first. O(nodes), with no
/// recursion: expressions may be as deep as memory holds.
template <typename Visit>
void visit_nodes(const Expression& expression, const Visit& visit)
{
    using Node = Expression::Node;
    std::unordered_map<const Node*, bool> seen;  // and visited
    std::vector<const Node*> stack{&expression.node()};
    while (!stack.empty()) {
        const Node* node = stack.back();
        const auto [at, is_new] = seen.emplace(node, false);
        if (is_new) {
            for (const auto& operand : node->operands)
                if (operand && !seen.contains(operand.get())) stack.push_back(operand.get());
            continue;
        }
        stack.pop_back();
        if (!std::exchange(at->second, true)) visit(*node);
    }
}

}  // namespace genus
