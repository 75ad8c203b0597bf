#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "genus/model/local_form.h"

namespace genus {

enum class Quantity { Volume, Area };

/// What a solid does in a cell: the surfaces that decide there, and whether a point is inside, bit
/// b of `inside` for the point outside of just those surfaces i (F > 0) with bit i of b set.
struct CellSolid {
    static constexpr std::size_t kMostSurfaces = 6;
    std::vector<LocalForm> forms;
    std::uint64_t inside = 0;
};

/// An integral over a cell and how far it may be from the truth.
struct CellIntegral {
    double value = 0.0;
    double error = 0.0;
};

/// Volume of a solid in the cell [-1, 1]^3, or the area of its surface there, each piece of which
/// counts |C g| / |g_z| over the x and y of the cell, where g is the gradient and C has the given
/// columns. Nothing if the surfaces are too curved or too many in the cell for a proof: then it is
/// to be cut.
///
/// Of the three axes one is found along which every surface is a graph over the two others, and of
/// these one so that the curves where graphs meet each other or leave the cell are graphs in turn.
/// Between the places where such curves cross, everything is an iterated integral of one analytic
/// function. Gauss rules of as many points as `error` asks for are applied to it, at most 20; what
/// they leave is bounded by the size of the function on an ellipse about the interval. Rounding,
/// and places not known better than to rounding, are added to the error, so it may exceed what was
/// asked for.
///
/// Implements [saye2015], section 2 (one axis after the other, pieces between roots), with the
/// error of Gauss rules from [trefethen2013], theorem 8.2.
std::optional<CellIntegral> integrate_cell(const CellSolid& solid, Quantity quantity,
                                           const std::array<Vec3, 3>& columns, double error);

}  // namespace genus
