#include "genus/model/queries.h"

#include <algorithm>
#include <cmath>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/model/leaves.h"
#include "genus/model/plan.h"
#include "genus/model/ray_roots.h"
#include "genus/model/solid_field.h"

namespace genus {
namespace {

constexpr std::size_t kGrain = 1024;

template <class T, class F>
std::vector<T> map_points(std::span<const Vec3> points, F f)
{
    std::vector<T> result(points.size());
    parallel_for(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) result[i] = f(points[i]);
    });
    return result;
}

struct Root {
    double t;
    std::int32_t surface;
};

/// Where the ray may change between inside and outside, in order.
std::vector<Root> roots_along(const CsgField& field, const Vec3& origin, const Vec3& direction)
{
    std::vector<Root> roots;
    for (std::size_t s = 0; s < field.surfaces().size(); ++s)
        for (double t : ray_roots(field.surfaces()[s], origin, direction))
            if (t >= 0.0) roots.push_back({t, static_cast<std::int32_t>(s)});
    std::stable_sort(roots.begin(), roots.end(),
                     [](const Root& a, const Root& b) { return a.t < b.t; });
    return roots;
}

/// Roots closer than rounding of points on the ray are one crossing of several surfaces.
bool same_place(const Vec3& origin, const Vec3& direction, double t, double u)
{
    const double length = norm(direction);
    const double size = norm(origin) + std::fabs(u) * length;
    return std::fabs(u - t) * length <= 16.0 * std::numeric_limits<double>::epsilon() * size;
}

/// The surface of the crossing that decides: of those that cross at roots [begin, end) the one
/// whose gradient, as it enters the function, has the sign the crossing asks for and which gives
/// the value next to the crossing.
SolidHit make_hit(const CsgField& field, const Vec3& origin, const Vec3& direction,
                  std::span<const Root> roots, bool entering)
{
    const double t = roots.front().t;
    const Vec3 p = origin + t * direction;
    // At the point itself several surfaces may be zero; the branch is asked there.
    CsgField::Active branch = field.active(p);
    const auto crosses = [&](std::int32_t s) {
        return std::any_of(roots.begin(), roots.end(),
                           [&](const Root& r) { return r.surface == s; });
    };
    if (branch.surface < 0 || !crosses(branch.surface)) branch.surface = roots.front().surface;
    Vec3 n = normalized(field.surfaces()[branch.surface].gradient(p));
    // Outward is against the ray on the way in, along it on the way out.
    if ((dot(n, direction) > 0.0) == entering) n = -n;
    return {t, p, n, branch.surface, entering, -1};
}

}  // namespace

std::vector<char> contains(const Implicit& field, std::span<const Vec3> points)
{
    return map_points<char>(points, [&](const Vec3& p) { return field.value(p) <= 0.0; });
}

std::vector<char> contains(const Solid& solid, std::span<const Vec3> points)
{
    return contains(*solid_field(solid), points);
}

std::vector<double> values(const Implicit& field, std::span<const Vec3> points)
{
    return map_points<double>(points, [&](const Vec3& p) { return field.value(p); });
}

std::vector<double> values(const Solid& solid, std::span<const Vec3> points)
{
    return values(*solid_field(solid), points);
}

std::vector<Vec3> gradients(const Implicit& field, std::span<const Vec3> points)
{
    return map_points<Vec3>(points, [&](const Vec3& p) { return field.gradient(p); });
}

std::vector<Vec3> gradients(const Solid& solid, std::span<const Vec3> points)
{
    return gradients(*solid_field(solid), points);
}

std::vector<SolidHit> ray_cast(const CsgField& field, const Vec3& origin, const Vec3& direction)
{
    require(is_finite(origin) && is_finite(direction), "ray_cast: a number is not finite");
    require(direction != Vec3{}, "ray_cast: the direction is zero");
    const std::vector<Root> roots = roots_along(field, origin, direction);
    const auto inside = [&](double t) { return field.value(origin + t * direction) <= 0.0; };
    std::vector<SolidHit> hits;
    // The state before the first crossing, then between each two and after the last.
    bool was_inside = inside(roots.empty() ? 0.0 : 0.5 * roots.front().t);
    for (std::size_t begin = 0; begin < roots.size();) {
        std::size_t end = begin + 1;
        while (end < roots.size() && same_place(origin, direction, roots[end - 1].t, roots[end].t))
            ++end;
        const double last = roots[end - 1].t;
        const double probe = end < roots.size() ? 0.5 * (last + roots[end].t)
                                                : last + std::max(1.0, std::fabs(last));
        const bool is_inside = inside(probe);
        if (is_inside != was_inside)
            hits.push_back(make_hit(field, origin, direction,
                                    std::span(roots).subspan(begin, end - begin), is_inside));
        was_inside = is_inside;
        begin = end;
    }
    return hits;
}

std::vector<SolidHit> ray_cast(const Solid& solid, const Vec3& origin, const Vec3& direction)
{
    return ray_cast(solid, std::span(&origin, 1), std::span(&direction, 1)).front();
}

namespace {

template <class Cast>
std::vector<std::vector<SolidHit>> cast_all(std::span<const Vec3> origins,
                                            std::span<const Vec3> directions, const Cast& cast)
{
    require(origins.size() == directions.size(),
            "ray_cast: origins and directions differ in number");
    std::vector<std::vector<SolidHit>> hits(origins.size());
    parallel_for(origins.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) hits[i] = cast(origins[i], directions[i]);
    });
    return hits;
}

}  // namespace

std::vector<std::vector<SolidHit>> ray_cast(const CsgField& field, std::span<const Vec3> origins,
                                            std::span<const Vec3> directions)
{
    return cast_all(origins, directions,
                    [&](const Vec3& o, const Vec3& d) { return ray_cast(field, o, d); });
}

std::vector<std::vector<SolidHit>> ray_cast(const Solid& solid, std::span<const Vec3> origins,
                                            std::span<const Vec3> directions)
{
    const LeafFinder leaves(solid);
    const auto cast_at = [&](const auto& cast) {
        return cast_all(origins, directions, [&](const Vec3& o, const Vec3& d) {
            std::vector<SolidHit> hits = cast(o, d);
            for (SolidHit& hit : hits) hit.leaf = leaves.at(hit.point, hit.normal);
            return hits;
        });
    };
    if (has_formula(solid)) {
        const CsgField field(solid);
        return cast_at([&](const Vec3& o, const Vec3& d) { return ray_cast(field, o, d); });
    }
    const SolidSurface surface(solid);
    return cast_at([&](const Vec3& o, const Vec3& d) { return surface.ray_cast(o, d); });
}

}  // namespace genus
