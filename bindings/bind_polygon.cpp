#include <string>

#include <pybind11/stl.h>

#include "forms.h"
#include "genus/base/error.h"
#include "genus/mesh/dual.h"
#include "genus/mesh/platonic.h"
#include "genus/mesh/shapes.h"
#include "genus/mesh/validate.h"
#include "genus/polygon/triangulate.h"
#include "long_call.h"

namespace genus::python {

namespace {

// ---- plane polygons ---------------------------------------------------------------------------

Ring to_ring(const py::handle& value, const std::string& argument)
{
    const auto points =
        py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
    if (!points) {
        PyErr_Clear();
        throw py::value_error(argument + ": expected numbers of shape (n, 2)");
    }
    if (points.size() == 0) return {};
    if (points.ndim() != 2 || points.shape(1) != 2)
        throw py::value_error(argument + ": expected an array of shape (n, 2), got shape " +
                              py::str(points.attr("shape")).cast<std::string>());
    Ring ring(static_cast<std::size_t>(points.shape(0)));
    const double* x = points.data();
    for (Vec2& p : ring) {
        p = {{x[0], x[1]}};
        x += 2;
    }
    return ring;
}

TriangulateMethod to_method(const std::string& name)
{
    if (name == "auto") return TriangulateMethod::Auto;
    if (name == "ear") return TriangulateMethod::Ear;
    if (name == "sweep") return TriangulateMethod::Sweep;
    if (name == "delaunay") return TriangulateMethod::Delaunay;
    throw InvalidInput("triangulate: method is \"" + name +
                       "\", must be one of auto, ear, sweep, delaunay");
}

py::array triangulate_polygon(const ArrayLike& polygon, const py::iterable& holes,
                              const std::string& method, const py::object& progress)
{
    Polygon rings{to_ring(polygon, "polygon"), {}};
    for (const py::handle hole : holes)
        rings.holes.push_back(to_ring(hole, "holes[" + std::to_string(rings.holes.size()) + "]"));
    const TriangulateMethod how = to_method(method);
    auto triangles = std::make_shared<const std::vector<PolygonTriangle>>(
        long_call([&] { return triangulate(rings, how); }, progress));
    return shared_rows<std::int32_t>(triangles, *triangles);
}

void bind_triangulate(py::module_& m)
{
    m.def("triangulate", &triangulate_polygon, py::arg("polygon"), py::arg("holes") = py::tuple(),
          py::arg("method") = "auto", py::kw_only(), py::arg("progress") = py::none(),
          R"(Cut a plane polygon into triangles without new points: (k, 3) int32.

polygon : (n, 2) points of the outer ring, of either orientation
holes : rings inside it, (n, 2) each
method : "ear" (corner cutting, best-shaped corner first), "sweep" (O(n log n)), "delaunay"
    (constrained Delaunay, from the sweep by flips), or "auto": ear for few points, else sweep

The numbers name points: the outer ring first, then the holes. Triangles turn counterclockwise and
have positive area; every edge of the polygon is a side. n - 2 + 2 h triangles for n points and h
holes that touch nothing. Rings that cross are refused, with the points that do.

>>> square, hole = [[0, 0], [4, 0], [4, 4], [0, 4]], [[1, 1], [2, 1], [2, 2], [1, 2]]
>>> genus.triangulate(square, [hole]).shape
(8, 3))");
}

// ---- meshes of polygons -----------------------------------------------------------------------

Polygons make_polygons(const ArrayLike& vertices, const py::object& faces)
{
    return Polygons(to_polygon_mesh(vertices, faces));
}

// One array where all faces have as many corners.
py::object faces_of(const Polygons& p)
{
    const PolygonMesh& mesh = *p.mesh;
    const std::int32_t* data = mesh.corners.data();
    const auto degree = [&](std::size_t f) { return mesh.starts[f + 1] - mesh.starts[f]; };
    bool uniform = mesh.n_faces() > 0;
    for (std::size_t f = 1; f < mesh.n_faces(); ++f) uniform &= degree(f) == degree(0);
    constexpr py::ssize_t size = sizeof(std::int32_t);
    if (uniform)
        return shared_view(p.mesh, data, {static_cast<py::ssize_t>(mesh.n_faces()), degree(0)},
                           {size * degree(0), size});
    py::list faces;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f)
        faces.append(shared_view(p.mesh, data + mesh.starts[f], {degree(f)}, {size}));
    return faces;
}

const Topology& polygon_topology(const Polygons& p)
{
    if (!p.topology)
        p.topology = std::make_shared<const Topology>(
            long_call([mesh = p.mesh] { return topology(*mesh); }));
    return *p.topology;
}

std::vector<Finding> validate_polygons(const Polygons& p, bool self_intersections,
                                       std::size_t max_findings, const py::object& progress)
{
    const ValidateOptions options{self_intersections, max_findings};
    return long_call([&, mesh = p.mesh] { return validate(to_triangles(*mesh), options).findings; },
                     progress);
}

void bind_measures(py::class_<Polygons>& c)
{
    const auto measures = [](const Polygons& p) -> const Measures& {
        return measures_of(triangles_of(p));
    };
    c.def_property_readonly(
         "bounds", [](const Polygons& p) { return to_array(bounds(*p.mesh)); },
         "(2, 3) float64: lower and upper corner of the bounding box.")
        .def_property_readonly(
            "volume", [=](const Polygons& p) { return measures(p).volume; },
            "Volume inside, cubic model units.")
        .def_property_readonly(
            "area", [=](const Polygons& p) { return measures(p).area; },
            "Area of all faces, square model units.")
        .def_property_readonly(
            "centroid", [=](const Polygons& p) { return to_array(measures(p).centroid); },
            "(3,) float64: centre of mass of the inside.")
        .def_property_readonly(
            "is_closed", [](const Polygons& p) { return polygon_topology(p).closed; },
            "True if every edge has at least two faces.")
        .def_property_readonly(
            "topology",
            [](const Polygons& p) {
                polygon_topology(p);
                return std::const_pointer_cast<Topology>(p.topology);
            },
            "What holds of the mesh as a surface, a Topology.")
        .def("validate", &validate_polygons, py::kw_only(), py::arg("self_intersections") = true,
             py::arg("max_findings") = 100, py::arg("progress") = py::none(),
             "What keeps the mesh, cut into triangles, from bounding a solid: a list of Finding.");
}

void bind_polygon_mesh(py::module_& m)
{
    py::class_<Polygons> c(m, "PolygonMesh",
                           R"(Faces of any degree over shared vertices. Never changes.

>>> cube = genus.platonic(4, 3)
>>> cube.faces.shape, cube.topology.euler
((6, 4), 2)
>>> prism = genus.prism(5, h=2)
>>> sorted(len(face) for face in prism.faces)
[4, 4, 4, 4, 4, 5, 5])");
    c.def(py::init(&make_polygons), py::arg("vertices"), py::arg("faces"),
          "vertices (n, 3) numbers, model units; faces: lists of vertex numbers, of any length.")
        .def_property_readonly(
            "vertices",
            [](const Polygons& p) { return shared_rows<double>(p.mesh, p.mesh->vertices); },
            "(n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "faces", &faces_of,
            "Vertex numbers, int32, read-only views: (m, k) where all faces have k corners, else\n"
            "a list of one array a face.")
        .def_property_readonly(
            "corners", [](const Polygons& p) { return shared_view(p.mesh, p.mesh->corners); },
            "Vertex numbers of all faces one after the other, int32, a read-only view.")
        .def_property_readonly(
            "starts", [](const Polygons& p) { return shared_view(p.mesh, p.mesh->starts); },
            "Where each face begins in corners, and their end: (m + 1,) int64.")
        .def(
            "triangles", [](const Polygons& p) { return triangles_of(p); },
            "The same with faces cut into triangles without new vertices: a Mesh.")
        .def(
            "dual",
            [](const Polygons& p) {
                return Polygons(long_call([mesh = p.mesh] { return dual(*mesh); }));
            },
            R"(The dual mesh: a vertex at the barycentre of each face, a face round each vertex.

>>> len(genus.platonic(4, 3).dual().faces)
8)")
        .def("__len__", [](const Polygons& p) { return p.mesh->n_faces(); })
        .def("__repr__", [](const Polygons& p) {
            return "<genus.PolygonMesh: " + std::to_string(p.mesh->n_vertices()) + " vertices, " +
                   std::to_string(p.mesh->n_faces()) + " faces>";
        });
    bind_measures(c);
}

// ---- meshes made of numbers -------------------------------------------------------------------

void bind_shapes(py::module_& m)
{
    m.def(
        "platonic", [](int p, int q) { return Polygons(platonic(p, q)); }, py::arg("p"),
        py::arg("q"),
        R"(The regular solid {p, q}, faces of p sides and q at each vertex, on the unit sphere.

Only (p - 2)(q - 2) < 4 is possible: {3,3} {4,3} {3,4} {5,3} {3,5}.

>>> [genus.platonic(p, q).topology.faces for p, q in [(3, 3), (4, 3), (3, 4), (5, 3), (3, 5)]]
[4, 6, 8, 12, 20])");
    m.def(
        "icosphere",
        [](double r, std::int32_t parts) {
            return Mesh(long_call([&] { return icosphere(parts, r); }));
        },
        py::arg("r") = 1.0, py::arg("parts") = 8,
        R"(A sphere of 20 parts^2 nearly equal triangles: an icosahedron with every edge in parts.

>>> len(genus.icosphere(r=10, parts=4))
320)");
    m.def(
        "grid",
        [](std::int32_t nx, std::int32_t ny, double width, double depth) {
            return Polygons(grid_mesh(nx, ny, width, depth));
        },
        py::arg("nx"), py::arg("ny"), py::arg("width") = 1.0, py::arg("depth") = 1.0,
        R"(A flat sheet of nx times ny quadrilaterals in the plane z = 0 that faces up.

>>> genus.grid(3, 2, width=6, depth=2).area
12.0)");
    m.def(
        "prism",
        [](std::int32_t n, double h, double r, bool center) {
            return Polygons(prism(n, h, r, center));
        },
        py::arg("n"), py::arg("h"), py::arg("r") = 1.0, py::arg("center") = false,
        R"(A right prism over a regular polygon of n corners on a circle of radius r.

>>> genus.prism(4, h=3).volume
6.0)");
    m.def(
        "torus_mesh",
        [](double R, double r, std::int32_t nu, std::int32_t nv) {
            return Polygons(torus_mesh(R, r, nu, nv));
        },
        py::arg("R"), py::arg("r"), py::arg("nu") = 48, py::arg("nv") = 24,
        R"(A ring of nu times nv quadrilaterals with their corners on a torus about the z axis.

>>> genus.torus_mesh(3, 1).topology.genus
1)");
}

}  // namespace

const Mesh& triangles_of(const Polygons& p)
{
    if (!p.triangles)
        p.triangles = Mesh(long_call([mesh = p.mesh] { return to_triangles(*mesh); }));
    return *p.triangles;
}

void bind_polygons(py::module_& m, py::class_<Mesh>& mesh)
{
    bind_triangulate(m);
    bind_polygon_mesh(m);
    bind_shapes(m);
    mesh.def(
            "polygons", [](const Mesh& x) { return Polygons(to_polygons(*x.triangles)); },
            "The same as a PolygonMesh.")
        .def(
            "dual",
            [](const Mesh& x) {
                return Polygons(long_call([t = x.triangles] { return dual(*t); }));
            },
            R"(The dual of a closed mesh, a PolygonMesh: a vertex at the barycentre of each face, a
face round each vertex, an edge across each edge.

>>> genus.icosphere(parts=1).dual().topology.faces
12)");
}

}  // namespace genus::python
