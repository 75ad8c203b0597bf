#pragma once

#include <array>
#include <span>
#include <vector>

#include "genus/base/vec.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus::exact {

/// Makes coordinates equal that differ from an axis-parallel face by the rounding of earlier
/// computations only: values within `reach`, by axis, of the plane of such a face become that of
/// the lowest plane there. So 0.1 * 3 + 0.1 meets 0.1 * 4, and parts that were meant to touch do.
/// Returns for each point how far it moved, as the largest of its three coordinates; nothing where
/// none could.
///
/// Equal values move alike, so corners at one place stay at one place and axis-parallel planes
/// stay planes. O(n log planes); the result does not depend on the order of points.
std::vector<double> merge_close_coordinates(std::span<Vec3> points, std::span<const Triangle> faces,
                                            const Vec3& reach);

}  // namespace genus::exact
