#include "genus/model/ray_roots.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "genus/volume/crossing.h"

namespace genus {
namespace {

/// a b - c d with one rounding's error.
double difference_of_products(double a, double b, double c, double d)
{
    const double cd = c * d, error = std::fma(-c, d, cd);
    return std::fma(a, b, -cd) + error;
}

/// Roots of a t^2 + 2 b t + c, ascending.
std::vector<double> quadratic_roots(double a, double b, double c)
{
    if (a == 0.0) {
        if (b == 0.0) return {};
        return {-0.5 * c / b};
    }
    const double discriminant = difference_of_products(b, b, a, c);
    if (!(discriminant >= 0.0)) return {};
    // The sum without cancellation; the other root from the product c / a.
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    if (q == 0.0) return {0.0, 0.0};
    std::vector<double> roots{q / a, c / q};
    if (roots[0] > roots[1]) std::swap(roots[0], roots[1]);
    return roots;
}

/// The parameter at which the line is nearest to `to`.
double nearest_parameter(const Vec3& origin, const Vec3& direction, const Vec3& to)
{
    const double length = norm(direction);
    return dot(to - origin, direction / length) / length;
}

/// One step of Newton, kept only if it is small: it mends rounding, it must not wander.
double polished(const Surface& surface, const Vec3& origin, const Vec3& direction, double t)
{
    const Vec3 p = origin + t * direction;
    const double slope = dot(surface.gradient(p), direction);
    const double step = surface.value(p) / slope;
    return std::fabs(step) <= 1e-6 * std::fabs(t) ? t - step : t;
}

std::vector<double> quadric_roots(const Quadric& quadric, const Vec3& origin, const Vec3& direction)
{
    if (quadric.is_linear())
        return quadratic_roots(0.0, 0.5 * dot(quadric.gradient(origin), direction),
                               quadric.value(origin));
    const double shift = nearest_parameter(origin, direction, quadric.origin());
    const Vec3 near = origin + shift * direction;
    Vec3 bent;
    const std::array<Vec3, 3> hessian = quadric.hessian();
    for (int i = 0; i < 3; ++i) bent[i] = 0.5 * dot(hessian[i], direction);
    std::vector<double> roots = quadratic_roots(
        dot(bent, direction), 0.5 * dot(quadric.gradient(near), direction), quadric.value(near));
    for (double& t : roots) t += shift;
    return roots;
}

using Polynomial = std::vector<double>;  // coefficients, the constant first

double value_at(const Polynomial& f, double t)
{
    double sum = 0.0;
    for (std::size_t i = f.size(); i-- > 0;) sum = sum * t + f[i];
    return sum;
}

/// Places in [low, high] where `f` changes sign, found between those where its derivative does.
/// `exact` gives the value of f, better than the coefficients do.
std::vector<double> sign_changes(const Polynomial& f, double low, double high,
                                 const std::function<double(double)>& exact)
{
    std::vector<double> ends{low};
    if (f.size() > 2) {
        Polynomial derivative;
        for (std::size_t i = 1; i < f.size(); ++i)
            derivative.push_back(static_cast<double>(i) * f[i]);
        for (double t :
             sign_changes(derivative, low, high, [&](double x) { return value_at(derivative, x); }))
            ends.push_back(t);
    }
    ends.push_back(high);
    std::vector<double> roots;
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
        double a = ends[i], b = ends[i + 1];
        const bool rises = exact(a) <= 0.0;
        if (rises == (exact(b) <= 0.0)) continue;
        for (;;) {
            const double middle = 0.5 * (a + b);
            if (!(a < middle && middle < b)) break;
            (rises == (exact(middle) <= 0.0) ? a : b) = middle;
        }
        roots.push_back(b);
    }
    return roots;
}

std::vector<double> torus_roots(const Torus& torus, const Vec3& origin, const Vec3& direction)
{
    // In the torus' own coordinates, about the point nearest to its centre.
    const Transform& m = torus.to_local();
    const Vec3 center{
        {torus.placement().m[0][3], torus.placement().m[1][3], torus.placement().m[2][3]}};
    const Vec3 d = apply_vector(m, direction), start = apply_vector(m, origin - center);
    const double length = norm(d);
    const Vec3 unit = d / length;
    const double shift = -dot(start, unit);
    const Vec3 o = start + shift * unit;
    const double R = torus.R(), r = torus.r(), reach = R + r;
    const double height = norm(o);
    if (!(height <= 1.001 * reach)) return {};
    // |o + t unit|^2 = o.o + t^2 (o is orthogonal to unit, up to rounding).
    const double k = dot(o, o) + R * R - r * r, e = 2.0 * dot(o, unit);
    const double flat0 = o[0] * o[0] + o[1] * o[1], flat1 = 2.0 * (o[0] * unit[0] + o[1] * unit[1]);
    const double flat2 = unit[0] * unit[0] + unit[1] * unit[1], four = 4.0 * R * R;
    const Polynomial quartic{k * k - four * flat0, 2.0 * k * e - four * flat1,
                             e * e + 2.0 * k - four * flat2, 2.0 * e, 1.0};
    const auto exact = [&](double t) {
        const Vec3 x = o + t * unit;
        const double s = std::hypot(x[0], x[1]);
        return (s - R) * (s - R) + x[2] * x[2] - r * r;
    };
    std::vector<double> roots = sign_changes(quartic, -1.01 * reach, 1.01 * reach, exact);
    for (double& t : roots) t = (t + shift) / length;
    return roots;
}

// The part of a ray in a box, a little more than that; nothing if it passes by.
std::optional<Interval> part_in(const Box3& box, const Vec3& origin, const Vec3& direction)
{
    double low = -std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < 3; ++i) {
        if (direction[i] == 0.0) {
            if (origin[i] < box.min[i] || origin[i] > box.max[i]) return std::nullopt;
            continue;
        }
        const double a = (box.min[i] - origin[i]) / direction[i];
        const double b = (box.max[i] - origin[i]) / direction[i];
        low = std::max(low, std::min(a, b));
        high = std::min(high, std::max(a, b));
    }
    if (!(low <= high)) return std::nullopt;
    const double more = 1e-9 * (high - low) + 1e-12 * (std::fabs(low) + std::fabs(high));
    return Interval(low - more, high + more);
}

// Changes of sign of the function along the ray, by halving what bounds leave open: a piece without
// a zero is done, one on which the function is monotone has at most one. What happens within 2^-40
// of the way is taken as one crossing or none.
std::vector<double> function_roots(const Function& function, const Box3& box, const Vec3& origin,
                                   const Vec3& direction)
{
    const auto part = part_in(box, origin, direction);
    if (!part) return {};
    std::array<Expression, 3> at;
    for (std::size_t i = 0; i < 3; ++i)
        at[i] = Expression(origin[i]) + Expression(direction[i]) * Expression::x();
    const Function along(substituted(function.expression(), at));
    const auto value = [&](double t) { return along.value({{t, 0.0, 0.0}}); };
    std::vector<double> roots;
    std::vector<Interval> open{*part};
    const double least = 0x1p-40 * part->width();
    while (!open.empty()) {
        const Interval t = open.back();
        open.pop_back();
        const Box3 span{{{t.lo, 0.0, 0.0}}, {{t.hi, 0.0, 0.0}}};
        const Interval range = along.bound(span);
        if (range.lo > 0.0 || range.hi < 0.0) continue;
        const Interval slope = along.gradient_bound(span)[0];
        if (slope.lo > 0.0 || slope.hi < 0.0 || t.width() <= least) {
            const double first = value(t.lo), last = value(t.hi);
            if ((first < 0.0) == (last < 0.0)) continue;
            const double share =
                find_root([&](double s) { return value(t.lo + s * t.width()); }, first, last);
            roots.push_back(t.lo + share * t.width());
            continue;
        }
        open.push_back({t.mid(), t.hi});
        open.push_back({t.lo, t.mid()});
    }
    return roots;
}

}  // namespace

std::vector<double> ray_roots(const Surface& surface, const Vec3& origin, const Vec3& direction)
{
    if (surface.kind == Surface::Kind::Function)
        return function_roots(*surface.function, surface.function_box, origin, direction);
    std::vector<double> roots = surface.kind == Surface::Kind::Torus
                                    ? torus_roots(*surface.torus, origin, direction)
                                    : quadric_roots(surface.quadric, origin, direction);
    std::erase_if(roots, [](double t) { return !std::isfinite(t); });
    for (double& t : roots) t = polished(surface, origin, direction, t);
    std::sort(roots.begin(), roots.end());
    return roots;
}

}  // namespace genus
