#include "genus/model/solid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/model/random_trees.h"
#include "genus/base/error.h"
#include "genus/model/leaf_mesh.h"

namespace genus {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

template <class F>
std::string message_of(F f)
{
    try {
        f();
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "no error";
}

TEST(Solid, ConstructorsRefuseBadNumbersAndNameThem)
{
    EXPECT_THROW(sphere(0), InvalidInput);
    EXPECT_THROW(sphere(kNan), InvalidInput);
    EXPECT_THROW(sphere(kInf), InvalidInput);
    EXPECT_THROW(sphere(1, 2), InvalidInput);
    EXPECT_THROW(sphere(1, -3), InvalidInput);
    EXPECT_THROW(cube({{1, 0, 1}}), InvalidInput);
    EXPECT_THROW(ellipsoid({{1, -1, 1}}), InvalidInput);
    EXPECT_THROW(cylinder(0, 1, 1), InvalidInput);
    EXPECT_THROW(cylinder(1, 0, 0), InvalidInput);
    EXPECT_THROW(cylinder(1, -1, 1), InvalidInput);
    EXPECT_THROW(torus(1, 1), InvalidInput);
    EXPECT_THROW(half_space({{0, 0, 0}}, 1), InvalidInput);
    EXPECT_THROW(quadric(Quadric::sphere(1), Box3{}), InvalidInput);
    EXPECT_THROW(transformed(sphere(1), scaling({{1, 0, 1}})), InvalidInput);
    EXPECT_THROW(transformed(sphere(1), perspective(90, 1, 1, 2)), InvalidInput);
    EXPECT_THROW(colored(sphere(1), {{0, 0, 2, 1}}), InvalidInput);
    PolygonMesh bad;
    bad.vertices = {Vec3{}, Vec3{{1, 0, 0}}, Vec3{{0, 1, 0}}};
    bad.starts = {0, 3};
    bad.corners = {0, 1, 3};
    EXPECT_THROW(polyhedron(bad), InvalidInput);
    EXPECT_NE(message_of([] { sphere(-2.5); }).find("sphere: r"), std::string::npos);
    EXPECT_NE(message_of([] { sphere(-2.5); }).find("-2.5"), std::string::npos);
}

TEST(Solid, EmptyPartsVanish)
{
    EXPECT_TRUE(Solid().is_empty());
    EXPECT_TRUE(unite({}).is_empty());
    EXPECT_TRUE(intersect({}).is_empty());
    EXPECT_TRUE(subtract({}).is_empty());
    EXPECT_TRUE(intersect({sphere(1), Solid()}).is_empty());
    EXPECT_TRUE(subtract({Solid(), sphere(1)}).is_empty());
    EXPECT_TRUE(transformed(Solid(), translation({{1, 0, 0}})).is_empty());
    EXPECT_EQ(unite({Solid(), sphere(1)}), sphere(1));
    EXPECT_EQ(subtract({sphere(1), Solid()}), sphere(1));
    EXPECT_TRUE(Solid().bounds().empty());
}

TEST(Solid, EqualTreesAreEqualAndHashAlike)
{
    const auto build = [](double r) {
        return subtract({unite({cube({{1, 2, 3}}), sphere(r)}),
                         transformed(cylinder(3, 1, 0.5), translation({{0, -0.0, 1}}))});
    };
    EXPECT_EQ(build(2), build(2));
    EXPECT_EQ(build(2).hash(), build(2).hash());
    EXPECT_FALSE(build(2) == build(2.5));
    EXPECT_NE(build(2).hash(), build(2.5).hash());
    EXPECT_NE(unite({sphere(1), sphere(2)}).hash(), unite({sphere(2), sphere(1)}).hash());
    EXPECT_NE(unite({sphere(1), sphere(2)}).hash(), intersect({sphere(1), sphere(2)}).hash());
    EXPECT_FALSE(sphere(1) == sphere(1, 8));
    // Zero has two signs but is one number.
    const Solid a = transformed(sphere(1), translation({{0.0, 1, 0}}));
    const Solid b = transformed(sphere(1), translation({{-0.0, 1, 0}}));
    EXPECT_EQ(a, b);
    EXPECT_EQ(a.hash(), b.hash());
}

TEST(Solid, BoundsOfPrimitivesAreExact)
{
    EXPECT_EQ(sphere(10).bounds(), (Box3{{{-10, -10, -10}}, {{10, 10, 10}}}));
    EXPECT_EQ(cube({{1, 2, 3}}).bounds(), (Box3{{{0, 0, 0}}, {{1, 2, 3}}}));
    EXPECT_EQ(cube({{1, 2, 3}}, true).bounds(), (Box3{{{-0.5, -1, -1.5}}, {{0.5, 1, 1.5}}}));
    EXPECT_EQ(cylinder(4, 1, 3).bounds(), (Box3{{{-3, -3, 0}}, {{3, 3, 4}}}));
    EXPECT_EQ(cylinder(4, 1, 3, true).bounds(), (Box3{{{-3, -3, -2}}, {{3, 3, 2}}}));
    EXPECT_EQ(torus(3, 1).bounds(), (Box3{{{-4, -4, -1}}, {{4, 4, 1}}}));
    EXPECT_EQ(ellipsoid({{1, 2, 3}}).bounds(), (Box3{{{-1, -2, -3}}, {{1, 2, 3}}}));
    EXPECT_EQ(quadric(Quadric::sphere(2)).bounds(), (Box3{{{-2, -2, -2}}, {{2, 2, 2}}}));
    EXPECT_EQ(transformed(sphere(10), translation({{5, 0, 0}})).bounds(),
              (Box3{{{-5, -10, -10}}, {{15, 10, 10}}}));
    EXPECT_EQ(transformed(cylinder(4, 1, 1), rotation_x(90)).bounds(),
              (Box3{{{-1, -4, -1}}, {{1, 0, 1}}}));
    EXPECT_EQ(half_space({{0, 2, 0}}, 5).bounds(),
              (Box3{{{-kInf, -kInf, -kInf}}, {{kInf, 2.5, kInf}}}));
    EXPECT_EQ(half_space({{0, 0, -1}}, 5).bounds(),
              (Box3{{{-kInf, -kInf, -5}}, {{kInf, kInf, kInf}}}));
    EXPECT_EQ(half_space({{1, 1, 0}}, 5).bounds(), Box3::everything());
    const Box3 pipe = quadric(Quadric::cylinder(2)).bounds();
    EXPECT_EQ(pipe, (Box3{{{-2, -2, -kInf}}, {{2, 2, kInf}}}));
}

TEST(Solid, BoundsFollowTheOperators)
{
    const Solid a = sphere(1), b = transformed(sphere(1), translation({{1, 0, 0}}));
    EXPECT_EQ(unite({a, b}).bounds(), (Box3{{{-1, -1, -1}}, {{2, 1, 1}}}));
    EXPECT_EQ(intersect({a, b}).bounds(), (Box3{{{0, -1, -1}}, {{1, 1, 1}}}));
    EXPECT_EQ(subtract({a, b}).bounds(), a.bounds());
    const Solid far = transformed(sphere(1), translation({{9, 0, 0}}));
    EXPECT_TRUE(intersect({a, far}).bounds().empty());
    const Solid rod = intersect(
        {quadric(Quadric::cylinder(1)), half_space({{0, 0, 1}}, 5), half_space({{0, 0, -1}}, 0)});
    EXPECT_EQ(rod.bounds(), (Box3{{{-1, -1, 0}}, {{1, 1, 5}}}));
}

/// Points of the shape that reach farthest along the axes, found by brute force.
Box3 sampled_box(const Solid& solid, const Transform& t)
{
    Box3 box;
    const int n = 120;
    const auto add = [&](const Vec3& p) { box.add(apply(t, p)); };
    const Shape& shape = solid.node().shape;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= n / 2; ++j) {
            const double u = 6.283185307179586 * i / n, v = 6.283185307179586 * j / n;
            const Vec3 ball{{std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v)}};
            if (const auto* s = std::get_if<Sphere>(&shape)) add(s->r * ball);
            if (const auto* s = std::get_if<Ellipsoid>(&shape))
                add({{s->radii[0] * ball[0], s->radii[1] * ball[1], s->radii[2] * ball[2]}});
            if (const auto* s = std::get_if<TorusShape>(&shape))
                for (const double side : {v, -v}) {
                    const double ring = s->R + s->r * std::cos(side);
                    add({{ring * std::cos(u), ring * std::sin(u), s->r * std::sin(side)}});
                }
            if (const auto* s = std::get_if<Cylinder>(&shape)) {
                const double low = s->center ? -s->h / 2 : 0.0;
                add({{s->r1 * std::cos(u), s->r1 * std::sin(u), low}});
                add({{s->r2 * std::cos(u), s->r2 * std::sin(u), low + s->h}});
            }
        }
    return box;
}

TEST(Solid, BoundsOfAffineImagesAreTight)
{
    RandomShapes random(31);
    const std::vector<Solid> shapes{sphere(1.3), ellipsoid({{0.5, 1, 2}}), torus(2, 0.5),
                                    cylinder(3, 1, 0), cylinder(1, 0.3, 2, true)};
    for (int trial = 0; trial < 20; ++trial)
        for (const Solid& shape : shapes) {
            const Transform t = random.affine();
            const Box3 box = transformed(shape, t).bounds(), sampled = sampled_box(shape, t);
            EXPECT_TRUE(box.contains(sampled.inflated(-1e-12)));
            // Sampling every 3 degrees misses at most 1 - cos(3 degrees) of the size.
            const double gap = 0.003 * box.diagonal();
            EXPECT_TRUE(sampled.inflated(gap).contains(box)) << describe(shape.node().shape);
            // A chain of maps is as good as their product.
            const Solid chain =
                transformed(transformed(shape, random.affine(1.0, 0.0)), rotation_y(90));
            EXPECT_LE(chain.bounds().diagonal(), 2.0 * shape.bounds().diagonal());
        }
}

// A box of the round shape would be wider than the polyhedron that the shape stands for.
TEST(Solid, BoundsOfFacetedShapesAreThoseOfTheirPolyhedra)
{
    RandomShapes random(33);
    std::vector<Solid> shapes;
    for (const int n : {3, 4, 5, 7, 8, 30, 101}) {
        shapes.push_back(sphere(1.3, n));
        shapes.push_back(cylinder(3, 1, 0, false, n));
        shapes.push_back(cylinder(3, 0, 2, true, n));
        shapes.push_back(cylinder(1, 0.3, 2, true, n));
    }
    for (const Solid& shape : shapes) {
        SCOPED_TRACE(describe(shape.node().shape));
        const PolygonMesh mesh = facet_mesh(shape.node().shape);
        EXPECT_EQ(shape.bounds(), bounds(mesh));
        for (int trial = 0; trial < 50; ++trial) {
            Vec3 axis{};
            axis[trial % 3] = 1.0;
            const Transform t = trial < 3 ? rotation(90.0, axis) : random.affine();
            const Box3 box = transformed(shape, t).bounds();
            Box3 corners;
            for (const Vec3& v : mesh.vertices) corners.add(apply(t, v));
            const double step = 1e-15 * (norm(box.min) + norm(box.max));
            EXPECT_TRUE(box.inflated(step).contains(corners));
            EXPECT_TRUE(corners.inflated(step).contains(box));
        }
    }
}

TEST(Solid, BoundsHoldEveryPointOfRandomTrees)
{
    RandomShapes random(32);
    int inside = 0;
    for (int trial = 0; trial < 300; ++trial) {
        const Solid tree = random_tree(random, 6, false);
        MembershipOracle side;
        for (int sample = 0; sample < 100; ++sample) {
            const Vec3 p = random.point(3);
            if (side(tree, p) >= 0.0) continue;
            ++inside;
            EXPECT_TRUE(tree.bounds().inflated(1e-12).contains(p)) << "trial " << trial;
        }
    }
    EXPECT_GT(inside, 1000);
}

TEST(Solid, AnyDepthIsBuiltComparedAndEnded)
{
    const auto chain = [](int depth) {
        Solid s = sphere(1);
        for (int i = 0; i < depth; ++i) {
            s = i % 2 ? subtract({s, cube({{1, 1, 1}})}) : transformed(s, translation({{1, 0, 0}}));
        }
        return s;
    };
    const Solid a = chain(300000), b = chain(300000);
    EXPECT_EQ(a, b);
    EXPECT_EQ(a.hash(), b.hash());
    EXPECT_FALSE(a == chain(299998));
}

TEST(Solid, SharedPartsAreComparedOnce)
{
    // 2^60 paths through 60 shared nodes.
    const auto tower = [] {
        Solid s = sphere(1);
        for (int i = 0; i < 60; ++i) s = unite({s, transformed(s, translation({{1, 0, 0}}))});
        return s;
    };
    EXPECT_EQ(tower(), tower());
}

}  // namespace
}  // namespace genus
