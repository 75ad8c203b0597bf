#include "genus/boolean/mesh_boolean.h"

#include <limits>
#include <memory>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/boolean/operand_cache.h"

#include "shapes.h"

namespace genus {
namespace {

using namespace shapes;

TEST(MeshBoolean, CubesInAllCoincidentPlaces)
{
    // Cubes of side 2 and boxes of other sides at all offsets of a small grid: faces, edges and
    // corners in every position to each other. Everything is an integer, so volumes are exact.
    for (const double side : {1.0, 2.0, 3.0})
        for (int place = 0; place < 6 * 6 * 6; ++place) {
            const Vec3 at{{place % 6 - 3.0, place / 6 % 6 - 3.0, place / 36 - 3.0}};
            SCOPED_TRACE(std::to_string(side) + " at " + std::to_string(at[0]) + " " +
                         std::to_string(at[1]) + " " + std::to_string(at[2]));
            const IndexedMesh a = cube(2.0);
            const IndexedMesh b = cube(side, at);
            double common = 1.0;
            for (int k = 0; k < 3; ++k)
                common *= std::max(0.0, std::min(2.0, at[k] + side) - std::max(0.0, at[k]));
            const IndexedMesh sum = unite(a, b);
            const IndexedMesh both = intersect(a, b);
            const IndexedMesh rest = subtract(a, b);
            EXPECT_EQ(volume(sum), 8.0 + side * side * side - common);
            EXPECT_EQ(volume(both), common);
            EXPECT_EQ(volume(rest), 8.0 - common);
            for (const IndexedMesh* mesh : {&sum, &both, &rest}) expect_sound(*mesh);
            if (common > 0.0) {
                EXPECT_EQ(both.faces.size(), 12u);
            }
            if (::testing::Test::HasFailure()) return;
        }
}

TEST(MeshBoolean, SphereLessShiftedSphere)
{
    const IndexedMesh a = sphere(24, 48, 1.0);
    const IndexedMesh b = moved(a, {{0.3, 0.4, 0.5}});
    const IndexedMesh sum = unite(a, b);
    const IndexedMesh both = intersect(a, b);
    const IndexedMesh rest = subtract(a, b);
    for (const IndexedMesh* mesh : {&sum, &both, &rest}) expect_sound(*mesh);
    EXPECT_NEAR(volume(sum) + volume(both), 2.0 * volume(a), 1e-12);
    EXPECT_NEAR(volume(rest) + volume(both), volume(a), 1e-12);
}

// Known wrong answers of other libraries.

TEST(MeshBoolean, ChainOfCubesIsOnePiece)
{
    // 0.1 * i + 0.1 is often not 0.1 * (i + 1): gaps and overlaps of a unit in the last place.
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<IndexedMesh> cubes;
        for (int i = 0; i < 200; ++i) {
            Vec3 at;
            at[axis] = 0.1 * i;
            cubes.push_back(cube(0.1, at));
        }
        const MeshBooleanResult r = mesh_boolean(cubes, BooleanFormula::union_of(200));
        expect_sound(r.mesh);
        EXPECT_EQ(parts_of(r.mesh), 1);
        EXPECT_EQ(genus_of(r.mesh), 0);
        EXPECT_EQ(r.mesh.faces.size(), 12u);
        EXPECT_NEAR(volume(r.mesh), 0.2, 1e-14);
        EXPECT_LE(r.report.largest_snap, 1e-13);
    }
}

TEST(MeshBoolean, TetrahedraWithACommonFaceLeaveNoInnerFace)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto point = [&] { return Vec3{{unit(random), unit(random), unit(random)}}; };
    for (int round = 0; round < 200; ++round) {
        SCOPED_TRACE(round);
        const Vec3 a = point();
        const Vec3 b = point();
        const Vec3 c = point();
        const Vec3 n = cross(b - a, c - a);
        const Vec3 middle = (a + b + c) / 3.0;
        const IndexedMesh up = tetrahedron(a, b, c, middle + n + 0.1 * point());
        const IndexedMesh down = tetrahedron(a, b, c, middle - n + 0.1 * point());
        if (norm(n) < 0.3) continue;
        const IndexedMesh sum = unite(up, down);
        expect_sound(sum);
        EXPECT_EQ(sum.vertices.size(), 5u);
        EXPECT_EQ(sum.faces.size(), 6u);
        EXPECT_NEAR(volume(sum), volume(up) + volume(down), 1e-15);
        EXPECT_TRUE(intersect(up, down).faces.empty());
    }
}

TEST(MeshBoolean, BoredCubeFarFromTheOrigin)
{
    for (const double far : {0.0, 1e6, 1e9, 1e12, 1e15}) {
        SCOPED_TRACE(far);
        const Vec3 by{{far, far, far}};
        const IndexedMesh block = moved(cube(10.0), by);
        const IndexedMesh bore = moved(prism(32, 3.0, 3.0, -1.0, 11.0), by + Vec3{{5, 5, 0}});
        const IndexedMesh bored = subtract(block, bore);
        expect_sound(bored);
        EXPECT_EQ(genus_of(bored), 1);
        // The corners of the bore are rounded before we see them; what they bound is exact.
        double area = 0.0;
        for (int i = 1; i + 1 < 32; ++i) {
            const Vec3 p = bore.vertices[i] - bore.vertices[0];
            const Vec3 q = bore.vertices[i + 1] - bore.vertices[0];
            area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
        }
        EXPECT_NEAR(volume(bored), 1000.0 - 10.0 * area, 1e-9);
    }
}

TEST(MeshBoolean, CubeLessItselfTurnedALittle)
{
    // What remains of a square of side 1 less itself turned by t has the area
    // (sin t + cos t - 1) / (1 + sin t + cos t), in four slivers.
    const IndexedMesh block = box({{-0.5, -0.5, -0.5}}, {{0.5, 0.5, 0.5}});
    for (int k = 1; k <= 12; ++k) {
        const double degrees = std::pow(10.0, -k);
        SCOPED_TRACE(degrees);
        const IndexedMesh rest = subtract(block, turned(block, {{0, 0, 1}}, degrees));
        expect_sound(rest);
        EXPECT_EQ(parts_of(rest), 4);
        EXPECT_EQ(genus_of(rest), 0);
        const double t = degrees * std::numbers::pi / 180.0;
        const double less = std::sin(t) - 2.0 * std::sin(t / 2) * std::sin(t / 2);
        const double exact = less / (1.0 + std::sin(t) + std::cos(t));
        EXPECT_NEAR(volume(rest), exact, 2e-16 + 0.001 * exact);
    }
}

TEST(MeshBoolean, CoplanarCylindersAndATorus)
{
    const IndexedMesh disc = prism(48, 3.0, 3.0, 0.0, 1.0);
    const IndexedMesh hub = moved(prism(24, 1.0, 1.0, 0.0, 1.0), {{2.5, 0, 0}});
    const IndexedMesh ring = moved(torus(48, 24, 3.0, 0.5), {{0, 0, 0.5}});
    for (const auto& [a, b] :
         {std::pair{&disc, &hub}, std::pair{&disc, &ring}, std::pair{&hub, &ring}}) {
        const IndexedMesh sum = unite(*a, *b);
        const IndexedMesh both = intersect(*a, *b);
        expect_sound(sum);
        expect_sound(both);
        EXPECT_NEAR(volume(sum) + volume(both), volume(*a) + volume(*b), 1e-12);
    }
    const IndexedMesh all = genus::unite(std::vector{disc, hub, ring});
    expect_sound(all);
    EXPECT_EQ(parts_of(all), 1);
    EXPECT_EQ(genus_of(all), 0);
    double v = volume(disc) + volume(hub) + volume(ring) - volume(intersect(disc, hub)) -
               volume(intersect(disc, ring)) - volume(intersect(hub, ring));
    v += volume(genus::intersect(std::vector{disc, hub, ring}));
    EXPECT_NEAR(volume(all), v, 1e-12);
    EXPECT_NEAR(volume(all), 36.109498837576787, 1e-12);
}

TEST(MeshBoolean, BallWithBoresARingAndCoplanarDiscs)
{
    // A ball of 100 by 50 facets less three cylinders of 100 sides along the axes; the same in a
    // cube; and with a ring round its equator that bores cut, a hub and two discs whose flat sides
    // all lie in the planes that touch the ring. The numbers are those of manifold3d 3.5.4, which
    // is right here; CGAL's inexact kernel crashes on the second, geogram aborts on the third.
    const IndexedMesh bore = prism(100, 3.0, 3.0, -12.0, 12.0);
    std::vector<IndexedMesh> solids{sphere(50, 100, 10.0), bore, bore, bore,
                                    box({{-7.5, -7.5, -7.5}}, {{7.5, 7.5, 7.5}})};
    for (Vec3& p : solids[1].vertices) p = {{p[2], p[0], p[1]}};
    for (Vec3& p : solids[2].vertices) p = {{p[1], p[2], p[0]}};
    solids.push_back(torus(100, 48, 10.0, 1.0));
    solids.push_back(prism(100, 4.0, 4.0, -1.0, 1.0));
    for (const double x : {9.0, -9.0})
        solids.push_back(moved(prism(100, 2.0, 2.0, -1.0, 1.0), {{x, 0, 0}}));

    const auto expect = [](const IndexedMesh& mesh, std::int64_t genus, double v) {
        expect_sound(mesh);
        EXPECT_EQ(parts_of(mesh), 1);
        EXPECT_EQ(genus_of(mesh), genus);
        EXPECT_NEAR(volume(mesh), v, 1e-11);
    };
    const std::vector<IndexedMesh> bored(solids.begin(), solids.begin() + 4);
    expect(genus::subtract(bored), 5, 2831.40392131613);
    BooleanFormula in_cube = BooleanFormula::difference_of(4);
    in_cube.instructions[0].terms.push_back({4, true, false});
    const std::vector<IndexedMesh> cut(solids.begin(), solids.begin() + 5);
    expect(mesh_boolean(cut, in_cube).mesh, 5, 2140.7977365016804);
    BooleanFormula with_ring = BooleanFormula::difference_of(4);
    with_ring.add(false, {{0, false, false},
                          {5, true, false},
                          {6, true, false},
                          {7, true, false},
                          {8, true, false}});
    expect(mesh_boolean(solids, with_ring).mesh, 16, 3102.535152128766);
}

TEST(MeshBoolean, MengerSponge)
{
    // Of depth n: volume (20 / 27)^n; 20 handles-to-be a level: genus 5, 81, 1409.
    const std::array<std::int64_t, 3> genus_at{5, 81, 1409};
    std::vector<IndexedMesh> parts{cube(1.0)};
    for (int depth = 1; depth <= 3; ++depth) {
        int n = 1;
        for (int i = 1; i < depth; ++i) n *= 3;
        const auto is_hole = [](int x, int y) {
            for (; x > 0 || y > 0; x /= 3, y /= 3)
                if (x % 3 == 1 && y % 3 == 1) return true;
            return false;
        };
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                if (is_hole(i, j)) continue;
                const double s = 1.0 / (3 * n);
                const double a = (3 * i + 1) * s;
                const double b = (3 * j + 1) * s;
                parts.push_back(box({{a, b, -0.1}}, {{a + s, b + s, 1.1}}));
                parts.push_back(box({{a, -0.1, b}}, {{a + s, 1.1, b + s}}));
                parts.push_back(box({{-0.1, a, b}}, {{1.1, a + s, b + s}}));
            }
        const auto n_parts = static_cast<std::int32_t>(parts.size());
        const MeshBooleanResult result =
            mesh_boolean(parts, BooleanFormula::difference_of(n_parts));
        const IndexedMesh& sponge = result.mesh;
        // Most of what crosses is left, so that groups of prisms would be made for nothing.
        EXPECT_EQ(result.report.n_steps, 0);
        const Topology t = topology(sponge);
        EXPECT_EQ(t.genus.value_or(-1), genus_at[depth - 1]);
        EXPECT_EQ(t.components.size(), 1u);
        EXPECT_NEAR(volume(sponge), std::pow(20.0 / 27.0, depth), 1e-13);
        if (depth < 3) expect_sound(sponge);
    }
}

// The laws of sets.

TEST(MeshBoolean, WithItself)
{
    for (const IndexedMesh& a : {cube(1.0), sphere(9, 13, 1.0), torus(12, 7, 2.0, 0.7),
                                 turned(prism(7, 1.0, 0.4, 0.0, 1.0), {{1, 2, 3}}, 33.0)}) {
        EXPECT_TRUE(subtract(a, a).faces.empty());
        for (const IndexedMesh& same : {unite(a, a), intersect(a, a)}) {
            expect_sound(same);
            EXPECT_EQ(same.vertices.size(), a.vertices.size());
            EXPECT_EQ(same.faces.size(), a.faces.size());
            EXPECT_NEAR(volume(same), volume(a), 1e-14);
        }
    }
}

TEST(MeshBoolean, PiecesFitTogetherAgain)
{
    const IndexedMesh a = sphere(12, 16, 1.0);
    const IndexedMesh b = turned(cube(1.3), {{1, 2, 3}}, 40.0);
    const std::vector<IndexedMesh> pieces{subtract(a, b), intersect(a, b)};
    const IndexedMesh again = genus::unite(pieces);
    expect_sound(again);
    EXPECT_NEAR(volume(again), volume(a), 1e-13);
    EXPECT_EQ(genus_of(again), 0);
}

TEST(MeshBoolean, OperandsThatCrossNestAndTurnInsideOut)
{
    // Two cubes that overlap, in one operand: inside is where it winds round at all.
    const IndexedMesh pair = joined(cube(2.0), cube(2.0, {{1, 1, 1}}));
    const IndexedMesh merged = genus::unite(std::vector{pair});
    expect_sound(merged);
    EXPECT_EQ(volume(merged), 15.0);
    EXPECT_EQ(parts_of(merged), 1);
    // A cavity, and a cube in it.
    const IndexedMesh nested =
        joined(joined(cube(9.0), inside_out(cube(5.0, {{2, 2, 2}}))), cube(1.0, {{4, 4, 4}}));
    EXPECT_EQ(volume(genus::unite(std::vector{nested})), 729.0 - 125.0 + 1.0);
    EXPECT_EQ(volume(subtract(nested, cube(9.0, {{4.5, 0, 0}}))), 0.5 * 605.0);
    // Inside out: the same solid, its outside found.
    const IndexedMesh turned_over = genus::unite(std::vector{inside_out(cube(2.0))});
    expect_sound(turned_over);
    EXPECT_EQ(volume(turned_over), 8.0);
}

TEST(MeshBoolean, TouchingPartsGetCornersOfTheirOwn)
{
    // Common edge, common corner, corner in a face, edge across a face.
    for (const Vec3& at : {Vec3{{1, 1, 0}}, Vec3{{1, 1, 1}}, Vec3{{1, 1, 0.25}}}) {
        const IndexedMesh two = unite(cube(1.0), cube(1.0, at));
        expect_sound(two);
        EXPECT_EQ(parts_of(two), 2);
        EXPECT_EQ(volume(two), 2.0);
    }
    const Vec3 tip{{0.5, 0.5, 1.0}};
    const IndexedMesh spike = tetrahedron(tip, {{0, 0, 2}}, {{1, 0, 2}}, {{0, 1, 2}});
    const IndexedMesh on_face = unite(cube(1.0), spike);
    expect_sound(on_face);
    EXPECT_EQ(parts_of(on_face), 2);
}

// A quadrangle meets another once, whichever way both are cut into triangles.
TEST(MeshBoolean, PlatesMeetOnce)
{
    const IndexedMesh a = cube(1.0);
    for (int turn = 0; turn < 4; ++turn) {
        IndexedMesh b = moved(cube(1.0), {{0.5, 0.25, 0.125}});
        // Other diagonals.
        for (std::size_t f = 0; f < b.faces.size() && turn % 2 == 1; f += 2) {
            Triangle& t = b.faces[f];
            Triangle& u = b.faces[f + 1];
            const auto shared = [&](std::int32_t v) { return v == u[0] || v == u[1] || v == u[2]; };
            while (shared(t[0])) std::rotate(t.begin(), t.begin() + 1, t.end());
            while (u[0] == t[1] || u[0] == t[2]) std::rotate(u.begin(), u.begin() + 1, u.end());
            t = {t[0], t[1], u[0]};
            u = {t[0], u[0], u[1] == t[1] ? u[2] : u[1]};
        }
        const std::vector<IndexedMesh> both =
            turn < 2 ? std::vector<IndexedMesh>{a, b} : std::vector<IndexedMesh>{b, a};
        const MeshBooleanResult r = mesh_boolean(both, BooleanFormula::union_of(2));
        expect_sound(r.mesh);
        // Three faces of one cube cross two of the other each.
        EXPECT_EQ(r.report.n_contacts, 6);
        EXPECT_EQ(r.report.n_new_points, 6);
        EXPECT_NEAR(volume(r.mesh), 2.0 - 0.5 * 0.75 * 0.875, 1e-14);
        EXPECT_EQ(r.mesh.vertices.size(), 20u);
    }
}

// A part that shares two opposite corners of a square with it touches it along its diagonal, though
// all its other corners lie on one side (seed 104670 of the random formulas).
TEST(MeshBoolean, PartOnTheDiagonalOfASquare)
{
    for (const bool along : {false, true}) {
        SCOPED_TRACE(along);
        IndexedMesh mesh = cube(1.0);
        const auto n = static_cast<std::int32_t>(mesh.vertices.size());
        mesh.vertices.push_back({{0.3, 0.7, 2.0}});
        mesh.vertices.push_back({{0.7, 0.3, 2.0}});
        // The top has the corners 4, 5, 7, 6.
        const std::int32_t a = along ? 5 : 4;
        const std::int32_t c = along ? 6 : 7;
        const std::int32_t e = along ? n + 1 : n;
        if (along) {
            mesh.vertices[n] = {{0.3, 0.3, 2.0}};
            mesh.vertices[n + 1] = {{0.7, 0.7, 2.0}};
        }
        const std::int32_t f = 2 * n + 1 - e;
        const IndexedMesh part =
            tetrahedron(mesh.vertices[a], mesh.vertices[c], mesh.vertices[e], mesh.vertices[f]);
        const std::array<std::int32_t, 4> number{a, c, e, f};
        for (const Triangle& t : part.faces) {
            Triangle corners;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 4; ++k)
                    if (part.vertices[t[i]] == mesh.vertices[number[k]]) corners[i] = number[k];
            mesh.faces.push_back(corners);
        }
        const std::vector<IndexedMesh> one{mesh};
        const IndexedMesh sum = genus::unite(one);
        expect_sound(sum);
        EXPECT_EQ(parts_of(sum), 2);
        EXPECT_EQ(genus_of(sum), 0);
        EXPECT_NEAR(volume(sum), 1.0 + volume(part), 1e-15);
    }
}

TEST(MeshBoolean, DisjointPartsPassThrough)
{
    const IndexedMesh a = sphere(10, 12, 1.0);
    std::vector<IndexedMesh> all;
    for (int i = 0; i < 5; ++i) all.push_back(moved(a, {{3.0 * i, 0, 0}}));
    const MeshBooleanResult r = mesh_boolean(all, BooleanFormula::union_of(5));
    EXPECT_EQ(r.report.n_clusters, 5);
    EXPECT_EQ(r.report.n_contacts, 0);
    EXPECT_EQ(r.mesh.faces.size(), 5 * a.faces.size());
    EXPECT_EQ(r.report.largest_snap, 0.0);
    for (std::size_t f = 0; f < r.mesh.faces.size(); ++f)
        for (int i = 0; i < 3; ++i) {
            const IndexedMesh& from = all[r.operand[f]];
            EXPECT_EQ(r.mesh.vertices[r.mesh.faces[f][i]],
                      from.vertices[from.faces[r.source_face[f]][i]]);
        }
}

TEST(MeshBoolean, FacesKnowTheirSource)
{
    const std::vector<IndexedMesh> solids{sphere(12, 16, 1.0), turned(cube(1.3), {{1, 2, 3}}, 40.0),
                                          torus(20, 9, 0.8, 0.3)};
    const MeshBooleanResult r = mesh_boolean(solids, BooleanFormula::difference_of(3));
    for (std::size_t f = 0; f < r.mesh.faces.size(); ++f) {
        const IndexedMesh& from = solids[r.operand[f]];
        const Triangle& t = from.faces[r.source_face[f]];
        const Vec3& a = from.vertices[t[0]];
        const Vec3 n = normalized(cross(from.vertices[t[1]] - a, from.vertices[t[2]] - a));
        for (const std::int32_t v : r.mesh.faces[f])
            EXPECT_NEAR(dot(n, r.mesh.vertices[v] - a), 0.0, 1e-14);
    }
}

TEST(MeshBoolean, FormulasOfManyOperands)
{
    // (a or b) and not (c and d), against a count of unit cubes.
    const auto block = [](int x, int y, int z, int s) {
        return cube(s, {{1.0 * x, 1.0 * y, 1.0 * z}});
    };
    const std::array<std::array<int, 4>, 4> at{
        {{0, 0, 0, 4}, {2, 2, 2, 4}, {1, 1, 0, 3}, {2, 0, 1, 3}}};
    std::vector<IndexedMesh> solids;
    for (const auto& c : at) solids.push_back(block(c[0], c[1], c[2], c[3]));
    BooleanFormula formula;
    const auto either = formula.add(false, {{0, true, false}, {1, true, false}});
    const auto both = formula.add(true, {{2, true, false}, {3, true, false}});
    formula.add(true, {{either, false, false}, {both, false, true}});
    int count = 0;
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z) {
                const auto in = [&](int i) {
                    const auto within = [&](int v, int k) {
                        return v >= at[i][k] && v < at[i][k] + at[i][3];
                    };
                    return within(x, 0) && within(y, 1) && within(z, 2);
                };
                count += (in(0) || in(1)) && !(in(2) && in(3));
            }
    const IndexedMesh mesh = mesh_boolean(solids, formula).mesh;
    expect_sound(mesh);
    EXPECT_EQ(volume(mesh), count);
}

TEST(MeshBoolean, SameBitsOnAnyNumberOfThreads)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::vector<IndexedMesh> solids;
    for (int i = 0; i < 30; ++i)
        solids.push_back(moved(scaled(sphere(12, 18, 1.0), 0.1 + 0.2 * unit(random)),
                               {{unit(random), unit(random), unit(random)}}));
    const int before = thread_count();
    std::vector<MeshBooleanResult> results;
    for (const int threads : {1, 2, 8}) {
        set_thread_count(threads);
        results.push_back(mesh_boolean(solids, BooleanFormula::union_of(30)));
    }
    set_thread_count(before);
    expect_sound(results[0].mesh);
    for (const MeshBooleanResult& r : results) {
        EXPECT_TRUE(r.mesh == results[0].mesh);
        EXPECT_EQ(r.source_face, results[0].source_face);
    }
}

TEST(MeshBoolean, LongUnionsInGroupsMeanTheSame)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    // Long bars cross so often that they are not cut all at once.
    std::vector<IndexedMesh> solids{cube(1.0)};
    for (int i = 0; i < 40; ++i)
        solids.push_back(
            moved(turned(box({{-1.0, -0.03, -0.03}}, {{1.0, 0.03, 0.03}}),
                         {{unit(random), unit(random), unit(random)}}, 360.0 * unit(random)),
                  {{0.4 + 0.2 * unit(random), 0.5, 0.5}}));
    MeshBooleanOptions at_once;
    at_once.largest_union = 1000;
    const BooleanFormula carve = BooleanFormula::difference_of(41);
    const MeshBooleanResult a = mesh_boolean(solids, carve, at_once);
    const MeshBooleanResult b = mesh_boolean(solids, carve);
    EXPECT_EQ(a.report.n_steps, 0);
    EXPECT_GT(b.report.n_steps, 1);
    expect_sound(a.mesh);
    expect_sound(b.mesh);
    EXPECT_EQ(genus_of(a.mesh), genus_of(b.mesh));
    EXPECT_EQ(parts_of(a.mesh), parts_of(b.mesh));
    EXPECT_NEAR(volume(a.mesh), volume(b.mesh), 1e-13);
    for (std::size_t f = 0; f < b.mesh.faces.size(); ++f) {
        const IndexedMesh& from = solids[b.operand[f]];
        const Triangle& t = from.faces[b.source_face[f]];
        const Vec3& p = from.vertices[t[0]];
        const Vec3 n = normalized(cross(from.vertices[t[1]] - p, from.vertices[t[2]] - p));
        for (const std::int32_t v : b.mesh.faces[f])
            EXPECT_NEAR(dot(n, b.mesh.vertices[v] - p), 0.0, 1e-13);
    }
}

TEST(MeshBoolean, BuriedFacesMakeNoDifference)
{
    // All at once most faces lie inside others and are not cut; one by one all are.
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::vector<IndexedMesh> solids{cube(1.0)};
    for (int i = 0; i < 36; ++i)
        solids.push_back(moved(scaled(sphere(8, 12, 1.0), 0.1 + 0.2 * unit(random)),
                               {{unit(random), unit(random), unit(random)}}));
    const std::vector<IndexedMesh> balls(solids.begin() + 1, solids.end());
    IndexedMesh sum;
    IndexedMesh rest = solids[0];
    for (const IndexedMesh& ball : balls) {
        sum = unite(sum, ball);
        rest = subtract(rest, ball);
    }
    const MeshBooleanResult all = mesh_boolean(balls, BooleanFormula::union_of(36));
    const MeshBooleanResult carved = mesh_boolean(solids, BooleanFormula::difference_of(37));
    for (const auto& [r, one_by_one] : {std::pair{&all, &sum}, std::pair{&carved, &rest}}) {
        EXPECT_GT(r->report.n_buried_faces, 500);
        expect_sound(r->mesh);
        EXPECT_EQ(genus_of(r->mesh), genus_of(*one_by_one));
        EXPECT_EQ(parts_of(r->mesh), parts_of(*one_by_one));
        EXPECT_NEAR(volume(r->mesh), volume(*one_by_one), 1e-12);
    }
    // Inside one shell of an operand is not inside the operand: a ball in the cavity stays.
    const IndexedMesh shell = joined(cube(9.0), inside_out(cube(5.0, {{2, 2, 2}})));
    const std::vector<IndexedMesh> nested{shell, sphere(8, 12, 30.0), cube(1.0, {{4, 4, 4}}),
                                          cube(1.0, {{4.5, 4, 4}})};
    BooleanFormula formula;  // shell or (ball and (cube or cube))
    const auto cubes = formula.add(false, {{2, true, false}, {3, true, false}});
    const auto in_ball = formula.add(true, {{1, true, false}, {cubes, false, false}});
    formula.add(false, {{0, true, false}, {in_ball, false, false}});
    EXPECT_EQ(volume(mesh_boolean(nested, formula).mesh), 729.0 - 125.0 + 1.5);
}

// Operands that are none.

std::string refusal(const std::vector<IndexedMesh>& operands)
{
    try {
        genus::unite(operands);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}

TEST(MeshBoolean, RefusesWhatIsNoSolid)
{
    IndexedMesh open = cube(1.0);
    open.faces.pop_back();
    EXPECT_NE(refusal({cube(1.0), open}).find("operand 1, face"), std::string::npos);
    EXPECT_NE(refusal({open}).find("not closed"), std::string::npos);
    IndexedMesh turned_face = cube(1.0);
    std::swap(turned_face.faces[3][0], turned_face.faces[3][1]);
    EXPECT_NE(refusal({turned_face}).find("not closed"), std::string::npos);
    IndexedMesh wild = cube(1.0);
    wild.faces[7][1] = 8;
    EXPECT_NE(refusal({wild}).find("operand 0, face 7: corner 8"), std::string::npos);
    wild.faces[7][1] = -1;
    EXPECT_NE(refusal({wild}).find("corner -1"), std::string::npos);
    IndexedMesh nan = cube(1.0);
    nan.vertices[3][2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(refusal({nan}).find("nan"), std::string::npos);
    nan.vertices[3][2] = 1e301;
    EXPECT_NE(refusal({nan}).find("1e+301"), std::string::npos);
}

TEST(MeshBoolean, RefusesFormulasWithoutAMeaning)
{
    const std::vector<IndexedMesh> one{cube(1.0)};
    BooleanFormula outside;
    outside.add(false, {{0, true, true}});
    EXPECT_THROW(mesh_boolean(one, outside), InvalidInput);
    EXPECT_THROW(mesh_boolean(one, BooleanFormula::union_of(2)), InvalidInput);
    BooleanFormula later;
    later.add(false, {{0, false, false}});
    EXPECT_THROW(mesh_boolean(one, later), InvalidInput);
    BooleanFormula none;
    none.add(true, {});
    EXPECT_THROW(mesh_boolean(one, none), InvalidInput);
}

TEST(MeshBoolean, EmptyOperands)
{
    EXPECT_TRUE(genus::unite({}).faces.empty());
    EXPECT_TRUE(unite({}, {}).faces.empty());
    EXPECT_EQ(volume(unite(cube(2.0), {})), 8.0);
    EXPECT_EQ(volume(subtract(cube(2.0), {})), 8.0);
    EXPECT_TRUE(intersect(cube(2.0), {}).faces.empty());
}

TEST(MeshBoolean, UnweldedAndFlatFacesAreTakenAsMeant)
{
    // A triangle list, corners at the same places not made one; and a face folded onto an edge.
    const IndexedMesh solid = cube(2.0);
    IndexedMesh loose;
    for (const Triangle& t : solid.faces) {
        const auto base = static_cast<std::int32_t>(loose.vertices.size());
        for (const std::int32_t v : t) loose.vertices.push_back(solid.vertices[v]);
        loose.faces.push_back({base, base + 1, base + 2});
    }
    EXPECT_EQ(volume(unite(loose, cube(2.0, {{1, 1, 1}}))), 15.0);

    IndexedMesh seam = cube(2.0);  // corner 8 in the middle of an edge, seen by one side only
    seam.vertices.push_back({{1, 0, 0}});
    seam.faces[0] = {0, 2, 8};
    seam.faces.push_back({8, 2, 1});
    seam.faces.push_back({0, 8, 1});
    const IndexedMesh mended = unite(seam, cube(2.0, {{1, 1, 1}}));
    expect_sound(mended);
    EXPECT_EQ(volume(mended), 15.0);
}

BooleanOperand known(const IndexedMesh& mesh)
{
    return BooleanOperand(std::make_shared<const IndexedMesh>(mesh));
}

TEST(BooleanOperand, IsReadOnceForManyChanges)
{
    const IndexedMesh ball = turned(sphere(20, 40, 1.0), {{1, 2, 3}}, 20.0);
    const BooleanOperand operand = known(ball);
    const BooleanFormula less = BooleanFormula::difference_of(2);
    for (int i = 0; i < 4; ++i) {
        SCOPED_TRACE(i);
        const IndexedMesh tool = moved(cube(0.5), {{-0.3 + 0.1 * i, -0.2, 0.4}});
        const MeshBooleanResult fresh = mesh_boolean(std::vector<IndexedMesh>{ball, tool}, less);
        const MeshBooleanResult again =
            mesh_boolean(std::vector<BooleanOperand>{operand, known(tool)}, less);
        EXPECT_EQ(again.report.n_known, i > 0 ? 1 : 0);
        EXPECT_EQ(again.report.n_known_clean, i > 0 ? 1 : 0);
        EXPECT_TRUE(again.mesh.vertices == fresh.mesh.vertices);
        EXPECT_TRUE(again.mesh.faces == fresh.mesh.faces);
        EXPECT_TRUE(again.source_face == fresh.source_face);
    }
}

TEST(BooleanOperand, AResultIsKnownNotToTouchItself)
{
    const BooleanFormula less = BooleanFormula::difference_of(2);
    IndexedMesh plain = sphere(12, 24, 1.0);
    BooleanOperand part = known(plain);
    double taken = 0.0;
    for (int i = 0; i < 5; ++i) {
        SCOPED_TRACE(i);
        const IndexedMesh tool = turned(cube(0.3, {{0.35, -0.1, 0.75}}), {{0, 0, 1}}, 70.0 * i);
        MeshBooleanResult fresh = mesh_boolean(std::vector<IndexedMesh>{plain, tool}, less);
        MeshBooleanResult next = mesh_boolean(std::vector<BooleanOperand>{part, known(tool)}, less);
        EXPECT_EQ(next.report.n_known_clean, i > 0 ? 1 : 0);
        EXPECT_TRUE(next.clean);
        EXPECT_TRUE(next.mesh.vertices == fresh.mesh.vertices);
        EXPECT_TRUE(next.mesh.faces == fresh.mesh.faces);
        const double step = volume(plain) - volume(next.mesh);
        if (i == 0) taken = step;
        EXPECT_NEAR(step, taken, 0.02);  // of a ball that is not quite round
        plain = fresh.mesh;
        part =
            BooleanOperand(std::make_shared<const IndexedMesh>(std::move(next.mesh)), next.clean);
    }
}

TEST(BooleanOperand, OneThatTouchesItselfIsLookedAtEachTime)
{
    const BooleanFormula all = BooleanFormula::union_of(2);
    // Crossing components, a common edge, a common corner; a result whose parts touch.
    for (const Vec3& at : {Vec3{{0.5, 0.5, 0.5}}, Vec3{{1, 1, 0}}, Vec3{{1, 1, 1}}}) {
        const BooleanOperand twice = known(joined(cube(1.0), cube(1.0, at)));
        const BooleanOperand tool = known(cube(3.0, {{-1, -1, 0.75}}));
        for (int i = 0; i < 3; ++i) {
            const MeshBooleanResult r = mesh_boolean(std::vector<BooleanOperand>{twice, tool}, all);
            expect_sound(r.mesh);
            EXPECT_EQ(r.report.n_known_clean, i > 0 ? 1 : 0);  // the tool
        }
        const BooleanFormula itself = BooleanFormula::union_of(1);
        const MeshBooleanResult alone = mesh_boolean(std::vector<BooleanOperand>{twice}, itself);
        EXPECT_EQ(alone.clean, at[2] == 0.5);
    }
}

TEST(OperandCache, KnowsMeshesByIdentityAndForgets)
{
    OperandCache cache(30);
    const auto a = std::make_shared<const IndexedMesh>(cube(1.0));
    const auto b = std::make_shared<const IndexedMesh>(cube(1.0, {{0.5, 0.5, 0.5}}));
    const auto n_known = [&](std::vector<BooleanOperand> operands) {
        const auto n = static_cast<std::int32_t>(operands.size());
        return mesh_boolean(operands, BooleanFormula::union_of(n)).report.n_known;
    };
    EXPECT_EQ(n_known({cache.find(a), cache.find(b)}), 0);
    EXPECT_EQ(n_known({cache.find(a), cache.find(b)}), 2);
    EXPECT_EQ(cache.size(), 2u);
    // Equal, but another.
    auto c = std::make_shared<const IndexedMesh>(cube(1.0));
    cache.find(c);
    EXPECT_EQ(cache.size(), 2u);  // room for two
    EXPECT_EQ(n_known({cache.find(b)}), 1);
    EXPECT_EQ(n_known({cache.find(a)}), 0);
    c.reset();
    cache.find(a);
    EXPECT_EQ(cache.size(), 2u);
}

}  // namespace
}  // namespace genus
