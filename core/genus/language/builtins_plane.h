#pragma once

#include <optional>
#include <vector>

#include "genus/language/model_tree.h"
#include "genus/mesh/indexed_mesh.h"
#include "genus/polygon/region.h"

namespace genus::language {

/// What a plane node comes to.
struct PlaneShape {
    Region region;
    /// How far its border may be from the exact round one, where a tolerance asks for that.
    double deviation = 0.0;
};

/// True for nodes that are plane whatever is in them: square, circle, polygon, text, projection,
/// offset. All others are what their parts are, or solid.
bool is_plane_node(const std::string& name);

/// True for linear_extrude and rotate_extrude.
bool is_extrusion(const std::string& name);

/// The plane shape of a node made of plane parts; a node of no effect on plane shapes unites them.
/// Throws ModelError at the node for numbers that make no shape and for what cannot be made.
PlaneShape plane_shape(const ModelNode& node, std::vector<PlaneShape> parts);

/// A closed mesh, with what its deviation from the exact solid may be.
struct ExtrudedMesh {
    PolygonMesh mesh;
    double deviation = 0.0;
};
/// linear_extrude and rotate_extrude, with the number of slices that the text language takes.
ExtrudedMesh extruded(const ModelNode& node, const PlaneShape& profile);

/// Sides of a circle of radius r whose facets stay within `tolerance` of it: least n with
/// r (1 - cos(180 / n)) <= tolerance, at least 5. Throws ToleranceNotMet beyond a million.
int fragments_within(double tolerance, double r);

}  // namespace genus::language
