#include "genus/boolean/zone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "genus/base/parallel.h"
#include "genus/boolean/cell_grid.h"
#include "genus/boolean/solve.h"
#include "genus/boolean/star_shaped.h"
#include "shapes.h"
#include "soups.h"

// What a zone leaves out must make no difference.

namespace genus {
namespace {

using namespace shapes;

bool is_star(const IndexedMesh& mesh)
{
    return exact::is_star_shaped(soup_of({mesh}), 0, static_cast<std::int32_t>(mesh.n_faces()));
}

TEST(StarShaped, AreConvexOnesAndOthers)
{
    EXPECT_TRUE(is_star(sphere(20, 40, 1.0)));
    EXPECT_TRUE(is_star(inside_out(sphere(20, 40, 1.0))));
    EXPECT_TRUE(is_star(box({{0, 0, 0}}, {{1, 2, 30}})));
    EXPECT_TRUE(is_star(tetrahedron({{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}})));
    IndexedMesh star = sphere(20, 40, 1.0);
    for (std::size_t v = 0; v < star.vertices.size(); v += 3)
        star.vertices[v] = 2.0 * star.vertices[v];
    EXPECT_TRUE(is_star(star));
}

TEST(StarShaped, AreNoneThatMeetThemselvesOrAreOpen)
{
    EXPECT_FALSE(is_star(torus(40, 20, 2.0, 0.5)));
    // Every ray from the middle meets it twice, each time from the same side.
    EXPECT_FALSE(is_star(joined(sphere(20, 40, 1.0), sphere(20, 40, 1.0))));
    EXPECT_FALSE(is_star(joined(sphere(20, 40, 1.0), sphere(20, 40, 2.0))));
    EXPECT_FALSE(is_star(joined(sphere(20, 40, 1.0), moved(sphere(20, 40, 1.0), {{3, 0, 0}}))));
    IndexedMesh open = sphere(20, 40, 1.0);
    open.faces.pop_back();
    EXPECT_FALSE(is_star(open));
    IndexedMesh through = sphere(20, 40, 1.0);
    through.vertices[100] = -2.0 * through.vertices[100];
    EXPECT_FALSE(is_star(through));
}

// Points on a triangle, moved by less than the reach, fall into cells that are gone through.
TEST(CellGrids, GoThroughEveryCellOfATriangle)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int trial = 0; trial < 200; ++trial) {
        // Broad ones, needles and some along an axis.
        const double width = trial % 3 == 0 ? 1.0 : std::pow(0.1, trial % 12);
        const double reach = trial % 2 == 0 ? 0.0 : 40.0;
        std::vector<Vec3> points{{{0, 0, 0}}, {{1e3, 1e3, 1e3}}};
        for (int i = 0; i < 2; ++i)
            points.push_back({{1e3 * share(random), 1e3 * share(random), 1e3 * share(random)}});
        points.push_back(points[2] + width * Vec3{{500 * share(random), 300, 0}});
        if (trial % 5 == 0)
            for (int i = 2; i < 5; ++i) points[i][trial % 3] = 500.0;
        const Triangle t{2, 3, 4};
        for (int i = 0; i < 500; ++i) {
            const double u = share(random);
            const double v = (1.0 - u) * share(random);
            Vec3 p = points[2] + u * (points[3] - points[2]) + v * (points[4] - points[2]);
            for (double& c : p.c) c += 0.99 * reach * (2.0 * share(random) - 1.0);
            points.push_back(p);
        }
        const exact::CellGrid grid(points, 200'000);
        std::set<std::size_t> seen;
        grid.visit_until(t, grid.range(t, reach), reach, [&](std::size_t cell) {
            EXPECT_LT(cell, grid.n_cells());
            seen.insert(cell);
            return false;
        });
        for (std::size_t i = 5; i < points.size(); ++i)
            EXPECT_TRUE(seen.contains(grid.cell_of(static_cast<std::int32_t>(i))))
                << "trial " << trial;
    }
}

struct Outcome {
    exact::Solved solved;
    bool has_zone = false;
};

Outcome solve(const exact::Soup& soup, const std::vector<IndexedMesh>& meshes,
              const BooleanFormula& formula, bool in_zone)
{
    const exact::Frame frame = frame_round(meshes);
    const auto n = static_cast<std::int32_t>(meshes.size());
    exact::Start start = in_zone ? exact::look_over_zone(soup, frame, formula, n)
                                 : exact::look_over(soup, formula, n);
    Outcome outcome;
    outcome.has_zone = start.zone.has_value();
    MeshBooleanReport report;
    Vec3 place;
    auto solved = exact::solve_whole(soup, frame, formula, n, {}, std::move(start), report, place);
    EXPECT_TRUE(solved.has_value());
    if (solved) outcome.solved = std::move(*solved);
    return outcome;
}

// Returns whether there was a zone.
bool expect_same(const std::vector<IndexedMesh>& meshes, const BooleanFormula& formula,
                 bool may_cross_themselves = true)
{
    exact::Soup soup = soup_of(meshes);
    if (!may_cross_themselves) soup.crosses_itself.assign(meshes.size(), 0);
    const Outcome whole = solve(soup, meshes, formula, false);
    const Outcome zone = solve(soup, meshes, formula, true);
    const auto same = [](const exact::Soup::Given& a, const exact::Soup::Given& b) {
        return a.operand == b.operand && a.face == b.face;
    };
    EXPECT_TRUE(whole.solved.points == zone.solved.points);
    EXPECT_TRUE(whole.solved.faces == zone.solved.faces);
    EXPECT_TRUE(std::equal(whole.solved.given.begin(), whole.solved.given.end(),
                           zone.solved.given.begin(), zone.solved.given.end(), same));
    EXPECT_EQ(whole.solved.parts_touch, zone.solved.parts_touch);
    return zone.has_zone;
}

class Places {
public:
    explicit Places(std::uint32_t seed) : random_(seed) {}

    IndexedMesh place(const IndexedMesh& mesh, double reach)
    {
        const Vec3 axis = inside(1.0);
        return moved(turned(mesh, axis + Vec3{{0, 0, 2}}, 360.0 * share()), inside(reach));
    }

private:
    double share() { return static_cast<double>(random_()) / 4294967296.0; }
    Vec3 inside(double reach)
    {
        Vec3 p;
        for (double& c : p.c) c = reach * (2.0 * share() - 1.0);
        return p;
    }
    std::mt19937 random_;
};

TEST(Zones, MakeNoDifference)
{
    Places places(5);
    const IndexedMesh ball = sphere(40, 80, 1.0);
    const IndexedMesh ring = torus(90, 40, 1.0, 0.3);
    int n_zones = 0;
    for (int trial = 0; trial < 12; ++trial) {
        SCOPED_TRACE(trial);
        const IndexedMesh a = places.place(trial % 2 == 0 ? ball : ring, 0.8);
        const IndexedMesh b = places.place(trial % 3 == 0 ? ball : ring, 0.8);
        const BooleanFormula formula = trial % 4 < 2    ? BooleanFormula::difference_of(2)
                                       : trial % 4 == 2 ? BooleanFormula::union_of(2)
                                                        : BooleanFormula::intersection_of(2);
        n_zones += expect_same({a, b}, formula);
    }
    EXPECT_GE(n_zones, 8);
}

TEST(Zones, GiveTheSameBitsOnAnyNumberOfThreads)
{
    const std::vector<IndexedMesh> balls{sphere(60, 120, 1.0),
                                         moved(sphere(60, 120, 1.0), {{0.1, 0.2, 0.3}})};
    const BooleanFormula formula = BooleanFormula::difference_of(2);
    const int before = thread_count();
    set_thread_count(1);
    const MeshBooleanResult one = mesh_boolean(balls, formula);
    EXPECT_GT(one.report.n_left_alone, 0);
    for (const int threads : {2, 8}) {
        set_thread_count(threads);
        const MeshBooleanResult more = mesh_boolean(balls, formula);
        EXPECT_TRUE(one.mesh.vertices == more.mesh.vertices && one.mesh.faces == more.mesh.faces &&
                    one.operand == more.operand && one.source_face == more.source_face);
    }
    set_thread_count(before);
}

// What is joined to a face that is cut by its plane comes along, however far away.
TEST(Zones, HoldWhatLiesInOnePlaneWithWhatIsCut)
{
    const auto flattened = [](IndexedMesh mesh, double at) {
        for (Vec3& p : mesh.vertices) p[2] = std::clamp(p[2], -at, at);
        return mesh;
    };
    // Two drums with finely cut ends, one sunk into the other's end near its rim.
    const IndexedMesh drum = flattened(sphere(60, 120, 1.0), 0.3);
    const IndexedMesh peg = moved(scaled(sphere(40, 80, 1.0), 0.1), {{0.7, 0.0, 0.3}});
    EXPECT_TRUE(expect_same({drum, peg}, BooleanFormula::difference_of(2)));
}

TEST(Zones, HoldNoneOfThePartsThatMeetNothing)
{
    IndexedMesh many = sphere(30, 60, 1.0);
    for (int i = 0; i < 20; ++i)
        many = joined(many, moved(scaled(sphere(10, 20, 1.0), 0.3),
                                  {{2.0 + i % 4, i / 4 - 2.0, 0.5 * (i % 3)}}));
    // One that holds all of them, and one in the first alone.
    const IndexedMesh around = moved(scaled(sphere(40, 80, 1.0), 6.0), {{2.0, 0.0, 0.0}});
    const IndexedMesh beside = moved(sphere(30, 60, 1.0), {{-0.9, 0.3, 0.2}});
    EXPECT_TRUE(expect_same({many, beside}, BooleanFormula::union_of(2), false));
    EXPECT_TRUE(expect_same({many, beside}, BooleanFormula::intersection_of(2), false));
    EXPECT_TRUE(expect_same({around, many}, BooleanFormula::difference_of(2), false));
    EXPECT_TRUE(expect_same({around, inside_out(many)}, BooleanFormula::difference_of(2), false));
}

// Fans that meet in one corner get corners of their own, in a zone and beyond.
TEST(Zones, PartWhatTouchesInOnePoint)
{
    const auto pair = [](double angle) {
        // The second ball hangs on the last vertex of the first, a pole.
        IndexedMesh ball = sphere(40, 80, 1.0);
        const auto n = static_cast<std::int32_t>(ball.vertices.size());
        std::int32_t pole = 0;
        for (std::int32_t v = 0; v < n; ++v)
            if (ball.vertices[v][2] > ball.vertices[pole][2]) pole = v;
        IndexedMesh both = ball;
        const Vec3 top = ball.vertices[pole];
        for (std::int32_t v = 0; v < n; ++v) both.vertices.push_back(2.0 * top - ball.vertices[v]);
        for (const Triangle& t : ball.faces) {
            Triangle u{t[0] + n, t[2] + n, t[1] + n};
            for (std::int32_t& v : u)
                if (v == pole + n) v = pole;
            both.faces.push_back(u);
        }
        return turned(both, {{1, 0, 0}}, angle);
    };
    const IndexedMesh small = scaled(sphere(30, 60, 1.0), 0.2);
    for (const double angle : {0.0, 90.0, 145.0, 170.0, 180.0}) {
        SCOPED_TRACE(angle);
        const IndexedMesh hanging = pair(angle);
        EXPECT_TRUE(
            expect_same({hanging, moved(small, {{0, 0, -1}})}, BooleanFormula::difference_of(2)));
        const MeshBooleanResult result =
            mesh_boolean(std::vector<IndexedMesh>{hanging, moved(small, {{0, 0, -1}})},
                         BooleanFormula::difference_of(2));
        expect_sound(result.mesh);
    }
}

}  // namespace
}  // namespace genus
