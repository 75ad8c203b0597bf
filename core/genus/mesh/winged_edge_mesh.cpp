#include "genus/mesh/winged_edge_mesh.h"

#include "genus/base/error.h"
#include "genus/mesh/halfedge_mesh.h"

namespace genus {

WingedEdgeMesh::WingedEdgeMesh(const PolygonMesh& mesh) : WingedEdgeMesh(HalfedgeMesh(mesh)) {}

// Edges are numbered by the first of their two halfedges.
WingedEdgeMesh::WingedEdgeMesh(const HalfedgeMesh& mesh)
{
    require(mesh.vertex_slots() == mesh.n_vertices() && mesh.face_slots() == mesh.n_faces() &&
                mesh.halfedge_slots() == mesh.n_halfedges(),
            "WingedEdgeMesh: the halfedge mesh has dead elements, compact it first");
    std::vector<std::int32_t> edge_of(mesh.n_halfedges());
    std::int32_t n = 0;
    for (std::size_t i = 0; i < edge_of.size(); ++i) {
        const Halfedge h(i), o = mesh.opposite(h);
        edge_of[i] = o < h ? edge_of[o.index] : n++;
    }
    edges_.resize(n);
    for (std::size_t i = 0; i < edge_of.size(); ++i) {
        const Halfedge h(i);
        const int side = mesh.opposite(h) < h;
        Wings& w = edges_[edge_of[i]];
        w.vertices[side] = mesh.from(h).index;
        w.faces[side] = mesh.face(h).index;
        w.next[side] = edge_of[mesh.next(h).index];
        const Halfedge next = mesh.next(h);
        edges_[edge_of[next.index]].previous[mesh.opposite(next) < next] = edge_of[i];
    }
    for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
        points_.push_back(mesh.point(Vertex(v)));
        const Halfedge h = mesh.halfedge(Vertex(v));
        vertex_edge_.push_back(h.valid() ? edge_of[h.index] : -1);
    }
    for (std::size_t f = 0; f < mesh.n_faces(); ++f)
        face_edge_.push_back(edge_of[mesh.halfedge(Face(f)).index]);
}

std::size_t WingedEdgeMesh::memory_bytes(std::size_t bytes_per_coordinate) const
{
    return 3 * bytes_per_coordinate * n_vertices() + sizeof(Wings) * edges_.size() +
           sizeof(std::int32_t) * (vertex_edge_.size() + face_edge_.size());
}

PolygonMesh WingedEdgeMesh::to_polygons() const
{
    PolygonMesh mesh;
    mesh.vertices = points_;
    std::vector<std::int32_t> corners;
    for (std::size_t f = 0; f < n_faces(); ++f) {
        corners.clear();
        visit_face(Face(f), [&](Edge, Vertex v) { corners.push_back(v.index); });
        mesh.add_face(corners);
    }
    return mesh;
}

}  // namespace genus
