#pragma once

#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "genus/mesh/handles.h"
#include "genus/mesh/indexed_mesh.h"
#include "genus/mesh/property.h"

namespace genus {

/// Walks along halfedges by a step of the mesh until it is back where it began:
///     for (Halfedge h : mesh.outgoing(v)) visit(mesh.to(h));
template <class Mesh, Halfedge (Mesh::*Step)(Halfedge) const>
class HalfedgeCirculation {
public:
    HalfedgeCirculation(const Mesh& mesh, Halfedge first) : mesh_(&mesh), first_(first) {}

    class Iterator {
    public:
        using value_type = Halfedge;
        using difference_type = std::ptrdiff_t;
        Iterator(const Mesh* mesh, Halfedge first, Halfedge at)
            : mesh_(mesh), first_(first), at_(at)
        {
        }
        Halfedge operator*() const { return at_; }
        Iterator& operator++()
        {
            at_ = (mesh_->*Step)(at_);
            if (at_ == first_) at_ = Halfedge();
            return *this;
        }
        bool operator==(const Iterator& o) const { return at_ == o.at_; }

    private:
        const Mesh* mesh_;
        Halfedge first_, at_;
    };
    Iterator begin() const { return {mesh_, first_, first_}; }
    Iterator end() const { return {mesh_, first_, Halfedge()}; }

private:
    const Mesh* mesh_;
    Halfedge first_;
};

/// The halfedge form, explicit layout: faces of any degree; each halfedge knows its opposite, the
/// vertex it leads to, its face, and the next one round that face. Along the boundary run
/// halfedges without a face. A surface with complex edges or vertices, or faces that disagree about
/// the outside, cannot be held.
///
/// Implements [botsch2010], section 2.3 (halfedge data structure).
class HalfedgeMesh {
public:
    HalfedgeMesh() = default;
    /// The halfedges of a face are numbered like its corners, boundary ones follow. O(V + F).
    /// Throws InvalidInput naming the first vertex number out of range, face with a vertex twice,
    /// complex edge, flipped edge or complex vertex.
    explicit HalfedgeMesh(const PolygonMesh& mesh);
    explicit HalfedgeMesh(const IndexedMesh& mesh);

    std::size_t n_vertices() const { return points_.size(); }
    std::size_t n_halfedges() const { return to_.size(); }
    std::size_t n_edges() const { return to_.size() / 2; }
    std::size_t n_faces() const { return face_halfedge_.size(); }

    Vec3& point(Vertex v) { return points_[v.index]; }
    const Vec3& point(Vertex v) const { return points_[v.index]; }

    /// One that leaves the vertex: that on the boundary if there is one, none if it is isolated.
    Halfedge halfedge(Vertex v) const { return Halfedge(vertex_halfedge_[v.index]); }
    Halfedge halfedge(Face f) const { return Halfedge(face_halfedge_[f.index]); }
    /// One that leads from a to b; none if they are not neighbours. O(valence).
    Halfedge find(Vertex a, Vertex b) const;

    Halfedge opposite(Halfedge h) const { return Halfedge(opposite_[h.index]); }
    Halfedge next(Halfedge h) const { return Halfedge(next_[h.index]); }
    /// O(degree) of the face, O(valence) on a boundary.
    Halfedge previous(Halfedge h) const;
    Vertex to(Halfedge h) const { return Vertex(to_[h.index]); }
    Vertex from(Halfedge h) const { return to(opposite(h)); }
    Face face(Halfedge h) const { return Face(face_[h.index]); }

    bool is_boundary(Halfedge h) const { return face_[h.index] < 0; }
    bool is_boundary(Vertex v) const { return !halfedge(v).valid() || is_boundary(halfedge(v)); }

    /// The halfedge that leaves the same vertex, one further clockwise.
    Halfedge turned(Halfedge h) const { return next(opposite(h)); }

    using RoundVertex = HalfedgeCirculation<HalfedgeMesh, &HalfedgeMesh::turned>;
    using RoundFace = HalfedgeCirculation<HalfedgeMesh, &HalfedgeMesh::next>;
    /// All that leave v.
    RoundVertex outgoing(Vertex v) const { return {*this, halfedge(v)}; }
    /// All round f, or along the boundary loop of h.
    RoundFace around(Face f) const { return {*this, halfedge(f)}; }
    RoundFace around(Halfedge h) const { return {*this, h}; }

    /// The number of edges at v; 0 if it is isolated.
    std::int32_t valence(Vertex v) const;
    std::int32_t degree(Face f) const;

    /// One halfedge of each boundary loop, in the order of their numbers.
    std::vector<Halfedge> boundary_loops() const;

    template <class T>
    Property<Vertex, T> add_vertex_property(const std::string& name, T value = {})
    {
        return vertex_properties_.add<T>(name, std::move(value));
    }
    template <class T>
    Property<Halfedge, T> add_halfedge_property(const std::string& name, T value = {})
    {
        return halfedge_properties_.add<T>(name, std::move(value));
    }
    template <class T>
    Property<Face, T> add_face_property(const std::string& name, T value = {})
    {
        return face_properties_.add<T>(name, std::move(value));
    }
    const PropertySet<Vertex>& vertex_properties() const { return vertex_properties_; }
    const PropertySet<Halfedge>& halfedge_properties() const { return halfedge_properties_; }
    const PropertySet<Face>& face_properties() const { return face_properties_; }

    /// Bytes held for points and connectivity, at so many bytes a coordinate.
    std::size_t memory_bytes(std::size_t bytes_per_coordinate = sizeof(double)) const;

    PolygonMesh to_polygons() const;

    /// Throws InvalidInput naming the first element whose links contradict each other.
    void check() const;

private:
    // False if the sides make no manifold.
    template <class Sides>
    bool build(const Sides& sides);
    template <class Sides>
    bool add_boundary(const Sides& sides);
    bool vertices_are_regular() const;

    std::vector<Vec3> points_;
    std::vector<std::int32_t> vertex_halfedge_;
    std::vector<std::int32_t> opposite_, next_, to_, face_;  // by halfedge
    std::vector<std::int32_t> face_halfedge_;
    PropertySet<Vertex> vertex_properties_;
    PropertySet<Halfedge> halfedge_properties_;
    PropertySet<Face> face_properties_;
};

/// The halfedge form for triangles, small and fast: halfedge 3 f + i runs along face f from its
/// corner i, so that next and face are arithmetic and only the opposite is stored ("directed
/// edges"). On the boundary there is no opposite.
///
/// Implements [campagna1998].
class TriangleHalfedgeMesh {
public:
    TriangleHalfedgeMesh() = default;
    /// Throws as HalfedgeMesh does. O(V + F); takes over the arrays of `mesh`.
    explicit TriangleHalfedgeMesh(IndexedMesh mesh);

    std::size_t n_vertices() const { return mesh_.vertices.size(); }
    std::size_t n_halfedges() const { return opposite_.size(); }
    std::size_t n_faces() const { return mesh_.faces.size(); }
    const IndexedMesh& indexed() const { return mesh_; }

    Vec3& point(Vertex v) { return mesh_.vertices[v.index]; }
    const Vec3& point(Vertex v) const { return mesh_.vertices[v.index]; }

    /// One that leaves v, such that those met by turning counterclockwise are all there are.
    Halfedge halfedge(Vertex v) const { return Halfedge(vertex_halfedge_[v.index]); }
    Halfedge halfedge(Face f) const { return Halfedge(3 * f.index); }
    /// None on the boundary.
    Halfedge opposite(Halfedge h) const { return Halfedge(opposite_[h.index]); }
    static Halfedge next(Halfedge h)
    {
        return Halfedge(h.index % 3 == 2 ? h.index - 2 : h.index + 1);
    }
    static Halfedge previous(Halfedge h)
    {
        return Halfedge(h.index % 3 == 0 ? h.index + 2 : h.index - 1);
    }
    static Face face(Halfedge h) { return Face(h.index / 3); }
    Vertex from(Halfedge h) const { return Vertex(corners()[h.index]); }
    Vertex to(Halfedge h) const { return from(next(h)); }
    bool is_boundary(Vertex v) const
    {
        return !halfedge(v).valid() || !opposite(halfedge(v)).valid();
    }

    /// Calls `visit(Vertex)` for each neighbour of v, counterclockwise.
    template <class Visit>
    void visit_ring(Vertex v, Visit&& visit) const
    {
        const Halfedge first = halfedge(v);
        if (!first.valid()) return;
        Halfedge h = first;
        do {
            visit(to(h));
            const Halfedge incoming = previous(h);
            h = opposite(incoming);
            if (!h.valid()) {
                visit(from(incoming));
                return;
            }
        } while (h != first);
    }

    std::size_t memory_bytes(std::size_t bytes_per_coordinate = sizeof(double)) const;

private:
    const std::int32_t* corners() const { return mesh_.faces.data()->data(); }

    IndexedMesh mesh_;
    std::vector<std::int32_t> opposite_;
    std::vector<std::int32_t> vertex_halfedge_;
};

}  // namespace genus
