#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "genus/base/error.h"

namespace genus::io {

/// A mistake in a text at character `at`; `with_lines` turns it into a FileError with its line.
struct TextFault {
    const char* at;
    std::string problem;
};

/// The bytes as characters, less the mark that some editors put before UTF-8.
inline std::string_view as_text(std::span<const std::byte> bytes)
{
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    return text;
}

constexpr bool is_digit(char c)
{
    return static_cast<unsigned char>(c - '0') < 10;
}
constexpr bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}
constexpr bool is_newline(char c)
{
    return c == '\n' || c == '\r';
}
constexpr bool is_space(char c)
{
    return is_blank(c) || is_newline(c);
}
constexpr char to_lower(char c)
{
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
}

/// Number of the line, from 1, in which `at` stands. Lines end with LF, CR LF, or, in a text
/// without any LF, CR.
std::int64_t line_number(std::string_view text, const char* at);

/// The first word that is not in a comment after '#'; empty where there is none.
std::string_view first_word(std::string_view text);

/// The word at `p` as it can be shown in a message: in quotes, cut short, without control
/// characters.
std::string shown_word(const char* p, const char* end);

/// Runs `body`, which reads `text`, and gives its mistakes a line of the file `name`.
template <class Body>
auto with_lines(std::string_view text, const std::string& name, const Body& body)
{
    try {
        return body();
    } catch (const TextFault& fault) {
        throw FileError(name, fault.problem, FileError::at_line(line_number(text, fault.at)));
    }
}

/// Reads a decimal number at `p`: digits with an optional sign, point and exponent, rounded to the
/// nearest double. Returns the first character after it. Throws TextFault where there is none, or
/// where it is not finite: nan, inf, 1e999.
///
/// Up to 19 significant digits with small exponents are converted by one exactly rounded
/// operation [clinger1990] or by an integer division whose remainder decides the rounding;
/// anything else is left to std::from_chars.
const char* parse_number(const char* p, const char* end, double& value);

/// Reads a decimal integer of at most 18 digits with an optional sign.
const char* parse_integer(const char* p, const char* end, std::int64_t& value);

/// A place in a text with words separated by white space, and comments from '#' to the end of
/// the line.
struct TextCursor {
    const char* p;
    const char* end;

    explicit TextCursor(std::string_view text) : p(text.data()), end(text.data() + text.size()) {}

    bool at_end() const { return p == end; }
    /// Stops at the end of the line, too.
    bool at_line_end() const { return p == end || is_newline(*p) || *p == '#'; }

    void skip_blanks()
    {
        while (p != end && is_blank(*p)) ++p;
    }
    void skip_comment()
    {
        while (p != end && !is_newline(*p)) ++p;
    }
    /// To the next word, over ends of lines and comments.
    void skip_space()
    {
        while (p != end) {
            if (is_space(*p))
                ++p;
            else if (*p == '#')
                skip_comment();
            else
                break;
        }
    }
    void skip_word()
    {
        while (p != end && !is_space(*p)) ++p;
    }
    std::string_view word()
    {
        skip_space();
        const char* start = p;
        skip_word();
        return {start, static_cast<std::size_t>(p - start)};
    }
    /// `what` is named in the message where the text ends.
    double number(const char* what)
    {
        need(what);
        double value = 0.0;
        p = parse_number(p, end, value);
        end_of_word();
        return value;
    }
    std::int64_t integer(const char* what)
    {
        need(what);
        std::int64_t value = 0;
        p = parse_integer(p, end, value);
        end_of_word();
        return value;
    }

private:
    void need(const char* what)
    {
        skip_space();
        if (p == end) throw TextFault{p, std::string("the file ends before ") + what};
    }
    void end_of_word() const
    {
        if (p != end && !is_space(*p) && *p != '#')
            throw TextFault{p, "unexpected " + shown_word(p, end) + " after a number"};
    }
};

}  // namespace genus::io
