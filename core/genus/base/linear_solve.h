#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace genus {

/// How many solutions a linear system has.
enum class SolutionKind {
    Unique,                ///< as many independent equations as unknowns
    LeastSquares,          ///< more equations than unknowns, columns independent
    LeastNorm,             ///< fewer equations than unknowns, rows independent
    LeastSquaresLeastNorm  ///< neither rows nor columns are independent
};

/// "unique", "least squares", "least norm", "least squares and least norm".
const char* to_text(SolutionKind kind);

/// A real matrix factored once to solve A x = b in the least-squares sense for many right sides.
/// Of all minimisers the shortest is taken, x = A^+ b.
///
/// Orthogonal factors only, never the normal equations, so that the residual of a consistent
/// system stays at rounding level up to conditions of 1/epsilon. Factoring costs
/// O(rows cols min(rows, cols)), each right side O(rows cols). Results do not depend on threads.
///
/// Implements [golub2013], sections 5.4 and 5.5 (complete orthogonal decomposition).
/// Departs from it: a wide matrix is factored as its transpose, which makes the second set of
/// reflections empty whenever the rows are independent.
class LinearSolver {
public:
    /// `a` holds the matrix row by row. A pivot below `rank_tolerance` times the largest counts as
    /// zero; 0 means max(rows, cols) epsilon.
    /// Throws InvalidInput if sizes do not fit, a side is 0, or an entry is not finite.
    LinearSolver(std::size_t rows, std::size_t cols, std::span<const double> a,
                 double rank_tolerance = 0.0);
    ~LinearSolver();
    LinearSolver(LinearSolver&&) noexcept;
    LinearSolver& operator=(LinearSolver&&) noexcept;

    std::size_t rows() const { return rows_; }
    std::size_t cols() const { return cols_; }
    std::size_t rank() const { return rank_; }
    SolutionKind kind() const;
    /// Largest over smallest singular value among the `rank()` that count. Found by power
    /// iteration, to a few per cent and never above the truth; infinity for rank 0.
    double condition() const { return condition_; }

    /// Solves for `n` right sides at once. `b` is rows x n and the result cols x n, row by row.
    /// Throws InvalidInput if `b` has another size or an entry that is not finite.
    std::vector<double> solve(std::span<const double> b, std::size_t n = 1) const;

private:
    struct Factors;

    std::size_t rows_ = 0, cols_ = 0, rank_ = 0;
    double condition_ = 0.0;
    std::unique_ptr<Factors> factors_;
};

/// Singular values, largest first, of a matrix given row by row. O(rows cols min(rows, cols)),
/// meant for small ones. Throws as LinearSolver does.
std::vector<double> singular_values(std::size_t rows, std::size_t cols, std::span<const double> a);

}  // namespace genus
