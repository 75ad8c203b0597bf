#pragma once

#include <cstdint>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

struct DistanceOptions {
    /// Samples by unit of area, one random point each of equal cells, beside all vertices. Zero:
    /// so many that there are about 100,000 on each mesh.
    double density = 0.0;
    /// How far `bound` may exceed the largest distance, relatively; zero: no bound is sought.
    double precision = 0.01;
    /// A bound of this or less, in model units, is tight enough whatever the largest distance:
    /// surfaces that lie in each other need not be told apart to the last bit.
    double sufficient = 0.0;
    /// Whether the mean is wanted: without it much less is computed of points that are nearer than
    /// others.
    bool mean = true;
    /// Pieces looked at for the bound before it is left as loose as it is.
    std::int64_t max_pieces = 20'000'000;
};

/// How far the points of one surface are from another, model units.
struct OneSidedDistance {
    /// Largest distance of the sampled points and all vertices: never above the true one.
    double max = 0.0;
    /// Mean over the surface, by area, of the sampled points; zero if it was not wanted.
    double mean = 0.0;
    /// No point of the surface is farther away than this, up to rounding of the distances
    /// themselves (some 1e-15 of the coordinates). Infinity if no bound was sought.
    double bound = 0.0;
    std::int64_t samples = 0;
    /// A point with the distance `max`.
    Vec3 where;
};

struct MeshDistance {
    OneSidedDistance a_to_b, b_to_a;
    /// Of both directions the larger: `max` <= Hausdorff distance <= `bound`.
    double max = 0.0;
    double mean = 0.0;
    double bound = 0.0;
};

/// Distance from the surface of `a` to that of `b` as point sets, whatever their orientation.
///
/// The bound comes from branch and bound over the faces of `a`: a triangle is no farther from `b`
/// than its farthest corner is from any one face of `b`, for the distance to a convex set is a
/// convex function; where that exceeds the largest distance known by more than `precision`, the
/// triangle is split in four.
///
/// Deterministic at any thread count. Throws InvalidInput if one of the meshes has no faces while
/// the other has some, a face names a vertex that is not there, a coordinate is not finite, or an
/// option is negative. Two meshes without faces are at distance zero.
///
/// Implements [tang2009], section 4 (bounds by triangles), with nearest faces found by a box tree.
MeshDistance mesh_distance(const IndexedMesh& a, const IndexedMesh& b,
                           const DistanceOptions& options = {});

/// The same, one way only.
OneSidedDistance one_sided_distance(const IndexedMesh& from, const IndexedMesh& to,
                                    const DistanceOptions& options = {});

}  // namespace genus
