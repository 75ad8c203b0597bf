#pragma once

#include <array>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// What the solid inside a closed oriented mesh measures, at density 1.
struct Measures {
    double volume = 0.0;
    double area = 0.0;
    /// Centre of mass; of the surface where the volume is zero.
    Vec3 centroid;
    /// About the centroid, symmetric; diagonal entries are integrals of y^2 + z^2 and so on.
    std::array<std::array<double, 3>, 3> inertia{};
};

/// Integrals of polynomials over the tetrahedra between the faces and the middle of the mesh,
/// exact but for rounding. Coordinates are taken relative to that point, so a part far from the
/// origin loses no more than its coordinates have lost. Signed: a mesh turned inside out has
/// negative volume. Where the mesh is open, volume, centroid and inertia are those of the mesh
/// closed by a cone to the middle of its bounding box. O(faces), in parallel, the same bits at
/// any thread count. Throws InvalidInput if a face names a vertex that is not there.
///
/// Implements [eberly2002] (volume integrals by the divergence theorem).
Measures measure(const IndexedMesh& mesh);

double volume(const IndexedMesh& mesh);
double area(const IndexedMesh& mesh);

}  // namespace genus
