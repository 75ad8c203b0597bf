#include "genus/implicit/jump_parts.h"

#include <cmath>
#include <limits>

#include "genus/implicit/equal_parts.h"
#include "genus/implicit/fraction_pieces.h"
#include "genus/implicit/function.h"
#include "genus/implicit/step_pieces.h"
#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using Node = Expression::Node;

const Node* open_root(const Expression& expression, const Box3& box)
{
    const Node* found = nullptr;
    visit_nodes(expression, [&](const Node& n) {
        if (found || (n.operation != Operation::Sqrt && n.operation != Operation::Log)) return;
        const Interval range = Function(Expression::of(n.operands[0])).bound(box);
        if (range.lo < 0.0 && std::isfinite(range.lo) && std::isfinite(range.hi)) found = &n;
    });
    return found;
}

// The same of |g|, written without a crease and without a pole: only where g >= 0 does it count.
JumpPiece piece_of_root(const Expression& e, const Node& root, Rewriter& rewriter)
{
    constexpr double kLeast = std::numeric_limits<double>::min();
    const Expression g = Expression::of(root.operands[0]);
    const Expression square = Expression::apply(Operation::Square, g);
    const bool is_root = root.operation == Operation::Sqrt;
    const Expression same =
        is_root ? Expression::apply(Operation::Sqrt, Expression::apply(Operation::Sqrt, square))
                : 0.5 * Expression::apply(Operation::Log, square + kLeast);
    return {rewriter.rewritten(e, &root, same), {{g, true}}};
}

}  // namespace

std::optional<JumpPiece> defined_piece(const Expression& expression, const Box3& box)
{
    Rewriter rewriter(box);
    const Expression e = rewriter.rewritten(expression, nullptr, 0.0);
    const Node* root = open_root(e, box);
    if (!root) return std::nullopt;
    return piece_of_root(e, *root, rewriter);
}

bool is_defined(const Expression& expression, const Box3& box)
{
    bool defined = true;
    visit_nodes(expression, [&](const Node& n) {
        if (!defined) return;
        const auto operand = [&](std::size_t i = 0) {
            return Function(Expression::of(n.operands[i])).bound(box);
        };
        switch (n.operation) {
            case Operation::Number:
                defined = std::isfinite(n.number);
                break;
            case Operation::Sqrt:
            case Operation::Log:
            case Operation::RealPower:
                defined = operand().lo >= 0.0;
                break;
            case Operation::Asin:
            case Operation::Acos:
                defined = operand().magnitude() <= 1.0;
                break;
            case Operation::Atan2:  // tells zeros of either sign apart
                defined = operand().lo > 0.0 || operand().hi < 0.0 || operand(1).lo > 0.0;
                break;
            default:
                break;
        }
    });
    return defined;
}

std::optional<std::vector<JumpPiece>> jump_pieces(const Expression& expression, const Box3& box,
                                                  std::size_t most)
{
    Rewriter rewriter(box);
    const Expression e = rewriter.rewritten(expression, nullptr, 0.0);
    if (const Node* step = innermost_step(e, box))
        return pieces_by_level(e, *step, box, most, rewriter);
    return pieces_by_sign(e, box, most);
}

}  // namespace genus
