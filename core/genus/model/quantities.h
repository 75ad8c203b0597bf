#pragma once

#include <cstdint>
#include <optional>

#include "genus/model/solid.h"

namespace genus {

/// A number and how far it may be from the truth: the exact one is in [value - bound,
/// value + bound].
struct BoundedValue {
    double value = 0.0;
    double bound = 0.0;
    /// True if `bound` is proven, rounding included; false if it is estimated.
    bool certified = true;
};

struct QuantityOptions {
    /// Largest bound, cubic or square model units.
    std::optional<double> tolerance;
    /// The same as a share of the value, or of a millionth of what the bounding box has where that
    /// is more. 1e-6 if neither is given; with both, each holds.
    std::optional<double> relative;
    /// Give up with ToleranceNotMet before more cells than this are looked at.
    std::int64_t max_cells = 3'000'000;
};

/// Volume of a solid, and area of its surface (of the closure of its inside: where two parts share
/// a wall there is none), without a mesh.
///
/// A parallelepiped round the solid, askew to it, of the shape of its bounding box or near a cube,
/// whichever comes to an end sooner, is halved along all axes until each cell is settled: no
/// surface decides in it, or it is integrated (see cell_integral.h) with an error that is proven.
/// Cells in which surfaces touch, or a cone has its apex, stay unsettled at every size; there are
/// few, and what they hold is small at last, of area too, because a line meets a quadric twice at
/// most and a torus four times. So the cost grows with a power of log(1 / tolerance), unless
/// surfaces touch along whole curves. Any number of threads gives the same bits.
///
/// Trees of polyhedra with many faces, with polyhedra that are not convex, or with leaves that are
/// no polynomials are measured on their mesh: the bound is then estimated unless nothing is curved
/// and no coordinate was rounded.
///
/// Throws InvalidInput for a tolerance that is not positive, UnboundedSolid, and ToleranceNotMet
/// with what was reached and where.
BoundedValue volume(const Solid& solid, const QuantityOptions& options = {});
BoundedValue area(const Solid& solid, const QuantityOptions& options = {});

}  // namespace genus
