#pragma once

#include <vector>

#include "genus/model/flexible_mesh.h"
#include "genus/model/surface_form.h"

namespace genus {

/// Makes a mesh with all vertices on their surfaces as coarse as the curvature allows, and its
/// faces round: collapses edges across which normals turn little, flips others, and moves vertices
/// inside of faces towards the middle of their neighbours. What stays is fine only where curves are
/// near each other. No face turns from the exact normals at its corners by more than about 35
/// degrees, and chords of curves stay flat beside the faces along them, or within `flat_enough` of
/// both surfaces: where these touch their curve may go anywhere between.
///
/// A finer mesh may still be needed to prove what is so near by: then use the mesh as it was.
/// O(n log n) for n edges.
void widen(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms, double max_error,
           double flat_enough);

}  // namespace genus
