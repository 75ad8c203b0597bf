#pragma once

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "genus/language/builtins.h"
#include "genus/language/diagnostics.h"
#include "genus/language/frame.h"
#include "genus/language/model_tree.h"
#include "genus/language/syntax.h"
#include "genus/language/value.h"

namespace genus::language {

/// One run of a module of the model: what its `children()` stand for.
struct ModuleInstance {
    const Block* children;
    Frame* frame;  // in which the children are evaluated
};

/// The arguments of a built-in module by the names of its parameters.
struct ModuleArguments {
    const std::vector<std::string_view>* names;
    std::vector<Value> values;  // undef where not given

    const Value& operator[](std::string_view name) const;
};

/// Runs a resolved program. Calls itself deeply: use it on a large stack.
///
/// Functions in tail position do not deepen the stack. A default value is evaluated only where its
/// argument is missing. The variables of a used file are evaluated at the first call into it, and
/// again only if a special variable they read has changed.
class Evaluator {
public:
    Evaluator(Program& program, Diagnostics& diagnostics);
    ~Evaluator();
    Evaluator(const Evaluator&) = delete;
    Evaluator& operator=(const Evaluator&) = delete;

    /// Sets a special variable for the whole run.
    void set_root_special(std::string_view name, Value value);
    /// The nodes of the model under one root. Throws ModelError: for an endless recursion, a failed
    /// assertion, an unknown module, too much memory.
    ModelNode run();
    /// Value of a special variable at the root of the model, after `run`; undef if it has none.
    Value root_special(std::string_view name) const;

    // For the built-in functions and modules.

    Diagnostics& diagnostics() { return diagnostics_; }
    const Program& program() const { return program_; }
    std::mt19937& random() { return random_; }
    [[noreturn]] void fail(const Place& place, const std::string& problem) const;
    /// Undef if there is none.
    Value special(std::string_view name) const;
    /// Names of the modules being run, outermost first.
    const std::vector<Names::Id>& module_stack() const { return module_stack_; }
    ModelNode make_node(std::string name, const Statement& statement) const;

private:
    struct Activation {
        const FunctionDefinition* definition = nullptr;
        FrameHold frame;
        Value value;  // where there was nothing to activate
    };
    struct UsedFile {
        FrameHold frame;
        bool ready = false;
        std::vector<std::pair<std::uint32_t, Value>> specials;  // it sets
        std::vector<std::pair<std::uint32_t, Value>> reads;     // special variables it read
    };

    // Expressions. `ref` avoids a copy where the value lies in a variable or literal; else it is
    // put into `store`.
    Value eval(const Expr* e, Frame* f);
    const Value& ref(const Expr* e, Frame* f, Value& store);
    const Value* slot_of(const Variable& v, Frame* f) const;
    Value unset_variable(const Variable& v, Frame* f);
    Value special_value(const Special& s);
    const Value& read_special(std::uint32_t number);
    Value unary(const Unary& u, Frame* f);
    Value binary(const Binary& b, Frame* f);
    Value range(const RangeExpr& r, Frame* f);
    Value list(const List& l, Frame* f);
    Value index(const Index& i, Frame* f);
    Value member(const Member& m, Frame* f);
    Value let(const Let& l, Frame* f);
    Value body_of(const AssertExpr& a, Frame* f);
    void assertion(const std::vector<Argument>& arguments, const Place& place, Frame* f);
    void echo(const std::vector<Argument>& arguments, const Place& place, Frame* f);

    // Items of a list go onto the value stack.
    void push(Value v);
    void collect(const Expr* item, Frame* f);
    void collect_for(const For& loop, std::size_t pair, Frame* f);
    void collect_c_for(const CFor& loop, Frame* f);
    void collect_all(const Value& v, const Place& place);
    Value take_list(std::size_t base);

    // Variables of let.
    FrameHold enter(const Bindings& b, Frame* f);
    void bind_pairs(const std::vector<BindingPair>& pairs, std::size_t n, Frame* f);
    void bind_pair(const BindingPair& pair, Value v, Frame* f);

    // Calls.
    bool prepare(const Call& call, Frame* f, Activation& out);
    Value run_function(const FunctionDefinition* definition, FrameHold frame);
    Value builtin(const Call& call, Frame* f);
    bool bind_positions(const FunctionDefinition& definition,
                        const std::vector<Argument>& arguments, Frame* caller, Frame* outside,
                        Frame* inside);
    void bind_arguments(const std::vector<Parameter>& parameters, const void* definition,
                        const std::vector<Argument>& arguments, Binding& binding,
                        const Place& place, Frame* caller, Frame* outside, Frame* inside);
    void find_binding(const std::vector<Parameter>& parameters, const void* definition,
                      const std::vector<Argument>& arguments, Binding& binding) const;
    Value default_value(const Parameter& p, Frame* outside);
    Frame* used_frame(std::size_t file);
    void start_used_file(std::size_t number, UsedFile& file);
    bool still_valid(const UsedFile& file) const;

    // Special variables: the current value of each, and what to restore.
    void set_special(std::uint32_t number, Value v);
    void restore_specials(std::size_t mark);

    // Modules.
    using Nodes = std::vector<ModelNode>;
    void assignments(const Block& block, Frame* f);
    void block(const Block& block, Frame* f, Nodes& out);
    void instantiate(const Statement& s, Frame* f, Nodes& out);
    void dispatch(const Statement& s, Frame* f, Nodes& out);
    void user_module(const Statement& s, Frame* f, Nodes& out);
    void builtin_module(const Statement& s, Frame* f, Nodes& out);
    void if_statement(const Statement& s, Frame* f, Nodes& out);
    void for_statement(const Statement& s, Frame* f, Nodes& out);
    void for_variable(const Statement& s, std::size_t argument, Frame* f, Nodes& out);
    void let_statement(const Statement& s, Frame* f, Nodes& out);
    void echo_or_assert(const Statement& s, Frame* f, Nodes& out);
    void children_statement(const Statement& s, Frame* f, Nodes& out);
    void child_by_number(const Statement& s, const ModuleInstance& m, double number, Nodes& out);
    void node_statement(const Statement& s, Frame* f, Nodes& out);
    ModuleArguments module_arguments(const Statement& s, const std::vector<std::string_view>& names,
                                     std::size_t n_positional, Frame* f);
    static const ModuleInstance* instance_of(Frame* f);

    Program& program_;
    Diagnostics& diagnostics_;
    std::mt19937 random_;
    std::vector<Value> stack_;     // items of the lists being built
    std::vector<Value> specials_;  // by number; unset where unknown
    std::vector<std::pair<std::uint32_t, Value>> undo_;
    std::vector<std::pair<std::uint32_t, Value>>* reads_ =
        nullptr;  // of the used file being started
    std::size_t reads_mark_ = 0;
    std::vector<Names::Id> module_stack_;
    std::vector<std::unique_ptr<UsedFile>> used_;
    std::vector<Value> root_specials_;
    FrameHold root_frame_;
    std::uint32_t steps_ = 0;  // to look for a wish to cancel now and then
    std::size_t n_nodes_ = 0;
    std::size_t depth_ = 0;              // of the statement being run
    const Place* call_place_ = nullptr;  // of the last call, should the stack run out
    Names::Id call_name_ = Argument::kNoName;
    std::uint32_t parent_modules_special_;
};

/// Text of a value as `str` and `echo` show it; strings in lists are quoted.
std::string to_text(const Value& v, const Names& names);
/// The same, a string too in quotes.
std::string to_quoted_text(const Value& v, const Names& names);
/// Six digits, as short as they go: "0.1", "1e+10", "inf".
std::string number_text(double value);
void append_number(std::string& out, double value);

/// Makes the node of built-in module `number` (counted from BuiltinModule::First), without
/// children.
struct NodeMaker {
    std::string_view name;
    std::vector<std::string_view> parameters;
    std::size_t n_positional;
    ModelNode (*make)(Evaluator&, const Statement&, const ModuleArguments&);
    bool is_leaf = false;  // takes no children
};
const NodeMaker& node_maker(std::uint32_t number);

}  // namespace genus::language
