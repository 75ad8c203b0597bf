#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "genus/base/linear_solve.h"
#include "genus/deform/ffd.h"

namespace genus {

/// A wish put to a lattice: the point goes to `target`; with a direction, the directional
/// derivative of the map there becomes `target`. A point with itself as target stays.
struct FfdConstraint {
    Vec3 point;
    Vec3 target;
    double weight = 1.0;            // of its error, in least squares
    std::optional<Vec3> direction;  // model units
};

struct FfdFitOptions {
    /// Weight of the squared moves of the control points beside the squared errors; 0 for none.
    /// Positive, it makes badly conditioned wishes harmless, which are then met approximately.
    double regularisation = 0.0;
    /// Leaves the outer k + 1 layers in place, so that the result is C^k across the border; -1
    /// moves all.
    int keep_border = -1;
    /// See LinearSolver.
    double rank_tolerance = 0.0;
    /// A wish counts as met if its error is below this times the size of the lattice.
    double met = 1e-10;
};

struct FfdFit {
    Lattice lattice;
    SolutionKind kind;
    std::size_t rank;
    double condition;
    std::vector<double> residuals;  // of each constraint, distance in model units, unweighted
    double largest_residual;
    double moved;                    // root of the sum of squared moves of control points
    std::vector<std::size_t> unmet;  // constraints with a residual that counts
    /// Pairs of constraints on the same point that ask for different things.
    std::vector<std::pair<std::size_t, std::size_t>> contradictions;
    /// One line: kind, rank, condition, residual, and the first contradiction.
    std::string summary() const;
};

/// Inverse free-form deformation: the moves of the control points that take given points to given
/// places, by complete orthogonal decomposition: least squares when the wishes are too many, the
/// smallest moves when they are too few, both when they depend on one another.
///
/// Construction factors the matrix of lattice weights, O(c^2 n) for c constraints on n control
/// points; `solve` for new targets costs one back-substitution, O(c n), which is what dragging one
/// point needs.
///
/// Implements [hsu1992]. Departs from it: no pseudo-inverse is formed, and no normal equations.
class InverseFfd {
public:
    /// Adds to the moves that `lattice` has already. Throws InvalidInput if there are no
    /// constraints, one is outside the lattice or not finite, a weight is not positive, or all
    /// control points are kept.
    InverseFfd(Lattice lattice, std::vector<FfdConstraint> constraints,
               const FfdFitOptions& options = {});

    /// For the targets given with the constraints, or for others, one for each.
    FfdFit solve() const;
    FfdFit solve(std::span<const Vec3> targets) const;

private:
    std::vector<double> right_side(std::span<const Vec3> targets) const;
    Vec3 current(const FfdConstraint& c, const Lattice& lattice) const;

    Lattice lattice_;
    std::vector<FfdConstraint> constraints_;
    FfdFitOptions options_;
    std::vector<std::size_t> free_;  // control points that may move
    bool wide_ = false;
    std::size_t solver_rows_ = 0;
    std::optional<LinearSolver> plain_, solver_;  // without and with regularisation
};

/// InverseFfd for one set of targets.
FfdFit fit_lattice(const Lattice& lattice, std::vector<FfdConstraint> constraints,
                   const FfdFitOptions& options = {});

}  // namespace genus
