#pragma once

#include <optional>
#include <vector>

#include "genus/model/csg_field.h"

namespace genus {

/// What a tree becomes: its surfaces, each once, and the formula over them.
struct LoweredTree {
    std::vector<Surface> surfaces;
    std::vector<CsgField::Instruction> instructions;
};

/// Writes a tree as a formula over surfaces; see CsgField, whose constructor this is. No
/// recursion, so any depth of tree will do. Throws InvalidInput as CsgField does, and for trees of
/// more than 10^7 leaves once shared parts are written out.
LoweredTree lower(const Solid& solid);

/// A leaf of a tree, and its surfaces among those of the tree: it is where none of them, negated
/// where that is said, is positive.
struct PlacedLeaf {
    const Node* node;
    Transform map;
    std::vector<CsgField::Term> surfaces;
};
/// The same with leaves for terms: `is_surface` tells a leaf from an instruction.
struct TreeOfLeaves {
    std::vector<PlacedLeaf> leaves;
    std::vector<Surface> surfaces;  // in the order of `lower`
    std::vector<CsgField::Instruction> instructions;
    std::vector<Solid> expanded;  // keeps nodes that are not in the tree
};
/// As `lower`; `solid` must outlive the result. Nothing if a leaf is a function, which is no
/// intersection of surfaces.
std::optional<TreeOfLeaves> lower_to_leaves(const Solid& solid);

/// What lies below the transforms and colours on top of a tree, and the map that these make.
struct PlacedNode {
    const Node* node;
    Transform map;
};
PlacedNode below_transforms(const Node& top, const Transform& map = {});

/// The surfaces of one primitive moved by `map`, their intersection being the primitive. Throws
/// InvalidInput as `lower`.
std::vector<Surface> leaf_surfaces(const Shape& shape, const Transform& map);

}  // namespace genus
