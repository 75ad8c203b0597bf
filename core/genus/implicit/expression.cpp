#include "genus/implicit/expression.h"

#include <cmath>
#include <unordered_map>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/implicit/operations.h"
#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using NodePtr = std::shared_ptr<const Expression::Node>;

bool is_number(const Expression& e, double value)
{
    return e.number() && *e.number() == value;
}

// The operand that is the outcome, whatever it is; null if there is none.
const Expression* one_that_is_all(Operation operation, const Expression& a, const Expression& b)
{
    switch (operation) {
        case Operation::Add:
            return is_number(a, 0.0) ? &b : is_number(b, 0.0) ? &a : nullptr;
        case Operation::Subtract:
            return is_number(b, 0.0) ? &a : nullptr;
        case Operation::Multiply:
            return is_number(a, 1.0) ? &b : is_number(b, 1.0) ? &a : nullptr;
        case Operation::Divide:
            return is_number(b, 1.0) ? &a : nullptr;
        case Operation::Min:
        case Operation::Max:
            return &a.node() == &b.node() ? &a : nullptr;
        default:
            return nullptr;
    }
}

// Whole exponents up to this are powers by multiplication.
constexpr double kLargestPower = 1024.0;

}  // namespace

int operand_count(Operation operation)
{
    if (operation <= Operation::Z) return 0;
    return operation < Operation::Add ? 1 : 2;
}

Expression::Node::~Node()
{
    std::vector<NodePtr> below;
    const auto take = [&below](std::array<NodePtr, 2>& from) {
        for (NodePtr& operand : from)
            if (operand) below.push_back(std::move(operand));
    };
    take(operands);
    while (!below.empty()) {
        const NodePtr node = std::move(below.back());
        below.pop_back();
        // The last to hold it: its operands come here before it goes.
        if (node.use_count() == 1) take(const_cast<Node&>(*node).operands);
    }
}

Expression::Expression(double number)
    : node_(std::make_shared<const Node>(Operation::Number, number, std::array<NodePtr, 2>{}))
{
}

Expression Expression::x()
{
    return Expression(std::make_shared<const Node>(Operation::X, 0.0, std::array<NodePtr, 2>{}));
}

Expression Expression::y()
{
    return Expression(std::make_shared<const Node>(Operation::Y, 0.0, std::array<NodePtr, 2>{}));
}

Expression Expression::z()
{
    return Expression(std::make_shared<const Node>(Operation::Z, 0.0, std::array<NodePtr, 2>{}));
}

Expression Expression::apply(Operation operation, const Expression& a)
{
    if (const double* n = a.number()) return operate(operation, *n, 0.0, 0.0);
    return Expression(
        std::make_shared<const Node>(operation, 0.0, std::array<NodePtr, 2>{a.node_, nullptr}));
}

Expression Expression::apply(Operation operation, const Expression& a, const Expression& b)
{
    const double *m = a.number(), *n = b.number();
    if (m && n) return operate(operation, *m, *n, 0.0);
    if (const Expression* same = one_that_is_all(operation, a, b)) return *same;
    if (operation == Operation::Multiply && &a.node() == &b.node())
        return apply(Operation::Square, a);
    if (operation == Operation::RealPower && n) {
        if (*n == 1.0) return a;
        if (*n == 2.0) return apply(Operation::Square, a);
        if (*n == 0.5) return apply(Operation::Sqrt, a);
        if (*n == std::floor(*n) && std::fabs(*n) <= kLargestPower)
            return Expression(std::make_shared<const Node>(
                Operation::Power, *n, std::array<NodePtr, 2>{a.node_, nullptr}));
    }
    return Expression(
        std::make_shared<const Node>(operation, 0.0, std::array<NodePtr, 2>{a.node_, b.node_}));
}

const double* Expression::number() const
{
    return node_->operation == Operation::Number ? &node_->number : nullptr;
}

Expression operator-(const Expression& a)
{
    return Expression::apply(Operation::Negate, a);
}

Expression operator+(const Expression& a, const Expression& b)
{
    return Expression::apply(Operation::Add, a, b);
}

Expression operator-(const Expression& a, const Expression& b)
{
    return Expression::apply(Operation::Subtract, a, b);
}

Expression operator*(const Expression& a, const Expression& b)
{
    return Expression::apply(Operation::Multiply, a, b);
}

Expression operator/(const Expression& a, const Expression& b)
{
    return Expression::apply(Operation::Divide, a, b);
}

Expression pow(const Expression& a, const Expression& b)
{
    return Expression::apply(Operation::RealPower, a, b);
}

Expression min(const Expression& a, const Expression& b)
{
    return Expression::apply(Operation::Min, a, b);
}

Expression max(const Expression& a, const Expression& b)
{
    return Expression::apply(Operation::Max, a, b);
}

Expression mod(const Expression& a, const Expression& b)
{
    return a - b * Expression::apply(Operation::Floor, a / b);
}

Expression hypot(const Expression& a, const Expression& b)
{
    return Expression::apply(Operation::Sqrt, Expression::apply(Operation::Square, a) +
                                                  Expression::apply(Operation::Square, b));
}

Expression clamp(const Expression& a, const Expression& low, const Expression& high)
{
    return min(max(a, low), high);
}

Expression mix(const Expression& a, const Expression& b, const Expression& t)
{
    return a + t * (b - a);
}

Expression smooth_min(const Expression& a, const Expression& b, const Expression& width)
{
    const Expression within = max(width - Expression::apply(Operation::Abs, a - b), 0.0);
    return min(a, b) - Expression::apply(Operation::Square, within) / (Expression(4.0) * width);
}

Expression smooth_max(const Expression& a, const Expression& b, const Expression& width)
{
    return -smooth_min(-a, -b, width);
}

Expression repeat(const Expression& a, const Expression& period)
{
    return a - period * Expression::apply(Operation::Round, a / period);
}

Expression substituted(const Expression& expression, const std::array<Expression, 3>& xyz)
{
    std::unordered_map<const Expression::Node*, Expression> done;
    visit_nodes(expression, [&](const Expression::Node& node) {
        const auto operand = [&](std::size_t i) { return done.at(node.operands[i].get()); };
        switch (node.operation) {
            case Operation::Number:
                done.emplace(&node, node.number);
                break;
            case Operation::X:
                done.emplace(&node, xyz[0]);
                break;
            case Operation::Y:
                done.emplace(&node, xyz[1]);
                break;
            case Operation::Z:
                done.emplace(&node, xyz[2]);
                break;
            case Operation::Power:
                done.emplace(&node, pow(operand(0), node.number));
                break;
            default:
                done.emplace(&node, node.operands[1]
                                        ? Expression::apply(node.operation, operand(0), operand(1))
                                        : Expression::apply(node.operation, operand(0)));
        }
    });
    return done.at(&expression.node());
}

namespace {

const char* name_of(Operation operation)
{
    static constexpr const char* names[] = {
        "",     "x",     "y",    "z",   "-",    "abs",  "square", "pow",  "sqrt",  "cbrt", "exp",
        "log",  "sin",   "cos",  "tan", "asin", "acos", "atan",   "sinh", "cosh",  "tanh", "floor",
        "ceil", "round", "sign", " + ", " - ",  " * ",  " / ",    "pow",  "atan2", "min",  "max"};
    static_assert(std::size(names) == static_cast<std::size_t>(Operation::Max) + 1);
    return names[static_cast<std::size_t>(operation)];
}

bool is_infix(Operation operation)
{
    return operation >= Operation::Add && operation <= Operation::Divide;
}

}  // namespace

std::string to_text(const Expression& expression, std::size_t most)
{
    // What is still to be written, last first: a node or a piece of text.
    struct Item {
        const Expression::Node* node;
        std::string text;
    };
    std::vector<Item> stack{{&expression.node(), {}}};
    std::string out;
    while (!stack.empty() && out.size() <= most) {
        const Item item = std::move(stack.back());
        stack.pop_back();
        if (!item.node) {
            out += item.text;
            continue;
        }
        const Operation operation = item.node->operation;
        const auto& [a, b] = item.node->operands;
        if (operation == Operation::Number) {
            out += to_text(item.node->number);
        } else if (operand_count(operation) == 0) {
            out += name_of(operation);
        } else if (is_infix(operation)) {
            out += "(";
            stack.push_back({nullptr, ")"});
            stack.push_back({b.get(), {}});
            stack.push_back({nullptr, name_of(operation)});
            stack.push_back({a.get(), {}});
        } else {
            out += std::string(name_of(operation)) + "(";
            stack.push_back({nullptr, ")"});
            if (operation == Operation::Power)
                stack.push_back({nullptr, ", " + to_text(item.node->number)});
            if (b) {
                stack.push_back({b.get(), {}});
                stack.push_back({nullptr, ", "});
            }
            stack.push_back({a.get(), {}});
        }
    }
    if (out.size() > most) out = out.substr(0, most) + "...";
    return out;
}

}  // namespace genus
