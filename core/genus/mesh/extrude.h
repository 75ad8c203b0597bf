#pragma once

#include "genus/mesh/indexed_mesh.h"
#include "genus/polygon/region.h"

namespace genus {

struct LinearExtrudeOptions {
    double height = 1.0;
    bool center = false;     // half of it below z = 0
    double twist = 0.0;      // degrees over the whole height, clockwise seen from above
    int slices = 1;          // layers; more follow a twist or an uneven scale more closely
    Vec2 scale{{1.0, 1.0}};  // of the top; zero in both axes ends in a point
};

/// The solid between a region at the bottom and its copy, turned and scaled, at the top; closed,
/// faces outward. Walls are flat quadrilaterals without twist and uneven scale, triangles
/// otherwise, cut along the shorter diagonal. Empty for an empty region.
/// Where the region touches itself in a point, so does the solid along an edge.
///
/// Throws InvalidInput for a height or slices that are not positive, a negative or uneven zero
/// scale, numbers that are not finite, or more than 10^8 vertices. O(n slices + triangulation).
PolygonMesh linear_extrude(const Region& region, const LinearExtrudeOptions& options);

struct RotateExtrudeOptions {
    double angle = 360.0;  // degrees, counterclockwise; clockwise if negative
    double start = 0.0;    // angle of the first copy, from the x axis
    int fragments = 32;    // segments over the whole angle
};

/// The solid that a region of the plane x, z sweeps when it turns about the z axis; closed, faces
/// outward. Points on the axis do not turn. A full turn takes three fragments or more.
///
/// Throws InvalidInput if the region reaches to both sides of the axis, for fragments out of range,
/// an angle that is zero or more than a turn, or more than 10^8 vertices.
PolygonMesh rotate_extrude(const Region& region, const RotateExtrudeOptions& options);

}  // namespace genus
