#include "genus/implicit/jump_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "genus/base/halves.h"
#include "genus/implicit/function.h"
#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using Node = Expression::Node;
using NodePtr = std::shared_ptr<const Node>;

bool is_step(Operation o)
{
    return o == Operation::Floor || o == Operation::Ceil || o == Operation::Round ||
           o == Operation::Sign;
}

bool may_jump(Operation o)
{
    switch (o) {
        case Operation::Power:
        case Operation::Sqrt:
        case Operation::Log:
        case Operation::Tan:
        case Operation::Asin:
        case Operation::Acos:
        case Operation::Divide:
        case Operation::RealPower:
        case Operation::Atan2:
            return true;
        default:
            return is_step(o);
    }
}

/// Makes equal parts one, so that all uses of floor(x) are the same node.
class Rewriter {
public:
    explicit Rewriter(const Box3& box) : box_(box) {}

    /// With `by` in place of `node`, if that is given.
    Expression rewritten(const Expression& expression, const Node* node, const Expression& by)
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

private:
    using Key = std::tuple<Operation, std::uint64_t, const Node*, const Node*>;

    static Expression leaf(const Node& n)
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
    // Zero times something is zero, but where that is infinite or nothing.
    bool is_nothing(const Expression& a, const Expression& b) const
    {
        if (!a.number() || *a.number() != 0.0) return false;
        const Interval range = Function(b).bound(box_);
        return std::isfinite(range.lo) && std::isfinite(range.hi);
    }
    Expression binary(Operation o, const Expression& a, const Expression& b) const
    {
        if (o == Operation::Multiply && (is_nothing(a, b) || is_nothing(b, a))) return 0.0;
        return Expression::apply(o, a, b);
    }
    Expression one_of(const Expression& e)
    {
        const Node& n = e.node();
        const Key key{n.operation, std::bit_cast<std::uint64_t>(n.number), n.operands[0].get(),
                      n.operands[1].get()};
        return known_.emplace(key, e).first->second;
    }

    const Box3& box_;
    std::map<Key, Expression> known_;
};

// ---- floor, ceil, round, sign

// Has it no value in a whole piece of space? No number, and analytic but for being an absolute
// value.
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

// The step itself, whose operand has none inside.
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

// ---- Roots and logarithms

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

// ---- Fractions

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

// ---- Where a function jumps

struct Sample {
    Vec3 at;
    double value;
};

// Where between two samples the sign changes without a zero, if so.
std::optional<Vec3> gap(const Implicit& field, Sample a, Sample b)
{
    constexpr int kHalvings = 52;
    constexpr double kGap = 2e-5;  // of the difference before: less is left of a cube root
    const bool inside = a.value <= 0.0;
    if (inside == (b.value <= 0.0)) return std::nullopt;
    const double before = std::fabs(b.value - a.value);
    for (int step = 0; step < kHalvings; ++step) {
        const Vec3 middle = 0.5 * (a.at + b.at);
        const double value = field.value(middle);
        ((value <= 0.0) == inside ? a : b) = {middle, value};
    }
    const double left = std::fabs(b.value - a.value);
    if (std::isfinite(left) && left <= kGap * before) return std::nullopt;
    return 0.5 * (a.at + b.at);
}

}  // namespace

bool may_jump(const Expression& expression)
{
    bool may = false;
    visit_nodes(expression, [&](const Node& n) { may = may || may_jump(n.operation); });
    return may;
}

std::optional<Vec3> jump_at_border(const Implicit& field, const Box3& box)
{
    constexpr std::size_t kSamples = 17;
    // Off the middle, where planes of symmetry are.
    constexpr Vec3 kShift{{0.4142, 0.5858, 0.3660}};
    std::vector<Vec3> points;
    points.reserve(kSamples * kSamples * kSamples);
    for (std::size_t k = 0; k < kSamples; ++k)
        for (std::size_t j = 0; j < kSamples; ++j)
            for (std::size_t i = 0; i < kSamples; ++i) {
                const Vec3 at{
                    {static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}};
                Vec3 p = box.min;
                for (std::size_t c = 0; c < 3; ++c)
                    p[c] += (at[c] + kShift[c]) / kSamples * (box.max[c] - box.min[c]);
                points.push_back(p);
            }
    std::vector<double> values(points.size());
    field.values(points, values);
    for (std::size_t n = 0; n < points.size(); ++n) {
        std::size_t rest = n, step = 1;
        for (int axis = 0; axis < 3; ++axis, rest /= kSamples, step *= kSamples) {
            if (rest % kSamples + 1 == kSamples) continue;
            const std::size_t m = n + step;
            if (auto place = gap(field, {points[n], values[n]}, {points[m], values[m]}))
                return place;
        }
    }
    return std::nullopt;
}

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
