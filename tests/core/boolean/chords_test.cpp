#include "genus/boolean/chords.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace genus::exact {
namespace {

Vec3 corner(double x, double y)
{
    return {{x, y, x + 2.0 * y}};
}

// A quadrangle with up to four points on each side, seen along z.
std::vector<PointRef> random_polygon(std::mt19937& dice)
{
    const std::array<Vec3, 4> corners{corner(0, 0), corner(60, 12), corner(72, 84),
                                      corner(-24, 60)};
    std::vector<PointRef> points;
    for (std::size_t i = 0; i < 4; ++i) {
        const Vec3 &from = corners[i], &to = corners[(i + 1) % 4];
        for (int k = 0; k < 12; ++k)
            if (k == 0 || dice() % 4 == 0) points.push_back({from + (k / 12.0) * (to - from)});
    }
    return points;
}

double twice_area(const std::vector<PointRef>& p, std::span<const std::int32_t> polygon)
{
    double area = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3 &a = p[polygon[i]].approx, &b = p[polygon[(i + 1) % polygon.size()]].approx;
        area += a[0] * b[1] - a[1] * b[0];
    }
    return area;
}

TEST(Chords, AreKeptAsAreAllPointsOfThePolygon)
{
    int n_cut = 0;
    for (std::uint32_t seed = 0; seed < 2000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 dice(seed);
        const std::vector<PointRef> points = random_polygon(dice);
        const auto n = static_cast<std::int32_t>(points.size());
        std::vector<Chord> chords(dice() % 4);
        for (Chord& c : chords) {
            c[0] = static_cast<std::int32_t>(dice() % points.size());
            c[1] = (c[0] + 1 + static_cast<std::int32_t>(dice() % (points.size() - 1))) % n;
        }
        const auto cells = cut_by_chords(2, false, points, chords);
        const auto crosses = [](Chord a, Chord b) {
            if (a[0] > a[1]) std::swap(a[0], a[1]);
            const auto inside = [&](std::int32_t p) { return a[0] < p && p < a[1]; };
            const auto outside = [&](std::int32_t p) { return p < a[0] || a[1] < p; };
            return (inside(b[0]) && outside(b[1])) || (inside(b[1]) && outside(b[0]));
        };
        bool any_cross = false;
        for (const Chord& a : chords)
            for (const Chord& b : chords) any_cross = any_cross || crosses(a, b);
        if (any_cross) {
            EXPECT_FALSE(cells);
        }
        if (!cells) continue;
        ++n_cut;
        // As many cells as a polygon of n corners has, none of them flat, that fill it.
        ASSERT_EQ(cells->corners.size(), static_cast<std::size_t>(n - 2));
        std::map<Chord, std::int32_t> across;
        double area = 0.0;
        for (std::size_t c = 0; c < cells->corners.size(); ++c) {
            const Triangle& t = cells->corners[c];
            EXPECT_GT(twice_area(points, t), 0.0);
            area += twice_area(points, t);
            for (std::size_t i = 0; i < 3; ++i)
                EXPECT_TRUE(
                    across.emplace(Chord{t[i], t[(i + 1) % 3]}, cells->across[c][i]).second);
        }
        std::vector<std::int32_t> whole(points.size());
        for (std::int32_t i = 0; i < n; ++i) whole[i] = i;
        EXPECT_EQ(area, twice_area(points, whole));
        // Cells are joined across what is neither side nor chord.
        const auto is_chord = [&](const Chord& e) {
            return std::any_of(chords.begin(), chords.end(), [&](const Chord& c) {
                return c == e || c == Chord{e[1], e[0]};
            });
        };
        for (const auto& [edge, cell] : across) {
            const bool is_side = (edge[0] + 1) % n == edge[1];
            EXPECT_EQ(cell < 0, is_side || is_chord(edge));
            if (!is_side) {
                EXPECT_EQ(across.count({edge[1], edge[0]}), 1u);
            }
        }
        for (const Chord& c : chords)
            EXPECT_EQ(across.count(c) + across.count({c[1], c[0]}),
                      (c[0] + 1) % n == c[1] || (c[1] + 1) % n == c[0] ? 1u : 2u);
    }
    EXPECT_GT(n_cut, 1000);
}

TEST(Chords, AlongASideAreNone)
{
    const std::vector<PointRef> points{
        {corner(0, 0)}, {corner(4, 0)}, {corner(8, 0)}, {corner(4, 9)}};
    const std::vector<Chord> along{{0, 2}}, across{{1, 3}};
    EXPECT_FALSE(cut_by_chords(2, false, points, along));
    EXPECT_TRUE(cut_by_chords(2, false, points, across));
}

}  // namespace
}  // namespace genus::exact
