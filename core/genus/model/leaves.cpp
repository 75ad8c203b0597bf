#include "genus/model/leaves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/model/solid_field.h"

namespace genus {
namespace {

constexpr std::size_t kMostLeaves = 10'000'000;
constexpr double kUnit = std::numeric_limits<double>::epsilon();
// Of the size of coordinates: this far from a border is not on it; and a step to either side.
constexpr double kAway = 1e-6, kBeside = 1e-8;

/// Depth first: `on_leaf` for each primitive or empty solid, `on_operator` for each operator after
/// its parts.
template <class OnLeaf, class OnOperator>
void walk(const Solid& solid, const OnLeaf& on_leaf, const OnOperator& on_operator)
{
    struct Step {
        PlacedLeaf at;
        bool is_end;
    };
    std::vector<Step> open{{{solid, Transform{}}, false}};
    for (std::size_t n = 0; !open.empty(); ++n) {
        if (n % 1024 == 0) current_progress().check();
        const Step step = std::move(open.back());
        open.pop_back();
        const Node& node = step.at.leaf.node();
        const auto parts = parts_of(node);
        if (step.is_end) {
            on_operator(node);
            continue;
        }
        if (parts.empty()) {
            on_leaf(step.at);
            continue;
        }
        const auto* moved = std::get_if<Transformed>(&node.shape);
        const Transform map = moved ? step.at.map * moved->map : step.at.map;
        open.push_back({step.at, true});
        for (std::size_t i = parts.size(); i-- > 0;) open.push_back({{parts[i], map}, false});
    }
}

}  // namespace

std::vector<PlacedLeaf> leaves_of(const Solid& solid)
{
    std::vector<PlacedLeaf> leaves;
    walk(
        solid,
        [&](const PlacedLeaf& leaf) {
            if (leaf.leaf.is_empty()) return;
            require(leaves.size() < kMostLeaves, "solid: more than 10^7 leaves");
            leaves.push_back(leaf);
        },
        [](const Node&) {});
    return leaves;
}

std::vector<std::string> leaf_names(const Solid& solid)
{
    std::vector<std::string> names;
    for (const PlacedLeaf& leaf : leaves_of(solid))
        names.push_back(describe(leaf.leaf.node().shape));
    return names;
}

struct LeafFinder::Data {
    struct Entry {
        PlacedLeaf placed;
        std::once_flag made;
        std::shared_ptr<const Implicit> field;
    };
    std::vector<Entry> leaves;
    std::vector<std::int32_t> bounded, unbounded;  // numbers of leaves
    BoxTree boxes;                                 // of the bounded ones

    const Implicit& field_of(std::int32_t i)
    {
        Entry& leaf = leaves[i];
        std::call_once(leaf.made, [&] {
            leaf.field = solid_field(transformed(leaf.placed.leaf, leaf.placed.map));
        });
        return *leaf.field;
    }

    // The tree once the states of its leaves are known: its operators after their parts.
    enum class Operator { Leaf, Nothing, Union, Intersection, Difference };
    struct Step {
        Operator what;
        std::uint32_t n_parts;
    };
    std::vector<Step> program;

    void write_program(const Solid& solid)
    {
        const auto write = [&](Operator what, std::size_t n_parts) {
            program.push_back({what, static_cast<std::uint32_t>(n_parts)});
        };
        walk(
            solid,
            [&](const PlacedLeaf& leaf) {
                write(leaf.leaf.is_empty() ? Operator::Nothing : Operator::Leaf, 0);
            },
            [&](const Node& node) {
                const std::size_t n = parts_of(node).size();
                if (std::holds_alternative<Union>(node.shape)) write(Operator::Union, n);
                if (std::holds_alternative<Intersection>(node.shape))
                    write(Operator::Intersection, n);
                if (std::holds_alternative<Difference>(node.shape)) write(Operator::Difference, n);
            });
    }

    // Whether a point is in the solid that is in these leaves, ascending, and no others.
    bool is_inside(const std::vector<std::int32_t>& in) const
    {
        std::vector<char> stack;
        std::int32_t leaf = 0;
        auto next = in.begin();
        for (const Step& step : program) {
            if (step.what == Operator::Leaf) {
                const bool is_in = next != in.end() && *next == leaf;
                if (is_in) ++next;
                ++leaf;
                stack.push_back(is_in);
                continue;
            }
            const auto first = stack.end() - static_cast<std::ptrdiff_t>(step.n_parts);
            const auto has_true = [&](auto from) {
                return std::find(from, stack.end(), char{1}) != stack.end();
            };
            bool value = false;
            if (step.what == Operator::Union) value = has_true(first);
            if (step.what == Operator::Intersection)
                value = std::find(first, stack.end(), char{0}) == stack.end();
            if (step.what == Operator::Difference) value = *first != 0 && !has_true(first + 1);
            stack.erase(first, stack.end());
            stack.push_back(value);
        }
        return !stack.empty() && stack.back() != 0;
    }

    // Whether the solid at q would change if this leaf alone did.
    bool decides(std::int32_t leaf, const std::vector<std::int32_t>& candidates, const Vec3& q)
    {
        std::vector<std::int32_t> with, without;
        for (const std::int32_t i : candidates) {
            if (i != leaf && !(field_of(i).value(q) <= 0.0)) continue;
            with.push_back(i);
            if (i != leaf) without.push_back(i);
        }
        return is_inside(with) != is_inside(without);
    }

    // Leaves whose box is at p or near, ascending.
    std::vector<std::int32_t> near(const Vec3& p, double reach) const
    {
        std::vector<std::int32_t> found = unbounded;
        boxes.visit_overlapping(Box3{p, p}.inflated(reach),
                                [&](std::int32_t i) { found.push_back(bounded[i]); });
        std::sort(found.begin(), found.end());
        return found;
    }
};

LeafFinder::LeafFinder(const Solid& solid) : data_(std::make_unique<Data>())
{
    std::vector<PlacedLeaf> leaves = leaves_of(solid);
    data_->leaves = std::vector<Data::Entry>(leaves.size());
    std::vector<Box3> boxes;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const Box3 box = image_bounds(leaves[i].leaf, leaves[i].map);
        const auto number = static_cast<std::int32_t>(i);
        data_->leaves[i].placed = std::move(leaves[i]);
        if (box.empty() || !box.bounded()) {
            data_->unbounded.push_back(number);
            continue;
        }
        data_->bounded.push_back(number);
        boxes.push_back(box);
    }
    data_->boxes = BoxTree(boxes);
    data_->write_program(solid);
}

LeafFinder::~LeafFinder() = default;

std::int32_t LeafFinder::at(const Vec3& p, const Vec3& normal) const
{
    if (data_->leaves.size() <= 1) return data_->leaves.empty() ? -1 : 0;
    double size = norm(p);
    if (!data_->bounded.empty()) size = std::max(size, data_->boxes.bounds().diagonal());
    struct Border {
        std::int32_t leaf;
        double away, turn;
    };
    std::vector<Border> borders;
    const auto look_at = [&](const std::vector<std::int32_t>& numbers) {
        borders.clear();
        double least = std::numeric_limits<double>::infinity();
        for (const std::int32_t i : numbers) {
            const Implicit& field = data_->field_of(i);
            const Vec3 g = field.gradient(p);
            const double slope = norm(g);
            const double scale = slope > 0.0 ? 1.0 / slope : 1.0;
            borders.push_back(
                {i, std::fabs(field.value(p)) * scale, std::fabs(dot(g, normal)) * scale});
            least = std::min(least, borders.back().away);
        }
        return least;
    };
    std::vector<std::int32_t> numbers = data_->near(p, 1e-9 * size);
    double least = look_at(numbers);
    if (!(least <= kAway * size)) {  // the point itself is rounded, or a leaf has no slope there
        numbers.resize(data_->leaves.size());
        std::iota(numbers.begin(), numbers.end(), 0);
        least = look_at(numbers);
    }
    // Those that are as near as can be told and have the normal.
    const double near = 2.0 * least + 64.0 * kUnit * size;
    double turn = 0.0;
    for (const Border& b : borders)
        if (b.away <= near) turn = std::max(turn, b.turn);
    std::erase_if(borders,
                  [&](const Border& b) { return !(b.away <= near && b.turn >= turn - 1e-9); });
    if (borders.size() > 1)
        for (const Border& b : borders)
            for (const double side : {-1.0, 1.0})
                if (data_->decides(b.leaf, numbers, p + side * kBeside * size * normal))
                    return b.leaf;
    return borders.empty() ? -1 : borders.front().leaf;
}

}  // namespace genus
