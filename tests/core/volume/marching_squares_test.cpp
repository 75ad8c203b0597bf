#include "genus/volume/marching_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "genus/base/error.h"

namespace genus {
namespace {

using Size2 = std::array<std::int32_t, 2>;

double signed_area(const Contour& c)
{
    double sum = 0.0;
    for (std::size_t n = 0; n < c.points.size(); ++n) {
        const Vec2 &a = c.points[n], &b = c.points[(n + 1) % c.points.size()];
        sum += 0.5 * (a[0] * b[1] - a[1] * b[0]);
    }
    return sum;
}

std::vector<double> integer_values(const Size2& size, std::mt19937& random)
{
    std::uniform_int_distribution<int> number(-2, 2);
    std::vector<double> values(static_cast<std::size_t>(size[0]) * size[1]);
    for (double& v : values) v = number(random);
    return values;
}

// The disc of radius 1, sampled at a spacing of about h.
std::vector<Contour> disc(double h)
{
    const auto n = static_cast<std::int32_t>(2.6 / h);
    std::vector<double> values;
    const SquareFrame frame{{{-1.31, -1.27}}, {{h, h}}};
    for (std::int32_t j = 0; j < n; ++j)
        for (std::int32_t i = 0; i < n; ++i)
            values.push_back(std::hypot(frame.origin[0] + i * h, frame.origin[1] + j * h) - 1.0);
    return marching_squares(std::span<const double>(values), {n, n}, frame);
}

TEST(MarchingSquares, AreaOfADiscConvergesWithTheSquareOfTheCell)
{
    double last = 0.0;
    for (const double h : {0.2, 0.1, 0.05, 0.025}) {
        const auto lines = disc(h);
        ASSERT_EQ(lines.size(), 1u);
        EXPECT_TRUE(lines[0].closed);
        const double error = std::numbers::pi - signed_area(lines[0]);  // inside on the left
        EXPECT_GT(error, 0.0);
        if (last > 0.0) {
            EXPECT_NEAR(last / error, 4.0, 0.6);
        }
        last = error;
    }
}

TEST(MarchingSquares, TheBilinearInterpolantDecidesASaddle)
{
    const auto lines = [](std::vector<double> values) {
        return marching_squares(std::span<const double>(values), {2, 2}, {},
                                {0.0, true, SampleOrder::FirstFastest});
    };
    EXPECT_EQ(lines({-3, 1, 1, -3}).size(), 1u);  // joined through the middle
    EXPECT_EQ(lines({-1, 3, 3, -1}).size(), 2u);  // apart
    EXPECT_EQ(lines({-2, 2, 2, -2}).size(), 2u);  // a tie: apart
    const double third = 1.0 / 3.0, more = std::nextafter(third, 1.0);
    EXPECT_EQ(lines({-third, third, third, -more}).size(), 1u);
    EXPECT_EQ(lines({-third, third, more, -third}).size(), 2u);
}

// Inside and outside of every sample, told by the windings of the lines alone. The lines of two
// samples never pass through a third, so the point just beside a sample tells.
TEST(MarchingSquares, LinesAreClosedOrEndOnTheBorder)
{
    for (int trial = 0; trial < 2000; ++trial) {
        std::mt19937 random(trial);
        std::uniform_int_distribution<int> extent(2, 7);
        const Size2 size{extent(random), extent(random)};
        const std::vector<double> values = integer_values(size, random);
        std::size_t points = 0;
        for (const bool close : {false, true}) {
            const auto lines = marching_squares(std::span<const double>(values), size, {},
                                                {0.0, close, SampleOrder::FirstFastest});
            points = 0;
            for (const Contour& c : lines) {
                points += c.points.size();
                if (close) {
                    ASSERT_TRUE(c.closed) << trial;
                }
                if (c.closed) continue;
                for (const Vec2& end : {c.points.front(), c.points.back()})
                    ASSERT_TRUE(end[0] == 0 || end[1] == 0 || end[0] == size[0] - 1 ||
                                end[1] == size[1] - 1)
                        << trial;
            }
            std::size_t crossed = 0;  // every crossed grid edge has its point on one line
            const auto inside = [&](int i, int j) {
                return i >= 0 && j >= 0 && i < size[0] && j < size[1] &&
                       values[static_cast<std::size_t>(j * size[0] + i)] < 0;
            };
            const int margin = close ? 1 : 0;
            for (int j = -margin; j < size[1] + margin; ++j)
                for (int i = -margin; i < size[0] + margin; ++i) {
                    crossed += i + 1 < size[0] + margin && inside(i, j) != inside(i + 1, j);
                    crossed += j + 1 < size[1] + margin && inside(i, j) != inside(i, j + 1);
                }
            ASSERT_EQ(points, crossed) << trial;
        }
    }
}

// Turning the numbers over keeps all lines, unless a number is zero: then it changes sides.
TEST(MarchingSquares, TheNegativeHasTheSameLinesBackwards)
{
    for (int trial = 0; trial < 300; ++trial) {
        std::mt19937 random(trial);
        std::uniform_real_distribution<double> number(-1, 1);
        std::vector<double> values(30), negative;
        for (double& v : values) v = number(random);
        for (const double v : values) negative.push_back(-v);
        const auto lines = marching_squares(std::span<const double>(values), {6, 5});
        const auto back = marching_squares(std::span<const double>(negative), {6, 5});
        ASSERT_EQ(lines.size(), back.size()) << trial;
        std::multiset<std::size_t> a, b;
        for (const Contour& c : lines) a.insert(c.points.size());
        for (const Contour& c : back) b.insert(c.points.size());
        ASSERT_EQ(a, b) << trial;
    }
}

TEST(MarchingSquares, OrderAndTypeOfTheArrayDoNotMatter)
{
    std::mt19937 random(3);
    const Size2 size{5, 4};
    const std::vector<double> values = integer_values(size, random);
    std::vector<float> turned;
    for (int i = 0; i < size[0]; ++i)
        for (int j = 0; j < size[1]; ++j)
            turned.push_back(static_cast<float>(values[static_cast<std::size_t>(j * size[0] + i)]));
    EXPECT_EQ(marching_squares(std::span<const double>(values), size),
              marching_squares(std::span<const float>(turned), size, {},
                               {0.0, false, SampleOrder::LastFastest}));
}

TEST(MarchingSquares, RefusesBadSizesAndNumbers)
{
    const std::vector<double> four(4);
    const std::span<const double> values(four);
    EXPECT_THROW(marching_squares(values, {4, 1}), InvalidInput);
    EXPECT_THROW(marching_squares(values, {2, 3}), InvalidInput);
    EXPECT_THROW(marching_squares(values, {2, 2}, {{}, {{0.0, 1.0}}}), InvalidInput);
    EXPECT_THROW(marching_squares(values, {2, 2}, {}, {std::nan("")}), InvalidInput);
}

}  // namespace
}  // namespace genus
