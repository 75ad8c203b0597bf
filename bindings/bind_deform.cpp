#include <cstring>
#include <string>

#include "freeform.h"
#include "genus/base/parallel.h"
#include "genus/deform/ffd.h"
#include "genus/deform/inverse_ffd.h"
#include "genus/model/deformed.h"

namespace genus::python {

namespace {

/// What Python sees as genus.Lattice. `points` hands out an array that may be written to; what was
/// changed there is taken over before the lattice is used.
struct PyLattice {
    Lattice lattice;
    py::object points;        // the array handed out, or none
    std::vector<Vec3> known;  // what stood in it last

    explicit PyLattice(Lattice l) : lattice(std::move(l)), points(py::none()) {}

    const Lattice& current()
    {
        if (!points.is_none()) take_over();
        return lattice;
    }
    py::object array()
    {
        if (points.is_none()) {
            known = lattice.points();
            std::vector<py::ssize_t> shape(lattice.counts().begin(), lattice.counts().end());
            shape.push_back(3);
            points = py::array_t<double>(shape, reinterpret_cast<const double*>(known.data()));
        }
        take_over();
        return points;
    }
    /// The lattice has changed by itself: so does the array.
    void refresh()
    {
        if (points.is_none()) return;
        known = lattice.points();
        auto array = py::cast<py::array_t<double>>(points);
        std::memcpy(array.mutable_data(), known.data(), known.size() * sizeof(Vec3));
    }

private:
    void take_over()
    {
        const auto array = py::cast<py::array_t<double>>(points);
        const auto* now = reinterpret_cast<const Vec3*>(array.data());
        const auto [l, m, n] = lattice.counts();
        for (int i = 0; i < l; ++i)
            for (int j = 0; j < m; ++j)
                for (int k = 0; k < n; ++k) {
                    const std::size_t at = lattice.index(i, j, k);
                    if (std::memcmp(&now[at], &known[at], sizeof(Vec3)) == 0) continue;
                    lattice.set_point(i, j, k, now[at]);
                    known[at] = now[at];
                }
    }
};

Columns3 to_axes(const py::handle& value)
{
    const PointArray axes = to_point_array(value, "axes");
    if (axes.shape(0) != 3) throw py::value_error("axes: expected three vectors, shape (3, 3)");
    return {rows(axes)[0], rows(axes)[1], rows(axes)[2]};
}

Box3 box_of(const py::object& what)
{
    if (py::isinstance<Mesh>(what)) return bounds(*what.cast<const Mesh&>().triangles);
    if (py::hasattr(what, "bounds")) return to_box(what.attr("bounds")(), "bounds");
    return to_box(what, "bounds");
}

// Points of any shape (..., 3).
PointArray any_points(const py::handle& value, const char* argument)
{
    PointArray x = PointArray::ensure(value);
    if (!x || x.ndim() < 1 || x.shape(x.ndim() - 1) != 3) {
        PyErr_Clear();
        throw py::value_error(std::string(argument) + ": expected points, shape (..., 3)");
    }
    return x;
}

std::span<const Vec3> flat(const PointArray& x)
{
    return {reinterpret_cast<const Vec3*>(x.data()), static_cast<std::size_t>(x.size()) / 3};
}

py::array_t<double> like(const PointArray& x)
{
    return py::array_t<double>(std::vector<py::ssize_t>(x.shape(), x.shape() + x.ndim()));
}

PatchModel deformed_model(const PatchModel& model, const Lattice& lattice)
{
    std::vector<Patch> patches;
    for (const Patch& patch : model.patches())
        std::visit([&](const auto& p) { patches.emplace_back(deformed(p, lattice)); }, patch);
    return PatchModel(std::move(patches));
}

template <class Thing>
bool deform_as(const py::object& x, const Lattice& lattice, py::object& result)
{
    if (!py::isinstance<Thing>(x)) return false;
    result = py::cast(deformed(x.cast<const Thing&>(), lattice));
    return true;
}

py::object apply_lattice(PyLattice& self, const py::object& x)
{
    const Lattice& lattice = self.current();
    py::object result;
    if (deform_as<BezierCurve>(x, lattice, result) || deform_as<BSpline>(x, lattice, result) ||
        deform_as<TensorPatch>(x, lattice, result) ||
        deform_as<BezierTriangle>(x, lattice, result) ||
        deform_as<BSplineSurface>(x, lattice, result))
        return result;
    if (py::isinstance<PatchModel>(x))
        return py::cast(deformed_model(x.cast<const PatchModel&>(), lattice));
    if (py::isinstance<Mesh>(x))
        return py::cast(Mesh(deformed(*x.cast<const Mesh&>().triangles, lattice)));
    const PointArray points = any_points(x, "x");
    auto out = like(points);
    const auto to = writable_rows(out);
    bulk_call(to.size(), [&] { lattice.apply(flat(points), to); });
    return out;
}

struct InversePoints {
    std::vector<Vec3> points;
    std::vector<std::uint8_t> found, certified;
    std::vector<double> bound;
};

InversePoints inverse_of(const Lattice& lattice, std::span<const Vec3> y)
{
    InversePoints result;
    result.points.resize(y.size());
    result.found.resize(y.size());
    result.certified.resize(y.size());
    result.bound.resize(y.size());
    parallel_for(y.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const InversePoint p = lattice.inverse(y[i]);
            result.points[i] = p.point;
            result.found[i] = p.found;
            result.certified[i] = p.certified;
            result.bound[i] = p.bound;
        }
    });
    return result;
}

py::array inverse_points(PyLattice& self, const py::object& y)
{
    const PointArray points = any_points(y, "y");
    const Lattice& lattice = self.current();
    const InversePoints inverse = long_call([&] { return inverse_of(lattice, flat(points)); });
    for (std::size_t i = 0; i < inverse.found.size(); ++i)
        if (!inverse.found[i])
            throw InvalidInput("Lattice.inverse: nothing is taken to point " + std::to_string(i));
    auto out = like(points);
    std::copy(inverse.points.begin(), inverse.points.end(), writable_rows(out).begin());
    return out;
}

py::dict inverse_details(PyLattice& self, const py::object& y)
{
    const PointArray points = any_points(y, "y");
    const Lattice& lattice = self.current();
    InversePoints inverse = long_call([&] { return inverse_of(lattice, flat(points)); });
    const auto truths = [](std::vector<std::uint8_t> v) {
        return to_array(std::move(v)).attr("view")(py::dtype::of<bool>());
    };
    py::dict d;
    d["points"] = to_array(std::move(inverse.points));
    d["found"] = truths(std::move(inverse.found));
    d["certified"] = truths(std::move(inverse.certified));
    d["bound"] = to_array(std::move(inverse.bound));
    return d;
}

py::array jacobians(PyLattice& self, const py::object& x)
{
    const PointArray points = any_points(x, "x");
    std::vector<py::ssize_t> shape(points.shape(), points.shape() + points.ndim());
    shape.push_back(3);
    py::array_t<double> out(shape);
    const Lattice& lattice = self.current();
    double* to = out.mutable_data();
    for (const Vec3& p : flat(points)) {
        const Columns3 j = lattice.jacobian(p);
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 3; ++column) *to++ = j[column][row];
    }
    return out;
}

std::vector<FfdConstraint> constraints_of(const py::handle& points, const py::handle& targets,
                                          const py::object& weights, const py::object& directions)
{
    const PointArray from = to_point_array(points, "points"),
                     to = to_point_array(targets, "targets");
    if (from.shape(0) != to.shape(0))
        throw py::value_error("fit: " + std::to_string(from.shape(0)) + " points, " +
                              std::to_string(to.shape(0)) + " targets");
    std::vector<FfdConstraint> constraints;
    for (std::size_t i = 0; i < rows(from).size(); ++i)
        constraints.push_back({rows(from)[i], rows(to)[i], 1.0, std::nullopt});
    if (!weights.is_none()) {
        const auto w = to_weights(weights);
        if (w.size() != constraints.size())
            throw py::value_error("fit: as many weights as points are needed");
        for (std::size_t i = 0; i < w.size(); ++i) constraints[i].weight = w[i];
    }
    if (!directions.is_none()) {
        // A row of zeros: the point itself is meant.
        const PointArray d = to_point_array(directions, "directions");
        if (static_cast<std::size_t>(d.shape(0)) != constraints.size())
            throw py::value_error("fit: as many directions as points are needed");
        for (std::size_t i = 0; i < constraints.size(); ++i)
            if (rows(d)[i] != Vec3{}) constraints[i].direction = rows(d)[i];
    }
    return constraints;
}

InverseFfd solver(PyLattice& self, const ArrayLike& points, const ArrayLike& targets,
                  const py::object& weights, const py::object& directions, double regularisation,
                  int keep_border, double rank_tolerance)
{
    auto constraints = constraints_of(points, targets, weights, directions);
    FfdFitOptions options;
    options.regularisation = regularisation;
    options.keep_border = keep_border;
    options.rank_tolerance = rank_tolerance;
    return long_call([&, lattice = self.current()] {
        return InverseFfd(lattice, std::move(constraints), options);
    });
}

FfdFit fit_in_place(PyLattice& self, const ArrayLike& points, const ArrayLike& targets,
                    const py::object& weights, const py::object& directions, double regularisation,
                    int keep_border, double rank_tolerance)
{
    const InverseFfd inverse = solver(self, points, targets, weights, directions, regularisation,
                                      keep_border, rank_tolerance);
    FfdFit fit = long_call([&] { return inverse.solve(); });
    self.lattice = fit.lattice;
    self.refresh();
    return fit;
}

void bind_fit(py::module_& m)
{
    py::class_<FfdFit>(m, "Fit", "What an inverse deformation came to.")
        .def_property_readonly(
            "kind", [](const FfdFit& f) { return to_text(f.kind); },
            "How the system was solved: exactly, by least squares, by least norm, or both.")
        .def_readonly("rank", &FfdFit::rank, "Independent constraints.")
        .def_readonly("condition", &FfdFit::condition,
                      "Largest over smallest singular value that counts.")
        .def_readonly("residual", &FfdFit::largest_residual,
                      "Largest distance of a point from its target, model units.")
        .def_property_readonly(
            "residuals", [](const FfdFit& f) { return to_array(f.residuals); },
            "(n,) float64: that of each constraint.")
        .def_readonly("moved", &FfdFit::moved,
                      "Root of the sum of the squared moves of the control points.")
        .def_readonly("unmet", &FfdFit::unmet, "Constraints whose residual is not rounding.")
        .def_readonly("contradictions", &FfdFit::contradictions,
                      "Pairs of constraints on one point that ask for different things.")
        .def_property_readonly(
            "lattice", [](const FfdFit& f) { return PyLattice(f.lattice); },
            "The lattice that does it.")
        .def("__str__", &FfdFit::summary)
        .def("__repr__", [](const FfdFit& f) { return "<genus.Fit: " + f.summary() + ">"; });

    py::class_<InverseFfd>(m, "LatticeSolver",
                           "Inverse deformation with its matrix factored: new targets cost one "
                           "back-substitution.")
        .def(
            "solve",
            [](const InverseFfd& s, const py::object& targets) {
                if (targets.is_none()) return s.solve();
                const PointArray to = to_point_array(targets, "targets");
                return s.solve(rows(to));
            },
            py::arg("targets") = py::none(),
            "The Fit for these targets, (n, 3), or for those given at first.");
}

void bind_folds(py::module_& m)
{
    py::class_<FoldReport>(m, "FoldReport", "Whether a deformation turns space inside out.")
        .def_property_readonly(
            "kind",
            [](const FoldReport& r) {
                return r.kind == FoldReport::Kind::None     ? "none"
                       : r.kind == FoldReport::Kind::Folded ? "folded"
                                                            : "undecided";
            },
            "\"none\" (proven), \"folded\" or \"undecided\".")
        .def_property_readonly(
            "where", [](const FoldReport& r) { return to_array(r.where); },
            "(3,): a point with negative determinant, before the deformation.")
        .def_readonly("determinant", &FoldReport::determinant,
                      "There; without folds a positive lower bound.")
        .def("__repr__", [](const FoldReport& r) {
            return std::string("<genus.FoldReport: ") +
                   (r.kind == FoldReport::Kind::None ? "none" : "determinant ") +
                   (r.kind == FoldReport::Kind::None ? "" : to_text(r.determinant)) + ">";
        });
}

const char* kind_of(const OneToOneReport& r)
{
    return r.kind == OneToOneReport::Kind::Yes  ? "yes"
           : r.kind == OneToOneReport::Kind::No ? "no"
                                                : "undecided";
}

void bind_one_to_one(py::module_& m)
{
    py::class_<OneToOneReport>(m, "OneToOneReport",
                               "Whether a deformation takes two points to one place.")
        .def_property_readonly("kind", &kind_of,
                               "\"yes\" (it is one to one, proven), \"no\" or \"undecided\".")
        .def_property_readonly(
            "points",
            [](const OneToOneReport& r) {
                return to_array(std::vector<Vec3>(r.points.begin(), r.points.end()));
            },
            "(2, 3): for \"no\" two points that go to one place, before the deformation; for "
            "\"undecided\" where it\ncame down to.")
        .def_readonly("bound", &OneToOneReport::bound,
                      "For \"no\": the exact second point is within this of the one given.")
        .def("__repr__", [](const OneToOneReport& r) {
            return std::string("<genus.OneToOneReport: ") + kind_of(r) + ">";
        });
}

// One number for all three axes, or three.
std::array<int, 3> per_axis(const py::object& value, const char* argument)
{
    try {
        if (py::isinstance<py::int_>(value)) {
            const int n = value.cast<int>();
            return {n, n, n};
        }
        return value.cast<std::array<int, 3>>();
    } catch (const py::cast_error&) {
        throw py::type_error(std::string(argument) + ": expected a whole number or three");
    }
}

Box3 lattice_box(const Lattice& lattice)
{
    Box3 box;
    for (int corner = 0; corner < 8; ++corner)
        box.add(
            lattice.global({{static_cast<double>(corner & 1), static_cast<double>(corner >> 1 & 1),
                             static_cast<double>(corner >> 2 & 1)}}));
    return box;
}

}  // namespace

void bind_lattices(py::module_& m, py::class_<Solid>& solid)
{
    using Counts = std::array<int, 3>;
    py::class_<PyLattice> c(m, "Lattice",
                            R"(Free-form deformation by control points over a parallelepiped.

origin, axes : its corner and its three edges, (3,) and (3, 3), model units
degree : of the Bernstein polynomials along each axis, or of all; (l + 1, m + 1, n + 1) points

Points outside stay where they are. The array `points` may be written to, in place or whole.

>>> lattice = genus.Lattice([0, 0, 0], [[4, 0, 0], [0, 4, 0], [0, 0, 4]], degree=(2, 2, 2))
>>> lattice.points[1, 1, 2] += [0, 0, 4]
>>> lattice.apply([2, 2, 4]).tolist(), lattice.apply([9, 9, 9]).tolist()
([2.0, 2.0, 5.0], [9.0, 9.0, 9.0]))");
    c.def(py::init([](const VectorLike& origin, const ArrayLike& axes, const py::object& degree) {
              return PyLattice(
                  Lattice(to_vec3(origin, "origin"), to_axes(axes), per_axis(degree, "degree")));
          }),
          py::arg("origin"), py::arg("axes"), py::arg("degree") = Counts{3, 3, 3})
        .def_static(
            "bspline",
            [](const VectorLike& origin, const ArrayLike& axes, const py::object& counts,
               int degree) {
                return PyLattice(Lattice::bspline(to_vec3(origin, "origin"), to_axes(axes),
                                                  per_axis(counts, "counts"), degree));
            },
            py::arg("origin"), py::arg("axes"), py::arg("counts"), py::arg("degree") = 3,
            "Lattice of B-splines with `counts` control points along the axes: local, and of use "
            "where\nBernstein degrees get high.")
        .def_static(
            "over",
            [](const py::object& what, const py::object& degree) {
                return PyLattice(Lattice::over(box_of(what), per_axis(degree, "degree")));
            },
            py::arg("box"), py::arg("degree") = Counts{3, 3, 3},
            "Lattice over a box, (2, 3), or that of a Mesh, Solid or patch.")
        .def_property(
            "points", [](PyLattice& self) { return self.array(); },
            [](PyLattice& self, const py::object& value) {
                const py::object array = self.array();
                array.attr("__setitem__")(py::ellipsis(), value);
                self.current();
            },
            "(l + 1, m + 1, n + 1, 3) float64, model units; may be written to.")
        .def_property_readonly(
            "origin", [](const PyLattice& l) { return to_array(l.lattice.origin()); }, "(3,).")
        .def_property_readonly(
            "axes",
            [](const PyLattice& l) {
                return to_array(
                    std::vector<Vec3>(l.lattice.axes().begin(), l.lattice.axes().end()));
            },
            "(3, 3): the edges, one a row.")
        .def_property_readonly(
            "degree",
            [](const PyLattice& l) {
                return py::make_tuple(l.lattice.degree(0), l.lattice.degree(1),
                                      l.lattice.degree(2));
            },
            "Along each axis.")
        .def_property_readonly(
            "border_continuity", [](PyLattice& l) { return l.current().border_continuity(); },
            "The largest k for which the deformation is C^k across the border by layers that rest; "
            "-1 if\nit tears there.")
        .def(
            "keep_border",
            [](PyLattice& l, int k) {
                l.current();
                l.lattice.keep_border(k);
                l.refresh();
            },
            py::arg("k"), "Puts the outer k + 1 layers back, so that it is C^k across the border.")
        .def("apply", &apply_lattice, py::arg("x"),
             "Points (..., 3) deformed; or a Mesh by its vertices, a curve, patch or PatchModel by "
             "its\ncontrol points (exact for affine deformations only).")
        .def("inverse", &inverse_points, py::arg("y"),
             "The points (..., 3) that are taken to y; InvalidInput for one that nothing is taken "
             "to.")
        .def("inverse_details", &inverse_details, py::arg("y"),
             "A dict with points (n, 3), found, certified (a proof that each is the only one "
             "within bound)\nand bound, (n,).")
        .def("jacobian", &jacobians, py::arg("x"),
             "Derivatives (..., 3, 3): entry (i, j) is that of coordinate i by coordinate j.")
        .def(
            "folds",
            [](PyLattice& l, int max_boxes) {
                return long_call([&, lattice = l.current()] { return lattice.folds(max_boxes); });
            },
            py::arg("max_boxes") = 20000,
            "Where the deformation turns space inside out, if anywhere: a FoldReport.")
        .def(
            "one_to_one",
            [](PyLattice& l, const py::object& box, int max_pairs) {
                const Box3 where = box.is_none() ? lattice_box(l.lattice) : box_of(box);
                return long_call(
                    [&, lattice = l.current()] { return lattice.one_to_one(where, max_pairs); });
            },
            py::arg("box") = py::none(), py::arg("max_pairs") = 200000,
            R"(Whether two points of a box, (2, 3) or that of a thing, go to one place: a OneToOneReport.

Without a box: of the whole lattice. Points outside of the lattice do not count.

>>> lattice = genus.Lattice([0, 0, 0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
>>> lattice.points[1:3, 1:3, 1:3] += [0.1, 0, 0]
>>> lattice.one_to_one().kind
'yes')")
        .def("fit", &fit_in_place, py::arg("points"), py::arg("targets"),
             py::arg("weights") = py::none(), py::arg("directions") = py::none(), py::kw_only(),
             py::arg("regularisation") = 0.0, py::arg("keep_border") = -1,
             py::arg("rank_tolerance") = 0.0,
             R"(Moves the control points so that points (n, 3) go to targets (n, 3): a Fit.

Least squares where the constraints are too many, the smallest moves where they are too few.
directions : (n, 3), rows other than zero ask for the derivative along them instead
regularisation : weight of the squared moves; keep_border : layers k + 1 that rest, -1 for none

>>> lattice = genus.Lattice([0, 0, 0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
>>> fit = lattice.fit([[0.5, 0.5, 0.5]], [[0.5, 0.5, 0.75]])
>>> fit.rank, bool(fit.residual < 1e-12), lattice.apply([0.5, 0.5, 0.5]).round(9).tolist()
(1, True, [0.5, 0.5, 0.75]))")
        .def("solver", &solver, py::arg("points"), py::arg("targets"),
             py::arg("weights") = py::none(), py::arg("directions") = py::none(), py::kw_only(),
             py::arg("regularisation") = 0.0, py::arg("keep_border") = -1,
             py::arg("rank_tolerance") = 0.0,
             "The same kept factored, for targets that move: a LatticeSolver. Leaves the lattice "
             "alone.")
        .def("__repr__", [](PyLattice& l) {
            const auto [a, b, n] = l.lattice.counts();
            return std::string("<genus.Lattice: ") +
                   (l.lattice.is_bspline() ? "B-spline, " : "Bernstein, ") + std::to_string(a) +
                   " x " + std::to_string(b) + " x " + std::to_string(n) + " points>";
        });
    bind_folds(m);
    bind_one_to_one(m);
    bind_fit(m);
    solid.def(
        "deform",
        [](const Solid& s, PyLattice& lattice) {
            return long_call([&, l = lattice.current()] { return deformed(s, l); });
        },
        py::arg("lattice"),
        R"(The image under a free-form deformation. Method "auto" meshes the solid and deforms the mesh,
with a proven bound; "emc" and "mc" go by the inverse map.

>>> lattice = genus.Lattice([-2, -2, -2], [[4, 0, 0], [0, 4, 0], [0, 0, 4]])
>>> lattice.points[1:3, 1:3, 1:3] += [0.5, 0, 0]
>>> mesh = genus.sphere(1).deform(lattice).mesh(0.05)
>>> mesh.is_closed, mesh.error.certified, mesh.error.bound <= 0.05
(True, True, True))");
}

void bind_freeform(py::module_& m, py::class_<Solid>& solid)
{
    bind_curves(m);
    bind_patches(m);
    bind_lattices(m, solid);
}

}  // namespace genus::python
