#include "genus/io/write_mesh.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/io/gltf.h"
#include "genus/io/obj.h"
#include "genus/io/off.h"
#include "genus/io/output_file.h"
#include "genus/io/ply.h"
#include "genus/io/stl.h"
#include "genus/io/xml_formats.h"

namespace genus {

namespace {

constexpr std::size_t kGrain = std::size_t{1} << 16;

MeshFormat choose_format(const std::string& path, const WriteOptions& options)
{
    if (options.format) return *options.format;
    if (const auto format = format_of_extension(path)) return *format;
    throw FileError(
        path,
        "its extension names no mesh format known here (stl, obj, off, ply, glb, gltf, 3mf, amf)");
}

void check_positions(const std::vector<Vec3>& vertices)
{
    parallel_for(vertices.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Vec3 sum;  // of zeros, as long as all are finite
        for (std::size_t v = begin; v < end; ++v) sum += vertices[v] * 0.0;
        if (is_finite(sum)) return;
        while (is_finite(vertices[begin])) ++begin;
        throw InvalidInput("write_mesh: vertex " + std::to_string(begin) + " is not finite");
    });
}

template <class Face>
void check_faces(std::size_t n_faces, std::size_t n_vertices, const Face& face)
{
    const auto is_valid = [&](std::size_t f) {
        const std::span<const std::int32_t> corners = face(f);
        bool valid = corners.size() >= 3;
        for (const std::int32_t v : corners) valid &= static_cast<std::uint32_t>(v) < n_vertices;
        return valid;
    };
    parallel_for(n_faces, kGrain, [&](std::size_t begin, std::size_t end) {
        bool valid = true;
        for (std::size_t f = begin; f < end; ++f) valid &= is_valid(f);
        if (valid) return;
        while (is_valid(begin)) ++begin;
        throw InvalidInput("write_mesh: face " + std::to_string(begin) +
                           (face(begin).size() < 3 ? " has fewer than three corners"
                                                   : " names a vertex that does not exist"));
    });
}

void check(const IndexedMesh& mesh)
{
    check_positions(mesh.vertices);
    check_faces(mesh.n_faces(), mesh.n_vertices(),
                [&](std::size_t f) { return std::span<const std::int32_t>(mesh.faces[f]); });
}

void check(const MeshFile& file)
{
    check_positions(file.mesh.vertices);
    check_faces(file.mesh.n_faces(), file.mesh.n_vertices(),
                [&](std::size_t f) { return file.mesh.face(f); });
    require(file.vertex_colors.empty() || file.vertex_colors.size() == file.mesh.n_vertices(),
            "write_mesh_file: vertex_colors must be empty or have one colour per vertex");
    require(file.face_colors.empty() || file.face_colors.size() == file.mesh.n_faces(),
            "write_mesh_file: face_colors must be empty or have one colour per face");
}

void write_scene(io::Output& output, const MeshFile& file, MeshFormat format)
{
    if (format == MeshFormat::three_mf)
        io::write_3mf(output, file);
    else if (format == MeshFormat::amf)
        io::write_amf(output, file);
    else
        io::write_gltf(output, file, format == MeshFormat::glb);
}

void write_to(io::Output& output, const IndexedMesh& mesh, MeshFormat format, bool ascii)
{
    check(mesh);
    switch (format) {
        case MeshFormat::stl:
            return io::write_stl(output, mesh, ascii);
        case MeshFormat::obj:
            return io::write_obj(output, mesh);
        case MeshFormat::off:
            return io::write_off(output, mesh);
        case MeshFormat::ply:
            return io::write_ply(output, mesh, ascii);
        case MeshFormat::glb:
        case MeshFormat::gltf:
        case MeshFormat::three_mf:
        case MeshFormat::amf:
            return write_scene(output, {to_polygons(mesh), {}, {}}, format);
    }
    throw InvalidInput("write_mesh: options.format is not a MeshFormat");
}

void write_to(io::Output& output, const MeshFile& file, MeshFormat format, bool ascii)
{
    check(file);
    switch (format) {
        case MeshFormat::stl:
            return io::write_stl(output, to_triangles(file.mesh), ascii);
        case MeshFormat::obj:
            return io::write_obj(output, file);
        case MeshFormat::off:
            return io::write_off(output, file);
        case MeshFormat::ply:
            return io::write_ply(output, file, ascii);
        case MeshFormat::glb:
        case MeshFormat::gltf:
        case MeshFormat::three_mf:
        case MeshFormat::amf:
            return write_scene(output, file, format);
    }
    throw InvalidInput("write_mesh: options.format is not a MeshFormat");
}

// The materials of an OBJ file stand in a file of their own beside it.
void write_painted_obj(const std::string& path, const MeshFile& file)
{
    check(file);
    std::filesystem::path library = std::filesystem::path(path).replace_extension(".mtl");
    if (library == path) library += ".mtl";
    io::OutputFile materials(library.string()), output(path);
    io::write_obj_materials(materials, file);
    io::write_obj(output, file, library.filename().string());
    materials.commit();
    output.commit();
}

// A pipe has no place beside it.
bool may_have_companion(const std::string& path)
{
    std::error_code error;
    return !std::filesystem::exists(path, error) || std::filesystem::is_regular_file(path, error);
}

template <class Mesh>
void write_file(const std::string& path, const Mesh& mesh, const WriteOptions& options)
{
    const MeshFormat format = choose_format(path, options);
    io::OutputFile output(path);
    write_to(output, mesh, format, options.ascii);
    output.commit();
}

template <class Mesh>
std::vector<std::byte> write_bytes(const Mesh& mesh, MeshFormat format, bool ascii)
{
    io::OutputBytes output(std::string("<") + format_name(format) + ">");
    write_to(output, mesh, format, ascii);
    return std::move(output).take();
}

}  // namespace

void write_mesh(const std::string& path, const IndexedMesh& mesh, const WriteOptions& options)
{
    write_file(path, mesh, options);
}

void write_mesh(const std::string& path, const PolygonMesh& mesh, const WriteOptions& options)
{
    write_file(path, MeshFile{mesh, {}, {}}, options);
}

void write_mesh_file(const std::string& path, const MeshFile& file, const WriteOptions& options)
{
    const bool painted =
        choose_format(path, options) == MeshFormat::obj && !file.face_colors.empty();
    if (painted && may_have_companion(path)) return write_painted_obj(path, file);
    write_file(path, file, options);
}

std::vector<std::byte> mesh_bytes(const IndexedMesh& mesh, MeshFormat format, bool ascii)
{
    return write_bytes(mesh, format, ascii);
}

std::vector<std::byte> mesh_bytes(const MeshFile& file, MeshFormat format, bool ascii)
{
    return write_bytes(file, format, ascii);
}

}  // namespace genus
