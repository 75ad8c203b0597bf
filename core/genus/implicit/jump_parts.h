#pragma once

#include <optional>
#include <vector>

#include "genus/base/box.h"
#include "genus/implicit/expression.h"
#include "genus/implicit/implicit.h"

namespace genus {

/// A part of space in which a function with jumps is one without: where all `sides` hold.
struct JumpPiece {
    /// A side is where `of` is not negative, or where it is not positive.
    struct Side {
        Expression of;
        bool not_negative;
    };
    Expression function;
    std::vector<Side> sides;
};

/// False if it is seen from the operations that such a function changes its sign at zeros only.
bool may_jump(const Expression& expression);

/// A place where the function was seen to change its sign without a zero: at a jump, a pole or the
/// end of where it is defined. Some 5,000 samples in the box, and halving between those of
/// different signs: what is thinner than 1/16 of the box may be missed.
std::optional<Vec3> jump_at_border(const Implicit& field, const Box3& box);

/// The expression with a root or logarithm that can take values where it is not defined, and the
/// side g >= 0 on which it is the same. Nothing if there is none with bounds. Where g < 0 the
/// expression is not defined either. O(nodes).
std::optional<JumpPiece> defined_piece(const Expression& expression, const Box3& box);

/// Shown to be defined in the box, but where infinities meet. O(nodes).
bool is_defined(const Expression& expression, const Box3& box);

/// Takes one kind of jump out of an expression: but for a set without volume, {f <= 0} is in the
/// box the union of the pieces {function <= 0} cut to their sides. In this order
/// - floor, ceil, round and sign have one value a piece,
/// - sums and products of fractions whose denominators change sign are brought to one fraction,
///   whose sign is that of its numerator where the denominator is positive.
/// Nothing if there is no such place, or it is too deep inside: in another function, or in more
/// than `most` pieces. O(nodes) a piece.
std::optional<std::vector<JumpPiece>> jump_pieces(const Expression& expression, const Box3& box,
                                                  std::size_t most);

}  // namespace genus
