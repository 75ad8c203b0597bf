#include <cmath>
#include <string>

#include <pybind11/stl.h>

#include "bind.h"
#include "genus/base/error.h"
#include "genus/io/read_mesh.h"
#include "genus/io/write_mesh.h"
#include "long_call.h"
#include "paths.h"

namespace genus::python {

namespace {

// Those of these extensions that the library was built with.
std::vector<std::string> mesh_formats()
{
    std::vector<std::string> names;
    for (const char* name : {"stl", "obj", "off", "ply", "gltf", "glb", "3mf", "amf"})
        if (format_of_extension(std::string("part.") + name)) names.emplace_back(name);
    return names;
}

std::string joined(const std::vector<std::string>& names)
{
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

std::optional<MeshFormat> to_format(const std::optional<std::string>& name)
{
    if (!name) return std::nullopt;
    const auto format = format_of_extension("part." + *name);
    if (!format)
        throw InvalidInput("format is \"" + *name + "\", must be one of " + joined(mesh_formats()));
    return format;
}

Mesh load(const Path& path, const std::optional<std::string>& format, const py::object& progress)
{
    const ReadOptions options{to_format(format)};
    return Mesh(long_call([&] { return read_mesh(path.text, options); }, progress));
}

void save(const Mesh& mesh, const Path& path, const std::optional<std::string>& format, bool ascii,
          const py::object& progress)
{
    const WriteOptions options{to_format(format), ascii};
    long_call([&] { write_mesh(path.text, *mesh.triangles, options); }, progress);
}

void scale_vertices(PolygonMesh& mesh, double scale)
{
    for (Vec3& v : mesh.vertices) v *= scale;
}

py::dict convert(const Path& source, const Path& target, const std::optional<std::string>& format,
                 bool ascii, double scale, const py::object& progress)
{
    require(std::isfinite(scale) && scale > 0, "convert: scale", scale, "positive");
    const WriteOptions options{to_format(format), ascii};
    const PolygonMesh mesh = long_call(
        [&] {
            MeshFile file = read_mesh_file(source.text);
            if (scale != 1.0) scale_vertices(file.mesh, scale);
            write_mesh_file(target.text, file, options);
            return std::move(file.mesh);
        },
        progress);
    py::dict counts;
    counts["vertices"] = mesh.n_vertices();
    counts["faces"] = mesh.n_faces();
    return counts;
}

}  // namespace

void bind_io(py::module_& m, py::class_<Mesh>& mesh)
{
    m.def("mesh_formats", &mesh_formats, "Extensions of the mesh files that are read and written.");
    m.def("load", &load, py::arg("path"), py::kw_only(), py::arg("format") = py::none(),
          py::arg("progress") = py::none(),
          R"(Read a mesh from a file; faces of more corners are cut to triangles.

format : one of mesh_formats(); by content, then by the path's extension, if left out

Raises FileError with the byte or line of what is wrong.

>>> genus.cube(1).mesh().save("cube.ply")
>>> genus.load("cube.ply").volume
1.0)");
    m.def("convert", &convert, py::arg("source"), py::arg("target"), py::kw_only(),
          py::arg("format") = py::none(), py::arg("ascii") = false, py::arg("scale") = 1.0,
          py::arg("progress") = py::none(),
          R"(Write a mesh file in another format; faces of any degree and colours are kept where the
format has them. Returns the numbers of vertices and faces.

format : of the target; by its extension if left out
ascii : text where the format also has a binary form
scale : factor on all coordinates)");
    mesh.def("save", &save, py::arg("path"), py::kw_only(), py::arg("format") = py::none(),
             py::arg("ascii") = false, py::arg("progress") = py::none(),
             R"(Write a mesh file, whole or not at all.

format : by the path's extension if left out
ascii : text where the format also has a binary form)");
}

}  // namespace genus::python
