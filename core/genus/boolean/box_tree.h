#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "genus/base/parallel.h"
#include "genus/base/vec.h"

namespace genus::exact {

/// Axis-parallel box in single precision, rounded outward.
struct FloatBox {
    std::array<float, 3> low{3e38f, 3e38f, 3e38f};
    std::array<float, 3> high{-3e38f, -3e38f, -3e38f};

    void add(const FloatBox& o)
    {
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], o.low[k]);
            high[k] = std::max(high[k], o.high[k]);
        }
    }
    bool overlaps(const FloatBox& o) const
    {
        return low[0] <= o.high[0] && o.low[0] <= high[0] && low[1] <= o.high[1] &&
               o.low[1] <= high[1] && low[2] <= o.high[2] && o.low[2] <= high[2];
    }
};

FloatBox box_of(const Vec3& a, const Vec3& b, const Vec3& c);

/// Tree of boxes over items in Morton order, four to a node. Every item has an owner; with
/// `pairs_within_owner` off, pairs of items of one owner are not wanted and whole branches of one
/// owner are passed over.
///
/// Implements the linear order of [lauterbach2009] with an implicit tree in place of a built one.
/// O(n log n) to build by radix sort; no allocation per node.
class BoxTree {
public:
    using Pair = std::pair<std::int32_t, std::int32_t>;

    BoxTree() = default;
    /// `owners` may be empty: then all items are of different owners.
    BoxTree(std::vector<FloatBox> boxes, std::vector<std::int32_t> owners);

    /// All pairs of wanted items whose boxes overlap and that `keep(a, b)` keeps. The order of
    /// the result does not depend on threads.
    template <class Keep>
    std::vector<Pair> pairs(bool pairs_within_owner, const Keep& keep) const;

    /// Calls visit(item) for all items whose box overlaps `box`.
    template <class Visit>
    void query(const FloatBox& box, const Visit& visit) const;

    /// The items in Morton order.
    const std::vector<std::int32_t>& order() const { return items_; }

private:
    struct Node {
        FloatBox box;
        std::int32_t owner;  // -1 if mixed
    };
    struct NodePair {
        std::int32_t level, a, b;
    };

    void descend(NodePair pair, bool within, std::vector<NodePair>& out) const;
    template <class Emit>
    void items_of(NodePair pair, bool within, const Emit& emit) const;
    bool unwanted(std::int32_t a, std::int32_t b, bool within) const
    {
        return !within && a >= 0 && a == b;
    }

    std::vector<std::int32_t> items_;        // in Morton order
    std::vector<std::vector<Node>> levels_;  // [0]: one per item, in that order
};

inline void BoxTree::descend(NodePair pair, bool within, std::vector<NodePair>& out) const
{
    const int below = pair.level - 1;
    const auto& nodes = levels_[below];
    const auto end = [&](std::int32_t n) {
        return std::min<std::int32_t>(4 * n + 4, static_cast<std::int32_t>(nodes.size()));
    };
    for (std::int32_t i = 4 * pair.a; i < end(pair.a); ++i)
        for (std::int32_t j = pair.a == pair.b ? i : 4 * pair.b; j < end(pair.b); ++j) {
            if (unwanted(nodes[i].owner, nodes[j].owner, within)) continue;
            if (i == j ? below > 0 : nodes[i].box.overlaps(nodes[j].box))
                out.push_back({below, i, j});
        }
}

template <class Emit>
void BoxTree::items_of(NodePair pair, bool within, const Emit& emit) const
{
    std::vector<NodePair> stack{pair};
    while (!stack.empty()) {
        const NodePair top = stack.back();
        stack.pop_back();
        if (top.level == 0)
            emit(items_[top.a], items_[top.b]);
        else
            descend(top, within, stack);
    }
}

template <class Keep>
std::vector<BoxTree::Pair> BoxTree::pairs(bool pairs_within_owner, const Keep& keep) const
{
    if (items_.size() < 2) return {};
    std::vector<NodePair> tasks{{static_cast<std::int32_t>(levels_.size()) - 1, 0, 0}};
    while (tasks.size() < 512 && !tasks.empty() && tasks.front().level > 0) {
        std::vector<NodePair> finer;
        for (const NodePair& task : tasks) descend(task, pairs_within_owner, finer);
        tasks = std::move(finer);
    }
    std::vector<std::vector<Pair>> found(tasks.size());
    parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t)
            items_of(tasks[t], pairs_within_owner, [&](std::int32_t a, std::int32_t b) {
                if (a > b) std::swap(a, b);
                if (keep(a, b)) found[t].push_back({a, b});
            });
    });
    std::vector<Pair> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    return all;
}

template <class Visit>
void BoxTree::query(const FloatBox& box, const Visit& visit) const
{
    if (items_.empty()) return;
    std::vector<std::pair<std::int32_t, std::int32_t>> stack;
    const auto top = static_cast<std::int32_t>(levels_.size()) - 1;
    stack.push_back({top, 0});
    while (!stack.empty()) {
        const auto [level, n] = stack.back();
        stack.pop_back();
        if (!levels_[level][n].box.overlaps(box)) continue;
        if (level == 0) {
            visit(items_[n]);
            continue;
        }
        const auto last =
            std::min<std::int32_t>(4 * n + 4, static_cast<std::int32_t>(levels_[level - 1].size()));
        for (std::int32_t child = last - 1; child >= 4 * n; --child)
            stack.push_back({level - 1, child});
    }
}

}  // namespace genus::exact
