#pragma once

#include <string>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// A plane with the solid where normal . p <= offset.
struct FacePlane {
    Vec3 normal;  // not normalised
    double offset;
};

/// The planes of the faces of a convex polyhedron, one a face; degenerate faces are passed over.
/// Signs are those of orient3d; a vertex above a plane by no more than 1e-12 of the size of the
/// mesh, where coordinates end, counts as on it.
///
/// Throws InvalidInput "`name`: ..." naming the face if the mesh is not closed and oriented, or
/// not convex. O(faces * vertices), at most 10^10.
std::vector<FacePlane> convex_face_planes(const PolygonMesh& mesh, const std::string& name);

/// The planes alone, for meshes convex by construction. O(corners).
std::vector<FacePlane> face_planes(const PolygonMesh& mesh);

}  // namespace genus
