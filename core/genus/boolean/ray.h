#pragma once

#include "genus/boolean/arrangement.h"

namespace genus::exact {

/// A ray along a coordinate axis that starts at a corner of a face, moved into the face by an
/// infinitely small step along one edge, `m`, and a smaller one along another, `m2`: there it
/// meets no edge and no corner.
struct Ray {
    int axis;
    Vec3 start;
    Vec3 m;
    Vec3 m2;
};

/// The ray from the first corner of face f.
Ray ray_from(const Soup& soup, std::int32_t f);

FloatBox box_of_ray(const Ray& ray);

/// 1 or -1, the sign of its normal along the ray, if the face lies on it beyond its start. Exact.
int hit(const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c);

/// A line along a coordinate axis through the inside of a piece of a plane.
class UprightLine {
public:
    /// Along the axis in which the normal of the face `plane` is largest.
    UprightLine(const Soup& soup, std::int32_t plane);

    /// Does the normal of the plane point up the line?
    bool normal_is_up() const { return up_ > 0; }

    /// Moves the line through p, whose coordinate along it says nothing. False unless it then
    /// passes strictly inside the triangle, which lies in the plane.
    bool pass_through(const std::array<PointRef, 3>& triangle, const Vec3& p);

    /// Holds the line from the triangle upwards.
    FloatBox box() const;

    struct Crossing {
        int sign;    // of the normal of the face along the line; 0: passes by
        int height;  // sign of the height above the plane
        bool clear;  // false: through an edge
    };
    /// Exact.
    Crossing cross(std::int32_t face) const;

private:
    // The line meets a plane n . x = d at the height rest / n[axis].
    WideInt<5> rest(const Plane& plane) const;

    const Soup& soup_;
    Plane plane_;
    int axis_;
    int up_;
    Vec3 p_;
    double low_ = 0.0;
    WideInt<5> rest_;
};

}  // namespace genus::exact
