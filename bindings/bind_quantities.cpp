#include "arrays.h"
#include "bind.h"
#include "genus/model/nearest.h"
#include "genus/model/quantities.h"
#include "long_call.h"

#include <pybind11/stl.h>

namespace genus::python {
namespace {

template <class F>
py::object bounded(const F& quantity, const Solid& solid, std::optional<double> tolerance,
                   std::optional<double> relative, const py::object& progress)
{
    QuantityOptions options;
    options.tolerance = tolerance;
    options.relative = relative;
    const BoundedValue found = long_call([&] { return quantity(solid, options); }, progress);
    return py::module_::import("genus.bounded")
        .attr("Bounded")(found.value, found.bound, found.certified);
}

py::tuple nearest(const Solid& solid, const ArrayLike& given, const py::object& progress)
{
    const PointArray array = to_point_array(given, "points");
    const std::vector<SurfacePoint> found =
        long_call([&] { return nearest_points(solid, rows(array)); }, progress);
    std::vector<Vec3> points;
    std::vector<double> distances, bounds;
    for (const SurfacePoint& p : found) {
        points.push_back(p.point);
        distances.push_back(p.distance);
        bounds.push_back(p.bound);
    }
    return py::make_tuple(to_array(points), to_array(distances), to_array(bounds));
}

}  // namespace

void bind_quantities(py::class_<Solid>& solid)
{
    using Number = std::optional<double>;
    const auto define = [&](const char* name, auto quantity, const char* text) {
        solid.def(
            name,
            [quantity](const Solid& s, Number tolerance, Number relative,
                       const py::object& progress) {
                return bounded(quantity, s, tolerance, relative, progress);
            },
            py::arg("tolerance") = py::none(), py::kw_only(), py::arg("relative") = py::none(),
            py::arg("progress") = py::none(), text);
    };
    using Measure = BoundedValue (*)(const Solid&, const QuantityOptions&);
    define(
        "volume", static_cast<Measure>(&genus::volume),
        R"(The volume, without a mesh: a float with .bound, which the exact one is not farther away.

Parameters
----------
tolerance : the largest bound, cubic model units
relative : the same as a share of the volume; 1e-6 if neither is given
progress : called with (stage, share done) now and then

Raises
------
UnboundedSolid, ToleranceNotMet, InvalidInput

>>> v = (genus.sphere(1) & genus.cylinder(h=4, r=0.6, center=True)).volume(relative=1e-6)
>>> round(v, 4), v.bound <= 1e-6 * v, v.certified
(2.0441, True, True))");
    define("area", static_cast<Measure>(&genus::area),
           R"(The area of the surface, without a mesh: a float with .bound, as volume.

tolerance : the largest bound, square model units

>>> a = genus.cylinder(h=1, r=1).area(relative=1e-8)
>>> round(a, 6), a.bound <= 1e-8 * a
(12.566371, True))");
    solid.def(
        "nearest", &nearest, py::arg("points"), py::kw_only(), py::arg("progress") = py::none(),
        R"(For points (n, 3) the nearest of the surface, without a mesh: (points, distances, bounds).
Faces, edges and corners count as the tree cuts them. No point of the surface is nearer than
distance - bound.

>>> points, distances, bounds = (genus.sphere(5) - genus.cylinder(20, 3)).nearest([[0, 0, -9]])
>>> distances.round(9).tolist()
[4.0])");
}

}  // namespace genus::python
