#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "genus/base/vec.h"

namespace genus::io {

struct XmlAttribute {
    std::string_view name;
    std::string_view value;
};

/// Looks an attribute up by its name without prefix; nothing where it is missing.
const XmlAttribute* find_attribute(std::span<const XmlAttribute> attributes, std::string_view name);

/// A mistake in an XML text.
struct XmlFault {
    std::int64_t line;
    std::string problem;
};

/// What the reader of a format does with the elements, named without prefix. May throw
/// std::string, a problem, to which the parser adds the line.
class XmlHandler {
public:
    virtual ~XmlHandler() = default;
    virtual void start(std::string_view element, std::span<const XmlAttribute> attributes) = 0;
    virtual void end(std::string_view element) = 0;
    virtual void text(std::string_view piece) = 0;
};

/// Reads XML piece by piece, by the library expat. Refuses document types, and with them entities
/// and everything they can be abused for, elements nested deeper than 64, and single tags or
/// comments longer than 1 MB. Where document types are allowed, up to 100 entities are, short ones
/// that name no other; nothing outside the file is read. Throws XmlFault.
class XmlParser {
public:
    enum class DocumentType { Refused, Allowed };

    explicit XmlParser(XmlHandler& handler, DocumentType type = DocumentType::Refused);
    ~XmlParser();
    XmlParser(const XmlParser&) = delete;
    XmlParser& operator=(const XmlParser&) = delete;

    void feed(std::span<const char> piece);
    void finish();

    struct State;

private:
    void parse(const char* data, int size, bool last);

    std::unique_ptr<State> state_;
};

/// A number, or a whole number from 0 up to 2^31 - 1, that makes up the whole text but for white
/// space. Throw std::string, a problem that calls it `what`.
double xml_number(std::string_view text, const char* what);
std::int32_t xml_index(std::string_view text, const char* what);

}  // namespace genus::io
