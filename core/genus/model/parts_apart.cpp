#include "genus/model/parts_apart.h"

#include <algorithm>
#include <cstdint>

#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/disjoint_sets.h"
#include "genus/model/boolean_road.h"

namespace genus {

namespace {

// The number of the cluster of each box, counted in the order of first boxes.
std::vector<std::int32_t> clusters(const std::vector<Box3>& boxes)
{
    DisjointSets sets(boxes.size());
    using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;
    const auto note = [](std::int32_t i, std::int32_t j, Pairs& found) {
        found.emplace_back(i, j);
        return true;
    };
    for (const Pairs& found : BoxTree(boxes).visit_self_pairs<Pairs>(note))
        for (const auto& [i, j] : found) sets.unite(i, j);
    std::vector<std::int32_t> number(boxes.size(), -1);
    std::int32_t count = 0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        std::int32_t& first = number[sets.find(static_cast<std::int32_t>(i))];
        if (first < 0) first = count++;
        number[i] = first;
    }
    return number;
}

// What counts of the parts is inside of `box`; each may be unbounded.
std::vector<Solid> apart_of_union(const std::vector<Solid>& all, const Box3& box, double margin)
{
    std::vector<Solid> parts;
    std::vector<Box3> boxes;
    for (const Solid& part : all) {
        const Box3 inside = intersection(part.bounds(), box);
        if (inside.empty()) continue;
        parts.push_back(part);
        boxes.push_back(inside.inflated(0.5 * margin));
    }
    std::vector<std::vector<Solid>> groups;
    const std::vector<std::int32_t> number = clusters(boxes);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (static_cast<std::size_t>(number[i]) == groups.size()) groups.emplace_back();
        groups[number[i]].push_back(parts[i]);
    }
    std::vector<Solid> apart;
    for (const std::vector<Solid>& group : groups)
        apart.push_back(group.size() == 1 ? group[0] : unite(group));
    return apart;
}

// Of an intersection with one union among its parts: the union's, each intersected with the rest.
std::vector<Solid> apart_of_intersection(const std::vector<Solid>& all, const Box3& box,
                                         double margin)
{
    const auto is_union = [](const Solid& part) {
        return std::holds_alternative<Union>(part.node().shape);
    };
    if (std::count_if(all.begin(), all.end(), is_union) != 1) return {};
    std::vector<Solid> rest = all;
    const auto at = std::find_if(rest.begin(), rest.end(), is_union);
    const Solid united = *at;
    rest.erase(at);
    std::vector<Solid> apart;
    for (const Solid& part :
         apart_of_union(std::get<Union>(united.node().shape).parts, box, margin)) {
        std::vector<Solid> factors = rest;
        factors.insert(factors.begin(), part);
        apart.push_back(intersect(std::move(factors)));
    }
    return apart;
}

}  // namespace

std::vector<Solid> parts_apart(const Solid& solid, double margin)
{
    std::vector<Solid> found, apart, polyhedral;
    if (const auto* shape = std::get_if<Union>(&solid.node().shape))
        found = apart_of_union(shape->parts, solid.bounds(), margin);
    else if (const auto* common = std::get_if<Intersection>(&solid.node().shape))
        found = apart_of_intersection(common->parts, solid.bounds(), margin);
    if (found.size() < 2) return {solid};
    for (const Solid& one : found) (is_polyhedral(one) ? polyhedral : apart).push_back(one);
    if (!polyhedral.empty())
        apart.push_back(polyhedral.size() == 1 ? polyhedral[0] : unite(polyhedral));
    return apart;
}

}  // namespace genus
