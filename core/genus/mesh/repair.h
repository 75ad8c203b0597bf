#pragma once

#include <cstdint>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// Vertices closer than `tolerance` to an earlier one that was kept become that one; none moves
/// farther. With tolerance 0 only equal coordinates are joined. Faces are kept, also such as have
/// a vertex twice afterwards; vertices that no face names go. O(n) where few points are within
/// tolerance of each other. Throws InvalidInput for a negative tolerance, coordinates that are not
/// finite, or a vertex number out of range.
IndexedMesh weld(const IndexedMesh& mesh, double tolerance = 0.0);

/// For each point the number of the one that it becomes by `weld`. Throws as that does.
std::vector<std::int32_t> weld_targets(const std::vector<Vec3>& points, double tolerance);

/// What becomes of edges with more than two faces and vertices with more than one fan of faces.
enum class NonManifold {
    Keep,   ///< they stay
    Split,  ///< the mesh is cut apart there; no face goes
    Drop    ///< of an edge the two largest faces stay, of a vertex the fan with most faces
};

struct RepairOptions {
    double weld = 0.0;        // see weld(); model units
    bool t_junctions = true;  // cut faces where a vertex lies within an open edge
    bool orient = true;       // make neighbours agree, closed parts turn as nesting demands
    NonManifold non_manifold = NonManifold::Split;
    std::int64_t max_hole = 64;  // longest hole to close, in edges; 0: none. At most 500
};

/// What was done, in elements.
struct RepairReport {
    std::int64_t welded_vertices = 0;   // joined to others, or not used
    std::int64_t degenerate_faces = 0;  // dropped: a vertex twice
    std::int64_t duplicate_faces = 0;   // dropped: the vertices of an earlier face
    std::int64_t t_junctions = 0;       // vertices put into open edges
    std::int64_t turned_faces = 0;
    std::int64_t split_vertices = 0;  // added where fans were cut apart
    std::int64_t dropped_faces = 0;   // of complex edges and vertices
    std::int64_t closed_holes = 0;
    std::int64_t added_faces = 0;
    std::int64_t open_edges = 0;  // still there
};

struct RepairedMesh {
    IndexedMesh mesh;
    RepairReport report;
    /// The face that each face was or was cut from, -1 for those that close holes; and the vertex
    /// that each vertex was.
    std::vector<std::int32_t> source_face, source_vertex;
};

/// Mends what can be mended without moving vertices farther than the welding tolerance, in this
/// order: weld, drop degenerate and duplicate faces, cut faces at T-junctions, make neighbours
/// agree, cut apart or thin out complex edges and vertices, close holes, turn closed parts outward,
/// or inward in an odd number of others. A vertex makes a T-junction where it lies on an edge of
/// one face, exactly or within the welding tolerance, and has such an edge itself.
/// Parts that are one-sided stay as they are. Holes are closed by the triangles of least total
/// area, without new vertices; they may touch what is near. Whether the result is the border of a
/// solid is for `validate` to say.
///
/// O(F log F + n^3) for holes of n edges. Throws as `weld` does, and for options out of range.
///
/// Implements [barequet1995] (holes by dynamic programming).
RepairedMesh repair(const IndexedMesh& mesh, const RepairOptions& options = {});

}  // namespace genus
