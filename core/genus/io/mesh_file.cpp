#include "genus/io/mesh_file.h"

#include <algorithm>
#include <cstring>

#include "genus/io/stl.h"
#include "genus/io/text.h"

namespace genus {

namespace {

struct KnownFormat {
    MeshFormat format;
    const char* name;
};

constexpr KnownFormat kFormats[] = {
    {MeshFormat::stl, "stl"},      {MeshFormat::obj, "obj"}, {MeshFormat::off, "off"},
    {MeshFormat::ply, "ply"},      {MeshFormat::glb, "glb"}, {MeshFormat::gltf, "gltf"},
    {MeshFormat::three_mf, "3mf"}, {MeshFormat::amf, "amf"},
};

// [ST][C][N][4][n]OFF, the first word of an OFF file.
bool is_off_word(std::string_view word)
{
    for (const std::string_view prefix : {"ST", "C", "N", "4", "n"})
        if (word.starts_with(prefix)) word.remove_prefix(prefix.size());
    return word == "OFF";
}

}  // namespace

const char* format_name(MeshFormat format)
{
    for (const KnownFormat& known : kFormats)
        if (known.format == format) return known.name;
    return "unknown";
}

std::optional<MeshFormat> format_of_extension(std::string_view path)
{
    const std::size_t dot = path.find_last_of("./\\");
    if (dot == std::string_view::npos || path[dot] != '.') return std::nullopt;
    std::string extension(path.substr(dot + 1));
    for (char& c : extension) c = io::to_lower(c);
    for (const KnownFormat& known : kFormats)
        if (extension == known.name) return known.format;
    if (extension == "coff" || extension == "noff" || extension == "cnoff") return MeshFormat::off;
    return std::nullopt;
}

std::optional<MeshFormat> format_of_content(std::span<const std::byte> content)
{
    const std::string_view text = io::as_text(content);
    if (text.starts_with("ply\n") || text.starts_with("ply\r")) return MeshFormat::ply;
    if (text.starts_with("glTF")) return MeshFormat::glb;
    if (io::is_binary_stl_size(content)) return MeshFormat::stl;
    const std::string_view word = io::first_word(text);
    if (is_off_word(word)) return MeshFormat::off;
    if (io::looks_like_ascii_stl(text)) return MeshFormat::stl;
    if (word.starts_with("{") && text.find("\"asset\"") != std::string_view::npos)
        return MeshFormat::gltf;
    constexpr std::size_t start = 4096;
    if (word.starts_with("<") && text.substr(0, start).find("<amf") != std::string_view::npos)
        return MeshFormat::amf;
    return std::nullopt;
}

}  // namespace genus
