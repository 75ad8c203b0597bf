#include <cmath>
#include <string>
#include <vector>

#include <pybind11/stl.h>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"
#include "genus/base/transform.h"
#include "genus/io/region_file.h"
#include "genus/mesh/slice.h"
#include "genus/model/construct.h"
#include "genus/polygon/region.h"
#include "long_call.h"
#include "paths.h"
#include "region.h"

namespace genus::python {

namespace {

constexpr const char* kRings = "a ring (n, 2), a list of rings, or a Region";

using Number = std::optional<double>;

Ring to_ring(const py::handle& value, const char* argument)
{
    const auto points = PointArray::ensure(value);
    if (!points) throw py::value_error(std::string(argument) + ": expected " + kRings);
    if (points.size() == 0) return {};
    if (points.ndim() != 2 || points.shape(1) != 2)
        throw py::value_error(std::string(argument) + ": expected " + kRings +
                              ", got an array of shape " +
                              py::str(points.attr("shape")).cast<std::string>());
    Ring ring(static_cast<std::size_t>(points.shape(0)));
    const double* number = points.data();
    for (Vec2& p : ring) {
        p = {{number[0], number[1]}};
        number += 2;
    }
    return ring;
}

bool is_sequence(const py::handle& value)
{
    return PySequence_Check(value.ptr()) && !PyUnicode_Check(value.ptr()) &&
           !PyBytes_Check(value.ptr());
}

// True for a list of points, that is where the first item of the first item is a number.
bool is_one_ring(const py::handle& value)
{
    const py::object first = value[py::int_(0)];
    return is_sequence(first) && py::len(first) > 0 && !is_sequence(first[py::int_(0)]);
}

std::vector<Ring> to_rings(const py::handle& value, const char* argument)
{
    if (!is_sequence(value)) throw py::value_error(std::string(argument) + ": expected " + kRings);
    if (py::len(value) == 0) return {};
    if (is_one_ring(value)) return {to_ring(value, argument)};
    std::vector<Ring> rings;
    for (const py::object ring : py::reinterpret_borrow<py::sequence>(value))
        rings.push_back(to_ring(ring, argument));
    return rings;
}

FillRule to_fill_rule(const std::string& name)
{
    if (name == "evenodd") return FillRule::EvenOdd;
    if (name == "nonzero") return FillRule::NonZero;
    if (name == "positive") return FillRule::Positive;
    throw InvalidInput("Region: fill is \"" + name + "\", must be evenodd, nonzero or positive");
}

Region make_from(const py::object& rings, const std::string& fill)
{
    if (py::isinstance<Region>(rings)) return rings.cast<Region>();
    const FillRule rule = to_fill_rule(fill);
    const std::vector<Ring> list = to_rings(rings, "rings");
    return long_call([&] { return make_region(list, rule); });
}

py::array ring_array(const Ring& ring)
{
    return py::array_t<double>({static_cast<py::ssize_t>(ring.size()), py::ssize_t{2}},
                               ring.empty() ? nullptr : ring[0].c.data());
}

py::list ring_arrays(const std::vector<Ring>& rings)
{
    py::list list;
    for (const Ring& ring : rings) list.append(ring_array(ring));
    return list;
}

py::list polygon_list(const Region& region)
{
    py::list list;
    for (const Polygon& polygon : polygons(region))
        list.append(py::make_tuple(ring_array(polygon.outer), ring_arrays(polygon.holes)));
    return list;
}

py::array box_array(const Region& region)
{
    const Box2 box = bounds(region);
    const std::vector<double> corners{box.min[0], box.min[1], box.max[0], box.max[1]};
    return py::array_t<double>(std::vector<py::ssize_t>{2, 2}, corners.data());
}

py::array inside(const Region& region, const ArrayLike& points)
{
    const auto array = PointArray::ensure(points);
    if (!array || array.ndim() != 2 || array.shape(1) != 2)
        throw py::value_error("points: expected numbers of shape (n, 2)");
    py::array_t<bool> result(array.shape(0));
    const double* number = array.data();
    for (py::ssize_t i = 0; i < array.shape(0); ++i, number += 2)
        result.mutable_at(i) = contains(region, {{number[0], number[1]}});
    return result;
}

Region combine(Region (*operation)(std::span<const Region>), const Region& a, const Region& b)
{
    const std::vector<Region> operands{a, b};
    return long_call([&] { return operation(operands); });
}

Region except_common(const Region& a, const Region& b)
{
    const Region sum = combine(&unite, a, b), common = combine(&intersect, a, b);
    return combine(&subtract, sum, common);
}

Region offset_by(const Region& region, Number r, Number delta, bool chamfer, int fragments,
                 Number tolerance)
{
    if (r.has_value() == delta.has_value())
        throw InvalidInput("offset: give r for round corners or delta for straight ones");
    OffsetOptions options;
    const double distance = r ? *r : *delta;
    if (r) {
        const double reach = std::fabs(distance);
        options.fragments = fragments;
        if (fragments == 0 && std::isfinite(reach) && reach > 0.0)
            options.fragments = sides_within(tolerance.value_or(1e-3 * reach), reach);
    } else {
        options.join = chamfer ? JoinStyle::Chamfer : JoinStyle::Miter;
    }
    if (options.fragments == 0) options.fragments = 3;  // of a circle without extent
    return long_call([&] { return offset(region, distance, options); });
}

Region hull_of(const Region& region)
{
    std::vector<Vec2> points;
    for (const Ring& ring : region.rings) points.insert(points.end(), ring.begin(), ring.end());
    Ring ring = convex_hull(points);
    return ring.empty() ? Region{} : Region{{std::move(ring)}};
}

// Positions mapped; rings of mirror images are turned so that the inside stays on the left.
template <class Map>
Region mapped(Region region, double determinant, const Map& map)
{
    if (determinant == 0.0 || !std::isfinite(determinant))
        throw InvalidInput("Region: the map is singular or not finite");
    for (Ring& ring : region.rings) {
        for (Vec2& p : ring) p = map(p);
        if (determinant < 0.0) std::reverse(ring.begin(), ring.end());
    }
    return region;
}

Vec2 to_vec2(const py::handle& value, const char* argument)
{
    const std::vector<double> n = to_numbers(value, argument);
    if (n.size() != 2)
        throw py::value_error(std::string(argument) + ": expected 2 numbers, got " +
                              std::to_string(n.size()));
    return {{n[0], n[1]}};
}

Vec2 to_vec2_or_uniform(const py::handle& value, const char* argument)
{
    if (is_sequence(value)) return to_vec2(value, argument);
    const auto number = value.cast<double>();
    return {{number, number}};
}

Region translated(const Region& region, const VectorLike& by)
{
    const Vec2 step = to_vec2(by, "by");
    return mapped(region, 1.0, [&](const Vec2& p) { return p + step; });
}

Region rotated(const Region& region, double angle)
{
    const double c = cos_degrees(angle), s = sin_degrees(angle);
    return mapped(region, c * c + s * s, [&](const Vec2& p) {
        return Vec2{{c * p[0] - s * p[1], s * p[0] + c * p[1]}};
    });
}

Region scaled(const Region& region, const NumberOrVector& by)
{
    const Vec2 f = to_vec2_or_uniform(by, "by");
    return mapped(region, f[0] * f[1], [&](const Vec2& p) {
        return Vec2{{f[0] * p[0], f[1] * p[1]}};
    });
}

Region mirrored(const Region& region, const VectorLike& normal)
{
    const Vec2 n = to_vec2(normal, "normal");
    const double length = dot(n, n);
    return mapped(region, length > 0.0 ? -1.0 : 0.0,
                  [&](const Vec2& p) { return p - (2.0 * dot(n, p) / length) * n; });
}

Solid extruded(const py::object& polygon, double h, double twist, const NumberOrVector& scale,
               bool center, int slices, Number tolerance)
{
    ExtrudeOptions options;
    options.height = h;
    options.twist = twist;
    options.scale = to_vec2_or_uniform(scale, "scale");
    options.center = center;
    options.slices = slices;
    const Region region = to_region(polygon);
    return long_call([&] { return extrude(region, options, tolerance); });
}

Solid revolved(const py::object& polygon, double angle, int fragments, Number tolerance)
{
    const Region region = to_region(polygon);
    return long_call([&] { return revolve(region, {angle, fragments}, tolerance); });
}

Region load_region(const Path& path, const std::string& layer, bool center, double dpi,
                   Number tolerance)
{
    require(std::isfinite(dpi) && dpi > 0.0, "load_region: dpi", dpi, "positive");
    RegionReadOptions options;
    options.layer = layer;
    options.center = center;
    options.dpi = dpi;
    options.tolerance = tolerance;
    if (tolerance) {
        require(std::isfinite(*tolerance) && *tolerance > 0.0, "load_region: tolerance", *tolerance,
                "positive");
        options.sides = [t = *tolerance](double r) { return r > 0.0 ? sides_within(t, r) : 3; };
    }
    return long_call([&] { return read_region(path.text, options); });
}

void bind_construction(py::module_& m)
{
    m.def("load_region", &load_region, py::arg("path"), py::kw_only(), py::arg("layer") = "",
          py::arg("center") = false, py::arg("dpi") = 72.0, py::arg("tolerance") = py::none(),
          R"(Read a plane shape from an SVG or DXF file: a Region.

layer : of a DXF drawing; all of it if left out
center : move the middle of the bounding box of an SVG picture to the origin
dpi : user units to the inch where an SVG picture gives its size in none
tolerance : of curves, model units; 40 sides a circle if left out)");
    m.def("extrude", &extruded, py::arg("polygon"), py::arg("h"), py::arg("twist") = 0.0,
          py::arg("scale") = 1.0, py::arg("center") = false, py::kw_only(), py::arg("slices") = 0,
          py::arg("tolerance") = py::none(),
          R"(Solid over a plane shape from z = 0 to z = h.

polygon : a ring (n, 2), a list of rings (a ring inside another is a hole), or a Region
twist : degrees over the whole height, clockwise seen from above
scale : of the top, one number or (x, y)
slices : layers of a twisted solid; 0 for as many as the tolerance needs
tolerance : largest distance to the twisted walls, model units; a quarter of a thousandth of the
    diagonal if left out

>>> genus.extrude([[0, 0], [2, 0], [0, 2]], 3).mesh().volume
6.0)");
    m.def("revolve", &revolved, py::arg("polygon"), py::arg("angle") = 360.0, py::kw_only(),
          py::arg("fragments") = 0, py::arg("tolerance") = py::none(),
          R"(Solid that a plane shape sweeps when it turns about the z axis: x of the shape is the
distance from the axis and must not change its sign, y of the shape becomes z.

angle : degrees, counterclockwise from the x axis
fragments : sides of a full turn; 0 for as many as the tolerance needs
tolerance : largest distance to the round solid, model units; a quarter of a thousandth of the
    diagonal if left out

>>> ring = genus.revolve([[2, 0], [3, 0], [3, 1], [2, 1]], fragments=4)
>>> round(ring.mesh().volume, 9), ring.mesh().topology.genus
(10.0, 1))");
}

void bind_operators(py::class_<Region>& region)
{
    const auto add = [](const Region& a, const Region& b) { return combine(&unite, a, b); };
    region.def("__add__", add, py::is_operator())
        .def("__or__", add, py::is_operator())
        .def(
            "__sub__", [](const Region& a, const Region& b) { return combine(&subtract, a, b); },
            py::is_operator())
        .def(
            "__and__", [](const Region& a, const Region& b) { return combine(&intersect, a, b); },
            py::is_operator())
        .def("__xor__", &except_common, py::is_operator())
        .def(
            "__eq__", [](const Region& a, const Region& b) { return a == b; }, py::is_operator())
        .def(
            "__bool__", [](const Region& r) { return !r.empty(); }, "False if empty.")
        .def("__repr__", [](const Region& r) {
            return "<genus.Region: " + std::to_string(r.rings.size()) + " rings, area " +
                   to_text(area(r)) + ">";
        });
    region.attr("__hash__") = py::none();
}

void bind_shape(py::class_<Region>& region)
{
    region
        .def_property_readonly(
            "rings", [](const Region& r) { return ring_arrays(r.rings); },
            "List of (n, 2) float64: outer rings counterclockwise, holes clockwise.")
        .def_property_readonly(
            "area", [](const Region& r) { return area(r); }, "Area, square model units.")
        .def_property_readonly("bounds", &box_array,
                               "(2, 2) float64: lower and upper corner of the bounding box.")
        .def_property_readonly("is_empty", &Region::empty, "True if nothing is in it.")
        .def("polygons", &polygon_list,
             "List of (outer ring, list of holes), each ring (n, 2) float64.")
        .def("contains", &inside, py::arg("points"),
             "For points (n, 2), (n,) bool: inside or on the border, decided exactly.")
        .def("hull", &hull_of, "The smallest convex region that holds it.")
        .def("offset", &offset_by, py::arg("r") = py::none(), py::kw_only(),
             py::arg("delta") = py::none(), py::arg("chamfer") = false, py::arg("fragments") = 0,
             py::arg("tolerance") = py::none(),
             R"(Grown by a distance, or shrunk by a negative one.

r : distance, with round corners
delta : distance, with corners prolonged until they meet, or with chamfer cut off square
fragments : sides of a full circle of round corners; 0 for as many as the tolerance needs
tolerance : of round corners, model units; a thousandth of r if left out

>>> square = genus.Region([[0, 0], [2, 0], [2, 2], [0, 2]])
>>> square.offset(delta=1).area, square.offset(delta=-0.5).area
(16.0, 1.0))")
        .def("translate", &translated, py::arg("by"), "Moved by (x, y).")
        .def("rotate", &rotated, py::arg("angle"), "Turned by degrees about the origin.")
        .def("scale", &scaled, py::arg("by"), "Scaled about the origin by one factor or by (x, y).")
        .def("mirror", &mirrored, py::arg("normal"),
             "Mirrored at the line through the origin with this normal.")
        .def(
            "save",
            [](const Region& r, const Path& path) {
                long_call([&] { write_region(path.text, r); });
            },
            py::arg("path"),
            R"(Write an SVG or DXF file, by the extension of the path, whole or not at all.

>>> genus.Region([[0, 0], [2, 0], [0, 2]]).save("corner.svg")
>>> genus.load_region("corner.svg").area
2.0)");
}

}  // namespace

Region to_region(const py::object& polygon)
{
    return make_from(polygon, "evenodd");
}

py::class_<Region> bind_region(py::module_& m)
{
    py::class_<Region> region(
        m, "Region",
        R"(A closed part of the plane, bounded by rings. Never changes. a + b and a | b unite, a - b
subtracts, a & b intersects, a ^ b keeps what is in one of the two; all exactly, but for the
rounding of crossings.

>>> plate = genus.Region([[0, 0], [4, 0], [4, 3], [0, 3]])
>>> hole = genus.Region([[1, 1], [2, 1], [2, 2], [1, 2]])
>>> (plate - hole).area, (plate - hole).contains([[1.5, 1.5], [1, 1]]).tolist()
(11.0, [False, True]))");
    region.def(py::init(&make_from), py::arg("rings") = py::tuple(), py::kw_only(),
               py::arg("fill") = "evenodd",
               R"(rings : a ring (n, 2), a list of rings, or a Region; rings may cross and overlap
fill : what counts as inside: "evenodd", "nonzero" or "positive" (counterclockwise only))");
    bind_shape(region);
    bind_operators(region);
    return region;
}

void bind_plane_construction(py::module_& m, py::class_<Mesh>& mesh)
{
    bind_construction(m);
    mesh.def(
            "slice",
            [](const Mesh& self, double z) {
                return long_call([&, t = self.triangles] { return slice(*t, z); });
            },
            py::arg("z"),
            R"(Where the horizontal plane at height z cuts the solid inside: a Region.

>>> genus.cube([2, 3, 4]).mesh().slice(1).area
6.0)")
        .def(
            "project",
            [](const Mesh& self) {
                return long_call([t = self.triangles] { return project(*t); });
            },
            R"(The shadow of the solid inside on the plane z = 0: a Region.

>>> genus.cube([2, 3, 4]).mesh().project().area
6.0)");
}

}  // namespace genus::python
