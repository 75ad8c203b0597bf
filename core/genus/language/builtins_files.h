#pragma once

#include <span>
#include <vector>

#include "genus/language/builtins.h"
#include "genus/language/builtins_plane.h"
#include "genus/language/diagnostics.h"
#include "genus/model/solid.h"

namespace genus::language {

/// True for an import of a plane shape, by the extension of its file.
bool is_plane_import(const ModelNode& node);

/// The shape in the file that an import, or an extrusion of a file, names. Throws ModelError at
/// the node.
PlaneShape imported_shape(const ModelNode& node);

/// The solid under a height map: surface().
Solid surface_solid(const ModelNode& node);

/// The outlines of text(). Says so where another font than the one asked for stands in.
PlaneShape text_shape(const ModelNode& node, std::vector<Message>& messages);

/// dxf_dim(file, layer, name, origin, scale) and dxf_cross(file, layer, origin, scale).
Value dxf_dim(Evaluator& e, const Call& call, std::span<const Value> arguments);
Value dxf_cross(Evaluator& e, const Call& call, std::span<const Value> arguments);

}  // namespace genus::language
