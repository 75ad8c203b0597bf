#pragma once

#include <span>

#include "genus/base/vec.h"

namespace genus {

/// A point of a parametric surface with its partial derivatives.
struct SurfacePoint {
    Vec3 p, pu, pv, puu, puv, pvv;
};

/// Curvatures, 1 / model units; positive where the surface bends towards its normal pu x pv.
struct Curvatures {
    double gaussian, mean;
    double least, most;  // principal curvatures
};

/// From the fundamental forms. Not finite where pu and pv are parallel.
///
/// Implements [farin2002], chapter 19.
Curvatures curvatures(const SurfacePoint& s);

/// From the derivatives of (A, w), the partials of A / w.
SurfacePoint projected(const Vec4& p, const Vec4& pu, const Vec4& pv, const Vec4& puu,
                       const Vec4& puv, const Vec4& pvv);

/// Unit normal of a (rational) surface as the limit along a line into its domain, given the Taylor
/// coefficients along that line of (A, w) and its partials by u and v: the first coefficient of
/// (A_u w - A w_u) x (A_v w - A w_v) that does not vanish. Zero if all do (the surface is a curve
/// there).
Vec3 limit_normal(std::span<const Vec4> a, std::span<const Vec4> au, std::span<const Vec4> av);

}  // namespace genus
