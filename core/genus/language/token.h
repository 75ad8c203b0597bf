#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "genus/language/diagnostics.h"

namespace genus::language {

/// Numbers for names, so that comparing them is cheap.
class Names {
public:
    using Id = std::uint32_t;

    Id intern(std::string_view text);
    const std::string& operator[](Id id) const { return *texts_[id]; }
    std::size_t size() const { return texts_.size(); }
    /// Whether it is looked up where the program runs. `$children` is not, for all its dollar.
    bool is_special(Id id) const { return (*this)[id][0] == '$' && (*this)[id] != "$children"; }

private:
    std::unordered_map<std::string, Id> ids_;
    std::vector<const std::string*> texts_;
};

struct Token {
    enum class Kind : std::uint8_t {
        End,
        Number,
        String,
        Name,
        Module,
        Function,
        If,
        Else,
        For,
        Let,
        Assert,
        Echo,
        Each,
        True,
        False,
        Undef,
        LessEqual,
        GreaterEqual,
        Equal,
        NotEqual,
        And,
        Or,
        Character,  // `id` is the character itself
        Use         // `id` is the number of the file name in `strings`
    };

    Kind kind = Kind::End;
    Place place;
    std::uint32_t id = 0;  // Name: its id. String: its number in `strings`.
    double number = 0.0;

    bool is(char c) const { return kind == Kind::Character && id == static_cast<unsigned char>(c); }
};

struct TokenText {
    std::vector<Token> tokens;  // ends with one End
    std::vector<std::string> strings;
};

/// Finds and reads the files of a model.
class Loader {
public:
    Loader(Sources& sources, std::vector<std::string> library_paths);

    struct Found {
        std::string path;    // as it can be opened
        std::string shown;   // for messages
        std::string folder;  // for what it names in turn
    };

    /// Sets the folder from which messages name files.
    void set_model_folder(const std::string& folder) { model_folder_ = folder; }
    /// Looks in `folder`, then in the library paths. Throws ModelError at `place`.
    Found find(const std::string& name, const std::string& folder, const Place& place) const;
    /// Throws ModelError at `place` if the file cannot be read or is larger than a model may be.
    std::string read(const Found& file, const Place& place) const;
    Sources& sources() const { return sources_; }

private:
    Sources& sources_;
    std::vector<std::string> library_paths_;
    std::string model_folder_;
};

/// Cuts a text into tokens; `include <file>` is replaced by the tokens of that file.
///
/// Throws ModelError for an unterminated string or comment, a character that starts no token, an
/// include that cannot be read or that includes itself, and texts of more than 10^7 tokens.
/// Linear in the text.
class Tokenizer {
public:
    Tokenizer(Loader& loader, Names& names) : loader_(loader), names_(names) {}

    /// Notes the path of the file itself, which it may not include.
    void open(const std::string& path) { open_.push_back(path); }
    /// Appends the tokens of `text`, which is file number `file` and lies in `folder`.
    void add(std::string_view text, std::int32_t file, const std::string& folder);
    /// Closes the list with an End.
    TokenText take();

private:
    friend class Scanner;

    Loader& loader_;
    Names& names_;
    TokenText out_;
    std::vector<std::string> open_;     // paths of the includes being read
    std::vector<std::string> folders_;  // of each Use token's string, where it looks first
    Token last_;

public:
    /// Folder in which the use with this string number looks first.
    const std::string& folder_of_use(std::uint32_t string) const { return folders_[string]; }
};

}  // namespace genus::language
