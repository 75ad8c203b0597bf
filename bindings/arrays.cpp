#include "arrays.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace genus::python {

namespace {

std::string describe(const py::handle& value)
{
    if (py::hasattr(value, "shape"))
        return "an array of shape " + py::str(value.attr("shape")).cast<std::string>();
    const auto type = py::type::handle_of(value).attr("__name__").cast<std::string>();
    if (py::isinstance<py::sequence>(value) && !py::isinstance<py::str>(value))
        return "a " + type + " of " + std::to_string(py::len(value));
    return "a " + type;
}

[[noreturn]] void expected(const char* argument, const std::string& what, const py::handle& got)
{
    throw py::value_error(std::string(argument) + ": expected " + what + ", got " + describe(got));
}

bool is_number(const py::handle& value)
{
    return PyFloat_Check(value.ptr()) || PyIndex_Check(value.ptr()) ||
           (PyNumber_Check(value.ptr()) && !PySequence_Check(value.ptr()));
}

bool is_row(const py::handle& value)
{
    return PySequence_Check(value.ptr()) && !PyUnicode_Check(value.ptr()) &&
           !PyBytes_Check(value.ptr());
}

double to_number(const py::handle& value, const char* argument)
{
    if (!is_number(value)) expected(argument, "numbers", value);
    const double number = PyFloat_AsDouble(value.ptr());
    if (number == -1.0 && PyErr_Occurred()) throw py::error_already_set();
    return number;
}

void make_read_only(py::array& array)
{
    py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
}

template <class Row, class Scalar>
py::array view_rows(const std::vector<Row>& values, const py::object& owner)
{
    const auto n = static_cast<py::ssize_t>(values.size());
    const auto* data = reinterpret_cast<const Scalar*>(values.data());
    py::array array(py::dtype::of<Scalar>(), std::vector<py::ssize_t>{n, 3}, data, owner);
    make_read_only(array);
    return array;
}

std::int32_t to_vertex(std::int64_t vertex, const char* argument, std::size_t n_vertices)
{
    if (vertex < 0 || static_cast<std::uint64_t>(vertex) >= n_vertices)
        throw py::value_error(std::string(argument) + ": vertex " + std::to_string(vertex) +
                              " is not among the " + std::to_string(n_vertices) + " vertices");
    return static_cast<std::int32_t>(vertex);
}

void check_count(std::size_t n_vertices, const char* argument)
{
    if (n_vertices > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
        throw py::value_error(std::string(argument) + ": more than 2^31 - 1 vertices");
}

}  // namespace

std::vector<double> to_numbers(const py::handle& value, const char* argument)
{
    if (!is_row(value)) expected(argument, "numbers", value);
    std::vector<double> numbers;
    for (const py::object item : py::reinterpret_borrow<py::sequence>(value))
        numbers.push_back(to_number(item, argument));
    return numbers;
}

Vec3 to_vec3(const py::handle& value, const char* argument)
{
    if (!is_row(value) || py::len(value) != 3) expected(argument, "3 numbers", value);
    const std::vector<double> n = to_numbers(value, argument);
    return {{n[0], n[1], n[2]}};
}

Vec3 to_vec3_or_uniform(const py::handle& value, const char* argument)
{
    if (is_row(value)) return to_vec3(value, argument);
    if (!is_number(value)) expected(argument, "a number or 3 numbers", value);
    const double n = to_number(value, argument);
    return {{n, n, n}};
}

Transform to_transform(const py::handle& value, const char* argument)
{
    const char* shape = "a matrix of shape (4, 4) or (3, 4)";
    if (!is_row(value)) expected(argument, shape, value);
    const std::size_t n_rows = py::len(value);
    if (n_rows != 3 && n_rows != 4) expected(argument, shape, value);
    Transform t;
    for (std::size_t row = 0; row < n_rows; ++row) {
        const py::object item = value[py::int_(row)];
        if (!is_row(item) || py::len(item) != 4) expected(argument, shape, value);
        const std::vector<double> numbers = to_numbers(item, argument);
        std::copy(numbers.begin(), numbers.end(), t.m[row].begin());
    }
    return t;
}

Box3 to_box(const py::handle& value, const char* argument)
{
    if (!is_row(value) || py::len(value) != 2)
        expected(argument, "two corners, shape (2, 3)", value);
    return {to_vec3(value[py::int_(0)], argument), to_vec3(value[py::int_(1)], argument)};
}

PointArray to_point_array(const py::handle& value, const char* argument)
{
    PointArray points = PointArray::ensure(value);
    if (!points) expected(argument, "numbers of shape (n, 3)", value);
    if (points.size() == 0 && points.ndim() == 1)
        return PointArray(std::vector<py::ssize_t>{0, 3});  // an empty list
    if (points.ndim() != 2 || points.shape(1) != 3)
        expected(argument, "an array of shape (n, 3)", points);
    return points;
}

std::span<const Vec3> rows(const PointArray& points)
{
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    return {reinterpret_cast<const Vec3*>(points.data()),
            static_cast<std::size_t>(points.shape(0))};
}

std::vector<Triangle> to_triangles(const py::handle& value, const char* argument,
                                   std::size_t n_vertices)
{
    check_count(n_vertices, argument);
    const py::array any = py::array::ensure(value);
    if (!any) expected(argument, "vertex numbers of shape (m, 3)", value);
    if (any.size() == 0) return {};
    if (any.ndim() != 2 || any.shape(1) != 3) expected(argument, "an array of shape (m, 3)", any);
    if (any.dtype().kind() != 'i' && any.dtype().kind() != 'u')
        throw py::value_error(std::string(argument) + ": vertex numbers must be integers, got " +
                              py::str(any.dtype()).cast<std::string>());
    const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> wide(any);
    std::vector<Triangle> triangles(static_cast<std::size_t>(wide.shape(0)));
    const std::int64_t* vertex = wide.data();
    for (Triangle& triangle : triangles)
        for (std::int32_t& corner : triangle) corner = to_vertex(*vertex++, argument, n_vertices);
    return triangles;
}

PolygonMesh to_polygon_mesh(const py::handle& points, const py::handle& faces)
{
    const PointArray array = to_point_array(points, "points");
    PolygonMesh mesh;
    mesh.vertices.assign(rows(array).begin(), rows(array).end());
    check_count(mesh.n_vertices(), "points");
    if (!is_row(faces)) expected("faces", "a list of faces", faces);
    std::vector<std::int32_t> corners;
    for (const py::object face : py::reinterpret_borrow<py::sequence>(faces)) {
        if (!is_row(face)) expected("faces", "a list of lists of vertex numbers", faces);
        corners.clear();
        for (const py::object corner : py::reinterpret_borrow<py::sequence>(face)) {
            const py::ssize_t vertex = PyNumber_AsSsize_t(corner.ptr(), PyExc_OverflowError);
            if (vertex == -1 && PyErr_Occurred()) throw py::error_already_set();
            corners.push_back(to_vertex(vertex, "faces", mesh.n_vertices()));
        }
        mesh.add_face(corners);
    }
    return mesh;
}

py::array view(const std::vector<Vec3>& values, const py::object& owner)
{
    return view_rows<Vec3, double>(values, owner);
}

py::array view(const std::vector<Triangle>& values, const py::object& owner)
{
    return view_rows<Triangle, std::int32_t>(values, owner);
}

py::array to_array(const Vec3& value)
{
    return py::array_t<double>(3, value.c.data());
}

py::array to_array(const Box3& box)
{
    py::array_t<double> array(std::vector<py::ssize_t>{2, 3});
    std::memcpy(array.mutable_data(0, 0), box.min.c.data(), sizeof(Vec3));
    std::memcpy(array.mutable_data(1, 0), box.max.c.data(), sizeof(Vec3));
    return array;
}

py::array to_array(std::vector<Vec3> values)
{
    auto* owned = new std::vector<Vec3>(std::move(values));
    py::capsule owner(owned, [](void* p) { delete static_cast<std::vector<Vec3>*>(p); });
    return py::array_t<double>(std::vector<py::ssize_t>{static_cast<py::ssize_t>(owned->size()), 3},
                               reinterpret_cast<const double*>(owned->data()), owner);
}

}  // namespace genus::python
