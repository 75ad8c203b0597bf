#include "genus/implicit/solid_parts.h"

#include <optional>
#include <utility>

#include "genus/implicit/function.h"
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
        auto done = split_leaves(lifted_parts(e), depth);
        if (!done || n_leaves_ > kMostLeaves) return std::nullopt;
        if (out.parts.empty()) return done;
        out.parts.push_back(std::move(*done));
        return out;
    }

    bool jumps(const Expression& e) const
    {
        return may_jump(e) && jump_at_border(Function(e), box_);
    }

private:
    static constexpr int kMostCuts = 12;  // one inside the other
    static constexpr std::size_t kMostLeaves = 256, kMostPieces = 64;

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

}  // namespace

SmoothParts solid_parts(const Expression& expression, const Box3& box)
{
    Splitter splitter(box);
    if (!splitter.jumps(expression)) return smooth_parts(expression, box);
    const std::optional<SmoothParts> parts = splitter.split(expression);
    return parts && all_finite(*parts, box) ? *parts : as_leaf(expression);
}

}  // namespace genus
