#include "genus/base/predicates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace genus {
namespace {

__extension__ using Wide = __int128;

int sign(Wide x)
{
    return (x > 0) - (x < 0);
}

// Integers up to 2^29 times a power of two: the determinants fit in 128 bits.
class Lattice {
public:
    Lattice(unsigned seed, int spread, int exponent)
        : random_(seed), step_(std::ldexp(1.0, exponent)), digit_(-spread, spread)
    {
    }
    std::int64_t integer() { return digit_(random_); }
    double real(std::int64_t n) const { return static_cast<double>(n) * step_; }

private:
    std::mt19937 random_;
    double step_;
    std::uniform_int_distribution<std::int64_t> digit_;
};

Wide minor2(const std::int64_t (&p)[4][3], int i, int j)
{
    const auto d = [&](int v, int k) { return Wide(p[v][k]) - p[3][k]; };
    return d(i, 0) * d(j, 1) - d(i, 1) * d(j, 0);
}

TEST(Predicates, Orient3dAgreesWithIntegersAtEveryScale)
{
    for (const int spread : {2, 1000, 1 << 29})
        for (const int exponent : {-100, 0, 80}) {
            SCOPED_TRACE(testing::Message() << "spread " << spread << " exponent " << exponent);
            Lattice lattice(7, spread, exponent);
            for (int trial = 0; trial < 4000; ++trial) {
                std::int64_t p[4][3];
                Vec3 v[4];
                for (int i = 0; i < 4; ++i)
                    for (int k = 0; k < 3; ++k) {
                        p[i][k] = lattice.integer();
                        v[i][k] = lattice.real(p[i][k]);
                    }
                const auto z = [&](int i) { return Wide(p[i][2]) - p[3][2]; };
                const Wide det =
                    z(0) * minor2(p, 1, 2) + z(1) * minor2(p, 2, 0) + z(2) * minor2(p, 0, 1);
                ASSERT_EQ(orient3d(v[0], v[1], v[2], v[3]), sign(det));
            }
        }
}

TEST(Predicates, Orient3dSeesOneUnitInTheLastPlace)
{
    // Points of the plane x + y + z = 1.5, far from its origin, where doubles can say so exactly.
    const Vec3 a{{0.5, 0.5, 0.5}}, b{{12.25, -10.75, 0.0}}, c{{24.0, 24.0, -46.5}};
    Vec3 d{{-7.5, 8.25, 0.75}};
    EXPECT_EQ(orient3d(a, b, c, d), 0);
    const double exact = d[2];
    d[2] = std::nextafter(exact, 10.0);
    const int above = orient3d(a, b, c, d);
    d[2] = std::nextafter(exact, -10.0);
    EXPECT_EQ(orient3d(a, b, c, d), -above);
    EXPECT_NE(above, 0);
}

TEST(Predicates, Orient3dIsPositiveBelowACounterclockwiseTriangle)
{
    const Vec3 a{{0, 0, 0}}, b{{1, 0, 0}}, c{{0, 1, 0}};
    EXPECT_EQ(orient3d(a, b, c, {{0.2, 0.2, -1}}), 1);
    EXPECT_EQ(orient3d(a, b, c, {{0.2, 0.2, 1}}), -1);
}

TEST(Predicates, Orient2dIsAntisymmetricNearALine)
{
    // The grid of [shewchuk1997]: naive evaluation gives all three signs in a jumble here.
    const Vec2 b{{12, 12}}, c{{24, 24}};
    for (int i = 0; i < 64; ++i)
        for (int j = 0; j < 64; ++j) {
            const Vec2 a{{0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53}};
            // b and c lie on y = x: the turn depends on the side of that line alone.
            EXPECT_EQ(orient2d(a, b, c), (a[1] > a[0]) - (a[1] < a[0])) << i << " " << j;
            EXPECT_EQ(orient2d(b, a, c), -orient2d(a, b, c));
        }
}

TEST(Predicates, InCircleAgreesWithIntegers)
{
    Lattice lattice(11, 4000, 0);
    for (int trial = 0; trial < 20000; ++trial) {
        std::int64_t p[4][2];
        Vec2 v[4];
        for (int i = 0; i < 4; ++i)
            for (int k = 0; k < 2; ++k) {
                p[i][k] = lattice.integer() % (trial % 2 ? 4 : 4001);
                v[i][k] = lattice.real(p[i][k]);
            }
        const auto x = [&](int i) { return Wide(p[i][0]) - p[3][0]; };
        const auto y = [&](int i) { return Wide(p[i][1]) - p[3][1]; };
        const auto lift = [&](int i) { return x(i) * x(i) + y(i) * y(i); };
        const auto minor = [&](int i, int j) { return x(i) * y(j) - y(i) * x(j); };
        const Wide det = lift(0) * minor(1, 2) + lift(1) * minor(2, 0) + lift(2) * minor(0, 1);
        ASSERT_EQ(in_circle(v[0], v[1], v[2], v[3]), sign(det));
    }
}

TEST(Predicates, FourPointsOnACircleAreOnIt)
{
    EXPECT_EQ(in_circle({{5, 0}}, {{0, 5}}, {{-5, 0}}, {{3, 4}}), 0);
    EXPECT_EQ(in_circle({{5, 0}}, {{0, 5}}, {{-5, 0}}, {{3, std::nextafter(4.0, 0.0)}}), 1);
    EXPECT_EQ(in_circle({{5, 0}}, {{0, 5}}, {{-5, 0}}, {{3, std::nextafter(4.0, 5.0)}}), -1);
}

}  // namespace
}  // namespace genus
