#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "genus/base/vec.h"

namespace genus {

/// A tunnel through a cell: two loops of its case bound one surface instead of a disc each.
struct CellTunnel {
    std::array<std::uint8_t, 2> edges;  // a cube edge on each of the two loops
    /// Points of the trilinear surface round the narrowest part, in order, in the unit cube.
    std::array<Vec3, 4> waist;
};

/// The tunnel that the trilinear interpolant of the values at the corners of a cell has where they
/// are negative inside, if it has one. A tie is decided as if all values were a trifle larger, so
/// that zero counts as outside, as on faces. A tunnel joins inside corners that
/// are apart on all faces, or outside corners; there is never more than one.
///
/// In the slice at height t the interpolant is bilinear, with corner values a, b, c, d round the
/// slice that are linear in t. While a, c are on one side and b, d on the other, a c - b d tells
/// which pair is joined. A tunnel is where the pair that is apart at both ends of such a stretch
/// is joined between: the quadratic has two roots there. Decided exactly as long as the values,
/// zeros apart, lie within a factor of 2^200 of each other.
///
/// Implements [chernyaev1995], section 4 (test of the interior), with exact signs instead of a
/// look at one slice.
std::optional<CellTunnel> cell_tunnel(const std::array<double, 8>& values);

}  // namespace genus
