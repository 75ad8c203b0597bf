#include "genus/model/plan.h"

#include <algorithm>
#include <memory>
#include <unordered_map>

#include "genus/base/progress.h"
#include "genus/model/plan_proofs.h"

namespace genus {
namespace {

constexpr std::int64_t kMany = std::int64_t{1} << 62;
// Parts that a part is compared with, the largest first.
constexpr std::size_t kMostNeighbours = 16;

/// No interior: what is confined to such a box has no volume.
bool is_flat(const Box3& box)
{
    for (int i = 0; i < 3; ++i)
        if (!(box.min[i] < box.max[i])) return true;
    return false;
}

/// Leaves below each node, each node looked at once, parts before wholes.
class LeafCounter {
public:
    std::int64_t operator()(const Node& root)
    {
        std::vector<const Node*> open{&root};
        while (!open.empty()) {
            const Node* node = open.back();
            if (counts_.count(node)) {
                open.pop_back();
                continue;
            }
            bool ready = true;
            std::int64_t sum = parts_of(*node).empty() ? 1 : 0;
            for (const Solid& part : parts_of(*node)) {
                const auto found = counts_.find(&part.node());
                if (found == counts_.end()) {
                    ready = false;
                    open.push_back(&part.node());
                } else {
                    sum = std::min(kMany, sum + found->second);
                }
            }
            if (!ready) continue;
            counts_.emplace(node, sum);
            open.pop_back();
        }
        return counts_.at(&root);
    }

private:
    std::unordered_map<const Node*, std::int64_t> counts_;
};

/// A planned part and how many leaves of the original it stands for.
struct Planned {
    Solid solid;
    std::int64_t leaves = 0;
};

/// A part of an operator before planning: where it stands in the tree, and what lies above it.
struct Part {
    const Solid* solid;
    Transform map;
    std::optional<Vec4> color;
};

enum class Operator { Union, Intersection, Difference, Other };

Operator operator_of(const Node& node)
{
    if (std::holds_alternative<Union>(node.shape)) return Operator::Union;
    if (std::holds_alternative<Intersection>(node.shape)) return Operator::Intersection;
    if (std::holds_alternative<Difference>(node.shape)) return Operator::Difference;
    return Operator::Other;
}

struct Frame {
    const Node* node;
    Operator op;
    Box3 context;  // nothing outside matters
    std::vector<Part> parts;
    std::vector<Box3> rest;  // of an intersection: the boxes of parts i, i + 1, ... in common
    std::size_t next = 0;
    std::vector<Planned> done;
};

class Planner {
public:
    explicit Planner(const PlanOptions& options) : options_(options) {}

    Plan run(const Solid& solid)
    {
        expand_ = counter_(solid.node()) <= options_.most_leaves;
        Planned result;
        if (auto at_once = open({&solid, {}, {}}, options_.region)) result = std::move(*at_once);
        while (!stack_.empty()) {
            if (++steps_ % 256 == 0) current_progress().check();
            Frame& top = stack_.back();
            if (top.next < top.parts.size()) {
                const Box3 context = context_of_next(top);
                const Part part = top.parts[top.next++];
                // The frame may move when another is opened.
                if (auto at_once = open(part, context))
                    stack_.back().done.push_back(std::move(*at_once));
                continue;
            }
            Frame frame = std::move(stack_.back());
            stack_.pop_back();
            Planned done = finish(frame);
            if (!expand_) kept_.emplace(frame.node, done);
            if (stack_.empty()) {
                result = std::move(done);
            } else {
                stack_.back().done.push_back(std::move(done));
            }
        }
        explanation_.add("transforms folded into leaves",
                         std::max<std::int64_t>(0, maps_passed_ - maps_left_), "nodes");
        return {std::move(result.solid), std::move(explanation_)};
    }

private:
    void dropped(const char* why, std::int64_t leaves) { explanation_.add(why, leaves, "leaves"); }

    /// The box in which the next part of an operator can matter. Parts planned already count with
    /// the boxes they have now: they may have grown outside their own context, and so may this
    /// one, but never in the same place, since that lies in the context of the later of the two.
    Box3 context_of_next(const Frame& frame) const
    {
        if (!expand_) return Box3::everything();
        Box3 context = frame.context;
        if (frame.op == Operator::Difference && frame.next > 0)
            return intersection(context, frame.done[0].solid.bounds());
        if (frame.op != Operator::Intersection) return context;
        if (frame.next + 1 < frame.rest.size())
            context = intersection(context, frame.rest[frame.next + 1]);
        for (const Planned& part : frame.done) context = intersection(context, part.solid.bounds());
        return context;
    }

    /// Steps down over transforms and colours.
    Part settled(Part part)
    {
        for (;;) {
            if (const auto* moved = std::get_if<Transformed>(&part.solid->node().shape)) {
                part.map = part.map * moved->map;
                part.solid = &moved->part;
                ++maps_passed_;
            } else if (const auto* colored = std::get_if<Colored>(&part.solid->node().shape)) {
                if (!part.color) part.color = colored->rgba;  // the outermost colour counts
                part.solid = &colored->part;
            } else {
                return part;
            }
        }
    }

    /// The operands of an operator, those of nested operators of its kind in their place:
    /// (A - B) - C is A - B - C, and A - (B + C) likewise. Iterative, hence the lists.
    std::vector<Part> flat_parts(const Part& whole)
    {
        const Operator op = operator_of(whole.solid->node());
        const Operator nested = op == Operator::Difference ? Operator::Union : op;
        std::vector<Part> open{whole}, flat;
        Part first = whole;
        if (op == Operator::Difference) {
            // Down the first operands; what is subtracted further in comes first.
            open.clear();
            while (operator_of(first.solid->node()) == Operator::Difference) {
                const auto parts = parts_of(first.solid->node());
                for (std::size_t i = parts.size(); i-- > 1;)
                    open.push_back(settled({&parts[i], first.map, first.color}));
                if (first.solid != whole.solid)
                    explanation_.add("nested operators flattened", 1, "nodes");
                first = settled({&parts[0], first.map, first.color});
            }
            flat.push_back(first);
        }
        while (!open.empty()) {
            const Part part = open.back();
            open.pop_back();
            if (operator_of(part.solid->node()) != nested) {
                flat.push_back(part);
                continue;
            }
            if (part.solid != whole.solid)
                explanation_.add("nested operators flattened", 1, "nodes");
            const auto parts = parts_of(part.solid->node());
            for (std::size_t i = parts.size(); i-- > 0;)
                open.push_back(settled({&parts[i], part.map, part.color}));
        }
        return flat;
    }

    /// Starts on a part: the answer if there is one at once, else a frame is put on the stack.
    std::optional<Planned> open(const Part& given, const Box3& context)
    {
        const Part part = expand_ ? settled(given) : given;
        const Node& node = part.solid->node();
        if (!expand_) {
            const auto known = kept_.find(&node);
            if (known != kept_.end()) return known->second;
        }
        if (std::holds_alternative<Empty>(node.shape)) return Planned{};
        if (parts_of(node).empty()) return leaf(*part.solid, part.map, part.color, context);
        if (expand_ && is_flat(intersection(context, image_bounds(*part.solid, part.map)))) {
            dropped("part outside the reach of the operators above", counter_(node));
            return Planned{};
        }
        Frame frame{&node, operator_of(node), context, {}, {}, 0, {}};
        if (expand_) {
            frame.parts = flat_parts(part);
        } else {
            for (const Solid& below : parts_of(node)) frame.parts.push_back({&below, {}, {}});
        }
        if (expand_ && frame.op == Operator::Intersection) frame.rest = boxes_from(frame.parts);
        stack_.push_back(std::move(frame));
        return std::nullopt;
    }

    static std::vector<Box3> boxes_from(const std::vector<Part>& parts)
    {
        std::vector<Box3> rest(parts.size());
        Box3 common = Box3::everything();
        for (std::size_t i = parts.size(); i-- > 0;) {
            common = intersection(common, image_bounds(*parts[i].solid, parts[i].map));
            rest[i] = common;
        }
        return rest;
    }

    Planned leaf(const Solid& shape, const Transform& map, const std::optional<Vec4>& color,
                 const Box3& context)
    {
        Solid solid = map.is_identity() ? shape : transformed(shape, map);
        if (is_flat(intersection(context, solid.bounds()))) {
            dropped("part outside the reach of the operators above", 1);
            return {};
        }
        maps_left_ += !map.is_identity();
        if (color) solid = colored(solid, *color);
        return {shared(solid), 1};
    }

    Planned finish(Frame& frame)
    {
        switch (frame.op) {
            case Operator::Union:
                return finish_union(frame);
            case Operator::Intersection:
                return finish_intersection(frame);
            case Operator::Difference:
                return finish_difference(frame);
            case Operator::Other:
                break;
        }
        const Planned& part = frame.done[0];
        if (const auto* moved = std::get_if<Transformed>(&frame.node->shape))
            return {shared(transformed(part.solid, moved->map)), part.leaves};
        return {shared(colored(part.solid, std::get<Colored>(frame.node->shape).rgba)),
                part.leaves};
    }

    Planned finish_union(Frame& frame)
    {
        std::vector<Planned> parts = flattened<Union>(std::move(frame.done));
        drop_equal(parts, "united part given twice");
        drop_contained(parts, frame.context, "united part inside another");
        return assemble(parts, unite);
    }

    Planned finish_intersection(Frame& frame)
    {
        const bool any_empty = std::any_of(frame.done.begin(), frame.done.end(),
                                           [](const Planned& p) { return p.solid.is_empty(); });
        if (any_empty) return emptied(frame.done, "intersected with nothing");
        std::vector<Planned> parts = flattened<Intersection>(std::move(frame.done));
        drop_equal(parts, "intersected part given twice");
        Box3 common = frame.context;
        for (const Planned& part : parts) common = intersection(common, part.solid.bounds());
        std::vector<FieldProof> proofs;
        for (std::size_t i = 0; i < parts.size() && i < kMostNeighbours; ++i)
            proofs.emplace_back(parts[i].solid, parts[i].leaves);
        if (is_flat(common) || FieldProof::disjoint(proofs, common))
            return emptied(parts, "intersected parts do not meet");
        drop_holders(parts, proofs, frame.context);
        return assemble(parts, intersect);
    }

    /// Drops, one after the other, parts that hold all of the box that the others have in common.
    void drop_holders(std::vector<Planned>& parts, std::vector<FieldProof>& proofs,
                      const Box3& context)
    {
        std::vector<char> gone(parts.size(), 0);
        for (std::size_t i = 0; i < proofs.size(); ++i) {
            Box3 box = context;
            for (std::size_t j = 0; j < parts.size(); ++j)
                if (j != i && !gone[j]) box = intersection(box, parts[j].solid.bounds());
            const bool alone = std::count(gone.begin(), gone.end(), 0) == 1;
            gone[i] = !alone && box.bounded() && proofs[i].fills(box);
        }
        keep_others(parts, gone, "intersected part holds the rest");
    }

    void keep_others(std::vector<Planned>& parts, const std::vector<char>& gone, const char* why)
    {
        std::vector<Planned> kept;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            if (gone[i]) {
                dropped(why, parts[i].leaves);
            } else {
                kept.push_back(std::move(parts[i]));
            }
        }
        parts = std::move(kept);
    }

    Planned finish_difference(Frame& frame)
    {
        if (frame.done[0].solid.is_empty()) return emptied(frame.done, "subtracted from nothing");
        std::vector<Planned> tools = flattened_difference(std::move(frame.done));
        const Planned body = tools[0];
        tools.erase(tools.begin());
        drop_equal(tools, "subtracted part given twice");
        const Box3 reach = intersection(frame.context, body.solid.bounds());
        std::vector<FieldProof> pair;  // the body, then a tool
        pair.emplace_back(body.solid, body.leaves);
        std::vector<char> gone(tools.size(), 0);
        for (std::size_t i = 0; i < tools.size(); ++i) {
            if (i % 64 == 0) current_progress().check();
            const Box3 meet = intersection(reach, tools[i].solid.bounds());
            gone[i] = is_flat(meet);
            if (gone[i]) continue;
            pair.resize(1, pair[0]);
            pair.emplace_back(tools[i].solid, tools[i].leaves);
            gone[i] = FieldProof::disjoint(pair, meet);
            const bool swallowed = tools[i].solid == body.solid ||
                                   (reach.bounded() && tools[i].solid.bounds().contains(reach) &&
                                    FieldProof::inside(pair[0], pair[1], reach));
            if (swallowed) {
                tools.push_back(body);
                return emptied(tools, "subtracted away whole");
            }
        }
        keep_others(tools, gone, "subtracted part misses the solid");
        drop_contained(tools, reach, "subtracted part inside another");
        tools.insert(tools.begin(), body);
        return assemble(tools, subtract);
    }

    Planned emptied(const std::vector<Planned>& parts, const char* why)
    {
        std::int64_t leaves = 0;
        for (const Planned& part : parts) leaves += part.leaves;
        dropped(why, leaves);
        return {};
    }

    /// The parts with those of nested operators of the same kind in their place: planning may
    /// have laid such bare. Empty parts go.
    template <class Kind>
    std::vector<Planned> flattened(std::vector<Planned> parts)
    {
        std::vector<Planned> flat;
        for (Planned& part : parts) {
            if (part.solid.is_empty()) continue;
            const auto* inner = std::get_if<Kind>(&part.solid.node().shape);
            if (!inner) {
                flat.push_back(std::move(part));
                continue;
            }
            explanation_.add("nested operators flattened", 1, "nodes");
            for (const Solid& solid : inner->parts) flat.push_back({solid, counter_(solid.node())});
        }
        return flat;
    }

    /// (A - B) - C is A - B - C, and so is A - (B + C).
    std::vector<Planned> flattened_difference(std::vector<Planned> parts)
    {
        std::vector<Planned> flat;
        const Planned body = parts[0];
        if (const auto* inner = std::get_if<Difference>(&body.solid.node().shape)) {
            explanation_.add("nested operators flattened", 1, "nodes");
            for (const Solid& solid : inner->parts) flat.push_back({solid, counter_(solid.node())});
        } else {
            flat.push_back(body);
        }
        parts.erase(parts.begin());
        for (Planned& part : flattened<Union>(std::move(parts))) flat.push_back(std::move(part));
        return flat;
    }

    void drop_equal(std::vector<Planned>& parts, const char* why)
    {
        std::unordered_map<std::uint64_t, std::vector<Solid>> seen;
        std::vector<Planned> kept;
        for (Planned& part : parts) {
            auto& same_hash = seen[part.solid.hash()];
            if (std::find(same_hash.begin(), same_hash.end(), part.solid) != same_hash.end()) {
                dropped(why, part.leaves);
                continue;
            }
            same_hash.push_back(part.solid);
            kept.push_back(std::move(part));
        }
        parts = std::move(kept);
    }

    /// Drops parts proven to lie, as far as they matter, inside one of the largest others.
    void drop_contained(std::vector<Planned>& parts, const Box3& context, const char* why)
    {
        if (parts.size() < 2) return;
        std::vector<std::size_t> by_size(parts.size());
        for (std::size_t i = 0; i < parts.size(); ++i) by_size[i] = i;
        const auto volume = [&](std::size_t i) {
            const Vec3 size = parts[i].solid.bounds().size();
            return size[0] * size[1] * size[2];
        };
        std::stable_sort(by_size.begin(), by_size.end(),
                         [&](std::size_t i, std::size_t j) { return volume(i) > volume(j); });
        std::vector<std::size_t> large(by_size.begin(),
                                       by_size.begin() + std::min(parts.size(), kMostNeighbours));
        std::vector<FieldProof> proofs;
        for (std::size_t i : large) proofs.emplace_back(parts[i].solid, parts[i].leaves);
        std::vector<char> gone(parts.size(), 0);
        for (std::size_t i = parts.size(); i-- > 0;) {
            const Box3 box = intersection(context, parts[i].solid.bounds());
            std::unique_ptr<FieldProof> own;
            for (std::size_t k = 0; k < large.size() && !gone[i]; ++k) {
                if (large[k] == i || gone[large[k]]) continue;
                if (!parts[large[k]].solid.bounds().contains(box) || !box.bounded()) continue;
                if (!own) own = std::make_unique<FieldProof>(parts[i].solid, parts[i].leaves);
                gone[i] = FieldProof::inside(*own, proofs[k], box);
            }
        }
        keep_others(parts, gone, why);
    }

    Planned assemble(const std::vector<Planned>& parts, Solid (*op)(std::vector<Solid>))
    {
        std::vector<Solid> solids;
        std::int64_t leaves = 0;
        for (const Planned& part : parts) {
            solids.push_back(part.solid);
            leaves += part.leaves;
        }
        if (solids.size() == 1) return parts[0];
        return {shared(op(std::move(solids))), leaves};
    }

    /// The node that stands for all equal trees.
    Solid shared(const Solid& solid)
    {
        if (solid.is_empty()) return solid;
        auto& same_hash = known_[solid.hash()];
        for (const Solid& other : same_hash)
            if (other == solid) {
                if (!other.shares_node_with(solid))
                    explanation_.add("equal subtrees shared", 1, "nodes");
                return other;
            }
        same_hash.push_back(solid);
        return solid;
    }

    PlanOptions options_;
    bool expand_ = true;
    std::int64_t steps_ = 0;
    std::int64_t maps_passed_ = 0;
    std::int64_t maps_left_ = 0;
    std::vector<Frame> stack_;
    LeafCounter counter_;
    Explanation explanation_;
    std::unordered_map<std::uint64_t, std::vector<Solid>> known_;
    std::unordered_map<const Node*, Planned> kept_;
};

}  // namespace

void Explanation::add(const std::string& what, std::int64_t count, const std::string& unit)
{
    if (count == 0) return;
    for (Entry& entry : entries)
        if (entry.what == what && entry.unit == unit) {
            entry.count += count;
            return;
        }
    entries.push_back({what, count, unit});
}

std::string Explanation::to_text() const
{
    if (entries.empty()) return "nothing was left out";
    std::string text;
    for (const Entry& entry : entries) {
        if (!text.empty()) text += "\n";
        text += entry.what + ": " + std::to_string(entry.count) + " " + entry.unit;
    }
    return text;
}

Plan plan(const Solid& solid, const PlanOptions& options)
{
    return Planner(options).run(solid);
}

std::int64_t count_leaves(const Solid& solid)
{
    return LeafCounter()(solid.node());
}

}  // namespace genus
