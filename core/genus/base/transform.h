#pragma once

#include <array>

#include "genus/base/box.h"
#include "genus/base/vec.h"

namespace genus {

/// A 4x4 matrix on extended coordinates (x, y, z, w): points have w = 1, vectors w = 0.
/// `m[row][column]`; matrices act on columns, so `a * b` does b first.
///
/// Implements [shirley2009], chapters 6 and 7 (scale, shear, rotation, projection).
struct Transform {
    std::array<std::array<double, 4>, 4> m{
        {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};

    bool operator==(const Transform&) const = default;

    /// True if the last row is (0, 0, 0, 1): no projection.
    bool is_affine() const;
    bool is_identity() const { return *this == Transform{}; }
};

Transform operator*(const Transform& a, const Transform& b);

Transform translation(const Vec3& by);
/// Throws InvalidInput if a factor is not finite. A zero factor is legal here, but not invertible.
Transform scaling(const Vec3& factors);
/// x grows by `xy` y + `xz` z, and so on. Order: xy, xz, yx, yz, zx, zy.
Transform shear(const std::array<double, 6>& factors);
/// Rotations by degrees, counterclockwise seen from the tip of the axis. Multiples of 90 are exact.
Transform rotation_x(double degrees);
Transform rotation_y(double degrees);
Transform rotation_z(double degrees);
/// First about x, then y, then z.
Transform rotation(const Vec3& degrees);
/// About any axis through the origin (Rodrigues). Throws InvalidInput if the axis is zero.
Transform rotation(double degrees, const Vec3& axis);
/// At the plane through the origin with this normal. Throws InvalidInput if it is zero.
Transform mirror(const Vec3& normal);
/// Rigid map into camera coordinates: `eye` at the origin, looking along -z, `up` towards +y.
/// Throws InvalidInput if the view direction is zero or parallel to `up`.
Transform look_at(const Vec3& eye, const Vec3& target, const Vec3& up);
/// Perspective projection to the cube [-1, 1]^3; field of view in degrees, top to bottom.
Transform perspective(double field_of_view, double aspect, double near_plane, double far_plane);
/// Parallel projection of `box` (camera coordinates) to the cube [-1, 1]^3.
Transform orthographic(const Box3& box);

/// Determinant of the linear part, the factor by which volumes grow.
double determinant(const Transform& t);
/// No vector grows by a larger factor than this; exact for rotations and scalings along the axes,
/// never more than the root of 3 above the truth.
double largest_stretch(const Transform& t);
/// Throws InvalidInput if `t` is singular: its scaled condition exceeds 1e14.
Transform inverse(const Transform& t);

/// Image of a point; divides by w where `t` is a projection.
Vec3 apply(const Transform& t, const Vec3& point);
/// Image of a vector: translations do not move it.
Vec3 apply_vector(const Transform& t, const Vec3& vector);
/// Image of a surface normal, not normalised: the inverse transposed, up to a positive factor.
Vec3 apply_normal(const Transform& t, const Vec3& normal);
/// Box round the image of a box under an affine map. Infinite sides stay infinite.
Box3 apply(const Transform& t, const Box3& box);

/// Sine and cosine of an angle in degrees, exact at multiples of 30 and 90 as far as doubles go,
/// the same bits on every machine. Used wherever an angle decides about topology.
double sin_degrees(double degrees);
double cos_degrees(double degrees);

}  // namespace genus
