#include "genus/implicit/parse_expression.h"

#include <charconv>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <unordered_map>
#include <vector>

#include "genus/base/error.h"

namespace genus {

namespace {

constexpr std::size_t kLongest = 1'000'000;
constexpr int kDeepest = 200;

using Arguments = std::vector<Expression>;

struct NamedFunction {
    std::size_t fewest, most;
    std::function<Expression(const Arguments&)> make;
};

Expression folded(const Arguments& a, Expression (*f)(const Expression&, const Expression&))
{
    Expression result = a[0];
    for (std::size_t i = 1; i < a.size(); ++i) result = f(result, a[i]);
    return result;
}

Expression length_of(const Arguments& a)
{
    Expression sum;
    for (const Expression& e : a) sum = sum + Expression::apply(Operation::Square, e);
    return Expression::apply(Operation::Sqrt, sum);
}

const std::unordered_map<std::string_view, NamedFunction>& functions()
{
    constexpr std::size_t any = kLongest;
    const auto one = [](Operation o) {
        return NamedFunction{1, 1, [o](const Arguments& a) { return Expression::apply(o, a[0]); }};
    };
    const auto log_to = [](double base) {
        return NamedFunction{1, 1, [base](const Arguments& a) {
                                 return Expression::apply(Operation::Log, a[0]) / std::log(base);
                             }};
    };
    using O = Operation;
    static const std::unordered_map<std::string_view, NamedFunction> map{
        {"sin", one(O::Sin)},
        {"cos", one(O::Cos)},
        {"tan", one(O::Tan)},
        {"asin", one(O::Asin)},
        {"acos", one(O::Acos)},
        {"atan", one(O::Atan)},
        {"sinh", one(O::Sinh)},
        {"cosh", one(O::Cosh)},
        {"tanh", one(O::Tanh)},
        {"exp", one(O::Exp)},
        {"log", one(O::Log)},
        {"ln", one(O::Log)},
        {"log2", log_to(2.0)},
        {"log10", log_to(10.0)},
        {"sqrt", one(O::Sqrt)},
        {"cbrt", one(O::Cbrt)},
        {"abs", one(O::Abs)},
        {"sign", one(O::Sign)},
        {"square", one(O::Square)},
        {"floor", one(O::Floor)},
        {"ceil", one(O::Ceil)},
        {"round", one(O::Round)},
        {"atan2",
         {2, 2, [](const Arguments& a) { return Expression::apply(O::Atan2, a[0], a[1]); }}},
        {"pow", {2, 2, [](const Arguments& a) { return pow(a[0], a[1]); }}},
        {"mod", {2, 2, [](const Arguments& a) { return mod(a[0], a[1]); }}},
        {"min", {1, any, [](const Arguments& a) { return folded(a, &min); }}},
        {"max", {1, any, [](const Arguments& a) { return folded(a, &max); }}},
        {"hypot", {1, any, &length_of}},
        {"length", {1, any, &length_of}},
        {"clamp", {3, 3, [](const Arguments& a) { return clamp(a[0], a[1], a[2]); }}},
        {"mix", {3, 3, [](const Arguments& a) { return mix(a[0], a[1], a[2]); }}},
        {"smin", {3, 3, [](const Arguments& a) { return smooth_min(a[0], a[1], a[2]); }}},
        {"smax", {3, 3, [](const Arguments& a) { return smooth_max(a[0], a[1], a[2]); }}},
        {"repeat", {2, 2, [](const Arguments& a) { return repeat(a[0], a[1]); }}},
    };
    return map;
}

bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

class Parser {
public:
    explicit Parser(std::string_view text) : text_(text) {}

    Expression parse()
    {
        Expression result = sum();
        if (take("<=") || take("==") || take("=") || take("<")) {
            result = result - sum();
        } else if (take(">=") || take(">")) {
            result = sum() - result;
        }
        skip_space();
        if (at_ < text_.size()) fail(at_, "unexpected " + shown(at_));
        return result;
    }

private:
    [[noreturn]] void fail(std::size_t at, const std::string& problem) const
    {
        throw InvalidInput("implicit: column " + std::to_string(at + 1) + ": " + problem);
    }

    std::string shown(std::size_t at) const
    {
        if (at >= text_.size()) return "end of the formula";
        const char c = text_[at];
        if (c >= 33 && c < 127) return std::string("'") + c + "'";
        return "character with code " + std::to_string(static_cast<unsigned char>(c));
    }

    void skip_space()
    {
        while (at_ < text_.size() &&
               (text_[at_] == ' ' || (text_[at_] >= '\t' && text_[at_] <= '\r')))
            ++at_;
    }

    bool take(std::string_view token)
    {
        skip_space();
        if (text_.substr(at_, token.size()) != token) return false;
        at_ += token.size();
        return true;
    }

    void expect(char c)
    {
        if (!take({&c, 1})) fail(at_, std::string("expected '") + c + "', found " + shown(at_));
    }

    Expression sum()
    {
        Expression result = product();
        for (;;) {
            if (take("+")) {
                result = result + product();
            } else if (take("-")) {
                result = result - product();
            } else {
                return result;
            }
        }
    }

    Expression product()
    {
        Expression result = signed_power();
        for (;;) {
            if (take("*")) {
                result = result * signed_power();
            } else if (take("/")) {
                result = result / signed_power();
            } else if (take("%")) {
                result = mod(result, signed_power());
            } else {
                return result;
            }
        }
    }

    // -x^2 is -(x^2).
    Expression signed_power()
    {
        bool negative = false;
        for (;;) {
            if (take("-")) {
                negative = !negative;
            } else if (!take("+")) {
                break;
            }
        }
        const Expression result = power();
        return negative ? -result : result;
    }

    Expression power()
    {
        const Nested nested(*this);
        const Expression base = atom();
        if (take("**") || take("^")) return pow(base, signed_power());
        return base;
    }

    Expression atom()
    {
        skip_space();
        const std::size_t start = at_;
        if (start >= text_.size()) fail(start, "the formula ends where a value is expected");
        if (take("(")) {
            const Expression inner = sum();
            expect(')');
            return inner;
        }
        if (is_digit(text_[start]) || text_[start] == '.') return number();
        if (is_letter(text_[start])) return named();
        fail(start, "unexpected " + shown(start));
    }

    Expression number()
    {
        double value = 0.0;
        const char* begin = text_.data() + at_;
        const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
        if (error == std::errc::result_out_of_range) fail(at_, "the number is out of range");
        if (error != std::errc()) fail(at_, "unexpected " + shown(at_));
        at_ += static_cast<std::size_t>(end - begin);
        // 2x is a slip, not a product.
        if (at_ < text_.size() && (is_letter(text_[at_]) || text_[at_] == '.'))
            fail(at_, "unexpected " + shown(at_) + " after a number");
        return value;
    }

    Expression named()
    {
        const std::size_t start = at_;
        while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
        const std::string_view name = text_.substr(start, at_ - start);
        if (name == "x") return Expression::x();
        if (name == "y") return Expression::y();
        if (name == "z") return Expression::z();
        if (name == "pi") return std::numbers::pi;
        if (name == "tau") return 2.0 * std::numbers::pi;
        if (name == "e") return std::numbers::e;
        const auto found = functions().find(name);
        if (found == functions().end())
            fail(start, "unknown name '" + std::string(name.substr(0, 60)) + "'");
        expect('(');
        Arguments arguments;
        if (!take(")")) {
            do arguments.push_back(sum());
            while (take(","));
            expect(')');
        }
        const NamedFunction& f = found->second;
        if (arguments.size() < f.fewest || arguments.size() > f.most)
            fail(start, "'" + std::string(name) + "' takes " + count(f) + ", not " +
                            std::to_string(arguments.size()));
        return f.make(arguments);
    }

    static std::string count(const NamedFunction& f)
    {
        const std::string n = std::to_string(f.fewest);
        if (f.most == kLongest) return n + " argument or more";
        return n + (f.fewest == 1 ? " argument" : " arguments");
    }

    struct Nested {
        explicit Nested(Parser& parser) : parser_(parser)
        {
            if (++parser_.depth_ > kDeepest) parser_.fail(parser_.at_, "nested deeper than 200");
        }
        ~Nested() { --parser_.depth_; }
        Nested(const Nested&) = delete;
        Nested& operator=(const Nested&) = delete;
        Parser& parser_;
    };

    std::string_view text_;
    std::size_t at_ = 0;
    int depth_ = 0;
};

}  // namespace

Expression parse_expression(std::string_view text)
{
    require(text.size() <= kLongest, "implicit: the formula is longer than 10^6 characters");
    return Parser(text).parse();
}

}  // namespace genus
