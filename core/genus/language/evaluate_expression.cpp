#include <cmath>
#include <limits>

#include "genus/base/progress.h"
#include "genus/language/evaluate.h"
#include "genus/language/operators.h"
#include "genus/language/stack.h"

namespace genus::language {

namespace {

constexpr std::size_t kMaxTailCalls = 1'000'000;
constexpr std::size_t kMaxLoopTurns = 1'000'000;
constexpr std::uint32_t kMaxForElements = 1'000'000;

// An index as the language takes it: cut to a whole number; negative and endless ones are none.
std::optional<std::uint32_t> whole_index(double n)
{
    if (!(n > -1.0) || !(n < 4294967295.0)) return std::nullopt;
    return static_cast<std::uint32_t>(n);
}

double range_part(const RangeObject& r, std::uint32_t i)
{
    return i == 0 ? r.begin : i == 1 ? r.step : r.end;
}

}  // namespace

const Value* Evaluator::slot_of(const Variable& v, Frame* f) const
{
    for (const Variable* at = &v; at && at->found; at = at->otherwise) {
        Frame* frame = f;
        for (std::uint32_t n = at->slot.steps; n > 0; --n) frame = frame->parent;
        const Value& value = frame->slots()[at->slot.index];
        if (!value.is_unset()) return &value;
    }
    return nullptr;
}

Value Evaluator::unset_variable(const Variable& v, Frame*)
{
    diagnostics_.warn(v.place, "Ignoring unknown variable '" + program_.names[v.name] + "'");
    return Value();
}

const Value& Evaluator::read_special(std::uint32_t number)
{
    const Value& v = specials_[number];
    if (reads_) {
        bool own = false;
        for (std::size_t i = reads_mark_; i < undo_.size(); ++i) own |= undo_[i].first == number;
        if (!own) reads_->emplace_back(number, v);
    }
    return v;
}

Value Evaluator::special_value(const Special& s)
{
    const Value& v = read_special(s.special);
    if (!v.is_unset()) return v;
    diagnostics_.warn(s.place, "Ignoring unknown variable '" + program_.names[s.name] + "'");
    return Value();
}

const Value& Evaluator::ref(const Expr* e, Frame* f, Value& store)
{
    if (e->kind == ExprKind::Variable) {
        if (const Value* v = slot_of(*static_cast<const Variable*>(e), f)) return *v;
    } else if (e->kind == ExprKind::Literal) {
        return static_cast<const Literal*>(e)->value;
    }
    store = eval(e, f);
    return store;
}

Value Evaluator::eval(const Expr* e, Frame* f)
{
    switch (e->kind) {
        case ExprKind::Literal:
            return static_cast<const Literal*>(e)->value;
        case ExprKind::Variable: {
            const auto& v = *static_cast<const Variable*>(e);
            const Value* value = slot_of(v, f);
            return value ? *value : unset_variable(v, f);
        }
        case ExprKind::Special:
            return special_value(*static_cast<const Special*>(e));
        default:
            break;
    }
    check_stack();
    switch (e->kind) {
        case ExprKind::Unary:
            return unary(*static_cast<const Unary*>(e), f);
        case ExprKind::Binary:
            return binary(*static_cast<const Binary*>(e), f);
        case ExprKind::And: {
            const auto* b = static_cast<const Binary*>(e);
            Value store;
            if (!ref(b->a, f, store).truthy()) return false;
            return ref(b->b, f, store).truthy();
        }
        case ExprKind::Or: {
            const auto* b = static_cast<const Binary*>(e);
            Value store;
            if (ref(b->a, f, store).truthy()) return true;
            return ref(b->b, f, store).truthy();
        }
        case ExprKind::Ternary: {
            const auto* t = static_cast<const Ternary*>(e);
            Value store;
            return eval(ref(t->condition, f, store).truthy() ? t->yes : t->no, f);
        }
        case ExprKind::Range:
            return range(*static_cast<const RangeExpr*>(e), f);
        case ExprKind::List:
            return list(*static_cast<const List*>(e), f);
        case ExprKind::Index:
            return index(*static_cast<const Index*>(e), f);
        case ExprKind::Member:
            return member(*static_cast<const Member*>(e), f);
        case ExprKind::Call: {
            Activation activation;
            if (!prepare(*static_cast<const Call*>(e), f, activation))
                return std::move(activation.value);
            return run_function(activation.definition, std::move(activation.frame));
        }
        case ExprKind::FunctionLiteral:
            capture(f);
            ++f->references;
            return Value::function(&static_cast<const FunctionLiteral*>(e)->definition, f);
        case ExprKind::Let:
            return let(*static_cast<const Let*>(e), f);
        case ExprKind::Assert:
        case ExprKind::Echo:
            return body_of(*static_cast<const AssertExpr*>(e), f);
        default: {
            // A comprehension outside of a list, by way of brackets: a list of its own.
            const std::size_t base = stack_.size();
            collect(e, f);
            return take_list(base);
        }
    }
}

Value Evaluator::unary(const Unary& u, Frame* f)
{
    Value store;
    const Value& a = ref(u.a, f, store);
    switch (u.op) {
        case UnaryOp::Not:
            return !a.truthy();
        case UnaryOp::Plus:
            return a;
        case UnaryOp::Minus:
            break;
    }
    if (a.is_number()) return -a.as_number();
    std::string problem;
    Value v = negate(a, problem);
    if (!problem.empty()) diagnostics_.warn(u.place, problem);
    return v;
}

Value Evaluator::binary(const Binary& b, Frame* f)
{
    Value store_x, store_y;
    const Value& x = ref(b.a, f, store_x);
    const Value& y = ref(b.b, f, store_y);
    if (x.is_number() && y.is_number()) {
        const double m = x.as_number(), n = y.as_number();
        switch (b.op) {
            case BinaryOp::Add:
                return m + n;
            case BinaryOp::Subtract:
                return m - n;
            case BinaryOp::Multiply:
                return m * n;
            case BinaryOp::Divide:
                return m / n;
            case BinaryOp::Less:
                return m < n;
            case BinaryOp::LessEqual:
                return m <= n;
            case BinaryOp::Greater:
                return m > n;
            case BinaryOp::GreaterEqual:
                return m >= n;
            case BinaryOp::Equal:
                return m == n;
            case BinaryOp::NotEqual:
                return m != n;
            default:
                break;
        }
    }
    std::string problem;
    Value v = apply(b.op, x, y, problem);
    if (!problem.empty()) diagnostics_.warn(b.place, problem);
    return v;
}

Value Evaluator::range(const RangeExpr& r, Frame* f)
{
    const Value begin = eval(r.begin, f);
    const Value step = r.step ? eval(r.step, f) : Value(1.0);
    const Value end = eval(r.end, f);
    if (!begin.is_number() || !step.is_number() || !end.is_number()) return Value();
    double b = begin.as_number(), e = end.as_number();
    if (!r.step && b > e) {
        diagnostics_.deprecated(r.place,
                                "Using ranges of the form [begin:end] with begin value greater "
                                "than the end value is deprecated");
        std::swap(b, e);
    }
    const double s = step.as_number();
    const bool finite = std::isfinite(b) && std::isfinite(s) && std::isfinite(e);
    if (finite && s > 0 && b > e)
        diagnostics_.warn(r.place, "begin is greater than the end, but step is positive");
    if (finite && s < 0 && b < e)
        diagnostics_.warn(r.place, "begin is smaller than the end, but step is negative");
    return Value::range(b, s, e);
}

void Evaluator::push(Value v)
{
    if (stack_.size() == stack_.capacity()) {
        // What the doubled stack takes must fit beside the values there are.
        const std::size_t bytes = 2 * stack_.capacity() * sizeof(Value);
        charge_value_memory(bytes);
        release_value_memory(bytes);
        current_progress().check();
    }
    stack_.push_back(std::move(v));
}

Value Evaluator::take_list(std::size_t base)
{
    Value v = Value::list(std::span<const Value>(stack_).subspan(base));
    stack_.resize(base);
    return v;
}

Value Evaluator::list(const List& l, Frame* f)
{
    const std::size_t base = stack_.size();
    if (l.plain)
        for (const Expr* item : l.items) push(eval(item, f));
    else
        for (const Expr* item : l.items) collect(item, f);
    return take_list(base);
}

Value Evaluator::index(const Index& i, Frame* f)
{
    Value store_of, store_at;
    const Value& of = ref(i.of, f, store_of);
    const Value& at = ref(i.at, f, store_at);
    if (!at.is_number()) return Value();
    const auto n = whole_index(at.as_number());
    if (!n) return Value();
    if (of.is_list()) {
        const auto items = of.items();
        return *n < items.size() ? items[*n] : Value();
    }
    if (of.is_string()) {
        const StringObject& s = of.string_object();
        if (*n >= s.characters) return Value();
        if (s.bytes == s.characters) return Value::string(s.view().substr(*n, 1));
        std::size_t byte = 0;
        for (std::uint32_t k = 0; k < *n; ++k) byte += character_bytes(s.view(), byte);
        return Value::string(s.view().substr(byte, character_bytes(s.view(), byte)));
    }
    if (of.is_range() && *n < 3) return range_part(of.as_range(), *n);
    return Value();
}

Value Evaluator::member(const Member& m, Frame* f)
{
    Value store;
    const Value& of = ref(m.of, f, store);
    const std::string& name = program_.names[m.name];
    if (of.is_list() && name.size() == 1 && name[0] >= 'x' && name[0] <= 'z') {
        const auto items = of.items();
        const auto n = static_cast<std::size_t>(name[0] - 'x');
        return n < items.size() ? items[n] : Value();
    }
    if (of.is_range()) {
        if (name == "begin") return of.as_range().begin;
        if (name == "step") return of.as_range().step;
        if (name == "end") return of.as_range().end;
    }
    return Value();
}

// Let.

void Evaluator::bind_pair(const BindingPair& pair, Value v, Frame* f)
{
    if (pair.special >= 0)
        set_special(static_cast<std::uint32_t>(pair.special), std::move(v));
    else
        f->slots()[pair.slot] = std::move(v);
}

void Evaluator::bind_pairs(const std::vector<BindingPair>& pairs, std::size_t n, Frame* f)
{
    for (std::size_t i = 0; i < n; ++i) {
        const BindingPair& pair = pairs[i];
        Value v = eval(pair.value, f);
        if (pair.name == Argument::kNoName) {
            diagnostics_.warn(pair.place,
                              "Assignment without variable name " + to_text(v, program_.names));
        } else if (pair.duplicate) {
            diagnostics_.warn(pair.place, "Ignoring duplicate variable assignment " +
                                              program_.names[pair.name] + " = " +
                                              to_text(v, program_.names));
        } else {
            bind_pair(pair, std::move(v), f);
        }
    }
}

FrameHold Evaluator::enter(const Bindings& b, Frame* f)
{
    if (b.own_frame) return FrameHold(make_frame(b.n_slots, f));
    return FrameHold();
}

Value Evaluator::let(const Let& l, Frame* f)
{
    const std::size_t mark = undo_.size();
    const FrameHold own = enter(l.bindings, f);
    if (own) f = own.get();
    bind_pairs(l.bindings.pairs, l.bindings.pairs.size(), f);
    Value v = eval(l.body, f);
    restore_specials(mark);
    return v;
}

Value Evaluator::body_of(const AssertExpr& a, Frame* f)
{
    if (a.kind == ExprKind::Assert)
        assertion(a.arguments, a.place, f);
    else
        echo(a.arguments, a.place, f);
    return a.body ? eval(a.body, f) : Value();
}

void Evaluator::assertion(const std::vector<Argument>& arguments, const Place& place, Frame* f)
{
    const Argument* condition = nullptr;
    const Argument* message = nullptr;
    for (const Argument& a : arguments) {
        const bool named = a.name != Argument::kNoName;
        if (named ? program_.names[a.name] == "condition" : !condition)
            condition = &a;
        else if (named ? program_.names[a.name] == "message" : !message)
            message = &a;
    }
    if (condition && eval(condition->value, f).truthy()) return;
    std::string text = "Assertion '";
    if (condition) text += to_text(*condition->value, program_.names);
    text += "' failed";
    if (message) text += ": " + to_quoted_text(eval(message->value, f), program_.names);
    fail(place, text);
}

void Evaluator::echo(const std::vector<Argument>& arguments, const Place& place, Frame* f)
{
    std::string text;
    for (const Argument& a : arguments) {
        if (!text.empty()) text += ", ";
        if (a.name != Argument::kNoName) text += program_.names[a.name] + " = ";
        text += to_quoted_text(eval(a.value, f), program_.names);
    }
    diagnostics_.echo(place, text);
}

// Items of lists.

void Evaluator::collect(const Expr* item, Frame* f)
{
    check_stack();
    switch (item->kind) {
        case ExprKind::For: {
            const auto* loop = static_cast<const For*>(item);
            const std::size_t mark = undo_.size();
            collect_for(*loop, 0, f);
            restore_specials(mark);
            return;
        }
        case ExprKind::CFor:
            collect_c_for(*static_cast<const CFor*>(item), f);
            return;
        case ExprKind::If: {
            const auto* i = static_cast<const If*>(item);
            Value store;
            const bool yes = ref(i->condition, f, store).truthy();
            if (yes)
                collect(i->yes, f);
            else if (i->no)
                collect(i->no, f);
            return;
        }
        case ExprKind::Each: {
            const auto* each = static_cast<const Each*>(item);
            const std::size_t base = stack_.size();
            collect(each->of, f);
            const Value all = take_list(base);
            for (const Value& v : all.items()) collect_all(v, each->place);
            return;
        }
        case ExprKind::ListLet: {
            const auto* l = static_cast<const Let*>(item);
            const std::size_t mark = undo_.size();
            const FrameHold own = enter(l->bindings, f);
            Frame* inside = own ? own.get() : f;
            bind_pairs(l->bindings.pairs, l->bindings.pairs.size(), inside);
            collect(l->body, inside);
            restore_specials(mark);
            return;
        }
        default:
            push(eval(item, f));
    }
}

void Evaluator::collect_all(const Value& v, const Place& place)
{
    if (v.is_list()) {
        for (const Value& item : v.items()) push(item);
    } else if (v.is_range()) {
        const RangeObject& r = v.as_range();
        const std::uint32_t n = range_size(r);
        if (n >= kMaxForElements) {
            diagnostics_.warn(place, "Bad range parameter in for statement: too many elements (" +
                                         std::to_string(n) + ")");
            return;
        }
        for (std::uint32_t i = 0; i < n; ++i) push(Value(range_value(r, i)));
    } else if (v.is_string()) {
        for_each_character(v.as_string(), [&](std::string_view c) { push(Value::string(c)); });
    } else if (!v.is_undef()) {
        push(v);
    }
}

void Evaluator::collect_for(const For& loop, std::size_t number, Frame* f)
{
    const auto& pairs = loop.bindings.pairs;
    if (number == pairs.size()) {
        if (number > 0) collect(loop.body, f);
        return;
    }
    const BindingPair& pair = pairs[number];
    const bool last = number + 1 == pairs.size();
    // Where functions can hold on to the variable, each turn has a frame of its own.
    const bool fresh = loop.bindings.own_frame;
    const Value over = [&] {
        if (!fresh || number > 0) return eval(pair.value, f);
        const FrameHold unset(make_frame(loop.bindings.n_slots, f));
        return eval(pair.value, unset.get());
    }();
    const auto turn = [&](Value v) {
        if ((++steps_ & 0xfff) == 0) current_progress().check();
        FrameHold own;
        Frame* inside = f;
        if (fresh) {
            own = FrameHold(make_frame(loop.bindings.n_slots, number == 0 ? f : f->parent));
            inside = own.get();
            if (number > 0)
                for (std::uint32_t i = 0; i < loop.bindings.n_slots; ++i)
                    inside->slots()[i] = f->slots()[i];
        }
        if (pair.name != Argument::kNoName) bind_pair(pair, std::move(v), inside);
        if (last)
            collect(loop.body, inside);
        else
            collect_for(loop, number + 1, inside);
    };
    if (over.is_list()) {
        for (const Value& v : over.items()) turn(v);
    } else if (over.is_range()) {
        const RangeObject& r = over.as_range();
        const std::uint32_t n = range_size(r);
        if (n >= kMaxForElements) {
            diagnostics_.warn(loop.place,
                              "Bad range parameter in for statement: too many elements (" +
                                  std::to_string(n) + ")");
            return;
        }
        for (std::uint32_t i = 0; i < n; ++i) turn(range_value(r, i));
    } else if (over.is_string()) {
        for_each_character(over.as_string(), [&](std::string_view c) { turn(Value::string(c)); });
    } else if (!over.is_undef()) {
        turn(over);
    }
}

void Evaluator::collect_c_for(const CFor& loop, Frame* outside)
{
    const std::size_t mark = undo_.size();
    FrameHold own = enter(loop.bindings, outside);
    Frame* f = own ? own.get() : outside;
    const auto& pairs = loop.bindings.pairs;
    for (std::size_t i = loop.n_start; i < pairs.size(); ++i)
        if (pairs[i].special < 0 && pairs[i].name != Argument::kNoName)
            f->slots()[pairs[i].slot] = Value::unset();
    bind_pairs(pairs, loop.n_start, f);
    std::size_t turns = 0;
    for (;;) {
        Value store;
        if (!ref(loop.condition, f, store).truthy()) break;
        if ((++steps_ & 0xfff) == 0) current_progress().check();
        collect(loop.body, f);
        if (turns++ == kMaxLoopTurns)
            fail(loop.place, "for loop counter exceeded " + std::to_string(kMaxLoopTurns));
        if (own && own->references > 1) {
            // A function holds the frame of this turn: the next one gets a copy.
            FrameHold next(make_frame(loop.bindings.n_slots, outside));
            for (std::uint32_t i = 0; i < loop.bindings.n_slots; ++i)
                next->slots()[i] = own->slots()[i];
            own = std::move(next);
            f = own.get();
        }
        bind_pairs(loop.updates, loop.updates.size(), f);
    }
    restore_specials(mark);
}

// Calls.

bool Evaluator::prepare(const Call& call, Frame* f, Activation& out)
{
    using TargetKind = Target<FunctionDefinition>::Kind;
    if ((++steps_ & 0xfff) == 0) current_progress().check();
    call_place_ = &call.place;
    call_name_ = call.name;
    const FunctionDefinition* definition = nullptr;
    Frame* outside = nullptr;
    Value callee;
    if (call.callee->kind == ExprKind::Variable) {
        if (call.variable_found) {
            const Value* v = slot_of(*static_cast<const Variable*>(call.callee), f);
            if (v && v->is_function()) callee = *v;
        }
    } else if (call.callee->kind == ExprKind::Special) {
        callee = read_special(static_cast<const Special*>(call.callee)->special);
    } else {
        callee = eval(call.callee, f);
    }
    if (callee.is_function()) {
        definition = callee.as_function().definition;
        outside = callee.as_function().frame;
    } else if (call.callee->kind != ExprKind::Variable) {
        diagnostics_.warn(call.place, std::string("Can't call function on ") + callee.type_name());
        return false;
    } else {
        switch (call.target.kind) {
            case TargetKind::Unknown:
                diagnostics_.warn(call.place,
                                  "Ignoring unknown function '" + program_.names[call.name] + "'");
                return false;
            case TargetKind::Builtin:
                out.value = builtin(call, f);
                return false;
            case TargetKind::User:
                outside = f;
                for (std::uint32_t n = call.target.steps; n > 0; --n) outside = outside->parent;
                break;
            case TargetKind::Used:
                outside = used_frame(call.target.index);
                break;
        }
        definition = call.target.definition;
    }
    out.definition = definition;
    out.frame = FrameHold(make_frame(definition->n_slots, outside));
    if (bind_positions(*definition, call.arguments, f, outside, out.frame.get())) return true;
    // Where the callee is a value, another definition may be called from here while the arguments
    // are evaluated, so what is known of this one is not kept.
    Binding once;
    Binding& binding = callee.is_function() ? once : call.binding;
    bind_arguments(definition->parameters, definition, call.arguments, binding, call.place, f,
                   outside, out.frame.get());
    return true;
}

void Evaluator::find_binding(const std::vector<Parameter>& parameters, const void* definition,
                             const std::vector<Argument>& arguments, Binding& binding) const
{
    using BoundTo = Binding::Target::Kind;
    binding = Binding{};
    binding.definition = definition;
    std::vector<std::int64_t> source(parameters.size(), -1);  // argument of each parameter
    std::size_t position = 0;
    bool too_many = false;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const Argument& a = arguments[i];
        binding.targets.push_back({BoundTo::Dropped, 0});
        std::size_t p = parameters.size();
        if (a.name == Argument::kNoName) {
            if (position < parameters.size())
                p = position++;
            else if (!std::exchange(too_many, true))
                binding.warnings.push_back("Too many unnamed arguments supplied");
        } else {
            for (p = 0; p < parameters.size() && parameters[p].name != a.name;) ++p;
            if (p == parameters.size()) {
                if (a.special >= 0)
                    binding.targets[i] = {BoundTo::Special, static_cast<std::uint32_t>(a.special)};
                else
                    binding.warnings.push_back("variable " + program_.names[a.name] +
                                               " not specified as parameter");
            } else if (source[p] >= 0) {
                binding.warnings.push_back("argument " + program_.names[a.name] +
                                           " supplied more than once");
            }
        }
        if (p == parameters.size()) continue;
        if (source[p] >= 0) binding.targets[source[p]].kind = BoundTo::Dropped;
        source[p] = static_cast<std::int64_t>(i);
        binding.targets[i] = {BoundTo::Parameter, static_cast<std::uint32_t>(p)};
    }
    for (std::size_t p = 0; p < parameters.size(); ++p)
        if (source[p] < 0) binding.missing.push_back(static_cast<std::uint32_t>(p));
}

// The usual case, in which no name needs looking at.
bool Evaluator::bind_positions(const FunctionDefinition& definition,
                               const std::vector<Argument>& arguments, Frame* caller,
                               Frame* outside, Frame* inside)
{
    const auto& parameters = definition.parameters;
    if (definition.has_specials || arguments.size() > parameters.size()) return false;
    for (const Argument& a : arguments)
        if (a.name != Argument::kNoName) return false;
    for (std::size_t i = 0; i < arguments.size(); ++i)
        inside->slots()[parameters[i].slot] = eval(arguments[i].value, caller);
    for (std::size_t i = arguments.size(); i < parameters.size(); ++i)
        inside->slots()[parameters[i].slot] = default_value(parameters[i], outside);
    return true;
}

Value Evaluator::default_value(const Parameter& p, Frame* outside)
{
    if (!p.value) return Value();
    if (!p.own_frame) return eval(p.value, outside);
    const FrameHold own(make_frame(p.n_slots, outside));
    return eval(p.value, own.get());
}

void Evaluator::bind_arguments(const std::vector<Parameter>& parameters, const void* definition,
                               const std::vector<Argument>& arguments, Binding& binding,
                               const Place& place, Frame* caller, Frame* outside, Frame* inside)
{
    using BoundTo = Binding::Target::Kind;
    if (binding.definition != definition) find_binding(parameters, definition, arguments, binding);
    for (const std::string& warning : binding.warnings) diagnostics_.warn(place, warning);
    // Special variables change only once all arguments are evaluated: these still see the old.
    std::vector<std::pair<std::uint32_t, Value>> specials;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const Binding::Target to = binding.targets[i];
        if (to.kind == BoundTo::Dropped) continue;
        Value v = eval(arguments[i].value, caller);
        if (to.kind == BoundTo::Special)
            specials.emplace_back(to.index, std::move(v));
        else if (parameters[to.index].special >= 0)
            specials.emplace_back(parameters[to.index].special, std::move(v));
        else
            inside->slots()[parameters[to.index].slot] = std::move(v);
    }
    for (const std::uint32_t p : binding.missing) {
        Value v = default_value(parameters[p], outside);
        if (parameters[p].special >= 0)
            specials.emplace_back(parameters[p].special, std::move(v));
        else
            inside->slots()[parameters[p].slot] = std::move(v);
    }
    for (auto& [number, v] : specials) set_special(number, std::move(v));
}

Value Evaluator::run_function(const FunctionDefinition* definition, FrameHold frame)
{
    check_stack();
    const std::size_t mark = undo_.size();
    std::size_t tail_calls = 0;
    const Expr* e = definition->body;
    Frame* f = frame.get();
    Value result;
    while (e) {
        switch (e->kind) {
            case ExprKind::Ternary: {
                const auto* t = static_cast<const Ternary*>(e);
                Value store;
                e = ref(t->condition, f, store).truthy() ? t->yes : t->no;
                continue;
            }
            case ExprKind::Let: {
                const auto* l = static_cast<const Let*>(e);
                if (FrameHold own = enter(l->bindings, f)) {
                    frame = std::move(own);
                    f = frame.get();
                }
                bind_pairs(l->bindings.pairs, l->bindings.pairs.size(), f);
                e = l->body;
                continue;
            }
            case ExprKind::Assert:
            case ExprKind::Echo: {
                const auto* a = static_cast<const AssertExpr*>(e);
                if (a->kind == ExprKind::Assert)
                    assertion(a->arguments, a->place, f);
                else
                    echo(a->arguments, a->place, f);
                e = a->body;
                continue;
            }
            case ExprKind::Call: {
                const auto* call = static_cast<const Call*>(e);
                Activation next;
                if (!prepare(*call, f, next)) {
                    result = std::move(next.value);
                    e = nullptr;
                    continue;
                }
                if (++tail_calls > kMaxTailCalls)
                    fail(call->place,
                         "recursion: more than " + std::to_string(kMaxTailCalls) +
                             " calls without an end" +
                             (call->name == Argument::kNoName
                                  ? ""
                                  : " in function '" + program_.names[call->name] + "'"));
                frame = std::move(next.frame);
                f = frame.get();
                e = next.definition->body;
                continue;
            }
            default:
                result = eval(e, f);
                e = nullptr;
        }
    }
    restore_specials(mark);
    return result;
}

Value Evaluator::builtin(const Call& call, Frame* f)
{
    const std::size_t n = call.arguments.size();
    // `is_undef(x)` asks for a variable that may be unknown, without a warning.
    if (n == 1 && call.target.index == is_undef_number()) {
        const Expr* a = call.arguments[0].value;
        if (a->kind == ExprKind::Variable) {
            const Value* v = slot_of(*static_cast<const Variable*>(a), f);
            return !v || v->is_undef();
        }
        if (a->kind == ExprKind::Special) {
            const Value& v = read_special(static_cast<const Special*>(a)->special);
            if (v.is_unset()) return true;
        }
    }
    const std::size_t base = stack_.size();
    for (const Argument& a : call.arguments) push(eval(a.value, f));
    // A function may itself build lists, so the arguments leave the stack while it runs.
    constexpr std::size_t kFew = 4;
    const BuiltinFunction function = builtin_function(call.target.index);
    if (n <= kFew) {
        Value few[kFew];
        for (std::size_t i = 0; i < n; ++i) few[i] = std::move(stack_[base + i]);
        stack_.resize(base);
        return function(*this, call, {few, n});
    }
    std::vector<Value> many(
        std::make_move_iterator(stack_.begin() + static_cast<std::ptrdiff_t>(base)),
        std::make_move_iterator(stack_.end()));
    stack_.resize(base);
    return function(*this, call, many);
}

// Special variables.

void Evaluator::set_special(std::uint32_t number, Value v)
{
    undo_.emplace_back(number, std::move(specials_[number]));
    specials_[number] = std::move(v);
}

void Evaluator::restore_specials(std::size_t mark)
{
    while (undo_.size() > mark) {
        specials_[undo_.back().first] = std::move(undo_.back().second);
        undo_.pop_back();
    }
}

// Used files.

bool Evaluator::still_valid(const UsedFile& file) const
{
    for (const auto& [number, v] : file.reads)
        if (!equal(specials_[number], v)) return false;
    return true;
}

Frame* Evaluator::used_frame(std::size_t number)
{
    UsedFile& file = *used_[number];
    if (!file.frame || (file.ready && !still_valid(file))) start_used_file(number, file);
    for (const auto& [special, v] : file.specials) set_special(special, v);
    return file.frame.get();
}

void Evaluator::start_used_file(std::size_t number, UsedFile& file)
{
    const Block& block = program_.files[number]->scope.block;
    file.reads.clear();
    file.specials.clear();
    file.ready = false;
    file.frame = FrameHold(make_frame(block.n_slots, nullptr));
    const std::size_t mark = undo_.size();
    std::vector<std::pair<std::uint32_t, Value>> reads;
    const auto outer_reads = std::exchange(reads_, &reads);
    const std::size_t outer_mark = std::exchange(reads_mark_, mark);
    assignments(block, file.frame.get());
    reads_ = outer_reads;
    reads_mark_ = outer_mark;
    for (const Assignment& a : block.assignments)
        if (a.special >= 0) file.specials.emplace_back(a.special, specials_[a.special]);
    restore_specials(mark);
    if (outer_reads) outer_reads->insert(outer_reads->end(), reads.begin(), reads.end());
    file.reads = std::move(reads);
    file.ready = true;
}

}  // namespace genus::language
