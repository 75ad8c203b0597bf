#include <cstring>
#include <string>

#include "freeform.h"
#include "genus/patch/bezier_curve.h"
#include "genus/patch/bspline.h"
#include "genus/patch/cubic_spline.h"

namespace genus::python {

std::vector<Vec3> to_control_points(const py::handle& value, const char* argument)
{
    const PointArray given = PointArray::ensure(value);
    if (given && given.ndim() == 2 && given.shape(1) == 2) {
        std::vector<Vec3> points;
        for (py::ssize_t i = 0; i < given.shape(0); ++i)
            points.push_back({{given.at(i, 0), given.at(i, 1), 0.0}});
        return points;
    }
    PyErr_Clear();
    const PointArray array = to_point_array(value, argument);
    return {rows(array).begin(), rows(array).end()};
}

ControlNet to_control_net(const py::handle& value, const char* argument)
{
    const PointArray net = PointArray::ensure(value);
    if (!net || net.ndim() != 3 || net.shape(2) != 3) {
        PyErr_Clear();
        throw py::value_error(std::string(argument) + ": expected an array of shape (m, n, 3)");
    }
    const auto* first = reinterpret_cast<const Vec3*>(net.data());
    const auto m = static_cast<std::size_t>(net.shape(0));
    const auto n = static_cast<std::size_t>(net.shape(1));
    return {m, n, std::vector<Vec3>(first, first + m * n)};
}

std::vector<double> to_weights(const py::object& value)
{
    if (value.is_none()) return {};
    const Parameters weights(value, "weights");
    return {weights.values().begin(), weights.values().end()};
}

namespace {

py::array read_only(py::array array)
{
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

}  // namespace

py::array view_points(const std::vector<Vec3>& values, const std::vector<py::ssize_t>& shape,
                      const py::object& owner)
{
    std::vector<py::ssize_t> full = shape;
    full.push_back(3);
    return read_only(
        py::array_t<double>(full, reinterpret_cast<const double*>(values.data()), owner));
}

py::object weights_or_none(const std::vector<double>& weights,
                           const std::vector<py::ssize_t>& shape, const py::object& owner)
{
    if (weights.empty()) return py::none();
    return read_only(py::array_t<double>(shape, weights.data(), owner));
}

std::size_t choice(const std::string& given, const char* argument,
                   std::initializer_list<const char*> names)
{
    std::string all;
    std::size_t at = 0;
    for (const char* name : names) {
        if (given == name) return at;
        all += (at++ > 0 ? ", " : "") + std::string(name);
    }
    throw InvalidInput(std::string(argument) + " is \"" + given + "\", must be one of " + all);
}

namespace {

bool inside_unit(std::span<const double> t)
{
    for (const double x : t)
        if (!(x >= 0.0 && x <= 1.0)) return false;
    return true;
}

py::array evaluate_bezier(const BezierCurve& curve, const py::object& t)
{
    const Parameters at(t, "t");
    auto out = at.points();
    const auto points = writable_rows(out);
    bulk_call(at.size(), [&] {
        if (inside_unit(at.values())) return curve.evaluate(at.values(), points);
        for (std::size_t i = 0; i < points.size(); ++i) points[i] = curve.value(at.values()[i]);
    });
    return out;
}

template <class Curve>
py::array evaluate_spline(const Curve& curve, const py::object& t)
{
    const Parameters at(t, "t");
    auto out = at.points();
    const auto points = writable_rows(out);
    bulk_call(at.size(), [&] { curve.evaluate(at.values(), points); });
    return out;
}

template <class Curve>
py::array derivative_of(const Curve& curve, const py::object& t, int order)
{
    require(order >= 0 && order <= kMaxDegree, "derivative: order", order, "in [0, 512]");
    const Parameters at(t, "t");
    auto out = at.points();
    const auto points = writable_rows(out);
    bulk_call(at.size(), [&] {
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i] = curve.derivative(at.values()[i], order);
    });
    return out;
}

std::string with_points(const char* name, std::size_t n, int degree, bool rational)
{
    return std::string("<genus.") + name + ": " + (rational ? "rational, " : "") + "degree " +
           std::to_string(degree) + ", " + std::to_string(n) + " points>";
}

BSpline make_spline(const ArrayLike& points, int degree, const py::object& knots,
                    const py::object& weights)
{
    auto p = to_control_points(points, "points");
    auto w = to_weights(weights);
    if (!knots.is_none())
        return BSpline(std::move(p), KnotVector(degree, to_numbers(knots, "knots")), std::move(w));
    const int n = static_cast<int>(p.size());
    require(n > degree && degree >= 1, "BSpline: degree", degree,
            "at least 1 and less than the number of points");
    return BSpline(std::move(p), KnotVector::clamped(degree, n), std::move(w));
}

CubicSpline make_cubic(const ArrayLike& points, const std::string& ends)
{
    return CubicSpline(
        to_control_points(points, "points"),
        static_cast<CubicEnds>(choice(ends, "CubicSpline: ends", {"natural", "free", "closed"})));
}

BSpline interpolated(const ArrayLike& points, const std::string& ends,
                     const std::string& parametrization, const py::object& start,
                     const py::object& end)
{
    InterpolationOptions options;
    options.ends = static_cast<SplineEnds>(
        choice(ends, "interpolate: ends", {"not_a_knot", "natural", "clamped", "periodic"}));
    options.parametrization =
        static_cast<Parametrization>(choice(parametrization, "interpolate: parametrization",
                                            {"uniform", "chord_length", "centripetal"}));
    if (options.ends == SplineEnds::Clamped) {
        options.start_tangent = to_vec3(start, "start_tangent");
        options.end_tangent = to_vec3(end, "end_tangent");
    }
    return interpolate(to_control_points(points, "points"), options);
}

py::tuple spline_fit(const ArrayLike& points, int n_points, int degree,
                     const std::string& parametrization)
{
    const auto kind =
        static_cast<Parametrization>(choice(parametrization, "fit_spline: parametrization",
                                            {"uniform", "chord_length", "centripetal"}));
    const auto given = to_control_points(points, "points");
    const SplineFit made = long_call([&] { return fit(given, n_points, degree, kind); });
    return py::make_tuple(made.curve, made.largest, made.rms);
}

py::list crossings(const BezierCurve& a, const BezierCurve& b, double tolerance)
{
    const CurveCrossings found = long_call([&] { return intersect(a, b, tolerance); });
    if (found.overlap) throw InvalidInput("intersect: the curves run together for a stretch");
    py::list list;
    for (const CurveCrossing& c : found.crossings)
        list.append(py::make_tuple(c.s, c.t, to_array(c.point)));
    return list;
}

py::dict join_of(const BezierCurve& a, const BezierCurve& b, double ratio)
{
    const CurveJoin j = join(a, b, ratio);
    py::dict d;
    d["gap"] = j.gap;
    d["kink"] = j.kink;
    d["bend"] = j.bend;
    d["turn"] = j.turn;
    d["curvature"] = j.curvature;
    return d;
}

void bind_polyline(py::module_& m)
{
    py::class_<FlattenedCurve>(m, "Polyline",
                               "Points along a curve, joined by lines: also an array of them.")
        .def_property_readonly(
            "points",
            [](const py::object& self) {
                return view(self.cast<const FlattenedCurve&>().points, self);
            },
            "(n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "parameters", [](const FlattenedCurve& f) { return to_array(f.parameters); },
            "(n,) float64, ascending.")
        .def_readonly("bound", &FlattenedCurve::bound,
                      "Lines and curve are no farther apart than this, both ways; model units.")
        .def_property_readonly(
            "shape", [](const FlattenedCurve& f) { return py::make_tuple(f.points.size(), 3); },
            "(n, 3).")
        .def("__len__", [](const FlattenedCurve& f) { return f.points.size(); })
        .def("__getitem__",
             [](const py::object& self, const py::object& index) {
                 return self.attr("points").attr("__getitem__")(index);
             })
        .def(
            "__array__",
            [](const py::object& self, const py::object& type, const py::object&) {
                const py::object points = self.attr("points");
                return type.is_none() ? points : points.attr("astype")(type);
            },
            py::arg("dtype") = py::none(), py::arg("copy") = py::none())
        .def("__repr__", [](const FlattenedCurve& f) {
            return "<genus.Polyline: " + std::to_string(f.points.size()) + " points, within " +
                   to_text(f.bound) + ">";
        });
}

// What all curves have.
template <class Curve>
void bind_common(py::class_<Curve>& c)
{
    c.def(
         "derivative",
         [](const Curve& curve, const py::object& t, int order) {
             return derivative_of(curve, t, order);
         },
         py::arg("t"), py::arg("order") = 1,
         "Derivatives by the parameter, for parameters as in evaluate.")
        .def(
            "flatten",
            [](const Curve& curve, double tolerance) {
                return long_call([&] { return curve.flatten(tolerance); });
            },
            py::arg("tolerance"), "A Polyline no farther than tolerance from the curve.")
        .def(
            "bezier_segments",
            [](const Curve& curve) {
                if constexpr (std::is_same_v<Curve, BezierCurve>)
                    return std::vector<BezierCurve>{curve};
                else
                    return curve.bezier_segments();
            },
            "The polynomial (or rational) pieces in order, each a BezierCurve over [0, 1].");
}

void bind_bezier(py::module_& m)
{
    py::class_<BezierCurve> c(m, "BezierCurve",
                              R"(Bezier curve over [0, 1], with weights a rational one.

points : (n + 1, 3) or (n + 1, 2) control points, model units; weights : (n + 1,) positive

>>> curve = genus.BezierCurve([[0, 0], [1, 2], [2, 0]])
>>> curve.evaluate(0.5).tolist(), curve.evaluate([0, 1]).shape
([1.0, 1.0, 0.0], (2, 3)))");
    c.def(py::init([](const ArrayLike& points, const py::object& weights) {
              return BezierCurve(to_control_points(points, "points"), to_weights(weights));
          }),
          py::arg("points"), py::arg("weights") = py::none())
        .def_property_readonly("degree", &BezierCurve::degree, "One less than the points.")
        .def_property_readonly(
            "points",
            [](const py::object& self) {
                const auto& p = self.cast<const BezierCurve&>().points();
                return view(p, self);
            },
            "(n + 1, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "weights",
            [](const py::object& self) {
                const auto& curve = self.cast<const BezierCurve&>();
                return weights_or_none(curve.weights(), {curve.degree() + 1}, self);
            },
            "(n + 1,) float64, None for a polynomial curve.")
        .def(
            "evaluate", &evaluate_bezier, py::arg("t"),
            R"(Points at parameters of any shape, (..., 3), vectorised; outside [0, 1] the curve goes on.)")
        .def(
            "value_with_bound",
            [](const BezierCurve& curve, double t) {
                const auto b = curve.value_with_bound(t);
                return py::make_tuple(to_array(b.value), to_array(b.bound));
            },
            py::arg("t"), "The point, and a bound on the rounding error of each coordinate.")
        .def("split", &BezierCurve::split, py::arg("t"),
             "The parts before and after t, each over [0, 1].")
        .def("segment", &BezierCurve::segment, py::arg("a"), py::arg("b"),
             "The part from a to b, over [0, 1].")
        .def("elevate", &BezierCurve::elevated, py::arg("by") = 1,
             "The same curve with a degree higher by `by`.")
        .def("reduce", &BezierCurve::reduced, py::arg("degree"),
             "A curve of lower degree with the same ends, and how far apart the two may be.")
        .def("reversed", &BezierCurve::reversed, "Run through from the end.")
        .def("curvature", &BezierCurve::curvature, py::arg("t"), "1 / model units.")
        .def(
            "length",
            [](const BezierCurve& curve, double tolerance) {
                const CurveLength l = long_call([&] { return curve.length(tolerance); });
                return py::make_tuple(l.length, l.bound);
            },
            py::arg("tolerance"), "Arc length, and a bound on its error below the tolerance.")
        .def(
            "nearest",
            [](const BezierCurve& curve, const VectorLike& p, double tolerance) {
                const Vec3 point = to_vec3(p, "point");
                const auto n = long_call([&] { return curve.nearest(point, tolerance); });
                return py::make_tuple(n.parameter, to_array(n.point), n.distance);
            },
            py::arg("point"), py::arg("tolerance"),
            "Nearest point: its parameter, itself, and the distance.")
        .def("intersect", &crossings, py::arg("other"), py::arg("tolerance"),
             "Where two curves come as close as the tolerance: list of (s, t, point).")
        .def(
            "intersect_plane",
            [](const BezierCurve& curve, const VectorLike& normal, double offset) {
                std::vector<double> t;
                for (const auto& root : intersect_plane(curve, to_vec3(normal, "normal"), offset))
                    t.push_back(root.t);
                return t;
            },
            py::arg("normal"), py::arg("offset"),
            "Parameters at which normal . p = offset, ascending.")
        .def("join", &join_of, py::arg("other"), py::arg("ratio") = 1.0,
             "How the end of this curve meets the start of the other: gap (C0), kink (C1), bend "
             "(C2),\nturn (G1, radians), curvature (G2); the other lasts `ratio` times as long.")
        .def(
            "continuation",
            [](const BezierCurve& curve, int order, double ratio) {
                return to_array(continuation(curve, order, ratio));
            },
            py::arg("order"), py::arg("ratio") = 1.0,
            "The first order + 1 control points of a curve that goes on with C^order.")
        .def(
            "bounds", [](const BezierCurve& curve) { return to_array(curve.bounds()); },
            "Box of the control points, (2, 3).")
        .def("__repr__", [](const BezierCurve& curve) {
            return with_points("BezierCurve", curve.points().size(), curve.degree(),
                               curve.rational());
        });
    bind_common(c);
}

void bind_bspline(py::module_& m)
{
    py::class_<BSpline> c(m, "BSpline", R"(B-spline curve, with weights a NURBS.

points : (n, 3) or (n, 2), model units; knots : n + degree + 1 ascending numbers, without them
clamped and uniform over [0, 1]; weights : (n,) positive

>>> arc = genus.BSpline([[0, 0], [1, 2], [2, 0]], degree=2)
>>> arc.evaluate(0.5).tolist()
[1.0, 1.0, 0.0])");
    c.def(py::init(&make_spline), py::arg("points"), py::arg("degree") = 3,
          py::arg("knots") = py::none(), py::arg("weights") = py::none())
        .def_static(
            "closed",
            [](const ArrayLike& ring, int degree) {
                return BSpline::closed(to_control_points(ring, "ring"), degree);
            },
            py::arg("ring"), py::arg("degree") = 3, "Closed curve, the points being a ring.")
        .def_property_readonly("degree", &BSpline::degree, "Of the pieces.")
        .def_property_readonly(
            "points",
            [](const py::object& self) { return view(self.cast<const BSpline&>().points(), self); },
            "(n, 3) float64, model units; a read-only view.")
        .def_property_readonly(
            "weights",
            [](const py::object& self) {
                const auto& curve = self.cast<const BSpline&>();
                return weights_or_none(curve.weights(),
                                       {static_cast<py::ssize_t>(curve.points().size())}, self);
            },
            "(n,) float64, None for a polynomial spline.")
        .def_property_readonly(
            "knots", [](const BSpline& s) { return to_array(s.knots().values()); }, "float64.")
        .def_property_readonly(
            "domain",
            [](const BSpline& s) { return py::make_tuple(s.knots().begin(), s.knots().end()); },
            "First and last parameter.")
        .def(
            "evaluate",
            [](const BSpline& curve, const py::object& t) { return evaluate_spline(curve, t); },
            py::arg("t"), "Points at parameters of any shape, clamped to the domain; (..., 3).")
        .def("split", &BSpline::split, py::arg("t"),
             "The parts before and after t, over their share of the domain.")
        .def("insert_knot", &BSpline::with_knot, py::arg("t"), py::arg("times") = 1,
             "The same curve with one knot more.")
        .def("elevate", &BSpline::elevated, "The same curve one degree higher.")
        .def(
            "length",
            [](const BSpline& curve, double tolerance) {
                const CurveLength l = long_call([&] { return curve.length(tolerance); });
                return py::make_tuple(l.length, l.bound);
            },
            py::arg("tolerance"), "Arc length, and a bound on its error below the tolerance.")
        .def(
            "bounds", [](const BSpline& curve) { return to_array(curve.bounds()); },
            "Box of the control points, (2, 3).")
        .def("__repr__", [](const BSpline& s) {
            return with_points("BSpline", s.points().size(), s.degree(), s.rational());
        });
    bind_common(c);
}

void bind_cubic(py::module_& m)
{
    py::class_<CubicSpline> c(m, "CubicSpline",
                              R"(Uniform C2 cubic spline by its A-frame points.

ends : "natural" (from the first to the last point), "free", or "closed" (the points are a ring)

>>> spline = genus.CubicSpline([[0, 0, 0], [1, 1, 0], [2, 0, 0]])
>>> len(spline.bezier_segments()), spline.evaluate(2).tolist()
(2, [2.0, 0.0, 0.0]))");
    c.def(py::init(&make_cubic), py::arg("points"), py::arg("ends") = "natural")
        .def_static(
            "through",
            [](const ArrayLike& points, const std::string& ends) {
                return cubic_spline_through(
                    to_control_points(points, "points"),
                    static_cast<CubicEnds>(
                        choice(ends, "through: ends", {"natural", "free", "closed"})));
            },
            py::arg("points"), py::arg("ends") = "natural",
            "The spline with a joint at each of the points.")
        .def_property_readonly(
            "points",
            [](const py::object& self) {
                return view(self.cast<const CubicSpline&>().a_frame_points(), self);
            },
            "(n, 3) float64: the A-frame points; a read-only view.")
        .def_property_readonly(
            "bezier_points", [](const CubicSpline& s) { return to_array(s.bezier_points()); },
            "(3 pieces + 1, 3) float64: all Bezier points in order.")
        .def(
            "evaluate",
            [](const CubicSpline& curve, const py::object& t) { return evaluate_spline(curve, t); },
            py::arg("t"), "Points at parameters from 0 to the number of pieces; (..., 3).")
        .def("to_bspline", &CubicSpline::to_bspline, "The same as a BSpline.")
        .def("__repr__", [](const CubicSpline& s) {
            return "<genus.CubicSpline: " + std::to_string(s.a_frame_points().size()) + " points>";
        });
    bind_common(c);
}

}  // namespace

void bind_curves(py::module_& m)
{
    bind_polyline(m);
    bind_bezier(m);
    bind_bspline(m);
    bind_cubic(m);
    m.def("interpolate", &interpolated, py::arg("points"), py::arg("ends") = "not_a_knot",
          py::arg("parametrization") = "centripetal", py::kw_only(),
          py::arg("start_tangent") = py::none(), py::arg("end_tangent") = py::none(),
          R"(The C2 cubic BSpline through the points, (n, 3).

ends : "not_a_knot", "natural", "clamped" (with both tangents) or "periodic"
parametrization : "uniform", "chord_length" or "centripetal"

>>> genus.interpolate([[0, 0, 0], [1, 1, 0], [2, 0, 0], [3, 1, 0]]).evaluate(1).tolist()
[3.0, 1.0, 0.0])");
    m.def("fit_spline", &spline_fit, py::arg("points"), py::arg("n_points"), py::arg("degree") = 3,
          py::arg("parametrization") = "chord_length",
          "Least-squares BSpline with n_points control points: (curve, largest distance, root mean "
          "square).");
    m.def(
        "elliptic_arc",
        [](const VectorLike& center, const VectorLike& a, const VectorLike& b, double start,
           double sweep) {
            return elliptic_arc(to_vec3(center, "center"), to_vec3(a, "a"), to_vec3(b, "b"), start,
                                sweep);
        },
        py::arg("center"), py::arg("a"), py::arg("b"), py::arg("start") = 0.0,
        py::arg("sweep") = 360.0,
        R"(center + a cos x + b sin x for x from start over sweep degrees, exactly: a NURBS of degree 2.

>>> circle = genus.elliptic_arc([0, 0, 0], [2, 0, 0], [0, 2, 0])
>>> round(float((circle.evaluate(0.3) ** 2).sum()), 12)
4.0)");
}

}  // namespace genus::python
