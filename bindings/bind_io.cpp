#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>

#include <pybind11/stl.h>

#include "bind.h"
#include "forms.h"
#include "genus/base/error.h"
#include "genus/io/mend_file.h"
#include "genus/io/read_mesh.h"
#include "genus/io/stream.h"
#include "genus/io/write_mesh.h"
#include "genus/mesh/validate.h"
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

Polygons load_polygons(const Path& path, const std::optional<std::string>& format,
                       const py::object& progress)
{
    const ReadOptions options{to_format(format)};
    return Polygons(long_call([&] { return read_polygons(path.text, options); }, progress));
}

void save_polygons(const Polygons& mesh, const Path& path, const std::optional<std::string>& format,
                   bool ascii, const py::object& progress)
{
    const WriteOptions options{to_format(format), ascii};
    long_call([&, m = mesh.mesh] { write_mesh(path.text, *m, options); }, progress);
}

struct Conversion {
    WriteOptions write;
    double scale = 1.0;
    std::optional<double> unit, from_unit;  // millimetres
    std::optional<double> weld;
    bool repair = false;
    bool check = false;
};

// Files that would fill the memory, and that need not be known as a whole.
bool too_large(const std::string& path)
{
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    const double memory = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                          static_cast<double>(::sysconf(_SC_PAGESIZE));
    constexpr double kShare = 0.25;  // welded in memory, the mesh takes up to twice the file
    return !error && memory > 0.0 && static_cast<double>(size) > kShare * memory;
}

bool takes_whole_file(const Conversion& c)
{
    return c.weld || c.repair || c.check || c.unit;
}

bool shall_stream(const std::string& source, const std::string& target, const Conversion& c,
                  const std::optional<bool>& asked)
{
    if (asked.value_or(false) && takes_whole_file(c))
        throw InvalidInput(
            "convert: weld, repair, check and unit need the whole file, not a stream");
    if (asked) return *asked;
    const auto format = c.write.format ? c.write.format : format_of_extension(target);
    return !takes_whole_file(c) && too_large(source) && format && can_stream(source, *format);
}

void set_unit(MeshFile& file, const std::string& source, const Conversion& c)
{
    if (c.from_unit) file.unit = *c.from_unit;
    if (!c.unit) return;
    if (file.unit <= 0.0)
        throw FileError(source, "states no unit, so that none can be converted (from_unit)");
    scale_file(file, file.unit / *c.unit);
    file.unit = *c.unit;
}

void check_file(const MeshFile& file, const std::string& source)
{
    ValidateOptions options;
    options.max_findings = 1;
    const Validation v = validate(to_triangles(file.mesh), options);
    if (v.ok()) return;
    std::int64_t n = 0;
    for (const std::int64_t count : v.counts) n += count;
    const std::string others = n > 1 ? " (and " + std::to_string(n - 1) + " more findings)" : "";
    throw FileError(source, "is not the border of a solid: " + v.findings[0].text + others);
}

py::dict to_dict(const RepairReport& r)
{
    py::dict d;
    d["welded_vertices"] = r.welded_vertices;
    d["degenerate_faces"] = r.degenerate_faces;
    d["duplicate_faces"] = r.duplicate_faces;
    d["t_junctions"] = r.t_junctions;
    d["turned_faces"] = r.turned_faces;
    d["split_vertices"] = r.split_vertices;
    d["closed_holes"] = r.closed_holes;
    d["added_faces"] = r.added_faces;
    d["open_edges"] = r.open_edges;
    return d;
}

py::dict convert_whole(const std::string& source, const std::string& target, const Conversion& c,
                       const py::object& progress)
{
    MeshFile file;
    std::int64_t n_welded = 0;
    RepairReport repaired;
    long_call(
        [&] {
            file = read_mesh_file(source);
            set_unit(file, source, c);
            if (c.scale != 1.0) scale_file(file, c.scale);
            if (c.weld) n_welded = weld_file(file, *c.weld);
            if (c.repair) repaired = repair_file(file, {});
            if (c.check) check_file(file, source);
            write_mesh_file(target, file, c.write);
        },
        progress);
    py::dict counts;
    counts["vertices"] = file.mesh.n_vertices();
    counts["faces"] = file.mesh.n_faces();
    if (c.weld) counts["welded_vertices"] = n_welded;
    if (c.repair) counts["repair"] = to_dict(repaired);
    return counts;
}

py::dict convert(const Path& source, const Path& target, const std::optional<std::string>& format,
                 bool ascii, double scale, const std::optional<std::string>& unit,
                 const std::optional<std::string>& from_unit, const std::optional<double>& weld,
                 bool repair, bool check, const std::optional<bool>& stream,
                 const py::object& progress)
{
    require(std::isfinite(scale) && scale > 0, "convert: scale", scale, "positive");
    Conversion c{{to_format(format), ascii}, scale, {}, {}, weld, repair, check};
    if (unit) c.unit = unit_millimetres(*unit);
    if (from_unit) c.from_unit = unit_millimetres(*from_unit);
    if (!shall_stream(source.text, target.text, c, stream))
        return convert_whole(source.text, target.text, c, progress);
    const StreamCounts n = long_call(
        [&] { return stream_mesh(source.text, target.text, c.write, c.scale); }, progress);
    py::dict counts;
    counts["vertices"] = n.vertices;
    counts["faces"] = n.faces;
    counts["streamed"] = true;
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
    m.def("load_polygons", &load_polygons, py::arg("path"), py::kw_only(),
          py::arg("format") = py::none(), py::arg("progress") = py::none(),
          "Read a mesh from a file, faces of any degree as they are: a PolygonMesh.");
    m.def("convert", &convert, py::arg("source"), py::arg("target"), py::kw_only(),
          py::arg("format") = py::none(), py::arg("ascii") = false, py::arg("scale") = 1.0,
          py::arg("unit") = py::none(), py::arg("from_unit") = py::none(),
          py::arg("weld") = py::none(), py::arg("repair") = false, py::arg("check") = false,
          py::arg("stream") = py::none(), py::arg("progress") = py::none(),
          R"(Write a mesh file in another format; faces of any degree and colours are kept where the
format has them. Returns the numbers of vertices and faces, and what was mended.

format : of the target; by its extension if left out
ascii : text where the format also has a binary form
scale : factor on all lengths, whatever their unit
unit : of the target's numbers: mm, cm, m, um, in, ft; the source must state its own, or from_unit
from_unit : of the source's numbers, before what it states itself
weld : join vertices within this distance, in the target's numbers
repair : mend what can be mended, as Mesh.repair does; cuts faces into triangles
check : raise FileError, and write nothing, unless the mesh is the border of a solid
stream : binary STL to STL, PLY, OBJ or OFF piece by piece in constant memory, vertices not shared;
    if left out, where the file would fill the memory

Formats that have units state them: 3MF and AMF as they are, glTF in metres.)");
    mesh.def("save", &save, py::arg("path"), py::kw_only(), py::arg("format") = py::none(),
             py::arg("ascii") = false, py::arg("progress") = py::none(),
             R"(Write a mesh file, whole or not at all.

format : by the path's extension if left out
ascii : text where the format also has a binary form)");
    py::reinterpret_borrow<py::class_<Polygons>>(m.attr("PolygonMesh"))
        .def("save", &save_polygons, py::arg("path"), py::kw_only(), py::arg("format") = py::none(),
             py::arg("ascii") = false, py::arg("progress") = py::none(),
             "Write a mesh file, whole or not at all.");
}

}  // namespace genus::python
