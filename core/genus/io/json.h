#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace genus::io {

class JsonValue;

/// A JSON text, checked as a whole and kept as a list of its values in order, 32 bytes each, with
/// the text beside: numbers and strings are converted when asked for.
class JsonText {
public:
    /// Throws TextFault at the first character against [rfc8259], and where values are nested
    /// deeper than 64. `text` must outlive this.
    explicit JsonText(std::string_view text);

    JsonValue root() const;

private:
    friend class JsonValue;
    friend class JsonParser;

    enum class Kind : std::uint8_t { null, boolean, number, string, array, object };
    struct Token {
        Kind kind;
        std::string_view text;  // of a string between its quotes
        std::uint32_t next;     // first token behind this value and all it holds
    };

    std::vector<Token> tokens_;
};

/// A value in a JsonText; the empty one stands for a value that is missing.
class JsonValue {
public:
    JsonValue() = default;

    explicit operator bool() const { return json_ != nullptr; }
    /// Where it stands; of the missing value, null.
    const char* at() const { return json_ ? token().text.data() : nullptr; }

    /// Member of an object; missing where there is none or this is no object. O(members).
    JsonValue operator[](std::string_view key) const;
    /// Values of an array; none where this is no array.
    std::vector<JsonValue> elements() const;

    /// Each throws TextFault where the value is of another kind or, for an index, is not a whole
    /// number from 0 up.
    double number() const;
    std::uint64_t index() const;
    bool boolean() const;
    /// Without escapes.
    std::string string() const;

private:
    friend class JsonText;
    JsonValue(const JsonText* json, std::uint32_t token) : json_(json), token_(token) {}
    const JsonText::Token& token() const { return json_->tokens_[token_]; }
    void expect(JsonText::Kind kind, const char* what) const;

    const JsonText* json_ = nullptr;
    std::uint32_t token_ = 0;
};

}  // namespace genus::io
