#pragma once

#include "genus/implicit/quadric.h"

namespace genus {

/// A quadric in its own coordinates: p = center + X axes[0] + Y axes[1] + Z axes[2] brings the
/// surface to its standard equation, for instance X^2 + Y^2 + Z^2 = 1 (see `point`). The axes are
/// conjugate diameters, not always at right angles: that keeps their accuracy at aspect ratios of
/// 10^12. Made once per surface, some hundreds of operations.
///
/// Implements [blinn1984] (classification and parametric forms).
class QuadricForm {
public:
    explicit QuadricForm(const Quadric& quadric);

    QuadricKind kind() const { return kind_; }
    const Vec3& center() const { return center_; }
    const std::array<Vec3, 3>& axes() const { return axes_; }
    /// Pieces that `point` tells apart: 2 for a hyperboloid of two sheets, a hyperbolic cylinder
    /// and pairs of planes, 0 where there is no surface, else 1.
    int n_sheets() const;

    /// The point of the surface at the parameters (u, v):
    ///   ellipsoid                 u longitude, v latitude, radians
    ///   elliptic cylinder         u angle, v along the axis
    ///   cone                      u angle, v height, the apex at 0
    ///   hyperboloid of one sheet  u angle, v = arsinh of the height
    ///   hyperboloid of two sheets u angle, v = arcosh of the height on either sheet
    ///   elliptic paraboloid       u angle, v radius
    ///   hyperbolic paraboloid     u, v plane coordinates
    ///   parabolic cylinder        u along the rulings, v across
    ///   hyperbolic cylinder       u along the rulings, v = arsinh across
    ///   planes                    u, v plane coordinates
    ///   line                      v along it; point: neither counts
    /// Throws InvalidInput unless 0 <= sheet < n_sheets().
    Vec3 point(double u, double v, int sheet = 0) const;
    /// Unit normal there, pointing to where F > 0; zero where the gradient vanishes (an apex).
    Vec3 normal(double u, double v, int sheet = 0) const;

private:
    Quadric quadric_;
    QuadricKind kind_;
    Vec3 center_;
    std::array<Vec3, 3> axes_;
};

}  // namespace genus
