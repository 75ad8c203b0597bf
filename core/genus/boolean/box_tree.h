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

/// Tree of boxes over items in Morton order, four to a node. Every item has an owner: pairs
/// of items of one owner are not wanted, and whole branches of one owner are passed over. Owner -1
/// wants pairs with all others.
///
/// Implements the linear order of [lauterbach2009] with an implicit tree in place of a built one.
/// O(n log n) to build by radix sort; no allocation per node. Four boxes are compared at a time.
class BoxTree {
public:
    using Pair = std::pair<std::int32_t, std::int32_t>;

    BoxTree() = default;
    /// `owners` may be empty: then all pairs are wanted.
    BoxTree(std::vector<FloatBox> boxes, std::vector<std::int32_t> owners);

    /// Calls visit(a, b, part), a < b, for all pairs of wanted items whose boxes overlap. Each part
    /// is visited by one thread, and parts and their pairs do not depend on threads: what is
    /// collected by part and joined in the order of parts is always the same. `prepare(n)` is
    /// called first with the number of parts.
    template <class Prepare, class Visit>
    void visit_pairs(const Prepare& prepare, const Visit& visit) const;

    /// Calls visit(item) for all items whose box overlaps `box`.
    template <class Visit>
    void query(const FloatBox& box, const Visit& visit) const;

    /// The items in Morton order.
    const std::vector<std::int32_t>& order() const { return items_; }

private:
    // GCC and Clang: four at a time on any machine.
    using Four = float __attribute__((vector_size(16)));
    using FourBits = std::int32_t __attribute__((vector_size(16)));

    // Nodes 4n to 4n + 3 of a level. Places beyond the last node are empty boxes.
    struct Quad {
        std::array<Four, 3> low;
        std::array<Four, 3> high;
        std::array<std::int32_t, 4> owner;  // -1 if mixed

        // Bit i: box i overlaps box j of `o`.
        unsigned overlapping(const Quad& o, int j) const
        {
            FourBits m = (low[0] <= o.high[0][j]) & (high[0] >= o.low[0][j]);
            for (int k = 1; k < 3; ++k) m &= (low[k] <= o.high[k][j]) & (high[k] >= o.low[k][j]);
            return bits(m);
        }
        unsigned overlapping(const FloatBox& b) const
        {
            FourBits m = (low[0] <= b.high[0]) & (high[0] >= b.low[0]);
            for (int k = 1; k < 3; ++k) m &= (low[k] <= b.high[k]) & (high[k] >= b.low[k]);
            return bits(m);
        }
        static unsigned bits(FourBits m)
        {
            return static_cast<unsigned>((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8));
        }
    };
    struct NodePair {
        std::int32_t level, a, b;
    };

    struct Level {
        std::vector<FloatBox> boxes;
        std::vector<std::int32_t> owners;
    };
    template <class BoxAt, class OwnerAt>
    Level add_level(std::size_t n, const BoxAt& box_at, const OwnerAt& owner_at);
    template <class Emit>
    void descend(NodePair pair, const Emit& emit) const;

    std::vector<std::int32_t> items_;        // in Morton order
    std::vector<std::vector<Quad>> levels_;  // [0]: the items, in that order
};

// Calls emit(level, i, j) for the pairs of children that overlap and are wanted.
template <class Emit>
void BoxTree::descend(NodePair pair, const Emit& emit) const
{
    const int below = pair.level - 1;
    const Quad& a = levels_[below][pair.a];
    const Quad& b = levels_[below][pair.b];
    for (int i = 0; i < 4; ++i) {
        unsigned hits = b.overlapping(a, i);
        if (pair.a == pair.b) {
            // A node with itself, if it is no item; then with those that follow.
            const bool is_node = below > 0 && a.low[0][i] <= a.high[0][i];
            hits &= (0xeu << i) | (is_node ? 1u << i : 0u);
        }
        for (int j = 0; hits != 0; ++j, hits >>= 1)
            if ((hits & 1u) != 0 && (a.owner[i] < 0 || a.owner[i] != b.owner[j]))
                emit(NodePair{below, 4 * pair.a + i, 4 * pair.b + j});
    }
}

template <class Prepare, class Visit>
void BoxTree::visit_pairs(const Prepare& prepare, const Visit& visit) const
{
    std::vector<NodePair> tasks;
    if (items_.size() > 1) tasks.push_back({static_cast<std::int32_t>(levels_.size()), 0, 0});
    while (tasks.size() < 512 && !tasks.empty() && tasks.front().level > 1) {
        std::vector<NodePair> finer;
        for (const NodePair& task : tasks)
            descend(task, [&](const NodePair& pair) { finer.push_back(pair); });
        tasks = std::move(finer);
    }
    prepare(tasks.size());
    parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
        std::vector<NodePair> stack;
        for (std::size_t t = begin; t < end; ++t) {
            const auto leave = [&](const NodePair& pair) {
                if (pair.level > 0) {
                    stack.push_back(pair);
                    return;
                }
                const auto [a, b] = std::minmax(items_[pair.a], items_[pair.b]);
                visit(a, b, t);
            };
            leave(tasks[t]);
            while (!stack.empty()) {
                const NodePair top = stack.back();
                stack.pop_back();
                descend(top, leave);
            }
        }
    });
}

template <class Visit>
void BoxTree::query(const FloatBox& box, const Visit& visit) const
{
    if (items_.empty()) return;
    // At most three more nodes wait on each of up to 16 levels.
    std::array<std::pair<std::int32_t, std::int32_t>, 64> stack;
    std::size_t n_waiting = 0;
    stack[n_waiting++] = {static_cast<std::int32_t>(levels_.size()) - 1, 0};
    while (n_waiting > 0) {
        const auto [level, quad] = stack[--n_waiting];
        const unsigned hits = levels_[level][quad].overlapping(box);
        for (int i = level > 0 ? 3 : 0; level > 0 ? i >= 0 : i<4; level> 0 ? --i : ++i) {
            if ((hits >> i & 1u) == 0) continue;
            if (level == 0)
                visit(items_[4 * quad + i]);
            else
                stack[n_waiting++] = {level - 1, 4 * quad + i};
        }
    }
}

}  // namespace genus::exact
