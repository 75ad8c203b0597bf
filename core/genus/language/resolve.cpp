#include "genus/language/resolve.h"

#include <algorithm>
#include <array>

#include "genus/language/builtins.h"
#include "genus/language/stack.h"

namespace genus::language {

namespace {

/// Names of one stretch of text.
struct Scope {
    Scope* parent = nullptr;
    std::uint32_t* n_slots = nullptr;  // of the frame that holds the variables
    bool own_frame = true;             // else they live in that of the parent
    bool hoisted = true;               // a variable may be read before it is set
    const DefinitionScope* definitions = nullptr;
    std::vector<std::pair<Names::Id, std::uint32_t>> variables = {};
    std::unordered_map<Names::Id, std::uint32_t> many = {};  // instead, once there are many

    std::optional<std::uint32_t> find(Names::Id name) const
    {
        if (!many.empty()) {
            const auto at = many.find(name);
            return at == many.end() ? std::nullopt : std::optional(at->second);
        }
        for (const auto& [n, slot] : variables)
            if (n == name) return slot;
        return std::nullopt;
    }
    std::uint32_t add(Names::Id name)
    {
        if (const auto old = find(name)) return *old;
        const std::uint32_t slot = (*n_slots)++;
        variables.emplace_back(name, slot);
        if (!many.empty()) many[name] = slot;
        if (many.empty() && variables.size() > 16) many.insert(variables.begin(), variables.end());
        return slot;
    }
};

class Resolver {
public:
    explicit Resolver(Program& program) : program_(program), names_(program.names) {}

    void file(FileScope& file)
    {
        file_ = &file;
        Scope scope;
        definitions(file.scope, scope, nullptr);
    }

private:
    // `scope` gets the variables of the block and what `inner` defines is resolved in it.
    void definitions(DefinitionScope& inner, Scope& scope, Scope* parent)
    {
        scope.parent = parent;
        scope.n_slots = &inner.block.n_slots;
        scope.definitions = &inner;
        inner.block.own_frame = true;
        block_in(inner.block, scope);
        for (auto& [name, function] : inner.functions) this->function(*function, scope);
        for (auto& [name, module] : inner.modules) this->module(*module, scope);
    }

    void block_in(Block& block, Scope& scope)
    {
        for (Assignment& a : block.assignments) {
            if (names_.is_special(a.name))
                a.special = static_cast<std::int32_t>(program_.special(a.name));
            else
                a.slot = scope.add(a.name);
        }
        for (Assignment& a : block.assignments) a.value = expr(a.value, scope);
        for (Statement* s : block.statements) statement(*s, scope);
    }

    void child_block(Block& block, Scope& parent)
    {
        const auto is_variable = [&](const Assignment& a) { return !names_.is_special(a.name); };
        block.own_frame =
            std::any_of(block.assignments.begin(), block.assignments.end(), is_variable);
        if (!block.own_frame) {
            block_in(block, parent);
            return;
        }
        Scope scope;
        scope.parent = &parent;
        scope.n_slots = &block.n_slots;
        block_in(block, scope);
    }

    void parameters(std::vector<Parameter>& list, Scope& inside, Scope& outside)
    {
        for (Parameter& p : list) {
            if (names_.is_special(p.name))
                p.special = static_cast<std::int32_t>(program_.special(p.name));
            else
                p.slot = inside.add(p.name);
            if (!p.value) continue;
            Scope own;
            own.parent = &outside;
            own.n_slots = &p.n_slots;
            p.value = expr(p.value, p.own_frame ? own : outside);
        }
    }

    void function(FunctionDefinition& f, Scope& outside)
    {
        check_stack();
        Scope scope;
        scope.parent = &outside;
        scope.n_slots = &f.n_slots;
        scope.hoisted = false;
        parameters(f.parameters, scope, outside);
        for (const Parameter& p : f.parameters) f.has_specials |= p.special >= 0;
        f.body = expr(f.body, scope);
    }

    void module(ModuleDefinition& m, Scope& outside)
    {
        check_stack();
        Scope scope;
        scope.n_slots = &m.scope.block.n_slots;
        scope.parent = &outside;
        parameters(m.parameters, scope, outside);
        m.children_slot = scope.add(program_.names.intern("$children"));
        definitions(m.scope, scope, &outside);
    }

    void statement(Statement& s, Scope& scope)
    {
        check_stack();
        if (!s.is_if) find_target(s.target, s.name, scope, true);
        if (s.target.kind == Target<ModuleDefinition>::Kind::Builtin && binds(s.target.index)) {
            binding_statement(s, scope);
            return;
        }
        arguments(s.arguments, scope);
        child_block(s.children, scope);
        child_block(s.otherwise, scope);
    }

    static bool binds(std::uint32_t number)
    {
        return number <= static_cast<std::uint32_t>(BuiltinModule::Assign);
    }

    // for, let and the like: the arguments are variables of the children.
    void binding_statement(Statement& s, Scope& outside)
    {
        s.for_frame = true;
        Scope scope;
        scope.parent = &outside;
        scope.n_slots = &s.n_slots;
        for (Argument& a : s.arguments) {
            s.slots.push_back(0);
            if (a.name == Argument::kNoName) continue;
            if (names_.is_special(a.name))
                a.special = static_cast<std::int32_t>(program_.special(a.name));
            else
                s.slots.back() = scope.add(a.name);
        }
        for (Argument& a : s.arguments) a.value = expr(a.value, scope);
        child_block(s.children, scope);
    }

    void arguments(std::vector<Argument>& list, Scope& scope)
    {
        for (Argument& a : list) {
            if (a.name != Argument::kNoName && names_.is_special(a.name))
                a.special = static_cast<std::int32_t>(program_.special(a.name));
            a.value = expr(a.value, scope);
        }
    }

    template <typename Definition>
    void find_target(Target<Definition>& target, Names::Id name, const Scope& scope, bool module)
    {
        using TargetKind = typename Target<Definition>::Kind;
        std::uint32_t steps = 0;
        for (const Scope* s = &scope; s; s = s->parent) {
            if (s->definitions)
                if (const Definition* d = defined<Definition>(*s->definitions, name)) {
                    target = {TargetKind::User, d, steps, 0};
                    return;
                }
            if (s->own_frame) ++steps;
        }
        // Of several files that define it the one used last counts.
        for (auto use = file_->uses.rbegin(); use != file_->uses.rend(); ++use)
            if (const Definition* d = defined<Definition>(program_.files[use->file]->scope, name)) {
                target = {TargetKind::Used, d, 0, static_cast<std::uint32_t>(use->file)};
                return;
            }
        const auto number =
            module ? find_builtin_module(names_[name]) : find_builtin_function(names_[name]);
        if (number) target = {TargetKind::Builtin, nullptr, 0, *number};
    }

    template <typename Definition>
    static const Definition* defined(const DefinitionScope& scope, Names::Id name)
    {
        if constexpr (std::is_same_v<Definition, FunctionDefinition>) {
            const auto at = scope.functions.find(name);
            return at == scope.functions.end() ? nullptr : at->second;
        } else {
            const auto at = scope.modules.find(name);
            return at == scope.modules.end() ? nullptr : at->second;
        }
    }

    void variable(Variable& v, const Scope& scope)
    {
        Variable* at = &v;
        std::uint32_t steps = 0;
        for (const Scope* s = &scope; s; s = s->parent) {
            if (const auto slot = s->find(v.name)) {
                if (at->found) {
                    at->otherwise = program_.arena.make_expr<Variable>(ExprKind::Variable, v.place);
                    at = at->otherwise;
                    at->name = v.name;
                }
                at->found = true;
                at->slot = {steps, *slot};
                if (!s->hoisted) return;
            }
            if (s->own_frame) ++steps;
        }
    }

    // The variables of `let` and `for` and what stands in their reach.
    void bindings(Bindings& b, Scope& scope, Scope& outside)
    {
        scope.parent = &outside;
        scope.own_frame = scope.hoisted = b.own_frame;
        scope.n_slots = b.own_frame ? &b.n_slots : outside.n_slots;
        if (b.own_frame)
            for (BindingPair& pair : b.pairs) bind(pair, scope);
        for (BindingPair& pair : b.pairs) {
            pair.value = expr(pair.value, scope);
            if (!b.own_frame) bind(pair, scope);
        }
        mark_duplicates(b.pairs);
    }

    void bind(BindingPair& pair, Scope& scope)
    {
        if (pair.name == Argument::kNoName) return;
        if (names_.is_special(pair.name))
            pair.special = static_cast<std::int32_t>(program_.special(pair.name));
        else
            pair.slot = scope.add(pair.name);
    }

    static void mark_duplicates(std::vector<BindingPair>& pairs)
    {
        std::unordered_map<Names::Id, bool> seen;
        if (pairs.size() < 2) return;
        for (BindingPair& pair : pairs)
            if (pair.name != Argument::kNoName && !seen.try_emplace(pair.name, true).second)
                pair.duplicate = true;
    }

    Expr* c_for(CFor& f, Scope& outside)
    {
        f.n_start = f.bindings.pairs.size();
        Scope scope;
        bindings(f.bindings, scope, outside);
        // A variable met only in the updates is unset at first.
        scope.hoisted = true;
        for (BindingPair& pair : f.updates) {
            const bool known = pair.name != Argument::kNoName && scope.find(pair.name);
            bind(pair, scope);
            if (!known) f.bindings.pairs.push_back(pair);
        }
        f.condition = expr(f.condition, scope);
        for (BindingPair& pair : f.updates) pair.value = expr(pair.value, scope);
        mark_duplicates(f.updates);
        f.body = expr(f.body, scope);
        return &f;
    }

    Expr* list(List& l, Scope& scope)
    {
        bool constant = l.plain;
        for (Expr*& item : l.items) {
            item = expr(item, scope);
            constant = constant && item->kind == ExprKind::Literal;
        }
        if (!constant) return &l;
        std::vector<Value> values;
        for (const Expr* item : l.items) values.push_back(static_cast<const Literal*>(item)->value);
        return fold(Value::list(std::move(values)), l);
    }

    Expr* fold(Value value, const Expr& source)
    {
        auto* literal = program_.arena.make_expr<Literal>(ExprKind::Literal, source.place);
        literal->value = std::move(value);
        literal->source = &source;
        return literal;
    }

    static std::optional<double> number(const Expr* e)
    {
        if (!e || e->kind != ExprKind::Literal) return std::nullopt;
        const Value& v = static_cast<const Literal*>(e)->value;
        return v.is_number() ? std::optional(v.as_number()) : std::nullopt;
    }

    Expr* range(RangeExpr& r, Scope& scope)
    {
        r.begin = expr(r.begin, scope);
        if (r.step) r.step = expr(r.step, scope);
        r.end = expr(r.end, scope);
        const auto begin = number(r.begin), end = number(r.end);
        const auto step = r.step ? number(r.step) : std::optional(1.0);
        if (!begin || !end || !step || (*step > 0 && *begin > *end) || (*step < 0 && *begin < *end))
            return &r;
        return fold(Value::range(*begin, *step, *end), r);
    }

    Expr* unary(Unary& u, Scope& scope)
    {
        u.a = expr(u.a, scope);
        const auto n = number(u.a);
        if (!n || u.op == UnaryOp::Not) return &u;
        return fold(Value(u.op == UnaryOp::Minus ? -*n : *n), u);
    }

    void call(Call& c, Scope& scope)
    {
        if (c.callee->kind == ExprKind::Variable)
            variable(*static_cast<Variable*>(c.callee), scope);
        else
            c.callee = expr(c.callee, scope);
        if (c.callee->kind == ExprKind::Variable) {
            c.variable_found = static_cast<Variable*>(c.callee)->found;
            find_target(c.target, c.name, scope, false);
        }
        arguments(c.arguments, scope);
    }

    // Returns what to put in its place: itself, or the constant it stands for.
    Expr* expr(Expr* e, Scope& scope)
    {
        check_stack();
        switch (e->kind) {
            case ExprKind::Literal:
                return e;
            case ExprKind::Variable: {
                auto* v = static_cast<Variable*>(e);
                variable(*v, scope);
                if (v->found || names_[v->name] != "PI") return e;
                return fold(Value(3.14159265358979323846), *v);
            }
            case ExprKind::Special: {
                auto* s = static_cast<Special*>(e);
                s->special = program_.special(s->name);
                return e;
            }
            case ExprKind::Unary:
                return unary(*static_cast<Unary*>(e), scope);
            case ExprKind::Binary:
            case ExprKind::And:
            case ExprKind::Or: {
                auto* b = static_cast<Binary*>(e);
                b->a = expr(b->a, scope);
                b->b = expr(b->b, scope);
                return e;
            }
            case ExprKind::Ternary: {
                auto* t = static_cast<Ternary*>(e);
                t->condition = expr(t->condition, scope);
                t->yes = expr(t->yes, scope);
                t->no = expr(t->no, scope);
                return e;
            }
            case ExprKind::Range:
                return range(*static_cast<RangeExpr*>(e), scope);
            case ExprKind::List:
                return list(*static_cast<List*>(e), scope);
            case ExprKind::Index: {
                auto* i = static_cast<Index*>(e);
                i->of = expr(i->of, scope);
                i->at = expr(i->at, scope);
                return e;
            }
            case ExprKind::Member: {
                auto* m = static_cast<Member*>(e);
                m->of = expr(m->of, scope);
                return e;
            }
            case ExprKind::Call:
                call(*static_cast<Call*>(e), scope);
                return e;
            default:
                return scoped(e, scope);
        }
    }

    Expr* scoped(Expr* e, Scope& scope)
    {
        switch (e->kind) {
            case ExprKind::FunctionLiteral:
                function(static_cast<FunctionLiteral*>(e)->definition, scope);
                return e;
            case ExprKind::Let:
            case ExprKind::ListLet: {
                auto* l = static_cast<Let*>(e);
                Scope inside;
                bindings(l->bindings, inside, scope);
                l->body = expr(l->body, inside);
                return e;
            }
            case ExprKind::Assert:
            case ExprKind::Echo: {
                auto* a = static_cast<AssertExpr*>(e);
                arguments(a->arguments, scope);
                if (a->body) a->body = expr(a->body, scope);
                return e;
            }
            case ExprKind::For: {
                auto* f = static_cast<For*>(e);
                Scope inside;
                bindings(f->bindings, inside, scope);
                f->body = expr(f->body, inside);
                return e;
            }
            case ExprKind::CFor:
                return c_for(*static_cast<CFor*>(e), scope);
            case ExprKind::If: {
                auto* i = static_cast<If*>(e);
                i->condition = expr(i->condition, scope);
                i->yes = expr(i->yes, scope);
                if (i->no) i->no = expr(i->no, scope);
                return e;
            }
            case ExprKind::Each: {
                auto* each = static_cast<Each*>(e);
                each->of = expr(each->of, scope);
                return e;
            }
            default:
                return e;
        }
    }

    Program& program_;
    const Names& names_;
    FileScope* file_ = nullptr;
};

}  // namespace

void resolve(Program& program)
{
    Resolver resolver(program);
    for (const auto& file : program.files) resolver.file(*file);
}

}  // namespace genus::language
