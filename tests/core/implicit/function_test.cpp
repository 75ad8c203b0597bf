#include "genus/implicit/function.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <string_view>

#include "core/implicit/random_expressions.h"
#include "genus/base/error.h"
#include "genus/implicit/parse_expression.h"

namespace genus {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(ParseExpression, MeansWhatItSays)
{
    const struct {
        const char* text;
        std::function<double(double, double, double)> meant;
    } cases[] = {
        {"x^2 + y^2 - 1", [](double x, double y, double) { return x * x + y * y - 1; }},
        {"-x^2", [](double x, double, double) { return -(x * x); }},
        {"2^-1 * x", [](double x, double, double) { return 0.5 * x; }},
        {"2^3^2 - 512 + x", [](double x, double, double) { return x; }},
        {"x - y - z", [](double x, double y, double z) { return x - y - z; }},
        {"x / y / z", [](double x, double y, double z) { return x / y / z; }},
        {"--x + +y", [](double x, double y, double) { return x + y; }},
        {"sin(x)*cos( y )+tan(z)",
         [](double x, double y, double z) { return std::sin(x) * std::cos(y) + std::tan(z); }},
        {"atan2(y, x)", [](double x, double y, double) { return std::atan2(y, x); }},
        {"exp(x) + log(y^2 + 1)",
         [](double x, double y, double) { return std::exp(x) + std::log(y * y + 1); }},
        {"min(x, y, z)",
         [](double x, double y, double z) {
             return std::min({x, y, z});
         }},
        {"max(x, y) - clamp(z, -1, 1)",
         [](double x, double y, double z) { return std::max(x, y) - std::clamp(z, -1.0, 1.0); }},
        {"hypot(x, y, z) - 1",
         [](double x, double y, double z) { return std::sqrt(x * x + y * y + z * z) - 1; }},
        {"mod(x, 1)", [](double x, double, double) { return x - std::floor(x); }},
        {"x % 1", [](double x, double, double) { return x - std::floor(x); }},
        {"repeat(x, 2)", [](double x, double, double) { return x - 2 * std::floor(x / 2 + 0.5); }},
        {"mix(x, y, 0.25)", [](double x, double y, double) { return x + 0.25 * (y - x); }},
        {"abs(x)**3", [](double x, double, double) { return std::fabs(x * x * x); }},
        {"x^2 + y^2 <= 1 - z^2",
         [](double x, double y, double z) { return x * x + y * y - (1 - z * z); }},
        {"z >= x", [](double x, double, double z) { return x - z; }},
        {"1e1*x - .5e+1 * pi / tau", [](double x, double, double) { return 10 * x - 2.5; }},
        {"log2(x^2) - log10(100) - ln(e)",
         [](double x, double, double) { return std::log2(x * x) - 3; }},
    };
    std::mt19937 random(1);
    for (const auto& c : cases) {
        const Function f = compiled(c.text);
        for (int n = 0; n < 20; ++n) {
            const Vec3 p = random_point(random);
            const double meant = c.meant(p[0], p[1], p[2]);
            EXPECT_NEAR(f.value(p), meant, 1e-13 * (1 + std::fabs(meant))) << c.text;
        }
    }
}

TEST(ParseExpression, NamesTheColumnOfAMistake)
{
    const auto problem = [](std::string_view text) {
        try {
            parse_expression(text);
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(problem("x^2 + q - 1"), "implicit: column 7: unknown name 'q'");
    EXPECT_EQ(problem("x +"), "implicit: column 4: the formula ends where a value is expected");
    EXPECT_EQ(problem(""), "implicit: column 1: the formula ends where a value is expected");
    EXPECT_EQ(problem("(x"), "implicit: column 3: expected ')', found end of the formula");
    EXPECT_EQ(problem("x y"), "implicit: column 3: unexpected 'y'");
    EXPECT_EQ(problem("2x"), "implicit: column 2: unexpected 'x' after a number");
    EXPECT_EQ(problem("sin"), "implicit: column 4: expected '(', found end of the formula");
    EXPECT_EQ(problem("sin(x, y)"), "implicit: column 1: 'sin' takes 1 argument, not 2");
    EXPECT_EQ(problem("max()"), "implicit: column 1: 'max' takes 1 argument or more, not 0");
    EXPECT_EQ(problem("x \xc3\xa4"), "implicit: column 3: unexpected character with code 195");
    EXPECT_EQ(problem("1e999"), "implicit: column 1: the number is out of range");
    EXPECT_EQ(problem("x = y = z"), "implicit: column 7: unexpected '='");
    EXPECT_EQ(problem(std::string(301, '(')), "implicit: column 201: nested deeper than 200");
    EXPECT_EQ(problem(std::string(2'000'000, ' ')),
              "implicit: the formula is longer than 10^6 characters");
}

TEST(ParseExpression, EndsInAnAnswerOrANamedErrorForAnyText)
{
    const std::string letters = "xyz0123456789.+-*/^%()<=, sincomaxpe\n\t";
    std::uniform_int_distribution<std::size_t> letter(0, letters.size() - 1), length(0, 40);
    int read = 0;
    for (int trial = 0; trial < trials(20'000, 1'000'000); ++trial) {
        std::mt19937 random(trial);
        std::string text;
        for (std::size_t n = length(random); n > 0; --n) text += letters[letter(random)];
        try {
            const Expression e = parse_expression(text);
            // What is written is read back as the same function.
            EXPECT_EQ(Function(parse_expression(to_text(e))), Function(e)) << text;
            ++read;
        } catch (const InvalidInput&) {
        }
    }
    EXPECT_GT(read, 100);
}

TEST(Function, ComputesEqualPartsOnce)
{
    EXPECT_EQ(compiled("sin(x) + sin(x)*sin(x)").n_instructions(), 4u);
    EXPECT_EQ(compiled("(x + y)^2 - (y + x)^2").n_instructions(), 5u);
    // A sum of halves, written out 2^60 terms long.
    Expression e = Expression::x();
    for (int n = 0; n < 60; ++n) e = Expression(0.5) * e + Expression(0.5) * e;
    const Function f(e);
    EXPECT_LT(f.n_instructions(), 200u);
    EXPECT_EQ(f.value({{3, 0, 0}}), 3.0);
}

TEST(Function, TakesAnyDepth)
{
    const auto sum = [](int n) {
        Expression e = 0.0;
        for (double k = 1; k <= n; ++k) e = e + Expression::x() * k;
        return e;
    };
    EXPECT_EQ(Function(sum(50'000)).value({{1, 0, 0}}), 50'000.0 * 50'001.0 / 2.0);
    if (std::getenv("GENUS_LONG")) {
        EXPECT_THROW(Function(sum(400'000)), InvalidInput);
    }
}

TEST(Function, ABatchHasTheSameBits)
{
    std::mt19937 random(2);
    for (int trial = 0; trial < 200; ++trial) {
        const Function f(random_expression(random, 5));
        std::vector<Vec3> points(301);
        for (Vec3& p : points) p = random_point(random);
        std::vector<double> values(points.size());
        f.values(points, values);
        for (std::size_t n = 0; n < points.size(); ++n)
            ASSERT_EQ(values[n], f.value(points[n])) << to_text(f.expression());
    }
}

TEST(Function, BoundsHoldAllValues)
{
    for (int trial = 0; trial < trials(4'000, 400'000); ++trial) {
        std::mt19937 random(trial);
        const Function f(random_expression(random, 5));
        std::uniform_real_distribution<double> logarithm(-12, 1);
        const Vec3 centre = random_point(random, 3.0);
        const double size = std::pow(10.0, logarithm(random));
        Box3 box{centre, centre + Vec3{{size, 0.3 * size, 2.0 * size}}};
        if (trial % 5 == 0) box.min[0] = std::floor(box.min[0]);  // integers are odd places
        const Interval bound = f.bound(box);
        for (int n = 0; n < 30; ++n) {
            Vec3 p;
            std::uniform_int_distribution<int> place(0, 4);
            for (std::size_t i = 0; i < 3; ++i)
                p[i] = std::clamp(box.min[i] + (box.max[i] - box.min[i]) * place(random) / 4.0,
                                  box.min[i], box.max[i]);
            const double v = f.value(p);
            ASSERT_TRUE(bound.contains(v))
                << "seed " << trial << ": " << to_text(f.expression()) << " is " << v << " outside "
                << bound.lo << " .. " << bound.hi;
        }
    }
}

// Where the interval gradient is bounded the function is Lipschitz: differences over the box keep
// to it, creases or not.
TEST(Function, GradientBoundsHoldAllDifferences)
{
    int tried = 0;
    for (int trial = 0; trial < trials(4'000, 400'000); ++trial) {
        std::mt19937 random(trial);
        const Function f(random_expression(random, 4));
        const Vec3 centre = random_point(random, 3.0);
        const Box3 box{centre, centre + Vec3{{0.1, 0.2, 0.05}}};
        const IntervalVec3 g = f.gradient_bound(box);
        std::uniform_real_distribution<double> share(0, 1);
        const auto inside = [&] {
            Vec3 p;
            for (std::size_t i = 0; i < 3; ++i)
                p[i] = box.min[i] + (box.max[i] - box.min[i]) * share(random);
            return p;
        };
        for (int n = 0; n < 10; ++n) {
            const Vec3 p = inside(), q = inside();
            const Interval d = dot(g, q - p);
            const double a = f.value(p), b = f.value(q);
            const double rounding = 1e-13 * (std::fabs(a) + std::fabs(b) + 1e-3);
            if (d.magnitude() > 1e6 || !std::isfinite(a) || !std::isfinite(b)) continue;
            ++tried;
            // Rounding within the expression may exceed that of its value.
            const double slack = rounding + 1e-9 * d.magnitude() + 1e-9;
            ASSERT_TRUE(d.lo - slack <= b - a && b - a <= d.hi + slack)
                << "seed " << trial << ": " << to_text(f.expression()) << ": " << b - a
                << " outside " << d.lo << " .. " << d.hi;
            for (int i = 0; i < 3; ++i) {
                const double slope = f.gradient(p)[i];
                ASSERT_TRUE(g[i].lo - 1e-6 <= slope && slope <= g[i].hi + 1e-6)
                    << "seed " << trial << ": " << to_text(f.expression()) << ": " << slope
                    << " outside " << g[i].lo << " .. " << g[i].hi;
            }
        }
    }
    EXPECT_GT(tried, 1000);
}

TEST(Function, GradientIsTheLimitOfDifferences)
{
    const char* smooth[] = {"x^3*y - z",
                            "sin(x*y) + cos(z)",
                            "exp(x - y)*tanh(z)",
                            "sqrt(x^2 + y^2 + z^2 + 1)",
                            "atan2(x, y + 5) + atan(z)",
                            "log(x^2 + 2) / (1 + y^2) - cbrt(z + 7)",
                            "sinh(x)*cosh(y)",
                            "asin(x/3) - acos(y/4) + tan(z/4)",
                            "pow(x + 4, y)",
                            "x^-3 + (y+9)^2.5",
                            "smin(x, y + 0.1*z, 7)"};
    std::mt19937 random(4);
    for (const char* text : smooth) {
        const Function f = compiled(text);
        for (int n = 0; n < 20; ++n) {
            Vec3 p = random_point(random);
            if (std::fabs(p[0]) < 0.3) p[0] = 0.5;
            const Vec3 g = f.gradient(p);
            for (std::size_t i = 0; i < 3; ++i) {
                constexpr double h = 1e-4;
                Vec3 q = p, r = p;
                q[i] += h;
                r[i] -= h;
                const double limit = (f.value(q) - f.value(r)) / (2 * h);
                EXPECT_NEAR(g[i], limit, 1e-5 * (1 + std::fabs(limit))) << text;
            }
        }
    }
}

TEST(Function, BoundsTightenLinearlyOnAKnownFunction)
{
    const Function f = compiled("sin(x)*y + z^2 - 1");
    double last = 0.0;
    for (const double h : {0.1, 0.05, 0.025, 0.0125}) {
        const double width = f.bound({{{1, 1, 1}}, {{1 + h, 1 + h, 1 + h}}}).width();
        if (last > 0.0) {
            EXPECT_NEAR(last / width, 2.0, 0.1);
        }
        last = width;
    }
}

TEST(Function, PiecesGiveItsValueAndGradient)
{
    std::mt19937 random(5);
    int creased = 0;
    for (int trial = 0; trial < 500; ++trial) {
        const Function f(random_expression(random, 5));
        for (int n = 0; n < 10; ++n) {
            const Vec3 p = random_point(random);
            const std::int32_t piece = f.piece(p);
            ASSERT_GE(piece, 0);
            creased += piece > 0;
            ASSERT_EQ(f.piece_value(piece, p), f.value(p)) << to_text(f.expression());
            ASSERT_EQ(f.piece_gradient(piece, p), f.gradient(p)) << to_text(f.expression());
        }
    }
    EXPECT_GT(creased, 100);
    // Choices that do not reach the result make no other piece.
    const Function unused = compiled("max(x - 10, min(y, z))");
    EXPECT_EQ(unused.piece({{20, 1, 2}}), unused.piece({{20, 2, 1}}));
}

TEST(Function, UndefinedIsOutside)
{
    for (const char* text :
         {"sqrt(x) - 1", "log(x)", "asin(x - 3)", "x^0.5 - 9", "min(sqrt(x), -1)",
          "-max(sqrt(x), 1)", "0*sqrt(x) - 1", "0/(x - x) - 1"}) {
        const Function f = compiled(text);
        EXPECT_EQ(f.value({{-1, 0, 0}}), kInfinity) << text;
        EXPECT_EQ(f.gradient({{-1, 0, 0}}), Vec3{}) << text;
        EXPECT_EQ(f.bound({{{-1, 0, 0}}, {{2, 1, 1}}}).hi, kInfinity) << text;
    }
}

}  // namespace
}  // namespace genus
