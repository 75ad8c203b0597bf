#pragma once

#include <optional>
#include <span>

#include "genus/model/solid.h"
#include "genus/polygon/region.h"

namespace genus {

/// Solids made of others or of plane regions by more than operators. All are polyhedra: what is
/// curved in them or becomes curved is made within `tolerance`, which goes into the error of what
/// is made of it; without one, within a quarter of a thousandth of the bounding box's diagonal.

/// Convex hull of solids: of their corners, exactly, where all of them are united polyhedra; of
/// parts that are curved or cut from others a mesh is made first. Empty if flat.
Solid hull(std::span<const Solid> parts, std::optional<double> tolerance = std::nullopt);

/// The sum of all points of one solid with all of another, for one after the other; empty parts
/// are left out. Of convex parts the hull of the sums of corners. Otherwise what the borders sweep
/// over each other, all in one union, with each part of A at a point of B and each part of B at a
/// point of A. Throws InvalidInput beyond 200,000 pieces.
Solid minkowski(std::span<const Solid> parts, std::optional<double> tolerance = std::nullopt);

struct ExtrudeOptions {
    double height = 1.0;
    double twist = 0.0;  // degrees over the whole height, clockwise seen from above
    Vec2 scale{{1.0, 1.0}};
    bool center = false;
    int slices = 0;  // layers; 0: as many as the tolerance needs, else the polyhedron of that many
};

/// See mesh/extrude.h. Throws InvalidInput for what that refuses, ToleranceNotMet if a twist needs
/// more than a million slices.
Solid extrude(const Region& region, const ExtrudeOptions& options,
              std::optional<double> tolerance = std::nullopt);

struct RevolveOptions {
    double angle = 360.0;  // degrees, counterclockwise
    int fragments = 0;     // sides of a full turn; 0: as many as the tolerance needs
};

/// What a region of the plane x, z sweeps when it turns about the z axis, from the x axis on.
Solid revolve(const Region& region, const RevolveOptions& options,
              std::optional<double> tolerance = std::nullopt);

/// Sides of a full circle of radius r whose facets stay within `tolerance` of it, at least 5: the
/// least n with r (1 - cos(180 / n)) <= tolerance. Throws ToleranceNotMet beyond a million.
int sides_within(double tolerance, double r);

}  // namespace genus
