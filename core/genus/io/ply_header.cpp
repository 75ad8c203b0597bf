#include "genus/io/ply_header.h"

#include <algorithm>
#include <optional>

#include "genus/io/text.h"

namespace genus::io {

namespace {

struct TypeName {
    std::string_view name;
    PlyType type;
};

constexpr std::size_t kMost = 1000;  // elements, and properties of one: more is an attack

constexpr TypeName kTypeNames[] = {
    {"char", PlyType::int8},       {"int8", PlyType::int8},      {"uchar", PlyType::uint8},
    {"uint8", PlyType::uint8},     {"short", PlyType::int16},    {"int16", PlyType::int16},
    {"ushort", PlyType::uint16},   {"uint16", PlyType::uint16},  {"int", PlyType::int32},
    {"int32", PlyType::int32},     {"uint", PlyType::uint32},    {"uint32", PlyType::uint32},
    {"int64", PlyType::int64},     {"uint64", PlyType::uint64},  {"float", PlyType::float32},
    {"float32", PlyType::float32}, {"double", PlyType::float64}, {"float64", PlyType::float64}};

// Reads the lines of the header. They end like the first one: with LF, CR LF or CR. A reader that
// took either could not tell where the rows of a binary file begin.
class HeaderReader {
public:
    explicit HeaderReader(std::string_view text) : text_(text) {}

    PlyHeader read()
    {
        read_first_line();
        while (true) {
            next_line();
            const std::string_view keyword = word();
            if (keyword == "end_header") break;
            if (keyword == "format")
                read_format();
            else if (keyword == "element")
                read_element();
            else if (keyword == "property")
                read_property();
            else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty())
                fail(shown(keyword) + " is not a PLY header statement");
        }
        if (!has_format_) fail("the PLY header has no format");
        header_.size = end_of_line_;
        return std::move(header_);
    }

private:
    void read_first_line()
    {
        if (!text_.starts_with("ply")) fail("does not begin with 'ply'");
        line_ending_ = text_.substr(3).starts_with("\r\n") ? "\r\n"
                       : text_.substr(3).starts_with("\r") ? "\r"
                                                           : "\n";
        next_line();
        line_.remove_prefix(3);
        if (!word().empty()) fail("does not begin with 'ply'");
    }

    void next_line()
    {
        const std::size_t begin = end_of_line_;
        const std::size_t end = text_.find(line_ending_, begin);
        if (end == std::string_view::npos)
            throw TextFault{text_.data() + text_.size(), "the file ends before 'end_header'"};
        line_ = text_.substr(begin, end - begin);
        start_of_line_ = begin;
        end_of_line_ = end + line_ending_.size();
    }

    std::string_view word()
    {
        const auto begin = std::find_if_not(line_.begin(), line_.end(), is_space);
        const auto end = std::find_if(begin, line_.end(), is_space);
        const std::string_view found(begin, end);
        line_.remove_prefix(static_cast<std::size_t>(end - line_.begin()));
        return found;
    }

    static std::string shown(std::string_view found)
    {
        return shown_word(found.data(), found.data() + found.size());
    }

    [[noreturn]] void fail(const std::string& problem) const
    {
        throw TextFault{text_.data() + start_of_line_, problem};
    }

    void read_format()
    {
        const std::string_view name = word();
        const std::string_view version = word();
        if (name == "ascii")
            header_.ascii = true;
        else if (name == "binary_little_endian" || name == "binary_big_endian")
            header_.ascii = false;
        else
            fail(shown(name) + " is not a PLY format");
        header_.order = name == "binary_big_endian" ? std::endian::big : std::endian::little;
        if (version != "1.0") fail("PLY version " + shown(version) + " is not read");
        if (has_format_) fail("a second format");
        has_format_ = true;
    }

    void read_element()
    {
        PlyElement element;
        element.name = word();
        const std::string_view count = word();
        std::int64_t value = 0;
        if (element.name.empty() || count.empty()) fail("an element needs a name and a count");
        const char* end = count.data() + count.size();
        if (parse_integer(count.data(), end, value) != end || value < 0)
            fail(shown(count) + " is not a number of elements");
        if (header_.find(element.name) != nullptr) fail("a second element " + shown(element.name));
        if (header_.elements.size() == kMost) fail("too many elements");
        element.count = static_cast<std::uint64_t>(value);
        header_.elements.push_back(std::move(element));
    }

    void read_property()
    {
        if (header_.elements.empty()) fail("a property before the first element");
        PlyElement& element = header_.elements.back();
        PlyProperty property;
        std::string_view type = word();
        if (type == "list") {
            property.is_list = true;
            property.count_type = type_named(word());
            if (is_float(property.count_type)) fail("the count of a list is not an integer type");
            type = word();
        }
        property.type = type_named(type);
        property.name = word();
        if (property.name.empty()) fail("a property without a name");
        if (element.find({property.name}) >= 0) fail("a second property " + shown(property.name));
        if (element.properties.size() == kMost) fail("too many properties");
        element.properties.push_back(std::move(property));
    }

    PlyType type_named(std::string_view name) const
    {
        for (const TypeName& known : kTypeNames)
            if (name == known.name) return known.type;
        fail(shown(name) + " is not a PLY type");
    }

    std::string_view text_;
    std::string_view line_ending_;
    std::string_view line_;
    std::size_t start_of_line_ = 0;
    std::size_t end_of_line_ = 0;
    bool has_format_ = false;
    PlyHeader header_;
};

}  // namespace

std::size_t size_of(PlyType type)
{
    switch (type) {
        case PlyType::int8:
        case PlyType::uint8:
            return 1;
        case PlyType::int16:
        case PlyType::uint16:
            return 2;
        case PlyType::int32:
        case PlyType::uint32:
        case PlyType::float32:
            return 4;
        case PlyType::int64:
        case PlyType::uint64:
        case PlyType::float64:
            return 8;
    }
    return 0;
}

int PlyElement::find(std::initializer_list<std::string_view> names) const
{
    for (const std::string_view wanted : names)
        for (std::size_t i = 0; i < properties.size(); ++i)
            if (properties[i].name == wanted) return static_cast<int>(i);
    return -1;
}

std::uint64_t PlyElement::least_row_bytes(bool ascii) const
{
    std::uint64_t bytes = 0;
    for (const PlyProperty& property : properties)
        bytes += ascii ? 2 : size_of(property.is_list ? property.count_type : property.type);
    return bytes;
}

const PlyElement* PlyHeader::find(std::string_view element) const
{
    for (const PlyElement& candidate : elements)
        if (candidate.name == element) return &candidate;
    return nullptr;
}

PlyHeader read_ply_header(std::string_view text)
{
    return HeaderReader(text).read();
}

}  // namespace genus::io
