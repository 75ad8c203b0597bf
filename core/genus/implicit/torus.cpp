#include "genus/implicit/torus.h"

#include <cmath>
#include <limits>

#include "genus/base/error.h"

namespace genus {
namespace {

Transform checked(const Transform& placement)
{
    require(placement.is_affine(), "torus: the transform is not affine");
    return placement;
}

Vec3 linear_times(const Transform& t, const Vec3& v)
{
    Vec3 r;
    for (int i = 0; i < 3; ++i) r[i] = t.m[i][0] * v[0] + t.m[i][1] * v[1] + t.m[i][2] * v[2];
    return r;
}

Vec3 transposed_times(const Transform& t, const Vec3& v)
{
    Vec3 r;
    for (int i = 0; i < 3; ++i) r[i] = t.m[0][i] * v[0] + t.m[1][i] * v[1] + t.m[2][i] * v[2];
    return r;
}

}  // namespace

Torus::Torus(double R, double r, const Transform& placement)
    : R_(R), r_(r), placement_(checked(placement)), to_local_(inverse(placement))
{
    require(std::isfinite(R), "torus: R", R, "finite");
    require(r > 0.0 && r < R, "torus: r", r, "positive and less than R");
    require(r * r >= std::numeric_limits<double>::min() && R * R * R * R <= 1e300,
            "torus: radii out of range");
}

// Points are taken relative to the centre before the inverse is applied, so that nothing cancels
// far from the origin.
Vec3 Torus::local(const Vec3& p) const
{
    const Vec3 d{{p[0] - placement_.m[0][3], p[1] - placement_.m[1][3], p[2] - placement_.m[2][3]}};
    return linear_times(to_local_, d);
}

// The quartic is a difference of squares: with s the distance from the axis,
// F = ((s - R)^2 + z^2 - r^2) ((s + R)^2 + z^2 - r^2). The second factor is positive, so the
// first decides the sign and little cancels.
double Torus::value(const Vec3& p) const
{
    const Vec3 x = local(p);
    const double s = std::sqrt(x[0] * x[0] + x[1] * x[1]), zz = x[2] * x[2] - r_ * r_;
    return ((s - R_) * (s - R_) + zz) * ((s + R_) * (s + R_) + zz);
}

Vec3 Torus::gradient(const Vec3& p) const
{
    const Vec3 x = local(p);
    const double ss = x[0] * x[0] + x[1] * x[1];
    const double k = ss + x[2] * x[2] + R_ * R_ - r_ * r_;
    const Vec3 g{
        {4.0 * x[0] * (k - 2.0 * R_ * R_), 4.0 * x[1] * (k - 2.0 * R_ * R_), 4.0 * x[2] * k}};
    return transposed_times(to_local_, g);
}

IntervalVec3 Torus::local(const Box3& box) const
{
    IntervalVec3 d = to_intervals(box), x;
    for (int i = 0; i < 3; ++i) d[i] = d[i] - Interval(placement_.m[i][3]);
    for (int i = 0; i < 3; ++i) {
        x[i] = Interval(0.0);
        for (int j = 0; j < 3; ++j)
            if (to_local_.m[i][j] != 0.0) x[i] = x[i] + Interval(to_local_.m[i][j]) * d[j];
    }
    return x;
}

Interval Torus::bound(const Box3& box) const
{
    const IntervalVec3 x = local(box);
    const Interval s = sqrt(square(x[0]) + square(x[1]));
    const Interval zz = square(x[2]) - square(Interval(r_));
    const Interval near = square(s - Interval(R_)) + zz, far = square(s + Interval(R_)) + zz;
    // The same operations as value(), so that its rounded results are held, too.
    return near * far;
}

IntervalVec3 Torus::gradient_bound(const Box3& box) const
{
    const IntervalVec3 x = local(box);
    const Interval RR = square(Interval(R_)), rr = square(Interval(r_));
    const Interval rest = square(x[0]) + square(x[1]) + square(x[2]) - rr;
    const Interval flat = Interval(4.0) * (rest - RR), up = Interval(4.0) * (rest + RR);
    const IntervalVec3 local_gradient{x[0] * flat, x[1] * flat, x[2] * up};
    IntervalVec3 g;
    for (int i = 0; i < 3; ++i) {
        g[i] = Interval(0.0);
        for (int j = 0; j < 3; ++j)
            if (to_local_.m[j][i] != 0.0)
                g[i] = g[i] + Interval(to_local_.m[j][i]) * local_gradient[j];
    }
    return g;
}

Vec3 Torus::point(double u, double v) const
{
    const double s = R_ + r_ * std::cos(v);
    return apply(placement_, Vec3{{s * std::cos(u), s * std::sin(u), r_ * std::sin(v)}});
}

Vec3 Torus::normal(double u, double v) const
{
    const Vec3 n{{std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v)}};
    return normalized(transposed_times(to_local_, n));
}

}  // namespace genus
