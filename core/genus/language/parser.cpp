#include "genus/language/parser.h"

#include <filesystem>

#include "genus/base/progress.h"
#include "genus/language/stack.h"

namespace genus::language {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxUsedFiles = 10'000;

using Kind = Token::Kind;

// What fits on one line of a text.
std::string quoted_start(const std::string& text)
{
    std::string start = text.substr(0, std::min<std::size_t>(text.find_first_of("\r\n"), 40));
    for (char& c : start)
        if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    return '"' + start + (start.size() < text.size() ? "..." : "") + '"';
}

std::string describe(const Token& token, const TokenText& text, const Names& names)
{
    switch (token.kind) {
        case Kind::End:
            return "end of file";
        case Kind::Number:
            return "number";
        case Kind::String:
            return "string " + quoted_start(text.strings[token.id]);
        case Kind::LessEqual:
            return "'<='";
        case Kind::GreaterEqual:
            return "'>='";
        case Kind::Equal:
            return "'=='";
        case Kind::NotEqual:
            return "'!='";
        case Kind::And:
            return "'&&'";
        case Kind::Or:
            return "'||'";
        case Kind::Character:
            return std::string("'") + static_cast<char>(token.id) + "'";
        case Kind::Use:
            return "'use'";
        default:
            return "'" + names[token.id] + "'";
    }
}

/// How tightly a binary operator binds; 0 for other tokens.
int precedence(const Token& t)
{
    switch (t.kind) {
        case Kind::Or:
            return 1;
        case Kind::And:
            return 2;
        case Kind::Equal:
        case Kind::NotEqual:
            return 3;
        case Kind::LessEqual:
        case Kind::GreaterEqual:
            return 4;
        case Kind::Character:
            break;
        default:
            return 0;
    }
    switch (t.id) {
        case '<':
        case '>':
            return 4;
        case '+':
        case '-':
            return 5;
        case '*':
        case '/':
        case '%':
            return 6;
        default:
            return 0;
    }
}

BinaryOp binary_op(const Token& t)
{
    switch (t.kind) {
        case Kind::Equal:
            return BinaryOp::Equal;
        case Kind::NotEqual:
            return BinaryOp::NotEqual;
        case Kind::LessEqual:
            return BinaryOp::LessEqual;
        case Kind::GreaterEqual:
            return BinaryOp::GreaterEqual;
        default:
            break;
    }
    switch (t.id) {
        case '<':
            return BinaryOp::Less;
        case '>':
            return BinaryOp::Greater;
        case '+':
            return BinaryOp::Add;
        case '-':
            return BinaryOp::Subtract;
        case '*':
            return BinaryOp::Multiply;
        case '/':
            return BinaryOp::Divide;
        default:
            return BinaryOp::Modulo;
    }
}

bool is_comprehension(const Expr& e)
{
    switch (e.kind) {
        case ExprKind::For:
        case ExprKind::CFor:
        case ExprKind::If:
        case ExprKind::Each:
        case ExprKind::ListLet:
            return true;
        default:
            return false;
    }
}

/// What the parsers of all files of a program share.
struct Shared {
    Program& program;
    Diagnostics& diagnostics;
    Loader& loader;
    std::int32_t main_source;
    std::unordered_map<std::string, std::size_t> file_numbers = {};  // by path
    std::vector<Loader::Found> to_read = {};  // used files by number less one
};

/// Recursive descent over the tokens of one file.
class Parser {
public:
    Parser(Shared& shared, const Tokenizer& tokenizer, const TokenText& text)
        : shared_(shared),
          tokenizer_(tokenizer),
          text_(text),
          arena_(shared.program.arena),
          names_(shared.program.names)
    {
    }

    void file(FileScope& scope)
    {
        while (peek().kind != Kind::End) {
            if (peek().kind == Kind::Use)
                use(scope);
            else
                statement(scope.scope);
        }
    }

    /// "name = expression", replacing what `block` has.
    void define(Block& block)
    {
        Assignment a = assignment_head();
        a.value = expression();
        if (peek().kind != Kind::End) unexpected("end of the expression");
        assign(block, a, false);
    }

private:
    const Token& peek(std::size_t ahead = 0) const
    {
        return text_.tokens[std::min(at_ + ahead, text_.tokens.size() - 1)];
    }
    bool next_is(char c) const { return peek().is(c); }
    bool accept(char c)
    {
        if (!next_is(c)) return false;
        ++at_;
        return true;
    }
    bool accept(Kind kind)
    {
        if (peek().kind != kind) return false;
        ++at_;
        return true;
    }
    void expect(char c)
    {
        if (!accept(c)) unexpected(std::string("'") + c + "'");
    }
    Token expect_name(const char* what)
    {
        if (peek().kind != Kind::Name) unexpected(what);
        return text_.tokens[at_++];
    }
    [[noreturn]] void unexpected(const std::string& expected) const
    {
        fail(shared_.program.sources, peek().place,
             "syntax error: unexpected " + describe(peek(), text_, names_) + ", expected " +
                 expected);
    }
    void check_depth() const
    {
        try {
            check_stack();
        } catch (const StackExhausted&) {
            fail(shared_.program.sources, peek().place, "nested too deeply");
        }
    }

    // Statements.

    void use(FileScope& scope)
    {
        const Token token = peek();
        ++at_;
        const std::string& name = text_.strings[token.id];
        const std::string extension = fs::path(name).extension().string();
        if (extension == ".ttf" || extension == ".otf" || extension == ".TTF" ||
            extension == ".OTF")
            return;  // a font
        const Loader::Found found =
            shared_.loader.find(name, tokenizer_.folder_of_use(token.id), token.place);
        const auto [at, added] =
            shared_.file_numbers.try_emplace(found.path, shared_.to_read.size() + 1);
        if (added) {
            if (shared_.to_read.size() >= kMaxUsedFiles)
                fail(shared_.program.sources, token.place, "more than 10000 files are used");
            shared_.to_read.push_back(found);
        }
        scope.uses.push_back({token.place, at->second});
    }

    void statement(DefinitionScope& scope)
    {
        check_depth();
        if (accept(';')) return;
        if (accept('{')) {
            while (!accept('}')) {
                if (peek().kind == Kind::End) unexpected("'}'");
                statement(scope);
            }
            return;
        }
        if (peek().kind == Kind::Module)
            module_definition(scope);
        else if (peek().kind == Kind::Function)
            function_definition(scope);
        else if (starts_assignment())
            assignment(scope.block);
        else
            add_statement(scope.block, module_call());
    }

    bool starts_assignment() const { return peek().kind == Kind::Name && peek(1).is('='); }

    Assignment assignment_head()
    {
        const Token name = expect_name("a name");
        Assignment a;
        a.name = name.id;
        a.place = name.place;
        expect('=');
        return a;
    }

    void assignment(Block& block)
    {
        Assignment a = assignment_head();
        a.value = expression();
        expect(';');
        assign(block, a, true);
    }

    // The last assignment wins, at the place of the first.
    void assign(Block& block, const Assignment& a, bool warn)
    {
        const auto [at, added] = block.assigned.try_emplace(a.name, block.assignments.size());
        if (added) {
            block.assignments.push_back(a);
            return;
        }
        Assignment& old = block.assignments[at->second];
        if (warn) warn_overwritten(old, a);
        old = a;
    }

    // Silent where the model overrides what it includes: that is how parameters are set.
    void warn_overwritten(const Assignment& old, const Assignment& now)
    {
        const Sources& sources = shared_.program.sources;
        const std::string& main = *sources[shared_.main_source].path;
        const std::string &before = *sources[old.place.file].path,
                          &after = *sources[now.place.file].path;
        std::string text =
            names_[old.name] + " was assigned on line " + std::to_string(old.place.line);
        if (before == main && after == main)
            text += " but was overwritten";
        else if (before == after || before == main)
            text += " of \"" + sources[old.place.file].shown + "\" but was overwritten";
        else
            return;
        shared_.diagnostics.warn(now.place, text);
    }

    void module_definition(DefinitionScope& scope)
    {
        const Place place = peek().place;
        ++at_;
        auto* module = arena_.make<ModuleDefinition>();
        module->name = expect_name("the name of a module").id;
        module->place = place;
        expect('(');
        module->parameters = parameters();
        statement(module->scope);
        scope.modules[module->name] = module;
    }

    void function_definition(DefinitionScope& scope)
    {
        const Place place = peek().place;
        ++at_;
        auto* function = arena_.make<FunctionDefinition>();
        function->name = expect_name("the name of a function").id;
        function->place = place;
        expect('(');
        function->parameters = parameters();
        expect('=');
        function->body = expression();
        expect(';');
        scope.functions[function->name] = function;
    }

    // Up to and with the closing bracket.
    std::vector<Parameter> parameters()
    {
        std::vector<Parameter> list;
        while (!accept(')')) {
            if (accept(',')) continue;
            const Token name = expect_name("the name of a parameter");
            Parameter p;
            p.name = name.id;
            p.place = name.place;
            const std::size_t binders = n_binders_;
            if (accept('=')) p.value = expression();
            p.own_frame = n_binders_ > binders;
            list.push_back(p);
            if (!next_is(')') && !next_is(',')) unexpected("',' or ')'");
        }
        return list;
    }

    void add_statement(Block& block, Statement* s)
    {
        if (s) block.statements.push_back(s);
    }

    static bool names_module(const Token& t)
    {
        switch (t.kind) {
            case Kind::Name:
            case Kind::For:
            case Kind::Let:
            case Kind::Assert:
            case Kind::Echo:
            case Kind::Each:
                return true;
            default:
                return false;
        }
    }

    // Null for one that '*' switches off.
    Statement* module_call()
    {
        check_depth();
        if (accept('!')) return mark(&Statement::root);
        if (accept('#')) return mark(&Statement::highlight);
        if (accept('%')) return mark(&Statement::background);
        if (accept('*')) {
            module_call();
            return nullptr;
        }
        if (peek().kind == Kind::If) return if_statement();
        if (!names_module(peek())) unexpected("a statement");
        auto* s = arena_.make<Statement>();
        s->place = peek().place;
        s->name = peek().id;
        ++at_;
        expect('(');
        s->arguments = arguments(')');
        children(s->children);
        return s;
    }

    Statement* mark(bool Statement::*modifier)
    {
        Statement* s = module_call();
        if (s) s->*modifier = true;
        return s;
    }

    Statement* if_statement()
    {
        auto* s = arena_.make<Statement>();
        s->place = peek().place;
        s->name = peek().id;
        s->is_if = true;
        ++at_;
        expect('(');
        Argument condition;
        condition.place = peek().place;
        condition.value = expression();
        s->arguments.push_back(condition);
        expect(')');
        children(s->children);
        s->has_else = accept(Kind::Else);
        if (s->has_else) children(s->otherwise);
        return s;
    }

    void children(Block& block)
    {
        check_depth();
        if (accept(';')) return;
        if (!accept('{')) {
            add_statement(block, module_call());
            return;
        }
        while (!accept('}')) {
            if (peek().kind == Kind::End) unexpected("'}'");
            if (starts_assignment())
                assignment(block);
            else
                children(block);
        }
    }

    // Expressions.

    // Up to and with `close`.
    std::vector<Argument> arguments(char close)
    {
        std::vector<Argument> list;
        while (!accept(close)) {
            if (accept(',')) continue;
            list.push_back(argument());
            if (!next_is(close) && !next_is(',')) unexpected(std::string("',' or '") + close + "'");
        }
        return list;
    }

    Argument argument()
    {
        Argument a;
        a.place = peek().place;
        if (starts_assignment()) {
            a.name = peek().id;
            at_ += 2;
        }
        a.value = expression();
        return a;
    }

    std::vector<BindingPair> pairs(char close)
    {
        std::vector<BindingPair> list;
        for (const Argument& a : arguments(close)) {
            BindingPair pair;
            pair.name = a.name;
            pair.value = a.value;
            pair.place = a.place;
            list.push_back(pair);
        }
        return list;
    }

    Expr* expression()
    {
        check_depth();
        const Place place = peek().place;
        switch (peek().kind) {
            case Kind::Function:
                return function_literal();
            case Kind::Let: {
                ++at_;
                ++n_binders_;
                const std::size_t literals = n_literals_;
                auto* let = arena_.make_expr<Let>(ExprKind::Let, place);
                expect('(');
                let->bindings.pairs = pairs(')');
                let->body = expression();
                let->bindings.own_frame = n_literals_ > literals;
                return let;
            }
            case Kind::Assert:
            case Kind::Echo:
                return assert_or_echo();
            default:
                break;
        }
        Expr* condition = binary(1);
        if (!accept('?')) return condition;
        auto* t = arena_.make_expr<Ternary>(ExprKind::Ternary, place);
        t->condition = condition;
        t->yes = expression();
        expect(':');
        t->no = expression();
        return t;
    }

    Expr* function_literal()
    {
        const Place place = peek().place;
        ++at_;
        ++n_literals_;
        auto* f = arena_.make_expr<FunctionLiteral>(ExprKind::FunctionLiteral, place);
        f->definition.place = place;
        expect('(');
        f->definition.parameters = parameters();
        f->definition.body = expression();
        return f;
    }

    Expr* assert_or_echo()
    {
        const bool is_assert = peek().kind == Kind::Assert;
        auto* e = arena_.make_expr<AssertExpr>(is_assert ? ExprKind::Assert : ExprKind::Echo,
                                               peek().place);
        ++at_;
        expect('(');
        e->arguments = arguments(')');
        e->body = starts_expression() ? expression() : nullptr;
        return e;
    }

    bool starts_expression() const
    {
        switch (peek().kind) {
            case Kind::Number:
            case Kind::String:
            case Kind::Name:
            case Kind::Function:
            case Kind::Let:
            case Kind::Assert:
            case Kind::Echo:
            case Kind::True:
            case Kind::False:
            case Kind::Undef:
                return true;
            case Kind::Character: {
                const char c = static_cast<char>(peek().id);
                return c == '(' || c == '[' || c == '-' || c == '+' || c == '!';
            }
            default:
                return false;
        }
    }

    Expr* binary(int lowest)
    {
        const Place place = peek().place;
        Expr* left = unary();
        for (;;) {
            const Token op = peek();
            const int level = precedence(op);
            if (level < lowest || level == 0) return left;
            ++at_;
            const ExprKind kind = op.kind == Kind::And  ? ExprKind::And
                                  : op.kind == Kind::Or ? ExprKind::Or
                                                        : ExprKind::Binary;
            auto* b = arena_.make_expr<Binary>(kind, place);
            if (kind == ExprKind::Binary) b->op = binary_op(op);
            b->a = left;
            b->b = binary(level + 1);
            left = b;
        }
    }

    Expr* unary()
    {
        check_depth();
        const Place place = peek().place;
        const std::optional<UnaryOp> op = next_is('-')   ? std::optional(UnaryOp::Minus)
                                          : next_is('+') ? std::optional(UnaryOp::Plus)
                                          : next_is('!') ? std::optional(UnaryOp::Not)
                                                         : std::nullopt;
        if (!op) return power();
        ++at_;
        auto* u = arena_.make_expr<Unary>(ExprKind::Unary, place);
        u->op = *op;
        u->a = unary();
        return u;
    }

    Expr* power()
    {
        const Place place = peek().place;
        Expr* base = postfix();
        if (!accept('^')) return base;
        auto* b = arena_.make_expr<Binary>(ExprKind::Binary, place);
        b->op = BinaryOp::Power;
        b->a = base;
        b->b = unary();
        return b;
    }

    Expr* postfix()
    {
        const Place place = peek().place;
        Expr* e = primary();
        for (;;) {
            if (accept('(')) {
                auto* call = arena_.make_expr<Call>(ExprKind::Call, place);
                call->callee = e;
                if (e->kind == ExprKind::Variable) call->name = static_cast<Variable*>(e)->name;
                call->arguments = arguments(')');
                e = call;
            } else if (accept('[')) {
                auto* index = arena_.make_expr<Index>(ExprKind::Index, place);
                index->of = e;
                index->at = expression();
                expect(']');
                e = index;
            } else if (accept('.')) {
                auto* member = arena_.make_expr<Member>(ExprKind::Member, place);
                member->of = e;
                member->name = expect_name("the name of a member").id;
                e = member;
            } else {
                return e;
            }
        }
    }

    Expr* literal(Value value)
    {
        auto* l = arena_.make_expr<Literal>(ExprKind::Literal, peek().place);
        l->value = std::move(value);
        ++at_;
        return l;
    }

    Expr* primary()
    {
        const Token& t = peek();
        switch (t.kind) {
            case Kind::Number:
                return literal(Value(t.number));
            case Kind::String:
                return literal(Value::string(text_.strings[t.id]));
            case Kind::True:
                return literal(Value(true));
            case Kind::False:
                return literal(Value(false));
            case Kind::Undef:
                return literal(Value());
            case Kind::Name:
                return name();
            default:
                break;
        }
        if (t.is('[')) return list_or_range();
        if (!accept('(')) unexpected("an expression");
        Expr* e = expression();
        expect(')');
        return e;
    }

    Expr* name()
    {
        const Token& t = peek();
        ++at_;
        if (names_.is_special(t.id)) {
            auto* s = arena_.make_expr<Special>(ExprKind::Special, t.place);
            s->name = t.id;
            return s;
        }
        auto* v = arena_.make_expr<Variable>(ExprKind::Variable, t.place);
        v->name = t.id;
        return v;
    }

    Expr* list_or_range()
    {
        const Place place = peek().place;
        expect('[');
        auto* list = arena_.make_expr<List>(ExprKind::List, place);
        while (accept(',')) {
        }
        if (accept(']')) return list;
        Expr* first = list_item();
        if (!is_comprehension(*first) && accept(':')) return range(place, first);
        add_item(*list, first);
        while (!accept(']')) {
            if (!accept(',')) unexpected("',' or ']'");
            while (accept(',')) {
            }
            if (accept(']')) break;
            add_item(*list, list_item());
        }
        return list;
    }

    static void add_item(List& list, Expr* item)
    {
        list.items.push_back(item);
        if (is_comprehension(*item)) list.plain = false;
    }

    Expr* range(const Place& place, Expr* first)
    {
        auto* r = arena_.make_expr<RangeExpr>(ExprKind::Range, place);
        r->begin = first;
        r->end = expression();
        r->step = nullptr;
        if (accept(':')) {
            r->step = r->end;
            r->end = expression();
        }
        expect(']');
        return r;
    }

    // An expression or a comprehension, the latter in brackets or not.
    Expr* list_item()
    {
        check_depth();
        const Place place = peek().place;
        switch (peek().kind) {
            case Kind::For:
                return for_item();
            case Kind::If:
                return if_item();
            case Kind::Each: {
                ++at_;
                auto* each = arena_.make_expr<Each>(ExprKind::Each, place);
                each->of = list_item();
                return each;
            }
            case Kind::Let: {
                ++at_;
                ++n_binders_;
                const std::size_t literals = n_literals_;
                auto* let = arena_.make_expr<Let>(ExprKind::Let, place);
                expect('(');
                let->bindings.pairs = pairs(')');
                let->body = list_item();
                let->bindings.own_frame = n_literals_ > literals;
                if (is_comprehension(*let->body)) let->kind = ExprKind::ListLet;
                return let;
            }
            default:
                break;
        }
        if (!next_is('(') || !bracketed_comprehension()) return expression();
        ++at_;
        Expr* item = list_item();
        expect(')');
        return item;
    }

    // Whether the brackets that open here hold a comprehension. `let` decides by what follows it.
    bool bracketed_comprehension() const
    {
        std::size_t i = at_;
        for (;;) {
            while (token(i).is('(')) ++i;
            switch (token(i).kind) {
                case Kind::For:
                case Kind::If:
                case Kind::Each:
                    return true;
                case Kind::Let:
                    break;
                default:
                    return false;
            }
            if (!token(++i).is('(')) return false;
            std::size_t depth = 0;
            do {
                if (token(i).is('(')) ++depth;
                if (token(i).is(')')) --depth;
                if (token(i).kind == Kind::End) return false;
                ++i;
            } while (depth > 0);
        }
    }
    const Token& token(std::size_t i) const
    {
        return text_.tokens[std::min(i, text_.tokens.size() - 1)];
    }

    Expr* for_item()
    {
        const Place place = peek().place;
        const std::size_t literals = n_literals_;
        ++n_binders_;
        ++at_;
        expect('(');
        std::vector<BindingPair> start;
        while (!next_is(')') && !next_is(';')) {
            if (accept(',')) continue;
            const Argument a = argument();
            BindingPair pair;
            pair.name = a.name;
            pair.value = a.value;
            pair.place = a.place;
            start.push_back(pair);
            if (!next_is(')') && !next_is(',') && !next_is(';')) unexpected("',', ';' or ')'");
        }
        if (accept(')')) {
            auto* f = arena_.make_expr<For>(ExprKind::For, place);
            f->bindings.pairs = std::move(start);
            f->body = list_item();
            f->bindings.own_frame = n_literals_ > literals;
            return f;
        }
        expect(';');
        auto* f = arena_.make_expr<CFor>(ExprKind::CFor, place);
        f->bindings.pairs = std::move(start);
        f->condition = expression();
        expect(';');
        f->updates = pairs(')');
        f->body = list_item();
        f->bindings.own_frame = n_literals_ > literals;
        return f;
    }

    Expr* if_item()
    {
        auto* i = arena_.make_expr<If>(ExprKind::If, peek().place);
        ++at_;
        expect('(');
        i->condition = expression();
        expect(')');
        i->yes = list_item();
        i->no = accept(Kind::Else) ? list_item() : nullptr;
        return i;
    }

    Shared& shared_;
    const Tokenizer& tokenizer_;
    const TokenText& text_;
    Arena& arena_;
    Names& names_;
    std::size_t at_ = 0;
    // Met so far; a difference between two counts says whether a piece of text holds any.
    std::size_t n_literals_ = 0;
    std::size_t n_binders_ = 0;
};

void parse_file(Shared& shared, FileScope& scope, const std::string& text)
{
    Tokenizer tokenizer(shared.loader, shared.program.names);
    tokenizer.open(
        fs::path(*shared.program.sources[scope.source].path).lexically_normal().string());
    tokenizer.add(text, scope.source, scope.folder);
    const TokenText tokens = tokenizer.take();
    Parser(shared, tokenizer, tokens).file(scope);
}

void parse_define(Shared& shared, Block& block, const std::string& name, const std::string& value)
{
    Sources& sources = shared.program.sources;
    const std::int32_t source = sources.add("-D " + name, "-D " + name);
    Tokenizer tokenizer(shared.loader, shared.program.names);
    tokenizer.add(name + "=" + value, source, "");
    const TokenText tokens = tokenizer.take();
    Parser(shared, tokenizer, tokens).define(block);
}

FileScope& add_file(Program& program, std::int32_t source, const std::string& folder)
{
    program.files.push_back(std::make_unique<FileScope>());
    program.files.back()->source = source;
    program.files.back()->folder = folder;
    return *program.files.back();
}

}  // namespace

void parse_program(Program& program, const std::string& text, const std::string& path,
                   const ParseOptions& options, Diagnostics& diagnostics)
{
    const fs::path model(path);
    Loader loader(program.sources, options.library_paths);
    loader.set_model_folder(model.parent_path().string());
    const std::int32_t source = program.sources.add(path, model.filename().string());
    Shared shared{program, diagnostics, loader, source};
    FileScope& main = add_file(program, source, model.parent_path().string());
    parse_file(shared, main, text);
    for (const auto& [name, value] : options.defines)
        parse_define(shared, main.scope.block, name, value);
    for (std::size_t i = 0; i < shared.to_read.size(); ++i) {
        current_progress().check();
        const Loader::Found found = shared.to_read[i];
        const std::int32_t used = program.sources.add(found.path, found.shown);
        FileScope& scope = add_file(program, used, found.folder);
        parse_file(shared, scope, loader.read(found, Place{used, 1, 1}));
    }
}

}  // namespace genus::language
