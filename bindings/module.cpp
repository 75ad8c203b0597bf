#include <pybind11/pybind11.h>

#include "bind.h"
#include "forms.h"
#include "region.h"

PYBIND11_MODULE(_core, m)
{
    namespace python = genus::python;
    m.doc() = "The compiled core of genus.";
    m.attr("__version__") = GENUS_VERSION;
    python::bind_errors(m);
    python::bind_base(m);
    python::bind_reports(m);
    auto mesh = python::bind_mesh(m);
    python::bind_polygons(m, mesh);
    python::bind_forms(m, mesh);
    python::bind_mesh_tools(mesh);
    auto solid = python::bind_model(m);
    python::bind_quantities(solid);
    python::bind_freeform(m, solid);
    python::bind_region(m);
    python::bind_plane_construction(m, mesh);
    python::bind_implicit(m);
    python::bind_volume(m);
    python::bind_boolean(m, mesh);
    python::bind_io(m, mesh);
    python::bind_language(m);
}
