#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/model/plan.h"
#include "genus/model/solid.h"

namespace genus {

enum class MeshMethod {
    Auto,     ///< certified: exact boolean for polyhedra, adaptive cells for curved solids
    Boolean,  ///< exact boolean of leaf meshes
    Emc,      ///< extended marching cubes on a uniform grid, sharp edges kept; see grid_road.h
    Mc        ///< marching cubes, sharp edges cut off by up to a cell; as above
};

struct MeshOptions {
    /// Largest distance between mesh and exact solid, both ways, in model units. Without it, a
    /// thousandth of the diagonal of the bounding box.
    std::optional<double> tolerance;
    MeshMethod method = MeshMethod::Auto;
    /// Leave out what cannot touch the result. The mesh is the same without, later.
    bool plan = true;
    /// Sample the distance between mesh and exact solid (ErrorReport::measured).
    bool measure = true;
    /// Only what is in this box, as if it were cut out: the mesh is closed by sides of the box.
    /// Parts that do not reach into it cost no more than a look at their boxes.
    std::optional<Box3> region;
    /// Faces not much longer one way than the other, also where the solid is straight: for meshes
    /// that are bent afterwards.
    bool round_faces = false;
    /// Give up with ToleranceNotMet before more triangles than this would be made.
    std::int64_t max_triangles = 20'000'000;
};

/// How far mesh and exact solid are apart, in model units.
struct ErrorReport {
    /// No point of either surface is farther than this from the other.
    double bound = 0.0;
    /// True if `bound` is proven, false if estimated.
    bool certified = false;
    /// Largest distance found by sampling both ways, independent of how `bound` came about.
    double measured = 0.0;
    /// The share of each cause in `bound`, largest first.
    std::vector<std::pair<std::string, double>> parts;
    /// What is not proven, and near which place; empty if `certified`.
    std::string doubt;
};

struct MeshedSolid {
    IndexedMesh mesh;
    double tolerance = 0.0;
    std::string method;  // the road taken: "boolean", "emc", "mc"
    ErrorReport error;
    std::vector<std::pair<std::string, double>> seconds;  // by stage, in order
    Explanation explanation;
};

/// The road from tree to closed mesh: plan, leaf meshes or field, boolean or extended marching
/// cubes, certificate, gate. The mesh is closed, oriented, manifold and free of
/// self-intersections, or the call throws. Where the solid touches itself along an edge, each wedge
/// of matter has the edge for itself, with vertices at the same coordinates.
///
/// Throws UnboundedSolid naming the leaf, ToleranceNotMet with the places, InvalidInput for a
/// tolerance that is not positive, a region that is no box or a polyhedron that is no closed
/// surface, Cancelled.
MeshedSolid mesh_solid(const Solid& solid, const MeshOptions& options = {});

}  // namespace genus
