#pragma once

#include <optional>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/vec.h"
#include "genus/implicit/implicit.h"

namespace genus {

/// A point of the surface with its tangent plane.
struct TangentElement {
    Vec3 point;
    Vec3 normal;             // unit length, outward
    bool on_border = false;  // of the grid, not on the field
};

struct FeatureOptions {
    /// A sharp edge runs through a cell if two normals of it have an inner product below this.
    double theta_sharp = 0.9;
    /// A corner lies in it if some normal leans out of the plane of those two by a sine above this.
    double phi_corner = 0.7;
};

/// The point where the tangent planes of a cell with a sharp edge or corner meet; none where the
/// normals lie in one cone. Least squares with the smallest singular value taken as zero along an
/// edge, so the point on the edge nearest to the mean of the elements.
///
/// Implements [kobbelt2001], section 4.
std::optional<Vec3> feature_point(std::span<const TangentElement> elements,
                                  const FeatureOptions& options = {});

/// How far from its cell a feature may be.
enum class FeatureRoom {
    Near,   // a quarter of the cell
    Inside  // within it, off its faces by a 64th
};

/// The same, moved by Newton's method onto the crossing of those smooth pieces of the field that
/// the elements lie on: an edge of a tree of quadrics is met to the last digits. Stays within the
/// `room`: of an edge that is where it is nearest to the elements, or where it leaves the cell. If
/// the pieces do not cross there, it is the point of the tangent planes, moved to the cell.
std::optional<Vec3> feature_vertex(const Implicit& field, double level,
                                   std::span<const TangentElement> elements, const Box3& cell,
                                   const FeatureOptions& options = {},
                                   FeatureRoom room = FeatureRoom::Near);

}  // namespace genus
