#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/mesh/handles.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

class HalfedgeMesh;

/// The winged-edge form: each edge knows its two vertices, the faces on its two sides and the four
/// edges that follow and precede it round those faces. Faces of any degree. Vertices and faces know
/// one of their edges.
///
/// Implements [baumgart1975].
class WingedEdgeMesh {
public:
    /// Seen from `vertices[0]` to `vertices[1]` the face `faces[0]` is on the left, `faces[1]` on
    /// the right, -1 beyond the boundary. `next[k]` and `previous[k]` are the edges after and
    /// before this one counterclockwise round faces[k]; along the boundary where that is -1.
    struct Wings {
        std::array<std::int32_t, 2> vertices, faces, next, previous;
    };

    WingedEdgeMesh() = default;
    /// Throws InvalidInput if the mesh has dead elements.
    explicit WingedEdgeMesh(const HalfedgeMesh& mesh);
    /// Throws InvalidInput as HalfedgeMesh does.
    explicit WingedEdgeMesh(const PolygonMesh& mesh);

    std::size_t n_vertices() const { return points_.size(); }
    std::size_t n_edges() const { return edges_.size(); }
    std::size_t n_faces() const { return face_edge_.size(); }
    const Vec3& point(Vertex v) const { return points_[v.index]; }
    const Wings& wings(Edge e) const { return edges_[e.index]; }
    /// All of them, for bulk work.
    const std::vector<Vec3>& points() const { return points_; }
    const std::vector<Wings>& edges() const { return edges_; }
    const std::vector<std::int32_t>& vertex_edges() const { return vertex_edge_; }
    const std::vector<std::int32_t>& face_edges() const { return face_edge_; }
    /// None for an isolated vertex.
    Edge edge(Vertex v) const { return Edge(vertex_edge_[v.index]); }
    Edge edge(Face f) const { return Edge(face_edge_[f.index]); }

    /// Calls `visit(Edge, Vertex)` for each edge of f, counterclockwise, with the vertex at which
    /// it begins.
    template <class Visit>
    void visit_face(Face f, Visit&& visit) const
    {
        const Edge first = edge(f);
        Edge e = first;
        do {
            const Wings& w = wings(e);
            const int side = w.faces[0] == f.index ? 0 : 1;
            visit(e, Vertex(w.vertices[side]));
            e = Edge(w.next[side]);
        } while (e != first);
    }
    /// Calls `visit(Edge)` for each edge at v, clockwise.
    template <class Visit>
    void visit_vertex(Vertex v, Visit&& visit) const
    {
        const Edge first = edge(v);
        if (!first.valid()) return;
        Edge e = first;
        do {
            visit(e);
            // On the side where e comes in to v, the edge that follows leaves v.
            const Wings& w = wings(e);
            e = Edge(w.next[w.vertices[1] == v.index ? 0 : 1]);
        } while (e != first);
    }

    /// Bytes held, at so many bytes a coordinate.
    std::size_t memory_bytes(std::size_t bytes_per_coordinate = sizeof(double)) const;
    PolygonMesh to_polygons() const;

private:
    std::vector<Vec3> points_;
    std::vector<Wings> edges_;
    std::vector<std::int32_t> vertex_edge_, face_edge_;
};

}  // namespace genus
