#pragma once

#include "genus/mesh/indexed_mesh.h"
#include "genus/polygon/region.h"

namespace genus {

/// Where the horizontal plane at height z cuts the solid inside a closed oriented mesh, seen from
/// above. A vertex at that very height counts as above the plane: a face in the plane is the
/// slice if the solid lies beneath it, and not if it lies upon it. Which edges are cut, and how
/// their crossings join to rings, is decided by comparing heights; only the crossings are rounded.
///
/// Parts turned inside out count as solid, overlapping parts once. O(F) beside the rings. Throws
/// InvalidInput if z or a coordinate is not finite, for a vertex number out of range, or if the
/// plane meets an open edge, naming it.
Region slice(const IndexedMesh& mesh, double z);

/// The shadow on the plane z = 0 of the solid inside a closed oriented mesh: all that lies straight
/// below or above it. O((n + k) log n) for n upward faces whose projections cross k times. Throws
/// InvalidInput as `slice` does, save for open meshes, whose upward faces alone cast the shadow.
Region project(const IndexedMesh& mesh);

}  // namespace genus
