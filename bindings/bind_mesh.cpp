#include <string>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"
#include "genus/mesh/distance.h"
#include "genus/mesh/validate.h"
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

void bind_copies(py::class_<Mesh>& cls)
{
    const auto same = [](const py::object& self, const py::args&) { return self; };
    cls.def("__copy__", same, "Itself: a mesh never changes.")
        .def("__deepcopy__", same, "Itself: a mesh never changes.")
        .def(
            "__reduce__",
            [](const py::object& self) {
                return py::make_tuple(py::type::of(self),
                                      py::make_tuple(self.attr("vertices"), self.attr("faces")));
            },
            "For pickle: vertices and faces, not the record of the call that made it.");
}

py::object explanation(const Mesh& mesh)
{
    if (mesh.made) return py::cast(mesh.made->explanation);
    return mesh.origin ? py::cast(mesh.origin->explanation) : py::none();
}

py::object error_report(const Mesh& mesh)
{
    return mesh.made ? py::cast(mesh.made->error) : py::none();
}

py::array inertia(const Mesh& mesh)
{
    const auto& m = measures_of(mesh).inertia;
    return py::array_t<double>(std::vector<py::ssize_t>{3, 3}, m[0].data());
}

py::list complex_edges(const Topology& t)
{
    py::list edges;
    for (const ComplexEdge& e : t.complex_edges) edges.append(py::make_tuple(e.a, e.b, e.faces));
    return edges;
}

py::list complex_vertices(const Topology& t)
{
    py::list vertices;
    for (const ComplexVertex& v : t.complex_vertices)
        vertices.append(py::make_tuple(v.vertex, v.fans));
    return vertices;
}

py::list flipped_edges(const Topology& t)
{
    py::list edges;
    for (const FlippedEdge& e : t.flipped_edges) edges.append(py::make_tuple(e.a, e.b, e.faces));
    return edges;
}

template <class Class>
void bind_surface_kind(Class& c)
{
    c.def_readonly("vertices", &SurfaceKind::vertices)
        .def_readonly("edges", &SurfaceKind::edges)
        .def_readonly("faces", &SurfaceKind::faces)
        .def_readonly("boundary_edges", &SurfaceKind::boundary_edges)
        .def_readonly("boundary_loops", &SurfaceKind::boundary_loops,
                      "Closed curves of edges with one face only.")
        .def_readonly("euler", &SurfaceKind::euler, "V - E + F.")
        .def_readonly("genus", &SurfaceKind::genus,
                      "Handles, summed over components; None unless manifold and orientable.")
        .def_readonly("closed", &SurfaceKind::closed, "Every edge has at least two faces.")
        .def_readonly("oriented", &SurfaceKind::oriented,
                      "The two faces of an edge run along it in opposite directions.")
        .def_readonly("orientable", &SurfaceKind::orientable,
                      "Faces could be turned so that they do.")
        .def_readonly("manifold", &SurfaceKind::manifold, "No complex edge or vertex.");
}

std::string describe(const char* name, const SurfaceKind& kind)
{
    return std::string("<genus.") + name + ": V - E + F = " + std::to_string(kind.vertices) +
           " - " + std::to_string(kind.edges) + " + " + std::to_string(kind.faces) + " = " +
           std::to_string(kind.euler) + (kind.closed ? ", closed" : ", open") +
           (kind.manifold ? ", manifold>" : ", not manifold>");
}

std::vector<Finding> validate_mesh(const Mesh& mesh, bool self_intersections,
                                   std::size_t max_findings, const py::object& progress)
{
    const ValidateOptions options{self_intersections, max_findings};
    return long_call(
        [&, triangles = mesh.triangles] { return validate(*triangles, options).findings; },
        progress);
}

MeshDistance distance(const Mesh& a, const Mesh& b, const py::object& progress)
{
    return long_call([x = a.triangles, y = b.triangles] { return mesh_distance(*x, *y); },
                     progress);
}

void bind_distance(py::module_& m)
{
    py::class_<MeshDistance>(m, "MeshDistance", "How far two surfaces are apart, model units.")
        .def_readonly("max", &MeshDistance::max,
                      "Largest distance found, both ways; the true one is not below it.")
        .def_readonly("mean", &MeshDistance::mean, "Mean over the surfaces, the larger of the two.")
        .def_readonly("bound", &MeshDistance::bound, "The true largest distance is not above it.")
        .def("__repr__", [](const MeshDistance& d) {
            return "<genus.MeshDistance: max " + to_text(d.max) + ", mean " + to_text(d.mean) + ">";
        });
}

void bind_validation(py::module_& m)
{
    py::class_<Finding>(m, "Finding", "One thing that keeps a mesh from bounding a solid.")
        .def_property_readonly(
            "defect", [](const Finding& f) { return name(f.defect); },
            "Its kind: \"open edge\", ...")
        .def_readonly("vertices", &Finding::vertices, "The vertices concerned.")
        .def_readonly("faces", &Finding::faces, "The faces concerned.")
        .def_property_readonly(
            "at", [](const Finding& f) { return f.at.c; }, "A point of it, model units.")
        .def("__str__", [](const Finding& f) { return f.text; })
        .def("__repr__", [](const Finding& f) { return "<genus.Finding: " + f.text + ">"; });
}

void bind_topology(py::module_& m)
{
    py::class_<SurfaceKind, std::shared_ptr<SurfaceKind>> kind(
        m, "SurfaceKind", "What holds of a mesh, or of one component of it, as a surface.");
    bind_surface_kind(kind);
    kind.def("__repr__", [](const SurfaceKind& k) { return describe("SurfaceKind", k); });

    // Shared with the mesh it was made from.
    py::class_<Topology, SurfaceKind, std::shared_ptr<Topology>>(
        m, "Topology", "What holds of a mesh as a surface, whatever its shape.")
        .def_property_readonly(
            "components", [](const Topology& t) { return t.components.size(); },
            "Number of parts that hang together by vertices.")
        .def_property_readonly(
            "parts", [](const Topology& t) { return t.components; },
            "The same for each component, in the order of their smallest vertex.")
        .def_property_readonly(
            "component_of_vertex",
            [](const Topology& t) { return to_array(t.component_of_vertex); },
            "(n,) int32, -1 for vertices that no face names.")
        .def_readonly("isolated_vertices", &Topology::isolated_vertices,
                      "How many vertices no face names.")
        .def_readonly("degenerate_faces", &Topology::degenerate_faces,
                      "Faces with a vertex twice; left out of all else.")
        .def_property_readonly("complex_edges", &complex_edges,
                               "Edges of more than two faces: list of (a, b, faces).")
        .def_property_readonly("complex_vertices", &complex_vertices,
                               "Vertices whose faces form several fans: list of (vertex, fans).")
        .def_property_readonly(
            "flipped_edges", &flipped_edges,
            "Edges whose two faces run along them in the same direction: list of (a, b, faces).")
        .def_readonly("mean_valence", &Topology::mean_valence, "Edges a vertex, on average.")
        .def("__repr__", [](const Topology& t) { return describe("Topology", t); });
}

}  // namespace

const Topology& topology_of(const Mesh& mesh)
{
    if (!mesh.topology)
        mesh.topology = std::make_shared<const Topology>(
            long_call([triangles = mesh.triangles] { return topology(*triangles); }));
    return *mesh.topology;
}

const Measures& measures_of(const Mesh& mesh)
{
    if (!mesh.measures)
        mesh.measures = long_call([triangles = mesh.triangles] { return measure(*triangles); });
    return *mesh.measures;
}

py::class_<Mesh> bind_mesh(py::module_& m)
{
    bind_topology(m);
    bind_validation(m);
    bind_distance(m);
    py::class_<Mesh> cls(
        m, "Mesh",
        R"(Triangles as numbers of shared vertices, counterclockwise seen from outside. Never changes.

>>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
>>> tetrahedron = genus.Mesh(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
>>> tetrahedron.vertices.shape, tetrahedron.faces.dtype.name
((4, 3), 'int32'))");
    cls.def(py::init(&make_mesh), py::arg("vertices"), py::arg("faces"),
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
        .def_property_readonly(
            "volume", [](const Mesh& mesh) { return measures_of(mesh).volume; },
            "Volume inside, cubic model units; negative for a mesh turned inside out.")
        .def_property_readonly(
            "area", [](const Mesh& mesh) { return measures_of(mesh).area; },
            "Area of all faces, square model units.")
        .def_property_readonly(
            "centroid", [](const Mesh& mesh) { return to_array(measures_of(mesh).centroid); },
            "(3,) float64: centre of mass of the inside.")
        .def_property_readonly("inertia", &inertia,
                               "(3, 3) float64: inertia about the centroid at density 1.")
        .def_property_readonly(
            "is_closed", [](const Mesh& mesh) { return topology_of(mesh).closed; },
            "True if every edge has at least two faces.")
        .def_property_readonly(
            "topology",
            [](const Mesh& mesh) {
                topology_of(mesh);
                return std::const_pointer_cast<Topology>(mesh.topology);
            },
            R"(What holds of the mesh as a surface, a Topology.

>>> t = genus.cube(1).mesh().topology
>>> t.euler, t.genus, t.components, t.closed, t.manifold
(2, 0, 1, True, True))")
        .def_property_readonly("error", &error_report,
                               "The ErrorReport of the call that made the mesh, else None.")
        .def_property_readonly("seconds", &stage_seconds,
                               "Seconds by stage of the call that made the mesh, in order.")
        .def("report", &report,
             "All of this and what the mesh is, a dict of plain values that prints as a table.")
        .def("validate", &validate_mesh, py::kw_only(), py::arg("self_intersections") = true,
             py::arg("max_findings") = 100, py::arg("progress") = py::none(),
             R"(What keeps the mesh from bounding a solid: a list of Finding, empty if nothing does.

>>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
>>> [finding.defect for finding in genus.Mesh(corners, [[0, 1, 2]]).validate()]
['open edge', 'open edge', 'open edge'])")
        .def(
            "distance", &distance, py::arg("other"), py::kw_only(),
            py::arg("progress") = py::none(),
            R"(Distance between two surfaces as sets of points: a MeshDistance with max, mean, bound.

>>> corners, faces = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]
>>> lifted = genus.Mesh([[0, 0, 2], [1, 0, 2], [0, 1, 2]], faces)
>>> genus.Mesh(corners, faces).distance(lifted).max
2.0)")
        .def("explain", &explanation,
             "What the call that made the mesh left out, an Explanation, else None.")
        .def("__len__", [](const Mesh& mesh) { return mesh.triangles->n_faces(); })
        .def("__repr__", [](const Mesh& mesh) {
            return "<genus.Mesh: " + std::to_string(mesh.triangles->n_vertices()) + " vertices, " +
                   std::to_string(mesh.triangles->n_faces()) + " triangles>";
        });
    bind_copies(cls);
    return cls;
}

}  // namespace genus::python
