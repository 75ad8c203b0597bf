#include "genus/language/diagnostics.h"

namespace genus {

std::string echo_text(const std::vector<Message>& messages)
{
    std::string text;
    for (const Message& message : messages) text += message.text + "\n";
    return text;
}

namespace language {

namespace {

constexpr std::size_t kMaxRepeats = 5;  // of one warning in a row
constexpr std::size_t kMaxMessages = 100'000;
constexpr std::size_t kMaxBytes = 256u << 20;

}  // namespace

std::int32_t Sources::add(const std::string& path, const std::string& shown)
{
    files_.push_back({std::make_shared<const std::string>(path), shown});
    return static_cast<std::int32_t>(files_.size()) - 1;
}

void fail(const Sources& sources, const Place& place, const std::string& problem)
{
    // One line, whatever texts of the model it quotes.
    std::string line = problem;
    for (char& c : line)
        if (c == '\n' || c == '\r') c = ' ';
    throw ModelError(*sources[place.file].path, place.line, place.column, line);
}

void Diagnostics::echo(const Place& place, const std::string& text)
{
    add(Message::Kind::Echo, place, "ECHO: " + text);
}

void Diagnostics::warn(const Place& place, const std::string& text)
{
    std::string line = "WARNING: " + text + located(place);
    repeats_ = line == last_warning_ ? repeats_ + 1 : 0;
    if (repeats_ >= kMaxRepeats) return;
    last_warning_ = line;
    add(Message::Kind::Warning, place, std::move(line));
}

void Diagnostics::warn_with_hint(const Place& place, const std::string& text,
                                 const std::string& hint)
{
    add(Message::Kind::Warning, place, "WARNING: " + text + located(place) + "\n" + hint);
}

void Diagnostics::deprecated(const Place& place, const std::string& text)
{
    const std::string line = "DEPRECATED: " + text + located(place);
    if (said_.insert(line).second) add(Message::Kind::Deprecated, place, line);
}

void Diagnostics::deprecated_anywhere(const Place& place, const std::string& text)
{
    const std::string line = "DEPRECATED: " + text;
    if (said_.insert(line).second) add(Message::Kind::Deprecated, place, line);
}

void Diagnostics::add(Message::Kind kind, const Place& place, std::string text)
{
    if (messages_.size() > kMaxMessages || bytes_ > kMaxBytes) return;
    bytes_ += text.size();
    messages_.push_back(
        {kind, *sources_[place.file].path, place.line, place.column, std::move(text)});
    if (messages_.size() >= kMaxMessages || bytes_ > kMaxBytes) {
        messages_.push_back({Message::Kind::Warning, *sources_[place.file].path, 0, 0,
                             "WARNING: further messages are left out"});
        bytes_ = kMaxBytes + 1;
    }
}

std::string Diagnostics::located(const Place& place) const
{
    return " in file " + sources_[place.file].shown + ", line " + std::to_string(place.line);
}

}  // namespace language
}  // namespace genus
