#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "genus/base/vec.h"
#include "genus/volume/grid.h"

namespace genus {

/// Where the samples of a flat grid stand: sample (i, j) at origin + (i, j) * spacing.
struct SquareFrame {
    Vec2 origin{};
    Vec2 spacing{{1.0, 1.0}};
};

struct MarchingSquaresOptions {
    double level = 0.0;
    /// Close the lines along the border of the grid, as if everything beyond were outside; else
    /// they end there.
    bool close_border = false;
    SampleOrder order = SampleOrder::FirstFastest;
};

struct Contour {
    std::vector<Vec2> points;  // of a closed one the first does not come again at the end
    bool closed = false;
    bool operator==(const Contour&) const = default;
};

/// The lines on which samples of a plane, interpolated linearly along grid edges, reach a level,
/// with the smaller values on their left. A value equal to the level counts as greater. In a square
/// with smaller values on one diagonal and greater ones on the other the bilinear interpolant
/// decides, exactly. So no two lines cross, every line is closed or ends on the border, and with
/// `close_border` all are closed. Lines come in the order of their first sample, row by row;
/// where one passes a sample it has equal points.
///
/// Values need not be finite: whatever is not below the level is outside. O(samples).
///
/// Implements [lorensen1987] in the plane; ambiguous squares as in [nielson1991], section 3.
/// Throws InvalidInput unless `size` has two samples or more along both axes, `values` as many as
/// that says, the spacing is positive and the level finite.
std::vector<Contour> marching_squares(std::span<const float> values,
                                      const std::array<std::int32_t, 2>& size,
                                      const SquareFrame& frame = {},
                                      const MarchingSquaresOptions& options = {});
std::vector<Contour> marching_squares(std::span<const double> values,
                                      const std::array<std::int32_t, 2>& size,
                                      const SquareFrame& frame = {},
                                      const MarchingSquaresOptions& options = {});

}  // namespace genus
