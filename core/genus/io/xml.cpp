#include "genus/io/xml.h"

#include <expat.h>

#include <algorithm>
#include <limits>

#include "genus/base/progress.h"
#include "genus/io/text.h"

namespace genus::io {

namespace {

constexpr int kMaxDepth = 64;
constexpr int kMaxEntities = 100;
constexpr std::size_t kMaxEntity = 1000;
constexpr std::int64_t kMaxToken = std::int64_t{1} << 20;
constexpr std::size_t kPiece = std::size_t{1} << 16;

std::string_view without_prefix(std::string_view name)
{
    const std::size_t colon = name.find(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

std::string_view trimmed(std::string_view text)
{
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
}

}  // namespace

// Exceptions must not pass through expat: they are kept until it has returned.
struct XmlParser::State {
    XML_Parser parser = nullptr;
    XmlHandler* handler = nullptr;
    int depth = 0;
    int n_entities = 0;
    std::int64_t fed = 0;
    std::exception_ptr error;
    std::vector<XmlAttribute> attributes;

    template <class Body>
    void guarded(const Body& body)
    {
        if (error) return;
        try {
            body();
        } catch (...) {
            error = std::current_exception();
            XML_StopParser(parser, XML_FALSE);
        }
    }
};

namespace {

void on_start(void* data, const char* element, const char** pairs)
{
    auto& state = *static_cast<XmlParser::State*>(data);
    state.guarded([&] {
        if (++state.depth > kMaxDepth) throw std::string("elements nested too deeply");
        state.attributes.clear();
        for (; pairs[0] != nullptr; pairs += 2) state.attributes.push_back({pairs[0], pairs[1]});
        state.handler->start(without_prefix(element), state.attributes);
    });
}

void on_end(void* data, const char* element)
{
    auto& state = *static_cast<XmlParser::State*>(data);
    state.guarded([&] {
        --state.depth;
        state.handler->end(without_prefix(element));
    });
}

void on_text(void* data, const char* text, int size)
{
    auto& state = *static_cast<XmlParser::State*>(data);
    state.guarded([&] { state.handler->text({text, static_cast<std::size_t>(size)}); });
}

void on_document_type(void* data, const char*, const char*, const char*, int)
{
    auto& state = *static_cast<XmlParser::State*>(data);
    state.guarded([] { throw std::string("document types are not allowed here"); });
}

void on_entity(void* data, const char*, int, const char* value, int size, const char*, const char*,
               const char*, const char*)
{
    auto& state = *static_cast<XmlParser::State*>(data);
    state.guarded([&] {
        const std::string_view text =
            value == nullptr ? std::string_view() : std::string_view(value, size);
        if (++state.n_entities > kMaxEntities || text.size() > kMaxEntity ||
            text.find_first_of("&%<") != std::string_view::npos)
            throw std::string("entities like this are not allowed here");
    });
}

}  // namespace

const XmlAttribute* find_attribute(std::span<const XmlAttribute> attributes, std::string_view name)
{
    for (const XmlAttribute& attribute : attributes)
        if (without_prefix(attribute.name) == name) return &attribute;
    return nullptr;
}

XmlParser::XmlParser(XmlHandler& handler, DocumentType type) : state_(std::make_unique<State>())
{
    state_->parser = XML_ParserCreate(nullptr);
    if (state_->parser == nullptr) throw std::bad_alloc();
    state_->handler = &handler;
    XML_SetUserData(state_->parser, state_.get());
    XML_SetElementHandler(state_->parser, on_start, on_end);
    XML_SetCharacterDataHandler(state_->parser, on_text);
    if (type == DocumentType::Refused)
        XML_SetStartDoctypeDeclHandler(state_->parser, on_document_type);
    else
        XML_SetEntityDeclHandler(state_->parser, on_entity);
}

XmlParser::~XmlParser()
{
    XML_ParserFree(state_->parser);
}

void XmlParser::feed(std::span<const char> piece)
{
    for (; !piece.empty(); piece = piece.subspan(std::min(piece.size(), kPiece))) {
        current_progress().check();
        parse(piece.data(), static_cast<int>(std::min(piece.size(), kPiece)), false);
    }
}

void XmlParser::finish()
{
    parse(nullptr, 0, true);
}

void XmlParser::parse(const char* data, int size, bool last)
{
    const XML_Status status = XML_Parse(state_->parser, data, size, last ? XML_TRUE : XML_FALSE);
    const auto line = static_cast<std::int64_t>(XML_GetCurrentLineNumber(state_->parser));
    if (state_->error) {
        try {
            std::rethrow_exception(state_->error);
        } catch (const std::string& problem) {
            throw XmlFault{line, problem};
        }
    }
    if (status != XML_STATUS_OK)
        throw XmlFault{line,
                       std::string("XML: ") + XML_ErrorString(XML_GetErrorCode(state_->parser))};
    state_->fed += size;
    // What lies beyond the last event is a tag that has not ended; expat scans it again and again.
    if (state_->fed - XML_GetCurrentByteIndex(state_->parser) > kMaxToken)
        throw XmlFault{line, "a tag longer than 1 MB"};
}

double xml_number(std::string_view text, const char* what)
{
    text = trimmed(text);
    const char* end = text.data() + text.size();
    double value = 0.0;
    try {
        if (parse_number(text.data(), end, value) == end) return value;
    } catch (const TextFault& fault) {
        throw std::string(what) + ": " + fault.problem;
    }
    throw std::string(what) + ": " + shown_word(text.data(), end) + " is not a number";
}

std::int32_t xml_index(std::string_view text, const char* what)
{
    text = trimmed(text);
    const char* end = text.data() + text.size();
    std::int64_t value = 0;
    try {
        if (parse_integer(text.data(), end, value) == end && value >= 0 &&
            value <= std::numeric_limits<std::int32_t>::max())
            return static_cast<std::int32_t>(value);
    } catch (const TextFault& fault) {
        throw std::string(what) + ": " + fault.problem;
    }
    throw std::string(what) + ": " + shown_word(text.data(), end) + " is not an index";
}

}  // namespace genus::io
