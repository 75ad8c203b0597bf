#include "genus/language/model.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "genus/language/builtins_solid.h"
#include "genus/language/evaluate.h"
#include "genus/language/parser.h"
#include "genus/language/resolve.h"
#include "genus/language/stack.h"

namespace genus {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kMaxFileBytes = 100u << 20;

std::vector<std::string> library_paths(const ModelOptions& options)
{
    std::vector<std::string> paths = options.library_paths;
    if (const char* listed = std::getenv("OPENSCADPATH")) {
        std::string text(listed);
        for (std::size_t at = 0; at <= text.size();) {
            const std::size_t end = std::min(text.find(':', at), text.size());
            if (end > at) paths.push_back(text.substr(at, end - at));
            at = end + 1;
        }
    }
    if (const char* home = std::getenv("HOME"))
        paths.push_back((fs::path(home) / ".local/share/OpenSCAD/libraries").string());
    paths.push_back("/usr/share/openscad/libraries");
    return paths;
}

language::ParseOptions parse_options(const ModelOptions& options)
{
    language::ParseOptions out;
    out.defines = options.defines;
    if (options.tolerance) out.defines.emplace_back("$tolerance", to_text(*options.tolerance));
    out.library_paths = library_paths(options);
    return out;
}

void check(const ModelOptions& options)
{
    if (options.tolerance)
        require(*options.tolerance > 0 && *options.tolerance < 1e300, "read_model: tolerance",
                *options.tolerance, "positive and finite");
    for (const auto& [name, value] : options.defines) {
        bool good = !name.empty();
        for (std::size_t i = 0; i < name.size(); ++i) {
            const auto c = static_cast<unsigned char>(name[i]);
            good = good && (std::isalnum(c) || c == '_' || (c == '$' && i == 0));
        }
        if (!good) throw InvalidInput("read_model: '" + name + "' is not the name of a variable");
    }
}

// Runs on the large stack, whose thread the values belong to.
void run(const std::string& text, const std::string& path, const ModelOptions& options,
         TextModel& out)
{
    language::set_value_memory_limit(options.memory);
    language::Program program;
    language::Diagnostics diagnostics(program.sources);
    try {
        try {
            language::parse_program(program, text, path, parse_options(options), diagnostics);
            language::resolve(program);
        } catch (const language::StackExhausted&) {
            throw ModelError(path, 1, 1, "the model is nested too deeply");
        } catch (const language::OutOfValueMemory&) {
            throw ModelError(path, 1, 1, "the model needs too much memory");
        }
        language::Evaluator evaluator(program, diagnostics);
        evaluator.set_root_special("$preview", options.preview);
        if (options.tolerance) evaluator.set_root_special("$tolerance", *options.tolerance);
        out.tree = evaluator.run();
        const language::Value tolerance = evaluator.root_special("$tolerance");
        if (tolerance.is_number() && tolerance.as_number() > 0)
            out.tolerance = tolerance.as_number();
    } catch (...) {
        out.messages = diagnostics.take();
        throw;
    }
    out.messages = diagnostics.take();
    if (!options.solid) return;
    try {
        if (!options.plane) {
            out.solid = to_solid(out.tree, out.messages);
            return;
        }
        ModelGeometry made = to_geometry(out.tree, out.messages);
        out.solid = std::move(made.solid);
        out.region = std::move(made.region);
    } catch (const language::StackExhausted&) {
        throw ModelError(path, 1, 1, "the model is nested too deeply");
    }
}

}  // namespace

TextModel read_model_text(const std::string& text, const std::string& path,
                          const ModelOptions& options)
{
    check(options);
    TextModel model;
    const auto hand_over = [&] {
        if (options.messages) *options.messages = model.messages;
    };
    try {
        language::run_on_large_stack("language", [&] { run(text, path, options, model); });
    } catch (...) {
        hand_over();
        throw;
    }
    hand_over();
    return model;
}

TextModel read_model(const std::string& path, const ModelOptions& options)
{
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(path, error);
    if (error) throw FileError(path, error.message());
    if (bytes > kMaxFileBytes) throw FileError(path, "larger than 100 MB");
    std::ifstream in(path, std::ios::binary);
    std::string text(static_cast<std::size_t>(bytes), '\0');
    in.read(text.data(), static_cast<std::streamsize>(bytes));
    if (!in.is_open() || in.bad()) throw FileError(path, "cannot be read");
    text.resize(static_cast<std::size_t>(in.gcount()));
    return read_model_text(text, path, options);
}

}  // namespace genus
