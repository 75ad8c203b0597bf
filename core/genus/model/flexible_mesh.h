#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/model/cell_mesh.h"

namespace genus {

/// A closed manifold surface mesh under change: edges are split, flipped and collapsed in
/// O(valence).
///
/// Side 3f + i of face f runs from its corner i to the next; `twin` is the side across. Removed
/// faces stay as holes in the numbering until `release`.
///
/// Implements [botsch2010], section 2.3 (directed edges); the link condition for collapses as in
/// [dey1999].
class FlexibleMesh {
public:
    /// The mesh must be closed, oriented and manifold (see separate_fans).
    explicit FlexibleMesh(SurfaceMesh&& mesh);
    /// The mesh without holes in its numbering.
    SurfaceMesh release();

    std::int32_t n_sides() const { return static_cast<std::int32_t>(from_.size()); }
    bool alive(std::int32_t s) const { return from_[s] >= 0; }
    std::int32_t from(std::int32_t s) const { return from_[s]; }
    std::int32_t to(std::int32_t s) const { return from_[next(s)]; }
    std::int32_t apex(std::int32_t s) const { return from_[previous(s)]; }
    std::int32_t twin(std::int32_t s) const { return twin_[s]; }
    static std::int32_t next(std::int32_t s) { return s % 3 == 2 ? s - 2 : s + 1; }
    static std::int32_t previous(std::int32_t s) { return s % 3 == 0 ? s + 2 : s - 1; }
    std::int32_t label(std::int32_t s) const { return label_[s / 3]; }
    bool is_crease(std::int32_t s) const { return label(s) != label(twin_[s]); }

    std::size_t n_vertices() const { return points_.size(); }
    bool exists(std::int32_t v) const { return out_[v] >= 0; }
    const Vec3& point(std::int32_t v) const { return points_[v]; }
    void move(std::int32_t v, const Vec3& p) { points_[v] = p; }
    double cell_size(std::int32_t v) const { return size_[v]; }
    const std::array<std::int32_t, 3>& surfaces(std::int32_t v) const { return surfaces_[v]; }
    /// Whether the mesh touches itself at a vertex, see SurfaceMesh::touch_of_vertex.
    bool touches(std::int32_t v) const
    {
        return !touch_.empty() && touch_[static_cast<std::size_t>(v)] >= 0;
    }
    /// The side itself, and one of each other edge at the same place.
    std::vector<std::int32_t> coincident(std::int32_t s) const;
    /// The side from one vertex to another, -1 if no edge joins them.
    std::int32_t side(std::int32_t from, std::int32_t to) const;
    /// Creases that end at a vertex: 0 inside a face, 2 on a curve, else a corner.
    int n_creases(std::int32_t v) const;

    /// Calls `visit(side)` for the sides from `v`.
    template <class Visit>
    void visit_ring(std::int32_t v, Visit&& visit) const
    {
        const std::int32_t first = out_[v];
        std::int32_t s = first;
        do {
            visit(s);
            s = twin_[previous(s)];
        } while (s != first);
    }

    /// Puts a vertex on the edge of side s. Returns the vertex; sides keep their origins.
    std::int32_t split(std::int32_t s, const Vec3& p, const std::array<std::int32_t, 3>& surfaces);
    /// Turns the edge of side s to join the two apexes. False, and no change, if these are joined
    /// already.
    bool flip(std::int32_t s);
    /// True if removing the origin of s, its faces handed to the end of s, keeps the surface what
    /// it is.
    bool can_collapse(std::int32_t s) const;
    void collapse(std::int32_t s);
    /// True if these coincident edges are all that end at the place of their origins, and nothing
    /// round one of them is changed by removing the origin of another.
    bool can_collapse_together(const std::vector<std::int32_t>& edges) const;
    /// New vertices at one point; a single one touches nothing.
    void note_touch(const std::vector<std::int32_t>& vertices);

private:
    void join(std::int32_t s, std::int32_t t)
    {
        twin_[s] = t;
        twin_[t] = s;
    }
    std::int32_t add_face(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t label);

    std::vector<Vec3> points_;
    std::vector<double> size_;
    std::vector<std::array<std::int32_t, 3>> surfaces_;
    std::vector<std::int32_t> out_;  // a side from each vertex, -1 where it is gone
    std::vector<std::int32_t> from_, twin_, label_;
    std::vector<std::int32_t> touch_;                // of each vertex; empty if nothing touches
    std::vector<std::vector<std::int32_t>> places_;  // the vertices that were at each, some gone
};

}  // namespace genus
