#include "genus/boolean/arrangement.h"

#include <atomic>

#include "genus/boolean/cut_faces.h"
#include "genus/boolean/incidence.h"

namespace genus::exact {

Candidates find_candidates(const Soup& soup, std::vector<std::int32_t> owners, std::size_t most)
{
    Candidates candidates;
    candidates.tree = PlateTree(soup, std::move(owners));
    const Plates& plates = candidates.tree.plates();
    const auto corners = [&](std::int32_t f) { return plates.corners(soup, f); };
    std::vector<std::vector<BoxTree::Pair>> found;
    std::atomic<std::size_t> count{0};
    candidates.tree.visit_pairs([&](std::size_t parts) { found.resize(parts); },
                                [&](std::int32_t f, std::int32_t g, std::size_t part) {
                                    if (count.load(std::memory_order_relaxed) > most) return;
                                    // Corners that are one in their operand may be common. Those
                                    // of two operands at one place are contacts.
                                    if (certainly_apart(corners(f), corners(g))) return;
                                    found[part].push_back({f, g});
                                    if (soup.operand[f] != soup.operand[g])
                                        count.fetch_add(1, std::memory_order_relaxed);
                                });
    candidates.complete = count.load() <= most;
    if (!candidates.complete) return candidates;
    for (const auto& part : found)
        candidates.pairs.insert(candidates.pairs.end(), part.begin(), part.end());
    return candidates;
}

Arrangement arrange(const Soup& soup, Candidates candidates, std::vector<char> buried)
{
    Arrangement out;
    out.tree = std::move(candidates.tree);
    out.buried = std::move(buried);
    if (!out.buried.empty())
        std::erase_if(candidates.pairs, [&](const auto& pair) {
            return out.buried[pair.first] != 0 || out.buried[pair.second] != 0;
        });
    PointTable table(out);
    const Incidence incidence = find_incidence(soup, std::move(candidates.pairs), out, table);
    cut_faces(soup, incidence, out, table);
    return out;
}

}  // namespace genus::exact
