#pragma once

#include <span>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/patch/tessellate.h"

namespace genus {

/// How two patches join along a common edge, by the worst of several places on it.
struct PatchJoin {
    PatchEdgeUse a, b;
    double gap;   // C0: distance between the patches, model units
    double turn;  // G1: angle between the normals, radians; pi where one patch is turned over
};

/// Patches that share boundary curves: a surface of many pieces, closed or not.
class PatchModel {
public:
    explicit PatchModel(std::vector<Patch> patches);

    const std::vector<Patch>& patches() const { return patches_; }
    /// Every edge once, with the patches that have it; see common_edges.
    const std::vector<std::vector<PatchEdgeUse>>& edges() const { return edges_; }
    /// Every edge belongs to two patches (or twice to one).
    bool is_closed() const;
    /// No edge belongs to more than two, and where it belongs to two, they run through it in
    /// opposite directions: all fronts are on one side.
    bool is_oriented() const;
    /// Joins along all edges of two patches, each measured at `samples` + 1 places.
    std::vector<PatchJoin> joins(int samples = 8) const;
    TessellatedPatches tessellate(const TessellateOptions& options) const;
    Box3 bounds() const;

private:
    std::vector<Patch> patches_;
    std::vector<std::vector<PatchEdgeUse>> edges_;
};

/// Image under an affine map; what was shared stays shared.
PatchModel transformed(const PatchModel& model, const Transform& map);

/// The same surfaces with u and v of some patches exchanged, so that neighbours have their fronts
/// on one side and every closed surface has them outside. A surface that is not orientable keeps an
/// edge where fronts change sides.
PatchModel oriented(const PatchModel& model);

/// Normals of the vertices: mean of the faces' normals, weighted by their angles there. Zero for
/// vertices without faces.
std::vector<Vec3> vertex_normals(const IndexedMesh& mesh);

/// A cubic triangle patch for every face of the mesh, tangent to the given normals at the vertices.
/// Neighbours share their boundary curves to the last bit, so the model is closed where the mesh
/// is; across edges it is smooth at the vertices only.
/// Throws InvalidInput for indices out of range or another number of normals than vertices.
///
/// Implements [vlachos2001] (the cubic geometry; its quadratic normals are not used).
PatchModel pn_triangles(const IndexedMesh& mesh, std::span<const Vec3> normals);
PatchModel pn_triangles(const IndexedMesh& mesh);

}  // namespace genus
