#pragma once

#include <string>
#include <variant>
#include <vector>

#include "genus/language/builtins_plane.h"
#include "genus/language/diagnostics.h"
#include "genus/language/model_tree.h"
#include "genus/model/solid.h"

namespace genus::language {

/// True for bezier_curve, bspline (plane shapes), and bezier_patch, triangle_patch, patches.
bool is_freeform_shape(const std::string& name);

/// A curve as the plane shape that it bounds together with the line from its end to its start: to a
/// share of the tolerance, or without one in pieces by $fn or $fs. Patches as the solid inside
/// them: those of a file, or all bezier_patch and triangle_patch below the node, with groups and
/// transforms in between.
/// Throws ModelError at the node for numbers that make no curve or patch, other nodes among
/// patches, and patches that close nothing.
std::variant<PlaneShape, Solid> freeform_shape(const ModelNode& node);

/// True for ffd, move_points and subdivide, which change solids.
bool is_deformation(const std::string& name);

/// ffd: the solid under a lattice given by its control points or by moves of some of them.
/// move_points: under the lattice that takes given points to given places; what it cannot meet is
/// a warning. subdivide: the subdivision surface of a polyhedron.
/// Throws ModelError at the node.
Solid deformed_solid(const ModelNode& node, const Solid& part, std::vector<Message>& messages);

}  // namespace genus::language
