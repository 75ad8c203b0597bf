#pragma once

#include <cstdint>
#include <vector>

namespace genus {

/// The edges that a sweep line crosses, from bottom to top: a treap whose nodes are also linked
/// to their neighbours. The caller knows where an edge goes and says so; only `last_below`
/// compares. Expected O(log n) a call, O(1) for neighbours.
///
/// Implements [seidel1996] (treaps); priorities are a hash of the node number, so the shape
/// is the same in every run.
class SweepStatus {
public:
    static constexpr std::int32_t kNone = -1;

    /// Links of the unfinished chain above an edge; see sweep.cpp.
    struct Chain {
        std::int32_t bottom = kNone, top = kNone, rightmost = kNone;
    };
    struct Edge {
        std::int32_t left = 0, right = 0;  // vertices
        std::int32_t winding_above = 0;
        Chain chain;
    };

    Edge& operator[](std::int32_t node) { return nodes_[node].edge; }
    const Edge& operator[](std::int32_t node) const { return nodes_[node].edge; }

    std::int32_t below(std::int32_t node) const { return nodes_[node].below; }
    std::int32_t above(std::int32_t node) const { return nodes_[node].above; }
    /// The edge above `node`, or the lowest of all if that is kNone.
    std::int32_t first_above(std::int32_t node) const
    {
        return node == kNone ? lowest_ : nodes_[node].above;
    }

    /// The topmost edge for which `side(edge)` is positive, where all such lie below all others.
    template <class Side>
    std::int32_t last_below(Side&& side) const
    {
        std::int32_t found = kNone, at = root_;
        while (at != kNone) {
            if (side(at) > 0) {
                found = at;
                at = nodes_[at].child[1];
            } else {
                at = nodes_[at].child[0];
            }
        }
        return found;
    }

    /// A new edge just above `node`, or below all if that is kNone.
    std::int32_t insert_after(std::int32_t node)
    {
        const std::int32_t fresh = take_node();
        const std::int32_t next = first_above(node);
        Node& n = nodes_[fresh];
        n.below = node;
        n.above = next;
        if (node != kNone)
            nodes_[node].above = fresh;
        else
            lowest_ = fresh;
        if (next != kNone) nodes_[next].below = fresh;
        if (root_ == kNone)
            root_ = fresh;
        else if (node != kNone && nodes_[node].child[1] == kNone)
            hang(fresh, node, 1);
        else
            hang(fresh, next, 0);  // next has no lower child: node would be in it
        while (n.parent != kNone && nodes_[n.parent].priority < n.priority) rotate_up(fresh);
        return fresh;
    }

    void erase(std::int32_t node)
    {
        Node& n = nodes_[node];
        while (n.child[0] != kNone && n.child[1] != kNone) {
            const bool right = nodes_[n.child[0]].priority < nodes_[n.child[1]].priority;
            rotate_up(n.child[right]);
        }
        replace(node, n.child[0] != kNone ? n.child[0] : n.child[1]);
        if (n.below != kNone)
            nodes_[n.below].above = n.above;
        else
            lowest_ = n.above;
        if (n.above != kNone) nodes_[n.above].below = n.below;
        n.above = free_;
        free_ = node;
    }

private:
    struct Node {
        Edge edge;
        std::int32_t child[2] = {kNone, kNone};
        std::int32_t parent = kNone;
        std::int32_t below = kNone, above = kNone;
        std::uint32_t priority = 0;
    };

    std::int32_t take_node()
    {
        std::int32_t node = free_;
        if (node != kNone) {
            free_ = nodes_[node].above;
        } else {
            node = static_cast<std::int32_t>(nodes_.size());
            nodes_.emplace_back();
        }
        Node fresh;
        std::uint32_t hash = static_cast<std::uint32_t>(++n_taken_) * 0x9e3779b9u;
        hash = (hash ^ hash >> 16) * 0x85ebca6bu;
        fresh.priority = (hash ^ hash >> 13) * 0xc2b2ae35u;
        nodes_[node] = fresh;
        return node;
    }

    void hang(std::int32_t node, std::int32_t parent, int side)
    {
        nodes_[parent].child[side] = node;
        nodes_[node].parent = parent;
    }

    // Puts `other` (or nothing) where `node` hangs.
    void replace(std::int32_t node, std::int32_t other)
    {
        const std::int32_t parent = nodes_[node].parent;
        if (parent == kNone)
            root_ = other;
        else
            nodes_[parent].child[nodes_[parent].child[1] == node] = other;
        if (other != kNone) nodes_[other].parent = parent;
    }

    void rotate_up(std::int32_t node)
    {
        const std::int32_t parent = nodes_[node].parent;
        const int side = nodes_[parent].child[1] == node;
        const std::int32_t inner = nodes_[node].child[1 - side];
        replace(parent, node);
        nodes_[parent].child[side] = inner;
        if (inner != kNone) nodes_[inner].parent = parent;
        hang(parent, node, 1 - side);
    }

    std::vector<Node> nodes_;
    std::int32_t root_ = kNone;
    std::int32_t lowest_ = kNone;
    std::int32_t free_ = kNone;
    std::uint32_t n_taken_ = 0;
};

}  // namespace genus
