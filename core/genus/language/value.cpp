#include "genus/language/value.h"

#include <cmath>
#include <limits>
#include <new>

#include "genus/language/frame.h"
#include "genus/language/stack.h"

namespace genus::language {

namespace {

struct Memory {
    std::size_t used = 0;
    std::size_t limit = std::numeric_limits<std::size_t>::max();
};
thread_local Memory t_memory;

// Objects whose count fell to zero while another was being destroyed.
thread_local std::vector<Object*>* t_doomed = nullptr;

std::size_t bytes_of(const StringObject& s)
{
    return sizeof(StringObject) + s.bytes;
}
std::size_t bytes_of(const ListObject& l)
{
    return sizeof(ListObject) + l.size * sizeof(Value);
}

template <typename T>
T* allocate(std::size_t bytes, Object::Type type)
{
    charge_value_memory(bytes);
    auto* object = static_cast<T*>(std::malloc(bytes));
    if (!object) {
        release_value_memory(bytes);
        throw std::bad_alloc();
    }
    object->references = 1;
    object->type = type;
    return object;
}

void deallocate(void* object, std::size_t bytes) noexcept
{
    release_value_memory(bytes);
    std::free(object);
}

void drop(Object* object, std::vector<Object*>& doomed)
{
    if (object && --object->references == 0) doomed.push_back(object);
}

void drop_slots(std::span<Value> values, std::vector<Object*>& doomed)
{
    for (Value& v : values) drop(v.release_object(), doomed);
}

void destroy_one(Object* object, std::vector<Object*>& doomed)
{
    switch (object->type) {
        case Object::Type::String:
            deallocate(object, bytes_of(*static_cast<StringObject*>(object)));
            return;
        case Object::Type::Range:
            deallocate(object, sizeof(RangeObject));
            return;
        case Object::Type::List: {
            auto* list = static_cast<ListObject*>(object);
            drop_slots({list->data(), list->size}, doomed);
            deallocate(list, bytes_of(*list));
            return;
        }
        case Object::Type::Function:
            drop(static_cast<FunctionObject*>(object)->frame, doomed);
            deallocate(object, sizeof(FunctionObject));
            return;
        case Object::Type::Frame: {
            auto* frame = static_cast<Frame*>(object);
            drop_slots({frame->slots(), frame->n_slots}, doomed);
            drop(frame->parent, doomed);
            free_frame(frame);
            return;
        }
    }
}

// Only numbers, booleans and the like: nothing further to drop.
bool holds_no_objects(const ListObject& list)
{
    const Value* v = list.data();
    for (std::uint32_t i = 0; i < list.size; ++i)
        if (v[i].tag() >= Value::Tag::String) return false;
    return true;
}

bool same_items(std::span<const Value> a, std::span<const Value> b)
{
    check_stack();
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!equal(a[i], b[i])) return false;
    return true;
}

}  // namespace

void set_value_memory_limit(std::size_t bytes)
{
    t_memory.limit = bytes;
}

std::size_t value_memory()
{
    return t_memory.used;
}

void charge_value_memory(std::size_t bytes)
{
    if (t_memory.used + bytes > t_memory.limit) throw OutOfValueMemory();
    t_memory.used += bytes;
}

void release_value_memory(std::size_t bytes) noexcept
{
    t_memory.used -= bytes;
}

void destroy(Object* object)
{
    if (object->type == Object::Type::List) {
        auto* list = static_cast<ListObject*>(object);
        if (holds_no_objects(*list)) {
            deallocate(list, bytes_of(*list));
            return;
        }
    }
    if (t_doomed) {
        t_doomed->push_back(object);
        return;
    }
    thread_local std::vector<Object*> doomed;
    t_doomed = &doomed;
    destroy_one(object, doomed);
    while (!doomed.empty()) {
        Object* next = doomed.back();
        doomed.pop_back();
        destroy_one(next, doomed);
    }
    t_doomed = nullptr;
}

Value Value::string(std::string_view text)
{
    if (text.size() > std::numeric_limits<std::uint32_t>::max() / 2) throw OutOfValueMemory();
    auto* s = allocate<StringObject>(sizeof(StringObject) + text.size(), Object::Type::String);
    s->bytes = static_cast<std::uint32_t>(text.size());
    s->characters = static_cast<std::uint32_t>(count_characters(text));
    if (!text.empty()) std::memcpy(s->data(), text.data(), text.size());
    return Value(Tag::String, s);
}

Value Value::range(double begin, double step, double end)
{
    auto* r = allocate<RangeObject>(sizeof(RangeObject), Object::Type::Range);
    r->begin = begin;
    r->step = step;
    r->end = end;
    return Value(Tag::Range, r);
}

Value Value::function(const FunctionDefinition* definition, Frame* frame)
{
    auto* f = allocate<FunctionObject>(sizeof(FunctionObject), Object::Type::Function);
    f->definition = definition;
    f->frame = frame;
    return Value(Tag::Function, f);
}

namespace {

ListObject* make_list(std::size_t n)
{
    if (n > std::numeric_limits<std::uint32_t>::max() / 2) throw OutOfValueMemory();
    auto* list = allocate<ListObject>(sizeof(ListObject) + n * sizeof(Value), Object::Type::List);
    list->size = static_cast<std::uint32_t>(n);
    return list;
}

}  // namespace

Value Value::list(std::vector<Value>&& items)
{
    auto* list = make_list(items.size());
    for (std::size_t i = 0; i < items.size(); ++i)
        new (list->data() + i) Value(std::move(items[i]));
    return Value(Tag::List, list);
}

Value Value::list(std::span<const Value> items)
{
    auto* list = make_list(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) new (list->data() + i) Value(items[i]);
    return Value(Tag::List, list);
}

Value Value::numbers(std::span<const double> items)
{
    auto* list = make_list(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) new (list->data() + i) Value(items[i]);
    return Value(Tag::List, list);
}

bool Value::truthy() const
{
    switch (tag_) {
        case Tag::Unset:
        case Tag::Undef:
            return false;
        case Tag::Bool:
            return as_bool();
        case Tag::Number:
            return as_number() != 0.0;
        case Tag::String:
            return string_object().bytes > 0;
        case Tag::List:
            return !items().empty();
        case Tag::Range:
        case Tag::Function:
            return true;
    }
    return false;
}

const char* Value::type_name() const
{
    switch (tag_) {
        case Tag::Unset:
        case Tag::Undef:
            return "undefined";
        case Tag::Bool:
            return "bool";
        case Tag::Number:
            return "number";
        case Tag::String:
            return "string";
        case Tag::List:
            return "vector";
        case Tag::Range:
            return "range";
        case Tag::Function:
            return "function";
    }
    return "undefined";
}

bool equal(const Value& a, const Value& b)
{
    if (a.tag() != b.tag()) return false;
    switch (a.tag()) {
        case Value::Tag::Unset:
        case Value::Tag::Undef:
            return true;
        case Value::Tag::Bool:
            return a.as_bool() == b.as_bool();
        case Value::Tag::Number:
            return a.as_number() == b.as_number();
        case Value::Tag::String:
            return a.as_string() == b.as_string();
        case Value::Tag::List:
            return same_items(a.items(), b.items());
        case Value::Tag::Range:
            return compare_ranges(a.as_range(), b.as_range()) == 0;
        case Value::Tag::Function:
            return &a.as_function() == &b.as_function();
    }
    return false;
}

std::uint32_t range_size(const RangeObject& range)
{
    constexpr std::uint32_t kEndless = std::numeric_limits<std::uint32_t>::max();
    const double b = range.begin, s = range.step, e = range.end;
    if (std::isnan(b) || std::isnan(s) || std::isnan(e)) return 0;
    if (s < 0 ? b < e : b > e) return 0;
    if (s == 0) return b == e ? 0 : kEndless;
    if (b == e || std::isinf(s)) return 1;
    if (std::isinf(b) || std::isinf(e)) return kEndless;
    // Half a unit of rounding more, so that [0:0.1:0.3] reaches 0.3.
    const double n = std::nextafter((e - b) / s, std::numeric_limits<double>::max());
    return n >= kEndless - 1.0 ? kEndless : static_cast<std::uint32_t>(n) + 1;
}

int compare_ranges(const RangeObject& a, const RangeObject& b)
{
    const std::uint32_t m = range_size(a), n = range_size(b);
    const auto order = [](double x, double y) { return x < y ? -1 : x > y ? 1 : 0; };
    if (m == 0 || n == 0) return order(m, n);
    if (a.begin != b.begin) return order(a.begin, b.begin);
    if (m == 1 || n == 1 || a.step == b.step) return order(m, n);
    return order(a.step, b.step);
}

std::size_t character_bytes(std::string_view text, std::size_t at)
{
    const auto lead = static_cast<unsigned char>(text[at]);
    std::size_t bytes = lead < 0xc2 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : lead < 0xf5 ? 4 : 1;
    if (at + bytes > text.size()) return 1;
    for (std::size_t i = 1; i < bytes; ++i)
        if ((static_cast<unsigned char>(text[at + i]) & 0xc0) != 0x80) return 1;
    return bytes;
}

std::size_t count_characters(std::string_view text)
{
    std::size_t n = 0;
    for (std::size_t at = 0; at < text.size(); at += character_bytes(text, at)) ++n;
    return n;
}

std::uint32_t decode_character(std::string_view c)
{
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(c[i]); };
    switch (c.size()) {
        case 2:
            return (byte(0) & 0x1fu) << 6 | (byte(1) & 0x3fu);
        case 3:
            return (byte(0) & 0x0fu) << 12 | (byte(1) & 0x3fu) << 6 | (byte(2) & 0x3fu);
        case 4:
            return (byte(0) & 0x07u) << 18 | (byte(1) & 0x3fu) << 12 | (byte(2) & 0x3fu) << 6 |
                   (byte(3) & 0x3fu);
        default:
            return byte(0);
    }
}

std::string encode_character(std::uint32_t code)
{
    std::string s;
    const auto put = [&](std::uint32_t byte) { s += static_cast<char>(byte); };
    if (code == 0 || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return s;
    if (code < 0x80) {
        put(code);
    } else if (code < 0x800) {
        put(0xc0 | code >> 6);
        put(0x80 | (code & 0x3f));
    } else if (code < 0x10000) {
        put(0xe0 | code >> 12);
        put(0x80 | (code >> 6 & 0x3f));
        put(0x80 | (code & 0x3f));
    } else {
        put(0xf0 | code >> 18);
        put(0x80 | (code >> 12 & 0x3f));
        put(0x80 | (code >> 6 & 0x3f));
        put(0x80 | (code & 0x3f));
    }
    return s;
}

}  // namespace genus::language
