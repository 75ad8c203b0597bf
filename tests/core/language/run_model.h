#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "genus/language/model.h"

namespace genus {

/// What a run says, whether it ends well or not.
struct Said {
    std::string echo;
    std::string csg;
    std::string error;  // of a ModelError, empty where there was none
    int line = 0, column = 0;
};

inline Said run_model(const std::string& text, ModelOptions options = {},
                      const std::string& path = "case.scad")
{
    std::vector<Message> messages;
    options.messages = &messages;
    options.preview = true;
    options.solid = false;
    Said said;
    try {
        said.csg = to_csg(read_model_text(text, path, options).tree);
    } catch (const ModelError& e) {
        said.error = e.problem();
        said.line = e.line();
        said.column = e.column();
    }
    said.echo = echo_text(messages);
    return said;
}

inline std::string read_text(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

/// Programs with what OpenSCAD 2021.01 makes of them beside them.
inline std::filesystem::path programs_folder()
{
    return std::filesystem::path(GENUS_MODELS_DIR).parent_path() / "tests/core/language/programs";
}

/// A folder of its own, removed at the end.
class ScratchFolder {
public:
    ScratchFolder()
    {
        static int number = 0;
        path_ = std::filesystem::temp_directory_path() /
                ("genus_language_" + std::to_string(::getpid()) + "_" + std::to_string(number++));
        std::filesystem::create_directories(path_);
    }
    ~ScratchFolder() { std::filesystem::remove_all(path_); }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::string write(const std::string& name, const std::string& text) const
    {
        const auto file = path_ / name;
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << text;
        return file.string();
    }
    std::string file(const std::string& name) const { return (path_ / name).string(); }

private:
    std::filesystem::path path_;
};

}  // namespace genus
