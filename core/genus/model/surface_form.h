#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/interval.h"
#include "genus/base/vec.h"
#include "genus/model/csg_field.h"
#include "genus/model/quadratic_polynomial.h"
#include "genus/model/sign_formula.h"
#include "genus/model/two_lanes.h"

namespace genus {

/// The most of the sum of k_ij b_i b_j over pairs i < j, b barycentric in a triangle with a
/// quadratic form k_ij on its edges. Where the form is the square of a length, that is the square
/// of half the longest edge or, if all angles are acute, of the radius of the circle through the
/// corners; any other form has its most on an edge.
inline double most_between(const std::array<double, 3>& k)
{
    const double largest = std::max({0.0, k[0], k[1], k[2]}), on_edge = 0.25 * largest;
    const double sum = k[0] + k[1] + k[2];
    if (!(std::min({k[0], k[1], k[2]}) > 0.0 && 2.0 * largest < sum)) return on_edge;
    const double products = k[0] * k[1] + k[1] * k[2] + k[2] * k[0];
    const double inside = k[0] * k[1] * k[2] / (4.0 * products - sum * sum);
    // A third bounds it in any case, so thin triangles lose nothing by rounding.
    return std::max(on_edge, std::min(largest / 3.0, inside));
}

/// The same for two triangles.
inline Two most_between(const std::array<Two, 3>& k)
{
    const Two largest = greater(both(0.0), greater(k[0], greater(k[1], k[2])));
    const Two smallest = lesser(k[0], lesser(k[1], k[2])), sum = k[0] + k[1] + k[2];
    const Two products = k[0] * k[1] + k[1] * k[2] + k[2] * k[0];
    const Two inside = k[0] * k[1] * k[2] / (4.0 * products - sum * sum);
    const Two on_edge = 0.25 * largest, at_most = 1.0 / 3.0 * largest;
    const Two within = greater(on_edge, lesser(at_most, inside));
    return (smallest > 0.0) & (2.0 * largest < sum) ? within : on_edge;
}

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
    /// Whether its normals may turn to both sides at once.
    bool may_be_saddle() const { return may_be_saddle_; }
    /// What is quadratic in a quadratic F along a step: F(p + e) = F(p) + gradient(p).e + bend(e).
    double bend(const Vec3& e) const { return genus::bend(q_, e); }
    Two bend(const TwoVec& e) const { return genus::bend(q_, e); }
    /// The bends of the edges of a triangle. Those of other functions than quadratics are estimated
    /// from the values at their ends and middles, with a reserve.
    std::array<double, 3> bends(const std::array<Vec3, 3>& triangle) const
    {
        if (!is_quadratic()) return other_bends(triangle);
        return {bend(triangle[1] - triangle[0]), bend(triangle[2] - triangle[1]),
                bend(triangle[0] - triangle[2])};
    }
    /// By how much a quadratic with these bends may be below and above the linear function with its
    /// values at the corners: exact, but for rounding.
    static Interval deviation_of(const std::array<double, 3>& bends)
    {
        const bool all_one_way = std::min({bends[0], bends[1], bends[2]}) >= 0.0;
        return {-most_between(bends),
                all_one_way ? 0.0 : most_between({-bends[0], -bends[1], -bends[2]})};
    }
    /// How far a chord with its ends on the surface is from it, about: in its middle. Where the
    /// surface is a saddle, chords are as far from it as they would be if it curved all one way, by
    /// the absolute values of its curvatures: a face with such sides is no farther.
    double sagitta(const Vec3& p, const Vec3& q) const
    {
        if (is_plane()) return 0.0;
        return may_be_saddle_   ? sagitta_on_saddle(p, q)
               : is_quadratic() ? 0.25 * std::fabs(bend(q - p)) / norm(gradient(0.5 * (p + q)))
                                : distance(0.5 * (p + q));
    }
    double value(const Vec3& p) const
    {
        return is_quadratic() ? evaluate(q_, p - origin_) : other_value(p);
    }
    Vec3 gradient(const Vec3& p) const
    {
        return is_quadratic() ? slope(q_, p - origin_) : other_gradient(p);
    }
    /// Of a quadratic F at two points.
    Two value(const TwoVec& p) const { return evaluate(q_, p - origin_); }
    TwoVec gradient(const TwoVec& p) const { return slope(q_, p - origin_); }
    /// The bend of a quadratic F along a step of length 1 is no larger, whatever its sign.
    double most_bend() const
    {
        return std::sqrt(q_[4] * q_[4] + q_[5] * q_[5] + q_[6] * q_[6] +
                         0.5 * (q_[7] * q_[7] + q_[8] * q_[8] + q_[9] * q_[9]));
    }
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
    /// Holds F over the convex hull of any points.
    Interval range(std::span<const Vec3> hull) const;
    /// A lower bound, rounding covered, of the rate at which F grows along `direction` at points
    /// of the convex hull, times `sign`.
    double least_slope(std::span<const Vec3> hull, const Vec3& direction, double sign) const;
    /// True if `sign` F is shown to grow on all straight ways from points c + x with |x_i| <=
    /// half_i to c + up, and to fall on those to c - up, all of them within `hull`. Sharp for
    /// quadratics.
    bool grows_towards(const Vec3& c, const Vec3& half, const Vec3& up, const Box3& hull,
                       double sign) const;
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
    /// Rounding error of each component of `gradient` of a quadratic F, at most, in the box.
    double gradient_slack() const { return gradient_slack_; }
    /// The sign of F at p, 0 where rounding leaves it open.
    Sign sign(const Vec3& p) const;

private:
    using Quadratic = QuadraticPolynomial;  // about origin_

    double sagitta_on_saddle(const Vec3& p, const Vec3& q) const;
    Vec3 second_along(const Vec3& p, const Vec3& step) const;
    double other_value(const Vec3& p) const;
    std::array<double, 3> other_bends(const std::array<Vec3, 3>& triangle) const;
    Vec3 other_gradient(const Vec3& p) const;
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
    Vec3 reach_;  // of the box from the origin, along each axis
    bool may_be_saddle_ = false;
    int across_ = -1;  // the axis that a plane is perpendicular to, and where
    double place_ = 0.0;
    double gradient_slack_ = 0.0;  // rounding error of each component of the gradient, at most
};

/// The shortest d with normal_i . d >= demand_i for all i, or nothing if there is none (or none
/// shorter than 1000). Up to a few dozen constraints; enumerates the up to three that bind.
std::optional<Vec3> shortest_direction(std::span<const Vec3> normals,
                                       std::span<const double> demands);

/// Newton steps of least norm towards F_i = 0 for up to three surfaces at once. Returns the point
/// when all |F_i| are at rounding level, nothing if that is not reached within `reach` of `start`.
std::optional<Vec3> project(std::span<const SurfaceForm* const> surfaces, const Vec3& start,
                            double reach);

}  // namespace genus
