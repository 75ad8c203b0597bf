#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// An edge with more than two faces.
struct ComplexEdge {
    std::int32_t a, b;
    std::vector<std::int32_t> faces;
    bool operator==(const ComplexEdge&) const = default;
};

/// An edge with one face, from `a` to `b` as that face runs.
struct BoundaryEdge {
    std::int32_t a, b;
    std::int32_t face;
    bool operator==(const BoundaryEdge&) const = default;
};

/// A vertex whose faces form more than one fan: no neighbourhood of it is a disc or half disc.
struct ComplexVertex {
    std::int32_t vertex;
    std::int32_t fans;
    bool operator==(const ComplexVertex&) const = default;
};

/// An edge whose two faces run along it in the same direction.
struct FlippedEdge {
    std::int32_t a, b;
    std::array<std::int32_t, 2> faces;
    bool operator==(const FlippedEdge&) const = default;
};

/// What holds of a mesh as a surface, whatever its shape. The flags say:
/// closed - every edge has at least two faces; oriented - the two faces of an edge run along it in
/// opposite directions; orientable - faces could be turned so that they do; manifold - no complex
/// edge or vertex.
struct SurfaceKind {
    std::int64_t vertices = 0, edges = 0, faces = 0;
    std::int64_t boundary_edges = 0;
    /// Closed curves of boundary edges, followed from fan to fan where they meet in a vertex.
    std::int64_t boundary_loops = 0;
    /// V - E + F.
    std::int64_t euler = 0;
    /// Handles of the surface with its boundary loops capped: 2 - 2 genus = euler + loops, summed
    /// over components. Only for manifold, orientable surfaces.
    std::optional<std::int64_t> genus;
    bool closed = true, oriented = true, orientable = true, manifold = true;
};

struct Topology : SurfaceKind {
    /// Parts that hang together by vertices, in the order of their smallest vertex.
    std::vector<SurfaceKind> components;
    /// The component of each vertex, -1 for those that no face names.
    std::vector<std::int32_t> component_of_vertex;
    std::int64_t isolated_vertices = 0;

    /// Faces of fewer than three corners or with a vertex twice. They bound nothing and are left
    /// out of all that is said here.
    std::vector<std::int32_t> degenerate_faces;
    std::vector<BoundaryEdge> open_edges;  // in the order of faces
    std::vector<ComplexEdge> complex_edges;
    std::vector<ComplexVertex> complex_vertices;
    std::vector<FlippedEdge> flipped_edges;

    /// How many vertices have 0, 1, 2, ... edges; the last entry counts all from there on.
    std::array<std::int64_t, 33> valences{};
    std::int32_t least_valence = 0, greatest_valence = 0;
    double mean_valence = 0.0;
};

/// O(V + F) for bounded valence. Throws InvalidInput if a face names a vertex that is not there.
///
/// Implements [botsch2010], sections 1.3 and 2.1 (manifolds, Euler formula).
Topology topology(const IndexedMesh& mesh);
Topology topology(const PolygonMesh& mesh);

/// The flags alone, faster.
bool is_closed(const IndexedMesh& mesh);
bool is_oriented(const IndexedMesh& mesh);

}  // namespace genus
