#include <string>

#include "arrays.h"
#include "bind.h"
#include "long_call.h"

#include <pybind11/stl.h>

namespace genus::python {

namespace {

Mesh make_mesh(const ArrayLike& vertices, const ArrayLike& faces)
{
    const PointArray points = to_point_array(vertices, "vertices");
    IndexedMesh mesh;
    mesh.vertices.assign(rows(points).begin(), rows(points).end());
    mesh.faces = to_triangles(faces, "faces", mesh.n_vertices());
    return Mesh(std::move(mesh));
}

py::dict stage_seconds(const Mesh& mesh)
{
    py::dict seconds;
    if (mesh.made)
        for (const auto& [stage, s] : mesh.made->seconds) seconds[py::str(stage)] = s;
    return seconds;
}

py::object explanation(const Mesh& mesh)
{
    return mesh.made ? py::cast(mesh.made->explanation) : py::none();
}

py::object error_report(const Mesh& mesh)
{
    return mesh.made ? py::cast(mesh.made->error) : py::none();
}

}  // namespace

void bind_mesh(py::module_& m)
{
    py::class_<Mesh>(
        m, "Mesh",
        R"(Triangles as numbers of shared vertices, counterclockwise seen from outside. Never changes.

>>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
>>> tetrahedron = genus.Mesh(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
>>> tetrahedron.vertices.shape, tetrahedron.faces.dtype.name
((4, 3), 'int32'))")
        .def(py::init(&make_mesh), py::arg("vertices"), py::arg("faces"),
             "vertices (n, 3) numbers, model units; faces (m, 3) vertex numbers.")
        .def_property_readonly(
            "vertices",
            [](const py::object& self) {
                return view(self.cast<const Mesh&>().triangles->vertices, self);
            },
            "(n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "faces",
            [](const py::object& self) {
                return view(self.cast<const Mesh&>().triangles->faces, self);
            },
            "(m, 3) int32, vertex numbers; a read-only view.")
        .def_property_readonly(
            "bounds", [](const Mesh& mesh) { return to_array(bounds(*mesh.triangles)); },
            "(2, 3) float64: lower and upper corner of the bounding box.")
        .def_property_readonly("error", &error_report,
                               "The ErrorReport of the call that made the mesh, else None.")
        .def_property_readonly("seconds", &stage_seconds,
                               "Seconds by stage of the call that made the mesh, in order.")
        .def("explain", &explanation,
             "What the call that made the mesh left out, an Explanation, else None.")
        .def("__len__", [](const Mesh& mesh) { return mesh.triangles->n_faces(); })
        .def("__repr__", [](const Mesh& mesh) {
            return "<genus.Mesh: " + std::to_string(mesh.triangles->n_vertices()) + " vertices, " +
                   std::to_string(mesh.triangles->n_faces()) + " triangles>";
        });
}

}  // namespace genus::python
