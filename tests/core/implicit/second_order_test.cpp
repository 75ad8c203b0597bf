#include "genus/implicit/second_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "core/implicit/random_expressions.h"
#include "genus/implicit/parse_expression.h"
#include "genus/implicit/smooth_parts.h"

namespace genus {
namespace {

Box3 cube_at(const Vec3& c, double half)
{
    return {c - Box3::filled(half), c + Box3::filled(half)};
}

Vec3 random_in(std::mt19937& random, const Box3& box)
{
    std::uniform_real_distribution<double> share(0.0, 1.0);
    Vec3 p;
    for (std::size_t i = 0; i < 3; ++i)
        p[i] = std::min(box.max[i], box.min[i] + share(random) * (box.max[i] - box.min[i]));
    return p;
}

// How far p is from what the model says, beyond what it allows for.
double excess(const QuadraticModel& m, const Vec3& p, double value)
{
    const Vec3 d = p - m.at;
    const auto& h = m.hessian;
    const double model = m.value + dot(m.gradient, d) +
                         0.5 * (h[0] * d[0] * d[0] + h[1] * d[1] * d[1] + h[2] * d[2] * d[2]) +
                         h[3] * d[0] * d[1] + h[4] * d[0] * d[2] + h[5] * d[1] * d[2];
    const double size = std::fabs(model) + std::fabs(value) + std::fabs(m.value);
    return std::fabs(model - value) - m.rest - 1e-13 * (size + norm(m.gradient) * norm(d));
}

bool gradient_fits(const QuadraticModel& m, const Vec3& p, const Vec3& g)
{
    const Vec3 d = p - m.at;
    const auto& h = m.hessian;
    const Vec3 model{{m.gradient[0] + h[0] * d[0] + h[3] * d[1] + h[4] * d[2],
                      m.gradient[1] + h[3] * d[0] + h[1] * d[1] + h[5] * d[2],
                      m.gradient[2] + h[4] * d[0] + h[5] * d[1] + h[2] * d[2]}};
    const double slack = 1e-11 * (norm(model) + norm(g) + norm(m.gradient));
    for (std::size_t i = 0; i < 3; ++i)
        if (std::fabs(model[i] - g[i]) > m.slope_rest[i] + slack || g[i] < m.slope[i].lo - slack ||
            g[i] > m.slope[i].hi + slack)
            return false;
    return true;
}

TEST(QuadraticModels, OneOfThemHoldsEveryValueAndGradient)
{
    std::mt19937 random(20);
    int with_models = 0, with_several = 0;
    for (int trial = 0; trial < trials(20000, 1'000'000); ++trial) {
        const Expression e = random_expression(random, 4);
        const Function f(e);
        const Box3 box = cube_at(random_point(random), std::ldexp(1.0, -1 - trial % 8));
        const std::vector<QuadraticModel> models = f.quadratic_models(box);
        if (models.empty()) continue;
        const double rounding = f.rounding_error(box);
        ++with_models;
        with_several += models.size() > 1;
        for (int n = 0; n < 8; ++n) {
            const Vec3 p = random_in(random, box);
            const double value = f.value(p);
            ASSERT_TRUE(std::isfinite(value)) << to_text(e);
            const Vec3 g = f.gradient(p);
            const double slack = std::isfinite(rounding) ? rounding : 1e-9 * std::fabs(value);
            EXPECT_TRUE(std::any_of(models.begin(), models.end(),
                                    [&](const QuadraticModel& m) {
                                        return excess(m, p, value) <= slack &&
                                               gradient_fits(m, p, g);
                                    }))
                << to_text(e) << " trial " << trial << " at " << p[0] << " " << p[1] << " " << p[2];
        }
    }
    EXPECT_GT(with_models, trials(20000, 1'000'000) / 3);
    EXPECT_GT(with_several, trials(20000, 1'000'000) / 100);
}

TEST(QuadraticModels, OfAQuadraticHaveNoRest)
{
    const Function f = compiled("x^2 + 2*x*y - 3*z^2 + y*z - x + 4");
    const auto models = f.quadratic_models(cube_at({{1, 2, 3}}, 10.0));
    ASSERT_EQ(models.size(), 1u);
    EXPECT_LT(models[0].rest, 1e-11);
    const std::array<double, 6> expected{2, 0, -6, 2, 0, 1};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(models[0].hessian[i], expected[i], 1e-14);
}

TEST(QuadraticModels, TheRestFallsWithTheThirdPowerOfTheSize)
{
    for (const char* text :
         {"sin(x)*cos(y) + sin(y)*cos(z) + sin(z)*cos(x)", "sqrt(x^2 + y^2 + z^2) - 1",
          "exp(-x^2 - y^2) + 1/(1 + z^2)", "atan2(y, x) + cbrt(z) + 2^x + tanh(y)"}) {
        const Function f = compiled(text);
        double last = 0.0;
        for (const double half : {0x1p-4, 0x1p-5, 0x1p-6}) {
            const auto models = f.quadratic_models(cube_at({{0.7, 0.4, 0.9}}, half));
            ASSERT_EQ(models.size(), 1u) << text;
            if (last > 0.0) {
                EXPECT_NEAR(last / models[0].rest, 8.0, 1.5) << text;
            }
            last = models[0].rest;
        }
    }
}

// min(a, b) and abs(a - b) ask the same question, so on the middle of the band there are two
// pieces, and these are equal.
TEST(QuadraticModels, OfASmoothUnionAreThoseOfOneSmoothFunction)
{
    const std::string a = "(x - 1)^2 + y^2 + z^2 - 1", b = "(x + 1)^2 + y^2 + z^2 - 1";
    for (const std::string& text :
         {"smin(" + a + ", " + b + ", 0.5)",
          "min(" + a + ", " + b + ") - max(0.5 - abs((" + b + ") - (" + a + ")), 0)^2/2"}) {
        const auto models = compiled(text).quadratic_models(cube_at({{0, 0.3, 0.1}}, 0.05));
        ASSERT_EQ(models.size(), 2u) << text;
        EXPECT_NEAR(models[0].value, models[1].value, 1e-14);
        for (std::size_t i = 0; i < 6; ++i)
            EXPECT_NEAR(models[0].hessian[i], models[1].hessian[i], 1e-13);
    }
}

TEST(QuadraticModels, RepetitionHasAPieceOnEitherSideOfABorder)
{
    const Function f = compiled("repeat(x, 1)^2 + y^2 - 0.1");
    EXPECT_EQ(f.quadratic_models(cube_at({{0.2, 0, 0}}, 0.1)).size(), 1u);
    const auto models = f.quadratic_models(cube_at({{0.5, 0, 0}}, 0.1));
    ASSERT_EQ(models.size(), 2u);
    EXPECT_NEAR(models[0].gradient[0], 1.0, 1e-14);
    EXPECT_NEAR(models[1].gradient[0], -1.0, 1e-14);
}

TEST(QuadraticModels, ThereAreNoneAtPolesEndsOfRootsAndPlacesOfManyPieces)
{
    const Box3 box = cube_at({{0, 0, 0}}, 0.1);
    for (const char* text : {"1/x", "sqrt(x)", "log(x)", "cbrt(x)", "asin(x + 1)", "floor(100*x)",
                             "abs(x) + abs(y) + abs(z) + abs(x - y)", "sqrt(x^2 + y^2 + z^2)"})
        EXPECT_TRUE(compiled(text).quadratic_models(box).empty()) << text;
}

TEST(Function, ASquareBelowLeavesTheSignOfAQuotient)
{
    const Function f = compiled("1 - 1/(x^2 + y^2 + z^2)");
    EXPECT_LT(f.bound(cube_at({{0, 0, 0}}, 0.1)).hi, 0.0);
    EXPECT_EQ(f.value({}), -std::numeric_limits<double>::infinity());
    EXPECT_EQ(compiled("1/x").value({{-0.0, 0, 0}}), std::numeric_limits<double>::infinity());
    // A root of a sum of squares is defined where that is zero.
    EXPECT_LT(compiled("sqrt(x^2 + y^2) - 1").bound(cube_at({{0, 0, 0}}, 0.1)).hi, 0.0);
}

double value_of(const SmoothParts& p, const Vec3& at)
{
    if (p.kind == SmoothParts::Kind::Leaf) return Function(p.leaf).value(at);
    double value = value_of(p.parts[0], at);
    for (const SmoothParts& part : p.parts) {
        const double v = value_of(part, at);
        value = p.kind == SmoothParts::Kind::Min ? std::min(value, v) : std::max(value, v);
    }
    return value;
}

std::size_t leaves_of(const SmoothParts& p)
{
    std::size_t n = p.kind == SmoothParts::Kind::Leaf ? 1 : 0;
    for (const SmoothParts& part : p.parts) n += leaves_of(part);
    return n;
}

TEST(SmoothParts, HaveTheValueOfTheWhole)
{
    std::mt19937 random(21);
    int with_parts = 0;
    for (int trial = 0; trial < trials(5000, 300'000); ++trial) {
        const Expression e = random_expression(random, 5);
        const Box3 box = cube_at(random_point(random), 0.5);
        const SmoothParts parts = smooth_parts(e, box);
        if (parts.kind == SmoothParts::Kind::Leaf) continue;
        ++with_parts;
        const Function f(e);
        for (int n = 0; n < 4; ++n) {
            const Vec3 p = random_in(random, box);
            const double value = f.value(p);
            EXPECT_NEAR(value_of(parts, p), value, 1e-12 * (1.0 + std::fabs(value))) << to_text(e);
        }
    }
    EXPECT_GT(with_parts, trials(5000, 300'000) / 50);
}

TEST(SmoothParts, AreTakenOutOfWhatIsMonotone)
{
    const Box3 box = cube_at({{0, 0, 0}}, 2.0);
    const auto n_leaves = [&](const std::string& text) {
        return leaves_of(smooth_parts(parse_expression(text), box));
    };
    EXPECT_EQ(n_leaves("abs(sin(x)*cos(y)) - 0.3"), 2u);
    EXPECT_EQ(n_leaves("abs(x) + abs(y) + abs(z) - 1"), 8u);
    EXPECT_EQ(n_leaves("max(abs(x) - 1, abs(y) - 0.8, abs(z) - 0.6)"), 6u);
    EXPECT_EQ(n_leaves("-3*min(x, max(y, z)) + x/2"), 3u);
    EXPECT_EQ(n_leaves("exp(max(abs(x), abs(y))) + z^2 - 2"), 4u);
    EXPECT_EQ(n_leaves("acos(min(sin(x), cos(y))) - 1"), 2u);
    // These are smooth where it counts, or another function.
    EXPECT_EQ(n_leaves("smin(x, y, 0.1)"), 1u);
    EXPECT_EQ(n_leaves("sqrt(max(x, 0)^2 + max(y, 0)^2) - 0.2"), 1u);
    EXPECT_EQ(n_leaves("x*min(y, z)"), 1u);
    EXPECT_EQ(n_leaves("min(x, sqrt(y))"), 1u);
    EXPECT_EQ(n_leaves("min(x, 1/y)"), 1u);
    EXPECT_EQ(n_leaves("max(smin(x, y, 0.1), z - 1)"), 2u);
    std::string many = "0";
    for (int i = 0; i < 9; ++i) many += " + abs(x - " + std::to_string(i) + ")";
    EXPECT_EQ(n_leaves(many), 1u);
}

// An expression of 60 operations that has 2^60 ways through it: nobody is to go them.
TEST(SmoothParts, OfExpressionsThatUseTheirPartsTwiceEnd)
{
    const Box3 box = cube_at({{0, 0, 0}}, 2.0);
    const auto doubled = [&](Operation operation) {
        Expression e = parse_expression("abs(x)");
        for (int i = 0; i < 60; ++i) e = Expression::apply(operation, e, e);
        return leaves_of(smooth_parts(e, box));
    };
    EXPECT_LE(doubled(Operation::Min), 64u);
    EXPECT_EQ(doubled(Operation::Add), 1u);
    EXPECT_EQ(doubled(Operation::Multiply), 1u);
}

}  // namespace
}  // namespace genus
