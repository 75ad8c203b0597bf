#include "genus/base/predicates.h"

#include <cmath>

#include "genus/base/expansion.h"

namespace genus {

namespace {

constexpr double kUnit = 0x1p-53;
// Error of the rounded determinant relative to its permanent, [shewchuk1997] section 4.
constexpr double kOrient2dBound = (3.0 + 16.0 * kUnit) * kUnit;
constexpr double kOrient3dBound = (7.0 + 56.0 * kUnit) * kUnit;
constexpr double kInCircleBound = (10.0 + 96.0 * kUnit) * kUnit;

int sign_of(double x)
{
    return (x > 0.0) - (x < 0.0);
}

int orient2d_exactly(const Vec2& a, const Vec2& b, const Vec2& c)
{
    const auto acx = difference(a[0], c[0]), acy = difference(a[1], c[1]);
    const auto bcx = difference(b[0], c[0]), bcy = difference(b[1], c[1]);
    return (acx * bcy - acy * bcx).sign();
}

int orient3d_exactly(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
    const auto ax = difference(a[0], d[0]), ay = difference(a[1], d[1]);
    const auto az = difference(a[2], d[2]);
    const auto bx = difference(b[0], d[0]), by = difference(b[1], d[1]);
    const auto bz = difference(b[2], d[2]);
    const auto cx = difference(c[0], d[0]), cy = difference(c[1], d[1]);
    const auto cz = difference(c[2], d[2]);
    const auto bc = bx * cy - by * cx;
    const auto ca = cx * ay - cy * ax;
    const auto ab = ax * by - ay * bx;
    return (bc * az + ca * bz + ab * cz).sign();
}

int in_circle_exactly(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d)
{
    const auto ax = difference(a[0], d[0]), ay = difference(a[1], d[1]);
    const auto bx = difference(b[0], d[0]), by = difference(b[1], d[1]);
    const auto cx = difference(c[0], d[0]), cy = difference(c[1], d[1]);
    const auto bc = bx * cy - by * cx;
    const auto ca = cx * ay - cy * ax;
    const auto ab = ax * by - ay * bx;
    const auto lift_a = ax * ax + ay * ay;
    const auto lift_b = bx * bx + by * by;
    const auto lift_c = cx * cx + cy * cy;
    return (lift_a * bc + lift_b * ca + lift_c * ab).sign();
}

}  // namespace

int orient2d(const Vec2& a, const Vec2& b, const Vec2& c)
{
    const double left = (a[0] - c[0]) * (b[1] - c[1]);
    const double right = (a[1] - c[1]) * (b[0] - c[0]);
    const double det = left - right;
    if (std::fabs(det) > kOrient2dBound * (std::fabs(left) + std::fabs(right))) return sign_of(det);
    return orient2d_exactly(a, b, c);
}

int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
    const double ax = a[0] - d[0], ay = a[1] - d[1], az = a[2] - d[2];
    const double bx = b[0] - d[0], by = b[1] - d[1], bz = b[2] - d[2];
    const double cx = c[0] - d[0], cy = c[1] - d[1], cz = c[2] - d[2];
    const double det =
        az * (bx * cy - by * cx) + bz * (cx * ay - cy * ax) + cz * (ax * by - ay * bx);
    const double permanent = std::fabs(az) * (std::fabs(bx * cy) + std::fabs(by * cx)) +
                             std::fabs(bz) * (std::fabs(cx * ay) + std::fabs(cy * ax)) +
                             std::fabs(cz) * (std::fabs(ax * by) + std::fabs(ay * bx));
    if (std::fabs(det) > kOrient3dBound * permanent) return sign_of(det);
    // As where faces of a mesh share corners.
    if (a == b || a == c || a == d || b == c || b == d || c == d) return 0;
    return orient3d_exactly(a, b, c, d);
}

int in_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d)
{
    const double ax = a[0] - d[0], ay = a[1] - d[1];
    const double bx = b[0] - d[0], by = b[1] - d[1];
    const double cx = c[0] - d[0], cy = c[1] - d[1];
    const double lift_a = ax * ax + ay * ay;
    const double lift_b = bx * bx + by * by;
    const double lift_c = cx * cx + cy * cy;
    const double det =
        lift_a * (bx * cy - by * cx) + lift_b * (cx * ay - cy * ax) + lift_c * (ax * by - ay * bx);
    const double permanent = lift_a * (std::fabs(bx * cy) + std::fabs(by * cx)) +
                             lift_b * (std::fabs(cx * ay) + std::fabs(cy * ax)) +
                             lift_c * (std::fabs(ax * by) + std::fabs(ay * bx));
    if (std::fabs(det) > kInCircleBound * permanent) return sign_of(det);
    return in_circle_exactly(a, b, c, d);
}

}  // namespace genus
