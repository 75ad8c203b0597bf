#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/boolean/arrangement.h"
#include "genus/boolean/lists.h"
#include "genus/boolean/point_table.h"
#include "genus/mesh/disjoint_sets.h"

namespace genus::exact {

/// What the faces of a soup have to be cut by.
struct Incidence {
    struct Segment {
        std::int32_t other;  // the flat that makes it
        std::int32_t from;
        std::int32_t to;
        auto operator<=>(const Segment&) const = default;
    };

    /// Of each halfedge: its number among the edges that something touches, or -1. Halfedges
    /// between the same two points have one number.
    std::vector<std::int32_t> edge_of;
    /// Of each such edge: the points inside it, in order from its lower end to its higher one.
    Lists<std::int32_t> on_edge;
    /// Of each face: points inside it.
    Lists<std::int32_t> in_face;
    /// Of each flat: segments that cut it.
    Lists<Segment> segments;
    /// Pairs of faces of one plane that overlap.
    std::vector<std::pair<std::int32_t, std::int32_t>> coplanar;

    /// Faces of one plane joined across edges that are left out; the first one stands for all.
    DisjointSets flats{0};
    /// Of each halfedge: it parts two faces of one flat.
    std::vector<char> left_out;
};

/// Finds where the pairs of faces meet, and gives the points there numbers: `out` gets its points,
/// `first_equal`, the numbers of contacts, and `passive` says which faces need no cut. Faces that
/// `out` has as buried take no part.
///
/// Edges between faces of one operand and one plane, diagonals mostly, are left out where
/// something crosses them, and points that only such an edge would make are none.
Incidence find_incidence(const Soup& soup, std::vector<BoxTree::Pair> pairs, Arrangement& out,
                         PointTable& table);

}  // namespace genus::exact
