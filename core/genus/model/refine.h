#pragma once

#include <vector>

#include "genus/model/cell_mesh.h"
#include "genus/model/surface_form.h"

namespace genus {

/// Makes a closed surface mesh manifold where the solid touches itself: at an edge of four or more
/// faces, those that bound the same wedge of matter stay together, and a vertex with several fans
/// of faces becomes one vertex a fan. Returns false, and leaves the mesh alone, if it is not
/// closed and oriented to begin with. O(F).
bool separate_fans(SurfaceMesh& mesh);

/// Moves every vertex onto the exact surface, curve or corner of the surfaces it stands on (Newton
/// steps of least norm), except where a face would turn over. Returns the number of vertices that
/// had to stay.
std::int64_t settle(SurfaceMesh& mesh, const std::vector<SurfaceForm>& forms);

}  // namespace genus
