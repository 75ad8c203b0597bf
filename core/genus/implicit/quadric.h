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
/// Implements [blinn1984] (symmetric form) and the transformation rule Q' = M^-T Q M^-1.
class Quadric final : public Implicit {
public:
    /// Order A B C D E F G H I J as above, that is the upper triangle of Q row by row.
    explicit Quadric(const std::array<double, 10>& upper_triangle);

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

    const std::array<double, 10>& upper_triangle() const { return q_; }
    std::array<double, 10> polynomial() const;
    std::array<std::array<double, 4>, 4> matrix() const;
    bool is_linear() const;

    double value(const Vec3& p) const override;
    Vec3 gradient(const Vec3& p) const override;
    Interval bound(const Box3& box) const override;
    IntervalVec3 gradient_bound(const Box3& box) const override;

    bool operator==(const Quadric& other) const { return q_ == other.q_; }

private:
    std::array<double, 10> q_;
};

/// The quadric of the solid moved by `t`. Throws InvalidInput if `t` is singular or no affine map.
Quadric transformed(const Quadric& quadric, const Transform& t);

enum class QuadricKind {
    Everything, Nothing, HalfSpace, PlanePair, ParallelPlanes, DoublePlane, Line, Point,
    Ellipsoid, EllipticCylinder, HyperbolicCylinder, ParabolicCylinder, Cone,
    EllipticParaboloid, HyperbolicParaboloid, OneSheetHyperboloid, TwoSheetHyperboloid
};

/// Kind by the signs of the eigenvalues of the quadratic part and of Q.
QuadricKind classify(const Quadric& quadric);
std::string to_string(QuadricKind kind);

}  // namespace genus
