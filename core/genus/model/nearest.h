#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "genus/model/csg_field.h"

namespace genus {

/// A point of a solid's surface.
struct SurfacePoint {
    Vec3 point;
    double distance = 0.0;  // from the point that was asked for
    /// No point of the surface is nearer than distance - bound.
    double bound = 0.0;
    /// Numbers in the field of the surfaces that it lies on, -1 where there are fewer than three:
    /// one inside a face, two on an edge, three in a corner.
    std::array<std::int32_t, 3> surfaces{-1, -1, -1};
};

/// For each point the nearest one of the surface of a solid: on faces, edges and in corners as they
/// are cut by the tree, without a mesh. Parallel over points.
///
/// Boxes, nearest first, are dropped once the signs of the surfaces, within the box and nearer than
/// the best point so far, settle the formula; the rest are halved. Points of faces, edges and
/// corners are found by Newton's method for the nearest one on one, two or three surfaces, and
/// count if the formula depends on these surfaces there. Ends when nothing nearer by more than
/// 1e-10 of the diagonal of the box of the solid is left, or after 20,000 boxes: `bound` says what
/// is then still possible.
///
/// Throws InvalidInput for a point that is not finite, a solid without surface, and where CsgField
/// does or a leaf is no polynomial; UnboundedSolid as require_bounded.
std::vector<SurfacePoint> nearest_points(const Solid& solid, std::span<const Vec3> points);

}  // namespace genus
