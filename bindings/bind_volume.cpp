#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/model/csg_field.h"
#include "genus/model/queries.h"
#include "genus/model/solid.h"
#include "genus/volume/extended_marching_cubes.h"
#include "genus/volume/grid_field.h"
#include "genus/volume/marching_cubes.h"
#include "genus/volume/marching_squares.h"
#include "long_call.h"

#include <pybind11/stl.h>

namespace genus::python {

namespace {

constexpr double kDefaultCells = 64.0;  // along the longest side of a solid

/// An array as it is if its numbers are of the type and stand in order, else a copy that is.
template <typename T>
using Samples = py::array_t<T, py::array::c_style | py::array::forcecast>;

py::array checked_array(const py::object& values, int dimensions)
{
    py::array array = py::array::ensure(values);
    if (!array) {
        PyErr_Clear();
        throw py::type_error("values: expected an array of numbers");
    }
    if (array.ndim() != dimensions)
        throw py::value_error("values: expected " + std::to_string(dimensions) +
                              " dimensions, got " + std::to_string(array.ndim()));
    if (array.dtype().kind() != 'f' && array.dtype().kind() != 'i' && array.dtype().kind() != 'u' &&
        array.dtype().kind() != 'b')
        throw py::type_error("values: expected real numbers");
    constexpr py::ssize_t most = 1 << 30;
    for (int axis = 0; axis < dimensions; ++axis)
        if (array.shape(axis) > most)
            throw py::value_error("values: more than 2^30 samples along an axis");
    return array;
}

bool is_narrow(const py::array& array)
{
    return array.dtype().kind() == 'f' && array.itemsize() == 4;
}

bool is_fortran(const py::array& array)
{
    return (array.flags() & py::array::f_style) != 0 && (array.flags() & py::array::c_style) == 0;
}

// Calls `f` with the numbers in memory order and the order that this is.
template <typename T, typename F>
auto with_samples_of(const py::array& array, const F& f)
{
    const bool fortran = is_fortran(array);
    const Samples<T> samples(fortran ? py::array(array.attr("T")) : array);
    const auto order = fortran ? SampleOrder::FirstFastest : SampleOrder::LastFastest;
    return f(std::span<const T>(samples.data(), static_cast<std::size_t>(samples.size())), order);
}

template <typename F>
auto with_samples(const py::array& array, const F& f)
{
    return is_narrow(array) ? with_samples_of<float>(array, f) : with_samples_of<double>(array, f);
}

GridSize size_of(const py::array& array)
{
    return {static_cast<std::int32_t>(array.shape(0)), static_cast<std::int32_t>(array.shape(1)),
            static_cast<std::int32_t>(array.shape(2))};
}

GridFrame to_frame(const py::object& origin, const py::object& spacing)
{
    const GridFrame frame{to_vec3(origin, "origin"), to_vec3_or_uniform(spacing, "spacing")};
    for (const double s : frame.spacing.c)
        if (!(s > 0.0 && std::isfinite(s))) throw InvalidInput("spacing: must be positive");
    if (!is_finite(frame.origin)) throw InvalidInput("origin: not finite");
    return frame;
}

Grid make_grid(const py::object& values, const py::object& origin, const py::object& spacing)
{
    const py::array array = checked_array(values, 3);
    const GridSize size = size_of(array);
    const GridFrame frame = to_frame(origin, spacing);
    return with_samples(array, [&](auto samples, SampleOrder order) {
        return long_call([&] {
            std::vector<double> own(samples.begin(), samples.end());
            if (order == SampleOrder::LastFastest && !own.empty()) {
                const std::size_t nx = size[0], ny = size[1], nz = size[2];
                parallel_for(ny * nz, 64, [&](std::size_t begin, std::size_t end) {
                    for (std::size_t row = begin; row < end; ++row)
                        for (std::size_t i = 0; i < nx; ++i)
                            own[row * nx + i] =
                                static_cast<double>(samples[(i * ny + row % ny) * nz + row / ny]);
                });
            }
            return Grid(size, std::move(own), frame);
        });
    });
}

py::array grid_values(const py::object& self)
{
    const auto& grid = self.cast<const Grid&>();
    const py::ssize_t nx = grid.size()[0], ny = grid.size()[1], nz = grid.size()[2];
    constexpr py::ssize_t b = sizeof(double);
    py::array_t<double> view({nx, ny, nz}, {b, b * nx, b * nx * ny}, grid.values().data(), self);
    view.attr("flags").attr("writeable") = false;
    return view;
}

template <typename T, typename F>
py::array at_points(const py::object& points, const F& f)
{
    const PointArray array = to_point_array(points, "points");
    return to_array(long_call([&] {
        const auto at = rows(array);
        std::vector<T> result(at.size());
        parallel_for(at.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) result[i] = f(at[i]);
        });
        return result;
    }));
}

/// The field of a solid, the box to look at and the size of cells.
struct SolidCells {
    SolidCells(const Solid& solid, const std::optional<double>& size)
        : box(require_bounded(solid)), field(solid)
    {
        const Vec3 sides = box.empty() ? Vec3{{1, 1, 1}} : box.size();
        const double longest = std::max({sides[0], sides[1], sides[2]});
        cell_size = size.value_or(longest / kDefaultCells);
        // A margin, so that sides of the solid do not lie in planes of the grid.
        if (!box.empty()) box = box.inflated(0.0137 * longest);
    }

    Box3 box;
    CsgField field;
    double cell_size;
};

/// `march(field, box, options)` on the field of a solid.
template <typename Options, typename March>
IndexedMesh on_solid(const Solid& solid, const std::optional<double>& cell_size, Options options,
                     const March& march)
{
    const SolidCells cells(solid, cell_size);
    options.cell_size = cells.cell_size;
    return cells.box.empty() ? IndexedMesh() : march(cells.field, cells.box, options);
}

Mesh timed(const std::function<IndexedMesh()>& work, const py::object& progress)
{
    const double start = seconds_now();
    Mesh mesh(long_call(work, progress));
    mesh.seconds = seconds_now() - start;
    return mesh;
}

Mesh cubes(const py::object& source, double level, const std::optional<double>& cell_size,
           const py::object& origin, const py::object& spacing, bool close_border,
           const py::object& progress)
{
    MarchingCubesOptions options;
    options.level = level;
    options.close_border = close_border;
    if (py::isinstance<Grid>(source)) {
        const auto& grid = source.cast<const Grid&>();
        return timed([&] { return marching_cubes(grid, options); }, progress);
    }
    if (py::isinstance<Solid>(source)) {
        const auto& solid = source.cast<const Solid&>();
        return timed(
            [&] {
                return on_solid(solid, cell_size, options,
                                [](const Implicit& field, const Box3& box, const auto& o) {
                                    return marching_cubes(field, box, o);
                                });
            },
            progress);
    }
    const py::array array = checked_array(source, 3);
    const GridFrame frame = to_frame(origin, spacing);
    return with_samples(array, [&](auto samples, SampleOrder order) {
        options.order = order;
        return timed([&] { return marching_cubes(samples, size_of(array), frame, options); },
                     progress);
    });
}

Mesh extended_cubes(const py::object& source, double level, const std::optional<double>& cell_size,
                    double theta_sharp, double phi_corner, bool close_border,
                    const py::object& progress)
{
    ExtendedMarchingCubesOptions options;
    options.level = level;
    options.close_border = close_border;
    options.features = {theta_sharp, phi_corner};
    if (py::isinstance<Grid>(source)) {
        const auto& grid = source.cast<const Grid&>();
        const Vec3& s = grid.frame().spacing;
        options.cell_size = cell_size.value_or(std::min({s[0], s[1], s[2]}));
        return timed(
            [&] { return extended_marching_cubes(GridField(grid), grid.bounds(), options); },
            progress);
    }
    if (!py::isinstance<Solid>(source))
        throw py::type_error("extended_marching_cubes: expected a Solid or a Grid");
    const auto& solid = source.cast<const Solid&>();
    return timed([&] { return on_solid(solid, cell_size, options, &extended_marching_cubes); },
                 progress);
}

py::list squares(const py::object& values, double level, const py::object& origin,
                 const py::object& spacing, bool close_border)
{
    const py::array array = checked_array(values, 2);
    const std::vector<double> start = to_numbers(origin, "origin");
    std::vector<double> step;
    if (PyNumber_Check(spacing.ptr()) && !PySequence_Check(spacing.ptr()))
        step.assign(2, spacing.cast<double>());
    else
        step = to_numbers(spacing, "spacing");
    if (start.size() != 2) throw py::value_error("origin: expected 2 numbers");
    if (step.size() != 2) throw py::value_error("spacing: expected a number or 2 numbers");
    const std::array<std::int32_t, 2> size{static_cast<std::int32_t>(array.shape(0)),
                                           static_cast<std::int32_t>(array.shape(1))};
    const SquareFrame frame{{{start[0], start[1]}}, {{step[0], step[1]}}};
    const auto lines = with_samples(array, [&](auto samples, SampleOrder order) {
        return long_call([&] {
            return marching_squares(samples, size, frame, {level, close_border, order});
        });
    });
    py::list result;
    for (const Contour& line : lines) {
        // The first point comes again at the end of what is closed, as plots want it.
        std::vector<Vec2> points = line.points;
        if (line.closed) points.push_back(points.front());
        py::array_t<double> row({static_cast<py::ssize_t>(points.size()), py::ssize_t{2}});
        std::copy_n(&points[0].c[0], 2 * points.size(), row.mutable_data());
        result.append(std::move(row));
    }
    return result;
}

void bind_grid(py::module_& m)
{
    py::class_<Grid>(
        m, "Grid",
        "Samples of a function on a regular grid, trilinear in between. Keeps a copy of "
        "the values.")
        .def(
            py::init(&make_grid), py::arg("values"),
            py::arg("origin") = py::make_tuple(0.0, 0.0, 0.0), py::arg("spacing") = 1.0,
            R"(values : (nx, ny, nz) real and finite, values[i, j, k] at origin + (i, j, k) * spacing
origin, spacing : model units; one spacing for all axes or (3,)

>>> import numpy as np
>>> grid = genus.Grid(np.arange(8.0).reshape(2, 2, 2))
>>> grid.value([[0.5, 0, 0], [0, 0, 0.5]]).tolist()
[2.0, 0.5])")
        .def_property_readonly("values", &grid_values, "(nx, ny, nz) float64, read-only.")
        .def_property_readonly(
            "origin", [](const Grid& g) { return to_array(g.frame().origin); }, "(3,) float64.")
        .def_property_readonly(
            "spacing", [](const Grid& g) { return to_array(g.frame().spacing); }, "(3,) float64.")
        .def_property_readonly(
            "shape",
            [](const Grid& g) { return py::make_tuple(g.size()[0], g.size()[1], g.size()[2]); },
            "Numbers of samples along x, y and z.")
        .def(
            "bounds", [](const Grid& g) { return to_array(g.bounds()); },
            "(2, 3): first and last sample.")
        .def(
            "value",
            [](const Grid& g, const py::object& points) {
                return at_points<double>(points, [&](const Vec3& p) { return g.value(p); });
            },
            py::arg("points"),
            "Trilinear interpolant at points (n, 3), (n,) float64; outside that of the nearest "
            "point.")
        .def(
            "gradient",
            [](const Grid& g, const py::object& points) {
                return at_points<Vec3>(points, [&](const Vec3& p) { return g.gradient(p); });
            },
            py::arg("points"), "Central differences, interpolated like the value: (n, 3) float64.")
        .def("__repr__", [](const Grid& g) {
            return "<genus.Grid: " + std::to_string(g.size()[0]) + " x " +
                   std::to_string(g.size()[1]) + " x " + std::to_string(g.size()[2]) + ">";
        });
}

}  // namespace

void bind_volume(py::module_& m)
{
    bind_grid(m);
    m.def("marching_cubes", &cubes, py::arg("source"), py::arg("level") = 0.0, py::kw_only(),
          py::arg("cell_size") = py::none(), py::arg("origin") = py::make_tuple(0.0, 0.0, 0.0),
          py::arg("spacing") = 1.0, py::arg("close_border") = true,
          py::arg("progress") = py::none(),
          R"(Triangle mesh of the places where a function reaches a level, smaller values inside.

Closed and manifold for any values, zeros and ties included: faces and insides of cells are decided
exactly as the trilinear interpolant runs. A value equal to the level is outside.

Parameters
----------
source : a Grid, an array (nx, ny, nz) of real numbers, or a Solid
level : the value on the surface
cell_size : for a Solid, longest edge of a cell; a 64th of the longest side if left out
origin, spacing : for an array, as those of a Grid
close_border : cap the surface where it leaves the grid
progress : called with (stage, share done) now and then

An array of float32 or float64 in C or Fortran order is not copied; other numbers become float64.

>>> import numpy as np
>>> x, y, z = np.mgrid[-1:1:20j, -1:1:20j, -1:1:20j]
>>> mesh = genus.marching_cubes(x**2 + y**2 + z**2, 0.7, origin=(-1, -1, -1), spacing=2 / 19)
>>> mesh.is_closed, mesh.topology.euler
(True, 2))");
    m.def("extended_marching_cubes", &extended_cubes, py::arg("source"), py::arg("level") = 0.0,
          py::kw_only(), py::arg("cell_size") = py::none(), py::arg("theta_sharp") = 0.9,
          py::arg("phi_corner") = 0.7, py::arg("close_border") = true,
          py::arg("progress") = py::none(),
          R"(Marching cubes with the sharp edges and corners of the surface.

Parameters
----------
source : a Solid or a Grid
cell_size : longest edge of a cell; a 64th of the longest side, or the spacing, if left out
theta_sharp : an edge runs through a cell if two of its normals have an inner product below this
phi_corner : a corner, if a normal leans out of the plane of those two by a sine above this
level, close_border, progress : as for marching_cubes

>>> mesh = genus.extended_marching_cubes(genus.cube(1), cell_size=0.1)
>>> round(mesh.volume, 12), mesh.is_closed
(1.0, True))");
    m.def(
        "marching_squares", &squares, py::arg("values"), py::arg("level") = 0.0, py::kw_only(),
        py::arg("origin") = py::make_tuple(0.0, 0.0), py::arg("spacing") = 1.0,
        py::arg("close_border") = false,
        R"(Lines on which samples of a plane reach a level: a list of arrays (k, 2), smaller values on
their left. Closed ones end with their first point; others end on the border.

Parameters
----------
values : (nx, ny), values[i, j] at origin + (i, j) * spacing
close_border : close all lines along the border, as if everything beyond were larger

>>> import numpy as np
>>> x, y = np.mgrid[-2:2:41j, -2:2:41j]
>>> [ring] = genus.marching_squares(np.hypot(x, y), 1.0, origin=(-2, -2), spacing=0.1)
>>> bool(abs(np.hypot(*ring.T) - 1).max() < 0.01)
True)");
}

}  // namespace genus::python
