#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "genus/language/diagnostics.h"
#include "genus/language/token.h"
#include "genus/language/value.h"

namespace genus::language {

// The tree of a program. The parser builds it; `resolve` then fills in what is marked so. Nodes
// belong to the Arena and are never freed before it, so plain pointers connect them.

struct FunctionDefinition;
struct ModuleDefinition;

enum class ExprKind : std::uint8_t {
    Literal,
    Variable,
    Special,
    Unary,
    Binary,
    And,
    Or,
    Ternary,
    Range,
    List,
    Index,
    Member,
    Call,
    FunctionLiteral,
    Let,
    Assert,
    Echo,
    // Only inside a list:
    For,
    CFor,
    If,
    Each,
    ListLet
};

struct Expr {
    ExprKind kind;
    Place place;
};

struct Literal : Expr {
    Value value;
    const Expr* source = nullptr;  // what was folded into it, for printing
};

/// How to reach a variable: resolved.
struct Slot {
    std::uint32_t steps = 0;  // frames outward
    std::uint32_t index = 0;
};

struct Variable : Expr {
    Names::Id name;
    bool found = false;             // resolved: some scope has it
    Slot slot;                      // resolved
    Variable* otherwise = nullptr;  // resolved: where to look while the slot is unset
};

/// A variable whose name starts with '$': looked up where the program runs, not where it stands.
struct Special : Expr {
    Names::Id name;
    std::uint32_t special = 0;  // resolved: number among the special variables
};

enum class UnaryOp : std::uint8_t { Plus, Minus, Not };
struct Unary : Expr {
    UnaryOp op;
    Expr* a;
};

enum class BinaryOp : std::uint8_t {
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
    Power,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual
};
const char* to_string(BinaryOp op);

struct Binary : Expr {  // also And, Or
    BinaryOp op;
    Expr* a;
    Expr* b;
};

struct Ternary : Expr {
    Expr *condition, *yes, *no;
};

struct RangeExpr : Expr {
    Expr* begin;
    Expr* step;  // null where not given
    Expr* end;
};

struct List : Expr {
    std::vector<Expr*> items;
    bool plain = true;  // no comprehension among the items
};

struct Index : Expr {
    Expr *of, *at;
};

struct Member : Expr {
    Expr* of;
    Names::Id name;
};

struct Argument {
    static constexpr Names::Id kNoName = ~Names::Id{0};

    Names::Id name = kNoName;
    Expr* value = nullptr;
    Place place;
    std::int32_t special = -1;  // resolved: number if the name is a special variable
};

/// How the arguments of a call meet the parameters of one definition: found once per call.
struct Binding {
    struct Target {
        enum class Kind : std::uint8_t { Parameter, Special, Dropped };
        Kind kind;
        std::uint32_t index;  // of the parameter, or number of the special variable
    };
    const void* definition = nullptr;
    std::vector<Target> targets;         // one an argument
    std::vector<std::string> warnings;   // said at each call
    std::vector<std::uint32_t> missing;  // parameters without argument
};

/// Where a named function or module is: resolved.
template <typename Definition>
struct Target {
    enum class Kind : std::uint8_t { Unknown, User, Used, Builtin };
    Kind kind = Kind::Unknown;
    const Definition* definition = nullptr;  // User, Used
    std::uint32_t steps = 0;                 // User: frames outward to the scope that holds it
    std::uint32_t index = 0;                 // Used: number of the file; Builtin: its number
};

struct Call : Expr {
    Expr* callee = nullptr;  // a Variable or Special where a name is called
    Names::Id name = Argument::kNoName;
    std::vector<Argument> arguments;
    bool variable_found = false;        // resolved: the name may be a variable
    Target<FunctionDefinition> target;  // resolved
    mutable Binding binding;
};

struct BindingPair {
    Names::Id name = Argument::kNoName;
    Expr* value = nullptr;
    Place place;
    // resolved:
    std::uint32_t slot = 0;
    std::int32_t special = -1;
    bool duplicate = false;
};

/// Variables of a scope inside an expression. Where a function literal can hold on to them they
/// get a frame of their own at each entry, else they live in the frame around: resolved.
struct Bindings {
    std::vector<BindingPair> pairs;
    bool own_frame = false;
    std::uint32_t n_slots = 0;  // of the own frame
};

struct Let : Expr {  // also ListLet
    Bindings bindings;
    Expr* body;
};

struct AssertExpr : Expr {  // also Echo
    std::vector<Argument> arguments;
    Expr* body;  // null where none follows
};

struct For : Expr {
    Bindings bindings;
    Expr* body;
};

struct CFor : Expr {
    Bindings bindings;  // start values; then, unset, names met only in the updates
    std::vector<BindingPair> updates;
    std::size_t n_start = 0;  // resolved: how many of the bindings are start values
    Expr* condition;
    Expr* body;
};

struct If : Expr {
    Expr *condition, *yes;
    Expr* no;  // may be null
};

struct Each : Expr {
    Expr* of;
};

struct Parameter {
    Names::Id name = 0;
    Expr* value = nullptr;  // default, null where none
    Place place;
    // resolved:
    std::int32_t special = -1;
    std::uint32_t slot = 0;
    bool own_frame = false;  // the default needs a frame for its own variables
    std::uint32_t n_slots = 0;
};

struct FunctionDefinition {
    Names::Id name = Argument::kNoName;  // none for a literal
    Place place;
    std::vector<Parameter> parameters;
    Expr* body = nullptr;
    std::uint32_t n_slots = 0;  // resolved
    bool has_specials = false;  // resolved: among the parameters
};

struct FunctionLiteral : Expr {
    FunctionDefinition definition;
};

struct Assignment {
    Names::Id name = 0;
    Expr* value = nullptr;
    Place place;
    // resolved:
    std::uint32_t slot = 0;
    std::int32_t special = -1;
};

struct Statement;

/// Assignments and module calls between braces, or of a file or module.
struct Block {
    std::vector<Assignment> assignments;  // one a name, in order of first appearance
    std::unordered_map<Names::Id, std::size_t> assigned;
    std::vector<Statement*> statements;
    bool own_frame = false;     // resolved: has variables
    std::uint32_t n_slots = 0;  // resolved
};

/// A call of a module, with its children. `if` is one with a condition as its argument.
struct Statement {
    Place place;
    Names::Id name = 0;
    std::vector<Argument> arguments;
    Block children;
    Block otherwise;  // of an if
    bool is_if = false;
    bool has_else = false;
    bool root = false, highlight = false, background = false;  // ! # %
    // resolved:
    Target<ModuleDefinition> target;
    bool for_frame = false;            // binds variables round its children
    std::vector<std::uint32_t> slots;  // of the arguments that bind variables
    std::uint32_t n_slots = 0;
    mutable Binding binding;
};

/// Where functions and modules can be defined: a file or the body of a module.
struct DefinitionScope {
    std::unordered_map<Names::Id, FunctionDefinition*> functions;
    std::unordered_map<Names::Id, ModuleDefinition*> modules;
    Block block;
};

struct ModuleDefinition {
    Names::Id name = 0;
    Place place;
    std::vector<Parameter> parameters;
    DefinitionScope scope;
    std::uint32_t children_slot = 0;  // resolved: of the variable $children
};

struct FileScope {
    std::int32_t source = 0;
    std::string folder;
    DefinitionScope scope;
    struct Use {
        Place place;
        std::size_t file;  // number among the files of the program
    };
    std::vector<Use> uses;
};

/// Owns the nodes of a program.
class Arena {
public:
    template <typename T>
    T* make()
    {
        auto owned = std::make_unique<Holder<T>>();
        T* node = &owned->node;
        nodes_.push_back(std::move(owned));
        return node;
    }
    template <typename T>
    T* make_expr(ExprKind kind, const Place& place)
    {
        T* node = make<T>();
        node->kind = kind;
        node->place = place;
        return node;
    }

private:
    struct Any {
        virtual ~Any() = default;
    };
    template <typename T>
    struct Holder final : Any {
        T node{};
    };
    std::vector<std::unique_ptr<Any>> nodes_;
};

/// A whole program: file 0 is the model, the others are those it uses.
struct Program {
    Sources sources;
    Names names;
    Arena arena;
    std::vector<std::unique_ptr<FileScope>> files;
    std::vector<Names::Id> specials;  // names of the special variables by number
    std::unordered_map<Names::Id, std::uint32_t> special_numbers;

    std::uint32_t special(Names::Id name)
    {
        const auto [at, added] =
            special_numbers.try_emplace(name, static_cast<std::uint32_t>(specials.size()));
        if (added) specials.push_back(name);
        return at->second;
    }
};

/// The expression as text, fully bracketed, as messages show it.
std::string to_text(const Expr& expr, const Names& names);
/// "function(x, y = 2) (x * y)".
std::string to_text(const FunctionDefinition& definition, const Names& names);

}  // namespace genus::language
