#include "genus/patch/tessellate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/patch/reference.h"
#include "genus/base/error.h"

namespace genus {
namespace {

using reference::random_points;
using reference::random_vec;

struct Borders {
    int open = 0;      // directed edges without their opposite
    int loops = 0;     // closed walks of such edges
    int repeated = 0;  // directed edges that occur twice
    int euler = 0;
};

Borders borders(const IndexedMesh& mesh)
{
    std::map<std::pair<int, int>, int> count;
    std::set<int> used;
    for (const Triangle& t : mesh.faces)
        for (int k = 0; k < 3; ++k) {
            ++count[{t[k], t[(k + 1) % 3]}];
            used.insert(t[k]);
        }
    Borders b;
    std::map<int, int> next;
    int edges = 0;
    for (const auto& [e, n] : count) {
        b.repeated += n > 1;
        const bool paired = count.contains({e.second, e.first});
        if (!paired) {
            ++b.open;
            next[e.first] = e.second;
        }
        edges += !paired || e.first < e.second;
    }
    b.euler = int(used.size()) - edges + int(mesh.faces.size());
    while (!next.empty()) {
        ++b.loops;
        for (auto at = next.begin(); at != next.end();) {
            const int to = at->second;
            next.erase(at);
            at = next.find(to);
        }
    }
    return b;
}

Vec3 value(const Patch& p, const Vec2& uv)
{
    return std::visit([&](const auto& s) { return s.value(uv[0], uv[1]); }, p);
}

// Largest distance found between mesh and patches at equal parameters.
double measured(std::span<const Patch> patches, const TessellatedPatches& t, int step = 1)
{
    double worst = 0.0;
    for (std::size_t f = 0; f < t.mesh.faces.size(); f += static_cast<std::size_t>(step))
        for (const auto& w : {Vec3{{1, 0, 0}}, Vec3{{1, 1, 1}}, Vec3{{1, 1, 0}}, Vec3{{0, 1, 1}},
                              Vec3{{2, 1, 1}}, Vec3{{1, 4, 1}}}) {
            const double sum = w[0] + w[1] + w[2];
            Vec3 linear;
            Vec2 uv;
            for (int k = 0; k < 3; ++k) {
                linear += (w[k] / sum) * t.mesh.vertices[t.mesh.faces[f][k]];
                uv += (w[k] / sum) * t.corners[f][k];
            }
            worst = std::max(worst, distance(linear, value(patches[t.patch_of_face[f]], uv)));
        }
    return worst;
}

TensorPatch bumpy(std::mt19937_64& random, int m, int n, bool rational)
{
    std::uniform_real_distribution<double> height(-0.3, 0.3), weight(0.5, 2.0);
    std::vector<Vec3> points;
    std::vector<double> weights;
    for (int i = 0; i <= m; ++i)
        for (int j = 0; j <= n; ++j) {
            points.push_back({{double(i) / m, double(j) / n, height(random)}});
            if (rational) weights.push_back(weight(random));
        }
    return TensorPatch(m, n, points, weights);
}

TEST(Tessellate, StaysWithinItsBoundAndTheTolerance)
{
    std::mt19937_64 random(101);
    std::vector<double> ratio;
    for (int trial = 0; trial < 8; ++trial)
        for (const double tolerance : {1e-1, 1e-2, 1e-3}) {
            const int m = 1 + trial % 4, n = 1 + trial % 3;
            std::vector<Patch> patches;
            if (trial % 3 == 0)
                patches.emplace_back(
                    BezierTriangle(m, random_points(random, (m + 1) * (m + 2) / 2)));
            else
                patches.emplace_back(bumpy(random, m, n, trial % 3 == 2));
            SCOPED_TRACE(testing::Message() << "trial " << trial << " tolerance " << tolerance);
            const auto t = tessellate(patches, {tolerance});
            ASSERT_LE(t.bound, tolerance);
            const double error = measured(patches, t, 1 + int(t.mesh.faces.size()) / 300);
            ASSERT_LE(error, t.bound) << trial;
            if (error > 1e-12) ratio.push_back(tolerance / error);
            const Borders b = borders(t.mesh);
            ASSERT_EQ(b.euler, 1);
            ASSERT_EQ(b.loops, 1);
            ASSERT_EQ(b.repeated, 0);
        }
    std::nth_element(ratio.begin(), ratio.begin() + ratio.size() / 2, ratio.end());
    EXPECT_LE(ratio[ratio.size() / 2], 12.0);
}

// A quarter of the tolerance takes four times the triangles, that is twice as many a side; the
// error found falls alike.
TEST(Tessellate, ErrorFallsFourfoldPerDoubling)
{
    std::mt19937_64 random(102);
    for (const bool triangle : {false, true}) {
        std::vector<Patch> patches;
        if (triangle)
            patches.emplace_back(BezierTriangle(4, random_points(random, 15)));
        else
            patches.emplace_back(bumpy(random, 3, 3, false));
        std::vector<double> faces, error;
        for (const double tolerance : {1e-3, 1e-3 / 4, 1e-3 / 16, 1e-3 / 64}) {
            const auto t = tessellate(patches, {tolerance});
            faces.push_back(double(t.mesh.faces.size()));
            error.push_back(measured(patches, t, 1 + int(t.mesh.faces.size()) / 3000));
        }
        const double order =
            2.0 * std::log(error.front() / error.back()) / std::log(faces.back() / faces.front());
        EXPECT_NEAR(order, 2.0, 0.35) << triangle;
        EXPECT_NEAR(faces.back() / faces.front(), 64.0, 24.0) << triangle;
    }
}

TEST(Tessellate, PlanePatchNeedsTwoTriangles)
{
    const std::vector<Patch> flat = {
        TensorPatch(1, 1, {{{0, 0, 0}}, {{0, 1, 0}}, {{1, 0, 0}}, {{1, 1, 0}}})};
    const auto t = tessellate(flat, {1e-9});
    EXPECT_EQ(t.mesh.faces.size(), 2u);
    const std::vector<Patch> high = {TensorPatch(std::get<TensorPatch>(flat[0]).elevated(3, 4))};
    EXPECT_EQ(tessellate(high, {1e-9}).mesh.faces.size(), 2u);
}

BezierCurve random_edge(std::mt19937_64& random, int degree, bool rational)
{
    std::uniform_real_distribution<double> weight(0.5, 2.0);
    std::vector<double> w;
    for (int i = 0; rational && i <= degree; ++i) w.push_back(weight(random));
    return BezierCurve(random_points(random, degree + 1), w);
}

// A patch of either kind, of degree `n` at least that of `edge`, that has `edge` as one of its
// edges, in either direction; all else random.
Patch patch_with_edge(std::mt19937_64& random, const BezierCurve& edge, bool triangle)
{
    std::uniform_real_distribution<double> weight(0.5, 2.0);
    const bool rational = edge.rational();
    const BezierCurve c = random() % 2 == 0 ? edge : edge.reversed();
    const int n = c.degree(), m = 1 + static_cast<int>(random() % 4);
    const int count = triangle ? (n + 1) * (n + 2) / 2 : (n + 1) * (m + 1);
    auto points = random_points(random, count);
    std::vector<double> weights;
    for (int i = 0; rational && i < count; ++i) weights.push_back(weight(random));
    const int side = static_cast<int>(random() % (triangle ? 3 : 4));
    const bool along_u = !triangle && side % 2 == 0;
    for (int s = 0; s <= n; ++s) {
        std::size_t at = 0;
        if (triangle)
            at = BezierTriangle::index(n,
                                       side == 0   ? s
                                       : side == 1 ? n - s
                                                   : 0,
                                       side == 0   ? 0
                                       : side == 1 ? s
                                                   : n - s);
        else if (along_u)
            at = static_cast<std::size_t>(s * (m + 1) + (side == 0 ? 0 : m));
        else
            at = static_cast<std::size_t>((side == 1 ? m : 0) * (n + 1) + s);
        points[at] = c.points()[s];
        if (rational) weights[at] = c.weights()[s];
    }
    if (triangle) return BezierTriangle(n, points, weights);
    return along_u ? TensorPatch(n, m, points, weights) : TensorPatch(m, n, points, weights);
}

TEST(Tessellate, NoCrackBetweenRandomNeighbours)
{
    const int pairs = reference::long_run() ? 10000 : 150;
    std::mt19937_64 random(103);
    std::uniform_real_distribution<double> log_tolerance(-2.3, 0.5);
    for (int trial = 0; trial < pairs; ++trial) {
        SCOPED_TRACE(testing::Message() << "pair " << trial << " seed 103");
        const BezierCurve edge = random_edge(random, 1 + trial % 4, trial % 5 == 0);
        const int up = trial % 7 == 0 ? 1 + trial % 2 : 0;
        std::vector<Patch> patches = {patch_with_edge(random, edge, trial % 2 == 0),
                                      patch_with_edge(random, edge.elevated(up), trial % 3 == 0)};
        const double tolerance = std::pow(10.0, log_tolerance(random));
        const auto t = tessellate(patches, {tolerance});
        ASSERT_LE(t.bound, tolerance);
        ASSERT_LE(measured(patches, t, 1 + int(t.mesh.faces.size()) / 50), t.bound);
        // Orientations of the two are random, so edges are counted without direction: joined
        // along one edge they make a disc.
        std::map<std::pair<int, int>, int> edges;
        std::set<int> used;
        for (const Triangle& f : t.mesh.faces)
            for (int k = 0; k < 3; ++k) {
                ++edges[std::minmax(f[k], f[(k + 1) % 3])];
                used.insert(f[k]);
            }
        ASSERT_EQ(int(used.size()) - int(edges.size()) + int(t.mesh.faces.size()), 1);
        std::map<int, int> degree;
        for (const auto& [e, n] : edges) {
            ASSERT_LE(n, 2);
            if (n == 1) {
                ++degree[e.first];
                ++degree[e.second];
            }
        }
        for (const auto& [vertex, n] : degree) ASSERT_EQ(n, 2);

        // Alone, each patch puts the same points on the edge.
        if (up > 0) continue;
        std::set<std::array<double, 3>> first;
        for (const Vec3& p :
             tessellate(std::span(patches).subspan(0, 1), {tolerance}).mesh.vertices)
            first.insert(p.c);
        const auto second = tessellate(std::span(patches).subspan(1, 1), {tolerance});
        int shared = 0;
        for (const Vec3& p : second.mesh.vertices) shared += first.contains(p.c);
        int between = 0;
        std::map<int, int> sides;
        for (std::size_t f = 0; f < t.mesh.faces.size(); ++f)
            for (const int vertex : t.mesh.faces[f]) sides[vertex] |= 1 << t.patch_of_face[f];
        for (const auto& [vertex, s] : sides) between += s == 3;
        ASSERT_EQ(shared, between);
    }
}

TEST(Tessellate, ClosedModelsAreWatertight)
{
    const BSpline half = elliptic_arc({}, {{2, 0, 0}}, {{0, 0, 2}}, -90.0, 180.0);
    const BSpline circle = elliptic_arc({{3, 0, 0}}, {{1, 0, 0}}, {{0, 0, 1}});
    for (const double tolerance : {0.3, 1e-2, 3e-3}) {
        const auto sphere = tessellate(surface_of_revolution(half), {tolerance});
        Borders b = borders(sphere.mesh);
        EXPECT_EQ(b.open, 0);
        EXPECT_EQ(b.repeated, 0);
        EXPECT_EQ(b.euler, 2);
        for (const Vec3& p : sphere.mesh.vertices) EXPECT_NEAR(norm(p), 2.0, 1e-13);
        const auto torus = tessellate(surface_of_revolution(circle), {tolerance});
        b = borders(torus.mesh);
        EXPECT_EQ(b.open, 0);
        EXPECT_EQ(b.repeated, 0);
        EXPECT_EQ(b.euler, 0);
    }
}

// Six bicubic faces of a cube blown up, sharing their boundary curves.
TEST(Tessellate, BlownUpCubeIsClosed)
{
    std::vector<Patch> faces;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            std::vector<Vec3> points;
            for (int i = 0; i <= 3; ++i)
                for (int j = 0; j <= 3; ++j) {
                    const double a = (2.0 * i - 3.0) / 3.0, b = (2.0 * j - 3.0) / 3.0;
                    Vec3 p;
                    p[axis] = side;
                    p[(axis + 1) % 3] = side > 0 ? a : b;
                    p[(axis + 2) % 3] = side > 0 ? b : a;
                    points.push_back(p * (1.0 + 0.2 * (3.0 - dot(p, p))));
                }
            faces.emplace_back(TensorPatch(3, 3, points));
        }
    const auto t = tessellate(faces, {1e-3});
    const Borders b = borders(t.mesh);
    EXPECT_EQ(b.open, 0);
    EXPECT_EQ(b.repeated, 0);
    EXPECT_EQ(b.euler, 2);
    EXPECT_LE(measured(faces, t), t.bound);
}

// One of two rational neighbours elevated: the corners must stay the same to the last bit.
TEST(Tessellate, ElevatedRationalNeighboursStayJoined)
{
    const BSpline half = elliptic_arc({{0.1, 0, 0}}, {{0.7, 0, 0}}, {{0, 0, 0.9}}, -90.0, 180.0);
    std::vector<Patch> patches;
    int k = 0;
    for (const TensorPatch& p : surface_of_revolution(half).bezier_patches())
        patches.emplace_back(k++ % 2 == 0 ? p.elevated(2, 1) : p);
    const auto t = tessellate(patches, {1e-2});
    // The axis is left open by the shifted profile: two small holes.
    const Borders b = borders(t.mesh);
    EXPECT_EQ(b.loops, 2);
    EXPECT_EQ(b.euler, 0);
    EXPECT_EQ(b.repeated, 0);
}

TEST(Tessellate, RefusesWhatItCannotDo)
{
    std::mt19937_64 random(104);
    const std::vector<Patch> patch = {bumpy(random, 3, 3, false)};
    EXPECT_THROW(tessellate(patch, {0.0}), InvalidInput);
    EXPECT_THROW(tessellate(patch, {std::nan("")}), InvalidInput);
    EXPECT_THROW(tessellate(patch, {1e-17}), ToleranceNotMet);
    EXPECT_THROW(tessellate(patch, {1e-6, 1000}), ToleranceNotMet);
    EXPECT_TRUE(tessellate(std::vector<Patch>{}, {1.0}).mesh.faces.empty());
}

}  // namespace
}  // namespace genus
