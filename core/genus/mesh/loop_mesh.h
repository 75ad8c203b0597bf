#pragma once

#include <cstdint>
#include <vector>

#include "genus/mesh/handles.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// V - E + F - (L - F) = 2 (S - G): what a surface in pieces counts.
struct EulerCounts {
    std::int64_t vertices = 0, edges = 0, faces = 0, loops = 0, shells = 0;

    /// Handles, summed over shells.
    std::int64_t genus() const { return shells - (vertices - edges + faces - (loops - faces)) / 2; }
    bool operator==(const EulerCounts&) const = default;
};

/// Halfedges with loops: the form in which the make and kill operators work. A face is bounded by
/// an outer loop and any number of rings; a loop is a cycle of halfedges or, in a face that has
/// just begun, one lone vertex. Edges may dangle, join a vertex to itself, or have the same
/// face on both sides: all that solids pass through while they are built, and that HalfedgeMesh
/// forbids. Hence a form of its own: the other one stays small and fast, and its faces need no list
/// of loops. The opposite of halfedge h is h ^ 1.
///
/// Every operator keeps V - E + F - (L - F) = 2 (S - G), costs O(1) but for the renaming of a loop
/// or of the halfedges of a vertex, and throws InvalidInput where its condition fails, with
/// everything as it was. Numbers of killed elements are given out again. The form knows nothing
/// of shape but the points.
///
/// Implements [mantyla1988], chapters 9 and 11 (Euler operators on halfedges).
class LoopMesh {
public:
    /// A place in a loop: before a halfedge, or at the lone vertex of its loop.
    struct Corner {
        Corner(Halfedge h) : halfedge(h) {}  // NOLINT: both are meant to convert
        Corner(Vertex lone) : vertex(lone) {}
        Halfedge halfedge;
        Vertex vertex;
    };

    /// Make vertex, face, shell: a new shell of one vertex. Returns the vertex.
    Vertex mvfs(const Vec3& point);
    /// Kills such a shell.
    void kvfs(Vertex v);

    /// Make edge, vertex: a new vertex at the end of an edge that dangles at the corner. Returns
    /// the halfedge that leads to it.
    Halfedge mev(Corner corner, const Vec3& point);
    /// Splits the vertex from which a and b leave: the halfedges met by turning clockwise from a up
    /// to but not including b go to the new vertex. Returns the halfedge that leads to it.
    Halfedge mev(Halfedge a, Halfedge b, const Vec3& point);
    /// Kill edge, vertex: draws the end of h into its start. The ends must differ.
    void kev(Halfedge h);

    /// Make edge, face: joins two corners of one loop by an edge. The returned halfedge leads from
    /// a to b and keeps the face with its rings; its opposite bounds the new face.
    Halfedge mef(Corner a, Corner b);
    /// Kill edge, face: the face across h, without rings, becomes part of that of h.
    void kef(Halfedge h);

    /// Kill edge, make ring: h and its opposite are of one loop, which falls apart; the part at the
    /// end of h becomes a ring of its own. Returns it.
    Loop kemr(Halfedge h);
    /// Make edge, kill ring: joins corners of two loops of one face; the loop of b goes. Returns
    /// the halfedge from a to b.
    Halfedge mekr(Corner a, Corner b);

    /// Kill face, make ring and hole: g, a face without rings, ends, its loop becomes a ring of f.
    /// Within one shell that adds a handle, else two shells become one.
    void kfmrh(Face f, Face g);
    /// Make face, kill ring and hole: a ring becomes the outer loop of a new face.
    Face mfkrh(Loop ring);

    std::size_t n_vertices() const { return points_.size() - free_vertices_.size(); }
    std::size_t n_edges() const { return next_.size() / 2 - free_edges_.size(); }
    std::size_t n_faces() const { return face_loop_.size() - free_faces_.size(); }
    std::size_t n_loops() const { return loops_.size() - free_loops_.size(); }
    /// With shells found by following edges and rings, O(n).
    EulerCounts counts() const;
    /// The same for each shell, in the order of their smallest vertex.
    std::vector<EulerCounts> shells() const;

    std::size_t vertex_slots() const { return points_.size(); }
    std::size_t halfedge_slots() const { return next_.size(); }
    std::size_t face_slots() const { return face_loop_.size(); }
    std::size_t loop_slots() const { return loops_.size(); }
    bool is_alive(Vertex v) const
    {
        return in(v, points_.size()) && vertex_link_[v.index] != kDead;
    }
    bool is_alive(Halfedge h) const { return in(h, next_.size()) && next_[h.index] != kDead; }
    bool is_alive(Face f) const { return in(f, face_loop_.size()) && face_loop_[f.index] != kDead; }
    bool is_alive(Loop l) const { return in(l, loops_.size()) && loops_[l.index].face != kDead; }

    const Vec3& point(Vertex v) const { return points_[v.index]; }
    Vec3& point(Vertex v) { return points_[v.index]; }
    static Halfedge opposite(Halfedge h) { return Halfedge(h.index ^ 1); }
    Halfedge next(Halfedge h) const { return Halfedge(next_[h.index]); }
    Halfedge previous(Halfedge h) const { return Halfedge(previous_[h.index]); }
    Vertex from(Halfedge h) const { return Vertex(from_[h.index]); }
    Vertex to(Halfedge h) const { return from(opposite(h)); }
    Loop loop(Halfedge h) const { return Loop(loop_[h.index]); }
    Face face(Halfedge h) const { return face(loop(h)); }
    Face face(Loop l) const { return Face(loops_[l.index].face); }
    bool is_lone(Vertex v) const { return vertex_link_[v.index] < -2; }
    /// One that leaves v; none if it is lone.
    Halfedge halfedge(Vertex v) const;
    /// The loop of a lone vertex.
    Loop loop(Vertex lone) const { return Loop(-3 - vertex_link_[lone.index]); }
    /// One of the loop; none if it is a lone vertex, which is then `vertex(l)`.
    Halfedge halfedge(Loop l) const { return Halfedge(loops_[l.index].halfedge); }
    Vertex vertex(Loop l) const { return Vertex(loops_[l.index].vertex); }
    Loop outer(Face f) const { return Loop(face_loop_[f.index]); }
    /// All loops of f, the outer one first, then rings by age.
    std::vector<Loop> loops(Face f) const;

    /// Faces with one loop as they are; faces with rings in triangles, cut in their own plane.
    /// Throws InvalidInput naming a loop of fewer than three corners or a face that cannot be
    /// cut: rings that cross or lie outside.
    PolygonMesh to_polygons() const;

    /// Throws InvalidInput naming the first element whose links contradict each other.
    void check() const;

private:
    static constexpr std::int32_t kDead = -2;

    struct LoopEntry {
        std::int32_t face = kDead;
        std::int32_t halfedge = -1;
        std::int32_t vertex = -1;  // where halfedge is -1
        std::int32_t next = -1;    // loop of the same face
    };

    template <class H>
    static bool in(H h, std::size_t n)
    {
        return h.index >= 0 && static_cast<std::size_t>(h.index) < n;
    }
    void demand_alive(Halfedge h, const char* operation) const;
    void demand_alive(Corner c, const char* operation) const;
    Vertex vertex(Corner c) const { return c.halfedge.valid() ? from(c.halfedge) : c.vertex; }
    Loop loop(Corner c) const { return c.halfedge.valid() ? loop(c.halfedge) : loop(c.vertex); }

    Vertex add_vertex(const Vec3& point);
    Halfedge add_edge(Vertex from, Vertex to);
    Loop add_loop(Face f);
    Face add_face();
    void kill(Vertex v);
    void kill_edge(Halfedge h);
    void kill_loop(Loop l);
    void kill(Face f);
    void make_lone(Vertex v, Loop l);
    void link(Halfedge h, Halfedge next);
    void insert_before(Halfedge h, Halfedge fresh);
    void take_out(Halfedge h);
    void leave(Halfedge h);
    void name_loop(Halfedge first, Loop l);
    void append_loop(Face f, Loop l);
    void unlink_loop(Loop l);
    std::vector<std::int32_t> shell_of_face() const;

    std::vector<Vec3> points_;
    std::vector<std::int32_t> vertex_link_;  // a halfedge that leaves, or -3 - loop of a lone one
    std::vector<std::int32_t> from_, next_, previous_, loop_;  // by halfedge
    std::vector<LoopEntry> loops_;
    std::vector<std::int32_t> face_loop_;  // the outer one
    std::vector<std::int32_t> free_vertices_, free_edges_, free_loops_, free_faces_;
};

}  // namespace genus
