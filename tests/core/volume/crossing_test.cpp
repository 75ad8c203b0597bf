#include "genus/volume/crossing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace genus {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The root, with the number of calls it took.
struct Found {
    double t;
    int calls;
};
Found find(const std::function<double(double)>& f)
{
    int calls = 0;
    const double t = find_root(
        [&](double x) {
            ++calls;
            return f(x);
        },
        f(0.0), f(1.0));
    return {t, calls};
}

// Does the sign change within a unit of rounding of t?
bool changes_at(const std::function<double(double)>& f, double t)
{
    const double low = std::max(0.0, t - 0x1p-51), high = std::min(1.0, t + 0x1p-51);
    return (f(low) < 0.0) != (f(high) < 0.0) || f(t) == 0.0;
}

TEST(FindRoot, TakesFewCallsForSmoothFunctions)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<double> number(-1, 1);
    int linear = 0, smooth = 0, n = 0;
    while (n < 1000) {
        const double a = number(random), b = 2 * number(random), c = 0.5 * number(random);
        const auto line = [&](double t) { return a + b * t; };
        const auto curve = [&](double t) { return a + b * t + c * t * t * std::sin(2 * t); };
        if ((line(0) < 0) == (line(1) < 0) || (curve(0) < 0) == (curve(1) < 0)) continue;
        ++n;
        const Found x = find(line), y = find(curve);
        ASSERT_TRUE(changes_at(line, x.t));
        ASSERT_TRUE(changes_at(curve, y.t));
        linear += x.calls;
        smooth += y.calls;
    }
    EXPECT_LE(linear, 4 * n);
    EXPECT_LE(smooth, 8 * n);
}

TEST(FindRoot, EndsForAnyFunction)
{
    const std::function<double(double)> odd[] = {
        [](double t) { return t < 0.3 ? -1.0 : 1.0; },
        [](double t) { return t < 0.7 ? -kInfinity : kInfinity; },
        [](double t) { return t < 0.1 ? -1e-300 : 1e300; },
        [](double t) { return t < 0.5 ? -1.0 : std::nan(""); },
        [](double t) { return std::pow(t - 0.4, 25.0); },
        [](double t) { return std::cbrt(t - 1e-9); },
        [](double t) { return 1e-3 - t * t * t; },
        [](double t) { return t - 1.0; },
        [](double t) { return t == 0.0 ? -1.0 : 1.0; },
    };
    for (const auto& f : odd) {
        const Found found = find(f);
        EXPECT_TRUE(changes_at(f, found.t)) << found.t;
        EXPECT_LE(found.calls, 120);
    }
}

}  // namespace
}  // namespace genus
