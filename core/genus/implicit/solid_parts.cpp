#include "genus/implicit/solid_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "genus/base/halves.h"
#include "genus/implicit/function.h"
#include "genus/implicit/half_space_of.h"
#include "genus/implicit/jump_parts.h"

namespace genus {

namespace {

using Kind = SmoothParts::Kind;

SmoothParts as_leaf(const Expression& e)
{
    return {Kind::Leaf, e, {}};
}

// Lifts minima and maxima, and cuts what is left at its jumps, until neither is to be done.
class Splitter {
public:
    explicit Splitter(const Box3& box) : box_(box) {}

    // Nothing if there would be too many leaves.
    std::optional<SmoothParts> split(Expression e, int depth = kMostCuts)
    {
        // What is not defined is outside, whatever it is a minimum of: before all else.
        SmoothParts out{Kind::Max, {}, {}};
        for (int n = 0; n < kMostCuts; ++n) {
            const auto defined = defined_piece(e, box_);
            if (!defined) break;
            e = defined->function;
            add_sides(*defined, out);
        }
        if (!is_defined(e, box_)) return std::nullopt;
        auto done = split_leaves(lifted(e), depth);
        if (!done || n_leaves_ > kMostLeaves) return std::nullopt;
        if (out.parts.empty()) return done;
        out.parts.push_back(std::move(*done));
        return out;
    }

    // Where it is the border, or would be but for other parts: there a step is not seldom zero in
    // all of a piece of space.
    bool jumps(const Expression& e) const { return may_jump(e) && any_jumps(lifted(e)); }

private:
    static constexpr int kMostCuts = 12;  // one inside the other
    static constexpr std::size_t kMostLeaves = 256, kMostPieces = 64;

    // Whole where a part would not be defined where the whole is: log|x| is not log(x) and log(-x).
    SmoothParts lifted(const Expression& e) const
    {
        SmoothParts parts = lifted_parts(e);
        return all_defined(parts) || !is_defined(e, box_) ? parts : as_leaf(e);
    }

    bool all_defined(const SmoothParts& parts) const
    {
        if (parts.kind == Kind::Leaf) return is_defined(parts.leaf, box_);
        return std::all_of(parts.parts.begin(), parts.parts.end(),
                           [&](const SmoothParts& part) { return all_defined(part); });
    }

    bool any_jumps(const SmoothParts& parts) const
    {
        if (parts.kind == Kind::Leaf)
            return may_jump(parts.leaf) && jump_at_border(Function(parts.leaf), box_);
        return std::any_of(parts.parts.begin(), parts.parts.end(),
                           [&](const SmoothParts& part) { return any_jumps(part); });
    }

    void add_sides(const JumpPiece& piece, SmoothParts& to)
    {
        for (const JumpPiece::Side& side : piece.sides) {
            to.parts.push_back(as_leaf(side.of));
            to.parts.back().negated = side.not_negative;
            ++n_leaves_;
        }
    }

    std::optional<SmoothParts> split_leaves(const SmoothParts& p, int depth)
    {
        if (p.kind == Kind::Leaf) return split_leaf(p, depth);
        SmoothParts out{p.kind, {}, {}};
        for (const SmoothParts& part : p.parts) {
            auto done = split_leaves(part, depth);
            if (!done) return std::nullopt;
            out.parts.push_back(std::move(*done));
        }
        return out;
    }

    std::optional<SmoothParts> split_leaf(const SmoothParts& leaf, int depth)
    {
        if (++n_leaves_ > kMostLeaves) return std::nullopt;
        // Inside what was cut, jumps that were of no account can be the border.
        if (depth == 0 || (depth == kMostCuts && !jumps(leaf.leaf))) return leaf;
        const auto pieces = jump_pieces(leaf.leaf, box_, kMostPieces);
        if (!pieces) return leaf;
        if (pieces->empty()) return as_leaf(1.0);
        SmoothParts out{Kind::Min, {}, {}};
        for (const JumpPiece& piece : *pieces) {
            SmoothParts all{Kind::Max, {}, {}};
            // A number is that of a piece that is full.
            if (!piece.function.number() || piece.sides.empty()) {
                auto done = split(piece.function, depth - 1);
                if (!done) return std::nullopt;
                all.parts.push_back(std::move(*done));
            }
            add_sides(piece, all);
            out.parts.push_back(std::move(all));
        }
        return out;
    }

    const Box3& box_;
    std::size_t n_leaves_ = 0;
};

// Drops what the other parts leave without volume, as the empty half of a ball behind a plane that
// touches it, and sides that the others never reach.
class Pruner {
public:
    explicit Pruner(const Box3& box) : box_(box) {}

    // What of `parts` has volume within all of `others`: nothing if none has, a negative number if
    // it fills them.
    std::optional<SmoothParts> pruned(const SmoothParts& parts, std::vector<SmoothParts> others)
    {
        SmoothParts out{parts.kind, {}, {}};
        if (parts.kind == Kind::Leaf) {
            others.push_back(parts);
            if (!has_volume(others)) return std::nullopt;
            return cuts(others, others.size() - 1) ? parts : as_leaf(-1.0);
        }
        if (parts.kind == Kind::Min) {
            for (const SmoothParts& part : parts.parts) {
                auto kept = pruned(part, others);
                if (!kept) continue;
                if (is_full(*kept)) return kept;
                out.parts.push_back(std::move(*kept));
            }
            if (out.parts.empty()) return std::nullopt;
            return out;
        }
        // Of an intersection all are within the leaves.
        const std::size_t first = others.size();
        std::vector<SmoothParts>& all = others;
        for (const SmoothParts& part : parts.parts)
            if (part.kind == Kind::Leaf) all.push_back(part);
        if (!has_volume(all)) return std::nullopt;
        for (std::size_t n = all.size(); n-- > first;)
            if (!cuts(all, n)) all.erase(all.begin() + static_cast<std::ptrdiff_t>(n));
        for (const SmoothParts& part : parts.parts) {
            if (part.kind == Kind::Leaf) continue;
            auto kept = pruned(part, all);
            if (!kept) return std::nullopt;
            if (!is_full(*kept)) out.parts.push_back(std::move(*kept));
        }
        out.parts.insert(out.parts.end(), all.begin() + static_cast<std::ptrdiff_t>(first),
                         all.end());
        return out.parts.empty() ? as_leaf(-1.0) : out;
    }

private:
    static constexpr std::size_t kMostBoxes = 200;
    static constexpr double kNothing = 1e-12;

    static bool is_full(const SmoothParts& parts)
    {
        return parts.kind == Kind::Leaf && parts.leaf.number() && *parts.leaf.number() < 0.0;
    }

    // Does a leaf take anything with volume from the others?
    bool cuts(std::vector<SmoothParts>& leaves, std::size_t n)
    {
        leaves[n].negated = !leaves[n].negated;
        const bool any = has_volume(leaves);
        leaves[n].negated = !leaves[n].negated;
        return any;
    }

    // Not shown by bounds that one of the leaves is positive at each place of the box, but for what
    // rounding adds to them. Planes along the axes cut the box exactly.
    bool has_volume(const std::vector<SmoothParts>& leaves)
    {
        Box3 box = box_;
        std::vector<std::pair<const Function*, bool>> functions;
        for (const SmoothParts& leaf : leaves)
            if (!cut(leaf, box)) functions.emplace_back(&function_of(leaf.leaf), leaf.negated);
        if (is_flat(box)) return false;
        std::vector<Box3> open{box};
        for (std::size_t n = 0; !open.empty(); ++n) {
            if (n == kMostBoxes) return true;
            const Box3 part = open.back();
            open.pop_back();
            const auto is_outside = [&](const auto& f) {
                return is_positive(*f.first, f.second ? -1.0 : 1.0, part);
            };
            if (std::any_of(functions.begin(), functions.end(), is_outside)) continue;
            const auto [low, high] = halves(part);
            open.push_back(high);
            open.push_back(low);
        }
        return false;
    }

    // Shown by bounds but for what rounding adds to them, if that is nothing beside what the
    // function usually is in the box.
    static bool is_positive(const Function& f, double sign, const Box3& box)
    {
        const Interval range = f.bound(box);
        const double least = sign > 0.0 ? range.lo : -range.hi;
        if (least >= 0.0) return true;
        const double slack = 16.0 * std::numeric_limits<double>::epsilon() * range.magnitude();
        if (!(least >= -slack)) return false;
        constexpr std::size_t kSamples = 27;
        std::array<double, kSamples> sizes{};
        for (std::size_t n = 0; n < kSamples; ++n) {
            const Vec3 share{{0.5 * static_cast<double>(n % 3),
                              0.5 * static_cast<double>(n / 3 % 3),
                              0.5 * static_cast<double>(n / 9)}};
            Vec3 p = box.min;
            for (std::size_t i = 0; i < 3; ++i) p[i] += share[i] * (box.max[i] - box.min[i]);
            sizes[n] = std::fabs(f.value(p));
            if (std::isnan(sizes[n])) return false;
        }
        std::nth_element(sizes.begin(), sizes.begin() + kSamples / 2, sizes.end());
        return slack <= kNothing * sizes[kSamples / 2];
    }

    static bool is_flat(const Box3& box)
    {
        for (std::size_t i = 0; i < 3; ++i)
            if (!(box.min[i] < box.max[i])) return true;
        return false;
    }

    // Cuts the box to the leaf, if that is a half-space with an axis for a normal.
    static bool cut(const SmoothParts& leaf, Box3& box)
    {
        const auto half = half_space_of(leaf.leaf);
        if (!half) return false;
        const auto c = half->polynomial();  // g x + h y + i z + j
        std::size_t axis = 3;
        for (std::size_t i = 0; i < 3; ++i) {
            if (c[6 + i] == 0.0) continue;
            if (axis < 3) return false;
            axis = i;
        }
        if (axis == 3) return false;
        const double place = -c[9] / c[6 + axis];
        if ((c[6 + axis] > 0.0) != leaf.negated)
            box.max[axis] = std::min(box.max[axis], place);
        else
            box.min[axis] = std::max(box.min[axis], place);
        return true;
    }

    const Function& function_of(const Expression& e)
    {
        return functions_.try_emplace(&e.node(), e).first->second;
    }

    const Box3& box_;
    std::unordered_map<const Expression::Node*, Function> functions_;
};

}  // namespace

SmoothParts solid_parts(const Expression& expression, const Box3& box)
{
    Splitter splitter(box);
    if (!splitter.jumps(expression)) return smooth_parts(expression, box);
    const std::optional<SmoothParts> parts = splitter.split(expression);
    if (!parts || !all_finite(*parts, box)) return as_leaf(expression);
    return Pruner(box).pruned(*parts, {}).value_or(as_leaf(1.0));
}

}  // namespace genus
