#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/model/mesh_solid.h"

namespace genus::python {

namespace py = pybind11;

/// What a boolean of meshes tells of its result: of each face its operand and its number there, and
/// what work it left out.
struct MeshOrigin {
    std::vector<std::int32_t> operand;
    std::vector<std::int32_t> face;
    Explanation explanation;
};

/// What Python sees as genus.Mesh: triangles that never change, and the record of the call that
/// made them where there was one.
struct Mesh {
    std::shared_ptr<const IndexedMesh> triangles;
    std::shared_ptr<const MeshedSolid> made;   // null for a mesh that was loaded or given
    double seconds = 0.0;                      // of that call, as its caller sees it
    bool was_measured = false;                 // and whether it sampled the error
    std::shared_ptr<const MeshOrigin> origin;  // null unless a boolean of meshes made it
    // Made when first asked for, with the interpreter lock held.
    mutable std::shared_ptr<const Topology> topology;
    mutable std::optional<Measures> measures;

    explicit Mesh(IndexedMesh mesh)
        : triangles(std::make_shared<const IndexedMesh>(std::move(mesh)))
    {
    }
    explicit Mesh(MeshedSolid result) : made(std::make_shared<const MeshedSolid>(std::move(result)))
    {
        triangles = {made, &made->mesh};
    }
};

const Topology& topology_of(const Mesh& mesh);
const Measures& measures_of(const Mesh& mesh);
/// Seconds by stage of the call that made the mesh.
py::dict stage_seconds(const Mesh& mesh);
/// All of it as a genus.report.table.MeshReport.
py::object report(const Mesh& mesh);

void bind_errors(py::module_& m);
void bind_base(py::module_& m);
py::class_<Mesh> bind_mesh(py::module_& m);
void bind_reports(py::module_& m);
py::class_<Solid> bind_model(py::module_& m);
void bind_quantities(py::class_<Solid>& solid);
/// Curves, patches, lattices; see freeform.h.
void bind_freeform(py::module_& m, py::class_<Solid>& solid);
/// Formulas, and solids made from them.
void bind_implicit(py::module_& m);
/// Grids, marching cubes and squares; after everything that they give back.
void bind_volume(py::module_& m);
void bind_boolean(py::module_& m, py::class_<Mesh>& mesh);
void bind_io(py::module_& m, py::class_<Mesh>& mesh);
void bind_language(py::module_& m);

}  // namespace genus::python
