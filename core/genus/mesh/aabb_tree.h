#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// A binary tree of boxes over numbered boxes ("items"), in one flat array. It answers which items
/// overlap a box or each other, which is nearest to a point, which a ray meets. The tree depends
/// on the boxes alone, not on the number of threads.
///
/// Implements [lauterbach2009], section 4 (hierarchy from Morton codes), with 63-bit codes.
class BoxTree {
public:
    BoxTree() = default;
    /// O(n) for the sort, O(n log n) worst case for the splits. Throws InvalidInput if a box is
    /// empty or not bounded.
    explicit BoxTree(std::span<const Box3> boxes);

    std::size_t n_items() const { return items_.size(); }
    /// Box round all items, empty without any.
    Box3 bounds() const { return nodes_.empty() ? Box3{} : nodes_[0].box; }

    /// Calls `visit(item)` for each item whose box overlaps `box`, in an order of the tree's own.
    template <class Visit>
    void visit_overlapping(const Box3& box, Visit&& visit) const
    {
        visit_nodes([&](const Box3& other) { return overlap(box, other); }, visit);
    }
    /// The same as a list, ascending.
    std::vector<std::int32_t> overlapping(const Box3& box) const;

    /// Calls `visit(item)` for each item whose box the ray origin + t direction, t in
    /// [0, t_max], meets; conservative by a few units in the last place.
    template <class Visit>
    void visit_along(const Vec3& origin, const Vec3& direction, double t_max, Visit&& visit) const
    {
        visit_nodes(RayTest(origin, direction, t_max), visit);
    }

    struct Nearest {
        std::int32_t item = -1;
        double distance2 = std::numeric_limits<double>::infinity();
    };
    /// The item for which `distance2(item)`, a squared distance to `p` and not less than that of
    /// its box, is least and below `limit2`; item -1 if there is none.
    template <class Distance2>
    Nearest nearest(const Vec3& p, Distance2&& distance2,
                    double limit2 = std::numeric_limits<double>::infinity()) const;

    /// Calls `visit(i, j, out)` once for each pair of items i < j whose boxes overlap, in parallel.
    /// Each of many tasks has an `Out` of its own; they come back in an order that does not
    /// depend on the threads. A task ends where `visit` returns false.
    template <class Out, class Visit>
    std::vector<Out> visit_self_pairs(Visit&& visit) const;
    /// The same for pairs (i of this tree, j of the other).
    template <class Out, class Visit>
    std::vector<Out> visit_pairs(const BoxTree& other, Visit&& visit) const;

private:
    // In preorder: the left child of node i is i + 1. A leaf holds the items
    // items_[link] .. items_[link + count - 1]; an inner node has count 0 and its right child
    // at `link`.
    struct Node {
        Box3 box;
        std::int32_t link;
        std::int32_t count;
    };

    // Every split on the way down uses up one of 63 code bits or halves a run of equal codes.
    static constexpr int kMaxDepth = 63 + 32;
    static constexpr std::int32_t kLeafItems = 4;

    class RayTest {
    public:
        RayTest(const Vec3& origin, const Vec3& direction, double t_max);
        bool operator()(const Box3& box) const;

    private:
        Vec3 origin_, inverse_;
        double t_max_;
    };

    class Builder;

    template <class Test, class Visit>
    void visit_nodes(Test&& test, Visit&& visit) const;

    using Pair = std::array<std::int32_t, 2>;
    static std::vector<Pair> first_pairs(const BoxTree& a, const BoxTree& b, bool self);
    static void expand(const BoxTree& a, const BoxTree& b, bool self, Pair pair,
                       std::vector<Pair>& out);
    template <class Visit>
    static bool walk_pairs(const BoxTree& a, const BoxTree& b, bool self, Pair pair, Visit& visit);
    template <class Visit>
    static bool visit_leaf_pair(const BoxTree& a, const BoxTree& b, bool same, Pair pair,
                                Visit& visit);

    std::vector<Node> nodes_;
    std::vector<std::int32_t> items_;
    std::vector<Box3> boxes_;  // of items_, in that order
};

/// Boxes of all faces. Throws InvalidInput for a vertex number out of range or a coordinate that
/// is not finite.
std::vector<Box3> face_boxes(const IndexedMesh& mesh);

struct ClosestPoint {
    std::int32_t face = -1;
    Vec3 point;
    double distance = std::numeric_limits<double>::infinity();
};

struct RayHit {
    double t = 0.0;  // in units of the direction
    std::int32_t face = -1;
    bool leaves = false;  // the ray goes out through the face, seen from its outer side
    Vec3 weights;         // barycentric, of the face's corners
};

/// The closest point of a triangle to p. A triangle without area counts as its sides.
///
/// Implements [ericson2005], section 5.1.5.
Vec3 closest_point(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Calls `visit(face, around, side)` for each face that the ray from p along the first axis passes
/// through, or would pass through backwards: `around` is the direction in which the face goes round
/// the ray (1: the ray leaves through it), `side` is 1 if p is behind the face, -1 before it, 0 in
/// its plane. The face lies ahead of p if the two are equal. Exact, and no ray goes through an
/// edge: it passes by on the same side for all faces there.
template <class Visit>
void visit_faces_ahead(const IndexedMesh& mesh, const BoxTree& tree, const Vec3& p, Visit&& visit);

namespace detail {
std::array<int, 2> face_ahead(const IndexedMesh& mesh, std::int32_t face, const Vec3& p);
}

/// A box tree over the faces of a mesh that stays alive and unchanged meanwhile.
class MeshTree {
public:
    /// Throws InvalidInput for a vertex number out of range or a coordinate that is not finite.
    explicit MeshTree(const IndexedMesh& mesh);

    const IndexedMesh& mesh() const { return *mesh_; }
    const BoxTree& boxes() const { return tree_; }

    /// Face and point nearest to p; face -1 if there is none closer than `limit`.
    ClosestPoint nearest(const Vec3& p,
                         double limit = std::numeric_limits<double>::infinity()) const;

    /// All hits of the ray origin + t direction, t >= 0, by ascending t. A ray through an edge or
    /// vertex hits one of the faces there, or none where it only grazes: on a closed mesh entries
    /// and exits match. Throws InvalidInput if the direction is zero or anything is not finite.
    ///
    /// Implements [woop2013], with exact edge signs.
    std::vector<RayHit> ray_hits(const Vec3& origin, const Vec3& direction) const;

    /// How often the closed oriented mesh winds round p: 1 inside, 0 outside. Exact. No value if
    /// p is seen to lie on a face.
    std::optional<int> winding_number(const Vec3& p) const;

private:
    const IndexedMesh* mesh_;
    BoxTree tree_;
};

// ---------------------------------------------------------------------------------------------

template <class Test, class Visit>
void BoxTree::visit_nodes(Test&& test, Visit&& visit) const
{
    if (nodes_.empty()) return;
    std::array<std::int32_t, kMaxDepth + 2> stack;
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const std::int32_t at = stack[--top];
        const Node& node = nodes_[at];
        if (!test(node.box)) continue;
        if (node.count == 0) {
            stack[top++] = node.link;
            stack[top++] = at + 1;
            continue;
        }
        for (std::int32_t i = node.link; i < node.link + node.count; ++i)
            if (test(boxes_[i])) visit(items_[i]);
    }
}

template <class Visit>
void visit_faces_ahead(const IndexedMesh& mesh, const BoxTree& tree, const Vec3& p, Visit&& visit)
{
    Box3 ahead;
    ahead.add(p);
    ahead.max[0] = std::numeric_limits<double>::infinity();
    tree.visit_overlapping(ahead, [&](std::int32_t f) {
        const auto [around, side] = detail::face_ahead(mesh, f, p);
        if (around != 0) visit(f, around, side);
    });
}

namespace detail {

inline double distance2(const Box3& box, const Vec3& p)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double d = std::max(std::max(box.min[i] - p[i], p[i] - box.max[i]), 0.0);
        sum += d * d;
    }
    return sum;
}

}  // namespace detail

template <class Distance2>
BoxTree::Nearest BoxTree::nearest(const Vec3& p, Distance2&& distance2, double limit2) const
{
    struct Entry {
        std::int32_t node;
        double distance2;
    };
    Nearest best{-1, limit2};
    if (nodes_.empty()) return best;
    std::array<Entry, kMaxDepth + 2> stack;
    std::size_t top = 0;
    stack[top++] = {0, detail::distance2(nodes_[0].box, p)};
    while (top > 0) {
        const Entry entry = stack[--top];
        if (entry.distance2 >= best.distance2) continue;
        const Node& node = nodes_[entry.node];
        if (node.count == 0) {
            Entry near{entry.node + 1, detail::distance2(nodes_[entry.node + 1].box, p)};
            Entry far{node.link, detail::distance2(nodes_[node.link].box, p)};
            if (far.distance2 < near.distance2) std::swap(near, far);
            if (far.distance2 < best.distance2) stack[top++] = far;
            if (near.distance2 < best.distance2) stack[top++] = near;
            continue;
        }
        for (std::int32_t i = node.link; i < node.link + node.count; ++i) {
            if (detail::distance2(boxes_[i], p) >= best.distance2) continue;
            const double d = distance2(items_[i]);
            if (d < best.distance2) best = {items_[i], d};
        }
    }
    return best;
}

template <class Visit>
bool BoxTree::visit_leaf_pair(const BoxTree& a, const BoxTree& b, bool same, Pair pair,
                              Visit& visit)
{
    const Node& m = a.nodes_[pair[0]];
    const Node& n = b.nodes_[pair[1]];
    for (std::int32_t i = m.link; i < m.link + m.count; ++i)
        for (std::int32_t j = same ? i + 1 : n.link; j < n.link + n.count; ++j)
            if (overlap(a.boxes_[i], b.boxes_[j]) && !visit(a.items_[i], b.items_[j])) return false;
    return true;
}

template <class Visit>
bool BoxTree::walk_pairs(const BoxTree& a, const BoxTree& b, bool self, Pair pair, Visit& visit)
{
    const Node& m = a.nodes_[pair[0]];
    const Node& n = b.nodes_[pair[1]];
    const bool same = self && pair[0] == pair[1];
    if (!same && !overlap(m.box, n.box)) return true;
    if (m.count > 0 && n.count > 0) {
        current_progress().check();
        return visit_leaf_pair(a, b, same, pair, visit);
    }
    const auto walk = [&](std::int32_t i, std::int32_t j) {
        return walk_pairs(a, b, self, {i, j}, visit);
    };
    const auto [i, j] = pair;
    if (same) return walk(i + 1, i + 1) && walk(m.link, m.link) && walk(i + 1, m.link);
    const bool open_first = n.count > 0 || (m.count == 0 && dot(m.box.size(), m.box.size()) >=
                                                                dot(n.box.size(), n.box.size()));
    return open_first ? walk(i + 1, j) && walk(m.link, j) : walk(i, j + 1) && walk(i, n.link);
}

template <class Out, class Visit>
std::vector<Out> BoxTree::visit_self_pairs(Visit&& visit) const
{
    const std::vector<Pair> tasks = first_pairs(*this, *this, true);
    std::vector<Out> out(tasks.size());
    parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t) {
        auto in_order = [&](std::int32_t i, std::int32_t j) {
            return visit(std::min(i, j), std::max(i, j), out[begin]);
        };
        walk_pairs(*this, *this, true, tasks[begin], in_order);
    });
    return out;
}

template <class Out, class Visit>
std::vector<Out> BoxTree::visit_pairs(const BoxTree& other, Visit&& visit) const
{
    const std::vector<Pair> tasks = first_pairs(*this, other, false);
    std::vector<Out> out(tasks.size());
    parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t) {
        auto with_out = [&](std::int32_t i, std::int32_t j) { return visit(i, j, out[begin]); };
        walk_pairs(*this, other, false, tasks[begin], with_out);
    });
    return out;
}

}  // namespace genus
