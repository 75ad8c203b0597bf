#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace genus::language {

struct FunctionDefinition;
struct Frame;

/// What lies on the heap behind a value. Counted without locks: values belong to one thread.
struct Object {
    enum class Type : std::uint8_t { String, List, Range, Function, Frame };
    std::uint32_t references = 1;
    Type type;
};

struct StringObject : Object {
    std::uint32_t bytes;
    std::uint32_t characters;  // equal to `bytes` where all are ASCII

    const char* data() const { return reinterpret_cast<const char*>(this + 1); }
    char* data() { return reinterpret_cast<char*>(this + 1); }
    std::string_view view() const { return {data(), bytes}; }
};

struct RangeObject : Object {
    double begin, step, end;
};

struct FunctionObject : Object {
    const FunctionDefinition* definition;
    Frame* frame;  // where it was made; counted
};

class Value;

struct alignas(8) ListObject : Object {  // the values follow it
    std::uint32_t size;

    const Value* data() const { return reinterpret_cast<const Value*>(this + 1); }
    Value* data() { return reinterpret_cast<Value*>(this + 1); }
};

/// Frees an object whose count fell to zero, and what only it held, without recursion.
void destroy(Object* object);

/// Limits on the memory that values may hold, for programs that would eat all of it. Counted for
/// the current thread.
struct OutOfValueMemory {};
void set_value_memory_limit(std::size_t bytes);
std::size_t value_memory();
/// Adds to the count; throws OutOfValueMemory above the limit.
void charge_value_memory(std::size_t bytes);
void release_value_memory(std::size_t bytes) noexcept;

/// A value of the text language: 16 bytes, cheap to copy. `Unset` is no value: the mark of a
/// variable that has none yet.
class Value {
public:
    enum class Tag : std::uint8_t { Unset, Undef, Bool, Number, String, List, Range, Function };

    Value() noexcept : tag_(Tag::Undef), bits_(0) {}
    Value(bool b) noexcept : tag_(Tag::Bool), bits_(b) {}
    Value(double n) noexcept : tag_(Tag::Number) { std::memcpy(&bits_, &n, sizeof n); }
    Value(const Value& o) noexcept : tag_(o.tag_), bits_(o.bits_)
    {
        if (is_heap()) ++object()->references;
    }
    Value(Value&& o) noexcept : tag_(o.tag_), bits_(o.bits_) { o.tag_ = Tag::Undef; }
    template <typename T>
    Value(T*) = delete;
    template <typename T>
    Value(const T*) = delete;

    Value& operator=(const Value& o) noexcept
    {
        if (o.is_heap()) ++o.object()->references;
        release();
        tag_ = o.tag_;
        bits_ = o.bits_;
        return *this;
    }
    Value& operator=(Value&& o) noexcept
    {
        std::swap(tag_, o.tag_);
        std::swap(bits_, o.bits_);
        return *this;
    }
    ~Value() { release(); }

    static Value unset() noexcept
    {
        Value v;
        v.tag_ = Tag::Unset;
        return v;
    }
    static Value string(std::string_view text);
    static Value range(double begin, double step, double end);
    /// Takes over one count of `frame`.
    static Value function(const FunctionDefinition* definition, Frame* frame);
    static Value list(std::vector<Value>&& items);
    static Value list(std::span<const Value> items);
    /// Of numbers.
    static Value numbers(std::span<const double> items);

    Tag tag() const { return tag_; }
    bool is_unset() const { return tag_ == Tag::Unset; }
    bool is_undef() const { return tag_ == Tag::Undef; }
    bool is_bool() const { return tag_ == Tag::Bool; }
    bool is_number() const { return tag_ == Tag::Number; }
    bool is_string() const { return tag_ == Tag::String; }
    bool is_list() const { return tag_ == Tag::List; }
    bool is_range() const { return tag_ == Tag::Range; }
    bool is_function() const { return tag_ == Tag::Function; }

    // Each only for a value of its kind.
    bool as_bool() const { return bits_ != 0; }
    double as_number() const
    {
        double n;
        std::memcpy(&n, &bits_, sizeof n);
        return n;
    }
    std::string_view as_string() const { return string_object().view(); }
    const StringObject& string_object() const { return *static_cast<StringObject*>(object()); }
    std::span<const Value> items() const
    {
        const auto* list = static_cast<ListObject*>(object());
        return {list->data(), list->size};
    }
    const RangeObject& as_range() const { return *static_cast<RangeObject*>(object()); }
    const FunctionObject& as_function() const { return *static_cast<FunctionObject*>(object()); }

    /// Whether conditions take it for true.
    bool truthy() const;
    /// "number", "vector", ..., as warnings name it.
    const char* type_name() const;

    /// The object, given up by this value, which becomes undef; null where there is none.
    Object* release_object() noexcept
    {
        Object* o = is_heap() ? object() : nullptr;
        tag_ = Tag::Undef;
        return o;
    }

private:
    Value(Tag tag, Object* o) noexcept : tag_(tag), bits_(reinterpret_cast<std::uintptr_t>(o)) {}

    bool is_heap() const { return tag_ >= Tag::String; }
    Object* object() const { return reinterpret_cast<Object*>(static_cast<std::uintptr_t>(bits_)); }
    void release() noexcept
    {
        if (is_heap() && --object()->references == 0) destroy(object());
    }

    Tag tag_;
    std::uint64_t bits_;
};
static_assert(sizeof(Value) == 16);
static_assert(sizeof(ListObject) % alignof(Value) == 0);

/// Equal as `==` sees it: values of different kinds are not.
bool equal(const Value& a, const Value& b);

/// Number of values a range runs through; 0 if none, the largest 32-bit number if endless.
std::uint32_t range_size(const RangeObject& range);
/// The value at that place of the range.
inline double range_value(const RangeObject& range, std::uint32_t i)
{
    return i == 0 ? range.begin : range.begin + i * range.step;
}
/// The order of two ranges, by the values they run through: negative, zero or positive.
int compare_ranges(const RangeObject& a, const RangeObject& b);

/// Bytes of the character that starts at `text[at]`, at least 1 and within the text.
std::size_t character_bytes(std::string_view text, std::size_t at);
/// Number of characters of UTF-8 text; stray bytes count as one each.
std::size_t count_characters(std::string_view text);
/// The code point of one character as `character_bytes` cuts them.
std::uint32_t decode_character(std::string_view character);
/// The code point in UTF-8; empty if it is none.
std::string encode_character(std::uint32_t code);

/// Calls f(character as string_view) for each character.
template <typename F>
void for_each_character(std::string_view text, F&& f)
{
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t bytes = character_bytes(text, at);
        f(text.substr(at, bytes));
        at += bytes;
    }
}

}  // namespace genus::language
