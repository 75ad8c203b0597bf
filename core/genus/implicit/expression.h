#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace genus {

/// What a node of an expression does with its operands.
enum class Operation : std::uint8_t {
    Number,
    X,
    Y,
    Z,
    Negate,
    Abs,
    Square,
    Power,  // to a whole number
    Sqrt,
    Cbrt,
    Exp,
    Log,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Floor,
    Ceil,
    Round,
    Sign,
    Add,
    Subtract,
    Multiply,
    Divide,
    RealPower,
    Atan2,
    Min,
    Max,
};
/// Numbers and coordinates have none, functions one, the rest two.
int operand_count(Operation operation);

/// A formula in x, y and z: a shared, immutable graph of nodes. Building one costs O(1) and never
/// throws but for memory; operations on numbers are carried out at once. Angles are radians.
///
/// What is not defined, such as the root of a negative number, is not a number, and so is
/// everything made of it.
class Expression {
public:
    struct Node;

    Expression(double number = 0.0);  // NOLINT: a number is an expression
    static Expression x();
    static Expression y();
    static Expression z();
    static Expression apply(Operation operation, const Expression& a);
    static Expression apply(Operation operation, const Expression& a, const Expression& b);

    /// What a node says.
    static Expression of(std::shared_ptr<const Node> node) { return Expression(std::move(node)); }

    const Node& node() const { return *node_; }
    /// Null unless the expression is a number.
    const double* number() const;

private:
    explicit Expression(std::shared_ptr<const Node> node) : node_(std::move(node)) {}
    std::shared_ptr<const Node> node_;
};

struct Expression::Node {
    Operation operation = Operation::Number;
    double number = 0.0;  // of a Number; the exponent of a Power
    std::array<std::shared_ptr<const Node>, 2> operands{};

    Node(Operation operation_, double number_, std::array<std::shared_ptr<const Node>, 2> operands_)
        : operation(operation_), number(number_), operands(std::move(operands_))
    {
    }
    Node(const Node&) = delete;
    Node& operator=(const Node&) = delete;
    /// Takes what is below apart without recursion, so that no depth overflows the stack.
    ~Node();
};

Expression operator-(const Expression& a);
Expression operator+(const Expression& a, const Expression& b);
Expression operator-(const Expression& a, const Expression& b);
Expression operator*(const Expression& a, const Expression& b);
Expression operator/(const Expression& a, const Expression& b);

Expression pow(const Expression& a, const Expression& b);
Expression min(const Expression& a, const Expression& b);
Expression max(const Expression& a, const Expression& b);
/// a - b floor(a / b): between 0 and b.
Expression mod(const Expression& a, const Expression& b);
Expression hypot(const Expression& a, const Expression& b);
/// The nearest of low .. high.
Expression clamp(const Expression& a, const Expression& low, const Expression& high);
/// a + t (b - a).
Expression mix(const Expression& a, const Expression& b, const Expression& t);
/// The smaller of two with the crease between them rounded over a band |a - b| < width, below the
/// smaller by up to a quarter of the width. Once continuously differentiable.
Expression smooth_min(const Expression& a, const Expression& b, const Expression& width);
Expression smooth_max(const Expression& a, const Expression& b, const Expression& width);
/// a less the nearest multiple of the period, so that what is written for -period/2 .. period/2
/// repeats for ever.
Expression repeat(const Expression& a, const Expression& period);

/// The expression with others in place of x, y and z. O(nodes); what is shared stays shared.
Expression substituted(const Expression& expression, const std::array<Expression, 3>& xyz);

/// As `parse_expression` reads it, with "..." in place of what is longer than `most` characters.
std::string to_text(const Expression& expression, std::size_t most = 200);

}  // namespace genus
