#pragma once

#include <cstdint>
#include <vector>

#include "genus/deform/ffd.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

struct DeformedMesh {
    IndexedMesh mesh;
    /// No point of it is farther than this from the image of the flat triangles given, nor the
    /// other way round.
    double bound = 0.0;
    /// Largest distance found between middles of faces and the images of their originals.
    double measured = 0.0;
};

/// Triangles within `tolerance` of the exact image of a mesh, which is curved: sides are halved
/// until the second derivatives of the map, bounded from its control points, allow no more.
/// What a side becomes depends on the triangles on both sides of it, hence no cracks; a closed
/// mesh stays closed. The mesh is cut along the border of the lattice, and along knots, where the
/// map has a kink there.
///
/// Throws InvalidInput if the mesh reaches across the border and the lattice tears it there,
/// ToleranceNotMet above `max_triangles`. O(triangles).
///
/// Implements [filip1986] (the bound, for a map of space).
DeformedMesh deformed_within(IndexedMesh mesh, const Lattice& lattice, double tolerance,
                             std::int64_t max_triangles);

/// How far a mesh may be at most from the exact image of another with the same faces: `images` are
/// its vertices, given for those of `source`, which need not be where the map takes these. Proven,
/// from the distance of both at the vertices and the second derivatives of the map between them.
///
/// Throws as deformed_within where the lattice tears the mesh. O(triangles).
double image_deviation(IndexedMesh source, std::vector<Vec3> images, const Lattice& lattice);

}  // namespace genus
