#pragma once

#include <array>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/transform.h"
#include "genus/patch/bezier_curve.h"
#include "genus/patch/surface.h"

namespace genus {

/// Triangular Bezier patch of degree n over u, v >= 0, u + v <= 1, with w = 1 - u - v; with weights
/// a rational one. Control point (i, j) goes with u^i v^j w^(n - i - j) and stands at index
/// i (n + 1) - i (i - 1) / 2 + j: rows of equal i. The front is where pu x pv points.
///
///     (0,n)                  edges run counterclockwise: 0 is v = 0 (u from 0 to 1),
///      |   \.                1 is w = 0 (v from 0 to 1), 2 is u = 0 (v from 1 to 0)
///      e2   e1
///      |      \.
///    (0,0)-e0-(n,0)
///
/// Implements [farin2002], chapters 17 and 18.
class BezierTriangle {
public:
    /// Throws InvalidInput unless 0 <= n <= kMaxDegree, there are (n + 1) (n + 2) / 2 finite
    /// points, and no weights or as many, all positive.
    BezierTriangle(int n, std::vector<Vec3> points, std::vector<double> weights = {});
    static BezierTriangle from_homogeneous(int n, std::span<const Vec4> points);

    int degree() const { return n_; }
    bool rational() const { return !weights_.empty(); }
    const std::vector<Vec3>& points() const { return points_; }
    const std::vector<double>& weights() const { return weights_; }
    static std::size_t index(int n, int i, int j)
    {
        return static_cast<std::size_t>(i * (n + 1) - i * (i - 1) / 2 + j);
    }
    const Vec3& point(int i, int j) const { return points_[index(n_, i, j)]; }
    std::vector<Vec4> homogeneous() const;
    bool operator==(const BezierTriangle&) const = default;

    /// By de Casteljau. O(n^3).
    Vec3 value(double u, double v) const;
    /// With a bound on the rounding error of each coordinate. O(n^2).
    Bounded<3> value_with_bound(double u, double v) const;
    /// Partials by u and v, w being 1 - u - v.
    SurfacePoint partials(double u, double v) const;
    /// Unit normal; at degenerate places the limit along the line to the middle, see TensorPatch.
    Vec3 normal(double u, double v) const;
    Curvatures curvature(double u, double v) const { return curvatures(partials(u, v)); }

    /// Many points inside the triangle, vectorised, and their unit normals. Sizes must agree, else
    /// InvalidInput.
    void evaluate(std::span<const double> u, std::span<const double> v,
                  std::span<Vec3> points) const;
    void evaluate(std::span<const double> u, std::span<const double> v, std::span<Vec3> points,
                  std::span<Vec3> normals) const;

    BezierCurve edge(int k) const;
    static Vec2 on_edge(int k, double s);
    /// The part with corners a (where u = v = 0), b (u = 1) and c (v = 1), given as (u, v), by
    /// blossoms. O(n^5) in all, small for the degrees in use.
    BezierTriangle part(const Vec2& a, const Vec2& b, const Vec2& c) const;
    /// Four halves of the size, the middle one last.
    std::array<BezierTriangle, 4> quartered() const;
    BezierTriangle elevated(int by = 1) const;

    Box3 bounds() const;

private:
    Vec3 limit(double u, double v) const;

    int n_;
    std::vector<Vec3> points_;
    std::vector<double> weights_;
};

BezierTriangle transformed(const BezierTriangle& patch, const Transform& map);

/// The quadrilaterals of control points across a common edge are planar and affine images of one
/// another exactly when two polynomial triangles join C1 with respect to the map that takes the
/// domain of one to that of the other. Returns, for triangles that share edge `ea` of `a` with
/// edge `eb` of `b` (run backwards), the largest distance of b's second row from where a's
/// continuation puts it; `across` is b's third corner in a's (u, v).
double c1_defect(const BezierTriangle& a, int ea, const BezierTriangle& b, int eb,
                 const Vec2& across);

}  // namespace genus
