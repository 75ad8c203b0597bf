#pragma once

#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"
#include "genus/patch/patch_model.h"
#include "long_call.h"

// What the bindings of curves, patches and lattices share.
namespace genus::python {

/// Parameters as they come: one number, or an array of any shape.
class Parameters {
public:
    Parameters(const py::handle& value, const char* argument)
        : values_(py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value))
    {
        if (!values_) {
            PyErr_Clear();
            throw py::value_error(std::string(argument) + ": expected numbers");
        }
    }
    /// Both of one shape, by the rules of numpy.
    static std::pair<Parameters, Parameters> broadcast(const py::handle& u, const py::handle& v)
    {
        Parameters a(u, "u"), b(v, "v");
        if (a.shape() == b.shape()) return {a, b};
        const py::tuple both =
            py::module_::import("numpy").attr("broadcast_arrays")(a.values_, b.values_);
        return {Parameters(both[0], "u"), Parameters(both[1], "v")};
    }

    std::span<const double> values() const
    {
        return {values_.data(), static_cast<std::size_t>(values_.size())};
    }
    std::size_t size() const { return static_cast<std::size_t>(values_.size()); }
    std::vector<py::ssize_t> shape() const
    {
        return {values_.shape(), values_.shape() + values_.ndim()};
    }
    /// A new array of points, one a parameter: its shape with (3,) added.
    py::array_t<double> points() const
    {
        std::vector<py::ssize_t> s = shape();
        s.push_back(3);
        return py::array_t<double>(s);
    }
    py::array_t<double> numbers() const { return py::array_t<double>(shape()); }

private:
    py::array_t<double, py::array::c_style | py::array::forcecast> values_;
};

inline std::span<Vec3> writable_rows(py::array_t<double>& points)
{
    return {reinterpret_cast<Vec3*>(points.mutable_data()),
            static_cast<std::size_t>(points.size()) / 3};
}

/// Few points are done at once, many on other threads, without the interpreter lock.
template <class Work>
void bulk_call(std::size_t n, const Work& work)
{
    constexpr std::size_t kFew = 4096;
    if (n <= kFew)
        work();
    else
        long_call(work);
}

/// Control points of a curve, (n, 3) or plane ones, (n, 2).
std::vector<Vec3> to_control_points(const py::handle& value, const char* argument);
/// Those of a surface, (m, n, 3), and both numbers.
struct ControlNet {
    std::size_t rows, columns;
    std::vector<Vec3> points;
};
ControlNet to_control_net(const py::handle& value, const char* argument);
/// None is none.
std::vector<double> to_weights(const py::object& value);
/// Read-only views that keep `owner` alive, `shape` without the last 3.
py::array view_points(const std::vector<Vec3>& values, const std::vector<py::ssize_t>& shape,
                      const py::object& owner);
py::object weights_or_none(const std::vector<double>& weights,
                           const std::vector<py::ssize_t>& shape, const py::object& owner);
/// One of `names` by its place, or InvalidInput "`argument` is .., must be one of ..".
std::size_t choice(const std::string& given, const char* argument,
                   std::initializer_list<const char*> names);

/// A tessellation as what Python sees, with error and seconds.
Mesh tessellated(const PatchModel& model, double tolerance, bool measure,
                 std::int64_t max_triangles, const py::object& progress);

void bind_curves(py::module_& m);
void bind_patches(py::module_& m);
void bind_lattices(py::module_& m, py::class_<Solid>& solid);

}  // namespace genus::python
