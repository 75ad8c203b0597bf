#include <string>

#include "freeform.h"
#include "genus/base/progress.h"
#include "genus/io/patch_file.h"
#include "genus/patch/bspline_surface.h"
#include "genus/patch/patch_model.h"
#include "genus/patch/subdivision.h"
#include "paths.h"

namespace genus::python {

Mesh tessellated(const PatchModel& model, double tolerance, bool measure,
                 std::int64_t max_triangles, const py::object& progress)
{
    const double start = seconds_now();
    TessellateOptions options{tolerance, max_triangles};
    MeshedSolid made;
    long_call(
        [&] {
            TessellatedPatches t = model.tessellate(options);
            made.tolerance = tolerance;
            made.method = "patches";
            made.error.bound = t.bound;
            made.error.certified = true;
            made.error.parts = {{"patches", t.bound}};
            made.seconds.emplace_back("mesh", seconds_now() - start);
            if (measure) {
                const double before = seconds_now();
                made.error.measured = measured_deviation(model.patches(), t);
                made.seconds.emplace_back("measure", seconds_now() - before);
            }
            made.mesh = std::move(t.mesh);
        },
        progress);
    Mesh mesh(std::move(made));
    mesh.seconds = seconds_now() - start;
    mesh.was_measured = measure;
    return mesh;
}

namespace {

template <class P>
py::array points_at(const P& patch, const py::object& u, const py::object& v)
{
    const auto [at_u, at_v] = Parameters::broadcast(u, v);
    auto out = at_u.points();
    const auto points = writable_rows(out);
    bulk_call(at_u.size(),
              [&, &a = at_u, &b = at_v] { patch.evaluate(a.values(), b.values(), points); });
    return out;
}

template <class P>
py::tuple points_and_normals(const P& patch, const py::object& u, const py::object& v)
{
    const auto [at_u, at_v] = Parameters::broadcast(u, v);
    auto out = at_u.points(), out_normals = at_u.points();
    const auto points = writable_rows(out), normals = writable_rows(out_normals);
    bulk_call(at_u.size(), [&, &a = at_u, &b = at_v] {
        patch.evaluate(a.values(), b.values(), points, normals);
    });
    return py::make_tuple(out, out_normals);
}

template <class P>
py::dict partials_at(const P& patch, double u, double v)
{
    const SurfacePoint s = patch.partials(u, v);
    py::dict d;
    d["p"] = to_array(s.p);
    d["u"] = to_array(s.pu);
    d["v"] = to_array(s.pv);
    d["uu"] = to_array(s.puu);
    d["uv"] = to_array(s.puv);
    d["vv"] = to_array(s.pvv);
    return d;
}

template <class P>
py::dict curvature_at(const P& patch, double u, double v)
{
    const Curvatures c = patch.curvature(u, v);
    py::dict d;
    d["gaussian"] = c.gaussian;
    d["mean"] = c.mean;
    d["least"] = c.least;
    d["most"] = c.most;
    return d;
}

PatchModel model_of(const TensorPatch& p)
{
    return PatchModel({p});
}
PatchModel model_of(const BezierTriangle& p)
{
    return PatchModel({p});
}
PatchModel model_of(const BSplineSurface& s)
{
    std::vector<Patch> patches;
    for (TensorPatch& p : s.bezier_patches()) patches.emplace_back(std::move(p));
    return PatchModel(std::move(patches));
}

PatchModel make_model(const py::iterable& items)
{
    std::vector<Patch> patches;
    const auto add = [&](const PatchModel& model) {
        patches.insert(patches.end(), model.patches().begin(), model.patches().end());
    };
    for (const py::handle item : items) {
        if (py::isinstance<TensorPatch>(item))
            patches.emplace_back(item.cast<const TensorPatch&>());
        else if (py::isinstance<BezierTriangle>(item))
            patches.emplace_back(item.cast<const BezierTriangle&>());
        else if (py::isinstance<BSplineSurface>(item))
            add(model_of(item.cast<const BSplineSurface&>()));
        else if (py::isinstance<PatchModel>(item))
            add(item.cast<const PatchModel&>());
        else
            throw py::type_error(
                "PatchModel: a patch is a TensorPatch, TrianglePatch, "
                "BSplineSurface or PatchModel");
    }
    return long_call([&] { return PatchModel(std::move(patches)); });
}

// What all surfaces have.
template <class P>
void bind_common(py::class_<P>& c)
{
    c.def(
         "evaluate",
         [](const P& p, const py::object& u, const py::object& v) { return points_at(p, u, v); },
         py::arg("u"), py::arg("v"),
         "Points at parameters of any shapes that broadcast, (..., 3), vectorised.")
        .def(
            "normals",
            [](const P& p, const py::object& u, const py::object& v) -> py::object {
                return points_and_normals(p, u, v)[1];
            },
            py::arg("u"), py::arg("v"),
            "Unit normals, (..., 3), along the cross product of the partials; limits at degenerate "
            "corners.")
        .def(
            "points_and_normals",
            [](const P& p, const py::object& u, const py::object& v) {
                return points_and_normals(p, u, v);
            },
            py::arg("u"), py::arg("v"), "Both in one pass: (points, normals).")
        .def("partials", &partials_at<P>, py::arg("u"), py::arg("v"),
             "Point and partial derivatives at one place: a dict with p, u, v, uu, uv, vv.")
        .def("curvature", &curvature_at<P>, py::arg("u"), py::arg("v"),
             "A dict: gaussian, mean, least and most (principal) curvature, 1 / model units.")
        .def(
            "bounds", [](const P& p) { return to_array(p.bounds()); },
            "Box of the control points, (2, 3).")
        .def(
            "mesh",
            [](const P& p, double tolerance, bool measure, std::int64_t max_triangles,
               const py::object& progress) {
                return tessellated(model_of(p), tolerance, measure, max_triangles, progress);
            },
            py::arg("tolerance"), py::kw_only(), py::arg("measure") = true,
            py::arg("max_triangles") = TessellateOptions{}.max_triangles,
            py::arg("progress") = py::none(),
            "Mesh no farther than tolerance from the surface, both ways, with its error.");
}

template <class P>
py::tuple split_tensor(const P& p, const py::object& u, const py::object& v)
{
    if (u.is_none() && v.is_none()) throw InvalidInput("split: give u, v or both");
    py::list parts;
    const auto across = [&](const P& part) {
        if (v.is_none()) {
            parts.append(part);
            return;
        }
        const auto [low, high] = part.split_v(v.cast<double>());
        parts.append(low);
        parts.append(high);
    };
    if (u.is_none()) {
        across(p);
    } else {
        const auto [low, high] = p.split_u(u.cast<double>());
        across(low);
        across(high);
    }
    return py::tuple(parts);
}

TensorPatch make_tensor(const ArrayLike& points, const py::object& weights)
{
    ControlNet net = to_control_net(points, "points");
    require(net.rows > 0 && net.columns > 0, "TensorPatch: there are no points");
    return TensorPatch(static_cast<int>(net.rows) - 1, static_cast<int>(net.columns) - 1,
                       std::move(net.points), to_weights(weights));
}

void bind_tensor(py::module_& m)
{
    py::class_<TensorPatch> c(
        m, "TensorPatch",
        R"(Bezier patch of degree (m, n) over [0, 1]^2, with weights a rational one.

points : (m + 1, n + 1, 3) control points, model units; weights : (m + 1, n + 1) positive

>>> patch = genus.TensorPatch([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]])
>>> patch.evaluate(0.5, 0.5).tolist(), patch.normals(0, 0).tolist()
([0.5, 0.5, 0.25], [0.0, 0.0, 1.0]))");
    c.def(py::init(&make_tensor), py::arg("points"), py::arg("weights") = py::none())
        .def_property_readonly(
            "degree",
            [](const TensorPatch& p) { return py::make_tuple(p.degree_u(), p.degree_v()); },
            "(m, n).")
        .def_property_readonly(
            "points",
            [](const py::object& self) {
                const auto& p = self.cast<const TensorPatch&>();
                return view_points(p.points(), {p.degree_u() + 1, p.degree_v() + 1}, self);
            },
            "(m + 1, n + 1, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "weights",
            [](const py::object& self) {
                const auto& p = self.cast<const TensorPatch&>();
                return weights_or_none(p.weights(), {p.degree_u() + 1, p.degree_v() + 1}, self);
            },
            "(m + 1, n + 1) float64, None for a polynomial patch.")
        .def(
            "value_with_bound",
            [](const TensorPatch& p, double u, double v) {
                const auto b = p.value_with_bound(u, v);
                return py::make_tuple(to_array(b.value), to_array(b.bound));
            },
            py::arg("u"), py::arg("v"),
            "The point, and a bound on the rounding error of each coordinate.")
        .def("split", &split_tensor<TensorPatch>, py::arg("u") = py::none(),
             py::arg("v") = py::none(),
             "The parts on both sides of u, of v, or, with both, the four parts.")
        .def("part", &TensorPatch::part, py::arg("u0"), py::arg("u1"), py::arg("v0"), py::arg("v1"),
             "The part [u0, u1] x [v0, v1].")
        .def("elevate", &TensorPatch::elevated, py::arg("by_u") = 1, py::arg("by_v") = 1,
             "The same patch with higher degrees.")
        .def("transposed", &TensorPatch::transposed, "u and v exchanged: seen from behind.")
        .def("edge", &TensorPatch::edge, py::arg("k"),
             "Border curve counterclockwise: 0 is v = 0, 1 is u = 1, 2 is v = 1, 3 is u = 0.")
        .def("__repr__", [](const TensorPatch& p) {
            return "<genus.TensorPatch: " + std::string(p.rational() ? "rational, " : "") +
                   "degree (" + std::to_string(p.degree_u()) + ", " + std::to_string(p.degree_v()) +
                   ")>";
        });
    bind_common(c);
}

// The degree n with (n + 1) (n + 2) / 2 points.
int triangle_degree(std::size_t points)
{
    int n = 0;
    while (n < kMaxDegree &&
           static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n + 2) / 2 < points)
        ++n;
    return n;
}

BezierTriangle make_triangle(const ArrayLike& points, const std::optional<int>& degree,
                             const py::object& weights)
{
    auto p = to_control_points(points, "points");
    const int n = degree.value_or(triangle_degree(p.size()));
    return BezierTriangle(n, std::move(p), to_weights(weights));
}

void bind_triangle(py::module_& m)
{
    py::class_<BezierTriangle> c(m, "TrianglePatch",
                                 R"(Triangular Bezier patch of degree n over u, v >= 0, u + v <= 1.

points : ((n + 1) (n + 2) / 2, 3), rows of equal u-index i = 0 .. n, in each j = 0 .. n - i;
weights : as many, positive

>>> flat = genus.TrianglePatch([[0, 0, 0], [0, 1, 0], [1, 0, 0]], degree=1)
>>> flat.evaluate([0.25], [0.5]).tolist()
[[0.25, 0.5, 0.0]])");
    c.def(py::init(&make_triangle), py::arg("points"), py::arg("degree") = py::none(),
          py::arg("weights") = py::none())
        .def_property_readonly("degree", &BezierTriangle::degree, "n.")
        .def_property_readonly(
            "points",
            [](const py::object& self) {
                return view(self.cast<const BezierTriangle&>().points(), self);
            },
            "((n + 1) (n + 2) / 2, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "weights",
            [](const py::object& self) {
                const auto& p = self.cast<const BezierTriangle&>();
                return weights_or_none(p.weights(), {static_cast<py::ssize_t>(p.points().size())},
                                       self);
            },
            "float64, None for a polynomial patch.")
        .def(
            "value_with_bound",
            [](const BezierTriangle& p, double u, double v) {
                const auto b = p.value_with_bound(u, v);
                return py::make_tuple(to_array(b.value), to_array(b.bound));
            },
            py::arg("u"), py::arg("v"),
            "The point, and a bound on the rounding error of each coordinate.")
        .def(
            "split",
            [](const BezierTriangle& p) {
                py::list parts;
                for (const BezierTriangle& part : p.quartered()) parts.append(part);
                return py::tuple(parts);
            },
            "Four patches of half the size, the middle one last.")
        .def("elevate", &BezierTriangle::elevated, py::arg("by") = 1,
             "The same patch with a higher degree.")
        .def("edge", &BezierTriangle::edge, py::arg("k"),
             "Border curve counterclockwise: 0 is v = 0, 1 is u + v = 1, 2 is u = 0.")
        .def("__repr__", [](const BezierTriangle& p) {
            return "<genus.TrianglePatch: " + std::string(p.rational() ? "rational, " : "") +
                   "degree " + std::to_string(p.degree()) + ">";
        });
    bind_common(c);
}

BSplineSurface make_surface(const ArrayLike& points, const std::pair<int, int>& degree,
                            const py::object& knots, const py::object& weights)
{
    ControlNet net = to_control_net(points, "points");
    const auto knots_of = [&](std::size_t axis, int p, std::size_t n) {
        if (!knots.is_none()) {
            const auto both = py::reinterpret_borrow<py::sequence>(knots);
            if (py::len(both) != 2) throw py::value_error("knots: expected two knot vectors");
            return KnotVector(p, to_numbers(both[axis], "knots"));
        }
        require(p >= 1 && static_cast<std::size_t>(p) < n, "BSplineSurface: degree", p,
                "at least 1 and less than the number of points");
        return KnotVector::clamped(p, static_cast<int>(n));
    };
    return BSplineSurface(knots_of(0, degree.first, net.rows),
                          knots_of(1, degree.second, net.columns), std::move(net.points),
                          to_weights(weights));
}

BSplineSurface with_knots(const BSplineSurface& s, const py::object& u, const py::object& v)
{
    const auto with = [](const KnotVector& knots, const py::object& t) {
        if (t.is_none()) return knots;
        const double at = t.cast<double>();
        require(at > knots.begin() && at < knots.end(), "insert_knot: knot", at,
                "inside the domain");
        require(knots.multiplicity(at) < knots.degree(), "insert_knot: multiplicity",
                knots.multiplicity(at) + 1, "at most the degree");
        return knots.with(at);
    };
    return s.refined(with(s.knots_u(), u), with(s.knots_v(), v));
}

void bind_surface(py::module_& m)
{
    const auto shape = [](const BSplineSurface& s) {
        return std::vector<py::ssize_t>{s.knots_u().n_points(), s.knots_v().n_points()};
    };
    py::class_<BSplineSurface> c(m, "BSplineSurface",
                                 R"(Tensor-product B-spline surface, with weights a NURBS.

points : (m, n, 3), model units; degree : in u and v; knots : two knot vectors, without them
clamped and uniform over [0, 1]; weights : (m, n) positive

>>> net = [[[i, j, i * j] for j in range(4)] for i in range(5)]
>>> genus.BSplineSurface(net).evaluate(1, 1).tolist()
[4.0, 3.0, 12.0])");
    c.def(py::init(&make_surface), py::arg("points"), py::arg("degree") = std::pair<int, int>(3, 3),
          py::arg("knots") = py::none(), py::arg("weights") = py::none())
        .def_property_readonly(
            "degree",
            [](const BSplineSurface& s) {
                return py::make_tuple(s.knots_u().degree(), s.knots_v().degree());
            },
            "In u and v.")
        .def_property_readonly(
            "points",
            [shape](const py::object& self) {
                const auto& s = self.cast<const BSplineSurface&>();
                return view_points(s.points(), shape(s), self);
            },
            "(m, n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "weights",
            [shape](const py::object& self) {
                const auto& s = self.cast<const BSplineSurface&>();
                return weights_or_none(s.weights(), shape(s), self);
            },
            "(m, n) float64, None for a polynomial surface.")
        .def_property_readonly(
            "knots",
            [](const BSplineSurface& s) {
                return py::make_tuple(to_array(s.knots_u().values()),
                                      to_array(s.knots_v().values()));
            },
            "Both knot vectors.")
        .def("elevate", &BSplineSurface::elevated, py::arg("in_u") = true, py::arg("in_v") = true,
             "The same surface one degree higher.")
        .def("split", &split_tensor<BSplineSurface>, py::arg("u") = py::none(),
             py::arg("v") = py::none(),
             "The parts on both sides of u, of v, or, with both, the four parts, each over its "
             "share "
             "of the domain.")
        .def("insert_knot", &with_knots, py::arg("u") = py::none(), py::arg("v") = py::none(),
             "The same surface with a knot more in u, in v, or both.")
        .def("bezier_patches", &BSplineSurface::bezier_patches,
             "The polynomial (or rational) pieces, those of one u-span after another.")
        .def("__repr__", [](const BSplineSurface& s) {
            return "<genus.BSplineSurface: " + std::string(s.rational() ? "rational, " : "") +
                   "degree (" + std::to_string(s.knots_u().degree()) + ", " +
                   std::to_string(s.knots_v().degree()) + "), " +
                   std::to_string(s.knots_u().n_points()) + " x " +
                   std::to_string(s.knots_v().n_points()) + " points>";
        });
    bind_common(c);
}

py::list joins_of(const PatchModel& model, int samples)
{
    py::list list;
    for (const PatchJoin& j : model.joins(samples)) {
        py::dict d;
        d["patches"] = py::make_tuple(j.a.patch, j.b.patch);
        d["edges"] = py::make_tuple(j.a.edge, j.b.edge);
        d["gap"] = j.gap;
        d["turn"] = j.turn;
        list.append(d);
    }
    return list;
}

py::list patches_of(const PatchModel& model)
{
    py::list list;
    for (const Patch& patch : model.patches())
        std::visit([&](const auto& p) { list.append(py::cast(p)); }, patch);
    return list;
}

PatchModel pn_model(const Mesh& mesh, const py::object& normals)
{
    if (normals.is_none()) return pn_triangles(*mesh.triangles);
    const PointArray array = to_point_array(normals, "normals");
    return pn_triangles(*mesh.triangles, rows(array));
}

void bind_patch_model(py::module_& m)
{
    py::class_<PatchModel> c(
        m, "PatchModel",
        R"(Patches that share boundary curves: a surface of many pieces, closed or not.

patches : TensorPatch, TrianglePatch, BSplineSurface or PatchModel, in any mixture

>>> sheet = genus.PatchModel([genus.TrianglePatch([[0, 0, 0], [0, 1, 0], [1, 0, 0]])])
>>> sheet.is_closed, len(sheet), len(sheet.mesh(0.1))
(False, 1, 1))");
    c.def(py::init(&make_model), py::arg("patches"))
        .def_static(
            "pn_triangles", &pn_model, py::arg("mesh"), py::arg("normals") = py::none(),
            "A cubic triangle patch for every face of a Mesh, tangent to the normals (n, 3) "
            "at its\nvertices, by default the means of its faces'.")
        .def_property_readonly("patches", &patches_of, "List of TensorPatch and TrianglePatch.")
        .def_property_readonly("is_closed", &PatchModel::is_closed,
                               "Every edge belongs to two patches.")
        .def_property_readonly("is_oriented", &PatchModel::is_oriented,
                               "All fronts are on one side.")
        .def_property_readonly(
            "edges", [](const PatchModel& model) { return model.edges().size(); },
            "Number of edges, shared ones once.")
        .def("joins", &joins_of, py::arg("samples") = 8,
             "How patches meet along common edges: dicts with patches, edges, gap (model units), "
             "turn\n(angle between normals, radians).")
        .def(
            "bounds", [](const PatchModel& model) { return to_array(model.bounds()); },
            "Box of the control points, (2, 3).")
        .def(
            "mesh", &tessellated, py::arg("tolerance"), py::kw_only(), py::arg("measure") = true,
            py::arg("max_triangles") = TessellateOptions{}.max_triangles,
            py::arg("progress") = py::none(),
            R"(Mesh no farther than tolerance from the patches, both ways, without cracks; closed where the
model is closed. mesh.error holds the proven bound and what sampling finds.)")
        .def(
            "transform",
            [](const PatchModel& model, const ArrayLike& matrix) {
                return transformed(model, to_transform(matrix, "matrix"));
            },
            py::arg("matrix"), "Image under an affine matrix, (4, 4) or (3, 4).")
        .def(
            "save",
            [](const PatchModel& model, const Path& path) {
                long_call([&] { write_patches(path.text, model.patches()); });
            },
            py::arg("path"),
            "Writes the patches in the format of the extension, without one of these as .bpt: see "
            "load_patches.\nWeights need .bpt, .obj or .bez, triangles .bpt or .bv.")
        .def("__len__", [](const PatchModel& model) { return model.patches().size(); })
        .def("__repr__", [](const PatchModel& model) {
            return "<genus.PatchModel: " + std::to_string(model.patches().size()) + " patches, " +
                   (model.is_closed() ? "closed>" : "open>");
        });
}

PolygonMesh polygons_of(const py::object& mesh)
{
    if (py::isinstance<Mesh>(mesh)) return to_polygons(*mesh.cast<const Mesh&>().triangles);
    if (!py::isinstance<py::sequence>(mesh) || py::len(mesh) != 2)
        throw py::value_error("mesh: expected a Mesh or (points, faces)");
    return to_polygon_mesh(mesh[py::int_(0)], mesh[py::int_(1)]);
}

SubdivisionMesh subdivision_mesh(const py::object& mesh, const py::iterable& creases,
                                 const std::vector<std::int32_t>& corners)
{
    SubdivisionMesh s{polygons_of(mesh), {}, corners};
    for (const py::handle item : creases) {
        const auto crease = py::reinterpret_borrow<py::sequence>(item);
        const std::size_t n = py::len(crease);
        if (n != 2 && n != 3)
            throw py::value_error("creases: expected (a, b) or (a, b, sharpness)");
        Crease c{crease[0].cast<std::int32_t>(), crease[1].cast<std::int32_t>()};
        if (n == 3) c.sharpness = crease[2].cast<double>();
        s.creases.push_back(c);
    }
    return s;
}

SubdivisionScheme scheme_of(const std::string& name, const char* argument)
{
    return choice(name, argument, {"catmull_clark", "loop"}) == 1 ? SubdivisionScheme::Loop
                                                                  : SubdivisionScheme::CatmullClark;
}

Mesh subdivided(const py::object& mesh, int levels, const std::string& scheme_name,
                const py::iterable& creases, const std::vector<std::int32_t>& corners, bool limit)
{
    const SubdivisionMesh s = subdivision_mesh(mesh, creases, corners);
    const SubdivisionScheme scheme = scheme_of(scheme_name, "subdivide: scheme");
    return Mesh(long_call([&] {
        SubdivisionMesh fine = scheme == SubdivisionScheme::Loop ? loop_subdivision(s, levels)
                                                                 : catmull_clark(s, levels);
        if (limit) fine.mesh.vertices = limit_surface(fine, scheme).points;
        return to_triangles(fine.mesh);
    }));
}

py::tuple limits(const py::object& mesh, const std::string& scheme_name,
                 const py::iterable& creases, const std::vector<std::int32_t>& corners)
{
    const SubdivisionMesh s = subdivision_mesh(mesh, creases, corners);
    const SubdivisionScheme scheme = scheme_of(scheme_name, "limit_surface: scheme");
    LimitSurface limit = long_call([&] { return limit_surface(s, scheme); });
    return py::make_tuple(to_array(std::move(limit.points)), to_array(std::move(limit.normals)));
}

}  // namespace

void bind_patches(py::module_& m)
{
    bind_tensor(m);
    bind_triangle(m);
    bind_surface(m);
    bind_patch_model(m);
    m.def(
        "load_patches",
        [](const Path& path) {
            return long_call([&] { return PatchModel(read_patches(path.text)); });
        },
        py::arg("path"),
        R"(Patches from a text file.

.bpt : their number; of each a line "m n" with the degrees, or "n" for a triangle, and its points
"x y z" or "x y z weight", v running fastest; also Newell's form with numbered points
.bv : BezierView; .bez and .bbp : Geomview; .obj : free-form surfaces of Wavefront's format, by pieces

>>> teapot = genus.load_patches("models/patches/teapot.bpt")
>>> len(teapot), teapot.is_closed
(42, True))");
    m.def("surface_of_revolution", &surface_of_revolution, py::arg("profile"),
          py::arg("sweep") = 360.0,
          "The BSpline profile turned about the z axis from the xz plane, exactly, over sweep "
          "degrees:\na BSplineSurface.");
    m.def("subdivide", &subdivided, py::arg("mesh"), py::arg("levels") = 1,
          py::arg("scheme") = "catmull_clark", py::kw_only(), py::arg("creases") = py::tuple(),
          py::arg("corners") = py::tuple(), py::arg("limit") = false,
          R"(Subdivision surface of a Mesh, or of (points, faces) with faces of any degree.

scheme : "catmull_clark", or "loop" for triangles
creases : (a, b) or (a, b, sharpness), edges that stay sharp for so many levels, without for ever
corners : vertices that do not move; limit : put the vertices on the limit surface

>>> points = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
>>> faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
>>> mesh = genus.subdivide((points, faces), 2)
>>> len(mesh), mesh.topology.euler
(192, 2))");
    m.def(
        "limit_surface", &limits, py::arg("mesh"), py::arg("scheme") = "catmull_clark",
        py::kw_only(), py::arg("creases") = py::tuple(), py::arg("corners") = py::tuple(),
        R"(Where the vertices of a mesh go on the limit surface of its subdivision, (n, 3), and the unit
normals there, (n, 3): zero on creases, at corners and wherever there is none. See subdivide.

>>> points = [[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
>>> faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
>>> limit, normals = genus.limit_surface((points, faces))
>>> limit[7].round(6).tolist(), normals[7].round(6).tolist()
([0.5, 0.5, 0.5], [0.57735, 0.57735, 0.57735]))");
}

}  // namespace genus::python
