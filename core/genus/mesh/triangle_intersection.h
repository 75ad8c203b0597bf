#pragma once

#include <array>

#include "genus/base/vec.h"

namespace genus {

using TrianglePoints = std::array<Vec3, 3>;

/// What two closed triangles have in common. Corners are shared if their coordinates are equal.
enum class TriangleContact {
    Disjoint,
    SharedCorner,  ///< one corner of both, nothing else
    SharedSide,    ///< one side of both, nothing else
    Crossing,      ///< anything more: a cut, a touch elsewhere, an overlap in one plane
    Degenerate     ///< one of them has no area: nothing is said
};

/// Exact for coordinates as `orient3d` demands; no tolerance. Two triangles with the same three
/// corners are Crossing.
///
/// Implements [guigue2003] in part: the planes settle most pairs, by orientation predicates only.
/// The rest is decided side against triangle, since contacts in shared corners are legal here.
TriangleContact triangle_contact(const TrianglePoints& a, const TrianglePoints& b);

/// True if all three corners lie on one line, exactly.
bool has_no_area(const TrianglePoints& t);

}  // namespace genus
