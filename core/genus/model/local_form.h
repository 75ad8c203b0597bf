#pragma once

#include <array>
#include <optional>
#include <vector>

#include "genus/base/interval.h"
#include "genus/model/csg_field.h"
#include "genus/model/enclosure.h"

namespace genus {

/// A parallelepiped o + q0 axis[0] + q1 axis[1] + q2 axis[2], |q_k| <= 1. The numbers are taken as
/// exact; `q` are its own coordinates.
struct Frame {
    Vec3 o;
    std::array<Vec3, 3> axis;
};

/// c + g.q + a0 xx + a1 yy + a2 zz + a3 yz + a4 xz + a5 xy with all coefficients enclosed.
struct EnclosedQuadratic {
    Enclosure c;
    std::array<Enclosure, 3> g;
    std::array<Enclosure, 6> a;
};

/// Place of the product of two different coordinates among the six of a quadratic.
constexpr int mixed(int i, int j)
{
    return 6 - i - j;
}

/// A surface of a CsgField in the coordinates of a frame: F = s, or s^2 - t for a torus, up to a
/// positive factor.
struct FramedSurface {
    FramedSurface(const Surface& surface, const Frame& frame);

    bool quartic;
    EnclosedQuadratic s, t;
};

/// F along a line parallel to an axis: the polynomial low + u (2 l + u) in the coordinate t.
struct AxisLine {
    std::array<double, 3> low{}, u{};  // coefficients, the constant first
    std::array<double, 2> l{};

    double value(double t) const
    {
        const double U = u[0] + t * (u[1] + t * u[2]), L = l[0] + t * l[1];
        return low[0] + t * (low[1] + t * low[2]) + U * (2.0 * L + U);
    }
    double slope(double t) const
    {
        const double U = u[0] + t * (u[1] + t * u[2]), dU = u[1] + 2.0 * t * u[2];
        const double L = l[0] + t * l[1];
        return low[1] + 2.0 * (t * low[2] + U * l[1] + (L + U) * dU);
    }
};

/// A FramedSurface in the coordinates e of a cell, q = center + half e with |e_k| <= 1: doubles,
/// and how far they may be from the truth. A torus is a quadratic and what is beyond it,
/// 2 (sigma.e) u + u^2, about the middle of the cell, for s^2 and t are large and nearly equal on
/// it.
class LocalForm {
public:
    LocalForm(const FramedSurface& surface, const Vec3& center, double half);
    /// Coordinate k of the result is coordinate order[k] of this one.
    LocalForm permuted(const std::array<int, 3>& order) const;

    bool is_quartic() const { return quartic_; }
    bool is_linear() const;
    double value(const Vec3& e) const;
    Vec3 gradient(const Vec3& e) const;
    /// F along the line through e parallel to an axis; its value is as near to the truth as
    /// value() is.
    AxisLine along(int axis, const Vec3& e) const;
    /// Holds F over the cell, and a component of its gradient over a box.
    Interval range() const;
    Interval slope_range(int axis, const Box3& box) const;
    /// |true - computed| at points with |e_k| <= reach, rounding included: of the value, of each
    /// component of the gradient.
    double slack(double reach) const;
    double gradient_slack(double reach) const;
    /// At most so much does a component of the gradient change for a step of length 1 along an
    /// axis, where |e_k| <= reach.
    double bend(double reach) const;

    /// What F does about a point P: F(P + d) is value + gradient.d + (a quadratic `a` in d) + what
    /// only a quartic has, 2 (sigma.d) u + u^2 with u the quadratic `u`.
    struct Expansion {
        double value;
        Vec3 gradient;
        std::array<double, 6> a;
        Vec3 sigma;
        std::array<double, 6> u;
    };
    Expansion about(const Vec3& p) const;

private:
    struct Part {
        double c = 0.0;
        Vec3 g;
        std::array<double, 6> a{};
        double ec = 0.0, eg = 0.0, ea = 0.0;  // each coefficient is that near

        double linear(const Vec3& e) const;
        double quadratic(const Vec3& e) const;
        Vec3 slope_of_quadratic(const Vec3& e) const;
        // Constant and slope along an axis, of the terms up to the first and of the second order.
        std::array<double, 2> linear_along(int axis, const Vec3& e) const;
        std::array<double, 3> quadratic_along(int axis, const Vec3& e) const;
        Interval range(const Box3& box) const;
        Interval slope_range(int axis, const Box3& box) const;
        // The most of the linear and of the quadratic terms, and of a component of the gradient.
        double reach_of_linear(double reach) const;
        double reach_of_quadratic(double reach) const;
        double reach_of_slope(double reach) const;
        double slack(double reach) const;
        double gradient_slack(double reach) const;
        double bend() const;
    };
    LocalForm() = default;
    static EnclosedQuadratic local(const EnclosedQuadratic& q, const Vec3& center, double half);
    static Part rounded(const EnclosedQuadratic& q);

    bool quartic_ = false;
    Part part_;  // up to the second order
    Part rest_;  // sigma and u
};

/// A surface as the graph z = z0 + a x + b y + (at most r) over the polydisc |x| <= R, |y| <= R of
/// complex numbers: one analytic function there, real for real x and y.
struct Graph {
    double z0 = 0.0, a = 0.0, b = 0.0, r = 0.0;
    double rise_x = 0.0, rise_y = 0.0;  // |dz/dx - a| and |dz/dy - b| are at most these
    double slope = 0.0;                 // of F along z at (0, 0, z0), with its sign
    double least_slope = 0.0;           // its absolute value on the graph is at least this
};

/// The zero of F on the axis of the cell, by Newton's method from its middle; nothing if that does
/// not converge near the cell.
std::optional<double> zero_on_axis(const LocalForm& form);

/// Shows by a contraction that the graph through (0, 0, z0) exists over the polydisc. Nothing if
/// that cannot be shown.
///
/// Implements [krawczyk1969] in discs about real centres: F = 0 is written as a fixed point with
/// the slope at (0, 0, z0), about the tangent plane there.
std::optional<Graph> graph_over(const LocalForm& form, double z0, double R);

/// How much the components of the gradient vary over that graph, at most.
Vec3 gradient_variation(const LocalForm& form, const Graph& graph, double R);

}  // namespace genus
