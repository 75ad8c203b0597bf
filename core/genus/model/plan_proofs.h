#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "genus/model/csg_field.h"
#include "genus/model/solid.h"

namespace genus {

/// Questions about solids in a box, answered "yes" where interval bounds on at most 256 cells of
/// the box prove it; a point that disproves it ends the search early. A solid that is no function
/// of space, or of more than 64 leaves, leaves every question open. The field is made when a
/// question first needs it: for a prism of a hundred sides that costs as much as cutting it.
class FieldProof {
public:
    /// `leaves` is how many the solid has, known to the caller, at least roughly.
    FieldProof(const Solid& solid, std::int64_t leaves) : solid_(solid), leaves_(leaves) {}

    /// True only if no point of the box belongs to all of them.
    static bool disjoint(std::span<FieldProof> solids, const Box3& box);
    /// True only if every point of `inner` in the box belongs to `outer`.
    static bool inside(FieldProof& inner, FieldProof& outer, const Box3& box);
    /// True only if every point of the box belongs to the solid.
    bool fills(const Box3& box);

private:
    const CsgField* field();  // null if there is none

    Solid solid_;
    std::int64_t leaves_;
    bool tried_ = false;
    std::optional<CsgField> field_;
};

}  // namespace genus
