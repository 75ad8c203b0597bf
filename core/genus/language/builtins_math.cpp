#include <array>
#include <cmath>
#include <limits>

#include "genus/base/transform.h"
#include "genus/language/builtins.h"
#include "genus/language/builtins_files.h"
#include "genus/language/evaluate.h"
#include "genus/language/operators.h"
#include "genus/language/stack.h"

namespace genus::language {

namespace {

using Arguments = std::span<const Value>;

constexpr double kPi = 3.14159265358979323846;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void warn(Evaluator& e, const Call& call, const std::string& text)
{
    e.diagnostics().warn(call.place, text);
}

const std::string& name_of(Evaluator& e, const Call& call)
{
    return e.program().names[call.name];
}

Value wrong_count(Evaluator& e, const Call& call)
{
    warn(e, call, name_of(e, call) + "() number of parameters does not match");
    return Value();
}

Value wrong_kind(Evaluator& e, const Call& call)
{
    warn(e, call, name_of(e, call) + "() parameter could not be converted");
    return Value();
}

// Functions of one number.

template <double (*f)(double)>
Value of_number(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 1) return wrong_count(e, call);
    if (!a[0].is_number()) return wrong_kind(e, call);
    return f(a[0].as_number());
}

template <double (*f)(double, double)>
Value of_two_numbers(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 2) return wrong_count(e, call);
    if (!a[0].is_number() || !a[1].is_number()) return wrong_kind(e, call);
    return f(a[0].as_number(), a[1].as_number());
}

double absolute(double x)
{
    return std::fabs(x);
}
double sign(double x)
{
    return x < 0 ? -1.0 : x > 0 ? 1.0 : 0.0;
}
double round_half_away(double x)
{
    return std::round(x);
}
double floor_of(double x)
{
    return std::floor(x);
}
double ceil_of(double x)
{
    return std::ceil(x);
}
double square_root(double x)
{
    return std::sqrt(x);
}
double exponential(double x)
{
    return std::exp(x);
}
double natural_logarithm(double x)
{
    return std::log(x);
}
double power(double x, double y)
{
    return std::pow(x, y);
}

// Odd functions are odd in the sign of zero too.
double sine(double x)
{
    if (!std::isfinite(x)) return kNan;
    return x < 0 ? -sin_degrees(-x) : sin_degrees(x);
}
double cosine(double x)
{
    return std::isfinite(x) ? cos_degrees(x) : kNan;
}
double tangent(double x)
{
    if (!std::isfinite(x)) return kNan;
    if (x < 0) {
        const double mirrored = tangent(-x);
        return mirrored == 0.0 ? mirrored : -mirrored;
    }
    const double turn = std::fmod(x, 180.0);
    const bool odd = std::fmod(std::floor(x / 180.0), 2.0) != 0.0;
    if (turn == 0.0) return odd ? -0.0 : 0.0;
    if (turn == 30.0) return std::sqrt(3.0) / 3.0;
    if (turn == 45.0) return 1.0;
    if (turn == 60.0) return std::sqrt(3.0);
    if (turn == 90.0) return (odd ? -1.0 : 1.0) * std::numeric_limits<double>::infinity();
    if (turn == 120.0) return -std::sqrt(3.0);
    if (turn == 135.0) return -1.0;
    if (turn == 150.0) return -std::sqrt(3.0) / 3.0;
    return sin_degrees(x) / cos_degrees(x);
}

double to_degrees(double radians)
{
    return radians * (180.0 / kPi);
}

// Whole degrees where these give back x exactly, so that asin(sin(10)) is 10.
double arc_sine(double x)
{
    if (!(std::fabs(x) <= 1.0)) return kNan;
    const double angle = to_degrees(std::asin(x));
    const double whole = std::round(angle);
    return std::fabs(angle - whole) < 1e-6 && sine(whole) == x ? whole : angle;
}
double arc_cosine(double x)
{
    if (!(std::fabs(x) <= 1.0)) return kNan;
    const double angle = to_degrees(std::acos(x));
    const double whole = std::round(angle);
    return std::fabs(angle - whole) < 1e-6 && cosine(whole) == x ? whole : angle;
}

// The arc tangent is well conditioned: a whole number within its rounding error is meant.
double whole_if_close(double angle)
{
    const double whole = std::round(angle);
    return std::fabs(angle - whole) <= 1e-15 * std::fabs(angle) ? whole : angle;
}
double arc_tangent(double x)
{
    return whole_if_close(to_degrees(std::atan(x)));
}
double arc_tangent_2(double y, double x)
{
    return whole_if_close(to_degrees(std::atan2(y, x)));
}

Value logarithm(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 1 && a.size() != 2) return wrong_count(e, call);
    for (const Value& v : a)
        if (!v.is_number()) return wrong_kind(e, call);
    const double x = a.back().as_number();
    return a.size() == 1 ? std::log10(x) : std::log(x) / std::log(a[0].as_number());
}

// The smallest or largest of numbers, or of a vector of comparable values.
Value extreme(Evaluator& e, const Call& call, Arguments a, bool largest)
{
    if (a.empty()) return wrong_count(e, call);
    if (a.size() == 1 && a[0].is_list()) {
        const auto items = a[0].items();
        if (items.empty()) return wrong_kind(e, call);
        const Value* best = &items[0];
        std::string problem;
        for (const Value& v : items.subspan(1)) {
            const Value better = largest ? apply(BinaryOp::Greater, v, *best, problem)
                                         : apply(BinaryOp::Less, v, *best, problem);
            if (better.truthy()) best = &v;
        }
        return *best;
    }
    for (const Value& v : a)
        if (!v.is_number()) return wrong_kind(e, call);
    double best = a[0].as_number();
    for (const Value& v : a.subspan(1))
        best = largest ? std::max(best, v.as_number()) : std::min(best, v.as_number());
    return best;
}
Value smallest(Evaluator& e, const Call& call, Arguments a)
{
    return extreme(e, call, a, false);
}
Value largest(Evaluator& e, const Call& call, Arguments a)
{
    return extreme(e, call, a, true);
}

// Vectors.

Value norm_of(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 1) return wrong_count(e, call);
    if (!a[0].is_list()) return Value();
    double sum = 0.0;
    for (const Value& v : a[0].items()) {
        if (!v.is_number()) {
            warn(e, call, "Incorrect arguments to norm()");
            return Value();
        }
        sum += v.as_number() * v.as_number();
    }
    return std::sqrt(sum);
}

Value cross_product(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 2) {
        warn(e, call, "Invalid number of parameters for cross()");
        return Value();
    }
    if (!a[0].is_list() || !a[1].is_list()) {
        warn(e, call, "Invalid type of parameters for cross()");
        return Value();
    }
    const auto u = a[0].items(), v = a[1].items();
    if (!((u.size() == 2 && v.size() == 2) || (u.size() == 3 && v.size() == 3))) {
        warn(e, call, "Invalid vector size of parameter for cross()");
        return Value();
    }
    double x[3] = {}, y[3] = {};
    for (std::size_t i = 0; i < u.size(); ++i) {
        if (!u[i].is_number() || !v[i].is_number()) {
            warn(e, call, "Invalid value in parameter vector for cross()");
            return Value();
        }
        x[i] = u[i].as_number();
        y[i] = v[i].as_number();
        if (std::isnan(x[i]) || std::isnan(y[i]) || std::isinf(x[i]) || std::isinf(y[i])) {
            warn(e, call,
                 std::string("Invalid value (") +
                     (std::isnan(x[i]) || std::isnan(y[i]) ? "NaN" : "INF") +
                     ") in parameter vector for cross()");
            return Value();
        }
    }
    if (u.size() == 2) return x[0] * y[1] - x[1] * y[0];
    return Value::numbers(std::array{x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2],
                                     x[0] * y[1] - x[1] * y[0]});
}

Value concatenate(Evaluator&, const Call&, Arguments a)
{
    std::vector<Value> out;
    for (const Value& v : a) {
        if (v.is_list())
            out.insert(out.end(), v.items().begin(), v.items().end());
        else
            out.push_back(v);
    }
    return Value::list(std::move(out));
}

Value length(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 1) return wrong_count(e, call);
    if (a[0].is_list()) return static_cast<double>(a[0].items().size());
    if (a[0].is_string()) return static_cast<double>(a[0].string_object().characters);
    return wrong_kind(e, call);
}

// One draw in [0, 1) of 53 bits or more from two of 32, the first the lower half.
double canonical(std::mt19937& random)
{
    const double low = random(), high = random();
    const double x = (low + high * 4294967296.0) / 18446744073709551616.0;
    return x < 1.0 ? x : std::nextafter(1.0, 0.0);
}

Value random_numbers(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 3 && a.size() != 4) return wrong_count(e, call);
    for (const Value& v : a)
        if (!v.is_number()) return wrong_kind(e, call);
    double low = a[0].as_number(), high = a[1].as_number();
    if (!std::isfinite(low) || !std::isfinite(high)) return Value();
    if (low > high) std::swap(low, high);
    const double n = a[2].as_number();
    if (!std::isfinite(n) || n < 0) return Value();
    if (n > 50'000'000) throw OutOfValueMemory();
    if (a.size() == 4) {
        const double seed = a[3].as_number();
        const double whole = std::isfinite(seed) ? std::fmod(std::trunc(seed), 4294967296.0) : 0.0;
        e.random().seed(static_cast<std::uint32_t>(static_cast<std::int64_t>(whole)));
    }
    std::vector<double> out(static_cast<std::size_t>(n));
    for (double& x : out) x = low == high ? low : canonical(e.random()) * (high - low) + low;
    return Value::numbers(out);
}

Value look_up(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 2) return wrong_count(e, call);
    if (!a[0].is_number() || !std::isfinite(a[0].as_number())) {
        warn(e, call,
             "lookup(" + to_quoted_text(a[0], e.program().names) +
                 ", ...) first argument is not a number");
        return Value();
    }
    if (!a[1].is_list() || a[1].items().empty()) return Value();
    const double x = a[0].as_number();
    double low = 0, low_value = 0, high = 0, high_value = 0;
    bool any = false;
    for (const Value& row : a[1].items()) {
        if (!row.is_list() || row.items().size() < 2 || !row.items()[0].is_number() ||
            !row.items()[1].is_number()) {
            if (!any) return Value();
            continue;
        }
        const double key = row.items()[0].as_number(), value = row.items()[1].as_number();
        if (!any) {
            low = high = key;
            low_value = high_value = value;
            any = true;
            continue;
        }
        if (key <= x && (key > low || low > x)) {
            low = key;
            low_value = value;
        }
        if (key >= x && (key < high || high < x)) {
            high = key;
            high_value = value;
        }
    }
    // Beyond an end of the table, or on an entry, one of the two is not bracketed.
    if (x <= low) return high_value;
    if (x >= high) return low_value;
    const double t = (x - low) / (high - low);
    return high_value * t + low_value * (1 - t);
}

// search().

/// What is looked for in what, and how the finds are to be given.
struct Search {
    Evaluator& evaluator;
    const Call& call;
    double matches_wanted;  // 0: all
    std::size_t column;
};

// Numbers of the entries that match, up to the wanted number of them.
template <typename Matches>
std::vector<double> find_entries(const Search& s, std::size_t n, Matches&& matches)
{
    std::vector<double> found;
    for (std::size_t i = 0; i < n; ++i) {
        if (!matches(i)) continue;
        found.push_back(static_cast<double>(i));
        if (s.matches_wanted > 0 && static_cast<double>(found.size()) >= s.matches_wanted) break;
    }
    return found;
}

bool entry_matches(const Value& what, const Value& entry, std::size_t column)
{
    if (column == 0 && equal(what, entry)) return true;
    return entry.is_list() && column < entry.items().size() && equal(what, entry.items()[column]);
}

// A single find stands bare where one was asked for; else each has a list.
void add_finds(const Search& s, std::vector<Value>& out, const std::vector<double>& found)
{
    if (s.matches_wanted == 1) {
        if (!found.empty()) out.emplace_back(found[0]);
    } else {
        out.push_back(Value::numbers(found));
    }
}

Value search_in_string(const Search& s, std::string_view what, std::string_view table)
{
    std::vector<std::string_view> characters;
    for_each_character(table, [&](std::string_view c) { characters.push_back(c); });
    std::vector<Value> out;
    for_each_character(what, [&](std::string_view c) {
        add_finds(s, out, find_entries(s, characters.size(), [&](std::size_t i) {
                      return characters[i] == c;
                  }));
    });
    return Value::list(std::move(out));
}

Value search_string_in_list(const Search& s, std::string_view what, Arguments table)
{
    for (std::size_t i = 0; i < table.size(); ++i)
        if (!table[i].is_list() || s.column >= table[i].items().size()) {
            warn(s.evaluator, s.call,
                 "Invalid entry in search vector at index " + std::to_string(i) +
                     ", required number of values in the entry: " + std::to_string(s.column + 1) +
                     ". Invalid entry: " + to_quoted_text(table[i], s.evaluator.program().names));
            return Value::list(std::vector<Value>());
        }
    std::vector<Value> out;
    for_each_character(what, [&](std::string_view c) {
        const auto found = find_entries(s, table.size(), [&](std::size_t i) {
            if (!table[i].is_list() || s.column >= table[i].items().size()) return false;
            const Value& cell = table[i].items()[s.column];
            return cell.is_string() && !cell.as_string().empty() &&
                   cell.as_string().substr(0, character_bytes(cell.as_string(), 0)) == c;
        });
        if (found.empty())
            warn(s.evaluator, s.call, "search term not found: \"" + std::string(c) + "\"");
        add_finds(s, out, found);
    });
    return Value::list(std::move(out));
}

Value search_list(const Search& s, Arguments what, Arguments table)
{
    std::vector<Value> out;
    for (const Value& w : what) {
        const auto found = find_entries(
            s, table.size(), [&](std::size_t i) { return entry_matches(w, table[i], s.column); });
        if (s.matches_wanted == 1 && found.empty())
            out.push_back(Value::list(std::vector<Value>()));
        else
            add_finds(s, out, found);
    }
    return Value::list(std::move(out));
}

Value search(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() < 2) return wrong_count(e, call);
    Search s{e, call, 1.0, 0};
    if (a.size() > 2 && a[2].is_number()) s.matches_wanted = std::max(0.0, a[2].as_number());
    if (a.size() > 3 && a[3].is_number() && a[3].as_number() > 0)
        s.column = static_cast<std::size_t>(std::min(a[3].as_number(), 1e9));
    const Value &what = a[0], &table = a[1];
    if (what.is_number()) {
        if (!table.is_list()) return Value::list(std::vector<Value>());
        const auto items = table.items();
        return Value::numbers(find_entries(s, items.size(), [&](std::size_t i) {
            return entry_matches(what, items[i], s.column);
        }));
    }
    if (what.is_string() && table.is_string())
        return search_in_string(s, what.as_string(), table.as_string());
    if (what.is_string() && table.is_list())
        return search_string_in_list(s, what.as_string(), table.items());
    if (what.is_list() && table.is_list()) return search_list(s, what.items(), table.items());
    return Value();
}

// Text.

Value text_of(Evaluator& e, const Call&, Arguments a)
{
    std::string out;
    for (const Value& v : a) out += to_text(v, e.program().names);
    return Value::string(out);
}

void append_characters(std::string& out, const Value& v)
{
    check_stack();
    if (v.is_number()) {
        if (v.as_number() > 0 && v.as_number() < 2e9)
            out += encode_character(static_cast<std::uint32_t>(v.as_number()));
    } else if (v.is_list()) {
        for (const Value& item : v.items()) append_characters(out, item);
    } else if (v.is_range()) {
        const RangeObject& r = v.as_range();
        const std::uint32_t n = range_size(r);
        if (n >= 1'000'000) return;
        for (std::uint32_t i = 0; i < n; ++i) append_characters(out, range_value(r, i));
    }
}

Value characters(Evaluator&, const Call&, Arguments a)
{
    std::string out;
    for (const Value& v : a) append_characters(out, v);
    return Value::string(out);
}

Value ordinal(Evaluator& e, const Call& call, Arguments a)
{
    if (a.empty()) return Value();
    if (a.size() > 1) {
        warn(e, call,
             "ord() called with " + std::to_string(a.size()) +
                 " arguments, only 1 argument expected");
        return Value();
    }
    if (!a[0].is_string()) {
        warn(
            e, call,
            "ord() argument " + to_quoted_text(a[0], e.program().names) + " is not of type string");
        return Value();
    }
    const std::string_view text = a[0].as_string();
    if (text.empty()) return Value();
    return static_cast<double>(decode_character(text.substr(0, character_bytes(text, 0))));
}

// Kinds.

template <bool (*test)(const Value&)>
Value is_kind(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() != 1) return wrong_count(e, call);
    return test(a[0]);
}
bool undef_test(const Value& v)
{
    return v.is_undef();
}
bool list_test(const Value& v)
{
    return v.is_list();
}
bool number_test(const Value& v)
{
    return v.is_number() && !std::isnan(v.as_number());
}
bool bool_test(const Value& v)
{
    return v.is_bool();
}
bool string_test(const Value& v)
{
    return v.is_string();
}
bool function_test(const Value& v)
{
    return v.is_function();
}

Value version(Evaluator&, const Call&, Arguments)
{
    return Value::numbers(std::array{2021.0, 1.0, 0.0});
}

Value version_number(Evaluator& e, const Call& call, Arguments a)
{
    if (a.empty()) return 20210100.0;
    if (a.size() != 1) return wrong_count(e, call);
    if (!a[0].is_list()) return Value();
    double parts[3] = {};
    const auto items = a[0].items();
    if (items.size() != 2 && items.size() != 3) return Value();
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (!items[i].is_number()) return Value();
        parts[i] = items[i].as_number();
    }
    return parts[0] * 10000 + parts[1] * 100 + parts[2];
}

Value parent_module(Evaluator& e, const Call& call, Arguments a)
{
    if (a.size() > 1) return wrong_count(e, call);
    double n = 1.0;
    if (a.size() == 1) {
        if (!a[0].is_number()) return wrong_kind(e, call);
        n = std::trunc(a[0].as_number());
    }
    const auto& modules = e.module_stack();
    if (!(n >= 0)) {
        warn(e, call, "Negative parent module index (" + number_text(n) + ") not allowed");
        return Value();
    }
    if (!(n < static_cast<double>(modules.size()))) {
        warn(e, call,
             "Parent module index (" + number_text(n) +
                 ") greater than the number of modules on the stack");
        return Value();
    }
    const Names::Id name = modules[modules.size() - 1 - static_cast<std::size_t>(n)];
    return Value::string(e.program().names[name]);
}

struct Entry {
    std::string_view name;
    BuiltinFunction function;
};

constexpr Entry kFunctions[] = {
    {"is_undef", is_kind<undef_test>},
    {"abs", of_number<absolute>},
    {"sign", of_number<sign>},
    {"round", of_number<round_half_away>},
    {"floor", of_number<floor_of>},
    {"ceil", of_number<ceil_of>},
    {"sqrt", of_number<square_root>},
    {"exp", of_number<exponential>},
    {"ln", of_number<natural_logarithm>},
    {"log", logarithm},
    {"pow", of_two_numbers<power>},
    {"sin", of_number<sine>},
    {"cos", of_number<cosine>},
    {"tan", of_number<tangent>},
    {"asin", of_number<arc_sine>},
    {"acos", of_number<arc_cosine>},
    {"atan", of_number<arc_tangent>},
    {"atan2", of_two_numbers<arc_tangent_2>},
    {"min", smallest},
    {"max", largest},
    {"norm", norm_of},
    {"cross", cross_product},
    {"concat", concatenate},
    {"len", length},
    {"rands", random_numbers},
    {"lookup", look_up},
    {"search", search},
    {"str", text_of},
    {"chr", characters},
    {"ord", ordinal},
    {"is_list", is_kind<list_test>},
    {"is_num", is_kind<number_test>},
    {"is_bool", is_kind<bool_test>},
    {"is_string", is_kind<string_test>},
    {"is_function", is_kind<function_test>},
    {"version", version},
    {"version_num", version_number},
    {"parent_module", parent_module},
    {"dxf_dim", dxf_dim},
    {"dxf_cross", dxf_cross},
};

}  // namespace

std::optional<std::uint32_t> find_builtin_function(std::string_view name)
{
    static const auto numbers = [] {
        std::unordered_map<std::string_view, std::uint32_t> map;
        for (const Entry& entry : kFunctions)
            map.emplace(entry.name, static_cast<std::uint32_t>(map.size()));
        return map;
    }();
    const auto at = numbers.find(name);
    return at == numbers.end() ? std::nullopt : std::optional(at->second);
}

BuiltinFunction builtin_function(std::uint32_t number)
{
    return kFunctions[number].function;
}

std::uint32_t is_undef_number()
{
    return 0;
}

}  // namespace genus::language
