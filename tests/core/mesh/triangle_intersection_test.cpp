#include "genus/mesh/triangle_intersection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "cases/meshes.h"

using namespace genus;
using enum TriangleContact;

namespace {

const TrianglePoints kBase{{{{0, 0, 0}}, {{4, 0, 0}}, {{0, 4, 0}}}};

// The answer must not depend on the order of the triangles or of their corners.
void expect_contact(const TrianglePoints& a, const TrianglePoints& b, TriangleContact expected)
{
    std::array<std::size_t, 3> i{0, 1, 2};
    do {
        std::array<std::size_t, 3> j{0, 1, 2};
        do {
            const TrianglePoints p{a[i[0]], a[i[1]], a[i[2]]}, q{b[j[0]], b[j[1]], b[j[2]]};
            EXPECT_EQ(triangle_contact(p, q), expected);
            EXPECT_EQ(triangle_contact(q, p), expected);
        } while (std::next_permutation(j.begin(), j.end()));
    } while (std::next_permutation(i.begin(), i.end()));
}

}  // namespace

TEST(TriangleContact, WithNoCommonCorner)
{
    expect_contact(kBase, {{{{0, 0, 1}}, {{4, 0, 1}}, {{0, 4, 1}}}}, Disjoint);
    expect_contact(kBase, {{{{1, 1, -1}}, {{1, 1, 1}}, {{9, 9, 1}}}}, Crossing);
    // Both planes are cut, but beside the other triangle.
    expect_contact(kBase, {{{{5, 5, -1}}, {{5, 5, 1}}, {{9, 9, 1}}}}, Disjoint);
    // A corner on the inside, on a side, an edge in the plane.
    expect_contact(kBase, {{{{1, 1, 0}}, {{1, 1, 3}}, {{2, 1, 3}}}}, Crossing);
    expect_contact(kBase, {{{{2, 2, 0}}, {{2, 2, 3}}, {{3, 2, 3}}}}, Crossing);
    expect_contact(kBase, {{{{1, 1, 0}}, {{2, 1, 0}}, {{2, 1, 3}}}}, Crossing);
    expect_contact(kBase, {{{{-1, 1, 0}}, {{9, 1, 0}}, {{2, 1, 3}}}}, Crossing);
    expect_contact(kBase, {{{{5, 5, 0}}, {{9, 1, 0}}, {{2, 1, 3}}}}, Disjoint);
    // Side against side in one point.
    expect_contact(kBase, {{{{2, 0, -1}}, {{2, 0, 1}}, {{2, -3, 0}}}}, Crossing);
}

TEST(TriangleContact, InOnePlane)
{
    expect_contact(kBase, {{{{1, 1, 0}}, {{2, 1, 0}}, {{1, 2, 0}}}}, Crossing);  // within
    expect_contact(kBase, {{{{1, 1, 0}}, {{9, 1, 0}}, {{9, 2, 0}}}}, Crossing);  // overlaps
    expect_contact(kBase, {{{{5, 5, 0}}, {{9, 1, 0}}, {{9, 2, 0}}}}, Disjoint);
    expect_contact(kBase, {{{{2, 2, 0}}, {{9, 3, 0}}, {{9, 4, 0}}}}, Crossing);   // touches
    expect_contact(kBase, {{{{1, 0, 0}}, {{2, 0, 0}}, {{1, -1, 0}}}}, Crossing);  // side on side
    expect_contact(kBase, {{{{-9, -9, 0}}, {{20, -9, 0}}, {{-9, 20, 0}}}}, Crossing);
}

TEST(TriangleContact, WithOneCommonCorner)
{
    const Vec3 o{{0, 0, 0}};
    expect_contact(kBase, {{o, {{1, 1, 1}}, {{2, 1, 1}}}}, SharedCorner);
    expect_contact(kBase, {{o, {{-1, 0, 1}}, {{-1, 0, -1}}}}, SharedCorner);
    expect_contact(kBase, {{o, {{1, 1, 1}}, {{1, 1, -1}}}}, Crossing);      // cuts through
    expect_contact(kBase, {{o, {{9, 9, 9}}, {{9, 9, -9}}}}, Crossing);      // the long way
    expect_contact(kBase, {{o, {{1, 1, 0}}, {{1, 1, 1}}}}, Crossing);       // side within
    expect_contact(kBase, {{o, {{2, 0, 0}}, {{1, 1, 1}}}}, Crossing);       // side on side
    expect_contact(kBase, {{o, {{-2, 0, 0}}, {{1, 1, 1}}}}, SharedCorner);  // side opposite
    expect_contact(kBase, {{o, {{-2, 0, 0}}, {{0, -1, 0}}}}, SharedCorner);
    expect_contact(kBase, {{o, {{-2, 0, 0}}, {{1, 1, 0}}}}, Crossing);
    expect_contact(kBase, {{o, {{9, -1, 0}}, {{-1, 9, 0}}}}, Crossing);  // holds the angle
    expect_contact(kBase, {{o, {{1, 0, 0}}, {{1, -1, 0}}}}, Crossing);   // part of a side
    expect_contact(kBase, {{{{4, 0, 0}}, {{0, 4, 1}}, {{-3, 0, -1}}}}, Crossing);
}

TEST(TriangleContact, WithACommonSide)
{
    const Vec3 o{{0, 0, 0}}, e{{4, 0, 0}};
    expect_contact(kBase, {{o, e, {{1, 1, 1}}}}, SharedSide);
    expect_contact(kBase, {{o, e, {{1, -1, 0}}}}, SharedSide);
    expect_contact(kBase, {{o, e, {{1, 1, 0}}}}, Crossing);
    expect_contact(kBase, {{o, e, {{1, 1, 1e-300}}}}, SharedSide);
    expect_contact(kBase, kBase, Crossing);
}

TEST(TriangleContact, SaysNothingAboutTrianglesWithoutArea)
{
    EXPECT_EQ(triangle_contact(kBase, {{{{1, 1, 0}}, {{1, 1, 0}}, {{2, 2, 2}}}}), Degenerate);
    EXPECT_EQ(triangle_contact(kBase, {{{{0, 0, 0}}, {{4, 0, 0}}, {{2, 0, 0}}}}), Degenerate);
    EXPECT_TRUE(has_no_area({{{{0, 0, 0}}, {{1, 2, 3}}, {{3, 6, 9}}}}));
    EXPECT_FALSE(has_no_area({{{{0, 0, 0}}, {{1, 2, 3}}, {{3, 6, std::nextafter(9.0, 10.0)}}}}));
}

__extension__ using Int128 = __int128;

// Small integers make every kind of contact common; the oracle intersects exactly in integers,
// in quite another way: it clips triangle a, as a polygon with rational corners, against b.
namespace {

struct Fraction3 {  // a point with common denominator
    std::array<Int128, 3> x;
    Int128 w;
};

using Polygon3 = std::vector<Fraction3>;
using Plane = std::array<Int128, 4>;

Int128 side(const Plane& h, const Fraction3& p)
{
    return h[0] * p.x[0] + h[1] * p.x[1] + h[2] * p.x[2] + h[3] * p.w;
}

Int128 gcd(Int128 a, Int128 b)
{
    a = a < 0 ? -a : a;
    b = b < 0 ? -b : b;
    while (b != 0) std::swap(a %= b, b);
    return a;
}

Fraction3 between(const Fraction3& p, const Fraction3& q, Int128 sp, Int128 sq)
{
    Fraction3 r;
    Int128 g = 0;
    for (int i = 0; i < 3; ++i) g = gcd(g, r.x[i] = sp * q.x[i] - sq * p.x[i]);
    g = gcd(g, r.w = sp * q.w - sq * p.w);
    if (r.w < 0) g = -g;
    for (auto& x : r.x) x /= g;
    r.w /= g;
    return r;
}

// The part of a convex polygon (or segment, or point) where side >= 0.
Polygon3 clip(const Polygon3& polygon, const Plane& h)
{
    Polygon3 out;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Fraction3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const Int128 sp = side(h, p), sq = side(h, q);
        if (sp >= 0) out.push_back(p);
        if ((sp > 0 && sq < 0) || (sp < 0 && sq > 0)) out.push_back(between(p, q, sp, sq));
    }
    return out;
}

using Integer3 = std::array<Int128, 3>;

Integer3 cross_of(const Integer3& a, const Integer3& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Integer3 difference(const Vec3& a, const Vec3& b)
{
    Integer3 d;
    for (std::size_t i = 0; i < 3; ++i) d[i] = static_cast<Int128>(a[i] - b[i]);
    return d;
}

Plane plane_through(const Vec3& p, const Integer3& n)
{
    Int128 d = 0;
    for (std::size_t i = 0; i < 3; ++i) d -= n[i] * static_cast<Int128>(p[i]);
    return {n[0], n[1], n[2], d};
}

TriangleContact oracle(const TrianglePoints& a, const TrianglePoints& b)
{
    Polygon3 common;
    for (const Vec3& p : a)
        common.push_back(
            {{static_cast<Int128>(p[0]), static_cast<Int128>(p[1]), static_cast<Int128>(p[2])}, 1});
    const Integer3 n = cross_of(difference(b[1], b[0]), difference(b[2], b[0]));
    const Plane plane = plane_through(b[0], n);
    common = clip(common, plane);
    common = clip(common, {-plane[0], -plane[1], -plane[2], -plane[3]});
    for (std::size_t i = 0; i < 3; ++i)
        common = clip(common, plane_through(b[i], cross_of(n, difference(b[(i + 1) % 3], b[i]))));
    if (common.empty()) return Disjoint;
    // All corners of the common part must be shared corners: of one, or of one side.
    std::array<bool, 3> seen{};
    for (const Fraction3& p : common) {
        bool shared = false;
        for (std::size_t i = 0; i < 3; ++i) {
            bool here = p.w == 1;
            for (std::size_t k = 0; k < 3; ++k)
                here = here && p.x[k] == static_cast<Int128>(a[i][k]);
            if (!here || std::find(b.begin(), b.end(), a[i]) == b.end()) continue;
            shared = seen[i] = true;
        }
        if (!shared) return Crossing;
    }
    const int n_seen = seen[0] + seen[1] + seen[2];
    return n_seen == 1 ? SharedCorner : n_seen == 2 ? SharedSide : Crossing;
}

}  // namespace

TEST(TriangleContact, AgreesWithExactClippingOnSmallIntegers)
{
    std::mt19937 random(2024);
    std::array<int, 5> seen{};
    const int cases = std::getenv("GENUS_LONG") ? 20'000'000 : 200'000;
    for (int i = 0; i < cases; ++i) {
        const unsigned range = 2 + i % 4;
        const auto draw = [&] {
            Vec3 p;
            for (double& x : p.c) x = static_cast<double>(random() % range);
            return p;
        };
        TrianglePoints a{draw(), draw(), draw()}, b{draw(), draw(), draw()};
        if (i % 3 > 0) b[0] = a[random() % 3];
        if (i % 3 > 1) b[1] = a[random() % 3];
        const TriangleContact contact = triangle_contact(a, b);
        ++seen[static_cast<std::size_t>(contact)];
        if (has_no_area(a) || has_no_area(b)) {
            // A contact in the common plane may be settled all the same, but never wrongly.
            EXPECT_TRUE(contact == Degenerate || contact == Disjoint || contact == SharedCorner);
            continue;
        }
        ASSERT_EQ(contact, oracle(a, b)) << "case " << i;
    }
    for (const int n : seen) EXPECT_GT(n, cases / 1000);
}
