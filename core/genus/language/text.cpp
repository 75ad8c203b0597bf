#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "genus/language/evaluate.h"
#include "genus/language/model_tree.h"
#include "genus/language/stack.h"
#include "genus/language/syntax.h"

namespace genus::language {

namespace {

// The digits of a number rounded to six, and the power of ten of the first.
struct Digits {
    char text[8];
    int n = 0;
    int exponent = 0;
};

// Scientific form of so many digits, cut into digits and exponent.
Digits split(const char* c, const char* end)
{
    Digits d;
    for (; c != end && *c != 'e'; ++c)
        if (*c != '.') d.text[d.n++] = *c;
    if (c != end) {
        ++c;
        if (*c == '+') ++c;
        std::from_chars(c, end, d.exponent);
    }
    return d;
}

// One unit more in the last digit.
void round_up(Digits& d)
{
    int i = d.n - 1;
    for (; i >= 0 && d.text[i] == '9'; --i) d.text[i] = '0';
    if (i >= 0) {
        ++d.text[i];
        return;
    }
    d.text[0] = '1';
    ++d.exponent;
}

// Whether the value lies exactly in the middle between two numbers of six digits and was rounded
// down to the even one; the text language rounds such up.
bool rounded_down_from_middle(double value, const Digits& d)
{
    if ((d.text[5] - '0') % 2 != 0) return false;
    char exact[64];
    const auto end =
        std::to_chars(exact, exact + sizeof exact, value, std::chars_format::scientific, 40).ptr;
    std::string digits;
    for (const char* c = exact; c != end && *c != 'e'; ++c)
        if (*c != '.') digits += *c;
    return digits.compare(0, 6, d.text, 6) == 0 && digits[6] == '5' &&
           digits.find_first_not_of('0', 7) == std::string::npos;
}

Digits six_digits(double value)
{
    char buffer[32];
    const auto end =
        std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::scientific, 5).ptr;
    Digits d = split(buffer, end);
    // A number in the middle has a short binary fraction; most have none and are done.
    if (value * 67108864.0 == std::floor(value * 67108864.0) && rounded_down_from_middle(value, d))
        round_up(d);
    while (d.n > 1 && d.text[d.n - 1] == '0') --d.n;
    return d;
}

void append_quoted(std::string& out, std::string_view text)
{
    out += '"';
    out += text;
    out += '"';
}

void append(std::string& out, const Value& v, const Names& names, bool quoted)
{
    check_stack();
    switch (v.tag()) {
        case Value::Tag::Unset:
        case Value::Tag::Undef:
            out += "undef";
            return;
        case Value::Tag::Bool:
            out += v.as_bool() ? "true" : "false";
            return;
        case Value::Tag::Number:
            append_number(out, v.as_number());
            return;
        case Value::Tag::String:
            if (quoted)
                append_quoted(out, v.as_string());
            else
                out += v.as_string();
            return;
        case Value::Tag::List: {
            out += '[';
            const char* separator = "";
            for (const Value& item : v.items()) {
                out += separator;
                separator = ", ";
                append(out, item, names, true);
            }
            out += ']';
            return;
        }
        case Value::Tag::Range: {
            const RangeObject& r = v.as_range();
            out += '[';
            append_number(out, r.begin);
            out += " : ";
            append_number(out, r.step);
            out += " : ";
            append_number(out, r.end);
            out += ']';
            return;
        }
        case Value::Tag::Function:
            out += to_text(*v.as_function().definition, names);
            return;
    }
}

/// Writes expressions back as text.
class Printer {
public:
    explicit Printer(const Names& names) : names_(names) {}

    void expr(const Expr& e)
    {
        check_stack();
        switch (e.kind) {
            case ExprKind::Literal: {
                const auto& l = static_cast<const Literal&>(e);
                if (l.source)
                    expr(*l.source);
                else
                    append(out, l.value, names_, true);
                return;
            }
            case ExprKind::Variable:
                name(static_cast<const Variable&>(e).name);
                return;
            case ExprKind::Special:
                name(static_cast<const Special&>(e).name);
                return;
            case ExprKind::Unary: {
                const auto& u = static_cast<const Unary&>(e);
                out += u.op == UnaryOp::Plus ? "+" : u.op == UnaryOp::Minus ? "-" : "!";
                expr(*u.a);
                return;
            }
            case ExprKind::Binary:
            case ExprKind::And:
            case ExprKind::Or: {
                const auto& b = static_cast<const Binary&>(e);
                const char* op = e.kind == ExprKind::And  ? "&&"
                                 : e.kind == ExprKind::Or ? "||"
                                                          : to_string(b.op);
                out += '(';
                expr(*b.a);
                out += std::string(" ") + op + " ";
                expr(*b.b);
                out += ')';
                return;
            }
            case ExprKind::Ternary: {
                const auto& t = static_cast<const Ternary&>(e);
                out += '(';
                expr(*t.condition);
                out += " ? ";
                expr(*t.yes);
                out += " : ";
                expr(*t.no);
                out += ')';
                return;
            }
            case ExprKind::Range:
                range(static_cast<const RangeExpr&>(e));
                return;
            case ExprKind::List: {
                out += '[';
                const char* separator = "";
                for (const Expr* item : static_cast<const List&>(e).items) {
                    out += separator;
                    separator = ", ";
                    expr(*item);
                }
                out += ']';
                return;
            }
            case ExprKind::Index: {
                const auto& i = static_cast<const Index&>(e);
                expr(*i.of);
                out += '[';
                expr(*i.at);
                out += ']';
                return;
            }
            case ExprKind::Member: {
                const auto& m = static_cast<const Member&>(e);
                expr(*m.of);
                out += '.';
                name(m.name);
                return;
            }
            case ExprKind::Call:
                call(static_cast<const Call&>(e));
                return;
            case ExprKind::FunctionLiteral:
                function(static_cast<const FunctionLiteral&>(e).definition);
                return;
            default:
                scoped(e);
        }
    }

    void function(const FunctionDefinition& f)
    {
        out += "function(";
        const char* separator = "";
        for (const Parameter& p : f.parameters) {
            out += separator;
            separator = ", ";
            name(p.name);
            if (!p.value) continue;
            out += " = ";
            expr(*p.value);
        }
        out += ") ";
        expr(*f.body);
    }

    std::string out;

private:
    void name(Names::Id id) { out += names_[id]; }

    void range(const RangeExpr& r)
    {
        out += '[';
        expr(*r.begin);
        out += " : ";
        if (r.step) {
            expr(*r.step);
            out += " : ";
        }
        expr(*r.end);
        out += ']';
    }

    void call(const Call& c)
    {
        const bool bare = c.callee->kind == ExprKind::Variable ||
                          c.callee->kind == ExprKind::Special || c.callee->kind == ExprKind::Call;
        if (!bare) out += '(';
        expr(*c.callee);
        if (!bare) out += ')';
        arguments(c.arguments);
    }

    template <typename List>
    void arguments(const List& list)
    {
        out += '(';
        const char* separator = "";
        for (const auto& a : list) {
            out += separator;
            separator = ", ";
            if (a.name != Argument::kNoName) {
                name(a.name);
                out += " = ";
            }
            expr(*a.value);
        }
        out += ')';
    }

    void bracketed(const Expr& e)
    {
        out += '(';
        expr(e);
        out += ')';
    }

    void scoped(const Expr& e)
    {
        switch (e.kind) {
            case ExprKind::Let: {
                const auto& l = static_cast<const Let&>(e);
                out += "let";
                arguments(l.bindings.pairs);
                out += ' ';
                expr(*l.body);
                return;
            }
            case ExprKind::ListLet: {
                const auto& l = static_cast<const Let&>(e);
                out += "let";
                arguments(l.bindings.pairs);
                out += ' ';
                bracketed(*l.body);
                return;
            }
            case ExprKind::Assert:
            case ExprKind::Echo: {
                const auto& a = static_cast<const AssertExpr&>(e);
                out += e.kind == ExprKind::Assert ? "assert" : "echo";
                arguments(a.arguments);
                if (!a.body) return;
                out += ' ';
                expr(*a.body);
                return;
            }
            case ExprKind::For: {
                const auto& f = static_cast<const For&>(e);
                out += "for";
                arguments(f.bindings.pairs);
                out += ' ';
                bracketed(*f.body);
                return;
            }
            case ExprKind::CFor:
                c_for(static_cast<const CFor&>(e));
                return;
            case ExprKind::If: {
                const auto& i = static_cast<const If&>(e);
                out += "if(";
                expr(*i.condition);
                out += ") ";
                bracketed(*i.yes);
                if (!i.no) return;
                out += " else ";
                bracketed(*i.no);
                return;
            }
            case ExprKind::Each:
                out += "each ";
                bracketed(*static_cast<const Each&>(e).of);
                return;
            default:
                return;
        }
    }

    void c_for(const CFor& f)
    {
        const auto pairs = [&](std::span<const BindingPair> list) {
            const char* separator = "";
            for (const BindingPair& pair : list) {
                out += separator;
                separator = ", ";
                if (pair.name != Argument::kNoName) {
                    name(pair.name);
                    out += " = ";
                }
                expr(*pair.value);
            }
        };
        out += "for(";
        pairs(std::span(f.bindings.pairs).first(f.n_start));
        out += ';';
        expr(*f.condition);
        out += ';';
        pairs(f.updates);
        out += ") ";
        expr(*f.body);
    }

    const Names& names_;
};

}  // namespace

void append_number(std::string& out, double value)
{
    if (value == 0.0) {
        out += '0';
        return;
    }
    if (std::isnan(value)) {
        out += "nan";
        return;
    }
    if (value < 0.0) out += '-';
    value = std::abs(value);
    if (std::isinf(value)) {
        out += "inf";
        return;
    }
    if (value < 1e6 && value == std::floor(value)) {
        out += std::to_string(static_cast<long>(value));
        return;
    }
    const Digits d = six_digits(value);
    const auto digits = [&](int from, int to) {
        for (int i = from; i < to; ++i) out += i < d.n ? d.text[i] : '0';
    };
    if (d.exponent < -5 || d.exponent >= 6) {
        digits(0, 1);
        if (d.n > 1) out += '.';
        digits(1, d.n);
        out += d.exponent < 0 ? "e-" : "e+";
        out += std::to_string(std::abs(d.exponent));
    } else if (d.exponent < 0) {
        out += "0." + std::string(static_cast<std::size_t>(-d.exponent - 1), '0');
        digits(0, d.n);
    } else {
        digits(0, d.exponent + 1);
        if (d.n > d.exponent + 1) out += '.';
        digits(d.exponent + 1, d.n);
    }
}

std::string number_text(double value)
{
    std::string out;
    append_number(out, value);
    return out;
}

std::string to_text(const Value& v, const Names& names)
{
    std::string out;
    append(out, v, names, false);
    return out;
}

std::string to_quoted_text(const Value& v, const Names& names)
{
    std::string out;
    append(out, v, names, true);
    return out;
}

std::string to_text(const Expr& expr, const Names& names)
{
    Printer printer(names);
    printer.expr(expr);
    return std::move(printer.out);
}

std::string to_text(const FunctionDefinition& definition, const Names& names)
{
    Printer printer(names);
    printer.function(definition);
    return std::move(printer.out);
}

const char* to_string(BinaryOp op)
{
    switch (op) {
        case BinaryOp::Add:
            return "+";
        case BinaryOp::Subtract:
            return "-";
        case BinaryOp::Multiply:
            return "*";
        case BinaryOp::Divide:
            return "/";
        case BinaryOp::Modulo:
            return "%";
        case BinaryOp::Power:
            return "^";
        case BinaryOp::Less:
            return "<";
        case BinaryOp::LessEqual:
            return "<=";
        case BinaryOp::Greater:
            return ">";
        case BinaryOp::GreaterEqual:
            return ">=";
        case BinaryOp::Equal:
            return "==";
        case BinaryOp::NotEqual:
            return "!=";
    }
    return "";
}

}  // namespace genus::language

namespace genus {

namespace {

// Most parameters show numbers as C does, matrices and lists of points as echo does.
enum class Style { Plain, Echo };

void append_plain_number(std::string& out, double value)
{
    if (std::isnan(value)) {
        out += "nan";
        return;
    }
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value == 0.0 ? 0.0 : value,
                                   std::chars_format::general, 6)
                         .ptr;
    out.append(buffer, end);
}

void append_text(std::string& out, const std::string& text)
{
    out += '"';
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (c == '\n')
            out += "\\n";
        else if (c == '\r')
            out += "\\r";
        else if (c == '\t')
            out += "\\t";
        else
            out += c;
    }
    out += '"';
}

void append(std::string& out, const ModelValue& v, const char* separator, Style style)
{
    if (v.is_undef()) {
        out += "undef";
    } else if (const double* n = v.number()) {
        if (style == Style::Echo)
            language::append_number(out, *n);
        else
            append_plain_number(out, *n);
    } else if (const std::string* text = v.text()) {
        append_text(out, *text);
    } else if (const ModelValue::List* list = v.list()) {
        out += '[';
        const char* between = "";
        for (const ModelValue& item : *list) {
            out += between;
            between = separator;
            append(out, item, separator, style);
        }
        out += ']';
    } else {
        out += v.truth() ? "true" : "false";
    }
}

Style style_of(const ModelNode& node, const std::string& parameter)
{
    const bool points = parameter == "points" || parameter == "faces" || parameter == "paths";
    return points || node.name == "multmatrix" ? Style::Echo : Style::Plain;
}

// Bounded, lest the text of a very deep tree grow with the square of its depth.
void indent(std::string& out, std::size_t depth)
{
    out.append(std::min<std::size_t>(depth, 1000), '\t');
}

void append_head(std::string& out, const ModelNode& node, std::size_t depth)
{
    if (node.background) out += '%';
    if (node.highlight) out += '#';
    indent(out, depth);
    out += node.name + "(";
    // The lists of resize are written without spaces.
    const char* list_separator = node.name == "resize" ? "," : ", ";
    const char* separator = "";
    for (const auto& [name, value] : node.parameters) {
        out += separator;
        separator = ", ";
        if (!name.empty()) out += name + " = ";
        append(out, value, list_separator, style_of(node, name));
    }
    out += ")";
}

const ModelNode* find_root(const ModelNode& tree)
{
    std::vector<const ModelNode*> open{&tree};
    while (!open.empty()) {
        const ModelNode* node = open.back();
        open.pop_back();
        if (node->root) return node;
        for (std::size_t i = node->children.size(); i-- > 0;) open.push_back(&node->children[i]);
    }
    return nullptr;
}

}  // namespace

ModelNode::~ModelNode()
{
    if (children.empty()) return;
    std::vector<ModelNode> doomed = std::move(children);
    while (!doomed.empty()) {
        ModelNode node = std::move(doomed.back());
        doomed.pop_back();
        for (ModelNode& child : node.children) doomed.push_back(std::move(child));
        node.children.clear();
    }
}

const ModelValue& ModelNode::parameter(std::string_view parameter_name) const
{
    static const ModelValue undef;
    for (const auto& [name_of, value] : parameters)
        if (name_of == parameter_name) return value;
    return undef;
}

std::string to_csg(const ModelNode& tree)
{
    struct Open {
        const ModelNode* node;
        std::size_t next;
    };
    std::string out;
    std::vector<Open> open;
    const auto start = [&](const ModelNode& node) {
        append_head(out, node, open.size());
        if (node.children.empty()) {
            out += ";\n";
        } else {
            out += " {\n";
            open.push_back({&node, 0});
        }
    };
    const auto finish = [&] {
        while (!open.empty()) {
            Open& top = open.back();
            if (top.next < top.node->children.size()) {
                start(top.node->children[top.next++]);
                continue;
            }
            open.pop_back();
            indent(out, open.size());
            out += "}\n";
        }
    };
    if (const ModelNode* root = find_root(tree)) {
        start(*root);
        finish();
        return out + "\n";
    }
    for (const ModelNode& child : tree.children) {
        start(child);
        finish();
    }
    return out + "\n";
}

}  // namespace genus
