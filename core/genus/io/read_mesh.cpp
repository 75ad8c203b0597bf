#include "genus/io/read_mesh.h"

#include <utility>

#include "genus/base/error.h"
#include "genus/io/input_file.h"
#include "genus/io/obj.h"
#include "genus/io/off.h"
#include "genus/io/ply.h"
#include "genus/io/raw_mesh.h"
#include "genus/io/stl.h"
#include "genus/io/text.h"

namespace genus {

namespace {

MeshFormat choose_format(std::span<const std::byte> content, const std::string& name,
                         const ReadOptions& options)
{
    if (options.format) return *options.format;
    if (const auto format = format_of_content(content)) return *format;
    if (const auto format = format_of_extension(name)) return *format;
    if (io::looks_like_obj(io::as_text(content))) return MeshFormat::obj;
    throw FileError(name, "is in no mesh format known here (stl, obj, off, ply)");
}

io::RawMesh read_raw(std::span<const std::byte> content, const std::string& name,
                     const ReadOptions& options)
{
    if (content.empty()) throw FileError(name, "is empty");
    switch (choose_format(content, name, options)) {
        case MeshFormat::stl:
            return io::read_stl(content, name);
        case MeshFormat::obj:
            return io::read_obj(content, name);
        case MeshFormat::off:
            return io::read_off(content, name);
        case MeshFormat::ply:
            return io::read_ply(content, name);
    }
    throw InvalidInput("read_mesh: options.format is not a MeshFormat");
}

}  // namespace

MeshFile read_mesh_file(std::span<const std::byte> content, const std::string& name,
                        const ReadOptions& options)
{
    return io::to_mesh_file(read_raw(content, name, options));
}

PolygonMesh read_polygons(std::span<const std::byte> content, const std::string& name,
                          const ReadOptions& options)
{
    return read_mesh_file(content, name, options).mesh;
}

IndexedMesh read_mesh(std::span<const std::byte> content, const std::string& name,
                      const ReadOptions& options)
{
    return io::to_indexed_mesh(read_raw(content, name, options));
}

MeshFile read_mesh_file(const std::string& path, const ReadOptions& options)
{
    return read_mesh_file(io::InputFile(path).bytes(), path, options);
}

PolygonMesh read_polygons(const std::string& path, const ReadOptions& options)
{
    return read_polygons(io::InputFile(path).bytes(), path, options);
}

IndexedMesh read_mesh(const std::string& path, const ReadOptions& options)
{
    return read_mesh(io::InputFile(path).bytes(), path, options);
}

}  // namespace genus
