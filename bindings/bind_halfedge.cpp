#include <string>

#include <pybind11/stl.h>

#include "forms.h"
#include "genus/base/error.h"
#include "genus/mesh/face_mesh.h"
#include "genus/mesh/halfedge_mesh.h"
#include "genus/mesh/loop_mesh.h"
#include "genus/mesh/rings.h"
#include "genus/mesh/strips.h"
#include "genus/mesh/triangle_list.h"
#include "genus/mesh/winged_edge_mesh.h"
#include "long_call.h"

// The storage forms. Arrays are views of the form's own memory, never copies. A form that operators
// change is copied first where views or circulators of it are still alive: they go on to show it as
// it was, and nothing dangles.
namespace genus::python {

namespace {

using Bytes = std::size_t;

// ---- halfedges --------------------------------------------------------------------------------

struct Halfedges {
    std::shared_ptr<HalfedgeMesh> mesh;

    explicit Halfedges(HalfedgeMesh m) : mesh(std::make_shared<HalfedgeMesh>(std::move(m))) {}

    const HalfedgeMesh& read() const { return *mesh; }
    HalfedgeMesh& write()
    {
        if (mesh.use_count() > 1) mesh = std::make_shared<HalfedgeMesh>(*mesh);
        return *mesh;
    }
};

template <class H>
H to_handle(const HalfedgeMesh& mesh, std::int64_t i, std::size_t slots, const char* what)
{
    if (i < 0 || static_cast<std::size_t>(i) >= slots || !mesh.is_alive(H(static_cast<int>(i))))
        throw InvalidInput("there is no " + std::string(what) + " " + std::to_string(i));
    return H(static_cast<std::int32_t>(i));
}
Vertex to_vertex(const HalfedgeMesh& mesh, std::int64_t i)
{
    return to_handle<Vertex>(mesh, i, mesh.vertex_slots(), "vertex");
}
Halfedge to_halfedge(const HalfedgeMesh& mesh, std::int64_t i)
{
    return to_handle<Halfedge>(mesh, i, mesh.halfedge_slots(), "halfedge");
}
Face to_face(const HalfedgeMesh& mesh, std::int64_t i)
{
    return to_handle<Face>(mesh, i, mesh.face_slots(), "face");
}

// Steps along halfedges, as in the notes: until it is back where it began.
struct Circulator {
    std::shared_ptr<const HalfedgeMesh> mesh;
    Halfedge first, at;
    bool round_vertex;

    std::int32_t next()
    {
        if (!at.valid()) throw py::stop_iteration();
        const Halfedge h = at;
        at = round_vertex ? mesh->turned(h) : mesh->next(h);
        if (at == first) at = Halfedge();
        return h.index;
    }
};

Circulator circulate(const Halfedges& x, Halfedge first, bool round_vertex)
{
    return {x.mesh, first, first, round_vertex};
}

template <class H>
py::array alive(const HalfedgeMesh& mesh, std::size_t slots)
{
    std::vector<std::int32_t> numbers;
    for (std::size_t i = 0; i < slots; ++i)
        if (mesh.is_alive(H(i))) numbers.push_back(static_cast<std::int32_t>(i));
    return to_array(std::move(numbers));
}

py::tuple rings_to_tuple(OneRings rings)
{
    return py::make_tuple(to_array(std::move(rings.starts)), to_array(std::move(rings.vertices)));
}

// Values (n,) or (n, k) give sums of the same shape.
template <class Form>
py::array sums(const Form& form, std::size_t n_vertices, const ArrayLike& values)
{
    const auto array =
        py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(values);
    if (!array) {
        PyErr_Clear();
        throw py::value_error("values: expected numbers of shape (n,) or (n, k)");
    }
    if (array.ndim() < 1 || array.ndim() > 2 ||
        array.shape(0) != static_cast<py::ssize_t>(n_vertices))
        throw py::value_error("values: expected one row for each of the " +
                              std::to_string(n_vertices) + " vertices, got shape " +
                              py::str(array.attr("shape")).cast<std::string>());
    const auto width = static_cast<std::size_t>(array.ndim() == 2 ? array.shape(1) : 1);
    const std::span<const double> span(array.data(), static_cast<std::size_t>(array.size()));
    auto out = std::make_shared<const std::vector<double>>(
        long_call([&] { return ring_sums(form, span, width); }));
    const std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
    return py::array(shared_view(out, *out).attr("reshape")(shape));
}

template <class Link>
py::array link_view(const Halfedges& x, Link&& link)
{
    return shared_view<std::int32_t>(x.mesh, link(x.read().arrays()));
}

void bind_halfedge_arrays(py::class_<Halfedges>& c)
{
    using Arrays = HalfedgeMesh::Arrays;
    c.def_property_readonly(
         "points",
         [](const Halfedges& x) { return shared_rows<double>(x.mesh, x.read().arrays().points); },
         "(n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "opposite",
            [](const Halfedges& x) {
                return link_view(
                    x, [](const Arrays& a) -> auto& { return a.opposite; });
            },
            "Of each halfedge the one there and back, int32, a view; so are those that follow.\n"
            "Entries of removed elements are -2.")
        .def_property_readonly(
            "next",
            [](const Halfedges& x) {
                return link_view(
                    x, [](const Arrays& a) -> auto& { return a.next; });
            },
            "Of each halfedge the next one round its face, or along the boundary.")
        .def_property_readonly(
            "to",
            [](const Halfedges& x) {
                return link_view(
                    x, [](const Arrays& a) -> auto& { return a.to; });
            },
            "Of each halfedge the vertex to which it leads.")
        .def_property_readonly(
            "face",
            [](const Halfedges& x) {
                return link_view(
                    x, [](const Arrays& a) -> auto& { return a.face; });
            },
            "Of each halfedge its face, -1 along the boundary.")
        .def_property_readonly(
            "vertex_halfedge",
            [](const Halfedges& x) {
                return link_view(
                    x, [](const Arrays& a) -> auto& { return a.vertex_halfedge; });
            },
            "Of each vertex a halfedge that leaves it, that on the boundary if there is one; -1 "
            "for\n"
            "an isolated vertex.")
        .def_property_readonly(
            "face_halfedge",
            [](const Halfedges& x) {
                return link_view(
                    x, [](const Arrays& a) -> auto& { return a.face_halfedge; });
            },
            "Of each face one of its halfedges.")
        .def(
            "vertices",
            [](const Halfedges& x) { return alive<Vertex>(x.read(), x.read().vertex_slots()); },
            "Numbers of the vertices that are there, int32.")
        .def(
            "halfedges",
            [](const Halfedges& x) { return alive<Halfedge>(x.read(), x.read().halfedge_slots()); },
            "Numbers of the halfedges that are there.")
        .def(
            "faces",
            [](const Halfedges& x) { return alive<Face>(x.read(), x.read().face_slots()); },
            "Numbers of the faces that are there.");
}

void bind_halfedge_counts(py::class_<Halfedges>& c)
{
    c.def_property_readonly("n_vertices", [](const Halfedges& x) { return x.read().n_vertices(); })
        .def_property_readonly("n_edges", [](const Halfedges& x) { return x.read().n_edges(); })
        .def_property_readonly("n_faces", [](const Halfedges& x) { return x.read().n_faces(); })
        .def_property_readonly(
            "euler",
            [](const Halfedges& x) {
                const HalfedgeMesh& m = x.read();
                return static_cast<std::int64_t>(m.n_vertices()) -
                       static_cast<std::int64_t>(m.n_edges()) +
                       static_cast<std::int64_t>(m.n_faces());
            },
            "V - E + F.")
        .def(
            "memory_bytes",
            [](const Halfedges& x, Bytes coordinate) { return x.read().memory_bytes(coordinate); },
            py::arg("bytes_per_coordinate") = sizeof(double),
            "Bytes of points and connectivity, at so many bytes a coordinate.")
        .def(
            "check", [](const Halfedges& x) { x.read().check(); },
            "Raises InvalidInput naming the first element whose links contradict each other.");
}

void bind_halfedge_walks(py::class_<Halfedges>& c)
{
    c.def(
         "outgoing",
         [](const Halfedges& x, std::int64_t vertex) {
             return circulate(x, x.read().halfedge(to_vertex(x.read(), vertex)), true);
         },
         py::arg("vertex"), "Circulator over the halfedges that leave a vertex, clockwise.")
        .def(
            "around",
            [](const Halfedges& x, std::int64_t face) {
                return circulate(x, x.read().halfedge(to_face(x.read(), face)), false);
            },
            py::arg("face"), "Circulator over the halfedges of a face, counterclockwise.")
        .def(
            "loop",
            [](const Halfedges& x, std::int64_t halfedge) {
                return circulate(x, to_halfedge(x.read(), halfedge), false);
            },
            py::arg("halfedge"), "Circulator along the face or boundary loop of a halfedge.")
        .def(
            "vertex_ring",
            [](const Halfedges& x, std::int64_t vertex) {
                std::vector<std::int32_t> ring;
                for (const Halfedge h : x.read().outgoing(to_vertex(x.read(), vertex)))
                    ring.push_back(x.read().to(h).index);
                return ring;
            },
            py::arg("vertex"), "The neighbours of a vertex, clockwise.")
        .def(
            "face_ring",
            [](const Halfedges& x, std::int64_t vertex) {
                std::vector<std::int32_t> ring;
                for (const Halfedge h : x.read().outgoing(to_vertex(x.read(), vertex)))
                    if (!x.read().is_boundary(h)) ring.push_back(x.read().face(h).index);
                return ring;
            },
            py::arg("vertex"), "The faces at a vertex, clockwise.")
        .def(
            "face_vertices",
            [](const Halfedges& x, std::int64_t face) {
                std::vector<std::int32_t> ring;
                for (const Halfedge h : x.read().around(to_face(x.read(), face)))
                    ring.push_back(x.read().from(h).index);
                return ring;
            },
            py::arg("face"), "The corners of a face, counterclockwise.")
        .def(
            "ends",
            [](const Halfedges& x, std::int64_t halfedge) {
                const Halfedge h = to_halfedge(x.read(), halfedge);
                return py::make_tuple(x.read().from(h).index, x.read().to(h).index);
            },
            py::arg("halfedge"), "The two vertices of a halfedge: from, to.")
        .def(
            "find",
            [](const Halfedges& x, std::int64_t a, std::int64_t b) -> std::optional<std::int32_t> {
                const HalfedgeMesh& m = x.read();
                const Halfedge h = m.find(to_vertex(m, a), to_vertex(m, b));
                return h.valid() ? std::optional(h.index) : std::nullopt;
            },
            py::arg("a"), py::arg("b"), "The halfedge from vertex a to b, None if there is none.")
        .def(
            "previous",
            [](const Halfedges& x, std::int64_t halfedge) {
                return x.read().previous(to_halfedge(x.read(), halfedge)).index;
            },
            py::arg("halfedge"), "The halfedge before this one round its face.")
        .def(
            "valence",
            [](const Halfedges& x, std::int64_t vertex) {
                return x.read().valence(to_vertex(x.read(), vertex));
            },
            py::arg("vertex"), "The number of edges at a vertex.")
        .def(
            "degree",
            [](const Halfedges& x, std::int64_t face) {
                return x.read().degree(to_face(x.read(), face));
            },
            py::arg("face"), "The number of corners of a face.")
        .def(
            "boundary_loops",
            [](const Halfedges& x) {
                std::vector<std::int32_t> loops;
                for (const Halfedge h : x.read().boundary_loops()) loops.push_back(h.index);
                return loops;
            },
            "One halfedge of each boundary loop; follow it with loop().")
        .def(
            "one_rings",
            [](const Halfedges& x) {
                return rings_to_tuple(long_call([&] { return one_rings(x.read()); }));
            },
            "(starts, vertices): the neighbours of vertex v, counterclockwise, are\n"
            "vertices[starts[v]:starts[v + 1]].")
        .def(
            "ring_sums",
            [](const Halfedges& x, const ArrayLike& values) {
                return sums(x.read(), x.read().vertex_slots(), values);
            },
            py::arg("values"),
            "For each vertex the sum of its neighbours' values, (n,) or (n, k).");
}

void bind_halfedge_operators(py::class_<Halfedges>& c)
{
    c.def(
         "split_face",
         [](Halfedges& x, std::int64_t face, const VectorLike& point) {
             const Face f = to_face(x.read(), face);
             return x.write().split_face(f, to_vec3(point, "point")).index;
         },
         py::arg("face"), py::arg("point"),
         "Join a new vertex to all corners of a face; returns its number.")
        .def(
            "cut_face",
            [](Halfedges& x, std::int64_t a, std::int64_t b) {
                const Halfedge h = to_halfedge(x.read(), a), g = to_halfedge(x.read(), b);
                return x.write().split_face(h, g).index;
            },
            py::arg("a"), py::arg("b"),
            "Cut a face by an edge from the start of halfedge a to the start of b; returns it.")
        .def(
            "join_faces",
            [](Halfedges& x, std::int64_t halfedge) {
                const Halfedge h = to_halfedge(x.read(), halfedge);
                x.write().join_faces(h);
            },
            py::arg("halfedge"), "Remove the edge between two faces; that of the halfedge stays.")
        .def(
            "split_edge",
            [](Halfedges& x, std::int64_t halfedge, const VectorLike& point) {
                const Halfedge h = to_halfedge(x.read(), halfedge);
                return x.write().split_edge(h, to_vec3(point, "point")).index;
            },
            py::arg("halfedge"), py::arg("point"),
            "Put a new vertex on an edge, cutting triangles beside it; returns its number.")
        .def(
            "flip_edge",
            [](Halfedges& x, std::int64_t halfedge) {
                const Halfedge h = to_halfedge(x.read(), halfedge);
                x.write().flip_edge(h);
            },
            py::arg("halfedge"), "Turn the edge between two triangles.")
        .def(
            "can_flip_edge",
            [](const Halfedges& x, std::int64_t halfedge) {
                return x.read().can_flip_edge(to_halfedge(x.read(), halfedge));
            },
            py::arg("halfedge"))
        .def(
            "collapse_edge",
            [](Halfedges& x, std::int64_t halfedge) {
                const Halfedge h = to_halfedge(x.read(), halfedge);
                x.write().collapse_edge(h);
            },
            py::arg("halfedge"),
            "Draw the start of a halfedge into its end, where the link condition allows it.")
        .def(
            "can_collapse_edge",
            [](const Halfedges& x, std::int64_t halfedge) {
                return x.read().can_collapse_edge(to_halfedge(x.read(), halfedge));
            },
            py::arg("halfedge"), "Whether the link condition holds.")
        .def(
            "set_point",
            [](Halfedges& x, std::int64_t vertex, const VectorLike& point) {
                const Vertex v = to_vertex(x.read(), vertex);
                x.write().point(v) = to_vec3(point, "point");
            },
            py::arg("vertex"), py::arg("point"), "Move a vertex.")
        .def(
            "compact", [](Halfedges& x) { x.write().compact(); },
            "Give the elements that are there the numbers 0, 1, 2, ... in their order.");
}

void bind_halfedge_mesh(py::module_& m)
{
    py::class_<Circulator>(m, "Circulator", "Steps along halfedges until back where it began.")
        .def("__iter__", [](Circulator& x) -> Circulator& { return x; })
        .def("__next__", &Circulator::next);
    py::class_<Halfedges> c(
        m, "HalfedgeMesh",
        R"(The halfedge form: faces of any degree; each halfedge knows its opposite, the vertex to
which it leads, its face, and the next one round it. Elements are numbers. Arrays are views without
copies; those taken before an operator go on to show the mesh as it was.

>>> mesh = genus.icosphere(parts=2).halfedge()
>>> [mesh.to[h] for h in mesh.outgoing(0)] == mesh.vertex_ring(0)
True
>>> vertex = mesh.split_face(0, mesh.points[mesh.face_vertices(0)].mean(axis=0))
>>> mesh.n_vertices, mesh.euler
(43, 2))");
    c.def(py::init([](const Mesh& x) {
              return Halfedges(long_call([&] { return HalfedgeMesh(*x.triangles); }));
          }),
          py::arg("mesh"),
          "From triangles or polygons; raises InvalidInput naming the first\n"
          "element that is not manifold.")
        .def(py::init([](const Polygons& x) {
                 return Halfedges(long_call([&] { return HalfedgeMesh(*x.mesh); }));
             }),
             py::arg("mesh"));
    bind_halfedge_counts(c);
    bind_halfedge_arrays(c);
    bind_halfedge_walks(c);
    bind_halfedge_operators(c);
    c.def(
         "polygons", [](const Halfedges& x) { return Polygons(x.read().to_polygons()); },
         "What is there, as a PolygonMesh.")
        .def(
            "mesh", [](const Halfedges& x) { return Mesh(to_triangles(x.read().to_polygons())); },
            "What is there, faces cut into triangles, as a Mesh.")
        .def("__repr__", [](const Halfedges& x) {
            return "<genus.HalfedgeMesh: " + std::to_string(x.read().n_vertices()) + " vertices, " +
                   std::to_string(x.read().n_edges()) + " edges, " +
                   std::to_string(x.read().n_faces()) + " faces>";
        });
}

// ---- directed edges ---------------------------------------------------------------------------

struct DirectedEdges {
    std::shared_ptr<const TriangleHalfedgeMesh> mesh;
};

void bind_directed_edges(py::module_& m)
{
    py::class_<DirectedEdges>(
        m, "TriangleHalfedgeMesh",
        R"(The halfedge form for triangles, small and fast: halfedge 3 f + i runs along face f from
its corner i, so that only the opposite is stored.

>>> mesh = genus.icosphere(parts=10).triangle_halfedge()
>>> bool((mesh.opposite[mesh.opposite] == range(len(mesh.opposite))).all())
True)")
        .def_property_readonly(
            "points",
            [](const DirectedEdges& x) {
                return shared_rows<double>(x.mesh, x.mesh->indexed().vertices);
            },
            "(n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "corners",
            [](const DirectedEdges& x) {
                return shared_rows<std::int32_t>(x.mesh, x.mesh->indexed().faces);
            },
            "(m, 3) int32: from where each halfedge runs; a view.")
        .def_property_readonly(
            "opposite",
            [](const DirectedEdges& x) { return shared_view(x.mesh, x.mesh->opposites()); },
            "(3 m,) int32, -1 on the boundary; a view.")
        .def_property_readonly(
            "vertex_halfedge",
            [](const DirectedEdges& x) { return shared_view(x.mesh, x.mesh->vertex_halfedges()); },
            "(n,) int32: one that leaves each vertex, -1 if there is none; a view.")
        .def(
            "vertex_ring",
            [](const DirectedEdges& x, std::int64_t vertex) {
                if (vertex < 0 || static_cast<std::size_t>(vertex) >= x.mesh->n_vertices())
                    throw InvalidInput("there is no vertex " + std::to_string(vertex));
                std::vector<std::int32_t> ring;
                x.mesh->visit_ring(Vertex(static_cast<std::int32_t>(vertex)),
                                   [&](Vertex w) { ring.push_back(w.index); });
                return ring;
            },
            py::arg("vertex"), "The neighbours of a vertex, counterclockwise.")
        .def(
            "one_rings",
            [](const DirectedEdges& x) {
                return rings_to_tuple(long_call([&] { return one_rings(*x.mesh); }));
            },
            "(starts, vertices): the neighbours of vertex v are vertices[starts[v]:starts[v + 1]].")
        .def(
            "ring_sums",
            [](const DirectedEdges& x, const ArrayLike& values) {
                return sums(*x.mesh, x.mesh->n_vertices(), values);
            },
            py::arg("values"), "For each vertex the sum of its neighbours' values, (n,) or (n, k).")
        .def(
            "memory_bytes", [](const DirectedEdges& x, Bytes b) { return x.mesh->memory_bytes(b); },
            py::arg("bytes_per_coordinate") = sizeof(double),
            "Bytes of points and connectivity, at so many bytes a coordinate.");
}

// ---- winged edges, faces, strips --------------------------------------------------------------

struct WingedEdges {
    std::shared_ptr<const WingedEdgeMesh> mesh;
};

using Wings = WingedEdgeMesh::Wings;

py::array wings_view(const WingedEdges& x, std::array<std::int32_t, 2> Wings::*part)
{
    static const Wings none{};
    const auto& edges = x.mesh->edges();
    const Wings& first = edges.empty() ? none : edges[0];
    return shared_view(x.mesh, (first.*part).data(), {static_cast<py::ssize_t>(edges.size()), 2},
                       {sizeof(Wings), sizeof(std::int32_t)});
}

void bind_winged_edges(py::module_& m)
{
    py::class_<WingedEdges> c(
        m, "WingedEdgeMesh",
        R"(The winged-edge form: each edge knows its two vertices, the faces on its left and right,
and the edges that follow and precede it round those faces.

>>> cube = genus.platonic(4, 3).winged_edge()
>>> cube.edge_vertices.shape, cube.edge_faces.shape, len(cube.face_edges(0))
((12, 2), (12, 2), 4))");
    c.def_property_readonly(
         "points",
         [](const WingedEdges& x) { return shared_rows<double>(x.mesh, x.mesh->points()); },
         "(n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "edge_vertices", [](const WingedEdges& x) { return wings_view(x, &Wings::vertices); },
            "(e, 2) int32: from, to; a view.")
        .def_property_readonly(
            "edge_faces", [](const WingedEdges& x) { return wings_view(x, &Wings::faces); },
            "(e, 2) int32: left, right; -1 beyond the boundary; a view.")
        .def_property_readonly(
            "edge_next", [](const WingedEdges& x) { return wings_view(x, &Wings::next); },
            "(e, 2) int32: the edge after this one round the left and the right face; a view.")
        .def_property_readonly(
            "edge_previous", [](const WingedEdges& x) { return wings_view(x, &Wings::previous); },
            "(e, 2) int32: the edge before this one; a view.")
        .def_property_readonly(
            "vertex_edge",
            [](const WingedEdges& x) { return shared_view(x.mesh, x.mesh->vertex_edges()); },
            "(n,) int32: an edge of each vertex, -1 if there is none; a view.")
        .def_property_readonly(
            "face_edge",
            [](const WingedEdges& x) { return shared_view(x.mesh, x.mesh->face_edges()); },
            "(m,) int32: an edge of each face; a view.")
        .def(
            "face_edges",
            [](const WingedEdges& x, std::int64_t face) {
                if (face < 0 || static_cast<std::size_t>(face) >= x.mesh->n_faces())
                    throw InvalidInput("there is no face " + std::to_string(face));
                std::vector<std::int32_t> edges;
                x.mesh->visit_face(Face(static_cast<std::int32_t>(face)),
                                   [&](Edge e, Vertex) { edges.push_back(e.index); });
                return edges;
            },
            py::arg("face"), "The edges of a face, counterclockwise.")
        .def(
            "vertex_edges",
            [](const WingedEdges& x, std::int64_t vertex) {
                if (vertex < 0 || static_cast<std::size_t>(vertex) >= x.mesh->n_vertices())
                    throw InvalidInput("there is no vertex " + std::to_string(vertex));
                std::vector<std::int32_t> edges;
                x.mesh->visit_vertex(Vertex(static_cast<std::int32_t>(vertex)),
                                     [&](Edge e) { edges.push_back(e.index); });
                return edges;
            },
            py::arg("vertex"), "The edges at a vertex, clockwise.")
        .def(
            "polygons", [](const WingedEdges& x) { return Polygons(x.mesh->to_polygons()); },
            "Back to shared vertices.")
        .def(
            "memory_bytes", [](const WingedEdges& x, Bytes b) { return x.mesh->memory_bytes(b); },
            py::arg("bytes_per_coordinate") = sizeof(double),
            "Bytes of points and connectivity, at so many bytes a coordinate.");
}

struct Faces {
    std::shared_ptr<const FaceMesh> mesh;
};

void bind_face_mesh(py::module_& m)
{
    py::class_<Faces>(m, "FaceMesh",
                      R"(The face-based form: each triangle knows its corners and its neighbours.

>>> mesh = genus.icosphere(parts=3).face_based()
>>> mesh.neighbours.shape, len(mesh.vertex_faces(0))
((180, 3), 5))")
        .def_property_readonly(
            "points",
            [](const Faces& x) { return shared_rows<double>(x.mesh, x.mesh->indexed().vertices); },
            "(n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "corners",
            [](const Faces& x) {
                return shared_rows<std::int32_t>(x.mesh, x.mesh->indexed().faces);
            },
            "(m, 3) int32; a view.")
        .def_property_readonly(
            "neighbours",
            [](const Faces& x) { return shared_rows<std::int32_t>(x.mesh, x.mesh->neighbours()); },
            "(m, 3) int32: the face across the side from corner i to the next, -1 on the "
            "boundary;\n"
            "a view.")
        .def_property_readonly(
            "vertex_face",
            [](const Faces& x) { return shared_view(x.mesh, x.mesh->vertex_faces()); },
            "(n,) int32: a face of each vertex, -1 if there is none; a view.")
        .def(
            "vertex_faces",
            [](const Faces& x, std::int64_t vertex) {
                if (vertex < 0 || static_cast<std::size_t>(vertex) >= x.mesh->n_vertices())
                    throw InvalidInput("there is no vertex " + std::to_string(vertex));
                std::vector<std::int32_t> faces;
                x.mesh->visit_faces(Vertex(static_cast<std::int32_t>(vertex)),
                                    [&](Face f) { faces.push_back(f.index); });
                return faces;
            },
            py::arg("vertex"), "The faces at a vertex, counterclockwise.")
        .def(
            "memory_bytes", [](const Faces& x, Bytes b) { return x.mesh->memory_bytes(b); },
            py::arg("bytes_per_coordinate") = sizeof(double),
            "Bytes of points and connectivity, at so many bytes a coordinate.");
}

struct Strips {
    std::shared_ptr<const TriangleStrips> strips;
};

void bind_strips(py::module_& m)
{
    py::class_<Strips>(m, "TriangleStrips",
                       R"(Triangles in strips: every three neighbouring points of a strip are one.

>>> strips = genus.icosphere(parts=10).strips()
>>> strips.triangles_per_strip > 20
True)")
        .def_property_readonly(
            "points",
            [](const Strips& x) { return shared_rows<double>(x.strips, x.strips->points); },
            "(k, 3) float64, model units, strip after strip; a read-only view.")
        .def_property_readonly(
            "starts", [](const Strips& x) { return shared_view(x.strips, x.strips->starts); },
            "Where each strip begins in points, and their end, int32; a view.")
        .def_property_readonly("triangles_per_strip",
                               [](const Strips& x) { return x.strips->triangles_per_strip(); })
        .def("__len__", [](const Strips& x) { return x.strips->n_strips(); })
        .def(
            "mesh", [](const Strips& x) { return Mesh(to_indexed(*x.strips)); },
            "Back to shared vertices; equal points become one.")
        .def(
            "memory_bytes", [](const Strips& x, Bytes b) { return x.strips->memory_bytes(b); },
            py::arg("bytes_per_coordinate") = sizeof(double),
            "Bytes of points and starts, at so many bytes a coordinate.");
}

// ---- loops ------------------------------------------------------------------------------------

// A halfedge's number, or ~v for the lone vertex v.
LoopMesh::Corner to_corner(const LoopMesh& mesh, std::int32_t corner)
{
    if (corner >= 0) return Halfedge(corner);
    const Vertex v(~corner);
    return mesh.is_alive(v) ? LoopMesh::Corner(v) : LoopMesh::Corner(Vertex());
}

void bind_loop_operators(py::class_<LoopMesh>& c)
{
    c.def(
         "mvfs",
         [](LoopMesh& x, const VectorLike& point) { return x.mvfs(to_vec3(point, "point")).index; },
         py::arg("point"), "Make vertex, face, shell; returns the vertex.")
        .def(
            "kvfs", [](LoopMesh& x, std::int32_t vertex) { x.kvfs(Vertex(vertex)); },
            py::arg("vertex"), "Kill a shell of one vertex.")
        .def(
            "mev",
            [](LoopMesh& x, std::int32_t corner, const VectorLike& point) {
                return x.mev(to_corner(x, corner), to_vec3(point, "point")).index;
            },
            py::arg("corner"), py::arg("point"),
            "Make edge, vertex: an edge that dangles at the corner; returns the halfedge there.")
        .def(
            "split_vertex",
            [](LoopMesh& x, std::int32_t a, std::int32_t b, const VectorLike& point) {
                return x.mev(Halfedge(a), Halfedge(b), to_vec3(point, "point")).index;
            },
            py::arg("a"), py::arg("b"), py::arg("point"),
            "The general mev: the halfedges clockwise from a up to but not b leave the new vertex.")
        .def(
            "kev", [](LoopMesh& x, std::int32_t halfedge) { x.kev(Halfedge(halfedge)); },
            py::arg("halfedge"), "Kill edge, vertex: draws the end of the halfedge into its start.")
        .def(
            "mef",
            [](LoopMesh& x, std::int32_t a, std::int32_t b) {
                return x.mef(to_corner(x, a), to_corner(x, b)).index;
            },
            py::arg("a"), py::arg("b"),
            "Make edge, face: joins corners of one loop; the opposite bounds the new face.")
        .def(
            "kef", [](LoopMesh& x, std::int32_t halfedge) { x.kef(Halfedge(halfedge)); },
            py::arg("halfedge"), "Kill edge, face: the face across becomes part of this one.")
        .def(
            "kemr",
            [](LoopMesh& x, std::int32_t halfedge) { return x.kemr(Halfedge(halfedge)).index; },
            py::arg("halfedge"), "Kill edge, make ring; returns the loop of the ring.")
        .def(
            "mekr",
            [](LoopMesh& x, std::int32_t a, std::int32_t b) {
                return x.mekr(to_corner(x, a), to_corner(x, b)).index;
            },
            py::arg("a"), py::arg("b"),
            "Make edge, kill ring: joins corners of two loops of a face.")
        .def(
            "kfmrh", [](LoopMesh& x, std::int32_t f, std::int32_t g) { x.kfmrh(Face(f), Face(g)); },
            py::arg("f"), py::arg("g"),
            "Kill face, make ring and hole: the loop of g becomes a ring of f.")
        .def(
            "mfkrh", [](LoopMesh& x, std::int32_t ring) { return x.mfkrh(Loop(ring)).index; },
            py::arg("ring"), "Make face, kill ring and hole; returns the face.");
}

void bind_loop_mesh(py::module_& m)
{
    const auto demand = [](bool holds, const char* what, std::int32_t i) {
        if (!holds)
            throw InvalidInput(std::string("there is no ") + what + " " + std::to_string(i));
    };
    py::class_<LoopMesh> c(
        m, "LoopMesh",
        R"(Halfedges with loops and rings, for the make and kill operators. Each keeps
V - E + F - (L - F) = 2 (S - G). A corner is a place in a loop: the number of the halfedge that
leaves it, or ~v for the lone vertex v of a face that has just begun. The opposite of h is h ^ 1.

>>> mesh = genus.LoopMesh()
>>> a = mesh.mvfs([0, 0, 0])
>>> ab = mesh.mev(~a, [1, 0, 0])
>>> bc = mesh.mev(ab ^ 1, [0, 1, 0])
>>> ca = mesh.mef(bc ^ 1, ab)
>>> mesh.counts()
{'vertices': 3, 'edges': 3, 'faces': 2, 'loops': 2, 'shells': 1, 'genus': 0})");
    c.def(py::init<>());
    bind_loop_operators(c);
    c.def(
         "counts",
         [](const LoopMesh& x) {
             const EulerCounts n = x.counts();
             py::dict d;
             d["vertices"] = n.vertices;
             d["edges"] = n.edges;
             d["faces"] = n.faces;
             d["loops"] = n.loops;
             d["shells"] = n.shells;
             d["genus"] = n.genus();
             return d;
         },
         "V, E, F, L, S and G, a dict.")
        .def(
            "next",
            [=](const LoopMesh& x, std::int32_t h) {
                demand(x.is_alive(Halfedge(h)), "halfedge", h);
                return x.next(Halfedge(h)).index;
            },
            py::arg("halfedge"), "The next halfedge of its loop.")
        .def(
            "ends",
            [=](const LoopMesh& x, std::int32_t h) {
                demand(x.is_alive(Halfedge(h)), "halfedge", h);
                return py::make_tuple(x.from(Halfedge(h)).index, x.to(Halfedge(h)).index);
            },
            py::arg("halfedge"), "The vertices of a halfedge: from, to.")
        .def(
            "face",
            [=](const LoopMesh& x, std::int32_t h) {
                demand(x.is_alive(Halfedge(h)), "halfedge", h);
                return x.face(Halfedge(h)).index;
            },
            py::arg("halfedge"), "The face at the left of a halfedge.")
        .def(
            "loops",
            [=](const LoopMesh& x, std::int32_t f) {
                demand(x.is_alive(Face(f)), "face", f);
                std::vector<std::int32_t> loops;
                for (const Loop l : x.loops(Face(f))) loops.push_back(l.index);
                return loops;
            },
            py::arg("face"), "The loops of a face, the outer one first.")
        .def(
            "corner",
            [=](const LoopMesh& x, std::int32_t l) {
                demand(x.is_alive(Loop(l)), "loop", l);
                return x.halfedge(Loop(l)).valid() ? x.halfedge(Loop(l)).index
                                                   : ~x.vertex(Loop(l)).index;
            },
            py::arg("loop"), "A corner of a loop.")
        .def(
            "faces",
            [](const LoopMesh& x) {
                std::vector<std::int32_t> faces;
                for (std::size_t f = 0; f < x.face_slots(); ++f)
                    if (x.is_alive(Face(f))) faces.push_back(static_cast<std::int32_t>(f));
                return faces;
            },
            "Numbers of the faces that are there.")
        .def(
            "point",
            [=](const LoopMesh& x, std::int32_t v) {
                demand(x.is_alive(Vertex(v)), "vertex", v);
                return to_array(x.point(Vertex(v)));
            },
            py::arg("vertex"), "(3,) float64.")
        .def("check", &LoopMesh::check,
             "Raises InvalidInput naming the first element whose links contradict each other.")
        .def(
            "polygons", [](const LoopMesh& x) { return Polygons(x.to_polygons()); },
            "A PolygonMesh; faces with rings are cut into triangles.");
}

// ---- from meshes ------------------------------------------------------------------------------

py::array triangle_corners(const Mesh& x)
{
    auto list = std::make_shared<const TriangleList>(to_triangle_list(*x.triangles));
    constexpr py::ssize_t size = sizeof(double);
    return shared_view(list, reinterpret_cast<const double*>(list->triangles.data()),
                       {static_cast<py::ssize_t>(list->n_faces()), 3, 3},
                       {9 * size, 3 * size, size});
}

void bind_mesh_methods(py::class_<Mesh>& mesh)
{
    mesh.def(
            "halfedge",
            [](const Mesh& x) {
                return Halfedges(long_call([&] { return HalfedgeMesh(*x.triangles); }));
            },
            "The halfedge form, a HalfedgeMesh; raises InvalidInput naming the first element that\n"
            "is not manifold.")
        .def(
            "triangle_halfedge",
            [](const Mesh& x) {
                return DirectedEdges{std::make_shared<const TriangleHalfedgeMesh>(
                    long_call([&] { return TriangleHalfedgeMesh(*x.triangles); }))};
            },
            "The small halfedge form for triangles, a TriangleHalfedgeMesh.")
        .def(
            "winged_edge",
            [](const Mesh& x) {
                return WingedEdges{std::make_shared<const WingedEdgeMesh>(
                    long_call([&] { return WingedEdgeMesh(HalfedgeMesh(*x.triangles)); }))};
            },
            "The winged-edge form, a WingedEdgeMesh.")
        .def(
            "face_based",
            [](const Mesh& x) {
                return Faces{std::make_shared<const FaceMesh>(
                    long_call([&] { return FaceMesh(*x.triangles); }))};
            },
            "The face-based form, a FaceMesh.")
        .def(
            "strips",
            [](const Mesh& x) {
                return Strips{std::make_shared<const TriangleStrips>(
                    long_call([&] { return to_strips(*x.triangles); }))};
            },
            "The triangles in few strips, TriangleStrips.")
        .def("triangle_list", &triangle_corners,
             "(m, 3, 3) float64: every triangle with its own three points.");
}

}  // namespace

void bind_forms(py::module_& m, py::class_<Mesh>& mesh)
{
    bind_halfedge_mesh(m);
    bind_directed_edges(m);
    bind_winged_edges(m);
    bind_face_mesh(m);
    bind_strips(m);
    bind_loop_mesh(m);
    bind_mesh_methods(mesh);
    auto polygons = py::reinterpret_borrow<py::class_<Polygons>>(m.attr("PolygonMesh"));
    polygons
        .def(
            "halfedge",
            [](const Polygons& x) {
                return Halfedges(long_call([&] { return HalfedgeMesh(*x.mesh); }));
            },
            "The halfedge form, a HalfedgeMesh.")
        .def(
            "winged_edge",
            [](const Polygons& x) {
                return WingedEdges{std::make_shared<const WingedEdgeMesh>(
                    long_call([&] { return WingedEdgeMesh(*x.mesh); }))};
            },
            "The winged-edge form, a WingedEdgeMesh.");
}

}  // namespace genus::python
