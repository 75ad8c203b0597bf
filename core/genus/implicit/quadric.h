#pragma once

#include <array>
#include <string>

#include "genus/base/transform.h"
#include "genus/implicit/implicit.h"

namespace genus {

/// F(p) = p^T Q p with p = (x, y, z, 1) and Q symmetric; inside F <= 0. The ten coefficients stand
/// for A x^2 + 2B xy + 2C xz + 2D x + E y^2 + 2F yz + 2G y + H z^2 + 2I z + J, so that
/// Q = [A B C D; B E F G; C F H I; D G I J].
///
/// The coefficients are kept about an origin of their own: F(p) = f(p - origin). A ball of radius
/// 1 at 10^8 keeps its shape to the last bit, which its coefficients about (0, 0, 0) cannot say.
/// Everything public speaks of space as the caller sees it, except `local` and `origin`.
///
/// Nothing is normalised: scaling all coefficients scales F. Value, gradient and bounds cost some
/// tens of operations and allocate nothing.
///
/// Implements [blinn1984] (symmetric form) and the transformation rule Q' = M^-T Q M^-1.
class Quadric final : public Implicit {
public:
    /// Order A B C D E F G H I J as above, that is the upper triangle of Q row by row. Throws
    /// InvalidInput if a number is not finite.
    explicit Quadric(const std::array<double, 10>& upper_triangle, const Vec3& origin = {});

    /// From the polynomial a x^2 + b y^2 + c z^2 + d xy + e xz + f yz + g x + h y + i z + j.
    static Quadric from_polynomial(const std::array<double, 10>& coefficients);
    /// Throws InvalidInput if `q` is not symmetric to 1e-12 of its largest entry.
    static Quadric from_matrix(const std::array<std::array<double, 4>, 4>& q);

    static Quadric sphere(double r);
    static Quadric ellipsoid(const Vec3& radii);
    /// Infinite, about the z axis.
    static Quadric cylinder(double r);
    /// Infinite double cone about the z axis: radius `r0` at z = 0, growing by `slope` with z.
    static Quadric cone(double r0, double slope);
    /// normal . p <= offset; the normal keeps its length.
    static Quadric half_space(const Vec3& normal, double offset);

    /// The ten coefficients about (0, 0, 0), rounded where the origin is elsewhere.
    std::array<double, 10> upper_triangle() const;
    std::array<double, 10> polynomial() const;
    std::array<std::array<double, 4>, 4> matrix() const;
    bool is_linear() const { return form_ == Form::Linear; }

    /// The coefficients as they are kept, about `origin()`. Linear ones have the origin (0, 0, 0).
    const std::array<double, 10>& local() const { return q_; }
    const Vec3& origin() const { return origin_; }
    /// The same function with its coefficients about another origin.
    Quadric about(const Vec3& origin) const;
    /// F times `factor`.
    Quadric scaled(double factor) const;

    double value(const Vec3& p) const override
    {
        const double x = p[0] - origin_[0], y = p[1] - origin_[1], z = p[2] - origin_[2];
        if (form_ == Form::Linear) return 2.0 * (q_[3] * x + q_[6] * y + q_[8] * z) + q_[9];
        return x * (q_[0] * x + 2.0 * (q_[1] * y + q_[2] * z + q_[3])) +
               y * (q_[4] * y + 2.0 * (q_[5] * z + q_[6])) + z * (q_[7] * z + 2.0 * q_[8]) + q_[9];
    }
    Vec3 gradient(const Vec3& p) const override
    {
        const double x = p[0] - origin_[0], y = p[1] - origin_[1], z = p[2] - origin_[2];
        return {{2.0 * (q_[0] * x + q_[1] * y + q_[2] * z + q_[3]),
                 2.0 * (q_[1] * x + q_[4] * y + q_[5] * z + q_[6]),
                 2.0 * (q_[2] * x + q_[5] * y + q_[7] * z + q_[8])}};
    }
    /// On a bounded box: exact up to rounding where F has no mixed terms or is monotone on the box
    /// in two of the variables it mixes; else too wide by at most the mixed terms' range.
    Interval bound(const Box3& box) const override;
    IntervalVec3 gradient_bound(const Box3& box) const override;

    /// The matrix of second derivatives, the same everywhere.
    std::array<Vec3, 3> hessian() const;

    /// Same numbers, hence the same function.
    bool operator==(const Quadric& other) const
    {
        return q_ == other.q_ && origin_ == other.origin_;
    }

private:
    enum class Form { Linear, Separable, General };

    std::array<double, 10> q_;
    Vec3 origin_;
    Form form_ = Form::General;
};

/// The quadric of the solid moved by `t`: F'(t p) = F(p). Linear ones stay exactly linear.
/// Coefficients are formed in twice the precision of a double; mixed terms below 4 units in the
/// last place of their squares, that is what rounding of a rotation leaves behind, are dropped.
/// Throws InvalidInput if `t` is singular or no affine map, or if a coefficient overflows.
Quadric transformed(const Quadric& quadric, const Transform& t);

/// No principal curvature of the level sets of F inside `box` exceeds this (1 / model unit):
/// greatest |second derivative| / least |gradient|. Infinite where the gradient may vanish.
double curvature_bound(const Quadric& quadric, const Box3& box);

enum class QuadricKind {
    Everything,
    Nothing,
    HalfSpace,
    PlanePair,
    ParallelPlanes,
    DoublePlane,
    Line,
    Point,
    Ellipsoid,
    EllipticCylinder,
    HyperbolicCylinder,
    ParabolicCylinder,
    Cone,
    EllipticParaboloid,
    HyperbolicParaboloid,
    OneSheetHyperboloid,
    TwoSheetHyperboloid
};

/// Kind by the signs of the eigenvalues of the quadratic part and of Q, brought to its centre.
/// An eigenvalue below 1e-13 of the largest counts as zero. The kind is that of the surface F = 0;
/// "Everything" and "Nothing" tell the sign of F where there is no surface.
///
/// Implements [blinn1984] (classification by rank and signature).
QuadricKind classify(const Quadric& quadric);
std::string to_string(QuadricKind kind);

}  // namespace genus
