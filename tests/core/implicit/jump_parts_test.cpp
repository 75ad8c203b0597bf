#include "genus/implicit/jump_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "core/implicit/random_expressions.h"
#include "genus/implicit/function.h"
#include "genus/implicit/half_space_of.h"
#include "genus/implicit/parse_expression.h"
#include "genus/implicit/solid_parts.h"

namespace genus {
namespace {

const Box3 kBox{{{-2.1, -1.9, -2.0}}, {{1.9, 2.0, 2.2}}};

bool is_inside(const SmoothParts& p, const Vec3& at)
{
    if (p.kind == SmoothParts::Kind::Leaf) {
        const double value = Function(p.leaf).value(at);
        return p.negated ? value >= 0.0 : value <= 0.0;
    }
    const bool any = p.kind == SmoothParts::Kind::Min;
    for (const SmoothParts& part : p.parts)
        if (is_inside(part, at) == any) return any;
    return !any;
}

bool has_jump(const SmoothParts& p)
{
    if (p.kind == SmoothParts::Kind::Leaf)
        return may_jump(p.leaf) && jump_at_border(Function(p.leaf), kBox).has_value();
    for (const SmoothParts& part : p.parts)
        if (has_jump(part)) return true;
    return false;
}

TEST(JumpParts, AreTheSameSolidWithoutJumps)
{
    for (const char* text :
         {"1/x", "1/x - 1", "-1/x + 1/y", "1/x + 1/y + 1/z", "x/abs(x)", "y/(x*z) - 1", "tan(x)",
          "tan(2*x) - y", "1/(x*abs(x)) + 1", "(1/x)^3 - 2", "mod(x, 1) - 0.5", "floor(x)",
          "ceil(x)*y", "round(x) - y", "sign(x*y) + z/3", "mod(x, 1) + mod(y, 1) - 1",
          "floor(x) + floor(y)", "floor(floor(x)/2 + y)", "max(mod(x, 1) - 0.5, x^2 + y^2 - 1)",
          "min(1/x, floor(y)) + 0.1", "x^2 + y^2 + z^2 - 1 - 0.1*sign(x)", "sqrt(x) - 1",
          "sqrt(x - y) + log(z) - 0.3", "log(x)", "sqrt(sqrt(x) - 0.5) - y",
          // Bounds that are huge in one place say nothing of another.
          "max(exp(20*x) - 2, floor(y))", "sqrt(exp(max(y, -2))) - sinh(abs(log(z)))",
          "0*floor(x) - y"}) {
        SCOPED_TRACE(text);
        const Expression e = parse_expression(text);
        const Function f(e);
        EXPECT_TRUE(jump_at_border(f, kBox) || std::string(text) == "0*floor(x) - y");
        const SmoothParts parts = solid_parts(e, kBox);
        EXPECT_FALSE(has_jump(parts));
        std::mt19937 random(7);
        for (int n = 0; n < 2000; ++n) {
            Vec3 p;
            for (std::size_t i = 0; i < 3; ++i)
                p[i] = std::uniform_real_distribution(kBox.min[i], kBox.max[i])(random);
            ASSERT_EQ(is_inside(parts, p), f.value(p) <= 0.0) << p[0] << ' ' << p[1] << ' ' << p[2];
        }
    }
}

TEST(JumpParts, OfAnyExpressionAreTheSameSolid)
{
    std::mt19937 random(22);
    int cut = 0;
    const int trials = std::getenv("GENUS_LONG") ? 50'000 : 400;
    for (int trial = 0; trial < trials; ++trial) {
        const Expression e = random_expression(random, 4);
        if (!may_jump(e)) continue;
        const Vec3 middle = random_point(random);
        const Box3 box = Box3{middle, middle}.inflated(0.5);
        const SmoothParts parts = solid_parts(e, box);
        if (parts.kind == SmoothParts::Kind::Leaf || smooth_parts(e, box).parts.size() > 1)
            continue;
        ++cut;
        const Function f(e);
        for (int n = 0; n < 20; ++n) {
            Vec3 p;
            for (std::size_t i = 0; i < 3; ++i)
                p[i] = std::uniform_real_distribution(box.min[i], box.max[i])(random);
            const double value = f.value(p);
            if (std::fabs(value) < 1e-9) continue;  // rounding may differ
            ASSERT_EQ(is_inside(parts, p), value <= 0.0) << to_text(e) << " trial " << trial;
        }
    }
    EXPECT_GT(cut, trials / 100);
}

// Periods and poles that are no border leave a function whole: its own bounds say more.
TEST(JumpParts, AreNotCutWhereTheSignStays)
{
    for (const char* text : {"repeat(x, 1)^2 + y^2 + z^2 - 0.09", "1 <= 1/(x^2 + y^2 + z^2)",
                             "sqrt(x^2 + y^2) - 1", "cbrt(x)", "1/x^2 - 3", "sqrt(abs(x)) - 1"}) {
        SCOPED_TRACE(text);
        EXPECT_FALSE(jump_at_border(Function(parse_expression(text)), kBox));
    }
    const Expression periods = parse_expression("repeat(x, 1)^2 + y^2 + z^2 - 0.09");
    EXPECT_EQ(solid_parts(periods, kBox).kind, SmoothParts::Kind::Leaf);
}

TEST(JumpParts, StayWholeWhereTheyWouldBeTooMany)
{
    for (const char* text : {"mod(1000*x, 1) - 0.5", "sin(1/x)", "floor(1/x)", "exp(1/x) - 2",
                             "floor(min(1, x)) + y"}) {
        SCOPED_TRACE(text);
        const Expression e = parse_expression(text);
        EXPECT_EQ(solid_parts(e, kBox).kind, SmoothParts::Kind::Leaf);
        // Next to a pole a sine has no jump, but more zeros than anyone can follow.
        EXPECT_EQ(jump_at_border(Function(e), kBox).has_value(), std::string(text) != "sin(1/x)");
    }
}

TEST(JumpParts, OfAPeriodAreBetweenThePlanesThatCount)
{
    const SmoothParts slabs = solid_parts(parse_expression("mod(x, 1) - 0.5"), kBox);
    ASSERT_EQ(slabs.parts.size(), 4u);  // from -2, -1, 0, 1; the part of -3 in the box is outside
    // The zero is below the next jump, so that this is no border.
    for (const SmoothParts& slab : slabs.parts) {
        EXPECT_LE(slab.parts.size(), 2u);
        for (const SmoothParts& side : slab.parts) EXPECT_TRUE(half_space_of(side.leaf));
    }
}

std::size_t n_leaves(const SmoothParts& p)
{
    if (p.kind == SmoothParts::Kind::Leaf) return 1;
    std::size_t n = 0;
    for (const SmoothParts& part : p.parts) n += n_leaves(part);
    return n;
}

// What others leave without volume is dropped, whether it touches them or is out of their reach.
TEST(JumpParts, WithoutVolumeAreDropped)
{
    const Box3 box{{{-2, -2, -2}}, {{2, 2, 2}}};
    const struct {
        const char* text;
        std::size_t leaves;
    } cases[] = {
        // The ball and its halves: x <= -1/2; 0 <= x <= 1/2. At x = 1 and -1 planes touch it.
        {"max(mod(x, 1) - 0.5, x^2 + y^2 + z^2 - 1)", 4},
        // A cylinder between planes; on x = 1 and -1 only its axis would be left.
        {"round(x)^2 + y^2 + z^2 - 1", 3},
        {"max(floor(x), x^2 + y^2 + z^2 - 1)", 1},
        {"max(floor(x + 1), 1 - x^2 - y^2 - z^2)", 2},
    };
    for (const auto& c : cases) {
        SCOPED_TRACE(c.text);
        const Expression e = parse_expression(c.text);
        const SmoothParts parts = solid_parts(e, box);
        EXPECT_EQ(n_leaves(parts), c.leaves);
        const Function f(e);
        std::mt19937 random(5);
        std::uniform_real_distribution coordinate(-2.0, 2.0);
        for (int n = 0; n < 2000; ++n) {
            const Vec3 p{{coordinate(random), coordinate(random), coordinate(random)}};
            ASSERT_EQ(is_inside(parts, p), f.value(p) <= 0.0) << p[0] << ' ' << p[1] << ' ' << p[2];
        }
    }
}

TEST(HalfSpaceOf, IsThatOfPolynomialsOfDegreeOne)
{
    const auto half = half_space_of(parse_expression("2*(x - 3*y)/4 - (1 - z) + 0*x"));
    ASSERT_TRUE(half);
    EXPECT_TRUE(half->is_linear());
    EXPECT_DOUBLE_EQ(half->value({{1, 2, 3}}), -2.5 + 2.0);
    for (const char* text : {"x*y", "x^2", "sin(x)", "1", "x/y", "abs(x)", "x - x", "x/0"})
        EXPECT_FALSE(half_space_of(parse_expression(text))) << text;
}

// min(e, e) is e, sixty times over: neither choices nor instructions add up.
TEST(Expression, MinimaOfEqualOperandsAreThese)
{
    const Expression x = Expression::x();
    Expression e = Expression::apply(Operation::Abs, x), same = e;
    for (int n = 0; n < 60; ++n) e = max(min(e, e), e);
    EXPECT_EQ(Function(e), Function(same));
    // Also where they were written twice.
    const auto twice = [](const char* text) { return Function(parse_expression(text)); };
    EXPECT_EQ(twice("min(sin(x)*y, y*sin(x))"), twice("sin(x)*y"));
}

}  // namespace
}  // namespace genus
