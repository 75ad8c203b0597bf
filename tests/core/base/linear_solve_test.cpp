#include "genus/base/linear_solve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "genus/base/error.h"

namespace genus {
namespace {

using Numbers = std::vector<double>;

struct Dense {
    std::size_t rows, cols;
    Numbers a;
    double operator()(std::size_t i, std::size_t j) const { return a[i * cols + j]; }
};

Dense random_matrix(std::mt19937& random, std::size_t rows, std::size_t cols)
{
    std::normal_distribution<double> number;
    Dense m{rows, cols, Numbers(rows * cols)};
    for (double& x : m.a) x = number(random);
    return m;
}

Dense product(const Dense& a, const Dense& b)
{
    Dense c{a.rows, b.cols, Numbers(a.rows * b.cols)};
    for (std::size_t i = 0; i < a.rows; ++i)
        for (std::size_t k = 0; k < a.cols; ++k)
            for (std::size_t j = 0; j < b.cols; ++j) c.a[i * b.cols + j] += a(i, k) * b(k, j);
    return c;
}

Numbers times(const Dense& a, const Numbers& x)
{
    return product(a, {x.size(), 1, x}).a;
}

Dense transposed(const Dense& a)
{
    Dense t{a.cols, a.rows, Numbers(a.a.size())};
    for (std::size_t i = 0; i < a.rows; ++i)
        for (std::size_t j = 0; j < a.cols; ++j) t.a[j * a.rows + i] = a(i, j);
    return t;
}

double norm(const Numbers& v)
{
    double sum = 0.0;
    for (const double x : v) sum += x * x;
    return std::sqrt(sum);
}

Numbers residual(const Dense& a, const Numbers& x, Numbers b)
{
    const Numbers ax = times(a, x);
    for (std::size_t i = 0; i < b.size(); ++i) b[i] -= ax[i];
    return b;
}

// The pseudo-inverse is characterised by: the residual is orthogonal to the columns, and the
// solution is a combination of the rows.
void expect_pseudo_inverse(const Dense& a, const Numbers& b, const Numbers& x, double tolerance)
{
    EXPECT_LE(norm(times(transposed(a), residual(a, x, b))), tolerance * norm(b));
    const Dense at = transposed(a);
    const LinearSolver rows_span(at.rows, at.cols, at.a);
    EXPECT_LE(norm(residual(at, rows_span.solve(x), x)), tolerance * norm(x));
}

TEST(LinearSolver, GivesThePseudoInverseForEveryShapeAndRank)
{
    std::mt19937 random(31);
    for (const auto& [m, n, r] : {std::array<std::size_t, 3>{7, 7, 7},
                                  {12, 5, 5},
                                  {5, 12, 5},
                                  {12, 5, 3},
                                  {5, 12, 3},
                                  {9, 9, 4},
                                  {1, 6, 1},
                                  {6, 1, 1},
                                  {60, 40, 25}}) {
        SCOPED_TRACE(testing::Message() << m << "x" << n << " rank " << r);
        const Dense a = product(random_matrix(random, m, r), random_matrix(random, r, n));
        const LinearSolver solver(m, n, a.a, 1e-12);
        EXPECT_EQ(solver.rank(), r);
        const auto kind = solver.kind();
        EXPECT_EQ(kind, r == m && r == n ? SolutionKind::Unique
                        : r == n         ? SolutionKind::LeastSquares
                        : r == m         ? SolutionKind::LeastNorm
                                         : SolutionKind::LeastSquaresLeastNorm);
        const Numbers b = random_matrix(random, m, 1).a;
        expect_pseudo_inverse(a, b, solver.solve(b), 1e-10);
    }
}

TEST(LinearSolver, SolvesManyRightSidesAsItSolvesOne)
{
    std::mt19937 random(32);
    for (const auto& [m, n] : {std::pair<std::size_t, std::size_t>{8, 5}, {5, 8}}) {
        const Dense a = random_matrix(random, m, n), b = random_matrix(random, m, 3);
        const LinearSolver solver(m, n, a.a);
        const Numbers all = solver.solve(b.a, 3);
        for (std::size_t k = 0; k < 3; ++k) {
            Numbers one(m);
            for (std::size_t i = 0; i < m; ++i) one[i] = b(i, k);
            const Numbers x = solver.solve(one);
            for (std::size_t j = 0; j < n; ++j) EXPECT_NEAR(all[j * 3 + k], x[j], 1e-13);
        }
    }
}

TEST(LinearSolver, ConditionAgreesWithSingularValues)
{
    std::mt19937 random(33);
    for (int trial = 0; trial < 50; ++trial) {
        Dense a = random_matrix(random, 10, 6);
        for (std::size_t i = 0; i < 10; ++i)
            for (std::size_t j = 0; j < 6; ++j) a.a[i * 6 + j] *= std::pow(10.0, -1.5 * double(j));
        const Numbers s = singular_values(10, 6, a.a);
        const LinearSolver solver(10, 6, a.a);
        EXPECT_LE(solver.condition(), 1.0000001 * s.front() / s.back());
        EXPECT_GE(solver.condition(), 0.8 * s.front() / s.back());
    }
}

// Where the normal equations lose half of the digits: columns that differ by 1e-9.
TEST(LinearSolver, KeepsTheDigitsThatNormalEquationsLose)
{
    const double e = 1e-9;
    const Dense a{3, 2, {1, 1, e, 0, 0, e}};
    const LinearSolver solver(3, 2, a.a);
    EXPECT_EQ(solver.rank(), 2u);
    const Numbers b = {2, e, e};  // x = (1, 1)
    const Numbers x = solver.solve(b);
    EXPECT_NEAR(x[0], 1.0, 1e-6);
    EXPECT_NEAR(x[1], 1.0, 1e-6);
    EXPECT_LE(norm(residual(a, x, b)), 1e-15);
}

TEST(LinearSolver, ZeroMatrixHasRankZeroAndSolutionZero)
{
    const LinearSolver solver(2, 3, Numbers(6));
    EXPECT_EQ(solver.rank(), 0u);
    EXPECT_EQ(solver.solve(Numbers{1, 2}), Numbers(3));
    EXPECT_TRUE(std::isinf(solver.condition()));
}

TEST(LinearSolver, RefusesWrongSizesAndNumbers)
{
    EXPECT_THROW(LinearSolver(0, 3, Numbers{}), InvalidInput);
    EXPECT_THROW(LinearSolver(2, 2, Numbers(3)), InvalidInput);
    EXPECT_THROW(LinearSolver(std::size_t{1} << 40, std::size_t{1} << 40, Numbers{}), InvalidInput);
    EXPECT_THROW(LinearSolver(1, 1, Numbers{std::nan("")}), InvalidInput);
    EXPECT_THROW(LinearSolver(1, 1, Numbers{1.0}, 2.0), InvalidInput);
    const LinearSolver solver(1, 1, Numbers{2.0});
    EXPECT_THROW(solver.solve(Numbers{1, 2}), InvalidInput);
    EXPECT_THROW(solver.solve(Numbers{std::numeric_limits<double>::infinity()}), InvalidInput);
}

}  // namespace
}  // namespace genus
