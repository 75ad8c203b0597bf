#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "genus/model/csg_field.h"

namespace genus {

/// Which side of a surface: -1 inside (F < 0), 1 outside, 0 unknown.
using Sign = std::int8_t;

/// The tree of a CsgField as a formula over the signs of its surfaces: all that counts for the
/// question "inside or outside". Shrinks as signs become known, so that a small cell carries a
/// formula of the few surfaces that decide in it.
class SignFormula {
public:
    explicit SignFormula(const CsgField& field);

    /// 0 as long as the formula depends on some surface, else the sign it has throughout.
    Sign constant() const { return constant_; }
    /// The surfaces the formula still names, ascending.
    const std::vector<std::int32_t>& surfaces() const { return parts_->surfaces; }
    /// How the result depends on a surface: `plain` if matter lies where it is negative, `negated`
    /// as in the second operand of a difference, or both. `twice` if it is written both ways.
    struct Use {
        bool plain = false, negated = false, twice = false;
    };
    /// How each of `surfaces()` enters, in their order.
    const std::vector<Use>& uses() const { return parts_->uses; }

    /// The formula once the signs that are not 0 are known; `signs` has one entry a surface of the
    /// field. Surfaces are dropped where they turn out not to matter, as the wall between two parts
    /// that were put together, or the end of one inside the other. O(length), times 2^n for n up to
    /// eight surfaces if one is named more than once; a formula that no sign changes is shared, not
    /// copied, and one of up to eight surfaces remembers what it became before.
    SignFormula simplified(std::span<const Sign> signs) const;
    /// The sign of the formula, 0 if the known signs leave it open.
    Sign sign(std::span<const Sign> signs) const;
    /// The same, with both cases tried of surfaces that enter both ways.
    Sign sign_by_cases(std::vector<Sign>& signs) const;

private:
    // A term is 2 * number + negated, of a surface or, complemented bitwise, of an earlier node.
    struct Node {
        bool is_max;
        std::int32_t first, count;
    };
    // What a formula became once signs were known, by these. Grows at its head only, so threads
    // read it, and add to it, without a lock.
    class Memory {
    public:
        Memory() = default;
        Memory(const Memory&) : Memory() {}
        Memory& operator=(const Memory&) = delete;
        ~Memory();
        const SignFormula* find(std::uint32_t signs) const;
        // Unless there is much in it already.
        void add(std::uint32_t signs, const SignFormula& became) const;

    private:
        struct Entry;
        mutable std::atomic<const Entry*> first_{nullptr};
    };
    struct Parts {
        std::vector<Node> nodes;  // the last is the result
        std::vector<std::int32_t> terms;
        std::vector<std::int32_t> surfaces;
        std::vector<Use> uses;
        bool any_repeated = false;  // a surface is named more than once, and some may be idle
        Memory memory;

        void note_surfaces();
    };
    explicit SignFormula(Sign constant);
    explicit SignFormula(Parts&& parts) : parts_(std::make_shared<const Parts>(std::move(parts))) {}

    SignFormula simplified_anew(std::span<const Sign> signs) const;
    SignFormula folded(std::span<const Sign> signs) const;
    std::vector<Sign> table() const;
    SignFormula with_true_uses() const;

    std::shared_ptr<const Parts> parts_;
    Sign constant_ = 0;
};

}  // namespace genus
