#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

#include "genus/base/error.h"

namespace genus {

/// Something a text model says while it runs: its own echo, or a warning about it.
struct Message {
    enum class Kind { Echo, Warning, Deprecated };
    Kind kind = Kind::Echo;
    std::string file;  // as it can be opened
    int line = 0;      // from 1; 0 where there is no place
    int column = 0;
    std::string text;  // the whole line as shown, "ECHO: 1" or "WARNING: ..."
};

/// The messages, one a line, each ended by a newline.
std::string echo_text(const std::vector<Message>& messages);

namespace language {

/// A place in a source: number of the file in `Sources`, line and column from 1.
struct Place {
    std::int32_t file = 0;
    std::int32_t line = 0;
    std::int32_t column = 0;
};

/// The files of one model. Names are shared with what is made from them.
class Sources {
public:
    struct File {
        std::shared_ptr<const std::string> path;  // as it can be opened
        std::string shown;                        // as messages name it: from the model's folder
    };

    std::int32_t add(const std::string& path, const std::string& shown);
    const File& operator[](std::int32_t file) const { return files_[file]; }

private:
    std::vector<File> files_;
};

/// Throws ModelError at this place.
[[noreturn]] void fail(const Sources& sources, const Place& place, const std::string& problem);

/// Collects messages in order, up to a fixed number; then one says that more were left out.
class Diagnostics {
public:
    explicit Diagnostics(const Sources& sources) : sources_(sources) {}

    void echo(const Place& place, const std::string& text);
    /// "WARNING: `text` in file F, line L"; the same again and again only five times.
    void warn(const Place& place, const std::string& text);
    /// A warning with a second line of advice.
    void warn_with_hint(const Place& place, const std::string& text, const std::string& hint);
    /// The same as "DEPRECATED: ...", but once for each line of the model.
    void deprecated(const Place& place, const std::string& text);
    /// The same, said once for the whole model and without a place in the text.
    void deprecated_anywhere(const Place& place, const std::string& text);

    std::vector<Message> take() { return std::move(messages_); }

private:
    void add(Message::Kind kind, const Place& place, std::string text);
    std::string located(const Place& place) const;

    const Sources& sources_;
    std::vector<Message> messages_;
    std::unordered_set<std::string> said_;
    std::string last_warning_;
    std::size_t repeats_ = 0;
    std::size_t bytes_ = 0;
};

}  // namespace language
}  // namespace genus
