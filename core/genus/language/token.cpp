#include "genus/language/token.h"

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "genus/base/progress.h"
#include "genus/language/value.h"

namespace genus::language {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxTokens = 10'000'000;
constexpr std::uintmax_t kMaxFileBytes = 100u << 20;
constexpr std::size_t kMaxIncludeDepth = 500;

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}
bool is_hex_digit(char c)
{
    return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}
bool is_name_character(char c)
{
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

const std::unordered_map<std::string_view, Token::Kind>& keywords()
{
    using Kind = Token::Kind;
    static const std::unordered_map<std::string_view, Kind> map = {
        {"module", Kind::Module}, {"function", Kind::Function}, {"if", Kind::If},
        {"else", Kind::Else},     {"for", Kind::For},           {"let", Kind::Let},
        {"assert", Kind::Assert}, {"echo", Kind::Echo},         {"each", Kind::Each},
        {"true", Kind::True},     {"false", Kind::False},       {"undef", Kind::Undef}};
    return map;
}

}  // namespace

Names::Id Names::intern(std::string_view text)
{
    const auto [at, added] = ids_.try_emplace(std::string(text), static_cast<Id>(texts_.size()));
    if (added) texts_.push_back(&at->first);
    return at->second;
}

Loader::Loader(Sources& sources, std::vector<std::string> library_paths)
    : sources_(sources), library_paths_(std::move(library_paths))
{
}

Loader::Found Loader::find(const std::string& name, const std::string& folder,
                           const Place& place) const
{
    const auto usable = [&](const fs::path& path) {
        std::error_code error;
        return fs::is_regular_file(path, error);
    };
    const fs::path wanted(name);
    std::vector<fs::path> candidates;
    if (wanted.is_absolute()) {
        candidates.push_back(wanted);
    } else {
        candidates.push_back(fs::path(folder) / wanted);
        for (const std::string& library : library_paths_)
            candidates.push_back(fs::path(library) / wanted);
    }
    for (const fs::path& candidate : candidates) {
        if (!usable(candidate)) continue;
        const fs::path path = candidate.lexically_normal();
        std::error_code error;
        const fs::path base = model_folder_.empty() ? fs::path(".") : fs::path(model_folder_);
        std::string shown = fs::proximate(path, base, error).string();
        if (error || shown.empty()) shown = path.string();
        return {path.string(), shown, path.parent_path().string()};
    }
    fail(sources_, place, "file '" + name + "' not found");
}

std::string Loader::read(const Found& found, const Place& place) const
{
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(found.path, error);
    if (error) fail(sources_, place, "cannot read '" + found.path + "': " + error.message());
    if (bytes > kMaxFileBytes) fail(sources_, place, "'" + found.path + "' is larger than 100 MB");
    std::ifstream in(found.path, std::ios::binary);
    std::string text(static_cast<std::size_t>(bytes), '\0');
    in.read(text.data(), static_cast<std::streamsize>(bytes));
    if (in.bad() || !in.is_open()) fail(sources_, place, "cannot read '" + found.path + "'");
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
}

/// Walks through one file.
class Scanner {
public:
    Scanner(Tokenizer& owner, std::string_view text, std::int32_t file, const std::string& folder)
        : owner_(owner), text_(text), file_(file), folder_(folder)
    {
    }

    void run()
    {
        if (text_.substr(0, 3) == "\xef\xbb\xbf") at_ = line_start_ = 3;
        while (skip_blanks()) token();
    }

    Place place() const
    {
        return {
            file_, line_,
            static_cast<std::int32_t>(std::min<std::size_t>(at_ - line_start_ + 1, 1'000'000'000))};
    }

private:
    char peek(std::size_t ahead = 0) const
    {
        return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
    }
    [[noreturn]] void fail_at(const Place& where, const std::string& problem) const
    {
        fail(owner_.loader_.sources(), where, problem);
    }
    void newline(std::size_t at)
    {
        ++line_;
        line_start_ = at + 1;
    }

    bool skip_blanks()
    {
        for (;;) {
            if (at_ >= text_.size()) return false;
            const char c = text_[at_];
            if (c == '\n') newline(at_);
            if (is_space(c))
                ++at_;
            else if (c == '\xc2' && peek(1) == '\xa0')  // no-break space
                at_ += 2;
            else if (c == '\xa0')  // the same in Latin-1
                at_ += 1;
            else if (c == '/' && peek(1) == '/')
                at_ = std::min(text_.find('\n', at_), text_.size());
            else if (c == '/' && peek(1) == '*')
                block_comment();
            else
                return true;
        }
    }

    void block_comment()
    {
        const Place start = place();
        const std::size_t end = text_.find("*/", at_ + 2);
        if (end == std::string_view::npos) fail_at(start, "comment is not closed");
        for (std::size_t i = at_; i < end; ++i)
            if (text_[i] == '\n') newline(i);
        at_ = end + 2;
    }

    void push(Token token)
    {
        if (owner_.out_.tokens.size() >= kMaxTokens)
            fail_at(token.place, "the model has more than 10 million tokens");
        if (owner_.out_.tokens.size() % 4096 == 0) current_progress().check();
        owner_.out_.tokens.push_back(token);
    }

    void token()
    {
        const char c = peek();
        if (c == '"')
            string();
        else if (is_digit(c) || (c == '.' && is_digit(peek(1))))
            number_or_name();
        else if (is_name_character(c) || (c == '$' && is_name_character(peek(1))))
            name();
        else
            symbol();
    }

    std::size_t name_length() const
    {
        std::size_t n = peek() == '$' ? 1 : 0;
        while (is_name_character(peek(n))) ++n;
        return n;
    }

    // Length of the number that starts here: 12, 12., 1.5, .5, each with an exponent.
    std::size_t number_length() const
    {
        std::size_t n = 0;
        while (is_digit(peek(n))) ++n;
        if (peek(n) == '.') {
            ++n;
            while (is_digit(peek(n))) ++n;
        }
        if (peek(n) != 'e' && peek(n) != 'E') return n;
        std::size_t e = n + 1;
        if (peek(e) == '+' || peek(e) == '-') ++e;
        if (!is_digit(peek(e))) return n;
        while (is_digit(peek(e))) ++e;
        return e;
    }

    bool is_hex(std::string_view word) const
    {
        if (word.size() < 3 || word[0] != '0' || (word[1] != 'x' && word[1] != 'X')) return false;
        for (const char c : word.substr(2))
            if (!is_hex_digit(c)) return false;
        return true;
    }

    // A name may start with digits; the longer reading wins.
    void number_or_name()
    {
        Token t;
        t.kind = Token::Kind::Number;
        t.place = place();
        const std::size_t digits = number_length();
        const std::size_t letters = name_length();
        const std::string_view word = text_.substr(at_, letters);
        if (is_hex(word)) {
            for (const char c : word.substr(2)) t.number = t.number * 16 + hex_value(c);
            at_ += letters;
        } else if (letters > digits) {
            name();
            return;
        } else {
            t.number = number(text_.substr(at_, digits));
            at_ += digits;
        }
        push(t);
    }

    static int hex_value(char c) { return is_digit(c) ? c - '0' : (c | 0x20) - 'a' + 10; }

    static double number(std::string_view word)
    {
        double value = 0.0;
        const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
        if (result.ec != std::errc::result_out_of_range) return value;
        // Too large or too small: infinity or zero, as the exponent says.
        return std::strtod(std::string(word).c_str(), nullptr);
    }

    void name()
    {
        Token t;
        t.place = place();
        const std::string_view word = text_.substr(at_, name_length());
        at_ += word.size();
        if ((word == "include" || word == "use") && file_name(word == "use", t.place)) return;
        const auto keyword = keywords().find(word);
        t.kind = keyword == keywords().end() ? Token::Kind::Name : keyword->second;
        t.id = owner_.names_.intern(word);
        push(t);
    }

    // The "<file>" after `use` and `include`; false if none follows.
    bool file_name(bool use, const Place& where)
    {
        std::size_t open = at_;
        while (open < text_.size() && is_space(text_[open])) ++open;
        if (open >= text_.size() || text_[open] != '<') return false;
        const std::size_t close = text_.find_first_of(">\n", open);
        if (close == std::string_view::npos || text_[close] == '\n')
            fail_at(where, "the file name after '<' is not closed by '>'");
        const std::string file(text_.substr(open + 1, close - open - 1));
        for (std::size_t i = at_; i < close; ++i)
            if (text_[i] == '\n') newline(i);
        at_ = close + 1;
        if (use)
            push_use(file, where);
        else
            include(file, where);
        return true;
    }

    void push_use(const std::string& file, const Place& where)
    {
        Token t;
        t.kind = Token::Kind::Use;
        t.place = where;
        t.id = add_string(file);
        push(t);
    }

    std::uint32_t add_string(std::string text)
    {
        owner_.out_.strings.push_back(std::move(text));
        owner_.folders_.push_back(folder_);
        return static_cast<std::uint32_t>(owner_.out_.strings.size()) - 1;
    }

    void include(const std::string& file, const Place& where)
    {
        const Loader::Found found = owner_.loader_.find(file, folder_, where);
        for (const std::string& open : owner_.open_)
            if (open == found.path) fail_at(where, "'" + file + "' includes itself");
        if (owner_.open_.size() >= kMaxIncludeDepth) fail_at(where, "includes nested too deeply");
        const std::string text = owner_.loader_.read(found, where);
        const std::int32_t number = owner_.loader_.sources().add(found.path, found.shown);
        owner_.open_.push_back(found.path);
        owner_.add(text, number, found.folder);
        owner_.open_.pop_back();
    }

    void string()
    {
        Token t;
        t.kind = Token::Kind::String;
        t.place = place();
        ++at_;
        std::string out;
        for (;;) {
            if (at_ >= text_.size()) fail_at(t.place, "string is not closed");
            const char c = text_[at_++];
            if (c == '"') break;
            if (c == '\n') newline(at_ - 1);
            if (c == '\\')
                escape(out);
            else
                out += c;
        }
        t.id = add_string(std::move(out));
        push(t);
    }

    // After a backslash. One that starts no escape is dropped.
    void escape(std::string& out)
    {
        const char c = peek();
        switch (c) {
            case 'n':
                out += '\n';
                break;
            case 't':
                out += '\t';
                break;
            case 'r':
                out += '\r';
                break;
            case '\\':
                out += '\\';
                break;
            case '"':
                out += '"';
                break;
            case 'x':
                if (peek(1) < '0' || peek(1) > '7' || !is_hex_digit(peek(2))) return;
                code_point(out, 2);
                return;
            case 'u':
                code_point(out, 4);
                return;
            case 'U':
                code_point(out, 6);
                return;
            default:
                return;
        }
        ++at_;
    }

    void code_point(std::string& out, std::size_t digits)
    {
        std::uint32_t code = 0;
        for (std::size_t i = 1; i <= digits; ++i) {
            if (!is_hex_digit(peek(i))) return;
            code = code * 16 + static_cast<std::uint32_t>(hex_value(peek(i)));
        }
        at_ += digits + 1;
        out += code == 0 ? " " : encode_character(code);
    }

    void symbol()
    {
        using Kind = Token::Kind;
        Token t;
        t.place = place();
        const std::string_view two = text_.substr(at_, 2);
        const Kind kind = two == "<="   ? Kind::LessEqual
                          : two == ">=" ? Kind::GreaterEqual
                          : two == "==" ? Kind::Equal
                          : two == "!=" ? Kind::NotEqual
                          : two == "&&" ? Kind::And
                          : two == "||" ? Kind::Or
                                        : Kind::Character;
        t.kind = kind;
        if (kind == Kind::Character) {
            const char c = peek();
            if (std::string_view("+-*/%^!?:;,.=<>()[]{}#$").find(c) == std::string_view::npos)
                fail_at(t.place, "unexpected character " + describe(c));
            t.id = static_cast<unsigned char>(c);
            at_ += 1;
        } else {
            at_ += 2;
        }
        push(t);
    }

    std::string describe(char c) const
    {
        const auto byte = static_cast<unsigned char>(c);
        if (byte > 0x20 && byte < 0x7f) return std::string("'") + c + "'";
        const std::size_t bytes = character_bytes(text_, at_);
        if (bytes > 1) return "'" + std::string(text_.substr(at_, bytes)) + "'";
        static const char* digits = "0123456789abcdef";
        return std::string("with code 0x") + digits[byte >> 4] + digits[byte & 15];
    }

    Tokenizer& owner_;
    std::string_view text_;
    std::int32_t file_;
    const std::string& folder_;
    std::size_t at_ = 0;
    std::int32_t line_ = 1;
    std::size_t line_start_ = 0;

    friend class Tokenizer;
};

void Tokenizer::add(std::string_view text, std::int32_t file, const std::string& folder)
{
    Scanner scanner(*this, text, file, folder);
    scanner.run();
    last_.place = scanner.place();
}

TokenText Tokenizer::take()
{
    last_.kind = Token::Kind::End;
    out_.tokens.push_back(last_);
    return std::move(out_);
}

}  // namespace genus::language
