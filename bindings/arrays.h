#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/transform.h"
#include "genus/mesh/indexed_mesh.h"

namespace py = pybind11;

namespace genus::python {

inline bool any_object(PyObject*)
{
    return true;
}

/// What Python hands over where numbers are wanted: lists, tuples or arrays. Numpy is imported
/// only by the functions here that return or take arrays of points, never for three numbers.
class VectorLike : public py::object {
    PYBIND11_OBJECT(VectorLike, object, any_object)
};
class NumberOrVector : public py::object {
    PYBIND11_OBJECT(NumberOrVector, object, any_object)
};
class ArrayLike : public py::object {
    PYBIND11_OBJECT(ArrayLike, object, any_object)
};

/// `argument` is the name used in the ValueError that says what was expected and what came.
Vec3 to_vec3(const py::handle& value, const char* argument);
/// One number stands for all three.
Vec3 to_vec3_or_uniform(const py::handle& value, const char* argument);
std::vector<double> to_numbers(const py::handle& value, const char* argument);
/// (4, 4), or (3, 4) with the last row left out.
Transform to_transform(const py::handle& value, const char* argument);
/// (2, 3): lower and upper corner.
Box3 to_box(const py::handle& value, const char* argument);

using PointArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// An (n, 3) array; itself where it is C-contiguous float64, else converted once.
PointArray to_point_array(const py::handle& value, const char* argument);
/// The rows of it, without a copy.
std::span<const Vec3> rows(const PointArray& points);
/// (m, 3) vertex numbers, each checked to be in [0, n_vertices).
std::vector<Triangle> to_triangles(const py::handle& value, const char* argument,
                                   std::size_t n_vertices);
/// Faces of any degree: an (m, k) array or a list of lists, numbers checked as above.
PolygonMesh to_polygon_mesh(const py::handle& points, const py::handle& faces);

/// Read-only (n, 3) views that keep `owner` alive.
py::array view(const std::vector<Vec3>& values, const py::object& owner);
py::array view(const std::vector<Triangle>& values, const py::object& owner);
/// Arrays of their own, shape (3,), (2, 3) and (n, 3).
py::array to_array(const Vec3& value);
py::array to_array(const Box3& box);
py::array to_array(std::vector<Vec3> values);

template <class T>
py::array to_array(std::vector<T> values)
{
    auto* owned = new std::vector<T>(std::move(values));
    py::capsule owner(owned, [](void* p) { delete static_cast<std::vector<T>*>(p); });
    return py::array_t<T>(static_cast<py::ssize_t>(owned->size()), owned->data(), owner);
}

}  // namespace genus::python

namespace pybind11::detail {

template <>
struct handle_type_name<genus::python::VectorLike> {
    static constexpr auto name = const_name("Sequence[float]");
};
template <>
struct handle_type_name<genus::python::NumberOrVector> {
    static constexpr auto name = const_name("float | Sequence[float]");
};
template <>
struct handle_type_name<genus::python::ArrayLike> {
    static constexpr auto name = const_name("ArrayLike");
};

}  // namespace pybind11::detail
