#pragma once

#include <optional>
#include <string>
#include <vector>

#include "genus/language/diagnostics.h"
#include "genus/language/model_tree.h"
#include "genus/model/solid.h"
#include "genus/polygon/region.h"

namespace genus {

/// The solid that a model tree describes: the union of its nodes, or what the modifier ! picks.
/// Nodes without extent, such as a cube of size 0, are empty; a transform that flattens its parts
/// makes them empty with a warning. Faces of a polyhedron turn clockwise seen from outside in the
/// text language and are reversed.
///
/// Throws ModelError at the node for numbers that make no solid and for geometry that cannot be
/// made (yet), naming the feature. Calls itself as deep as the tree is; O(nodes).
Solid to_solid(const ModelNode& tree, std::vector<Message>& messages);

/// What a model tree describes: a plane shape where `region` is set, else a solid.
struct ModelGeometry {
    Solid solid;
    std::optional<Region> region;
};
/// The same for models of either kind. Throws as `to_solid` does, not for plane shapes.
ModelGeometry to_geometry(const ModelNode& tree, std::vector<Message>& messages);

}  // namespace genus
