#pragma once

#include "genus/base/parallel.h"
#include "genus/boolean/box_tree.h"

namespace genus::exact {

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
