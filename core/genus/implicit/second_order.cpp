#include "genus/implicit/second_order.h"

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "genus/implicit/operations.h"

namespace genus {

namespace {

using Instruction = Function::Instruction;

constexpr std::size_t kMostPieces = 8;
constexpr std::int32_t kZero = -1;  // in place of an instruction: the number 0
constexpr double kRounding = 1.0 + 64.0 * std::numeric_limits<double>::epsilon();

bool is_comparison(Operation operation)
{
    return operation == Operation::Min || operation == Operation::Max ||
           operation == Operation::Abs;
}

bool is_step(Operation operation)
{
    return operation == Operation::Floor || operation == Operation::Ceil ||
           operation == Operation::Round || operation == Operation::Sign;
}

// The two instructions whose difference decides.
std::pair<std::int32_t, std::int32_t> compared(const std::vector<Instruction>& code,
                                               const Instruction& c)
{
    const auto or_zero = [&](std::int32_t i) {
        const Instruction& operand = code[static_cast<std::size_t>(i)];
        return operand.operation == Operation::Number && operand.number == 0.0 ? kZero : i;
    };
    if (c.operation != Operation::Abs) return {or_zero(c.a), or_zero(c.b)};
    const Instruction& of = code[static_cast<std::size_t>(c.a)];
    if (of.operation == Operation::Subtract) return {or_zero(of.a), or_zero(of.b)};
    return {c.a, kZero};
}

// Second derivatives in the order xx, yy, zz, xy, xz, yz.
using Bend = std::array<Interval, 6>;
constexpr std::array<std::array<std::size_t, 2>, 6> kAxes{
    {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

bool is_zero(const Interval& a)
{
    return a.lo == 0.0 && a.hi == 0.0;
}

void add_product(Interval& to, const Interval& a, const Interval& b)
{
    if (is_zero(a) || is_zero(b)) return;
    const Interval more = a == Interval(1.0) ? b : b == Interval(1.0) ? a : a * b;
    to = is_zero(to) ? more : to + more;
}

// An intermediate result with its derivatives.
struct Jet {
    Range range;
    IntervalVec3 slope{};
    Bend bend{};
};

// The chain rule for an operation of one or two operands; without `bend` first derivatives only.
Jet jet_of(const Instruction& c, const Jet& a, const Jet& b, bool bend)
{
    const bool two = operand_count(c.operation) == 2;
    Jet out;
    out.range = operate(c.operation, a.range, b.range, c.number);
    const auto [by_a, by_b] =
        derivatives(c.operation, a.range.values, b.range.values, c.number, out.range.values);
    for (std::size_t k = 0; k < 3; ++k) {
        add_product(out.slope[k], by_a, a.slope[k]);
        if (two) add_product(out.slope[k], by_b, b.slope[k]);
    }
    if (!bend) return out;
    const SecondDerivatives second =
        second_derivatives(c.operation, a.range.values, b.range.values, c.number, out.range.values);
    for (std::size_t n = 0; n < 6; ++n) {
        const auto [k, l] = kAxes[n];
        Interval& h = out.bend[n];
        add_product(h, by_a, a.bend[n]);
        add_product(h, second.aa, k == l ? square(a.slope[k]) : a.slope[k] * a.slope[l]);
        if (!two) continue;
        add_product(h, by_b, b.bend[n]);
        add_product(h, second.bb, k == l ? square(b.slope[k]) : b.slope[k] * b.slope[l]);
        add_product(h, second.ab, a.slope[k] * b.slope[l]);
        add_product(h, second.ab, a.slope[l] * b.slope[k]);
    }
    return out;
}

Jet negative(const Jet& a)
{
    Jet out;
    out.range = {-a.range.values, a.range.may_be_undefined};
    for (std::size_t k = 0; k < 3; ++k) out.slope[k] = -a.slope[k];
    for (std::size_t n = 0; n < 6; ++n) out.bend[n] = -a.bend[n];
    return out;
}

double radius(const Interval& a)
{
    const double mid = a.mid();
    return std::max(a.hi - mid, mid - a.lo);
}

// Goes through the instructions over a box and at its middle, and where a choice is open goes on in
// each way.
class PieceWalk {
public:
    PieceWalk(const std::vector<Instruction>& code, const ChoiceList& choices, const Box3& box)
        : code_(code),
          choices_(choices),
          over_(to_intervals(box)),
          at_(box.center()),
          wide_(code.size()),
          middle_(code.size()),
          answer_(choices.n_questions(), 0.0)
    {
        for (std::size_t i = 0; i < 3; ++i)
            half_[i] = std::max(box.max[i] - at_[i], at_[i] - box.min[i]) * kRounding;
    }

    std::vector<QuadraticModel> run()
    {
        if (!go_on(0)) found_.clear();
        return std::move(found_);
    }

private:
    // From instruction `i` with the answers so far. False if there is no use in going on.
    bool go_on(std::size_t i)
    {
        for (; i < code_.size(); ++i) {
            const std::int32_t asked = choices_.question(i);
            if (asked < 0) {
                evaluate(i);
                continue;
            }
            const auto q = static_cast<std::size_t>(asked);
            if (choices_.asks_first(i)) {
                const std::optional<Interval> open = decide(i);
                if (!open) return false;
                if (open->lo != open->hi) {
                    // Each open choice on the way makes another piece at least.
                    if (++n_open_ == kMostPieces) return false;
                    for (const double answer : {open->lo, open->hi}) {
                        answer_[q] = answer;
                        take(i);
                        if (!go_on(i + 1)) return false;
                    }
                    --n_open_;
                    return true;
                }
                answer_[q] = open->lo;
            }
            take(i);
        }
        return add_model();
    }

    void evaluate(std::size_t i)
    {
        const Instruction& c = code_[i];
        if (operand_count(c.operation) > 0) {
            wide_[i] = jet_of(c, wide_[c.a], wide_[c.b], true);
            middle_[i] = jet_of(c, middle_[c.a], middle_[c.b], false);
            return;
        }
        wide_[i] = middle_[i] = Jet{};
        if (c.operation == Operation::Number) {
            wide_[i].range = middle_[i].range = operate(c.operation, Range{}, Range{}, c.number);
            return;
        }
        const auto axis =
            static_cast<std::size_t>(c.operation) - static_cast<std::size_t>(Operation::X);
        wide_[i].range = {over_[axis]};
        middle_[i].range = {Interval(at_[axis])};
        wide_[i].slope[axis] = middle_[i].slope[axis] = Interval(1.0);
    }

    // Both answers, or twice the one there is; nothing for a step with more than two values.
    std::optional<Interval> decide(std::size_t i) const
    {
        const Instruction& c = code_[i];
        if (is_step(c.operation)) {
            const Range r = operate(c.operation, wide_[c.a].range, Range{}, c.number);
            if (r.values.hi - r.values.lo <= 1.0) return r.values;
            return std::nullopt;
        }
        const auto [first, second] = compared(code_, c);
        const Interval d = difference(first, second);
        if (d.lo >= 0.0) return Interval(choices_.turned(i) ? 0.0 : 1.0);
        if (d.hi <= 0.0) return Interval(choices_.turned(i) ? 1.0 : 0.0);
        return Interval(0.0, 1.0);
    }

    // Of two results over the box, also by their values in the middle and their slopes.
    Interval difference(std::int32_t first, std::int32_t second) const
    {
        static const Jet zero{};
        const auto jet = [&](const std::vector<Jet>& jets, std::int32_t i) -> const Jet& {
            return i == kZero ? zero : jets[static_cast<std::size_t>(i)];
        };
        const Jet &a = jet(wide_, first), &b = jet(wide_, second);
        const Interval natural = a.range.values - b.range.values;
        if (natural.lo >= 0.0 || natural.hi <= 0.0) return natural;
        Interval mean = jet(middle_, first).range.values - jet(middle_, second).range.values;
        for (std::size_t k = 0; k < 3; ++k)
            mean = mean + (a.slope[k] - b.slope[k]) * Interval(-half_[k], half_[k]);
        return {std::max(natural.lo, mean.lo), std::min(natural.hi, mean.hi)};
    }

    // What the choice of an instruction hands on, its question being answered.
    void take(std::size_t i)
    {
        const Instruction& c = code_[i];
        const double answer = answer_[static_cast<std::size_t>(choices_.question(i))];
        if (is_step(c.operation)) {
            wide_[i] = middle_[i] = Jet{};
            wide_[i].range = {Interval(answer), wide_[c.a].range.may_be_undefined};
            middle_[i].range = {Interval(answer)};
            return;
        }
        const bool not_more = (answer == 0.0) != choices_.turned(i);  // first <= second
        if (c.operation == Operation::Abs) {
            wide_[i] = not_more ? negative(wide_[c.a]) : wide_[c.a];
            middle_[i] = not_more ? negative(middle_[c.a]) : middle_[c.a];
            return;
        }
        const bool takes_a = not_more == (c.operation == Operation::Min);
        const bool undefined =
            wide_[c.a].range.may_be_undefined || wide_[c.b].range.may_be_undefined;
        wide_[i] = wide_[takes_a ? c.a : c.b];
        middle_[i] = middle_[takes_a ? c.a : c.b];
        wide_[i].range.may_be_undefined = undefined;
    }

    bool add_model()
    {
        if (found_.size() == kMostPieces) return false;
        const Jet &over = wide_.back(), &middle = middle_.back();
        if (over.range.may_be_undefined) return false;
        QuadraticModel m;
        m.at = at_;
        m.slope = over.slope;
        m.value = middle.range.values.mid();
        m.rest = radius(middle.range.values);
        for (std::size_t k = 0; k < 3; ++k) {
            m.gradient[k] = middle.slope[k].mid();
            m.slope_rest[k] = radius(middle.slope[k]);
            m.rest += m.slope_rest[k] * half_[k];
        }
        for (std::size_t n = 0; n < 6; ++n) {
            const auto [k, l] = kAxes[n];
            m.hessian[n] = over.bend[n].mid();
            const double r = radius(over.bend[n]);
            m.rest += (k == l ? 0.5 : 1.0) * r * half_[k] * half_[l];
            m.slope_rest[k] += r * half_[l];
            if (k != l) m.slope_rest[l] += r * half_[k];
        }
        m.rest *= kRounding;
        m.slope_rest *= kRounding;
        double all = m.value + m.rest;
        for (const double h : m.hessian) all += h;
        if (!std::isfinite(all) || !is_finite(m.gradient) || !is_finite(m.slope_rest)) return false;
        found_.push_back(m);
        return true;
    }

    const std::vector<Instruction>& code_;
    const ChoiceList& choices_;
    IntervalVec3 over_;
    Vec3 at_, half_;
    std::vector<Jet> wide_, middle_;
    std::vector<double> answer_;
    std::size_t n_open_ = 0;  // choices on the way that are gone through in each way
    std::vector<QuadraticModel> found_;
};

}  // namespace

ChoiceList::ChoiceList(const std::vector<Instruction>& code)
    : question_(code.size(), -1), turned_(code.size(), 0), asks_first_(code.size(), 0)
{
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> numbers;
    for (std::size_t i = 0; i < code.size(); ++i) {
        const Instruction& c = code[i];
        if (is_step(c.operation)) {
            question_[i] = static_cast<std::int32_t>(n_questions_++);
            asks_first_[i] = 1;
        } else if (is_comparison(c.operation)) {
            auto pair = compared(code, c);
            turned_[i] = pair.second < pair.first ? 1 : 0;
            if (turned_[i] != 0) std::swap(pair.first, pair.second);
            const auto [at, is_new] =
                numbers.emplace(pair, static_cast<std::int32_t>(n_questions_));
            question_[i] = at->second;
            asks_first_[i] = is_new ? 1 : 0;
            if (is_new) ++n_questions_;
        }
    }
}

std::vector<QuadraticModel> quadratic_models(const std::vector<Instruction>& code,
                                             const ChoiceList& choices, const Box3& box)
{
    return PieceWalk(code, choices, box).run();
}

}  // namespace genus
