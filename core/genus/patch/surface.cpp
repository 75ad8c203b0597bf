#include "genus/patch/surface.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace genus {

Curvatures curvatures(const SurfacePoint& s)
{
    const Vec3 n = normalized(cross(s.pu, s.pv));
    const double E = dot(s.pu, s.pu), F = dot(s.pu, s.pv), G = dot(s.pv, s.pv);
    const double L = dot(s.puu, n), M = dot(s.puv, n), N = dot(s.pvv, n);
    const double area = E * G - F * F;
    Curvatures c;
    c.gaussian = (L * N - M * M) / area;
    c.mean = (E * N - 2.0 * F * M + G * L) / (2.0 * area);
    const double half = std::sqrt(std::max(0.0, c.mean * c.mean - c.gaussian));
    c.least = c.mean - half;
    c.most = c.mean + half;
    return c;
}

namespace {

Vec3 xyz(const Vec4& p)
{
    return {{p[0], p[1], p[2]}};
}

// A_u w - A w_u, as a polynomial along the line.
std::vector<Vec3> tangent(std::span<const Vec4> a, std::span<const Vec4> au)
{
    std::vector<Vec3> t(a.size() + au.size() - 1);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < au.size(); ++j)
            t[i + j] += xyz(au[j]) * a[i][3] - xyz(a[i]) * au[j][3];
    return t;
}

double largest(std::span<const Vec3> t)
{
    double m = 0.0;
    for (const Vec3& x : t) m = std::max(m, norm(x));
    return m;
}

}  // namespace

SurfacePoint projected(const Vec4& p, const Vec4& pu, const Vec4& pv, const Vec4& puu,
                       const Vec4& puv, const Vec4& pvv)
{
    const double w = p[3];
    SurfacePoint s;
    s.p = xyz(p) / w;
    s.pu = (xyz(pu) - pu[3] * s.p) / w;
    s.pv = (xyz(pv) - pv[3] * s.p) / w;
    s.puu = (xyz(puu) - 2.0 * pu[3] * s.pu - puu[3] * s.p) / w;
    s.puv = (xyz(puv) - pu[3] * s.pv - pv[3] * s.pu - puv[3] * s.p) / w;
    s.pvv = (xyz(pvv) - 2.0 * pv[3] * s.pv - pvv[3] * s.p) / w;
    return s;
}

Vec3 limit_normal(std::span<const Vec4> a, std::span<const Vec4> au, std::span<const Vec4> av)
{
    auto tu = tangent(a, au), tv = tangent(a, av);
    // What rounding left of coefficients that vanish must not be taken for a direction.
    constexpr double kNoise = 1e-12;
    const double scale_u = largest(tu), scale_v = largest(tv);
    for (Vec3& x : tu)
        if (norm(x) <= kNoise * scale_u) x = {};
    for (Vec3& x : tv)
        if (norm(x) <= kNoise * scale_v) x = {};
    for (std::size_t k = 0; k + 1 < tu.size() + tv.size(); ++k) {
        Vec3 n;
        double terms = 0.0;
        for (std::size_t i = k < tv.size() ? 0 : k - tv.size() + 1; i <= k && i < tu.size(); ++i) {
            n += cross(tu[i], tv[k - i]);
            terms += norm(tu[i]) * norm(tv[k - i]);
        }
        if (norm(n) > 1e-10 * terms && norm(n) > 0.0) return normalized(n);
    }
    return {};
}

}  // namespace genus
