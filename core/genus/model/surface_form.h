#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/interval.h"
#include "genus/base/vec.h"
#include "genus/model/csg_field.h"
#include "genus/model/sign_formula.h"

namespace genus {

/// A surface of a CsgField as polynomials, made for bounds over triangles and tetrahedra: a
/// quadratic has six Bernstein coefficients over a triangle and ten over a tetrahedron, the quartic
/// of a torus is a product of quadratics. The coefficients enclose the range, sharply for planes
/// and for small simplices. Any other function is, over the box round a simplex, within bounds of a
/// quadratic, or of one for each of its smooth pieces there; where it has no second derivatives, of
/// its value at the middle plus its gradient over the box times the way.
///
/// Bounds hold for points of the box given to the constructor: `slack` covers all rounding there.
///
/// Implements [farin2002], chapter 17 (Bernstein form over triangles; the convex hull property).
class SurfaceForm {
public:
    SurfaceForm(const Surface& surface, const Box3& box);

    bool is_plane() const { return kind_ == Surface::Kind::Plane; }
    /// Whether F is a polynomial of degree two at most.
    bool is_quadratic() const
    {
        return kind_ == Surface::Kind::Plane || kind_ == Surface::Kind::Quadric;
    }
    /// What is quadratic in a quadratic F along a step: F(p + e) = F(p) + gradient(p).e + bend(e).
    double bend(const Vec3& e) const
    {
        const double x = e[0], y = e[1], z = e[2];
        return x * (q_[4] * x + q_[7] * y + q_[8] * z) + y * (q_[5] * y + q_[9] * z) +
               q_[6] * z * z;
    }
    double value(const Vec3& p) const;
    Vec3 gradient(const Vec3& p) const;
    /// A point of a plane across an axis, with that coordinate as the plane has it: Newton's method
    /// leaves it a rounding away. Of any other surface, the point itself.
    Vec3 straightened(Vec3 p) const
    {
        if (across_ >= 0) p[across_] = place_;
        return p;
    }
    /// Distance of a point from the surface, to first order.
    double distance(const Vec3& p) const { return std::fabs(value(p)) / norm(gradient(p)); }
    /// Holds F over the convex hull of three or four points.
    Interval range(const std::array<Vec3, 3>& triangle) const;
    /// The same where the values at the corners are known.
    Interval range(const std::array<Vec3, 3>& triangle, const std::array<double, 3>& values) const;
    Interval range(const std::array<Vec3, 4>& tet) const;
    /// Holds the difference between F and the linear function with its values at the corners; of a
    /// quadratic it is exact, but for rounding far below that of `range`.
    Interval deviation(const std::array<Vec3, 3>& triangle) const;
    /// The range over a triangle of a function that has these values at its corners and deviates
    /// from linear as `times` F does: of a quadratic exact, but for rounding.
    Interval range_from(const std::array<double, 3>& values, const std::array<Vec3, 3>& triangle,
                        double times = 1.0) const;
    /// Holds F over the convex hull of any points.
    Interval range(std::span<const Vec3> hull) const;
    /// A lower bound, rounding covered, of the rate at which F grows along `direction` at points
    /// of the convex hull, times `sign`.
    double least_slope(std::span<const Vec3> hull, const Vec3& direction, double sign) const;
    /// The t nearest to 0 with F(p + t direction) = 0 to rounding, if there is one.
    std::optional<double> root_along(const Vec3& p, const Vec3& direction) const;
    /// Holds F and its gradient over a box.
    Interval range(const Box3& box) const;
    IntervalVec3 gradient_range(const Box3& box) const;
    /// Largest difference between F and its linear interpolant over the tetrahedron, as a bound.
    double linear_error(const std::array<Vec3, 4>& tet) const;
    /// Rounding error of `value`, at most, in the box; of a function a guess, not to be used in
    /// proofs.
    double slack() const { return slack_; }
    /// The sign of F at p, 0 where rounding leaves it open.
    Sign sign(const Vec3& p) const;

private:
    // c0 + c1 x + c2 y + c3 z + c4 xx + c5 yy + c6 zz + c7 xy + c8 xz + c9 yz about origin_.
    using Quadratic = std::array<double, 10>;

    /// The range of a function over the hull of points, `range_of(q, at, slack)` being that of a
    /// quadratic about a point.
    template <class RangeOf>
    Interval function_range(std::span<const Vec3> hull, const RangeOf& range_of) const;
    Interval mean_range(std::span<const Vec3> hull, const Box3& box) const;
    void note_axis(const std::array<double, 10>& polynomial);

    Surface::Kind kind_;
    std::shared_ptr<const Function> function_;
    Vec3 origin_;
    Quadratic q_{};        // plane or quadric
    Quadratic s_{}, t_{};  // torus: F = scale_ (s^2 - t)
    double scale_ = 1.0;
    double slack_ = 0.0;
    int across_ = -1;  // the axis that a plane is perpendicular to, and where
    double place_ = 0.0;
    double gradient_slack_ = 0.0;  // rounding error of each component of the gradient, at most
};

/// The most of the sum of k_ij b_i b_j over pairs i < j, b barycentric in a triangle with a
/// quadratic form k_ij on its edges. Where the form is the square of a length, that is the square
/// of half the longest edge or, if all angles are acute, of the radius of the circle through the
/// corners; any other form has its most on an edge.
double most_between(const std::array<double, 3>& k);

/// The shortest d with normal_i . d >= demand_i for all i, or nothing if there is none (or none
/// shorter than 1000). Up to a few dozen constraints; enumerates the up to three that bind.
std::optional<Vec3> shortest_direction(std::span<const Vec3> normals,
                                       std::span<const double> demands);

/// Newton steps of least norm towards F_i = 0 for up to three surfaces at once. Returns the point
/// when all |F_i| are at rounding level, nothing if that is not reached within `reach` of `start`.
std::optional<Vec3> project(std::span<const SurfaceForm* const> surfaces, const Vec3& start,
                            double reach);

}  // namespace genus
