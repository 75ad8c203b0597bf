#include "genus/base/interval.h"

#include <gtest/gtest.h>

#include <random>

namespace genus {
namespace {

// Real arithmetic checked by long double: 64 bits of mantissa see the rounding of doubles.
TEST(Interval, HoldsTheExactImageOfItsOperands)
{
    std::mt19937_64 random(21);
    std::uniform_real_distribution<double> mantissa(-2.0, 2.0);
    std::uniform_int_distribution<int> exponent(-40, 40);
    const auto number = [&] { return std::ldexp(mantissa(random), exponent(random)); };
    for (int trial = 0; trial < 200000; ++trial) {
        const double x = number(), y = number();
        const long double lx = x, ly = y;
        const auto holds = [&](const Interval& i, long double exact) {
            return i.lo <= exact && exact <= i.hi;
        };
        ASSERT_TRUE(holds(Interval(x) + y, lx + ly)) << x << " " << y;
        ASSERT_TRUE(holds(Interval(x) - y, lx - ly)) << x << " " << y;
        ASSERT_TRUE(holds(Interval(x) * y, lx * ly)) << x << " " << y;
        ASSERT_TRUE(holds(Interval(x) / y, lx / ly)) << x << " " << y;
        ASSERT_TRUE(holds(square(Interval(x)), lx * lx)) << x;
        ASSERT_TRUE(holds(sqrt(Interval(std::fabs(x))), std::sqrt(std::fabs(lx)))) << x;
    }
}

TEST(Interval, OperationsHoldAllPairsOfTheirOperands)
{
    std::mt19937_64 random(22);
    std::uniform_real_distribution<double> number(-3.0, 3.0);
    const auto interval = [&] {
        const double a = number(random), b = number(random);
        return Interval(std::min(a, b), std::max(a, b));
    };
    for (int trial = 0; trial < 20000; ++trial) {
        const Interval a = interval(), b = interval();
        for (const double s : {0.0, 0.3, 1.0})
            for (const double t : {0.0, 0.7, 1.0}) {
                const double x = std::lerp(a.lo, a.hi, s), y = std::lerp(b.lo, b.hi, t);
                ASSERT_TRUE((a + b).contains(x + y));
                ASSERT_TRUE((a - b).contains(x - y));
                ASSERT_TRUE((a * b).contains(x * y));
                ASSERT_TRUE(min(a, b).contains(std::min(x, y)));
                ASSERT_TRUE(max(a, b).contains(std::max(x, y)));
                ASSERT_TRUE(abs(a).contains(std::fabs(x)));
                ASSERT_TRUE(square(a).contains(x * x));
                if (y != 0.0) {
                    ASSERT_TRUE((a / b).contains(x / y));
                }
            }
    }
}

TEST(Interval, StaysSoundAtTheEdgesOfTheDoubles)
{
    const double huge = std::numeric_limits<double>::max();
    const double tiny = std::numeric_limits<double>::denorm_min();
    const Interval overflow = Interval(huge) * Interval(2.0);
    EXPECT_EQ(overflow.lo, huge);
    EXPECT_TRUE(std::isinf(overflow.hi));
    const Interval underflow = Interval(tiny) * Interval(0.25);
    EXPECT_LE(underflow.lo, 0.0);
    EXPECT_GE(underflow.hi, tiny);
    const Interval unknown = Interval::everything() - Interval::everything();
    EXPECT_TRUE(unknown.contains(0.0) && unknown.contains(huge) && unknown.contains(-huge));
    EXPECT_EQ(Interval::everything() * Interval(0.0), Interval(rounding::down(0), rounding::up(0)));
    EXPECT_EQ(Interval(1.0) / Interval(-1.0, 1.0), Interval::everything());
}

}  // namespace
}  // namespace genus
