#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/transform.h"
#include "genus/patch/bezier_curve.h"
#include "genus/patch/surface.h"

namespace genus {

/// Bezier patch of degree (m, n) over [0, 1]^2, with weights a rational one. Control point (i, j)
/// stands at index i (n + 1) + j; u goes with i, v with j. The front is where pu x pv points.
///
///   (0,n)---e2---(m,n)      edges run counterclockwise: 0 is v = 0, 1 is u = 1, 2 is v = 1
///     |            |        (backwards in u), 3 is u = 0 (backwards in v)
///    e3            e1
///     |            |
///   (0,0)---e0---(m,0)
///
/// Implements [farin2002], chapters 14 and 15, and 16 for rational ones.
class TensorPatch {
public:
    /// Throws InvalidInput unless 0 <= m, n <= kMaxDegree, there are (m + 1) (n + 1) finite points,
    /// and no weights or as many, all positive.
    TensorPatch(int m, int n, std::vector<Vec3> points, std::vector<double> weights = {});
    static TensorPatch from_homogeneous(int m, int n, std::span<const Vec4> points);

    int degree_u() const { return m_; }
    int degree_v() const { return n_; }
    bool rational() const { return !weights_.empty(); }
    const std::vector<Vec3>& points() const { return points_; }
    const std::vector<double>& weights() const { return weights_; }
    const Vec3& point(int i, int j) const { return points_[index(i, j)]; }
    std::vector<Vec4> homogeneous() const;
    bool operator==(const TensorPatch&) const = default;

    /// By de Casteljau in both directions. O(m n (m + n)).
    Vec3 value(double u, double v) const;
    /// With a bound on the rounding error of each coordinate. O(m n).
    Bounded<3> value_with_bound(double u, double v) const;
    SurfacePoint partials(double u, double v) const;
    /// Unit normal. Where the partials vanish or are parallel (collapsed edges and corners), the
    /// limit along the line to the middle of the patch; zero if there is none.
    Vec3 normal(double u, double v) const;
    Curvatures curvature(double u, double v) const { return curvatures(partials(u, v)); }

    /// Many points with parameters in [0, 1], vectorised, and their unit normals. Sizes must
    /// agree, else InvalidInput.
    void evaluate(std::span<const double> u, std::span<const double> v,
                  std::span<Vec3> points) const;
    void evaluate(std::span<const double> u, std::span<const double> v, std::span<Vec3> points,
                  std::span<Vec3> normals) const;

    /// Edge 0 to 3 as drawn above.
    BezierCurve edge(int k) const;
    /// Where edge k is at its parameter s.
    static Vec2 on_edge(int k, double s);
    /// The curves of constant v and of constant u.
    BezierCurve curve_u(double v) const;
    BezierCurve curve_v(double u) const;

    std::pair<TensorPatch, TensorPatch> split_u(double u) const;
    std::pair<TensorPatch, TensorPatch> split_v(double v) const;
    /// The part [u0, u1] x [v0, v1].
    TensorPatch part(double u0, double u1, double v0, double v1) const;
    TensorPatch elevated(int by_u, int by_v) const;
    /// u and v exchanged: the same surface seen from behind.
    TensorPatch transposed() const;

    Box3 bounds() const;

private:
    std::size_t index(int i, int j) const
    {
        return static_cast<std::size_t>(i) * (static_cast<std::size_t>(n_) + 1) +
               static_cast<std::size_t>(j);
    }
    Vec3 limit(double u, double v) const;

    int m_, n_;
    std::vector<Vec3> points_;
    std::vector<double> weights_;
};

/// Image under an affine map. Throws InvalidInput for a projection.
TensorPatch transformed(const TensorPatch& patch, const Transform& map);

/// Rows of control points 0 to `order` (constant u-index) of a patch that continues a polynomial
/// one beyond u = 1 with C^order continuity; see `continuation` of curves.
std::vector<std::vector<Vec3>> continuation(const TensorPatch& a, int order, double ratio = 1.0);

}  // namespace genus
