#pragma once

#include "genus/base/transform.h"
#include "genus/implicit/implicit.h"

namespace genus {

/// Torus as a quartic: F(p) = (|x|^2 + R^2 - r^2)^2 - 4 R^2 (x^2 + y^2) with x = M^-1 p, inside
/// F <= 0. R is the radius of the centre circle, r that of the tube, 0 < r < R; M any affine map.
///
/// Implements [hanrahan1989], torus as quartic.
class Torus final : public Implicit {
public:
    /// Throws InvalidInput unless 0 < r < R and `placement` is affine and invertible.
    Torus(double R, double r, const Transform& placement = {});

    double R() const { return R_; }
    double r() const { return r_; }
    const Transform& placement() const { return placement_; }
    const Transform& to_local() const { return to_local_; }

    double value(const Vec3& p) const override;
    Vec3 gradient(const Vec3& p) const override;
    Interval bound(const Box3& box) const override;
    IntervalVec3 gradient_bound(const Box3& box) const override;

    /// The point at angles u round the axis and v round the tube, radians.
    Vec3 point(double u, double v) const;
    /// Outward unit normal there.
    Vec3 normal(double u, double v) const;

    bool operator==(const Torus& o) const
    {
        return R_ == o.R_ && r_ == o.r_ && placement_ == o.placement_;
    }

private:
    Vec3 local(const Vec3& p) const;
    IntervalVec3 local(const Box3& box) const;

    double R_, r_;
    Transform placement_, to_local_;
};

}  // namespace genus
