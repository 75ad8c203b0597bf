#include "genus/boolean/exact_point.h"

#include <cmath>

#include "genus/base/error.h"

namespace genus::exact {

namespace {

constexpr double kEpsilon = 1.1102230246251565e-16;  // 2^-53

std::int64_t as_int(double v)
{
    return static_cast<std::int64_t>(v);
}

template <class T>
int sign_of(T value)
{
    return (value > 0) - (value < 0);
}

// (b - a) x (c - a), component k, exactly: below 2^107.
Int128 normal_component(int k, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const int u = (k + 1) % 3;
    const int v = (k + 2) % 3;
    return static_cast<Int128>((as_int(b[u]) - as_int(a[u]))) * (as_int(c[v]) - as_int(a[v])) -
           static_cast<Int128>((as_int(b[v]) - as_int(a[v]))) * (as_int(c[u]) - as_int(a[u]));
}

int exact_side_of_plane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p)
{
    WideInt<5> sum;
    for (int k = 0; k < 3; ++k)
        sum = WideInt<5>(sum + WideInt<2>::from_int128(normal_component(k, a, b, c)) *
                                   WideInt<1>((as_int(p[k]) - as_int(a[k]))));
    return sum.sign();
}

// Component k of the cross product of two normals, below 2^215.
WideInt<4> cross_component(int k, const Plane& a, const Plane& b)
{
    const int u = (k + 1) % 3;
    const int v = (k + 2) % 3;
    return WideInt<4>(a.n[u] * b.n[v] - a.n[v] * b.n[u]);
}

// floor(1024 x / w) for w > 0 and |x / w| up to 2^52. Each step takes off what a floating quotient
// says; the last units are settled by comparison.
// `whole` is taken back unless the quotient is a whole number of 1024ths, and of ones.
std::int64_t fixed_point(const WideInt<6>& x, const WideInt<6>& w, bool& whole)
{
    WideInt<8> rest(x * WideInt<1>(1024));
    const double divisor = w.to_double();
    if (!(std::abs(rest.to_double()) < 0x1p63 * divisor))
        throw Error("mesh_boolean: an intersection lies outside the grid");
    std::int64_t quotient = 0;
    for (int round = 0; round < 3; ++round) {
        const auto step = static_cast<std::int64_t>(rest.to_double() / divisor);
        if (step == 0) break;
        quotient += step;
        rest = WideInt<8>(rest - w * WideInt<1>(step));
    }
    while (rest.sign() < 0) {
        rest = WideInt<8>(rest + w);
        --quotient;
    }
    while (compare(rest, w) >= 0) {
        rest = WideInt<8>(rest - w);
        ++quotient;
    }
    whole = whole && rest.sign() == 0 && quotient % 1024 == 0;
    return quotient;
}

void finish(ExactPoint& point)
{
    if (point.w.sign() < 0) {
        point.w = -point.w;
        for (auto& x : point.x) x = -x;
    }
    point.on_grid = true;
    for (int k = 0; k < 3; ++k) point.fixed[k] = fixed_point(point.x[k], point.w, point.on_grid);
}

std::int64_t fixed_of(int k, const PointRef& p)
{
    return p.exact ? p.exact->fixed[k] : as_int(p.approx[k]) * 1024;
}

// Homogeneous coordinates of either sort of point.
struct Homogeneous {
    WideInt<6> x[3];
    WideInt<6> w;

    explicit Homogeneous(const PointRef& p)
    {
        for (int k = 0; k < 3; ++k)
            x[k] = p.exact ? p.exact->x[k] : WideInt<6>(as_int(p.approx[k]));
        w = p.exact ? p.exact->w : WideInt<6>(1);
    }
};

int exact_turn(int axis, const PointRef& a, const PointRef& b, const PointRef& c)
{
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const Homogeneous p(a);
    const Homogeneous q(b);
    const Homogeneous r(c);
    const auto qr_v = q.x[v] * r.w - r.x[v] * q.w;
    const auto qr_u = q.x[u] * r.w - r.x[u] * q.w;
    const auto qr_uv = q.x[u] * r.x[v] - r.x[u] * q.x[v];
    return (p.x[u] * qr_v - p.x[v] * qr_u + p.w * qr_uv).sign();
}

}  // namespace

Vec3 ExactPoint::approximate() const
{
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = static_cast<double>(fixed[k]) * (1.0 / 1024.0);
    return p;
}

Plane plane_through(const Vec3& a, const Vec3& b, const Vec3& c)
{
    Plane plane;
    WideInt<4> d;
    for (int k = 0; k < 3; ++k) {
        plane.n[k] = WideInt<2>::from_int128(normal_component(k, a, b, c));
        d = WideInt<4>(d + plane.n[k] * WideInt<1>(as_int(a[k])));
    }
    plane.d = WideInt<3>(d);
    return plane;
}

namespace {

// The axis along which an edge runs, or -1.
int axis_along(const Vec3& d)
{
    int axis = -1;
    for (int k = 0; k < 3; ++k) {
        if (d[k] == 0.0) continue;
        if (axis >= 0) return -1;
        axis = k;
    }
    return axis;
}

ExactPoint grid_point(const Vec3& p)
{
    ExactPoint point;
    for (int k = 0; k < 3; ++k) {
        point.x[k] = WideInt<6>(as_int(p[k]));
        point.fixed[k] = as_int(p[k]) * 1024;
    }
    point.w = WideInt<6>(1);
    point.on_grid = true;
    return point;
}

ExactPoint line_and_plane(const Vec3& p, const Vec3& q, const Plane& plane)
{
    WideInt<4> w;
    WideInt<4> along(plane.d);  // d - n . p
    for (int k = 0; k < 3; ++k) {
        w = WideInt<4>(w + plane.n[k] * WideInt<1>((as_int(q[k]) - as_int(p[k]))));
        along = WideInt<4>(along - plane.n[k] * WideInt<1>(as_int(p[k])));
    }
    ExactPoint point;
    point.w = WideInt<6>(w);
    for (int k = 0; k < 3; ++k)
        point.x[k] = WideInt<6>(w * WideInt<1>(as_int(p[k])) +
                                along * WideInt<1>((as_int(q[k]) - as_int(p[k]))));
    finish(point);
    return point;
}

}  // namespace

ExactPoint line_and_plane(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const int k = axis_along(q - p);
    if (k >= 0 && a[k] == b[k] && a[k] == c[k]) {
        Vec3 there = p;
        there[k] = a[k];
        return grid_point(there);
    }
    return line_and_plane(p, q, plane_through(a, b, c));
}

ExactPoint two_lines(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s)
{
    const int along = axis_along(q - p);
    if (along >= 0 && axis_along(s - r) >= 0) {
        Vec3 there = p;
        there[along] = r[along];
        return grid_point(there);
    }
    // The plane that holds r s and the direction of an axis in which the cross product of the two
    // lines is not zero cuts the first line where the second does.
    int axis = 0;
    for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        const Int128 cross =
            static_cast<Int128>((as_int(q[u]) - as_int(p[u]))) * (as_int(s[v]) - as_int(r[v])) -
            static_cast<Int128>((as_int(q[v]) - as_int(p[v]))) * (as_int(s[u]) - as_int(r[u]));
        if (cross != 0) axis = k;
    }
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    Plane plane;
    plane.n[axis] = WideInt<2>(0);
    plane.n[u] = WideInt<2>((as_int(s[v]) - as_int(r[v])));
    plane.n[v] = WideInt<2>((as_int(r[u]) - as_int(s[u])));
    plane.d = WideInt<3>(
        WideInt<4>(plane.n[u] * WideInt<1>(as_int(r[u])) + plane.n[v] * WideInt<1>(as_int(r[v]))));
    return line_and_plane(p, q, plane);
}

ExactPoint three_planes(const Plane& a, const Plane& b, const Plane& c)
{
    std::array<WideInt<4>, 3> bc;
    std::array<WideInt<4>, 3> ca;
    std::array<WideInt<4>, 3> ab;
    for (int k = 0; k < 3; ++k) {
        bc[k] = cross_component(k, b, c);
        ca[k] = cross_component(k, c, a);
        ab[k] = cross_component(k, a, b);
    }
    ExactPoint point;
    point.w = WideInt<6>(a.n[0] * bc[0] + a.n[1] * bc[1] + a.n[2] * bc[2]);
    for (int k = 0; k < 3; ++k) point.x[k] = WideInt<6>(a.d * bc[k] + b.d * ca[k] + c.d * ab[k]);
    finish(point);
    return point;
}

SideOfPlane::SideOfPlane(const Vec3& a, const Vec3& b, const Vec3& c) : a_(a), b_(b), c_(c)
{
    const Vec3 ab = b - a;
    const Vec3 ac = c - a;
    for (int k = 0; k < 3; ++k) {
        const int u = k == 2 ? 0 : k + 1;
        const int v = k == 0 ? 2 : k - 1;
        const double left = ab[u] * ac[v];
        const double right = ab[v] * ac[u];
        normal_[k] = left - right;
        size_[k] = std::abs(left) + std::abs(right);
    }
}

int SideOfPlane::exact(const Vec3& p) const
{
    return exact_side_of_plane(a_, b_, c_, p);
}

int side_of_plane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p)
{
    return SideOfPlane(a, b, c).of(p);
}

int turn(int axis, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const double left = (b[u] - a[u]) * (c[v] - a[v]);
    const double right = (b[v] - a[v]) * (c[u] - a[u]);
    const double det = left - right;
    const double bound = 4.0 * kEpsilon * (std::abs(left) + std::abs(right));
    if (det > bound) return 1;
    if (det < -bound) return -1;
    return sign_of(normal_component(axis, a, b, c));
}

int turn(int axis, const PointRef& a, const PointRef& b, const PointRef& c)
{
    if (!a.exact && !b.exact && !c.exact) return turn(axis, a.approx, b.approx, c.approx);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const double bu = b.approx[u] - a.approx[u];
    const double bv = b.approx[v] - a.approx[v];
    const double cu = c.approx[u] - a.approx[u];
    const double cv = c.approx[v] - a.approx[v];
    const double left = bu * cv;
    const double right = bv * cu;
    const double det = left - right;
    // Each coordinate is off by at most 0.26, so each difference by less than 0.53 and its own
    // rounding, at most another half.
    const double bound = 1.1 * (std::abs(bu) + std::abs(bv) + std::abs(cu) + std::abs(cv)) + 4.0 +
                         4.0 * kEpsilon * (std::abs(left) + std::abs(right));
    if (det > bound) return 1;
    if (det < -bound) return -1;
    return exact_turn(axis, a, b, c);
}

int turn_of_vector(int axis, const Vec3& v, const PointRef& p, const Vec3& m)
{
    const int i = (axis + 1) % 3;
    const int j = (axis + 2) % 3;
    const Homogeneous h(p);
    const auto di = h.x[i] - h.w * WideInt<1>(as_int(v[i]));
    const auto dj = h.x[j] - h.w * WideInt<1>(as_int(v[j]));
    return (di * WideInt<1>(as_int(m[j])) - dj * WideInt<1>(as_int(m[i]))).sign();
}

int compare_coordinate(int k, const PointRef& p, const PointRef& q)
{
    const std::int64_t fp = fixed_of(k, p);
    const std::int64_t fq = fixed_of(k, q);
    if (fp != fq) return fp < fq ? -1 : 1;
    if (!p.exact && !q.exact) return 0;
    const Homogeneous hp(p);
    const Homogeneous hq(q);
    return compare(hp.x[k] * hq.w, hq.x[k] * hp.w);
}

bool same_point(const PointRef& p, const PointRef& q)
{
    for (int k = 0; k < 3; ++k)
        if (fixed_of(k, p) != fixed_of(k, q)) return false;
    for (int k = 0; k < 3; ++k)
        if (compare_coordinate(k, p, q) != 0) return false;
    return true;
}

int dominant_axis(const Vec3& a, const Vec3& b, const Vec3& c)
{
    const Vec3 n = cross(b - a, c - a);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(n[k]) > std::abs(n[axis])) axis = k;
    for (int k = 0; k < 3; ++k) {
        const int candidate = (axis + k) % 3;
        if (normal_component(candidate, a, b, c) != 0) return candidate;
    }
    return -1;
}

int cross_sign(int k, const Plane& a, const Plane& b)
{
    return cross_component(k, a, b).sign();
}

}  // namespace genus::exact
