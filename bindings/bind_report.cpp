#include <pybind11/stl.h>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"

// What a call tells about itself: error, time, what was left out. Plain values for reports, so that
// writing one imports no numpy.
namespace genus::python {

namespace {

using Pairs = std::vector<std::pair<std::string, double>>;

py::dict to_dict(const Pairs& pairs)
{
    py::dict dict;
    for (const auto& [name, value] : pairs) dict[py::str(name)] = value;
    return dict;
}

py::list entries(const Explanation& explanation)
{
    py::list list;
    for (const auto& e : explanation.entries) list.append(py::make_tuple(e.what, e.count, e.unit));
    return list;
}

py::dict surface(const Topology& t)
{
    py::dict d;
    d["vertices"] = t.vertices;
    d["edges"] = t.edges;
    d["faces"] = t.faces;
    d["euler"] = t.euler;
    d["genus"] = t.genus;
    d["components"] = t.components.size();
    d["boundary_loops"] = t.boundary_loops;
    d["closed"] = t.closed;
    d["oriented"] = t.oriented;
    d["manifold"] = t.manifold;
    d["complex_edges"] = t.complex_edges.size();
    d["complex_vertices"] = t.complex_vertices.size();
    d["degenerate_faces"] = t.degenerate_faces.size();
    return d;
}

py::list corners(const Box3& box)
{
    py::list list;
    if (box.empty()) return list;
    list.append(py::cast(box.min.c));
    list.append(py::cast(box.max.c));
    return list;
}

py::dict error_values(const ErrorReport& error, bool was_measured)
{
    py::dict d;
    d["bound"] = error.bound;
    d["certified"] = error.certified;
    d["doubt"] = error.doubt;
    d["measured"] = was_measured ? py::cast(error.measured) : py::none();
    d["parts"] = to_dict(error.parts);
    return d;
}

}  // namespace

py::dict stage_seconds(const Mesh& mesh)
{
    return mesh.made ? to_dict(mesh.made->seconds) : py::dict();
}

py::object report(const Mesh& mesh)
{
    py::dict d = surface(topology_of(mesh));
    d["bounds"] = corners(bounds(*mesh.triangles));
    d["volume"] = measures_of(mesh).volume;
    d["area"] = measures_of(mesh).area;
    if (mesh.made) {
        d["method"] = mesh.made->method;
        d["tolerance"] = mesh.made->tolerance;
        d["error"] = error_values(mesh.made->error, mesh.was_measured);
        d["seconds"] = stage_seconds(mesh);
        d["seconds"]["total"] = mesh.seconds;
        d["left_out"] = entries(mesh.made->explanation);
    }
    return py::module_::import("genus.report.table").attr("MeshReport")(d);
}

void bind_reports(py::module_& m)
{
    py::class_<Explanation>(m, "Explanation", "What was left out of a scene, and why.")
        .def_property_readonly("entries", &entries, "List of (what, count, unit).")
        .def("__str__", &Explanation::to_text)
        .def("__repr__", [](const Explanation& e) {
            return "<genus.Explanation: " + std::to_string(e.entries.size()) + " entries>";
        });

    py::class_<ErrorReport>(m, "ErrorReport",
                            "How far mesh and exact solid are apart, in model units.")
        .def_readonly("bound", &ErrorReport::bound,
                      "No point of either surface is farther than this from the other.")
        .def_readonly("certified", &ErrorReport::certified,
                      "True if the bound is proven, False if estimated.")
        .def_readonly("measured", &ErrorReport::measured,
                      "Largest distance found by sampling both ways.")
        .def_property_readonly(
            "parts", [](const ErrorReport& e) { return to_dict(e.parts); },
            "Share of each cause in the bound, model units, largest first.")
        .def_readonly("doubt", &ErrorReport::doubt,
                      "What is not proven, and near which place; empty if certified.")
        .def("__repr__", [](const ErrorReport& e) {
            return "<genus.ErrorReport: bound " + to_text(e.bound) + ", measured " +
                   to_text(e.measured) + (e.certified ? ", certified>" : ", estimated>");
        });
}

}  // namespace genus::python
