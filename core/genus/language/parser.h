#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "genus/language/diagnostics.h"
#include "genus/language/syntax.h"

namespace genus::language {

struct ParseOptions {
    /// Variables of the model replaced from outside: name and text of an expression.
    std::vector<std::pair<std::string, std::string>> defines;
    /// Folders to look for `include` and `use`, after that of the file that asks.
    std::vector<std::string> library_paths;
};

/// Reads `text`, which is or pretends to be the file `path`, with all files it uses, into a tree.
/// Warnings about overwritten variables go to `diagnostics`, which must be that of
/// `program.sources`.
///
/// Throws ModelError for mistakes in the syntax, files that cannot be read and nesting beyond the
/// stack. Linear in the text. Call it on a large stack.
void parse_program(Program& program, const std::string& text, const std::string& path,
                   const ParseOptions& options, Diagnostics& diagnostics);

}  // namespace genus::language
