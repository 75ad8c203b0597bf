#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/mesh/halfedge_mesh.h"

namespace genus {

// Asks for memory that will be read soon. GCC takes a function that does nothing else for one
// without effect and drops calls of it, unless it is always inlined.
#ifdef __GNUC__
#define GENUS_PREFETCHING [[gnu::always_inline]] inline
GENUS_PREFETCHING void prefetch(const void* address)
{
    __builtin_prefetch(address);
}
#else
#define GENUS_PREFETCHING inline
inline void prefetch(const void*) {}
#endif

/// Triangles whose edges can be drawn together, and nothing else: what simplification walks about
/// in. Side 3 f + i runs along face f from its corner i to the next; corner and opposite side lie
/// side by side in memory, those of a face together: a step to a neighbour is one access.
///
/// Implements [campagna1998]; the link condition as in [botsch2010], section 7.2.
class CollapseMesh {
public:
    using Side = std::int32_t;
    static constexpr Side kNone = -1;

    explicit CollapseMesh(const TriangleHalfedgeMesh& mesh);

    std::size_t n_faces() const { return n_faces_; }
    /// Numbers run up to these; those of faces that are gone stay unused.
    std::size_t n_sides() const { return corners_.size(); }
    std::size_t n_vertices() const { return leaving_.size(); }
    bool is_alive(Side s) const { return corners_[s].vertex >= 0; }

    static Side next(Side s) { return s % 3 == 2 ? s - 2 : s + 1; }
    static Side previous(Side s) { return s % 3 == 0 ? s + 2 : s - 1; }
    std::int32_t from(Side s) const { return corners_[s].vertex; }
    std::int32_t to(Side s) const { return from(next(s)); }
    /// kNone on the boundary.
    Side opposite(Side s) const { return corners_[s].opposite; }
    /// kNone if no face has the vertex as a corner.
    Side leaving(std::int32_t v) const { return leaving_[v]; }

    GENUS_PREFETCHING void prefetch_side(Side s) const { prefetch(&corners_[s]); }

    /// Calls `visit(side)` for the side that leaves v in each face round it, counterclockwise from
    /// the boundary, if there is one.
    template <class Visit>
    void visit_leaving(std::int32_t v, Visit&& visit) const
    {
        const Side first = leaving_[v];
        for (Side s = first; s != kNone;) {
            visit(s);
            s = opposite(previous(s));
            if (s == first) return;
        }
    }

    /// Draws the start of s into its end; the triangles beside vanish. False, and nothing changed,
    /// if the ends have common neighbours besides the third corners of those triangles, if a
    /// part would be left with less than a tetrahedron or a triangle, or if two boundaries would
    /// meet. O(valence).
    bool collapse(Side s);

private:
    struct Corner {
        std::int32_t vertex;  // -1: the face is gone
        Side opposite;        // of the side from here to the next corner
    };

    bool is_boundary(std::int32_t v) const { return opposite(leaving_[v]) == kNone; }
    void gather_ring(std::int32_t v, std::vector<std::int32_t>& ring) const;
    bool can_collapse(Side s);
    void join(Side s, Side t);
    void close(Side s);
    void start_at(Side s);

    std::vector<Corner> corners_;
    /// By vertex, one side that leaves it: that without an opposite if there is one.
    std::vector<Side> leaving_;
    std::size_t n_faces_;
    std::vector<std::int32_t> ring_a_, ring_b_;  // kept for their memory
    std::vector<Side> moved_;
};

}  // namespace genus
