#include "genus/language/operators.h"

#include <algorithm>
#include <cmath>

#include "genus/language/stack.h"

namespace genus::language {

namespace {

using Items = std::span<const Value>;

void undefined(const char* op, const Value& a, const Value& b, std::string& problem)
{
    problem =
        std::string("undefined operation (") + a.type_name() + " " + op + " " + b.type_name() + ")";
}

template <typename F>
Value map(Items items, F&& f)
{
    std::vector<Value> out;
    out.reserve(items.size());
    for (const Value& v : items) out.push_back(f(v));
    return Value::list(std::move(out));
}

template <typename F>
Value element_wise(const Value& a, const Value& b, const char* op, std::string& problem, F&& f)
{
    check_stack();
    if (a.is_number() && b.is_number()) return f(a.as_number(), b.as_number());
    if (!a.is_list() || !b.is_list()) {
        undefined(op, a, b, problem);
        return Value();
    }
    const Items x = a.items(), y = b.items();
    std::vector<Value> out(std::min(x.size(), y.size()));
    std::string inner;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = element_wise(x[i], y[i], op, inner, f);
    return Value::list(std::move(out));
}

std::string size_text(std::size_t a, std::size_t b)
{
    return " (" + std::to_string(a) + " != " + std::to_string(b) + ")";
}

Value dot_product(Items a, Items b, std::string& problem)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (!a[i].is_number() || !b[i].is_number()) {
            undefined("*", a[i], b[i], problem);
            return Value();
        }
        sum += a[i].as_number() * b[i].as_number();
    }
    return Value(sum);
}

std::string entry_text(std::size_t row, std::size_t column)
{
    return "Matrix must contain only numbers. Problem at row " + std::to_string(row) + ", col " +
           std::to_string(column);
}

Value matrix_times_vector(Items m, Items v, std::string& problem)
{
    std::vector<Value> out;
    const std::size_t n = v.size();
    for (std::size_t row = 0; row < m.size(); ++row) {
        if (!m[row].is_list() || m[row].items().size() != n) {
            problem = row == 0 || !m[row].is_list() || m[0].items().size() == n
                          ? "Matrix must be rectangular. Problem at row " + std::to_string(row)
                          : "";
            if (row == 0)
                problem = "matrix*vector requires matrix column count to match vector length" +
                          size_text(m[0].items().size(), n);
            return Value();
        }
        const Items line = m[row].items();
        double sum = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            if (!line[i].is_number()) {
                problem = entry_text(row, i);
                return Value();
            }
            if (!v[i].is_number()) {
                problem = "Vector must contain only numbers. Problem at index " + std::to_string(i);
                return Value();
            }
            sum += line[i].as_number() * v[i].as_number();
        }
        out.emplace_back(sum);
    }
    return Value::list(std::move(out));
}

Value vector_times_matrix(Items v, Items m, std::string& problem)
{
    if (v.size() != m.size()) {
        problem = "vector*matrix requires vector length to match matrix row count" +
                  size_text(v.size(), m.size());
        return Value();
    }
    const std::size_t columns = m[0].items().size();
    std::vector<Value> out;
    for (std::size_t column = 0; column < columns; ++column) {
        double sum = 0.0;
        for (std::size_t row = 0; row < m.size(); ++row) {
            if (!m[row].is_list() || m[row].items().size() != columns) {
                problem = "Matrix must be rectangular. Problem at row " + std::to_string(row);
                return Value();
            }
            const Value& entry = m[row].items()[column];
            if (!entry.is_number()) {
                problem = entry_text(row, column);
                return Value();
            }
            if (!v[row].is_number()) {
                problem =
                    "Vector must contain only numbers. Problem at index " + std::to_string(row);
                return Value();
            }
            sum += v[row].as_number() * entry.as_number();
        }
        out.emplace_back(sum);
    }
    return Value::list(std::move(out));
}

Value matrix_times_matrix(Items a, Items b, std::string& problem)
{
    if (a[0].items().size() != b.size()) {
        problem =
            "matrix*matrix requires left operand column count to match right operand row count" +
            size_text(a[0].items().size(), b.size());
        return Value();
    }
    std::vector<Value> out;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (!a[i].is_list() || a[i].items().size() != b.size()) {
            problem = "Matrix must be rectangular. Problem at row " + std::to_string(i);
            return Value();
        }
        Value row = vector_times_matrix(a[i].items(), b, problem);
        if (row.is_undef()) {
            problem += "\n\twhile processing left operand at row " + std::to_string(i);
            return Value();
        }
        out.push_back(std::move(row));
    }
    return Value::list(std::move(out));
}

Value product(Items a, Items b, std::string& problem)
{
    if (a.empty() || b.empty()) {
        problem = "Multiplication is undefined on empty vectors";
        return Value();
    }
    const Value &x = a[0], &y = b[0];
    if (x.is_number() && y.is_number()) {
        if (a.size() == b.size()) return dot_product(a, b, problem);
        problem = "vector*vector requires matching lengths" + size_text(a.size(), b.size());
        return Value();
    }
    if (x.is_list() && y.is_number()) return matrix_times_vector(a, b, problem);
    if (x.is_number() && y.is_list()) return vector_times_matrix(a, b, problem);
    if (x.is_list() && y.is_list()) return matrix_times_matrix(a, b, problem);
    problem =
        std::string("undefined vector*vector multiplication where first elements are types ") +
        x.type_name() + " and " + y.type_name();
    return Value();
}

Value multiply(const Value& a, const Value& b, std::string& problem)
{
    check_stack();
    if (a.is_number() && b.is_number()) return a.as_number() * b.as_number();
    std::string inner;
    if (a.is_list() && b.is_number())
        return map(a.items(), [&](const Value& v) { return multiply(v, b, inner); });
    if (a.is_number() && b.is_list())
        return map(b.items(), [&](const Value& v) { return multiply(a, v, inner); });
    if (a.is_list() && b.is_list()) return product(a.items(), b.items(), problem);
    undefined("*", a, b, problem);
    return Value();
}

Value divide(const Value& a, const Value& b, std::string& problem)
{
    check_stack();
    if (a.is_number() && b.is_number()) return a.as_number() / b.as_number();
    std::string inner;
    if (a.is_list() && b.is_number())
        return map(a.items(), [&](const Value& v) { return divide(v, b, inner); });
    if (a.is_number() && b.is_list())
        return map(b.items(), [&](const Value& v) { return divide(a, v, inner); });
    undefined("/", a, b, problem);
    return Value();
}

// The order of two values of a kind: negative, zero, positive; nothing where they have none.
template <typename T>
Value ordered(BinaryOp op, const T& a, const T& b)
{
    switch (op) {
        case BinaryOp::Less:
            return a < b;
        case BinaryOp::LessEqual:
            return a <= b;
        case BinaryOp::Greater:
            return a > b;
        default:
            return a >= b;
    }
}

Value compare(BinaryOp op, const Value& a, const Value& b, std::string& problem);

Value compare_lists(BinaryOp op, Items a, Items b, std::string& problem)
{
    // The first elements that differ decide.
    const std::size_t n = std::min(a.size(), b.size());
    for (std::size_t i = 0; i < n; ++i) {
        if (equal(a[i], b[i])) continue;
        Value v = compare(op, a[i], b[i], problem);
        if (v.is_undef() && !problem.empty())
            problem += "\n\tin vector comparison at index " + std::to_string(i);
        return v;
    }
    return ordered(op, a.size(), b.size());
}

Value compare(BinaryOp op, const Value& a, const Value& b, std::string& problem)
{
    check_stack();
    if (a.is_number() && b.is_number()) return ordered(op, a.as_number(), b.as_number());
    if (a.is_string() && b.is_string()) return ordered(op, a.as_string(), b.as_string());
    if (a.is_bool() && b.is_bool()) return ordered(op, a.as_bool(), b.as_bool());
    if (a.is_list() && b.is_list()) return compare_lists(op, a.items(), b.items(), problem);
    if (a.is_range() && b.is_range())
        return ordered(op, compare_ranges(a.as_range(), b.as_range()), 0);
    if (a.tag() == b.tag())
        problem = std::string("operation undefined (") + a.type_name() + " " + to_string(op) + " " +
                  b.type_name() + ")";
    else
        undefined(to_string(op), a, b, problem);
    return Value();
}

}  // namespace

Value apply(BinaryOp op, const Value& a, const Value& b, std::string& problem)
{
    switch (op) {
        case BinaryOp::Add:
            return element_wise(a, b, "+", problem, [](double x, double y) { return x + y; });
        case BinaryOp::Subtract:
            return element_wise(a, b, "-", problem, [](double x, double y) { return x - y; });
        case BinaryOp::Multiply:
            return multiply(a, b, problem);
        case BinaryOp::Divide:
            return divide(a, b, problem);
        case BinaryOp::Modulo:
            if (a.is_number() && b.is_number()) return std::fmod(a.as_number(), b.as_number());
            undefined("%", a, b, problem);
            return Value();
        case BinaryOp::Power:
            if (a.is_number() && b.is_number()) return std::pow(a.as_number(), b.as_number());
            undefined("^", a, b, problem);
            return Value();
        case BinaryOp::Equal:
            return equal(a, b);
        case BinaryOp::NotEqual:
            return !equal(a, b);
        default:
            return compare(op, a, b, problem);
    }
}

Value negate(const Value& a, std::string& problem)
{
    check_stack();
    if (a.is_number()) return -a.as_number();
    if (a.is_list()) {
        std::string inner;
        return map(a.items(), [&](const Value& v) { return negate(v, inner); });
    }
    problem = std::string("undefined operation (-") + a.type_name() + ")";
    return Value();
}

}  // namespace genus::language
