#include "genus/patch/surface.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/patch/reference.h"
#include "genus/base/error.h"
#include "genus/patch/bezier_triangle.h"
#include "genus/patch/bspline_surface.h"
#include "genus/patch/bulk.h"
#include "genus/patch/tensor_patch.h"

namespace genus {
namespace {

using reference::Quad;
using reference::random_points;
using reference::random_vec;

std::vector<double> random_weights(std::mt19937_64& random, std::size_t n, bool rational)
{
    std::uniform_real_distribution<double> weight(0.3, 3.0);
    std::vector<double> w;
    for (std::size_t i = 0; rational && i < n; ++i) w.push_back(weight(random));
    return w;
}

TensorPatch random_tensor(std::mt19937_64& random, int m, int n, bool rational = false)
{
    const int count = (m + 1) * (n + 1);
    return TensorPatch(m, n, random_points(random, count), random_weights(random, count, rational));
}

BezierTriangle random_triangle(std::mt19937_64& random, int n, bool rational = false)
{
    const int count = (n + 1) * (n + 2) / 2;
    return BezierTriangle(n, random_points(random, count), random_weights(random, count, rational));
}

// Random points of the domain, u + v <= 1 for triangles.
void random_domain(std::mt19937_64& random, std::size_t n, bool triangle, std::vector<double>& u,
                   std::vector<double>& v)
{
    std::uniform_real_distribution<double> x(0.0, 1.0);
    u.clear();
    v.clear();
    for (std::size_t i = 0; i < n; ++i) {
        double a = x(random), b = x(random);
        if (triangle && a + b > 1.0) {
            a = 1.0 - a;
            b = 1.0 - b;
        }
        u.push_back(a);
        v.push_back(b);
    }
}

// Partials against difference quotients, for anything with value and partials.
template <class Patch>
void expect_partials(const Patch& s, double u, double v)
{
    const double h = 1e-4;
    const auto p = s.partials(u, v);
    const auto east = s.partials(u + h, v), west = s.partials(u - h, v);
    const auto north = s.partials(u, v + h), south = s.partials(u, v - h);
    const double size = 1.0 + norm(p.puu) + norm(p.puv) + norm(p.pvv);
    EXPECT_LE(distance(p.p, s.value(u, v)), 1e-13);
    EXPECT_LE(distance((east.p - west.p) / (2 * h), p.pu), 1e-4 * size);
    EXPECT_LE(distance((north.p - south.p) / (2 * h), p.pv), 1e-4 * size);
    EXPECT_LE(distance((east.pu - west.pu) / (2 * h), p.puu), 1e-3 * size);
    EXPECT_LE(distance((north.pu - south.pu) / (2 * h), p.puv), 1e-3 * size);
    EXPECT_LE(distance((north.pv - south.pv) / (2 * h), p.pvv), 1e-3 * size);
    EXPECT_LE(distance(s.normal(u, v), normalized(cross(p.pu, p.pv))), 1e-12);
}

TEST(TensorPatch, PartialsNormalsAndBulkAgree)
{
    std::mt19937_64 random(91);
    for (const bool rational : {false, true})
        for (const auto& [m, n] : {std::pair{1, 1}, {2, 3}, {3, 3}, {5, 1}, {4, 7}, {0, 3}}) {
            SCOPED_TRACE(testing::Message() << m << " " << n << " " << rational);
            const TensorPatch s = random_tensor(random, m, n, rational);
            std::vector<double> u, v;
            random_domain(random, 53, false, u, v);
            std::vector<Vec3> points(53), alone(53), normals(53);
            s.evaluate(u, v, points, normals);
            s.evaluate(u, v, alone);
            for (std::size_t i = 0; i < u.size(); ++i) {
                const auto exact = s.value_with_bound(u[i], v[i]);
                ASSERT_LE(distance(points[i], exact.value), 1e-14);
                ASSERT_LE(distance(alone[i], exact.value), 1e-14);
                ASSERT_LE(distance(normals[i], s.normal(u[i], v[i])), 1e-9);
            }
            if (m > 0) expect_partials(s, 0.37, 0.61);
        }
}

TEST(BezierTriangle, PartialsNormalsAndBulkAgree)
{
    std::mt19937_64 random(92);
    for (const bool rational : {false, true})
        for (const int n : {1, 2, 3, 4, 7}) {
            SCOPED_TRACE(testing::Message() << n << " " << rational);
            const BezierTriangle s = random_triangle(random, n, rational);
            std::vector<double> u, v;
            random_domain(random, 53, true, u, v);
            std::vector<Vec3> points(53), alone(53), normals(53);
            s.evaluate(u, v, points, normals);
            s.evaluate(u, v, alone);
            for (std::size_t i = 0; i < u.size(); ++i) {
                const auto exact = s.value_with_bound(u[i], v[i]);
                ASSERT_LE(distance(points[i], exact.value), 1e-14);
                ASSERT_EQ(alone[i], points[i]);
                ASSERT_LE(distance(normals[i], s.normal(u[i], v[i])), 1e-9);
            }
            expect_partials(s, 0.31, 0.22);
        }
}

// Nested de Casteljau in 113 bits.
std::array<Quad, 3> tensor_truth(const TensorPatch& s, double u, double v)
{
    const auto h = s.homogeneous();
    std::vector<std::array<Quad, 4>> rows;
    const std::size_t width = static_cast<std::size_t>(s.degree_v()) + 1;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(s.degree_u()); ++i)
        rows.push_back(reference::value<4>(std::span(h).subspan(i * width, width), v));
    const Quad t = u, r = Quad(1) - t;
    for (std::size_t left = rows.size() - 1; left > 0; --left)
        for (std::size_t i = 0; i < left; ++i)
            for (std::size_t k = 0; k < 4; ++k) rows[i][k] = r * rows[i][k] + t * rows[i + 1][k];
    return {rows[0][0] / rows[0][3], rows[0][1] / rows[0][3], rows[0][2] / rows[0][3]};
}

std::array<Quad, 3> triangle_truth(const BezierTriangle& s, double u, double v)
{
    std::vector<std::array<Quad, 4>> c;
    for (const Vec4& p : s.homogeneous()) c.push_back({p[0], p[1], p[2], p[3]});
    const Quad uu = u, vv = v, ww = Quad(1) - uu - vv;
    const auto at = [](int n, int i, int j) { return BezierTriangle::index(n, i, j); };
    for (int n = s.degree(); n > 0; --n)
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n - i; ++j)
                for (std::size_t k = 0; k < 4; ++k)
                    c[at(n - 1, i, j)][k] = uu * c[at(n, i + 1, j)][k] +
                                            vv * c[at(n, i, j + 1)][k] + ww * c[at(n, i, j)][k];
    return {c[0][0] / c[0][3], c[0][1] / c[0][3], c[0][2] / c[0][3]};
}

// Coordinates from 1e-12 to 1e12, of either sign.
Vec3 hard_point(std::mt19937_64& random)
{
    std::uniform_real_distribution<double> exponent(-12.0, 12.0), sign(-1.0, 1.0);
    Vec3 p;
    for (std::size_t k = 0; k < 3; ++k)
        p[k] = std::copysign(std::pow(10.0, exponent(random)), sign(random));
    return p;
}

template <class Patch, class Truth>
void expect_bounds(const Patch& s, const Truth& truth, const std::vector<double>& u,
                   const std::vector<double>& v, std::vector<double>& ratios)
{
    for (std::size_t i = 0; i < u.size(); ++i) {
        const auto ours = s.value_with_bound(u[i], v[i]);
        const auto exact = truth(s, u[i], v[i]);
        for (std::size_t k = 0; k < 3; ++k) {
            const Quad error = reference::magnitude(exact[k] - Quad(ours.value[k]));
            ASSERT_LE(error, Quad(ours.bound[k])) << u[i] << " " << v[i];
            if (error > 0) ratios.push_back(double(Quad(ours.bound[k]) / error));
        }
    }
}

double median(std::vector<double> x)
{
    std::nth_element(x.begin(), x.begin() + x.size() / 2, x.end());
    return x[x.size() / 2];
}

TEST(SurfaceBounds, AlwaysHoldAndAreTightInTheMedian)
{
    std::mt19937_64 random(93);
    const int rounds = reference::long_run() ? 2000 : 40;
    std::vector<double> u, v, ratios;
    for (int round = 0; round < rounds; ++round) {
        const int m = 1 + round % 9, n = 1 + (round / 3) % 12;
        std::vector<Vec3> points;
        for (int i = 0; i < (m + 1) * (n + 1); ++i) points.push_back(hard_point(random));
        random_domain(random, 10, false, u, v);
        expect_bounds(TensorPatch(m, n, points), tensor_truth, u, v, ratios);
        points.resize((m + 1) * (m + 2) / 2, Vec3{{1, 2, 3}});
        random_domain(random, 10, true, u, v);
        expect_bounds(BezierTriangle(m, points), triangle_truth, u, v, ratios);
    }
    EXPECT_LE(median(ratios), 10.0);
    RecordProperty("median_ratio", std::to_string(median(ratios)));
}

TEST(TensorPatch, EdgesSplitsAndElevationKeepTheSurface)
{
    std::mt19937_64 random(94);
    for (const bool rational : {false, true})
        for (const auto& [m, n] : {std::pair{1, 2}, {3, 3}, {5, 2}}) {
            const TensorPatch s = random_tensor(random, m, n, rational);
            for (int k = 0; k < 4; ++k)
                for (const double t : {0.0, 0.3, 1.0}) {
                    const Vec2 q = TensorPatch::on_edge(k, t);
                    EXPECT_LE(distance(s.edge(k).value(t), s.value(q[0], q[1])), 1e-14);
                }
            const auto part = s.part(0.2, 0.7, 0.9, 0.4);
            const auto [low, high] = s.split_v(0.3);
            for (const double x : {0.0, 0.4, 1.0})
                for (const double y : {0.0, 0.8, 1.0}) {
                    EXPECT_LE(distance(part.value(x, y), s.value(0.2 + 0.5 * x, 0.9 - 0.5 * y)),
                              1e-13);
                    EXPECT_LE(distance(low.value(x, y), s.value(x, 0.3 * y)), 1e-13);
                    EXPECT_LE(distance(high.value(x, y), s.value(x, 0.3 + 0.7 * y)), 1e-13);
                    EXPECT_LE(distance(s.elevated(1, 2).value(x, y), s.value(x, y)), 1e-13);
                    EXPECT_LE(distance(s.transposed().value(y, x), s.value(x, y)), 1e-13);
                    EXPECT_LE(distance(s.curve_u(y).value(x), s.value(x, y)), 1e-13);
                    EXPECT_LE(distance(s.curve_v(x).value(y), s.value(x, y)), 1e-13);
                }
        }
}

TEST(BezierTriangle, EdgesPartsAndElevationKeepTheSurface)
{
    std::mt19937_64 random(95);
    for (const bool rational : {false, true})
        for (const int n : {1, 2, 4}) {
            const BezierTriangle s = random_triangle(random, n, rational);
            for (int k = 0; k < 3; ++k)
                for (const double t : {0.0, 0.3, 1.0}) {
                    const Vec2 q = BezierTriangle::on_edge(k, t);
                    EXPECT_LE(distance(s.edge(k).value(t), s.value(q[0], q[1])), 1e-14);
                }
            const Vec2 a{{0.1, 0.2}}, b{{0.7, 0.1}}, c{{0.3, 0.6}};
            const auto part = s.part(a, b, c);
            const auto quarters = s.quartered();
            for (const auto& q : {Vec2{{0, 0}}, {{1, 0}}, {{0, 1}}, {{0.2, 0.3}}}) {
                const Vec2 at = (1 - q[0] - q[1]) * a + q[0] * b + q[1] * c;
                EXPECT_LE(distance(part.value(q[0], q[1]), s.value(at[0], at[1])), 1e-12);
                EXPECT_LE(distance(s.elevated(2).value(q[0], q[1]), s.value(q[0], q[1])), 1e-13);
                EXPECT_LE(distance(quarters[3].value(q[0], q[1]),
                                   s.value(0.5 - 0.5 * q[0], 0.5 - 0.5 * q[1])),
                          1e-13);
            }
        }
}

TEST(TensorPatch, ContinuationIsSmooth)
{
    std::mt19937_64 random(96);
    for (int order = 0; order <= 2; ++order) {
        const TensorPatch a = random_tensor(random, 3, 2);
        auto rows = continuation(a, order, 1.5);
        std::vector<Vec3> points;
        for (const auto& row : rows) points.insert(points.end(), row.begin(), row.end());
        while (points.size() < 12) points.push_back(random_vec(random));
        const TensorPatch b(3, 2, points);
        for (const double v : {0.0, 0.4, 1.0}) {
            const auto pa = a.partials(1.0, v), pb = b.partials(0.0, v);
            EXPECT_LE(distance(pa.p, pb.p), 1e-14);
            if (order >= 1) {
                EXPECT_LE(distance(1.5 * pa.pu, pb.pu), 1e-12);
            }
            if (order >= 2) {
                EXPECT_LE(distance(2.25 * pa.puu, pb.puu), 1e-11);
            }
        }
    }
}

TEST(BezierTriangle, PartsOfOnePolynomialJoinC1)
{
    std::mt19937_64 random(97);
    const BezierTriangle s = random_triangle(random, 4);
    const auto q = s.quartered();
    // Edge 1 of the first quarter is edge 1 of the middle one, run backwards; in the first's
    // coordinates the far corner of the middle one is (1, 1).
    EXPECT_LE(c1_defect(q[0], 1, q[3], 1, {{1, 1}}), 1e-13);
    BezierTriangle moved = random_triangle(random, 4);
    EXPECT_GT(c1_defect(q[0], 1, moved, 1, {{1, 1}}), 1e-3);
}

// An octant of the unit sphere as a biquadratic with a collapsed edge at the pole.
TEST(Normals, AreLimitsAtCollapsedEdges)
{
    const double s = std::sqrt(0.5);
    const BSpline half = elliptic_arc({}, {{1, 0, 0}}, {{0, 0, 1}}, -90.0, 180.0);
    const BSplineSurface sphere = surface_of_revolution(half);
    for (const TensorPatch& patch : sphere.bezier_patches()) {
        for (const double u : {0.0, 0.3, 1.0})
            for (const double v : {0.0, 0.5, 1.0}) {
                const Vec3 p = patch.value(u, v), n = patch.normal(u, v);
                EXPECT_NEAR(norm(p), 1.0, 1e-14);
                EXPECT_NEAR(std::fabs(dot(p, n)), 1.0, 1e-9) << u << " " << v;
                EXPECT_GT(dot(p, n) * dot(patch.value(0.5, 0.5), patch.normal(0.5, 0.5)), 0.0);
            }
        std::vector<double> u = {0, 1, 0.5}, v = {0.2, 0.7, 0.5};
        std::vector<Vec3> points(3), normals(3);
        patch.evaluate(u, v, points, normals);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::fabs(dot(points[i], normals[i])), 1.0, 1e-9);
    }
    // A triangle as a bilinear patch with two equal corners, flat: the normal is that of its plane.
    const TensorPatch flat(1, 1, {{{0, 0, 0}}, {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}});
    EXPECT_LE(distance(flat.normal(0, 0.5), {{0, 0, 1}}), 1e-12);
    EXPECT_LE(distance(flat.normal(0, 0), {{0, 0, 1}}), 1e-12);
    // A curve has no normal.
    const TensorPatch line(1, 1, {{{0, 0, 0}}, {{0, 0, 0}}, {{1, s, 0}}, {{1, s, 0}}});
    EXPECT_EQ(line.normal(0.5, 0.5), Vec3{});
    // A triangle patch with a collapsed corner row.
    const BezierTriangle cone(
        2, {{{0, 0, 0}}, {{0, 0, 0}}, {{0, 1, 0}}, {{0, 0, 0}}, {{0.5, 0.5, 0}}, {{1, 0, 0}}});
    EXPECT_NEAR(std::fabs(cone.normal(0, 0)[2]), 1.0, 1e-12);
}

TEST(Curvatures, AreThoseOfSphereCylinderAndTorus)
{
    const BSpline half = elliptic_arc({}, {{2, 0, 0}}, {{0, 0, 2}}, -90.0, 180.0);
    const BSplineSurface sphere = surface_of_revolution(half);
    const BSpline circle = elliptic_arc({{3, 0, 0}}, {{1, 0, 0}}, {{0, 0, 1}});
    const BSplineSurface torus = surface_of_revolution(circle);
    for (const double u : {0.1, 0.3, 0.45})
        for (const double v : {0.05, 0.4, 0.9}) {
            EXPECT_NEAR(sphere.curvature(u, v).gaussian, 0.25, 1e-11);
            EXPECT_NEAR(std::fabs(sphere.curvature(u, v).mean), 0.5, 1e-11);
            const Vec3 p = torus.value(u, v);
            const double rho = std::hypot(p[0], p[1]);
            EXPECT_NEAR(std::pow(rho - 3.0, 2) + p[2] * p[2], 1.0, 1e-13);
            // cos x / (rho) for a tube of radius 1.
            EXPECT_NEAR(torus.curvature(u, v).gaussian, (rho - 3.0) / rho, 1e-11);
        }
}

TEST(BSplineSurface, PiecesRefinementAndBulkKeepTheSurface)
{
    std::mt19937_64 random(98);
    for (const bool rational : {false, true}) {
        const KnotVector ku(3, {0, 0, 0, 0, 0.3, 0.3, 0.8, 1, 1, 1, 1});
        const KnotVector kv(2, {-2, -1, 0, 1, 2.5, 3, 4, 5});
        const std::size_t count = 7 * 5;
        const BSplineSurface s(ku, kv, random_points(random, 35),
                               random_weights(random, count, rational));
        std::vector<double> u, v;
        random_domain(random, 100, false, u, v);
        u.push_back(0.3);
        v.push_back(1.0);
        for (double& x : v) x *= 3.0;
        std::vector<Vec3> points(u.size()), normals(u.size());
        s.evaluate(u, v, points, normals);
        const auto refined = s.refined(ku.with(0.5, 2), kv.with(2.0));
        const auto up = s.elevated(true, true);
        for (std::size_t i = 0; i < u.size(); ++i) {
            ASSERT_LE(distance(points[i], s.value(u[i], v[i])), 1e-12);
            ASSERT_LE(distance(refined.value(u[i], v[i]), points[i]), 1e-12);
            ASSERT_LE(distance(up.value(u[i], v[i]), points[i]), 1e-11);
            ASSERT_LE(distance(normals[i], s.normal(u[i], v[i])), 1e-8);
        }
        expect_partials(s, 0.5, 0.5);
        const auto patches = s.bezier_patches();
        ASSERT_EQ(patches.size(), 3u * 3u);
        EXPECT_LE(distance(patches[4].value(0.5, 0.5), s.value(0.55, 1.75)), 1e-13);
    }
}

TEST(Surfaces, RefuseBadArguments)
{
    EXPECT_THROW(TensorPatch(1, 1, std::vector<Vec3>(3)), InvalidInput);
    EXPECT_THROW(TensorPatch(-1, 1, {}), InvalidInput);
    EXPECT_THROW(TensorPatch(100000, 100000, {}), InvalidInput);
    EXPECT_THROW(TensorPatch(0, 0, {{{std::nan(""), 0, 0}}}), InvalidInput);
    EXPECT_THROW(BezierTriangle(2, std::vector<Vec3>(5)), InvalidInput);
    EXPECT_THROW(BezierTriangle(1, std::vector<Vec3>(3), {1, 1, -1}), InvalidInput);
    const TensorPatch s(1, 1, std::vector<Vec3>(4));
    std::vector<Vec3> out(1);
    EXPECT_THROW(s.evaluate(std::vector<double>(2), std::vector<double>(2), out), InvalidInput);
    EXPECT_THROW(s.edge(4), InvalidInput);
    EXPECT_THROW(s.part(0.5, 0.5, 0, 1), InvalidInput);
}

// All bulk loops, run by `work`, with either width.
template <class Work>
void expect_same_bits(const Work& work)
{
    const std::vector<Vec3> wide = work();
    bulk::force_narrow_vectors(true);
    const std::vector<Vec3> narrow = work();
    bulk::force_narrow_vectors(false);
    EXPECT_EQ(wide, narrow);
}

TEST(Bulk, GivesTheSameBitsWithAnyVectorWidth)
{
    std::mt19937_64 random(100);
    std::vector<double> u, v;
    for (const bool rational : {false, true})
        for (const int n : {2, 3, 4, 9}) {
            const TensorPatch patch = random_tensor(random, n, n + 1, rational);
            const TensorPatch square = random_tensor(random, 3, 3, rational);
            const BezierTriangle triangle = random_triangle(random, n, rational);
            const BezierCurve curve = square.edge(0).elevated(n);
            random_domain(random, 101, true, u, v);
            expect_same_bits([&] {
                std::vector<Vec3> p(u.size()), all;
                auto normals = p;
                const auto keep = [&] {
                    all.insert(all.end(), p.begin(), p.end());
                    all.insert(all.end(), normals.begin(), normals.end());
                };
                patch.evaluate(u, v, p, normals);
                keep();
                square.evaluate(u, v, p, normals);
                keep();
                patch.evaluate(u, v, p);
                keep();
                triangle.evaluate(u, v, p, normals);
                keep();
                curve.evaluate(u, p);
                keep();
                return all;
            });
        }
}

}  // namespace
}  // namespace genus
