#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "genus/base/vec.h"
#include "genus/base/wide_int.h"

namespace genus::exact {

/// Exact geometry on an integer grid.
///
/// Grid points are vectors of doubles with integer values of magnitude up to kGridLimit.
/// Floating filters settle most signs; what they leave open is decided in fixed-width integers.
/// Points made by intersection are kept as homogeneous integer coordinates, which grow to 378 bits
/// for three planes: the widths in this file are derived from kGridLimit.
///
/// Implements the implicit points of [attene2020], with integers in place of expansions.

inline constexpr double kGridLimit = 4503599627370496.0;  // 2^52

/// n . x = d. Components of n stay below 2^107, d below 2^161.
struct Plane {
    std::array<WideInt<2>, 3> n;
    WideInt<3> d;
};

/// An intersection point x / w, with w > 0 and, per coordinate, floor(1024 x / w). Equal points
/// have equal `fixed`, and `fixed` is monotone in the coordinate.
struct ExactPoint {
    std::array<WideInt<6>, 3> x;
    WideInt<6> w;
    std::array<std::int64_t, 3> fixed;
    bool on_grid;  // all three coordinates are whole numbers

    Vec3 approximate() const;
};

/// A point of either sort, as predicates see it. `approx` is the point itself where `exact` is
/// null, and within 0.26 of it otherwise.
struct PointRef {
    Vec3 approx;
    const ExactPoint* exact = nullptr;
};

Plane plane_through(const Vec3& a, const Vec3& b, const Vec3& c);

/// Where the line p q meets the plane through a, b, c; they must not be parallel.
ExactPoint line_and_plane(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b,
                          const Vec3& c);
/// Where the lines p q and r s meet; they must lie in a plane and not be parallel.
ExactPoint two_lines(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s);
/// The planes must meet in one point.
ExactPoint three_planes(const Plane& a, const Plane& b, const Plane& c);

/// Sides of the plane through a, b, c, for grid points.
class SideOfPlane {
public:
    SideOfPlane(const Vec3& a, const Vec3& b, const Vec3& c);

    /// 1 where (b - a) x (c - a) points to, 0 on the plane.
    int of(const Vec3& p) const
    {
        double det = 0.0;
        double size = 0.0;
        for (int k = 0; k < 3; ++k) {
            const double d = p[k] - a_[k];
            det += d * normal_[k];
            size += std::abs(d) * size_[k];
        }
        const double bound = 8.0 * 1.1102230246251565e-16 * size;
        if (det > bound) return 1;
        if (det < -bound) return -1;
        return size == 0.0 ? 0 : exact(p);
    }

private:
    int exact(const Vec3& p) const;

    const Vec3& a_;
    const Vec3& b_;
    const Vec3& c_;
    Vec3 normal_;
    Vec3 size_;  // sums of the magnitudes of the terms of the normal
};

/// The same for one point.
int side_of_plane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p);

/// Turn of a, b, c seen against coordinate axis `axis`: 1 counterclockwise. A triangle whose
/// normal has a positive component along `axis` turns counterclockwise.
int turn(int axis, const Vec3& a, const Vec3& b, const Vec3& c);
int turn(int axis, const PointRef& a, const PointRef& b, const PointRef& c);

/// Sign of (p - v) x m along `axis`, for a grid point v and an integer vector m below 2^56.
int turn_of_vector(int axis, const Vec3& v, const PointRef& p, const Vec3& m);

/// Sign of p[k] - q[k].
int compare_coordinate(int k, const PointRef& p, const PointRef& q);
bool same_point(const PointRef& p, const PointRef& q);

/// The axis in which the normal of the triangle is largest, seen in floating point, with the
/// component certain not to be zero; -1 if all three components are zero.
int dominant_axis(const Vec3& a, const Vec3& b, const Vec3& c);
/// Sign of component k of the cross product of the two normals.
int cross_sign(int k, const Plane& a, const Plane& b);

}  // namespace genus::exact
