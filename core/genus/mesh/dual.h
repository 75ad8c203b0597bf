#pragma once

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// The dual of a closed mesh: a vertex at the barycentre (the mean of the corners) of each face,
/// a face round each vertex, an edge across each edge. Vertex i and face j of the dual belong to
/// face i and vertex j of the mesh; the outside stays outside. The dual of the dual has the
/// connectivity of the mesh. O(V + F).
///
/// Throws InvalidInput, naming an element, if the mesh is open, not oriented, not manifold, or has
/// a vertex with fewer than three edges.
PolygonMesh dual(const PolygonMesh& mesh);
PolygonMesh dual(const IndexedMesh& mesh);

}  // namespace genus
