#include "genus/implicit/function.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "genus/base/error.h"
#include "genus/implicit/operations.h"
#include "genus/implicit/second_order.h"

namespace genus {

namespace {

using Instruction = Function::Instruction;

constexpr std::size_t kMostInstructions = 1'000'000;
constexpr std::size_t kMostChoices = 30;
constexpr std::int32_t kAsItComes = -1;  // in place of a piece
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::uint64_t mix(std::uint64_t hash, std::uint64_t value)
{
    hash ^= value + 0x9e3779b97f4a7c15ull + (hash << 6) + (hash >> 2);
    return hash * 0xbf58476d1ce4e5b9ull;
}

struct InstructionHash {
    std::size_t operator()(const Instruction& i) const
    {
        std::uint64_t h =
            mix(static_cast<std::uint64_t>(i.operation), static_cast<std::uint32_t>(i.a));
        return mix(mix(h, static_cast<std::uint32_t>(i.b)), std::bit_cast<std::uint64_t>(i.number));
    }
};
// Numbers are told apart by their bits: 0 and -0 differ, NaN is itself.
struct InstructionEqual {
    bool operator()(const Instruction& x, const Instruction& y) const
    {
        return x.operation == y.operation && x.a == y.a && x.b == y.b &&
               std::bit_cast<std::uint64_t>(x.number) == std::bit_cast<std::uint64_t>(y.number);
    }
};

class Compiler {
public:
    std::vector<Instruction> compile(const Expression::Node& root)
    {
        std::vector<const Expression::Node*> stack{&root};
        while (!stack.empty()) {
            const Expression::Node* node = stack.back();
            if (done_.contains(node)) {
                stack.pop_back();
                continue;
            }
            const auto& [a, b] = node->operands;
            bool ready = true;
            for (const auto* operand : {b.get(), a.get()})
                if (operand && !done_.contains(operand)) {
                    stack.push_back(operand);
                    ready = false;
                }
            if (!ready) continue;
            stack.pop_back();
            done_.emplace(node, emit(*node));
        }
        // The result comes last, also where it is used by something else already.
        const std::int32_t result = done_.at(&root);
        if (result + 1 != static_cast<std::int32_t>(code_.size()))
            code_.resize(static_cast<std::size_t>(result) + 1);
        return std::move(code_);
    }

private:
    std::int32_t emit(const Expression::Node& node)
    {
        Instruction made{node.operation, 0, 0, node.number};
        if (node.operands[0]) made.a = done_.at(node.operands[0].get());
        if (node.operands[1]) made.b = done_.at(node.operands[1].get());
        const bool commutes =
            made.operation == Operation::Add || made.operation == Operation::Multiply;
        if (commutes && made.b < made.a) std::swap(made.a, made.b);
        const bool picks = made.operation == Operation::Min || made.operation == Operation::Max;
        if (picks && made.a == made.b) return made.a;
        if (made.operation == Operation::Multiply && made.a == made.b)
            made = {Operation::Square, made.a, 0, 0.0};
        const auto [at, is_new] = numbers_.emplace(made, static_cast<std::int32_t>(code_.size()));
        if (is_new) {
            require(code_.size() < kMostInstructions,
                    "implicit: more than 10^6 different subexpressions");
            code_.push_back(made);
        }
        return at->second;
    }

    std::vector<Instruction> code_;
    std::unordered_map<const Expression::Node*, std::int32_t> done_;
    std::unordered_map<Instruction, std::int32_t, InstructionHash, InstructionEqual> numbers_;
};

// Room for intermediate results, kept by each thread from call to call.
template <typename T>
T* scratch(std::size_t n)
{
    thread_local std::vector<T> room;
    if (room.size() < n) room.resize(n);
    return room.data();
}

// The same, beside one that is in use.
double* other_scratch(std::size_t n)
{
    thread_local std::vector<double> room;
    if (room.size() < n) room.resize(n);
    return room.data();
}

double outside_if_undefined(double value)
{
    return std::isnan(value) ? kInfinity : value;
}

// Applies one operation to a row of operands. The common ones are written out so that the compiler
// takes several at a time.
void operate_row(const Instruction& i, const double* __restrict a, const double* __restrict b,
                 double* __restrict out, std::size_t n)
{
    const auto each = [&](const auto& f) {
        for (std::size_t k = 0; k < n; ++k) out[k] = f(k);
    };
    switch (i.operation) {
        case Operation::Negate:
            return each([&](std::size_t k) { return -a[k]; });
        case Operation::Abs:
            return each([&](std::size_t k) { return std::fabs(a[k]); });
        case Operation::Square:
            return each([&](std::size_t k) { return a[k] * a[k]; });
        case Operation::Sqrt:
            return each([&](std::size_t k) { return std::sqrt(a[k]); });
        case Operation::Add:
            return each([&](std::size_t k) { return a[k] + b[k]; });
        case Operation::Subtract:
            return each([&](std::size_t k) { return a[k] - b[k]; });
        case Operation::Multiply:
            return each([&](std::size_t k) { return a[k] * b[k]; });
        case Operation::Divide:
            return each([&](std::size_t k) { return a[k] / (b[k] + 0.0); });
        case Operation::Min:
            return each([&](std::size_t k) { return a[k] < b[k] || a[k] != a[k] ? a[k] : b[k]; });
        case Operation::Max:
            return each([&](std::size_t k) { return a[k] > b[k] || a[k] != a[k] ? a[k] : b[k]; });
        default:
            return each([&](std::size_t k) { return operate(i.operation, a[k], b[k], i.number); });
    }
}

bool is_choice(Operation operation)
{
    return operation == Operation::Min || operation == Operation::Max ||
           operation == Operation::Abs;
}

// A range with those of the derivatives along x, y and z.
struct RangeDual {
    Range range;
    IntervalVec3 slope;
};

}  // namespace

Function::Function(const Expression& expression)
    : expression_(expression), code_(Compiler().compile(expression.node()))
{
    for (std::size_t i = 0; i < code_.size(); ++i) {
        if (is_choice(code_[i].operation)) choices_.push_back(static_cast<std::int32_t>(i));
    }
    choice_list_ = std::make_shared<const ChoiceList>(code_);
}

std::uint64_t Function::hash() const
{
    std::uint64_t h = code_.size();
    for (const Instruction& i : code_) h = mix(h, InstructionHash()(i));
    return h;
}

// Does a min, max or abs take its second operand (or the negative) in this piece?
bool Function::takes_second(std::size_t instruction, std::int32_t piece) const
{
    const auto at =
        std::lower_bound(choices_.begin(), choices_.end(), static_cast<std::int32_t>(instruction));
    return (piece >> (at - choices_.begin()) & 1) != 0;
}

// All intermediate results at a point.
const double* Function::results(const Vec3& p, std::int32_t piece) const
{
    double* v = scratch<double>(code_.size());
    for (std::size_t i = 0; i < code_.size(); ++i) {
        const Instruction& c = code_[i];
        switch (c.operation) {
            case Operation::X:
                v[i] = p[0];
                break;
            case Operation::Y:
                v[i] = p[1];
                break;
            case Operation::Z:
                v[i] = p[2];
                break;
            case Operation::Min:
            case Operation::Max:
            case Operation::Abs:
                if (piece != kAsItComes) {
                    const bool second = takes_second(i, piece);
                    v[i] = c.operation == Operation::Abs ? (second ? -v[c.a] : v[c.a])
                                                         : v[second ? c.b : c.a];
                    break;
                }
                [[fallthrough]];
            default:
                v[i] = operate(c.operation, v[c.a], v[c.b], c.number);
        }
    }
    return v;
}

double Function::value_with(const Vec3& p, std::int32_t piece) const
{
    return outside_if_undefined(results(p, piece)[code_.size() - 1]);
}

double Function::value(const Vec3& p) const
{
    return value_with(p, kAsItComes);
}

void Function::values(std::span<const Vec3> points, std::span<double> out) const
{
    // Rows of intermediate results stay in the nearest cache.
    const std::size_t most = std::clamp<std::size_t>(4096 / code_.size(), 8, 128);
    double* rows = scratch<double>(code_.size() * most);
    for (std::size_t begin = 0; begin < points.size(); begin += most) {
        const std::size_t n = std::min(most, points.size() - begin);
        for (std::size_t i = 0; i < code_.size(); ++i) {
            const Instruction& c = code_[i];
            double* row = rows + i * most;
            if (c.operation == Operation::Number) {
                std::fill_n(row, n, c.number);
            } else if (operand_count(c.operation) == 0) {
                const auto axis =
                    static_cast<std::size_t>(c.operation) - static_cast<std::size_t>(Operation::X);
                for (std::size_t k = 0; k < n; ++k) row[k] = points[begin + k][axis];
            } else {
                operate_row(c, rows + c.a * most, rows + c.b * most, row, n);
            }
        }
        const double* result = rows + (code_.size() - 1) * most;
        for (std::size_t k = 0; k < n; ++k) out[begin + k] = outside_if_undefined(result[k]);
    }
}

// Backwards from the result: how it changes with each intermediate result, which parts that are not
// chosen never get.
Vec3 Function::gradient_with(const Vec3& p, std::int32_t piece) const
{
    const double* v = results(p, piece);
    if (std::isnan(v[code_.size() - 1])) return {};
    double* slope = other_scratch(code_.size());
    std::fill_n(slope, code_.size(), 0.0);
    slope[code_.size() - 1] = 1.0;
    Vec3 gradient;
    for (std::size_t i = code_.size(); i-- > 0;) {
        if (slope[i] == 0.0) continue;
        const Instruction& c = code_[i];
        const int n = operand_count(c.operation);
        if (n == 0) {
            if (c.operation != Operation::Number)
                gradient[static_cast<std::size_t>(c.operation) -
                         static_cast<std::size_t>(Operation::X)] += slope[i];
            continue;
        }
        auto [by_a, by_b] = derivatives(c.operation, v[c.a], v[c.b], c.number, v[i]);
        if (piece != kAsItComes && is_choice(c.operation)) {
            const bool second = takes_second(i, piece);
            by_a = c.operation == Operation::Abs ? (second ? -1.0 : 1.0) : (second ? 0.0 : 1.0);
            by_b = 1.0 - by_a;
        }
        if (by_a != 0.0) slope[c.a] += slope[i] * by_a;
        if (n == 2 && by_b != 0.0) slope[c.b] += slope[i] * by_b;
    }
    return is_finite(gradient) ? gradient : Vec3{};
}

Vec3 Function::gradient(const Vec3& p) const
{
    return gradient_with(p, kAsItComes);
}

Interval Function::bound(const Box3& box) const
{
    const IntervalVec3 at = to_intervals(box);
    Range* r = scratch<Range>(code_.size());
    for (std::size_t i = 0; i < code_.size(); ++i) {
        const Instruction& c = code_[i];
        switch (c.operation) {
            case Operation::X:
                r[i] = {at[0]};
                break;
            case Operation::Y:
                r[i] = {at[1]};
                break;
            case Operation::Z:
                r[i] = {at[2]};
                break;
            default:
                r[i] = operate(c.operation, r[c.a], r[c.b], c.number);
        }
    }
    const Range& result = r[code_.size() - 1];
    return {result.values.lo, result.may_be_undefined ? kInfinity : result.values.hi};
}

IntervalVec3 Function::gradient_bound(const Box3& box) const
{
    const IntervalVec3 at = to_intervals(box);
    RangeDual* d = scratch<RangeDual>(code_.size());
    for (std::size_t i = 0; i < code_.size(); ++i) {
        const Instruction& c = code_[i];
        d[i].slope = {};
        if (c.operation == Operation::Number) {
            d[i].range = operate(c.operation, Range{}, Range{}, c.number);
            continue;
        }
        if (operand_count(c.operation) == 0) {
            const auto axis =
                static_cast<std::size_t>(c.operation) - static_cast<std::size_t>(Operation::X);
            d[i].range = {at[axis]};
            d[i].slope[axis] = Interval(1.0);
            continue;
        }
        const RangeDual &a = d[c.a], &b = d[c.b];
        const Range result = operate(c.operation, a.range, b.range, c.number);
        const auto [by_a, by_b] =
            derivatives(c.operation, a.range.values, b.range.values, c.number, result.values);
        IntervalVec3 slope;
        const auto add = [](Interval& to, const Interval& by, const Interval& of) {
            if (by == Interval(0.0) || of == Interval(0.0)) return;
            const Interval more = by == Interval(1.0) ? of : by * of;
            to = to == Interval(0.0) ? more : to + more;
        };
        for (std::size_t axis = 0; axis < 3; ++axis) {
            add(slope[axis], by_a, a.slope[axis]);
            if (operand_count(c.operation) == 2) add(slope[axis], by_b, b.slope[axis]);
        }
        d[i] = {result, slope};
    }
    const RangeDual& result = d[code_.size() - 1];
    if (!result.range.may_be_undefined) return result.slope;
    return {Interval::everything(), Interval::everything(), Interval::everything()};
}

std::vector<QuadraticModel> Function::quadratic_models(const Box3& box) const
{
    return genus::quadratic_models(code_, *choice_list_, box);
}

// Errors of the operands go on by the largest derivative, and each operation adds its own.
double Function::rounding_error(const Box3& box) const
{
    constexpr double kUnit = 4.0 * std::numeric_limits<double>::epsilon();
    struct Part {
        Range range;
        double error;
    };
    const IntervalVec3 at = to_intervals(box);
    std::vector<Part> parts(code_.size());
    for (std::size_t i = 0; i < code_.size(); ++i) {
        const Instruction& c = code_[i];
        if (operand_count(c.operation) == 0) {
            const auto axis =
                static_cast<std::size_t>(c.operation) - static_cast<std::size_t>(Operation::X);
            const bool is_number = c.operation == Operation::Number;
            parts[i] = {
                is_number ? operate(c.operation, Range{}, Range{}, c.number) : Range{at[axis]},
                0.0};
            continue;
        }
        // The values as they are computed lie in the bounds, too.
        const Part &a = parts[c.a], &b = parts[c.b];
        const Range range = operate(c.operation, a.range, b.range, c.number);
        const auto [by_a, by_b] =
            derivatives(c.operation, a.range.values, b.range.values, c.number, range.values);
        const auto passed = [](const Interval& by, double error) {
            return error == 0.0 ? 0.0 : by.magnitude() * error;
        };
        double error = passed(by_a, a.error);
        if (c.operation == Operation::Sqrt) error = std::min(error, std::sqrt(a.error));
        if (operand_count(c.operation) == 2) error += passed(by_b, b.error);
        const bool exact = c.operation == Operation::Negate || c.operation == Operation::Abs ||
                           c.operation == Operation::Min || c.operation == Operation::Max;
        if (!exact) error += kUnit * (range.values.magnitude() + error);
        parts[i] = {range, range.may_be_undefined || std::isnan(error) ? kInfinity : error};
    }
    return parts.back().error;
}

std::int32_t Function::piece(const Vec3& p) const
{
    if (choices_.size() > kMostChoices) return -1;
    if (choices_.empty()) return 0;
    const double* v = results(p, kAsItComes);
    // Only what is used decides: from the result down.
    std::vector<char> used(code_.size(), 0);
    used.back() = 1;
    std::int32_t piece = 0;
    std::size_t choice = choices_.size();
    for (std::size_t i = code_.size(); i-- > 0;) {
        const Instruction& c = code_[i];
        const bool chooses = choice > 0 && static_cast<std::size_t>(choices_[choice - 1]) == i;
        if (chooses) --choice;
        if (used[i] == 0) continue;
        const int n = operand_count(c.operation);
        bool first = n > 0, second = n == 2;
        if (chooses) {
            const double by_a = derivatives(c.operation, v[c.a], v[c.b], c.number, v[i]).first;
            const bool takes_other = by_a != 1.0;
            if (takes_other) piece |= std::int32_t{1} << choice;
            if (n == 2) {
                first = !takes_other;
                second = takes_other;
            }
        }
        if (first) used[c.a] = 1;
        if (second) used[c.b] = 1;
    }
    return piece;
}

double Function::piece_value(std::int32_t piece, const Vec3& p) const
{
    return value_with(p, piece);
}

Vec3 Function::piece_gradient(std::int32_t piece, const Vec3& p) const
{
    return gradient_with(p, piece);
}

}  // namespace genus
