#include "genus/boolean/arrangement.h"

#include <atomic>

#include "genus/base/parallel.h"
#include "genus/boolean/charts.h"
#include "genus/boolean/cut_faces.h"
#include "genus/boolean/incidence.h"

namespace genus::exact {

Candidates find_candidates(const Soup& soup, std::size_t most)
{
    const std::size_t n = soup.faces.size();
    std::vector<FloatBox> boxes(n);
    parallel_for(n, 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const auto& t = soup.faces[f];
            boxes[f] = box_of(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]);
        }
    });
    Candidates candidates;
    candidates.tree = BoxTree(std::move(boxes), find_owners(soup));
    std::vector<std::vector<BoxTree::Pair>> found;
    std::atomic<std::size_t> count{0};
    candidates.tree.visit_pairs([&](std::size_t parts) { found.resize(parts); },
                                [&](std::int32_t f, std::int32_t g, std::size_t part) {
                                    if (count.load(std::memory_order_relaxed) > most) return;
                                    // Corners that are one in their operand may be common. Those
                                    // of two operands at one place are contacts.
                                    if (certainly_apart(corners_of(soup, f), corners_of(soup, g)))
                                        return;
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
