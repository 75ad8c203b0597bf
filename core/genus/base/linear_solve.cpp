#include "genus/base/linear_solve.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

#include "genus/base/error.h"

namespace genus {

namespace {

using Matrix = Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Decomposition = Eigen::CompleteOrthogonalDecomposition<Matrix>;

// Together with the finiteness check this keeps a size taken from outside from overflowing.
constexpr std::size_t kMaxEntries = std::size_t{1} << 31;

Eigen::Index index(std::size_t i)
{
    return static_cast<Eigen::Index>(i);
}

Eigen::Map<const RowMajor> checked_map(const char* what, std::size_t rows, std::size_t cols,
                                       std::span<const double> a)
{
    const bool fits = rows > 0 && cols > 0 && rows <= kMaxEntries / cols;
    require(fits && a.size() == rows * cols, what);
    for (const double x : a) require(std::isfinite(x), what, x, "finite");
    return Eigen::Map<const RowMajor>(a.data(), index(rows), index(cols));
}

// The largest singular value of the upper triangle T, or of its inverse, by power iteration on
// T^T T. Starts from a vector without symmetry, so that no singular vector is missed by accident.
double triangle_norm(const Matrix& t, bool inverse)
{
    const auto upper = t.triangularView<Eigen::Upper>();
    Eigen::VectorXd v(t.cols());
    for (Eigen::Index i = 0; i < v.size(); ++i)
        v[i] = 1.0 + 0.37 * std::fmod(0.618 * double(i), 1.0);
    double sigma = 0.0;
    for (int step = 0; step < 30; ++step) {
        v /= v.norm();
        if (inverse) {
            Eigen::VectorXd w = upper.transpose().solve(v);
            v = upper.solve(w);
        } else {
            const Eigen::VectorXd w = upper * v;
            v = upper.transpose() * w;
        }
        const double next = std::sqrt(v.norm());
        if (!std::isfinite(next) || next == 0.0) return next;
        if (std::fabs(next - sigma) <= 1e-3 * next) return next;
        sigma = next;
    }
    return sigma;
}

double condition_of(const Decomposition& d)
{
    const Eigen::Index r = d.rank();
    if (r == 0) return std::numeric_limits<double>::infinity();
    const Matrix t = d.matrixT().topLeftCorner(r, r).triangularView<Eigen::Upper>();
    return triangle_norm(t, false) * triangle_norm(t, true);
}

}  // namespace

struct LinearSolver::Factors {
    bool transposed = false;
    Decomposition decomposition;
};

LinearSolver::LinearSolver(std::size_t rows, std::size_t cols, std::span<const double> a,
                           double rank_tolerance)
    : rows_(rows), cols_(cols), factors_(std::make_unique<Factors>())
{
    const auto matrix = checked_map("LinearSolver: matrix", rows, cols, a);
    require(rank_tolerance >= 0.0 && rank_tolerance < 1.0, "LinearSolver: rank_tolerance",
            rank_tolerance, "in [0, 1)");
    auto& d = factors_->decomposition;
    d.setThreshold(rank_tolerance > 0.0 ? rank_tolerance
                                        : static_cast<double>(std::max(rows, cols)) *
                                              std::numeric_limits<double>::epsilon());
    factors_->transposed = rows < cols;
    if (factors_->transposed)
        d.compute(matrix.transpose());
    else
        d.compute(matrix);
    rank_ = static_cast<std::size_t>(d.rank());
    condition_ = condition_of(d);
}

LinearSolver::~LinearSolver() = default;
LinearSolver::LinearSolver(LinearSolver&&) noexcept = default;
LinearSolver& LinearSolver::operator=(LinearSolver&&) noexcept = default;

SolutionKind LinearSolver::kind() const
{
    if (rank_ == rows_ && rank_ == cols_) return SolutionKind::Unique;
    if (rank_ == cols_) return SolutionKind::LeastSquares;
    if (rank_ == rows_) return SolutionKind::LeastNorm;
    return SolutionKind::LeastSquaresLeastNorm;
}

std::vector<double> LinearSolver::solve(std::span<const double> b, std::size_t n) const
{
    const auto right = checked_map("LinearSolver::solve: right side", rows_, n, b);
    std::vector<double> x(cols_ * n);
    if (rank_ == 0) return x;
    Eigen::Map<RowMajor> result(x.data(), index(cols_), index(n));
    const auto& d = factors_->decomposition;
    if (factors_->transposed)
        result = d.transpose().solve(right);
    else
        result = d.solve(right);
    return x;
}

std::vector<double> singular_values(std::size_t rows, std::size_t cols, std::span<const double> a)
{
    const Matrix matrix = checked_map("singular_values: matrix", rows, cols, a);
    const Eigen::JacobiSVD<Matrix> svd(matrix);
    const auto& s = svd.singularValues();
    return std::vector<double>(s.data(), s.data() + s.size());
}

const char* to_text(SolutionKind kind)
{
    switch (kind) {
        case SolutionKind::Unique:
            return "unique";
        case SolutionKind::LeastSquares:
            return "least squares";
        case SolutionKind::LeastNorm:
            return "least norm";
        case SolutionKind::LeastSquaresLeastNorm:
            break;
    }
    return "least squares and least norm";
}

}  // namespace genus
