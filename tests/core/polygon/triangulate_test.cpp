#include "genus/polygon/triangulate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <map>
#include <set>

#include "cases/polygons.h"
#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/polygon/delaunay.h"

using namespace genus;
using enum TriangulateMethod;

namespace {

constexpr std::array kMethods{Auto, Ear, Sweep, Delaunay};

std::vector<Vec2> points_of(const Polygon& polygon)
{
    std::vector<Vec2> points = polygon.outer;
    for (const Ring& hole : polygon.holes) points.insert(points.end(), hole.begin(), hole.end());
    return points;
}

double ring_area(const Ring& ring)
{
    double sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vec2 &p = ring[i], &q = ring[(i + 1) % ring.size()];
        sum += p[0] * q[1] - p[1] * q[0];
    }
    return sum / 2;
}

using Place = std::array<double, 2>;
using Side = std::pair<Place, Place>;

// Positive triangles, the area, every edge of the polygon, and no side with more than one
// triangle on its left.
void expect_triangulation(const Polygon& polygon, const std::vector<PolygonTriangle>& triangles,
                          double area, double tolerance)
{
    const std::vector<Vec2> points = points_of(polygon);
    double sum = 0;
    std::set<Side> sides;
    for (const auto& [a, b, c] : triangles) {
        ASSERT_EQ(orient2d(points[a], points[b], points[c]), 1);
        const Vec2 u = points[b] - points[a], v = points[c] - points[a];
        sum += (u[0] * v[1] - u[1] * v[0]) / 2;
        for (const auto& [p, q] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
            ASSERT_TRUE(sides.insert({points[p].c, points[q].c}).second);
    }
    ASSERT_NEAR(sum, area, tolerance);
    const auto expect_edges = [&](const Ring& ring) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Vec2 &p = ring[i], &q = ring[(i + 1) % ring.size()];
            if (p == q) continue;
            ASSERT_TRUE(sides.count({p.c, q.c}) || sides.count({q.c, p.c}));
        }
    };
    expect_edges(polygon.outer);
    for (const Ring& hole : polygon.holes) expect_edges(hole);
}

void expect_delaunay(const Polygon& polygon, const std::vector<PolygonTriangle>& triangles)
{
    const std::vector<Vec2> points = points_of(polygon);
    std::set<Side> fixed;
    const auto fix = [&](const Ring& ring) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Vec2 &p = ring[i], &q = ring[(i + 1) % ring.size()];
            fixed.insert({p.c, q.c});
            fixed.insert({q.c, p.c});
        }
    };
    fix(polygon.outer);
    for (const Ring& hole : polygon.holes) fix(hole);
    std::map<Side, std::int32_t> opposite;
    for (const PolygonTriangle& t : triangles)
        for (int i = 0; i < 3; ++i)
            opposite[{points[t[i]].c, points[t[(i + 1) % 3]].c}] = t[(i + 2) % 3];
    for (const auto& [side, corner] : opposite) {
        const auto across = opposite.find({side.second, side.first});
        if (across == opposite.end() || fixed.count(side)) continue;
        ASSERT_LE(
            in_circle(Vec2{side.first}, Vec2{side.second}, points[corner], points[across->second]),
            0);
    }
}

}  // namespace

TEST(Triangulate, SmallKnownShapes)
{
    const Ring square{{{0, 0}}, {{4, 0}}, {{4, 4}}, {{0, 4}}};
    const Ring hole{{{1, 1}}, {{2, 1}}, {{2, 2}}, {{1, 2}}};
    for (const TriangulateMethod method : kMethods) {
        EXPECT_EQ(triangulate({square, {}}, method).size(), 2u);
        const Polygon frame{square, {hole}};
        const auto triangles = triangulate(frame, method);
        EXPECT_EQ(triangles.size(), 8u);
        expect_triangulation(frame, triangles, 15, 0);
    }
}

TEST(Triangulate, StarsCombsSpiralsAndCircles)
{
    for (const int n : {10, 50, 500, 3000}) {
        std::vector<Ring> rings{cases::star(n), cases::comb(n), cases::circle(n)};
        if (n >= 500) rings.push_back(cases::spiral(n));
        for (const Ring& ring : rings)
            for (const bool turned : {false, true})
                for (const TriangulateMethod method : kMethods) {
                    Polygon polygon{ring, {}};
                    if (turned) std::reverse(polygon.outer.begin(), polygon.outer.end());
                    const auto triangles = triangulate(polygon, method);
                    EXPECT_EQ(triangles.size(), ring.size() - 2);
                    const double area = std::fabs(ring_area(ring));
                    expect_triangulation(polygon, triangles, area, 1e-9 * area);
                    if (method == Delaunay) expect_delaunay(polygon, triangles);
                }
    }
}

TEST(Triangulate, RandomCellsExactly)
{
    const int n_cases = std::getenv("GENUS_LONG") ? 1'000'000 : 4'000;
    for (int seed = 0; seed < n_cases; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        cases::CellOptions options;
        options.size = 2 + static_cast<int>(random() % 7);
        options.follow_outside = random() % 2;
        options.keep_flat_corners = random() % 2;
        options.repeat_points = random() % 2;
        options.mirror = random() % 2;
        const cases::CellPolygon cell = cases::cell_polygon(random, options);
        for (const TriangulateMethod method : {Ear, Sweep, Delaunay}) {
            SCOPED_TRACE(static_cast<int>(method));
            const auto triangles = triangulate(cell.polygon, method);
            ASSERT_EQ(static_cast<std::int64_t>(triangles.size()), cell.n_triangles);
            expect_triangulation(cell.polygon, triangles, cell.area, 0);
            if (method == Delaunay) expect_delaunay(cell.polygon, triangles);
            if (HasFatalFailure()) return;
        }
    }
}

TEST(Triangulate, RandomStarsWithHolesRoundTheirMiddle)
{
    std::mt19937 random(9);
    for (int i = 0; i < 300; ++i) {
        SCOPED_TRACE(i);
        Polygon polygon;
        const int n = 3 + static_cast<int>(random() % 40);
        const auto ring = [&](Vec2 center, double from, double to) {
            Ring r;
            for (int k = 0; k < n; ++k) {
                const double angle = 2 * std::numbers::pi * k / n;
                const double d = from + (to - from) * (random() * 0x1p-32);
                r.push_back(center + Vec2{{d * std::cos(angle), d * std::sin(angle)}});
            }
            return r;
        };
        polygon.outer = ring({}, 12, 20);
        double area = ring_area(polygon.outer);
        for (const double x : {-3.0, 0.0, 3.0})
            for (const double y : {-3.0, 0.0, 3.0}) {
                if (random() % 3 == 0) continue;
                polygon.holes.push_back(ring({{x, y}}, 0.3, 1.4));
                area -= ring_area(polygon.holes.back());
            }
        if (n < 12) polygon.holes.clear();  // chords might cut the middle
        if (n < 12) area = ring_area(polygon.outer);
        const std::size_t corners = n * (1 + polygon.holes.size());
        for (const TriangulateMethod method : kMethods) {
            const auto triangles = triangulate(polygon, method);
            EXPECT_EQ(triangles.size(), corners - 2 + 2 * polygon.holes.size());
            expect_triangulation(polygon, triangles, area, 1e-9 * area);
        }
    }
}

TEST(Triangulate, KeyholeRings)
{
    // A hole joined to the outer ring by an edge run through both ways: 10 corners, 8 triangles.
    const Polygon keyhole{{{{0, 0}},
                           {{4, 0}},
                           {{4, 4}},
                           {{0, 4}},
                           {{0, 0}},
                           {{1, 1}},
                           {{1, 2}},
                           {{2, 2}},
                           {{2, 1}},
                           {{1, 1}}},
                          {}};
    for (const TriangulateMethod method : kMethods) {
        const auto triangles = triangulate(keyhole, method);
        EXPECT_EQ(triangles.size(), 8u);
        expect_triangulation(keyhole, triangles, 15, 0);
    }
}

TEST(Triangulate, SpikesInwardAreEdgesOutwardNothing)
{
    const Polygon inward{{{{0, 0}}, {{4, 0}}, {{4, 4}}, {{2, 4}}, {{2, 2}}, {{2, 4}}, {{0, 4}}},
                         {}};
    for (const TriangulateMethod method : {Sweep, Delaunay}) {
        const auto triangles = triangulate(inward, method);
        EXPECT_EQ(triangles.size(), 5u);
        expect_triangulation(inward, triangles, 16, 0);
    }
    const Polygon outward{{{{0, 0}}, {{4, 0}}, {{4, 4}}, {{2, 4}}, {{2, 6}}, {{2, 4}}, {{0, 4}}},
                          {}};
    EXPECT_EQ(triangulate(outward, Sweep).size(), 3u);
    const Polygon to_the_left{{{{0, 0}}, {{4, 0}}, {{0, 4}}, {{0, 2}}, {{-3, 2}}, {{0, 2}}}, {}};
    EXPECT_EQ(triangulate(to_the_left, Sweep).size(), 2u);
}

TEST(Triangulate, RefusesWithThePlace)
{
    const Ring square{{{0, 0}}, {{4, 0}}, {{4, 4}}, {{0, 4}}};
    const auto moved = [](Ring ring, double x, double y) {
        for (Vec2& p : ring) p = 0.25 * p + Vec2{{x, y}};
        return ring;
    };
    const auto expect_refused = [](const Polygon& polygon, const std::string& part) {
        for (const TriangulateMethod method : kMethods) {
            try {
                triangulate(polygon, method);
                ADD_FAILURE() << "accepted, expected: " << part;
            } catch (const InvalidInput& e) {
                EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
            }
        }
    };
    expect_refused({{{{0, 0}}, {{4, 4}}, {{4, 0}}, {{0, 4}}}, {}}, "meets the edge");
    expect_refused({square, {moved(square, 3.5, 1)}}, "meets the edge");
    expect_refused({square, {moved(square, 9, 1)}}, "wind -1 times");
    expect_refused({square, {moved(square, 1, 1), moved(moved(square, 1, 1), 1, 1)}}, "wind");
    expect_refused({square, {{{{0, 2}}, {{1, 1}}, {{1, 3}}}}}, "point 4 (0, 2) lies on the edge");
    expect_refused({{{{0, 0}}, {{1, 1}}, {{2, 2}}}, {}}, "no area");
    expect_refused({square, {{{{1, 1}}, {{2, 2}}}}}, "hole 0");
    expect_refused({{}, {}}, "no area");
    expect_refused({{{{0, 0}}, {{4, 0}}, {{4, std::nan("")}}}, {}}, "point 2 is not finite");
    EXPECT_TRUE(triangulate({square, {square}}).empty());
}

TEST(Triangulate, TellsCrossingsOfALastBit)
{
    // A corner that pierces the opposite edge by one unit in the last place, touches it, or not.
    const auto dart = [](double y) {
        return Polygon{{{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0.5, y}}, {{0, 1}}}, {}};
    };
    for (const TriangulateMethod method : kMethods) {
        EXPECT_EQ(
            triangulate(dart(std::numeric_limits<double>::denorm_min() * 0x1p300), method).size(),
            3u);
        EXPECT_THROW(triangulate(dart(0.0), method), InvalidInput);
        EXPECT_THROW(triangulate(dart(-1e-60), method), InvalidInput);
    }
}

TEST(Triangulate, FindsEveryCrossingOfRandomRings)
{
    // Few points on a small grid: crossings, points on edges, overlaps, repeats and touches. What
    // all pairs of edges say must be what the sweep says.
    const auto within = [](const Vec2& p, const Vec2& a, const Vec2& b) {
        return orient2d(a, b, p) == 0 && p != a && p != b && dot(p - a, p - b) < 0;
    };
    const auto meet = [&](const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
        if (within(a, c, d) || within(b, c, d) || within(c, a, b) || within(d, a, b)) return true;
        return orient2d(a, b, c) * orient2d(a, b, d) < 0 &&
               orient2d(c, d, a) * orient2d(c, d, b) < 0;
    };
    std::array<int, 3> seen{};
    const int n_cases = std::getenv("GENUS_LONG") ? 3'000'000 : 30'000;
    for (int seed = 0; seed < n_cases; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const unsigned range = 2 + random() % 5;
        Ring ring(3 + random() % 6);
        for (Vec2& p : ring)
            for (double& x : p.c) x = static_cast<double>(random() % range);
        bool crosses = false;
        for (std::size_t i = 0; i < ring.size(); ++i)
            for (std::size_t j = i + 1; j < ring.size(); ++j)
                crosses |= meet(ring[i], ring[(i + 1) % ring.size()], ring[j],
                                ring[(j + 1) % ring.size()]);
        try {
            const auto triangles = triangulate({ring, {}}, Sweep);
            ASSERT_FALSE(crosses);
            double area = 0;
            for (const auto& [a, b, c] : triangles) {
                ASSERT_EQ(orient2d(ring[a], ring[b], ring[c]), 1);
                area += ring_area({ring[a], ring[b], ring[c]});
            }
            ASSERT_EQ(area, std::fabs(ring_area(ring)));
            ++seen[0];
        } catch (const InvalidInput& e) {
            const std::string text = e.what();
            const bool other = text.find("wind") != text.npos || text.find("area") != text.npos;
            ASSERT_TRUE(crosses || other) << text;
            ++seen[crosses ? 1 : 2];
        }
        const auto ears = [&] { return triangulate({ring, {}}, Ear); };
        if (crosses) {
            ASSERT_THROW(ears(), InvalidInput);
        }
    }
    for (const int n : seen) EXPECT_GT(n, n_cases / 100);
}

TEST(Triangulate, QualityModeBeatsGoingRound)
{
    const auto least_shape = [](const std::vector<Vec2>& points,
                                const std::vector<PolygonTriangle>& triangles) {
        double least = 1;
        for (const auto& [a, b, c] : triangles) {
            const Vec2 u = points[b] - points[a], v = points[c] - points[a],
                       w = points[c] - points[b];
            least = std::min(
                least, (u[0] * v[1] - u[1] * v[0]) / std::max({dot(u, u), dot(v, v), dot(w, w)}));
        }
        return least;
    };
    const Ring ring = cases::circle(48);
    const double ear = least_shape(ring, triangulate({ring, {}}, Ear));
    const double sweep = least_shape(ring, triangulate({ring, {}}, Sweep));
    EXPECT_GE(ear, sweep * (1 - 1e-12));
    const auto delaunay = triangulate({cases::star(200), {}}, Delaunay);
    const auto swept = triangulate({cases::star(200), {}}, Sweep);
    EXPECT_GE(least_shape(cases::star(200), delaunay), least_shape(cases::star(200), swept));
}

namespace {

// A line of n points that goes up and down a regular grid, under a bar: any four neighbours of the
// grid are on a circle.
Ring serpentine(int n)
{
    const int m = static_cast<int>(std::sqrt(n)) / 2 * 2 + 1;
    Ring ring;
    for (int i = 0; i < m; ++i)
        for (int j = 0; j < m; ++j) ring.push_back({{1.0 * i, i % 2 == 0 ? 1.0 + j : 1.0 * m - j}});
    ring.push_back({{1.0 * m, 1.0 * m}});
    ring.push_back({{1.0 * m, 0}});
    ring.push_back({{0, 0}});
    return ring;
}

// Two sorted rows of points, far apart beside their spacing.
Ring ribbon(int n)
{
    Ring ring;
    for (int i = 0; i < n / 2; ++i) ring.push_back({{0.01 * i, -1.0 - i * 37 % 101 * 0.01}});
    for (int i = n / 2; i-- > 0;) ring.push_back({{0.01 * i, 1.0 + i * 53 % 103 * 0.01}});
    return ring;
}

// Convex, and triangles by x are as far from Delaunay as can be.
Ring parabola(int n)
{
    Ring ring;
    for (int i = 0; i < n; ++i) {
        const double x = i - n / 2;
        ring.push_back({{x, x * x}});
    }
    return ring;
}

// Holes on a regular grid, as far apart as they are wide.
Polygon sieve(int n)
{
    const int m = static_cast<int>(std::sqrt(n / 4));
    const double end = 2.0 * m;
    Polygon polygon{{{{-1, -1}}, {{end, -1}}, {{end, end}}, {{-1, end}}}, {}};
    for (int i = 0; i < m; ++i)
        for (int j = 0; j < m; ++j) {
            const double x = 2.0 * i, y = 2.0 * j;
            polygon.holes.push_back({{{x, y}}, {{x, y + 1}}, {{x + 1, y + 1}}, {{x + 1, y}}});
        }
    return polygon;
}

}  // namespace

TEST(Triangulate, DelaunayOnManyPointsOfCirclesAndLines)
{
    for (const int n : {20, 400, 5000})
        for (const Polygon& polygon :
             {Polygon{serpentine(n), {}}, Polygon{ribbon(n), {}}, Polygon{parabola(n), {}},
              Polygon{cases::circle(n), {cases::circle(n / 2, 0.7)}}, sieve(n)}) {
            const auto triangles = triangulate(polygon, Delaunay);
            double area = std::fabs(ring_area(polygon.outer));
            for (const Ring& hole : polygon.holes) area -= std::fabs(ring_area(hole));
            EXPECT_EQ(triangles.size(), points_of(polygon).size() - 2 + 2 * polygon.holes.size());
            expect_triangulation(polygon, triangles, area, 1e-9 * area);
            expect_delaunay(polygon, triangles);
        }
}

TEST(Triangulate, DelaunayDoesNotDependOnTheScale)
{
    const auto triangles = triangulate({cases::star(60), {}}, Delaunay);
    for (const int power : {-300, -150, 150, 300}) {
        Ring ring = cases::star(60);
        for (Vec2& p : ring) p = std::ldexp(1.0, power) * p;
        EXPECT_EQ(triangulate({ring, {}}, Delaunay), triangles) << power;
    }
}

TEST(Triangulate, LargePolygonsInTime)
{
    const int n = std::getenv("GENUS_LONG") ? 1'000'000 : 50'000;
    const auto seconds = [](const Polygon& polygon, TriangulateMethod method) {
        const std::clock_t start = std::clock();
        EXPECT_EQ(triangulate(polygon, method).size(),
                  points_of(polygon).size() - 2 + 2 * polygon.holes.size());
        return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    };
    for (const auto& [name, polygon] : {std::pair{"star", Polygon{cases::star(n), {}}},
                                        {"comb", Polygon{cases::comb(n), {}}},
                                        {"spiral", Polygon{cases::spiral(n), {}}},
                                        {"circle", Polygon{cases::circle(n), {}}},
                                        {"serpentine", Polygon{serpentine(n), {}}},
                                        {"ribbon", Polygon{ribbon(n), {}}},
                                        {"parabola", Polygon{parabola(n), {}}},
                                        {"sieve", sieve(n)}}) {
        const double sweep = seconds(polygon, Sweep), delaunay = seconds(polygon, Delaunay);
        RecordProperty(name, std::to_string(sweep) + " Delaunay " + std::to_string(delaunay));
        // An edge costs a few exact signs on every level of joins. Quadratic time would be more
        // than a thousand times that of the sweep.
        EXPECT_LT(delaunay, 60 * sweep + 0.1) << name;
    }
}
