#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "arrays.h"
#include "bind.h"

namespace genus::python {

/// What Python sees as genus.PolygonMesh: faces of any degree that never change.
struct Polygons {
    std::shared_ptr<const PolygonMesh> mesh;
    // Made when first asked for, with the interpreter lock held.
    mutable std::shared_ptr<const Topology> topology;
    mutable std::optional<Mesh> triangles;

    explicit Polygons(PolygonMesh m) : mesh(std::make_shared<const PolygonMesh>(std::move(m))) {}
};

/// Cut into triangles, once.
const Mesh& triangles_of(const Polygons& polygons);

/// A read-only array over memory that `owner` keeps alive; strides in bytes.
template <class T>
py::array shared_view(std::shared_ptr<const void> owner, const T* data,
                      std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides)
{
    using Owner = std::shared_ptr<const void>;
    py::capsule base(new Owner(std::move(owner)), [](void* p) { delete static_cast<Owner*>(p); });
    py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, base);
    py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
    return array;
}

/// Of numbers one after the other.
template <class T>
py::array shared_view(std::shared_ptr<const void> owner, const std::vector<T>& values)
{
    return shared_view(std::move(owner), values.data(), {static_cast<py::ssize_t>(values.size())},
                       {sizeof(T)});
}

/// Of rows of k numbers: points, triangles.
template <class T, class Row>
py::array shared_rows(std::shared_ptr<const void> owner, const std::vector<Row>& rows)
{
    constexpr std::size_t k = sizeof(Row) / sizeof(T);
    return shared_view(std::move(owner), reinterpret_cast<const T*>(rows.data()),
                       {static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(k)},
                       {sizeof(Row), sizeof(T)});
}

/// genus.PolygonMesh, triangulate, platonic and other meshes made of numbers.
void bind_polygons(py::module_& m, py::class_<Mesh>& mesh);
/// The storage forms and their operators; after bind_polygons.
void bind_forms(py::module_& m, py::class_<Mesh>& mesh);
/// simplify, weld, repair, nearest, contains, ray_cast.
void bind_mesh_tools(py::class_<Mesh>& mesh);

}  // namespace genus::python
