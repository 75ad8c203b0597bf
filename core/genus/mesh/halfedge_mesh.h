#pragma once

#include <cstdint>
#include <initializer_list>
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
    /// Empty if `first` is none.
    HalfedgeCirculation(const Mesh& mesh, Halfedge first)
        : mesh_(&mesh), first_(first.valid() ? first : Halfedge())
    {
    }

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

    std::size_t n_vertices() const { return points_.size() - dead_vertices_; }
    std::size_t n_halfedges() const { return to_.size() - 2 * dead_edges_; }
    std::size_t n_edges() const { return to_.size() / 2 - dead_edges_; }
    std::size_t n_faces() const { return face_halfedge_.size() - dead_faces_; }

    /// Numbers run up to these. Operators that remove elements leave dead numbers behind until
    /// `compact` is called; before any of them all numbers are alive.
    std::size_t vertex_slots() const { return points_.size(); }
    std::size_t halfedge_slots() const { return to_.size(); }
    std::size_t face_slots() const { return face_halfedge_.size(); }
    bool is_alive(Vertex v) const { return vertex_halfedge_[v.index] != kDead; }
    bool is_alive(Halfedge h) const { return to_[h.index] != kDead; }
    bool is_alive(Face f) const { return face_halfedge_[f.index] != kDead; }

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

    // Euler operators; see euler_operators.cpp. Each keeps V - E + F, the boundary loops and the
    // genus, leaves no vertex twice in a face and no two edges between the same vertices, and
    // throws InvalidInput where it could not, with the mesh as it was. New elements get new numbers
    // at the end; properties of new elements have their default values.

    /// Joins a new vertex to all corners of f: a face of degree d becomes d triangles, of which one
    /// keeps its number. O(d).
    Vertex split_face(Face f, const Vec3& point);
    /// Cuts a face by a new edge from the start of a to the start of b ("mef"). The new halfedge
    /// from a's start is returned; the part on its right gets a new number. O(degree + valence).
    Halfedge split_face(Halfedge a, Halfedge b);
    bool can_split_face(Halfedge a, Halfedge b) const;
    /// Removes the edge between two faces; that of h stays ("kef"). O(degree).
    void join_faces(Halfedge h);
    bool can_join_faces(Halfedge h) const;
    /// Puts a new vertex on the edge of h, which then leads to it; triangles beside are cut in two.
    /// O(valence).
    Vertex split_edge(Halfedge h, const Vec3& point);
    /// Turns the edge between two triangles to join their other corners. O(valence).
    void flip_edge(Halfedge h);
    bool can_flip_edge(Halfedge h) const;
    /// Draws the start of h into its end; triangles beside vanish. Allowed by the link condition:
    /// the ends have no common neighbours but the third corners of those triangles. O(valence).
    void collapse_edge(Halfedge h);
    bool can_collapse_edge(Halfedge h) const;
    /// The same where it is allowed, else false.
    bool try_collapse_edge(Halfedge h);

    /// Gives the elements that are alive the numbers 0, 1, 2, ... in their order.
    void compact();

    /// The arrays behind the handles, for bulk work: by vertex slot, by halfedge slot, by face
    /// slot. Dead entries are -2, "none" is -1.
    struct Arrays {
        const std::vector<Vec3>& points;
        const std::vector<std::int32_t>& vertex_halfedge;
        const std::vector<std::int32_t>&opposite, &next, &to, &face;
        const std::vector<std::int32_t>& face_halfedge;
    };
    Arrays arrays() const
    {
        return {points_, vertex_halfedge_, opposite_, next_, to_, face_, face_halfedge_};
    }

    /// Bytes held for points and connectivity, at so many bytes a coordinate.
    std::size_t memory_bytes(std::size_t bytes_per_coordinate = sizeof(double)) const;

    /// The vertices and faces that are alive, in their order.
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

    static constexpr std::int32_t kDead = -2;

    Vertex add_vertex(const Vec3& point);
    Halfedge add_edge(Vertex from, Vertex to);
    Face add_face();
    void link(Halfedge h, Halfedge next) { next_[h.index] = next.index; }
    void set_loop(std::initializer_list<Halfedge> loop, Face f);
    void set_face(Halfedge h, Face f) { face_[h.index] = f.index; }
    void remove_edge(Halfedge h);
    void remove_face(Face f);
    void close_digon(Halfedge h);
    bool has_edges(Vertex v, int n) const;
    bool is_triangle(Halfedge h) const { return !is_boundary(h) && next(next(next(h))) == h; }

    std::vector<Vec3> points_;
    std::vector<std::int32_t> vertex_halfedge_;
    std::vector<std::int32_t> opposite_, next_, to_, face_;  // by halfedge
    std::vector<std::int32_t> face_halfedge_;
    std::size_t dead_vertices_ = 0, dead_edges_ = 0, dead_faces_ = 0;
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
    /// By halfedge, and by vertex; -1 is none.
    const std::vector<std::int32_t>& opposites() const { return opposite_; }
    const std::vector<std::int32_t>& vertex_halfedges() const { return vertex_halfedge_; }

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
