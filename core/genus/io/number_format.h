#pragma once

#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace genus::io {

/// No number written here needs more characters.
constexpr std::size_t kNumberChars = 32;

/// Writes the shortest decimal text that reads back as `value`; returns the place behind it.
/// Needs kNumberChars of room.
inline char* put_number(char* p, double value)
{
    return std::to_chars(p, p + kNumberChars, value).ptr;
}

/// Six significant digits.
inline char* put_short_number(char* p, double value)
{
    return std::to_chars(p, p + kNumberChars, value, std::chars_format::general, 6).ptr;
}

inline char* put_integer(char* p, std::int64_t value)
{
    return std::to_chars(p, p + kNumberChars, value).ptr;
}

inline char* put_text(char* p, std::string_view text)
{
    std::memcpy(p, text.data(), text.size());
    return p + text.size();
}

}  // namespace genus::io
