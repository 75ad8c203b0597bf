#include "genus/model/csg_field.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>

#include "core/model/random_trees.h"
#include "genus/base/error.h"
#include "genus/model/leaf_mesh.h"

namespace genus {
namespace {

const double kInf = std::numeric_limits<double>::infinity();

int trials(int usual, int in_the_long_run)
{
    return std::getenv("GENUS_LONG") ? in_the_long_run : usual;
}

std::uint64_t bits(double x)
{
    return std::bit_cast<std::uint64_t>(x);
}

Solid at(const Solid& s, double x, double y, double z)
{
    return transformed(s, translation({{x, y, z}}));
}

TEST(CsgField, AgreesWithMembershipByDefinition)
{
    RandomShapes random(41);
    int decided = 0, inside = 0;
    for (int trial = 0; trial < trials(500, 20000); ++trial) {
        SCOPED_TRACE(trial);
        const Solid tree = random_tree(random, 1 + trial % 12, false);
        const CsgField field(tree);
        MembershipOracle side;
        for (int sample = 0; sample < 100; ++sample) {
            const Vec3 p = random.point(3);
            const double expected = side(tree, p);
            if (side.nearest < 1e-9) continue;
            ++decided;
            inside += expected < 0;
            ASSERT_EQ(field.value(p) <= 0.0, expected < 0.0);
        }
    }
    EXPECT_GT(decided, 45000);
    EXPECT_GT(inside, decided / 20);
}

TEST(CsgField, PruningChangesNoBitInsideTheBox)
{
    RandomShapes random(42);
    std::size_t before = 0, after = 0;
    for (int trial = 0; trial < trials(300, 10000); ++trial) {
        SCOPED_TRACE(trial);
        const CsgField field(random_tree(random, 2 + trial % 12));
        Box3 box = random.box(1.5);
        CsgField::Pruned pruned = field.prune(box.inflated(0.2));
        pruned = field.prune(pruned, box);
        const Interval bound = field.bound(box);
        const IntervalVec3 slopes = field.gradient_bound(box);
        before += field.instructions().size();
        after += pruned.instructions.size();
        for (int sample = 0; sample < 40; ++sample) {
            const Vec3 p = random.point_in(box);
            const double value = field.value(p);
            EXPECT_TRUE(bound.contains(value));
            const CsgField::Active active = field.active(p);
            EXPECT_EQ(bits(active.value), bits(value));
            if (active.surface >= 0) {
                EXPECT_EQ(active.sign * field.surfaces()[active.surface].value(p), value);
                const Vec3 g = field.gradient(p);
                for (int i = 0; i < 3; ++i) EXPECT_TRUE(slopes[i].contains(g[i]));
            }
            if (pruned.constant_sign != 0) {
                EXPECT_GT(pruned.constant_sign * value, 0.0);
                continue;
            }
            EXPECT_EQ(bits(field.value(pruned, p)), bits(value));
            EXPECT_EQ(field.active(pruned, p).surface, active.surface);
            EXPECT_EQ(field.gradient(pruned, p), field.gradient(p));
            EXPECT_TRUE(field.bound(pruned, box).contains(value));
        }
    }
    EXPECT_LT(after, before);
}

TEST(CsgField, BoundsTightenAsBoxesShrink)
{
    RandomShapes random(43);
    for (int trial = 0; trial < 100; ++trial) {
        const CsgField field(random_tree(random, 6));
        if (field.instructions().empty()) continue;
        const Vec3 p = random.point();
        double last = kInf;
        for (double size = 0.1; size > 1e-4; size /= 4) {
            Box3 box;
            box.add(p);
            const double width = field.bound(box.inflated(size)).width();
            EXPECT_LT(width, 0.5 * last);
            last = width;
        }
    }
}

TEST(CsgField, GradientsNearSurfacesAreAboutOne)
{
    // Scale invariance: the same model a thousand times larger or smaller.
    for (const double scale : {1e-3, 1.0, 1e3}) {
        for (const Solid& shape : {sphere(3), cylinder(5, 2, 2), cylinder(5, 3, 1), torus(3, 1),
                                   cube({{1, 2, 3}}), ellipsoid({{2, 3, 3.5}})}) {
            const CsgField field(transformed(shape, scaling({{scale, scale, scale}})));
            for (const Surface& surface : field.surfaces()) {
                double longest = 0.0;
                for (int i = 0; i < 8; ++i) {
                    const Box3& b = shape.bounds();
                    const Vec3 corner{{i & 1 ? b.max[0] : b.min[0], i & 2 ? b.max[1] : b.min[1],
                                       i & 4 ? b.max[2] : b.min[2]}};
                    longest = std::max(longest, norm(surface.gradient(scale * corner)));
                }
                EXPECT_GT(longest, 0.5);
                EXPECT_LT(longest, 10.0);  // corners lie outside, where a torus is steep
            }
        }
    }
}

TEST(CsgField, PinAndHoleShareTheirSurface)
{
    const Solid pin = cylinder(30, 3, 3), hole = at(cylinder(40, 3, 3), 0, 0, -5);
    const Transform place = translation({{1, 2, 3}}) * rotation({{20, 30, 40}});
    for (const Transform& t : {Transform{}, place}) {
        const Solid plate = transformed(cube({{20, 20, 10}}, true), t);
        const Solid both = unite({subtract({plate, transformed(hole, t)}), transformed(pin, t)});
        const CsgField field(both);
        int quadrics = 0;
        for (const Surface& s : field.surfaces()) quadrics += s.kind == Surface::Kind::Quadric;
        EXPECT_EQ(quadrics, 1);
    }
}

TEST(CsgField, NeighbouringCubesShareThePlaneBetweenThem)
{
    // 0.1 + 0.2 is not 0.3 in doubles, but no model means the gap.
    const Solid low = cube({{1, 1, 0.3}}), high = at(cube({{1, 1, 1}}), 0, 0, 0.1 + 0.2);
    const CsgField field(unite({low, high}));
    EXPECT_EQ(field.surfaces().size(), 7U);
    const CsgField turned(transformed(unite({low, high}), rotation({{10, 20, 30}})));
    EXPECT_EQ(turned.surfaces().size(), 7U);
    // Planes that do differ stay apart.
    const CsgField apart(unite({low, at(cube({{1, 1, 1}}), 0, 0, 0.3 + 1e-12)}));
    EXPECT_EQ(apart.surfaces().size(), 8U);
    const CsgField balls(unite({sphere(1), sphere(1 + 1e-12)}));
    EXPECT_EQ(balls.surfaces().size(), 2U);
    const CsgField far(unite({at(sphere(1), 1e9, 0, 0), at(sphere(1), 1e9 + 0.001, 0, 0)}));
    EXPECT_EQ(far.surfaces().size(), 2U);
}

TEST(CsgField, NestedOperatorsOfOneKindAreOneInstruction)
{
    Solid chain = cube({{9, 9, 9}});
    for (int i = 0; i < 50; ++i) chain = subtract({chain, at(sphere(0.1), i, 0, 0)});
    const CsgField field(chain);
    EXPECT_EQ(field.instructions().size(), 1U);
    EXPECT_EQ(field.instructions()[0].terms.size(), 56U);
    EXPECT_TRUE(field.instructions()[0].is_max);
}

TEST(CsgField, HasNoSecondNappe)
{
    const CsgField cone(cylinder(2, 1, 0)), funnel(at(cylinder(2, 0, 1), 0, 0, 2));
    EXPECT_EQ(cone.value({{0, 0, 2}}), 0.0);  // the apex belongs to it
    EXPECT_GT(cone.value({{0, 0, 2.5}}), 0.0);
    EXPECT_LT(cone.value({{0, 0, 1.9}}), 0.0);
    EXPECT_EQ(funnel.value({{0, 0, 2}}), 0.0);
    EXPECT_GT(funnel.value({{0, 0, 1.5}}), 0.0);
    // Nearly a cone: the apex is just past the plane, and no sliver of the other nappe appears.
    const CsgField blunt(cylinder(3, 1, 1e-14));
    EXPECT_LE(blunt.value({{0, 0, 3}}), 0.0);
    EXPECT_GT(blunt.value({{1e-10, 0, 3}}), 0.0);
}

TEST(CsgField, FacetedShapesAreTheirPolyhedra)
{
    RandomShapes random(44);
    for (const Solid& shape : {sphere(2, 7), sphere(2, 8), cylinder(3, 1, 2, true, 5),
                               cylinder(3, 1, 0, false, 6), cylinder(3, 0, 1, false, 3)}) {
        const PolygonMesh mesh = facet_mesh(shape.node().shape);
        const CsgField field(shape), same(polyhedron(mesh));
        for (const Vec3& v : mesh.vertices) EXPECT_NEAR(field.value(v), 0.0, 1e-14);
        EXPECT_LT(field.value({{0, 0, 0.5}}), 0.0);
        for (int sample = 0; sample < 1000; ++sample) {
            const Vec3 p = random.point(2.5);
            EXPECT_NEAR(field.value(p), same.value(p), 1e-13);
        }
    }
}

PolygonMesh notched_block()
{
    // An L-shaped prism: six side faces, two caps; the inner edge makes it not convex.
    const std::vector<Vec2> ring{{{0, 0}}, {{2, 0}}, {{2, 1}}, {{1, 1}}, {{1, 2}}, {{0, 2}}};
    PolygonMesh mesh;
    for (const double z : {0.0, 1.0})
        for (const Vec2& p : ring) mesh.vertices.push_back({{p[0], p[1], z}});
    mesh.add_face(std::vector<std::int32_t>{5, 4, 3, 2, 1, 0});
    mesh.add_face(std::vector<std::int32_t>{6, 7, 8, 9, 10, 11});
    for (std::int32_t i = 0; i < 6; ++i) {
        const std::int32_t j = (i + 1) % 6;
        mesh.add_face(std::vector<std::int32_t>{i, j, j + 6, i + 6});
    }
    return mesh;
}

std::string refusal(const Solid& solid)
{
    try {
        const CsgField field(solid);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}

TEST(CsgField, RefusesPolyhedraThatAreNotConvexAndNamesThem)
{
    EXPECT_NE(refusal(polyhedron(notched_block())).find("polyhedron with 8 faces"),
              std::string::npos);
    EXPECT_NE(refusal(polyhedron(notched_block())).find("not convex"), std::string::npos);
    PolygonMesh open = facet_mesh(Cube{{{1, 1, 1}}});
    open.starts.pop_back();
    open.corners.resize(20);
    EXPECT_NE(refusal(polyhedron(open)).find("open edge"), std::string::npos);
    PolygonMesh inside_out = facet_mesh(Cube{{{1, 1, 1}}});
    for (std::size_t f = 0; f < 6; ++f)
        std::reverse(inside_out.corners.begin() + 4 * f, inside_out.corners.begin() + 4 * f + 4);
    EXPECT_NE(refusal(polyhedron(inside_out)).find("not convex"), std::string::npos);
    EXPECT_EQ(refusal(polyhedron(facet_mesh(Cube{{{1, 1, 1}}}))), "");
    EXPECT_NE(refusal(sphere(1e200)).find("sphere(r = 1e+200)"), std::string::npos);
}

TEST(CsgField, EmptySolidIsOutsideEverywhere)
{
    const CsgField field{Solid()};
    EXPECT_EQ(field.value({{0, 0, 0}}), kInf);
    EXPECT_EQ(field.prune(Box3{{{0, 0, 0}}, {{1, 1, 1}}}).constant_sign, 1);
    EXPECT_EQ(field.active({{0, 0, 0}}).surface, -1);
}

TEST(CsgField, TakesAnyDepthAndManyLeaves)
{
    Solid deep = sphere(1);
    for (int i = 0; i < 20000; ++i)
        deep = i % 2 ? unite({deep, at(sphere(0.1), 0.001 * i, 2, 0)})
                     : subtract({deep, at(sphere(0.1), 0.001 * i, 0, 0)});
    const CsgField field(deep);
    EXPECT_EQ(field.surfaces().size(), 20001U);
    EXPECT_LT(field.value({{0, 0.5, 0}}), 0.0);
    EXPECT_GT(field.value({{0.5, 0, 0}}), 0.0);
    EXPECT_LT(field.value({{5, 2, 0}}), 0.0);
}

}  // namespace
}  // namespace genus
