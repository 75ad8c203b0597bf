#pragma once

#include <span>
#include <utility>
#include <vector>

#include "genus/patch/bspline.h"
#include "genus/patch/tensor_patch.h"

namespace genus {

/// Tensor-product B-spline surface, with weights a NURBS. Control point (i, j) stands at index
/// i n_v + j, n_v being the number of points in v; u goes with i. Parameters are those of the
/// knots.
///
/// Implements [farin2002], chapter 16; [piegl1997], chapters 3, 4 and 8.
class BSplineSurface {
public:
    /// Throws InvalidInput unless the sizes agree, all is finite and weights are positive.
    BSplineSurface(KnotVector knots_u, KnotVector knots_v, std::vector<Vec3> points,
                   std::vector<double> weights = {});

    const KnotVector& knots_u() const { return u_; }
    const KnotVector& knots_v() const { return v_; }
    const std::vector<Vec3>& points() const { return points_; }
    const std::vector<double>& weights() const { return weights_; }
    bool rational() const { return !weights_.empty(); }
    std::vector<Vec4> homogeneous() const;

    Vec3 value(double u, double v) const { return partials(u, v).p; }
    /// At knots the derivatives from above.
    SurfacePoint partials(double u, double v) const;
    /// See TensorPatch::normal.
    Vec3 normal(double u, double v) const;
    Curvatures curvature(double u, double v) const { return curvatures(partials(u, v)); }
    /// Many points, parameters clamped to the domain, and their unit normals. Grouped by piece,
    /// each group by TensorPatch::evaluate. Sizes must agree, else InvalidInput.
    void evaluate(std::span<const double> u, std::span<const double> v,
                  std::span<Vec3> points) const;
    void evaluate(std::span<const double> u, std::span<const double> v, std::span<Vec3> points,
                  std::span<Vec3> normals) const;

    /// The same surface with knot vectors that contain its own, or elevated ones.
    BSplineSurface refined(const KnotVector& knots_u, const KnotVector& knots_v) const;
    BSplineSurface elevated(bool in_u, bool in_v) const;
    /// The parts on both sides of a parameter, each over its share of the domain. Throws
    /// InvalidInput unless it is inside.
    std::pair<BSplineSurface, BSplineSurface> split_u(double u) const;
    std::pair<BSplineSurface, BSplineSurface> split_v(double v) const;

    /// The pieces, those of one u-span after another; `n_spans_v` of them in each.
    std::vector<TensorPatch> bezier_patches() const;
    Box3 bounds() const;

private:
    KnotVector u_, v_;
    std::vector<Vec3> points_;
    std::vector<double> weights_;
};

BSplineSurface transformed(const BSplineSurface& surface, const Transform& map);

/// The profile turned about the z axis from the xz plane, exactly: u runs along the profile, v
/// round the axis. A half circle gives a sphere, a line a cylinder, cone or plane, a circle a
/// torus, a parabola a paraboloid. Throws InvalidInput unless 0 < |sweep| <= 360.
BSplineSurface surface_of_revolution(const BSpline& profile, double sweep = 360.0);

}  // namespace genus
