#pragma once

#include <span>
#include <vector>

#include "genus/model/csg_field.h"

namespace genus {

// Exact questions to a solid, answered without a mesh. Those that take a Solid build its field
// once; for many calls build a CsgField and keep it. All throw InvalidInput as CsgField does; those
// that take a Solid answer for every tree, with the help of meshes where there is no formula: see
// solid_field.h.

/// 1 where the point belongs to the solid, its border included, else 0. Parallel over points.
std::vector<char> contains(const Implicit& field, std::span<const Vec3> points);
std::vector<char> contains(const Solid& solid, std::span<const Vec3> points);

/// F at the points.
std::vector<double> values(const Implicit& field, std::span<const Vec3> points);
std::vector<double> values(const Solid& solid, std::span<const Vec3> points);
/// Gradients of F at the points.
std::vector<Vec3> gradients(const Implicit& field, std::span<const Vec3> points);
std::vector<Vec3> gradients(const Solid& solid, std::span<const Vec3> points);

/// Where a ray goes into or out of a solid.
struct SolidHit {
    double t;  // the point is origin + t direction
    Vec3 point;
    Vec3 normal;           // outward, length 1
    std::int32_t surface;  // number in the field
    bool entering;
    /// Of the primitive whose surface it is, as leaves_of counts; -1 from a field, which knows
    /// none.
    std::int32_t leaf = -1;
};

/// All entries and exits along the ray t >= 0, in order; entries and exits alternate. A ray that
/// starts inside begins with an exit, one that ends inside has no last exit; touching from outside
/// is no hit. Throws InvalidInput if the direction is zero or a number is not finite.
/// O(n^2) for n surfaces that the ray meets. Where primitives share a surface, as a pin and its
/// hole, the hit is of the one that makes the difference there.
///
/// Implements [roth1982], classification of a ray against a tree.
std::vector<SolidHit> ray_cast(const CsgField& field, const Vec3& origin, const Vec3& direction);
std::vector<SolidHit> ray_cast(const Solid& solid, const Vec3& origin, const Vec3& direction);
/// One list a ray; as many origins as directions. Parallel over rays.
std::vector<std::vector<SolidHit>> ray_cast(const CsgField& field, std::span<const Vec3> origins,
                                            std::span<const Vec3> directions);
std::vector<std::vector<SolidHit>> ray_cast(const Solid& solid, std::span<const Vec3> origins,
                                            std::span<const Vec3> directions);

/// A box that is proven to hold the solid: its bounds, or where these have infinite sides a cube
/// outside of which interval bounds show the function to be positive in every direction.
/// Throws UnboundedSolid naming the leaf that reaches to infinity and a direction it does so in.
Box3 require_bounded(const Solid& solid);

/// The bounding box to within `tolerance` on each side, never too small: by branch and bound over
/// cells of the box known so far. Where that takes more than 20,000 cells a side the best box so
/// far is returned. Empty if the solid is shown to be. Throws as require_bounded, and InvalidInput
/// for a tolerance that is not positive.
Box3 tight_bounds(const Solid& solid, double tolerance);

}  // namespace genus
