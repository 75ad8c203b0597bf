#include "genus/polygon/region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

#include "genus/base/error.h"
#include "genus/base/transform.h"
#include "genus/polygon/planar_arrangement.h"

namespace genus {
namespace {

Region rectangle(double x, double y, double width, double height)
{
    return {{{{{x, y}}, {{x + width, y}}, {{x + width, y + height}}, {{x, y + height}}}}};
}

Ring regular(int n, double r, const Vec2& center, double turn = 0.0)
{
    Ring ring;
    for (int i = 0; i < n; ++i) {
        const double angle = turn + 360.0 * i / n;
        ring.push_back(center + Vec2{{r * cos_degrees(angle), r * sin_degrees(angle)}});
    }
    return ring;
}

// Corners anywhere, so that the ring crosses itself in many places.
Ring random_ring(std::mt19937& random, int n, double step)
{
    std::uniform_int_distribution<int> coordinate(-20, 20);
    Ring ring;
    for (int i = 0; i < n; ++i)
        ring.push_back({{coordinate(random) * step, coordinate(random) * step}});
    return ring;
}

void expect_valid(const Region& region)
{
    EXPECT_FALSE(rings_cross(region.rings));
    for (const Ring& ring : region.rings) EXPECT_GE(ring.size(), 3u);
}

TEST(Region, UnionOfOverlappingSquaresHasTheSumLessTheCommonPart)
{
    const Region parts[] = {rectangle(0, 0, 2, 2), rectangle(1, 1, 2, 2)};
    const Region all = unite(parts);
    ASSERT_EQ(all.rings.size(), 1u);
    EXPECT_EQ(all.rings[0].size(), 8u);
    EXPECT_EQ(area(all), 7.0);
    EXPECT_EQ(area(intersect(parts)), 1.0);
    EXPECT_EQ(area(subtract(parts)), 3.0);
}

TEST(Region, SharedSidesVanish)
{
    const Region parts[] = {rectangle(0, 0, 0.1, 1), rectangle(0.1, 0, 0.2, 1)};
    const Region all = unite(parts);
    ASSERT_EQ(all.rings.size(), 1u);
    EXPECT_EQ(all.rings[0].size(), 4u);
    EXPECT_TRUE(intersect(parts).empty());
}

// The sides of a drawn line lie nearly on one line; cutting them where they cross moved them on by
// a grid step again and again.
TEST(Region, BundlesOfNearlyParallelEdgesSettle)
{
    std::mt19937 random(99);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const int trials = std::getenv("GENUS_LONG") ? 20'000 : 30;
    for (int trial = 0; trial < trials; ++trial) {
        SCOPED_TRACE(trial);
        const double angle = 360.0 * unit(random),
                     spread = 0.1 * std::pow(10.0, -12.0 * unit(random));
        const Vec2 u{{cos_degrees(angle), sin_degrees(angle)}}, v{{-u[1], u[0]}};
        std::vector<Ring> rings;
        for (int i = 0; i < 12; ++i) {
            const double from = unit(random), to = from + unit(random);
            const auto aside = [&] { return 0.1 + spread * (unit(random) - 0.5); };
            rings.push_back({from * u - aside() * v, to * u - aside() * v, to * u + aside() * v,
                             from * u + aside() * v});
        }
        const Region all = make_region(rings);
        expect_valid(all);
        EXPECT_LE(area(all), 0.4 + 2.0 * spread);
        EXPECT_GT(area(all), 0.0);
        EXPECT_TRUE(contains(all, 0.5 * (rings[0][0] + rings[0][2])));
    }
}

TEST(Region, AChainOfTouchingSquaresIsOnePiece)
{
    std::vector<Region> parts;
    for (int i = 0; i < 200; ++i) parts.push_back(rectangle(0.1 * i, 0, 0.1, 0.1));
    const Region all = unite(parts);
    ASSERT_EQ(all.rings.size(), 1u);
    EXPECT_NEAR(area(all), 2.0, 1e-12);
}

TEST(Region, SquaresThatTouchInACornerStayTwoRings)
{
    const Region parts[] = {rectangle(0, 0, 1, 1), rectangle(1, 1, 1, 1)};
    const Region all = unite(parts);
    EXPECT_EQ(all.rings.size(), 2u);
    EXPECT_EQ(area(all), 2.0);
}

TEST(Region, CoordinatesThatCameInGoOutWithTheSameBits)
{
    const Region parts[] = {rectangle(0.1, 0.3, 0.7, 0.2), rectangle(0.2, 0.1, 0.3, 0.9)};
    for (const Ring& ring : unite(parts).rings)
        for (const Vec2& p : ring) {
            bool known_x = false, known_y = false;
            for (const Region& part : parts)
                for (const Vec2& q : part.rings[0]) {
                    known_x |= p[0] == q[0];
                    known_y |= p[1] == q[1];
                }
            EXPECT_TRUE(known_x && known_y) << p[0] << " " << p[1];
        }
}

TEST(Region, FillRulesDifferWhereRingsOverlap)
{
    const Ring rings[] = {rectangle(0, 0, 4, 4).rings[0], rectangle(1, 1, 2, 2).rings[0]};
    EXPECT_EQ(area(make_region(rings, FillRule::NonZero)), 16.0);
    EXPECT_EQ(area(make_region(rings, FillRule::EvenOdd)), 12.0);
    // A star of five points turns twice round its middle.
    Ring star;
    for (int i = 0; i < 5; ++i) star.push_back(regular(5, 1, {{0, 0}}, 90)[2 * i % 5]);
    const Ring stars[] = {star};
    EXPECT_EQ(make_region(stars, FillRule::NonZero).rings.size(), 1u);
    EXPECT_GT(area(make_region(stars, FillRule::NonZero)),
              area(make_region(stars, FillRule::EvenOdd)) + 0.1);
}

TEST(Region, ObeysInclusionAndExclusionOnRandomRings)
{
    for (unsigned seed = 1; seed <= 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        // A coarse lattice makes many edges touch, overlap and meet in one point.
        const double step = seed % 3 == 0 ? 1.0 : seed % 3 == 1 ? 0.1 : 1e6 / 3;
        const int n = 3 + static_cast<int>(seed % 12);
        const Ring first[] = {random_ring(random, n, step)};
        const Ring second[] = {random_ring(random, n, step)};
        const Region parts[] = {make_region(first, FillRule::EvenOdd), make_region(second)};
        const Region all = unite(parts), common = intersect(parts), rest = subtract(parts);
        for (const Region& region : {parts[0], parts[1], all, common, rest}) expect_valid(region);
        const double slack = 1e-9 * step * step * 1600;
        EXPECT_NEAR(area(all) + area(common), area(parts[0]) + area(parts[1]), slack);
        EXPECT_NEAR(area(rest) + area(common), area(parts[0]), slack);
        const Region pieces[] = {rest, common};
        EXPECT_NEAR(area(unite(pieces)), area(parts[0]), slack);
    }
}

TEST(Region, MembershipFollowsTheFormula)
{
    std::uniform_real_distribution<double> coordinate(-21, 21);
    for (unsigned seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const Ring first[] = {random_ring(random, 9, 1.0)};
        const Ring second[] = {random_ring(random, 7, 1.0)};
        const Region a = make_region(first), b = make_region(second);
        const Region parts[] = {a, b};
        const Region all = unite(parts), common = intersect(parts), rest = subtract(parts);
        for (int trial = 0; trial < 200; ++trial) {
            const Vec2 p{{coordinate(random), coordinate(random)}};
            const bool in_a = contains(a, p), in_b = contains(b, p);
            EXPECT_EQ(contains(all, p), in_a || in_b);
            EXPECT_EQ(contains(common, p), in_a && in_b);
            EXPECT_EQ(contains(rest, p), in_a && !in_b);
        }
    }
}

TEST(Region, ManyCirclesUniteToTheirKnownArea)
{
    // A lattice of discs that overlap their four neighbours: lenses counted once.
    const int n = 256, side = 12;
    std::vector<Region> discs;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j)
            discs.push_back({{regular(n, 0.6, {{double(i), double(j)}}, 0.25)}});
    const Region all = unite(discs);
    expect_valid(all);
    EXPECT_EQ(all.rings.size(), 1u + (side - 1) * (side - 1));
    const double r = 0.6, half = std::acos(0.5 / r);
    const double lens = 2 * r * r * half - std::sin(2 * half) * r * r;
    const double disc = std::numbers::pi * r * r;
    const double expected = side * side * disc - 2 * side * (side - 1) * lens;
    EXPECT_NEAR(area(all), expected, 2e-4 * expected);
}

TEST(Region, FarFromTheOriginNothingIsLostThatDoublesCanTell)
{
    const double far = 1e12;
    const Region parts[] = {rectangle(far, far, 10, 10), rectangle(far + 4, far + 4, 2, 2)};
    EXPECT_EQ(area(subtract(parts)), 96.0);
}

TEST(Offset, OfASquareIsKnownForEveryJoin)
{
    const Region square = rectangle(0, 0, 10, 10);
    OffsetOptions options;
    options.join = JoinStyle::Miter;
    EXPECT_NEAR(area(offset(square, 1, options)), 144.0, 1e-9);
    EXPECT_NEAR(area(offset(square, -1, options)), 64.0, 1e-9);
    options.join = JoinStyle::Round;
    options.fragments = 4096;
    EXPECT_NEAR(area(offset(square, 1, options)), 140.0 + std::numbers::pi, 1e-4);
    EXPECT_NEAR(area(offset(square, -1, options)), 64.0, 1e-9);
    options.join = JoinStyle::Chamfer;
    // Each corner square loses a triangle: the cut is 1 from the corner along its diagonal.
    const double cut = std::sqrt(2.0) - 1.0;
    EXPECT_NEAR(area(offset(square, 1, options)), 144.0 - 4 * cut * cut, 1e-9);
}

TEST(Offset, HasTheChordsOfOpenScadWhereTheirNumberIsHalfWay)
{
    // Its numbers for a right angle; 14 is the one that goes up.
    const std::pair<int, std::size_t> chords[] = {{6, 1}, {10, 2}, {14, 4}, {18, 4}, {30, 7}};
    for (const auto& [fragments, n] : chords) {
        OffsetOptions options;
        options.fragments = fragments;
        const Region grown = offset(rectangle(0, 0, 3.16, 8), 1.7, options);
        ASSERT_EQ(grown.rings.size(), 1u);
        EXPECT_EQ(grown.rings[0].size(), 4 * (n + 1)) << fragments;
    }
}

TEST(Offset, ClosesHolesSplitsNecksAndEmptiesThinParts)
{
    const Region parts[] = {rectangle(0, 0, 10, 10), rectangle(4, 4, 2, 2)};
    const Region frame = subtract(parts);
    ASSERT_EQ(frame.rings.size(), 2u);
    EXPECT_EQ(offset(frame, 1.5).rings.size(), 1u);
    EXPECT_EQ(offset(frame, -1).rings.size(), 2u);
    EXPECT_TRUE(offset(frame, -2.5).empty());
    const Region bars[] = {rectangle(0, 0, 3, 3), rectangle(3, 1, 3, 1), rectangle(6, 0, 3, 3)};
    EXPECT_EQ(offset(unite(bars), -0.6).rings.size(), 2u);
}

TEST(Offset, OutThenInKeepsAConvexRegion)
{
    const Region disc{{regular(64, 5, {{1, 2}})}};
    OffsetOptions options;
    options.join = JoinStyle::Miter;
    EXPECT_NEAR(area(offset(offset(disc, 0.7, options), -0.7, options)), area(disc), 1e-8);
}

TEST(Offset, EqualsTheSetOfNearPoints)
{
    std::uniform_real_distribution<double> coordinate(-25, 25);
    for (unsigned seed = 1; seed <= 30; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const Ring rings[] = {random_ring(random, 8, 1.0)};
        const Region region = make_region(rings);
        OffsetOptions options;
        options.fragments = 720;
        const double d = 1.3;
        const Region grown = offset(region, d, options), shrunk = offset(region, -d, options);
        expect_valid(grown);
        expect_valid(shrunk);
        for (int trial = 0; trial < 300; ++trial) {
            const Vec2 p{{coordinate(random), coordinate(random)}};
            double nearest = 1e9;
            for (const Ring& ring : region.rings)
                for (std::size_t i = 0; i < ring.size(); ++i) {
                    const Vec2 a = ring[i], b = ring[(i + 1) % ring.size()];
                    const double t = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
                    nearest = std::min(nearest, distance(p, a + (b - a) * t));
                }
            if (std::fabs(nearest - d) < 1e-3) continue;
            const bool inside = contains(region, p);
            EXPECT_EQ(contains(grown, p), inside || nearest < d);
            EXPECT_EQ(contains(shrunk, p), inside && nearest > d);
        }
    }
}

TEST(ConvexHull, HoldsAllPointsAndDropsFlatCorners)
{
    const Vec2 grid[] = {{{0, 0}}, {{1, 0}}, {{2, 0}}, {{0, 1}}, {{1, 1}},
                         {{2, 1}}, {{0, 2}}, {{1, 2}}, {{2, 2}}, {{1, 1}}};
    EXPECT_EQ(convex_hull(grid), rectangle(0, 0, 2, 2).rings[0]);
    const Vec2 line[] = {{{0, 0}}, {{1, 1}}, {{3, 3}}, {{2, 2}}};
    EXPECT_TRUE(convex_hull(line).empty());
    EXPECT_TRUE(convex_hull({}).empty());
}

TEST(Polygons, HolesGoToTheSmallestRingRoundThem)
{
    // An island in a hole of a plate.
    const Region plates[] = {rectangle(0, 0, 10, 10), rectangle(1, 1, 8, 8)};
    const Region islands[] = {rectangle(3, 3, 4, 4), rectangle(4, 4, 1, 1)};
    const Region both[] = {subtract(plates), subtract(islands)};
    const auto parts = polygons(unite(both));
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_EQ(parts[0].holes.size(), 1u);
    EXPECT_EQ(parts[1].holes.size(), 1u);
    EXPECT_GT(std::fabs(area(parts[0].outer)), std::fabs(area(parts[0].holes[0])));
}

TEST(Region, RefusesWhatIsNotFinite)
{
    const Ring rings[] = {{{{0, 0}}, {{1, NAN}}, {{0, 1}}}};
    EXPECT_THROW(make_region(rings), InvalidInput);
    EXPECT_THROW(offset(rectangle(0, 0, 1, 1), INFINITY), InvalidInput);
    EXPECT_TRUE(make_region({}).empty());
    const Ring flat[] = {{{{0, 0}}, {{1, 0}}, {{2, 0}}}};
    EXPECT_TRUE(make_region(flat).empty());
}

}  // namespace
}  // namespace genus
