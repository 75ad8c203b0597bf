#include <algorithm>
#include <array>
#include <cmath>

#include "genus/base/progress.h"
#include "genus/language/evaluate.h"
#include "genus/language/stack.h"

namespace genus::language {

namespace {

constexpr std::size_t kMaxModuleDepth = 5'000;
constexpr std::size_t kMaxDepth = 20'000;  // of the tree
constexpr std::size_t kMaxNodes = 3'000'000;
constexpr std::uint32_t kMaxForElements = 1'000'000;
constexpr std::uint32_t kMaxChildren = 10'000;

}  // namespace

const Value& ModuleArguments::operator[](std::string_view name) const
{
    static thread_local const Value undef;
    for (std::size_t i = 0; i < names->size(); ++i)
        if ((*names)[i] == name) return values[i];
    return undef;
}

Evaluator::Evaluator(Program& program, Diagnostics& diagnostics)
    : program_(program), diagnostics_(diagnostics)
{
    for (const char* name : {"$fn", "$fa", "$fs", "$t", "$preview", "$vpr", "$vpt", "$vpd", "$vpf",
                             "$parent_modules", "$tolerance"})
        program_.special(program_.names.intern(name));
    parent_modules_special_ = program_.special(program_.names.intern("$parent_modules"));
    specials_.assign(program_.specials.size(), Value::unset());
    const Value origin = Value::numbers(std::array{0.0, 0.0, 0.0});
    set_root_special("$fn", 0.0);
    set_root_special("$fa", 12.0);
    set_root_special("$fs", 2.0);
    set_root_special("$t", 0.0);
    set_root_special("$preview", false);
    set_root_special("$vpr", origin);
    set_root_special("$vpt", origin);
    set_root_special("$vpd", 500.0);
    set_root_special("$vpf", 22.5);
    for (std::size_t i = 0; i < program_.files.size(); ++i)
        used_.push_back(std::make_unique<UsedFile>());
}

Evaluator::~Evaluator()
{
    clear_captured_frames();
}

void Evaluator::set_root_special(std::string_view name, Value value)
{
    const std::uint32_t number = program_.special(program_.names.intern(name));
    if (number >= specials_.size()) specials_.resize(number + 1, Value::unset());
    specials_[number] = std::move(value);
}

Value Evaluator::special(std::string_view name) const
{
    for (std::size_t i = 0; i < specials_.size(); ++i)
        if (program_.names[program_.specials[i]] == name)
            return specials_[i].is_unset() ? Value() : specials_[i];
    return Value();
}

Value Evaluator::root_special(std::string_view name) const
{
    return special(name);
}

void Evaluator::fail(const Place& place, const std::string& problem) const
{
    language::fail(program_.sources, place, problem);
}

ModelNode Evaluator::run()
{
    const DefinitionScope& scope = program_.files[0]->scope;
    const Place start{program_.files[0]->source, 1, 1};
    ModelNode root;
    root.name = "root";
    root.file = program_.sources[start.file].path;
    root.line = start.line;
    root.column = start.column;
    const auto here = [&] { return call_place_ ? *call_place_ : start; };
    try {
        root_frame_ = FrameHold(make_frame(scope.block.n_slots, nullptr));
        assignments(scope.block, root_frame_.get());
        for (const Statement* s : scope.block.statements)
            instantiate(*s, root_frame_.get(), root.children);
    } catch (const StackExhausted&) {
        fail(here(),
             "recursion without an end" + (call_name_ == Argument::kNoName
                                               ? std::string()
                                               : " in '" + program_.names[call_name_] + "'"));
    } catch (const OutOfValueMemory&) {
        fail(here(), "the model needs too much memory");
    } catch (const std::bad_alloc&) {
        fail(here(), "the model needs too much memory");
    }
    return root;
}

ModelNode Evaluator::make_node(std::string name, const Statement& s) const
{
    ModelNode node;
    node.name = std::move(name);
    node.file = program_.sources[s.place.file].path;
    node.line = s.place.line;
    node.column = s.place.column;
    node.root = s.root;
    node.highlight = s.highlight;
    node.background = s.background;
    const Value tolerance = special("$tolerance");
    node.tolerance = tolerance.is_number() ? std::max(tolerance.as_number(), 0.0) : 0.0;
    return node;
}

void Evaluator::assignments(const Block& block, Frame* f)
{
    for (const Assignment& a : block.assignments) {
        Value v = eval(a.value, f);
        if (a.special >= 0)
            set_special(static_cast<std::uint32_t>(a.special), std::move(v));
        else
            f->slots()[a.slot] = std::move(v);
    }
}

void Evaluator::block(const Block& block, Frame* f, Nodes& out)
{
    if (block.statements.empty() && block.assignments.empty()) return;
    const std::size_t mark = undo_.size();
    FrameHold own;
    if (block.own_frame) {
        own = FrameHold(make_frame(block.n_slots, f));
        f = own.get();
    }
    assignments(block, f);
    for (const Statement* s : block.statements) instantiate(*s, f, out);
    restore_specials(mark);
}

void Evaluator::instantiate(const Statement& s, Frame* f, Nodes& out)
{
    check_stack();
    if ((++steps_ & 0xff) == 0) current_progress().check();
    if (++n_nodes_ > kMaxNodes) fail(s.place, "the model has more than 3 million nodes");
    call_place_ = &s.place;
    call_name_ = s.name;
    if (++depth_ > kMaxDepth) fail(s.place, "nested too deeply");
    dispatch(s, f, out);
    --depth_;
}

void Evaluator::dispatch(const Statement& s, Frame* f, Nodes& out)
{
    using TargetKind = Target<ModuleDefinition>::Kind;
    if (s.is_if) {
        if_statement(s, f, out);
        return;
    }
    switch (s.target.kind) {
        case TargetKind::Unknown:
            fail(s.place, "unknown module '" + program_.names[s.name] + "'");
        case TargetKind::Builtin:
            builtin_module(s, f, out);
            return;
        default:
            user_module(s, f, out);
    }
}

void Evaluator::user_module(const Statement& s, Frame* f, Nodes& out)
{
    using TargetKind = Target<ModuleDefinition>::Kind;
    const ModuleDefinition& m = *s.target.definition;
    if (module_stack_.size() >= kMaxModuleDepth)
        fail(s.place, "recursion: more than " + std::to_string(kMaxModuleDepth) +
                          " modules within each other, the last is '" + program_.names[m.name] +
                          "'");
    const std::size_t mark = undo_.size();
    Frame* outside = f;
    if (s.target.kind == TargetKind::Used)
        outside = used_frame(s.target.index);
    else
        for (std::uint32_t n = s.target.steps; n > 0; --n) outside = outside->parent;
    FrameHold frame(make_frame(m.scope.block.n_slots, outside));
    bind_arguments(m.parameters, &m, s.arguments, s.binding, s.place, f, outside, frame.get());
    ModuleInstance instance{&s.children, f};
    frame->instance = &instance;
    module_stack_.push_back(m.name);
    frame->slots()[m.children_slot] = static_cast<double>(s.children.statements.size());
    set_special(parent_modules_special_, static_cast<double>(module_stack_.size()));
    ModelNode node = make_node("group", s);
    assignments(m.scope.block, frame.get());
    for (const Statement* inner : m.scope.block.statements)
        instantiate(*inner, frame.get(), node.children);
    module_stack_.pop_back();
    frame->instance = nullptr;
    restore_specials(mark);
    out.push_back(std::move(node));
}

void Evaluator::builtin_module(const Statement& s, Frame* f, Nodes& out)
{
    switch (static_cast<BuiltinModule>(s.target.index)) {
        case BuiltinModule::Assign:
            diagnostics_.deprecated(s.place,
                                    "The assign() module will be removed in future releases. Use a "
                                    "regular assignment instead.");
            let_statement(s, f, out);
            return;
        case BuiltinModule::Let:
            let_statement(s, f, out);
            return;
        case BuiltinModule::For:
        case BuiltinModule::IntersectionFor:
            for_statement(s, f, out);
            return;
        case BuiltinModule::Echo:
        case BuiltinModule::Assert:
            echo_or_assert(s, f, out);
            return;
        case BuiltinModule::Child:
            diagnostics_.deprecated_anywhere(
                s.place, "child() will be removed in future releases. Use children() instead.");
            children_statement(s, f, out);
            return;
        case BuiltinModule::Children:
            children_statement(s, f, out);
            return;
        case BuiltinModule::Group: {
            ModelNode node = make_node("group", s);
            block(s.children, f, node.children);
            out.push_back(std::move(node));
            return;
        }
        default:
            node_statement(s, f, out);
    }
}

void Evaluator::if_statement(const Statement& s, Frame* f, Nodes& out)
{
    Value store;
    const bool yes = ref(s.arguments[0].value, f, store).truthy();
    const Block& chosen = yes ? s.children : s.otherwise;
    if (!yes && !s.has_else) return;
    ModelNode node = make_node("group", s);
    block(chosen, f, node.children);
    out.push_back(std::move(node));
}

void Evaluator::for_statement(const Statement& s, Frame* f, Nodes& out)
{
    const bool intersection = static_cast<BuiltinModule>(s.target.index) != BuiltinModule::For;
    ModelNode node = make_node(intersection ? "intersection" : "group", s);
    if (!s.arguments.empty()) {
        const std::size_t mark = undo_.size();
        const FrameHold own(make_frame(s.n_slots, f));
        for_variable(s, 0, own.get(), node.children);
        restore_specials(mark);
    }
    out.push_back(std::move(node));
}

void Evaluator::for_variable(const Statement& s, std::size_t number, Frame* f, Nodes& out)
{
    if (number == s.arguments.size()) {
        block(s.children, f, out);
        return;
    }
    const Argument& a = s.arguments[number];
    const Value over = eval(a.value, f);
    const auto turn = [&](Value v) {
        current_progress().check();
        if (a.name == Argument::kNoName) {
            for_variable(s, number + 1, f, out);
        } else if (a.special >= 0) {
            const std::size_t mark = undo_.size();
            set_special(static_cast<std::uint32_t>(a.special), std::move(v));
            for_variable(s, number + 1, f, out);
            restore_specials(mark);
        } else {
            // A frame for each turn, as functions may hold on to it.
            const FrameHold own(make_frame(s.n_slots, f->parent));
            for (std::uint32_t i = 0; i < s.n_slots; ++i) own->slots()[i] = f->slots()[i];
            own->slots()[s.slots[number]] = std::move(v);
            for_variable(s, number + 1, own.get(), out);
        }
    };
    if (over.is_list()) {
        for (const Value& v : over.items()) turn(v);
    } else if (over.is_range()) {
        const RangeObject& r = over.as_range();
        const std::uint32_t n = range_size(r);
        if (n >= kMaxForElements) {
            diagnostics_.warn(s.place, "Bad range parameter in for statement: too many elements (" +
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

void Evaluator::let_statement(const Statement& s, Frame* f, Nodes& out)
{
    const std::size_t mark = undo_.size();
    const FrameHold own(make_frame(s.n_slots, f));
    std::vector<Names::Id> seen;
    for (std::size_t i = 0; i < s.arguments.size(); ++i) {
        const Argument& a = s.arguments[i];
        Value v = eval(a.value, own.get());
        if (a.name == Argument::kNoName) {
            diagnostics_.warn(a.place,
                              "Assignment without variable name " + to_text(v, program_.names));
            continue;
        }
        if (std::find(seen.begin(), seen.end(), a.name) != seen.end()) {
            diagnostics_.warn(a.place, "Ignoring duplicate variable assignment " +
                                           program_.names[a.name] + " = " +
                                           to_text(v, program_.names));
            continue;
        }
        seen.push_back(a.name);
        if (a.special >= 0)
            set_special(static_cast<std::uint32_t>(a.special), std::move(v));
        else
            own->slots()[s.slots[i]] = std::move(v);
    }
    ModelNode node = make_node("group", s);
    block(s.children, own.get(), node.children);
    restore_specials(mark);
    out.push_back(std::move(node));
}

void Evaluator::echo_or_assert(const Statement& s, Frame* f, Nodes& out)
{
    if (static_cast<BuiltinModule>(s.target.index) == BuiltinModule::Echo)
        echo(s.arguments, s.place, f);
    else
        assertion(s.arguments, s.place, f);
    if (s.children.statements.empty()) return;
    ModelNode node = make_node("group", s);
    block(s.children, f, node.children);
    out.push_back(std::move(node));
}

const ModuleInstance* Evaluator::instance_of(Frame* f)
{
    for (; f; f = f->parent)
        if (f->instance) return f->instance;
    return nullptr;
}

// One child, in a scope of its own. As in the text language the modifiers of the call are lost.
void Evaluator::child_by_number(const Statement& s, const ModuleInstance& m, double number,
                                Nodes& out)
{
    const std::size_t n = m.children->statements.size();
    if (!(number > -1.0)) {
        diagnostics_.warn(s.place,
                          "Negative children index (" + number_text(number) + ") not allowed");
        return;
    }
    if (!(number < static_cast<double>(n))) {
        diagnostics_.warn(s.place, "Children index (" + number_text(std::trunc(number)) +
                                       ") out of bounds (" + std::to_string(n) + " children)");
        return;
    }
    const std::size_t mark = undo_.size();
    Frame* f = m.frame;
    FrameHold own;
    if (m.children->own_frame) {
        own = FrameHold(make_frame(m.children->n_slots, f));
        f = own.get();
    }
    assignments(*m.children, f);
    instantiate(*m.children->statements[static_cast<std::size_t>(number)], f, out);
    restore_specials(mark);
}

void Evaluator::children_statement(const Statement& s, Frame* f, Nodes& out)
{
    static const std::vector<std::string_view> names = {"index"};
    const ModuleInstance* m = instance_of(f);
    if (!m) return;
    const bool deprecated = static_cast<BuiltinModule>(s.target.index) == BuiltinModule::Child;
    Value index = s.arguments.empty() ? Value() : eval(s.arguments[0].value, f);
    if (s.arguments.empty() && deprecated) index = Value(0.0);
    if (s.arguments.empty() && !deprecated) {
        ModelNode node = make_node("group", s);
        block(*m->children, m->frame, node.children);
        out.push_back(std::move(node));
        return;
    }
    if (index.is_number()) {
        child_by_number(s, *m, index.as_number(), out);
        return;
    }
    if (!index.is_list() && !index.is_range()) {
        diagnostics_.warn(s.place, "Bad parameter type (" + to_quoted_text(index, program_.names) +
                                       ") for children, only accept: empty, number, vector, range");
        return;
    }
    ModelNode node = make_node("group", s);
    if (index.is_list()) {
        for (const Value& v : index.items())
            if (v.is_number()) child_by_number(s, *m, v.as_number(), node.children);
    } else {
        const RangeObject& r = index.as_range();
        const std::uint32_t n = range_size(r);
        if (n > kMaxChildren) {
            diagnostics_.warn(s.place, "Bad range parameter for children: too many elements (" +
                                           std::to_string(n) + ")");
            return;
        }
        for (std::uint32_t i = 0; i < n; ++i)
            child_by_number(s, *m, range_value(r, i), node.children);
    }
    out.push_back(std::move(node));
}

ModuleArguments Evaluator::module_arguments(const Statement& s,
                                            const std::vector<std::string_view>& names,
                                            std::size_t n_positional, Frame* f)
{
    ModuleArguments out{&names, std::vector<Value>(names.size())};
    std::vector<std::pair<std::uint32_t, Value>> specials;
    std::size_t position = 0;
    bool too_many = false;
    std::vector<bool> given(names.size(), false);
    for (const Argument& a : s.arguments) {
        if (a.name == Argument::kNoName) {
            if (position < n_positional) {
                given[position] = true;
                out.values[position++] = eval(a.value, f);
            } else if (!std::exchange(too_many, true)) {
                diagnostics_.warn(s.place, "Too many unnamed arguments supplied");
            }
            continue;
        }
        const std::string& name = program_.names[a.name];
        const auto at = std::find(names.begin(), names.end(), name);
        if (at != names.end()) {
            const auto i = static_cast<std::size_t>(at - names.begin());
            if (given[i])
                diagnostics_.warn(s.place, "argument " + name + " supplied more than once");
            given[i] = true;
            out.values[i] = eval(a.value, f);
        } else if (a.special >= 0) {
            specials.emplace_back(a.special, eval(a.value, f));
        } else {
            diagnostics_.warn(s.place, "variable " + name + " not specified as parameter");
        }
    }
    for (auto& [number, v] : specials) set_special(number, std::move(v));
    return out;
}

void Evaluator::node_statement(const Statement& s, Frame* f, Nodes& out)
{
    const std::size_t mark = undo_.size();
    const NodeMaker& maker =
        node_maker(s.target.index - static_cast<std::uint32_t>(BuiltinModule::First));
    const ModuleArguments arguments = module_arguments(s, maker.parameters, maker.n_positional, f);
    ModelNode node = maker.make(*this, s, arguments);
    if (!maker.is_leaf)
        block(s.children, f, node.children);
    else if (!s.children.statements.empty())
        diagnostics_.warn(
            s.place, "module " + std::string(maker.name) + "() does not support child modules");
    restore_specials(mark);
    out.push_back(std::move(node));
}

}  // namespace genus::language
