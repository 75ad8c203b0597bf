#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/model/cell_mesh.h"
#include "genus/model/flexible_mesh.h"
#include "genus/model/surface_form.h"

namespace genus {

/// Moves every vertex onto the exact surface, curve or corner of the surfaces it stands on (Newton
/// steps of least norm), except where a face would turn over. Returns the number of vertices that
/// had to stay.
std::int64_t settle(SurfaceMesh& mesh, const std::vector<SurfaceForm>& forms);

/// Removes what is small beside its cells: collapses edges shorter than about a third of the cell
/// they come from, where labels, topology and the exact normals allow, and flips edges towards
/// better shapes. Cells cut surfaces anyhow, so without this a mesh is full of slivers.
void coarsen(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms);

/// Coarsens and settles, and collapses vertices into a neighbour that are still farther than `far`
/// from a surface they stand on; twice, as room is made by that.
void settle_all(SurfaceMesh& mesh, const std::vector<SurfaceForm>& forms, double far);

/// Halves edges at exact points until the middle of none is farther than `max_error` from its
/// surface or curve, or than `max_error` times the least factor of its ends where `factors` (one a
/// vertex, extended for new ones) says so; where surfaces meet at an angle, nearer, so that the
/// offset the certificate needs there stays alike. Returns the places where the new point did not
/// fit in, because the mesh there is too coarse for the shape. Throws ToleranceNotMet beyond
/// `max_triangles`.
///
/// Curves may be asked to be flat beside the faces along them: an edge on a curve is also halved
/// until its sagitta is at most `crease_share` of the heights of its two faces, or below
/// `flat_enough`.
struct CreaseDemand {
    double crease_share = kNone, flat_enough = 0.0;
    static constexpr double kNone = 0.0;
};
std::vector<Box3> subdivide(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms,
                            double max_error, std::vector<double>& factors,
                            std::int64_t max_triangles, const CreaseDemand& creases = {});

/// Halves edges, given by their ends, at exact points. Those that are none, or cannot be halved,
/// are left. Returns how many were halved.
std::int64_t halve_edges(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms,
                         const std::vector<std::array<std::int32_t, 2>>& ends);

/// The same for the long sides of these faces: the longest, and those more than half as long.
std::int64_t halve_faces(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms,
                         const std::vector<std::int32_t>& faces);

}  // namespace genus
