#include "genus/implicit/step_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "genus/base/halves.h"
#include "genus/implicit/function.h"
#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using Node = Expression::Node;

// One value of a step, and where it has it: low <= operand <= high.
struct Level {
    double value, low, high;
};

std::vector<Level> levels_of(Operation step, const Interval& range, std::size_t most)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (step == Operation::Sign) return {{-1.0, -kInfinity, 0.0}, {1.0, 0.0, kInfinity}};
    const double shift = step == Operation::Round ? 0.5 : 0.0;
    const double more = step == Operation::Ceil ? 1.0 : 0.0;
    // The bounds are rounded outward: what only that adds is no level.
    const double slack = 16.0 * std::numeric_limits<double>::epsilon() * range.magnitude();
    const double first = std::floor(range.lo + slack + shift);
    const double last = std::max(first, std::ceil(range.hi - slack + shift) - 1.0);
    std::vector<Level> levels;
    if (!(last - first < static_cast<double>(most))) return levels;
    for (double n = first; n <= last; ++n)
        levels.push_back({n + more, n == first ? -kInfinity : n - shift,
                          n == last ? kInfinity : n + 1.0 - shift});
    return levels;
}

// What is inside on neighbouring levels, whatever else, is one piece.
void join_full(std::vector<JumpPiece>& pieces, std::vector<Level>& levels)
{
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const bool is_full = pieces[i].function.number() != nullptr;
        if (is_full && kept > 0 && pieces[kept - 1].function.number() &&
            levels[kept - 1].high == levels[i].low) {
            levels[kept - 1].high = levels[i].high;
            continue;
        }
        pieces[kept] = pieces[i];
        levels[kept++] = levels[i];
    }
    pieces.resize(kept);
    levels.resize(kept);
}

// Shown by bounds to be outside in all of the box beyond a limit of `operand`.
bool is_outside_beyond(const Expression& f, const Expression& operand, const Interval& beyond,
                       const Box3& box)
{
    constexpr int kMostBoxes = 400;
    if (f.number()) return *f.number() > 0.0;
    const Function function(f), of(operand);
    std::vector<Box3> open{box};
    for (int n = 0; !open.empty(); ++n) {
        if (n == kMostBoxes) return false;
        const Box3 part = open.back();
        open.pop_back();
        const Interval where = of.bound(part);
        if (where.hi < beyond.lo || where.lo > beyond.hi || function.bound(part).lo > 0.0) continue;
        const auto [low, high] = halves(part);
        open.push_back(high);
        open.push_back(low);
    }
    return true;
}

}  // namespace

const Node* innermost_step(const Expression& expression, const Box3& box)
{
    const Node* found = nullptr;
    visit_nodes(expression, [&](const Node& n) {
        if (found || !is_step(n.operation)) return;
        const Expression operand = Expression::of(n.operands[0]);
        const Interval range = Function(operand).bound(box);
        if (n.operation == Operation::Sign ? range.lo < 0.0 && range.hi > 0.0 : true) found = &n;
    });
    return found;
}

std::optional<std::vector<JumpPiece>> pieces_by_level(const Expression& e, const Node& step,
                                                      const Box3& box, std::size_t most,
                                                      Rewriter& rewriter)
{
    const Expression operand = Expression::of(step.operands[0]);
    const Interval range = Function(operand).bound(box);
    if (!std::isfinite(range.lo) || !std::isfinite(range.hi)) return std::nullopt;
    if (!is_nowhere_flat(operand)) return std::nullopt;
    std::vector<Level> levels = levels_of(step.operation, range, most);
    if (levels.empty()) return std::nullopt;
    std::vector<JumpPiece> pieces;
    std::vector<Level> of_piece;
    for (const Level& level : levels) {
        Expression f = rewriter.rewritten(e, &step, level.value);
        if (f.number() && std::isnan(*f.number())) continue;  // outside
        const Interval values = Function(f).bound(box);
        if (values.lo > 0.0) continue;
        if (values.hi <= 0.0) f = -1.0;
        pieces.push_back({f, {}});
        of_piece.push_back(level);
    }
    join_full(pieces, of_piece);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const auto [value, low, high] = of_piece[i];
        const Expression& f = pieces[i].function;
        if (std::isfinite(low) && !is_outside_beyond(f, operand, {-kInfinity, low}, box))
            pieces[i].sides.push_back({operand - low, true});
        if (std::isfinite(high) && !is_outside_beyond(f, operand, {high, kInfinity}, box))
            pieces[i].sides.push_back({operand - high, false});
    }
    return pieces;
}

}  // namespace genus
