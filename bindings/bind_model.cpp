#include <cmath>
#include <string>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/model/csg_field.h"
#include "genus/model/leaves.h"
#include "genus/model/patch_solid.h"
#include "genus/model/plan.h"
#include "genus/model/queries.h"
#include "genus/model/solid.h"
#include "long_call.h"

#include <pybind11/stl.h>

namespace genus::python {

namespace {

using Number = std::optional<double>;

// The radius where a shape takes a radius or a diameter.
Number radius(const char* shape, const Number& r, const Number& d)
{
    if (r && d) throw InvalidInput(std::string(shape) + ": give r or d, not both");
    return d ? Number(*d / 2) : r;
}

double needed(const Number& value, const std::string& text)
{
    if (!value) throw InvalidInput(text);
    return *value;
}

Solid make_sphere(Number r, Number d, int fragments)
{
    return sphere(needed(radius("sphere", r, d), "sphere: give its radius r or diameter d"),
                  fragments);
}

Solid make_cylinder(double h, Number r, Number d, Number r1, Number r2, Number d1, Number d2,
                    bool center, int fragments)
{
    const Number both = radius("cylinder", r, d);
    const Number bottom = radius("cylinder", r1, d1), top = radius("cylinder", r2, d2);
    if (both && (bottom || top))
        throw InvalidInput("cylinder: give one radius or those of both ends, not all");
    const char* text = "cylinder: give r, d, or the radii or diameters of both ends";
    return cylinder(h, needed(both ? both : bottom, text), needed(both ? both : top, text), center,
                    fragments);
}

Solid make_quadric(const py::object& coefficients, const py::object& bounds)
{
    std::optional<Box3> box;
    if (!bounds.is_none()) box = to_box(bounds, "bounds");
    if (py::len(coefficients) == 10) {
        const std::vector<double> ten = to_numbers(coefficients, "coefficients");
        std::array<double, 10> q;
        std::copy(ten.begin(), ten.end(), q.begin());
        return quadric(Quadric(q), box);
    }
    if (py::len(coefficients) != 4)
        throw py::value_error("coefficients: expected 10 numbers or a (4, 4) matrix");
    return quadric(Quadric::from_matrix(to_transform(coefficients, "coefficients").m), box);
}

Solid rotated(const Solid& s, const py::object& angles, const py::object& axis)
{
    if (!axis.is_none())
        return transformed(s, rotation(angles.cast<double>(), to_vec3(axis, "axis")));
    if (PySequence_Check(angles.ptr())) return transformed(s, rotation(to_vec3(angles, "angles")));
    return transformed(s, rotation_z(angles.cast<double>()));
}

Vec4 to_color(const py::object& value, double alpha)
{
    const std::vector<double> c = to_numbers(value, "color");
    if (c.size() != 3 && c.size() != 4)
        throw py::value_error("color: expected 3 or 4 numbers in [0, 1], got " +
                              std::to_string(c.size()));
    return {{c[0], c[1], c[2], c.size() == 4 ? c[3] : alpha}};
}

MeshMethod to_method(const std::string& name)
{
    if (name == "auto") return MeshMethod::Auto;
    if (name == "boolean") return MeshMethod::Boolean;
    if (name == "emc") return MeshMethod::Emc;
    if (name == "mc") return MeshMethod::Mc;
    throw InvalidInput("mesh: method is \"" + name + "\", must be auto, boolean, emc or mc");
}

Mesh make_mesh(const Solid& solid, Number tolerance, const std::string& method, bool use_plan,
               bool measure, const py::object& region, std::int64_t max_triangles,
               const py::object& progress)
{
    MeshOptions options;
    if (!region.is_none()) options.region = to_box(region, "region");
    options.tolerance = tolerance;
    options.method = to_method(method);
    options.plan = use_plan;
    options.measure = measure;
    options.max_triangles = max_triangles;
    const double start = seconds_now();
    Mesh mesh(long_call([&] { return mesh_solid(solid, options); }, progress));
    mesh.seconds = seconds_now() - start;
    mesh.was_measured = measure;
    return mesh;
}

py::array inside(const Solid& solid, const py::object& points)
{
    const PointArray array = to_point_array(points, "points");
    const std::vector<char> flags = long_call([&] { return contains(solid, rows(array)); });
    py::array_t<bool> result(static_cast<py::ssize_t>(flags.size()));
    std::copy(flags.begin(), flags.end(), result.mutable_data());
    return result;
}

py::array field_values(const Solid& solid, const py::object& points)
{
    const PointArray array = to_point_array(points, "points");
    return to_array(long_call([&] { return values(solid, rows(array)); }));
}

py::array field_gradients(const Solid& solid, const py::object& points)
{
    const PointArray array = to_point_array(points, "points");
    return to_array(long_call([&] { return gradients(solid, rows(array)); }));
}

py::array box_of(const Solid& solid, Number tolerance)
{
    if (!tolerance) return to_array(solid.bounds());
    return to_array(long_call([&] { return tight_bounds(solid, *tolerance); }));
}

// Hits of all rays, ray after ray, as arrays.
struct RayHits {
    std::vector<std::int64_t> ray;
    std::vector<double> t;
    std::vector<Vec3> points;
    std::vector<Vec3> normals;
    std::vector<std::uint8_t> entering;
    std::vector<std::int64_t> leaf;
    Solid solid;  // that was hit

    void add(std::size_t number, const SolidHit& hit)
    {
        ray.push_back(static_cast<std::int64_t>(number));
        t.push_back(hit.t);
        points.push_back(hit.point);
        normals.push_back(hit.normal);
        entering.push_back(hit.entering);
        leaf.push_back(hit.leaf);
    }

    // One name a hit.
    std::vector<std::string> leaf_names() const
    {
        const std::vector<std::string> all = genus::leaf_names(solid);
        std::vector<std::string> names;
        for (const std::int64_t i : leaf) names.push_back(all[static_cast<std::size_t>(i)]);
        return names;
    }
};

RayHits cast_rays(const Solid& solid, const ArrayLike& origins, const ArrayLike& directions)
{
    const PointArray from = to_point_array(origins, "origins");
    const PointArray along = to_point_array(directions, "directions");
    if (from.shape(0) != along.shape(0))
        throw py::value_error("ray_cast: " + std::to_string(from.shape(0)) + " origins, " +
                              std::to_string(along.shape(0)) + " directions");
    return long_call([&] {
        const auto hits = ray_cast(solid, rows(from), rows(along));
        RayHits all;
        all.solid = solid;
        for (std::size_t i = 0; i < hits.size(); ++i)
            for (const SolidHit& hit : hits[i]) all.add(i, hit);
        return all;
    });
}

void bind_ray_hits(py::module_& m)
{
    py::class_<RayHits>(
        m, "RayHits",
        "Where rays enter and leave a solid: arrays, ray after ray, along each in order.")
        .def_property_readonly(
            "ray", [](const RayHits& h) { return to_array(h.ray); }, "(k,) int64: which ray.")
        .def_property_readonly(
            "t", [](const RayHits& h) { return to_array(h.t); },
            "(k,) float64: the point is origin + t direction.")
        .def_property_readonly(
            "points", [](const RayHits& h) { return to_array(h.points); }, "(k, 3) float64.")
        .def_property_readonly(
            "normals", [](const RayHits& h) { return to_array(h.normals); },
            "(k, 3) float64: outward, length 1.")
        .def_property_readonly(
            "entering",
            [](const RayHits& h) {
                return to_array(h.entering).attr("view")(py::dtype::of<bool>());
            },
            "(k,) bool: into the solid, else out of it.")
        .def_property_readonly(
            "leaf", [](const RayHits& h) { return to_array(h.leaf); },
            "(k,) int64: whose surface it is, as Solid.leaves() counts.")
        .def_property_readonly("leaf_names", &RayHits::leaf_names,
                               "The names of those, one a hit: \"sphere(r = 2)\".")
        .def("__len__", [](const RayHits& h) { return h.t.size(); });
}

std::string kind(const Solid& solid)
{
    static constexpr const char* names[] = {
        "empty",        "cube",       "sphere",      "ellipsoid",  "cylinder", "torus",
        "half space",   "quadric",    "implicit",    "polyhedron", "freeform", "union",
        "intersection", "difference", "transformed", "colored"};
    static_assert(std::size(names) == std::variant_size_v<Shape>);
    return names[solid.node().shape.index()];
}

Solid solid_of(const py::object& given)
{
    if (py::isinstance<PatchModel>(given)) {
        const auto& model = given.cast<const PatchModel&>();
        return long_call([&] { return patch_solid(oriented(model)); });
    }
    if (!py::isinstance<Mesh>(given))
        throw py::type_error("solid: expected a Mesh or a PatchModel");
    const auto& mesh = given.cast<const Mesh&>();
    const bool stands_for_curves =
        mesh.made && (mesh.made->method == "patches" || mesh.made->method == "freeform");
    return polyhedron(to_polygons(*mesh.triangles),
                      stands_for_curves ? mesh.made->error.bound : 0.0);
}

void bind_shapes(py::module_& m)
{
    m.def(
        "cube",
        [](const NumberOrVector& size, bool center) {
            return cube(to_vec3_or_uniform(size, "size"), center);
        },
        py::arg("size"), py::arg("center") = false,
        R"(Box with a corner at the origin, or its centre there; size in model units.

>>> genus.cube([2, 3, 4]).bounds().tolist()
[[0.0, 0.0, 0.0], [2.0, 3.0, 4.0]])");
    m.def("sphere", &make_sphere, py::arg("r") = py::none(), py::kw_only(),
          py::arg("d") = py::none(), py::arg("fragments") = 0,
          R"(Ball about the origin, by radius r or diameter d.

fragments : 0 for the exact ball, else the polyhedron of the text language with that many sides

>>> genus.sphere(2).contains([[0, 0, 2], [0, 0, 2.001]]).tolist()
[True, False])");
    m.def(
        "ellipsoid",
        [](double rx, double ry, double rz) {
            return ellipsoid({{rx, ry, rz}});
        },
        py::arg("rx"), py::arg("ry"), py::arg("rz"),
        R"(Ellipsoid about the origin with these radii along x, y and z.

>>> genus.ellipsoid(1, 2, 3).bounds().tolist()
[[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]])");
    m.def("cylinder", &make_cylinder, py::arg("h"), py::arg("r") = py::none(), py::kw_only(),
          py::arg("d") = py::none(), py::arg("r1") = py::none(), py::arg("r2") = py::none(),
          py::arg("d1") = py::none(), py::arg("d2") = py::none(), py::arg("center") = false,
          py::arg("fragments") = 0,
          R"(Cylinder along z from z = 0, or centred; a frustum with r1 below and r2 above.

>>> genus.cylinder(h=4, r1=2, r2=1, center=True).contains([[1.4, 0, 0], [1.4, 0, 1.5]]).tolist()
[True, False])");
    m.def(
        "cone", [](double h, double r, bool center) { return cylinder(h, r, 0.0, center); },
        py::arg("h"), py::arg("r"), py::arg("center") = false,
        R"(Cone of height h along z, radius r below, apex above.

>>> genus.cone(3, 1).contains([[0, 0, 3], [0.5, 0, 1.6]]).tolist()
[True, False])");
    m.def("torus", &torus, py::arg("R"), py::arg("r"),
          R"(Torus about the z axis: R to the middle of the tube, r the radius of the tube, r < R.

>>> genus.torus(R=3, r=1).contains([[3, 0, 1], [0, 0, 0]]).tolist()
[True, False])");
    m.def(
        "half_space",
        [](const VectorLike& normal, double offset) {
            return half_space(to_vec3(normal, "normal"), offset);
        },
        py::arg("normal"), py::arg("offset"),
        R"(All points p with normal . p <= offset. Unbounded until something bounds it.

>>> top = genus.sphere(1) - genus.half_space([0, 0, 1], 0)
>>> top.contains([[0, 0, 0.5], [0, 0, -0.5]]).tolist()
[True, False])");
    m.def(
        "quadric",
        [](const ArrayLike& q, const py::object& bounds) { return make_quadric(q, bounds); },
        py::arg("coefficients"), py::arg("bounds") = py::none(),
        R"(All points with p^T Q p <= 0, p = (x, y, z, 1), cut to bounds (2, 3) where given.

coefficients : the symmetric (4, 4) matrix Q, or its upper triangle row by row, ten numbers

>>> ball = genus.quadric([1, 0, 0, 0, 1, 0, 0, 1, 0, -4], bounds=[[-2, -2, -2], [2, 2, 2]])
>>> ball.contains([[0, 0, 1.9], [1.5, 1.5, 0]]).tolist()
[True, False])");
    m.def(
        "polyhedron",
        [](const ArrayLike& points, const ArrayLike& faces) {
            return polyhedron(to_polygon_mesh(points, faces));
        },
        py::arg("points"), py::arg("faces"),
        R"(Solid bounded by flat faces: points (n, 3), faces lists of point numbers, counterclockwise
seen from outside, of any length.

>>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
>>> genus.polyhedron(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]).bounds().tolist()
[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])");
    m.def(
        "solid", &solid_of, py::arg("mesh"),
        R"(The solid that a closed Mesh, or a closed PatchModel, bounds. A PatchModel is meshed when the
solid is, to its tolerance. A Mesh stays as it is; one made from patches, or of a deformed solid,
brings its error bound along.)");
}

void bind_solid(py::class_<Solid>& solid)
{
    const auto add = [](const Solid& a, const Solid& b) { return unite({a, b}); };
    const auto sub = [](const Solid& a, const Solid& b) { return subtract({a, b}); };
    const auto both = [](const Solid& a, const Solid& b) { return intersect({a, b}); };
    solid.def(py::init<>(), "The empty solid.")
        .def("__add__", add, py::is_operator())
        .def("__or__", add, py::is_operator())
        .def("__sub__", sub, py::is_operator())
        .def("__and__", both, py::is_operator())
        .def(
            "__eq__", [](const Solid& a, const Solid& b) { return a == b; }, py::is_operator())
        .def("__hash__", &Solid::hash)
        .def("__repr__", [](const Solid& s) { return "<genus.Solid: " + kind(s) + ">"; })
        .def(
            "translate",
            [](const Solid& s, const VectorLike& by) {
                return transformed(s, translation(to_vec3(by, "by")));
            },
            py::arg("by"),
            R"(Moved by (x, y, z).

>>> genus.cube(1).translate([5, 0, 0]).bounds().tolist()
[[5.0, 0.0, 0.0], [6.0, 1.0, 1.0]])")
        .def(
            "rotate",
            [](const Solid& s, const NumberOrVector& angles, const py::object& axis) {
                return rotated(s, angles, axis);
            },
            py::arg("angles"), py::arg("axis") = py::none(),
            R"(Turned by degrees: (about x, then y, then z), or one angle about axis, z without it.

>>> genus.cube([2, 1, 1]).rotate([0, 0, 90]).bounds()[:, 1:].tolist()
[[0.0, 0.0], [2.0, 1.0]])")
        .def(
            "scale",
            [](const Solid& s, const NumberOrVector& by) {
                return transformed(s, scaling(to_vec3_or_uniform(by, "by")));
            },
            py::arg("by"), "Scaled about the origin by one factor or by (x, y, z).")
        .def(
            "mirror",
            [](const Solid& s, const VectorLike& normal) {
                return transformed(s, mirror(to_vec3(normal, "normal")));
            },
            py::arg("normal"), "Mirrored at the plane through the origin with this normal.")
        .def(
            "transform",
            [](const Solid& s, const ArrayLike& matrix) {
                return transformed(s, to_transform(matrix, "matrix"));
            },
            py::arg("matrix"), "Moved by an affine matrix, (4, 4) or (3, 4), acting on columns.")
        .def(
            "color",
            [](const Solid& s, const VectorLike& rgba, double alpha) {
                return colored(s, to_color(rgba, alpha));
            },
            py::arg("rgba"), py::arg("alpha") = 1.0, "Coloured by 3 or 4 numbers in [0, 1].")
        .def("bounds", &box_of, py::arg("tolerance") = py::none(),
             R"(Box that holds the solid, (2, 3), infinite where no bound is known; not always the
tightest: a difference has the bounds of its first operand. With a tolerance, each side is that
near the solid.

>>> (genus.cube(4) - genus.cube([6, 9, 9], center=True)).bounds(tolerance=0.01).round(1).tolist()
[[3.0, 0.0, 0.0], [4.0, 4.0, 4.0]])")
        .def_property_readonly("is_empty", &Solid::is_empty, "True if nothing is in it.")
        .def_property_readonly("kind", &kind, "What the tree's root is: \"sphere\", \"union\", ...")
        .def(
            "contains", [](const Solid& s, const ArrayLike& p) { return inside(s, p); },
            py::arg("points"), "For points (n, 3), (n,) bool: inside or on the border.")
        .def(
            "value", [](const Solid& s, const ArrayLike& p) { return field_values(s, p); },
            py::arg("points"),
            "For points (n, 3), (n,) float64: a function F with F <= 0 in the solid, known up to "
            "positive\n"
            "factors on its leaves.")
        .def(
            "gradient", [](const Solid& s, const ArrayLike& p) { return field_gradients(s, p); },
            py::arg("points"),
            "For points (n, 3), (n, 3) float64: gradient of F, that of one branch at a crease.")
        .def("ray_cast", &cast_rays, py::arg("origins"), py::arg("directions"),
             R"(Entries and exits of rays, origins (n, 3) and directions (n, 3), in order: RayHits.

>>> hits = (genus.sphere(2) - genus.cylinder(9, 1)).ray_cast([[-3, 0, 1]], [[1, 0, 0]])
>>> hits.t.round(3).tolist(), hits.leaf.tolist()
([1.268, 2.0, 4.0, 4.732], [0, 1, 1, 0])
>>> hits.leaf_names[1]
'cylinder(h = 9, r = 1)')")
        .def(
            "leaves", [](const Solid& s) { return long_call([&] { return leaf_names(s); }); },
            R"(The primitives of the tree by name, in its order, the parts of an operator from left to
right; RayHits.leaf counts them. Transforms are not told.

>>> (genus.sphere(2) - genus.cylinder(9, 1).rotate([90, 0, 0])).leaves()
['sphere(r = 2)', 'cylinder(h = 9, r = 1)'])")
        .def(
            "explain", [](const Solid& s) { return plan(s).explanation; },
            "What planning leaves out of the work.")
        .def("mesh", &make_mesh, py::arg("tolerance") = py::none(), py::arg("method") = "auto",
             py::kw_only(), py::arg("plan") = true, py::arg("measure") = true,
             py::arg("region") = py::none(), py::arg("max_triangles") = MeshOptions{}.max_triangles,
             py::arg("progress") = py::none(),
             R"(Closed triangle mesh no farther than tolerance from the solid, both ways.

Parameters
----------
tolerance : model units; a thousandth of the bounding box's diagonal if left out
method : "auto", "boolean", "emc" (extended marching cubes) or "mc" (marching cubes)
plan : leave out what cannot touch the result
measure : sample the distance between mesh and solid (mesh.error.measured)
region : (2, 3), only what is in this box, cut out and closed by its sides
max_triangles : give up with ToleranceNotMet before more would be made
progress : called with (stage, share done) now and then

Raises
------
UnboundedSolid, ToleranceNotMet, InvalidInput

>>> mesh = (genus.sphere(10) - genus.cylinder(h=30, r=3, center=True)).mesh(tolerance=0.1)
>>> mesh.is_closed, mesh.topology.genus, mesh.error.measured <= mesh.error.bound <= 0.1
(True, 1, True))");
}

}  // namespace

py::class_<Solid> bind_model(py::module_& m)
{
    py::class_<Solid> solid(
        m, "Solid",
        "A solid: an immutable tree of shapes, moves and operators. Copies share; no geometry is\n"
        "made before a mesh or a value is asked for. a + b and a | b unite, a - b subtracts,\n"
        "a & b intersects.");
    bind_ray_hits(m);
    bind_shapes(m);
    bind_solid(solid);
    return solid;
}

}  // namespace genus::python
