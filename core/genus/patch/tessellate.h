#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/patch/bezier_triangle.h"
#include "genus/patch/bspline_surface.h"
#include "genus/patch/tensor_patch.h"

namespace genus {

using Patch = std::variant<TensorPatch, BezierTriangle>;

struct TessellateOptions {
    /// Largest distance between mesh and patches, both ways, in model units.
    double tolerance = 0.0;
    /// Give up with ToleranceNotMet before more triangles than this.
    std::int64_t max_triangles = 20'000'000;
};

struct TessellatedPatches {
    IndexedMesh mesh;
    std::vector<std::int32_t> patch_of_face;
    /// Parameters (u, v) of the corners of each face, in its patch.
    std::vector<std::array<Vec2, 3>> corners;
    /// No point of the mesh is farther than this from the patches, nor the other way round.
    double bound = 0.0;
};

/// Triangulates patches to a tolerance, without cracks: the number of points on an edge, and the
/// points, depend on the control points of that edge only, whichever patch it belongs to and in
/// whichever direction it runs. Edges with the same corners whose control points agree, once
/// elevated to a common degree, to 1e-12 of their size are one edge; corners are one if their
/// coordinates are equal. Collapsed edges become one vertex. A closed model gives a closed mesh.
///
/// Every triangle is linear over a triangle of the domain that spans X in u and Y in v; it is
/// within (D_uu X^2 + 2 D_uv X Y + D_vv Y^2) / 8 of the patch, with D bounds of the second
/// derivatives from the control net. Each patch has a regular grid inside, and a ring of
/// triangles that joins it to the edges; the ring is made narrower until its own bound, taken
/// over the strip, is under the tolerance. O(triangles).
///
/// Implements [filip1986] (the bound); the ring is ours.
/// Throws InvalidInput if the tolerance is not positive, ToleranceNotMet below rounding or above
/// `max_triangles`.
TessellatedPatches tessellate(std::span<const Patch> patches, const TessellateOptions& options);
TessellatedPatches tessellate(const BSplineSurface& surface, const TessellateOptions& options);

/// Largest distance found between mesh and patches, by sampling: from the middles of all faces and
/// of their sides to the points of the patches with the same parameters. Shares nothing with the
/// bound. O(faces).
double measured_deviation(std::span<const Patch> patches, const TessellatedPatches& made);

/// An edge as a patch has it: its number there, and whether it runs like the common edge.
struct PatchEdgeUse {
    std::int32_t patch;
    std::int32_t edge;
    bool forward;
    bool operator==(const PatchEdgeUse&) const = default;
};
/// The edges of all patches, each once, with those who have it; collapsed ones left out. Edges are
/// one as `tessellate` takes them.
std::vector<std::vector<PatchEdgeUse>> common_edges(std::span<const Patch> patches);

}  // namespace genus
