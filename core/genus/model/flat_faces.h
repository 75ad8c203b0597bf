#pragma once

#include <vector>

#include "genus/model/flexible_mesh.h"
#include "genus/model/surface_form.h"

namespace genus {

/// Makes the faces in planes round, where a curve borders on them: an edge that leaves a vertex of
/// a curve at a small angle would be on the wrong side of it once the curve is cut finely. In
/// planes edges are flipped to a Delaunay triangulation, and edges of their borders are halved as
/// long as a vertex is nearer to their middles than their ends are.
///
/// Implements [ruppert1995], section 3, without its points in the middle of faces, for a few
/// rounds. O(faces) a round.
void round_flat_faces(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms);

}  // namespace genus
