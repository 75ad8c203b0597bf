#include "genus/deform/inverse_ffd.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/patch/reference.h"
#include "genus/base/error.h"

namespace genus {
namespace {

using reference::random_points;
using reference::random_vec;

const Lattice kCube = Lattice::over({{{-1, -1, -1}}, {{1, 1, 1}}}, {3, 3, 3});

Lattice cube(int degree)
{
    return Lattice::over({{{-1, -1, -1}}, {{1, 1, 1}}}, {degree, degree, degree});
}

std::vector<FfdConstraint> random_constraints(std::mt19937_64& random, int n)
{
    std::vector<FfdConstraint> c;
    for (int i = 0; i < n; ++i) {
        const Vec3 p = random_vec(random, 0.95);
        c.push_back({p, p + random_vec(random, 0.3), 1.0, std::nullopt});
    }
    return c;
}

double sum_of_squares(const std::vector<double>& r)
{
    double s = 0.0;
    for (const double x : r) s += x * x;
    return s;
}

TEST(InverseFfd, MeetsTooFewWishesWithTheSmallestMoves)
{
    std::mt19937_64 random(131);
    for (const int degree : {2, 3, 7, 20}) {
        const auto wishes = random_constraints(random, 8);
        const FfdFit fit = fit_lattice(cube(degree), wishes);
        EXPECT_EQ(fit.kind, SolutionKind::LeastNorm);
        EXPECT_EQ(fit.rank, 8u);
        EXPECT_LE(fit.largest_residual, 1e-10) << degree;
        EXPECT_TRUE(fit.unmet.empty());
        EXPECT_TRUE(fit.contradictions.empty());
        for (const auto& w : wishes)
            EXPECT_LE(distance(fit.lattice.apply(w.point), w.target), 1e-10);
        // Smallest: the moves are combinations of the rows, so moving along anything that the
        // constraints do not see only lengthens them. Adding such a part must not shorten.
        auto other = fit.lattice.moves();
        for (Vec3& d : other) d += random_vec(random, 0.01);
        Lattice moved = fit.lattice;
        moved.set_moves(other);
        std::vector<FfdConstraint> back;
        for (const auto& w : wishes) back.push_back({w.point, w.target, 1.0, std::nullopt});
        const FfdFit repaired = fit_lattice(moved, back);
        double length = 0.0;
        for (const Vec3& d : repaired.lattice.moves()) length += dot(d, d);
        EXPECT_GE(std::sqrt(length), fit.moved * (1.0 - 1e-9));
    }
}

TEST(InverseFfd, MeetsTooManyWishesInTheLeastSquaresSense)
{
    std::mt19937_64 random(132);
    const auto wishes = random_constraints(random, 200);
    const FfdFit fit = fit_lattice(kCube, wishes);
    EXPECT_EQ(fit.kind, SolutionKind::LeastSquares);
    EXPECT_EQ(fit.rank, 64u);
    EXPECT_FALSE(fit.unmet.empty());
    const double best = sum_of_squares(fit.residuals);
    for (int trial = 0; trial < 100; ++trial) {
        Lattice other = fit.lattice;
        auto moves = other.moves();
        moves[random() % moves.size()] += random_vec(random, 1e-3);
        other.set_moves(moves);
        double sum = 0.0;
        for (const auto& w : wishes) sum += std::pow(distance(other.apply(w.point), w.target), 2);
        EXPECT_GE(sum, best);
    }
}

TEST(InverseFfd, FindsADeformationThatIsThere)
{
    std::mt19937_64 random(133);
    Lattice truth = kCube;
    truth.set_moves(random_points(random, 64, 0.2));
    std::vector<FfdConstraint> wishes;
    for (int i = 0; i < 150; ++i) {
        const Vec3 p = random_vec(random, 1.0);
        wishes.push_back({p, truth.apply(p), 1.0, std::nullopt});
    }
    const FfdFit fit = fit_lattice(kCube, wishes);
    EXPECT_LE(fit.largest_residual, 1e-12);
    for (std::size_t i = 0; i < 64; ++i)
        EXPECT_LE(distance(fit.lattice.moves()[i], truth.moves()[i]), 1e-13 * fit.condition);
}

TEST(InverseFfd, NamesContradictionsAndTakesTheirMean)
{
    std::mt19937_64 random(134);
    auto wishes = random_constraints(random, 5);
    wishes.push_back({wishes[2].point, wishes[2].target + Vec3{{0.2, 0, 0}}, 1.0, std::nullopt});
    const FfdFit fit = fit_lattice(kCube, wishes);
    EXPECT_EQ(fit.kind, SolutionKind::LeastSquaresLeastNorm);
    EXPECT_EQ(fit.rank, 5u);
    ASSERT_EQ(fit.contradictions.size(), 1u);
    EXPECT_EQ(fit.contradictions[0], std::pair(std::size_t{2}, std::size_t{5}));
    EXPECT_EQ(fit.unmet, (std::vector<std::size_t>{2, 5}));
    EXPECT_NEAR(fit.residuals[2], 0.1, 1e-12);
    EXPECT_NEAR(fit.residuals[5], 0.1, 1e-12);
    EXPECT_NE(fit.summary().find("2 and 5 contradict"), std::string::npos);
    // The same wish twice is no contradiction, but it lowers the rank.
    auto twice = random_constraints(random, 4);
    twice.push_back(twice[1]);
    const FfdFit agreed = fit_lattice(kCube, twice);
    EXPECT_EQ(agreed.rank, 4u);
    EXPECT_TRUE(agreed.contradictions.empty());
    EXPECT_LE(agreed.largest_residual, 1e-12);
}

TEST(InverseFfd, WeightsDrawTheCompromise)
{
    const Vec3 p{{0.1, 0.2, 0.3}};
    const std::vector<FfdConstraint> wishes = {{p, p, 3.0, std::nullopt},
                                               {p, p + Vec3{{1, 0, 0}}, 1.0, std::nullopt}};
    // Weighted mean with squares 9 and 1.
    EXPECT_NEAR(fit_lattice(kCube, wishes).residuals[0], 0.1, 1e-12);
}

TEST(InverseFfd, DirectionsAndFixedPointsAreMet)
{
    std::mt19937_64 random(135);
    const Vec3 p{{0.2, -0.3, 0.1}};
    std::vector<FfdConstraint> wishes = {
        {p, p, 1.0, std::nullopt},
        {p, {{0, 1, 0}}, 1.0, Vec3{{1, 0, 0}}},  // the x direction turns to y
        {{{-0.5, 0.5, 0.5}}, {{-0.5, 0.5, 0.9}}, 1.0, std::nullopt}};
    const FfdFit fit = fit_lattice(cube(5), wishes);
    EXPECT_LE(distance(fit.lattice.apply(p), p), 1e-12);
    EXPECT_LE(distance(fit.lattice.jacobian(p)[0], {{0, 1, 0}}), 1e-11);
    EXPECT_LE(fit.largest_residual, 1e-11);
}

TEST(InverseFfd, KeepsTheBorder)
{
    std::mt19937_64 random(136);
    const auto wishes = random_constraints(random, 6);
    FfdFitOptions o;
    o.keep_border = 1;
    const FfdFit fit = fit_lattice(cube(7), wishes, o);
    EXPECT_EQ(fit.lattice.border_continuity(), 1);
    EXPECT_LE(fit.largest_residual, 1e-10);
    o.keep_border = 2;
    EXPECT_THROW(fit_lattice(cube(4), wishes, o), InvalidInput);
}

TEST(InverseFfd, RegularisationIsTheMinimumOfItsSum)
{
    std::mt19937_64 random(137);
    for (const int count : {20, 100}) {  // fewer and more than the 64 unknowns
        const auto wishes = random_constraints(random, count);
        FfdFitOptions o;
        o.regularisation = 1e-3;
        const FfdFit fit = fit_lattice(kCube, wishes, o);
        const double best = sum_of_squares(fit.residuals) + 1e-3 * fit.moved * fit.moved;
        for (int trial = 0; trial < 100; ++trial) {
            Lattice other = fit.lattice;
            auto moves = other.moves();
            moves[random() % moves.size()] += random_vec(random, 1e-3);
            other.set_moves(moves);
            double sum = 0.0;
            for (const auto& w : wishes)
                sum += std::pow(distance(other.apply(w.point), w.target), 2);
            for (const Vec3& d : moves) sum += 1e-3 * dot(d, d);
            EXPECT_GE(sum, best);
        }
        EXPECT_LE(fit.moved, fit_lattice(kCube, wishes).moved);
    }
}

TEST(InverseFfd, NewTargetsGiveWhatANewFitGives)
{
    std::mt19937_64 random(138);
    auto wishes = random_constraints(random, 30);
    const InverseFfd solver(kCube, wishes);
    std::vector<Vec3> targets;
    for (auto& w : wishes) targets.push_back(w.target);
    targets[7] += Vec3{{0.3, 0.1, 0}};
    wishes[7].target = targets[7];
    EXPECT_EQ(solver.solve(targets).lattice.moves(), fit_lattice(kCube, wishes).lattice.moves());
}

TEST(InverseFfd, AddsToADeformationThatIsThereAlready)
{
    std::mt19937_64 random(139);
    Lattice bent = kCube;
    bent.set_moves(random_points(random, 64, 0.2));
    const auto wishes = random_constraints(random, 10);
    const FfdFit fit = fit_lattice(bent, wishes);
    EXPECT_LE(fit.largest_residual, 1e-12);
    const FfdFit nothing = fit_lattice(fit.lattice, wishes);
    EXPECT_LE(nothing.moved, 1e-10);
}

TEST(InverseFfd, WorksOnSplineLattices)
{
    std::mt19937_64 random(140);
    const auto lattice = Lattice::bspline(
        {{-1, -1, -1}}, {Vec3{{2, 0, 0}}, Vec3{{0, 2, 0}}, Vec3{{0, 0, 2}}}, {8, 8, 8});
    const FfdFit fit = fit_lattice(lattice, random_constraints(random, 40));
    EXPECT_LE(fit.largest_residual, 1e-10);
}

TEST(InverseFfd, RefusesBadArguments)
{
    EXPECT_THROW(fit_lattice(kCube, {}), InvalidInput);
    EXPECT_THROW(fit_lattice(kCube, {{{{2, 0, 0}}, {}, 1.0, std::nullopt}}), InvalidInput);
    EXPECT_THROW(fit_lattice(kCube, {{{}, {}, 0.0, std::nullopt}}), InvalidInput);
    EXPECT_THROW(fit_lattice(kCube, {{{}, {{std::nan(""), 0, 0}}, 1.0, std::nullopt}}),
                 InvalidInput);
    const InverseFfd solver(kCube, {{{}, {}, 1.0, std::nullopt}});
    EXPECT_THROW(solver.solve(std::vector<Vec3>(2)), InvalidInput);
}

TEST(InverseFfd, MeetsTwoHundredConstraintsOnEightCubed)
{
    std::mt19937_64 random(141);
    const auto wishes = random_constraints(random, 200);
    EXPECT_LE(fit_lattice(cube(7), wishes).largest_residual, 1e-10);
    EXPECT_LE(InverseFfd(cube(7), wishes).solve().largest_residual, 1e-10);
}

}  // namespace
}  // namespace genus
