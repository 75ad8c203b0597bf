#include "genus/io/json.h"

#include <limits>

#include "genus/io/text.h"

namespace genus::io {

namespace {

constexpr int kMaxDepth = 64;

bool is_hex(char c)
{
    return is_digit(c) || (to_lower(c) >= 'a' && to_lower(c) <= 'f');
}

std::uint32_t hex_value(std::string_view four)
{
    std::uint32_t value = 0;
    for (const char c : four)
        value =
            16 * value + static_cast<std::uint32_t>(is_digit(c) ? c - '0' : to_lower(c) - 'a' + 10);
    return value;
}

void append_utf8(std::string& text, std::uint32_t code)
{
    const auto put = [&](std::uint32_t byte) { text.push_back(static_cast<char>(byte)); };
    if (code < 0x80) {
        put(code);
    } else if (code < 0x800) {
        put(0xC0 | code >> 6);
        put(0x80 | (code & 0x3F));
    } else if (code < 0x10000) {
        put(0xE0 | code >> 12);
        put(0x80 | (code >> 6 & 0x3F));
        put(0x80 | (code & 0x3F));
    } else {
        put(0xF0 | code >> 18);
        put(0x80 | (code >> 12 & 0x3F));
        put(0x80 | (code >> 6 & 0x3F));
        put(0x80 | (code & 0x3F));
    }
}

bool is_surrogate(std::uint32_t code)
{
    return code >= 0xD800 && code < 0xE000;
}

char control_character(char letter)
{
    switch (letter) {
        case 'b':
            return '\b';
        case 'f':
            return '\f';
        case 'n':
            return '\n';
        case 'r':
            return '\r';
        case 't':
            return '\t';
        default:
            return letter;  // quote, slash, backslash
    }
}

}  // namespace

class JsonParser {
public:
    JsonParser(std::string_view text, std::vector<JsonText::Token>& tokens)
        : p_(text.data()), end_(p_ + text.size()), tokens_(tokens)
    {
    }

    void parse()
    {
        read_value(0);
        skip_space();
        if (p_ != end_) fail("unexpected " + shown_word(p_, end_) + " behind the JSON text");
    }

private:
    using Kind = JsonText::Kind;

    [[noreturn]] void fail(const std::string& problem) const { throw TextFault{p_, problem}; }

    void skip_space()
    {
        while (p_ != end_ && (*p_ == ' ' || *p_ == '\t' || is_newline(*p_))) ++p_;
    }
    char next()
    {
        skip_space();
        if (p_ == end_) fail("the JSON text ends too soon");
        return *p_;
    }
    void expect(char c)
    {
        if (next() != c) fail(std::string("expected ") + c + ", found " + shown_word(p_, end_));
        ++p_;
    }

    void read_value(int depth)
    {
        if (depth > kMaxDepth) fail("JSON values nested too deeply");
        if (tokens_.size() >= std::numeric_limits<std::uint32_t>::max())
            fail("too many JSON values");
        const char first = next();
        const std::size_t token = tokens_.size();
        const char* start = p_;
        tokens_.push_back({Kind::null, {}, 0});
        if (first == '{')
            read_object(depth);
        else if (first == '[')
            read_array(depth);
        else if (first == '"')
            read_string();
        else if (first == '-' || is_digit(first))
            read_number();
        else
            read_word();
        const bool quoted = first == '"';
        JsonText::Token& read = tokens_[token];
        read.kind = kind_of(first);
        read.text = quoted ? std::string_view(start + 1, p_ - 1) : std::string_view(start, p_);
        read.next = static_cast<std::uint32_t>(tokens_.size());
    }

    static Kind kind_of(char first)
    {
        switch (first) {
            case '{':
                return Kind::object;
            case '[':
                return Kind::array;
            case '"':
                return Kind::string;
            case 't':
            case 'f':
                return Kind::boolean;
            case 'n':
                return Kind::null;
            default:
                return Kind::number;
        }
    }

    void read_object(int depth)
    {
        ++p_;
        if (next() == '}') {
            ++p_;
            return;
        }
        while (true) {
            if (next() != '"') fail("expected the name of a member");
            read_value(depth + 1);
            expect(':');
            read_value(depth + 1);
            if (next() == ',')
                ++p_;
            else
                break;
        }
        expect('}');
    }

    void read_array(int depth)
    {
        ++p_;
        if (next() == ']') {
            ++p_;
            return;
        }
        read_value(depth + 1);
        while (next() == ',') {
            ++p_;
            read_value(depth + 1);
        }
        expect(']');
    }

    void read_string()
    {
        ++p_;
        while (true) {
            if (p_ == end_) fail("a JSON string without end");
            if (*p_ == '"') break;
            if (static_cast<unsigned char>(*p_) < 0x20)
                fail("a control character in a JSON string");
            if (*p_ == '\\') read_escape();
            ++p_;
        }
        ++p_;
    }

    // Leaves p_ at the last character of the escape.
    void read_escape()
    {
        constexpr std::string_view letters = "\"\\/bfnrtu";
        ++p_;
        if (p_ == end_ || letters.find(*p_) == std::string_view::npos) fail("a wrong JSON escape");
        if (*p_ != 'u') return;
        for (int i = 0; i < 4; ++i) {
            ++p_;
            if (p_ == end_ || !is_hex(*p_)) fail("a wrong JSON escape");
        }
    }

    void read_digits()
    {
        if (p_ == end_ || !is_digit(*p_)) fail("a digit is missing in a JSON number");
        while (p_ != end_ && is_digit(*p_)) ++p_;
    }

    void read_number()
    {
        if (*p_ == '-') ++p_;
        if (p_ != end_ && *p_ == '0')
            ++p_;
        else
            read_digits();
        if (p_ != end_ && *p_ == '.') {
            ++p_;
            read_digits();
        }
        if (p_ != end_ && (*p_ == 'e' || *p_ == 'E')) {
            ++p_;
            if (p_ != end_ && (*p_ == '-' || *p_ == '+')) ++p_;
            read_digits();
        }
    }

    void read_word()
    {
        const std::string_view rest(p_, end_);
        for (const std::string_view word : {"true", "false", "null"}) {
            if (!rest.starts_with(word)) continue;
            p_ += word.size();
            return;
        }
        fail(shown_word(p_, end_) + " is not a JSON value");
    }

    const char* p_;
    const char* end_;
    std::vector<JsonText::Token>& tokens_;
};

JsonText::JsonText(std::string_view text)
{
    JsonParser(text, tokens_).parse();
}

JsonValue JsonText::root() const
{
    return {this, 0};
}

JsonValue JsonValue::operator[](std::string_view key) const
{
    if (json_ == nullptr || token().kind != JsonText::Kind::object) return {};
    for (std::uint32_t i = token_ + 1; i < token().next;) {
        const std::uint32_t value = i + 1;  // a name holds nothing
        if (json_->tokens_[i].text == key) return {json_, value};
        i = json_->tokens_[value].next;
    }
    return {};
}

std::vector<JsonValue> JsonValue::elements() const
{
    std::vector<JsonValue> values;
    if (json_ == nullptr || token().kind != JsonText::Kind::array) return values;
    for (std::uint32_t i = token_ + 1; i < token().next; i = json_->tokens_[i].next)
        values.push_back({json_, i});
    return values;
}

void JsonValue::expect(JsonText::Kind kind, const char* what) const
{
    if (token().kind != kind)
        throw TextFault{at(), std::string("expected ") + what + ", found " +
                                  shown_word(at(), at() + token().text.size())};
}

double JsonValue::number() const
{
    expect(JsonText::Kind::number, "a number");
    double value = 0.0;
    parse_number(at(), at() + token().text.size(), value);
    return value;
}

std::uint64_t JsonValue::index() const
{
    constexpr double most = 9007199254740992.0;  // up to here doubles hold every whole number
    const double value = number();
    if (!(value >= 0.0 && value <= most &&
          value == static_cast<double>(static_cast<std::uint64_t>(value))))
        throw TextFault{at(), "expected a whole number from 0 up, found " +
                                  shown_word(at(), at() + token().text.size())};
    return static_cast<std::uint64_t>(value);
}

bool JsonValue::boolean() const
{
    expect(JsonText::Kind::boolean, "true or false");
    return token().text == "true";
}

std::string JsonValue::string() const
{
    expect(JsonText::Kind::string, "a string");
    const std::string_view raw = token().text;
    std::string text;
    for (std::size_t i = 0; i < raw.size(); ++i) {
        if (raw[i] != '\\') {
            text.push_back(raw[i]);
            continue;
        }
        if (raw[++i] != 'u') {
            text.push_back(control_character(raw[i]));
            continue;
        }
        std::uint32_t code = hex_value(raw.substr(i + 1, 4));
        i += 4;
        // Two escapes make one character beyond 16 bits; half of such a pair is none.
        if (is_surrogate(code) && code < 0xDC00 && raw.substr(i + 1, 2) == "\\u") {
            const std::uint32_t low = hex_value(raw.substr(i + 3, 4));
            if (low >= 0xDC00 && low < 0xE000) {
                code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
                i += 6;
            }
        }
        append_utf8(text, is_surrogate(code) ? 0xFFFD : code);
    }
    return text;
}

}  // namespace genus::io
