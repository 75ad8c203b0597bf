#include "genus/io/read_mesh.h"

#include <filesystem>
#include <utility>

#include "genus/base/error.h"
#include "genus/io/gltf.h"
#include "genus/io/input_file.h"
#include "genus/io/obj.h"
#include "genus/io/off.h"
#include "genus/io/ply.h"
#include "genus/io/raw_mesh.h"
#include "genus/io/stl.h"
#include "genus/io/text.h"
#include "genus/io/xml_formats.h"

namespace genus {

namespace {

MeshFormat choose_format(std::span<const std::byte> content, const std::string& name,
                         const ReadOptions& options)
{
    if (options.format) return *options.format;
    if (const auto format = format_of_content(content)) return *format;
    const auto of_extension = format_of_extension(name);
    // Two formats are packed the same way; only one is so as a rule.
    if (io::is_zip(content))
        return of_extension == MeshFormat::amf ? MeshFormat::amf : MeshFormat::three_mf;
    if (of_extension) return *of_extension;
    if (io::looks_like_obj(io::as_text(content))) return MeshFormat::obj;
    throw FileError(name,
                    "is in no mesh format known here (stl, obj, off, ply, glb, gltf, 3mf, amf)");
}

// `folder` is where the file lies, nothing where it is not a file.
io::RawMesh read_raw(std::span<const std::byte> content, const std::string& name,
                     const ReadOptions& options, const std::optional<std::string>& folder)
{
    if (content.empty()) throw FileError(name, "is empty");
    switch (choose_format(content, name, options)) {
        case MeshFormat::stl:
            return io::read_stl(content, name);
        case MeshFormat::obj:
            return io::read_obj(content, name, folder);
        case MeshFormat::off:
            return io::read_off(content, name);
        case MeshFormat::ply:
            return io::read_ply(content, name);
        case MeshFormat::glb:
        case MeshFormat::gltf:
            return io::read_gltf(content, name, folder);
        case MeshFormat::three_mf:
            return io::read_3mf(content, name);
        case MeshFormat::amf:
            return io::read_amf(content, name);
    }
    throw InvalidInput("read_mesh: options.format is not a MeshFormat");
}

io::RawMesh read_raw(const std::string& path, const ReadOptions& options)
{
    const io::InputFile file(path);
    return read_raw(file.bytes(), path, options,
                    std::filesystem::path(path).parent_path().string());
}

}  // namespace

MeshFile read_mesh_file(std::span<const std::byte> content, const std::string& name,
                        const ReadOptions& options)
{
    return io::to_mesh_file(read_raw(content, name, options, std::nullopt));
}

PolygonMesh read_polygons(std::span<const std::byte> content, const std::string& name,
                          const ReadOptions& options)
{
    return read_mesh_file(content, name, options).mesh;
}

IndexedMesh read_mesh(std::span<const std::byte> content, const std::string& name,
                      const ReadOptions& options)
{
    return io::to_indexed_mesh(read_raw(content, name, options, std::nullopt));
}

MeshFile read_mesh_file(const std::string& path, const ReadOptions& options)
{
    return io::to_mesh_file(read_raw(path, options));
}

PolygonMesh read_polygons(const std::string& path, const ReadOptions& options)
{
    return read_mesh_file(path, options).mesh;
}

IndexedMesh read_mesh(const std::string& path, const ReadOptions& options)
{
    return io::to_indexed_mesh(read_raw(path, options));
}

}  // namespace genus
