#include "genus/boolean/ray.h"

#include <algorithm>

namespace genus::exact {

namespace {

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

int sign_of(Int128 value)
{
    return (value > 0) - (value < 0);
}

// Sign of (b - a) x m seen along `axis`, for an integer vector m.
int turn_of_edge(int axis, const Vec3& a, const Vec3& b, const Vec3& m)
{
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const auto product = [](double x, double y) {
        return static_cast<Int128>(static_cast<std::int64_t>(x)) * static_cast<std::int64_t>(y);
    };
    return sign_of(product(b[u] - a[u], m[v]) - product(b[v] - a[v], m[u]));
}

// Sign of n . m for the normal n of a, b, c.
int side_of_vector(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& m)
{
    const Plane plane = plane_through(a, b, c);
    WideInt<5> sum;
    for (int k = 0; k < 3; ++k)
        sum = WideInt<5>(sum + plane.n[k] * WideInt<1>(static_cast<std::int64_t>(m[k])));
    return sum.sign();
}

}  // namespace

Ray ray_from(const Soup& soup, std::int32_t f)
{
    const Vec3& a = soup.points[soup.faces[f][0]];
    const Vec3& b = soup.points[soup.faces[f][1]];
    const Vec3& c = soup.points[soup.faces[f][2]];
    return {dominant_axis(a, b, c), a, b - a, c - a};
}

FloatBox box_of_ray(const Ray& ray)
{
    FloatBox box = box_of(ray.start, ray.start, ray.start);
    box.high[ray.axis] = 3e38f;
    return box;
}

int hit(const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const Vec3* p[3] = {&a, &b, &c};
    int turning = 0;
    for (int i = 0; i < 3; ++i) {
        const Vec3& from = *p[i];
        const Vec3& to = *p[next(i)];
        int s = turn(ray.axis, from, to, ray.start);
        if (s == 0) s = turn_of_edge(ray.axis, from, to, ray.m);
        if (s == 0) s = turn_of_edge(ray.axis, from, to, ray.m2);
        if (s == 0 || s == -turning) return 0;
        turning = s;
    }
    int side = side_of_plane(a, b, c, ray.start);
    if (side == 0) side = side_of_vector(a, b, c, ray.m);
    if (side == 0) side = side_of_vector(a, b, c, ray.m2);
    // A face that turns counterclockwise has its normal along the ray, and is met if the start
    // lies below it.
    return side * turning < 0 ? turning : 0;
}

UprightLine::UprightLine(const Soup& soup, std::int32_t plane) : soup_(soup)
{
    const Vec3& a = soup.points[soup.faces[plane][0]];
    const Vec3& b = soup.points[soup.faces[plane][1]];
    const Vec3& c = soup.points[soup.faces[plane][2]];
    plane_ = plane_through(a, b, c);
    axis_ = dominant_axis(a, b, c);
    up_ = turn(axis_, a, b, c);
}

bool UprightLine::pass_through(const std::array<PointRef, 3>& triangle, const Vec3& p)
{
    p_ = p;
    int turning = 0;
    for (int i = 0; i < 3; ++i) {
        const int s = turn(axis_, triangle[i], triangle[next(i)], {p, nullptr});
        if (s == 0 || s == -turning) return false;
        turning = s;
    }
    low_ =
        std::min({triangle[0].approx[axis_], triangle[1].approx[axis_], triangle[2].approx[axis_]});
    rest_ = rest(plane_);
    return true;
}

FloatBox UprightLine::box() const
{
    Vec3 low = p_;
    low[axis_] = low_ - 1.0;  // approximations are that good
    FloatBox box = box_of(low, low, low);
    box.high[axis_] = 3e38f;
    return box;
}

WideInt<5> UprightLine::rest(const Plane& plane) const
{
    WideInt<5> r(plane.d);
    for (int k = 0; k < 3; ++k)
        if (k != axis_)
            r = WideInt<5>(r - plane.n[k] * WideInt<1>(static_cast<std::int64_t>(p_[k])));
    return r;
}

UprightLine::Crossing UprightLine::cross(std::int32_t face) const
{
    const Triangle& t = soup_.faces[face];
    int turning = 0;
    bool on_edge = false;
    for (int i = 0; i < 3; ++i) {
        const int s = turn(axis_, soup_.points[t[i]], soup_.points[t[next(i)]], p_);
        on_edge = on_edge || s == 0;
        if (s == 0) continue;
        if (s == -turning) return {0, 0, true};
        turning = s;
    }
    if (on_edge) return {0, 0, false};
    const Plane plane = plane_through(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
    const int order = compare(rest(plane) * plane_.n[axis_], rest_ * plane.n[axis_]);
    return {turning, order * plane.n[axis_].sign() * plane_.n[axis_].sign(), true};
}

}  // namespace genus::exact
