#pragma once

#include <pybind11/pybind11.h>

#include "bind.h"
#include "genus/polygon/region.h"

namespace genus::python {

/// What Python hands over where a plane shape is wanted: a ring (n, 2), a list of rings, of which
/// one inside another is a hole, or a Region.
Region to_region(const py::object& polygon);

py::class_<Region> bind_region(py::module_& m);
/// extrude and revolve, Mesh.slice and Mesh.project.
void bind_plane_construction(py::module_& m, py::class_<Mesh>& mesh);

}  // namespace genus::python
