#include "genus/polygon/region.h"

#include <algorithm>
#include <cmath>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/transform.h"
#include "genus/polygon/planar_arrangement.h"

namespace genus {

namespace {

using Winding = PlanarArrangement::Winding;
using RingViews = std::vector<std::span<const Vec2>>;

constexpr int kMostFragments = 1 << 20;

void append(RingViews& views, const Region& region)
{
    for (const Ring& ring : region.rings) views.emplace_back(ring);
}

bool accepts(FillRule rule, std::int32_t turns)
{
    switch (rule) {
        case FillRule::NonZero:
            return turns != 0;
        case FillRule::EvenOdd:
            return turns % 2 != 0;
        case FillRule::Positive:
            return turns > 0;
    }
    return false;
}

// The line at `distance` to the right of a ring, with a join at every corner. At inner corners it
// loops back on itself; the loops turn the other way and vanish under the positive fill rule.
class OffsetLine {
public:
    OffsetLine(const Ring& ring, double distance, const OffsetOptions& options)
        : distance_(distance), options_(options)
    {
        for (const Vec2& p : ring)
            if (corners_.empty() || p != corners_.back()) corners_.push_back(p);
        while (corners_.size() > 1 && corners_.front() == corners_.back()) corners_.pop_back();
    }

    Ring make()
    {
        const std::size_t n = corners_.size();
        if (n < 3) return {};
        for (std::size_t i = 0; i < n; ++i)
            join(corners_[i], normal(corners_[(i + n - 1) % n], corners_[i]),
                 normal(corners_[i], corners_[(i + 1) % n]));
        return std::move(line_);
    }

private:
    // Unit normal to the right of a -> b: outward for a counterclockwise ring.
    static Vec2 normal(const Vec2& a, const Vec2& b)
    {
        const Vec2 d = b - a;
        const double length = std::hypot(d[0], d[1]);
        return {{d[1] / length, -d[0] / length}};
    }

    void add(const Vec2& corner, const Vec2& direction, double factor)
    {
        line_.push_back(corner + direction * factor);
    }

    void join(const Vec2& corner, const Vec2& before, const Vec2& after)
    {
        const double sine = before[0] * after[1] - before[1] * after[0];
        const double cosine = dot(before, after);
        if (sine < 0.0) {  // an inner corner: through the corner itself, so that no gap opens
            add(corner, before, distance_);
            line_.push_back(corner);
            add(corner, after, distance_);
        } else if (options_.join == JoinStyle::Round) {
            round(corner, before, after, std::atan2(sine, cosine));
        } else if (options_.join == JoinStyle::Miter &&
                   2.0 <= options_.miter_limit * options_.miter_limit * (1.0 + cosine)) {
            add(corner, before + after, distance_ / (1.0 + cosine));
        } else {
            chamfer(corner, before, after, std::atan2(sine, cosine));
        }
    }

    // Chords of an arc. Where their number lies half-way, as of a right angle by sixths of a
    // circle, rounding decides: they are counted by way of the sagitta, so that OpenSCAD's number
    // comes out.
    int chords(double angle) const
    {
        const double half = std::acos(1.0 - (1.0 - cos_degrees(180.0 / options_.fragments)));
        return static_cast<int>(0.5 / half * angle + 0.5);
    }

    void round(const Vec2& corner, const Vec2& before, const Vec2& after, double angle)
    {
        const double step = 360.0 / options_.fragments;
        const int steps = chords(angle);
        for (int k = 0; k < std::max(steps, 1); ++k) {
            const double c = cos_degrees(k * step), s = sin_degrees(k * step);
            add(corner, {{c * before[0] - s * before[1], s * before[0] + c * before[1]}},
                distance_);
        }
        add(corner, after, distance_);
    }

    // Square at the distance: the cut touches the circle round the corner half-way.
    void chamfer(const Vec2& corner, const Vec2& before, const Vec2& after, double angle)
    {
        const double t = std::tan(angle / 4.0);
        add(corner, {{before[0] - before[1] * t, before[1] + before[0] * t}}, distance_);
        add(corner, {{after[0] + after[1] * t, after[1] - after[0] * t}}, distance_);
    }

    double distance_;
    const OffsetOptions& options_;
    std::vector<Vec2> corners_;
    Ring line_;
};

std::vector<Ring> offset_lines(const Region& region, double distance, const OffsetOptions& options,
                               bool reversed)
{
    std::vector<Ring> lines;
    for (Ring ring : region.rings) {
        if (reversed) std::reverse(ring.begin(), ring.end());
        lines.push_back(OffsetLine(ring, distance, options).make());
    }
    return lines;
}

// Twice the signed area, relative to the first corner so that far rings keep their digits.
double doubled_area(const Ring& ring)
{
    double sum = 0.0;
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
        const Vec2 a = ring[i] - ring[0], b = ring[i + 1] - ring[0];
        sum += a[0] * b[1] - a[1] * b[0];
    }
    return sum;
}

enum class Place { Outside, Border, Inside };

// Crossings of the ray to the right of p with the ring, decided exactly.
Place place_in_ring(const Ring& ring, const Vec2& p)
{
    bool inside = false;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
        const bool a_above = a[1] > p[1], b_above = b[1] > p[1];
        if (a_above == b_above) {
            const bool level = a[1] == p[1] && b[1] == p[1];
            if (level && std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]))
                return Place::Border;
            if (p == a || p == b) return Place::Border;
            continue;
        }
        const int turn = orient2d(a, b, p);
        if (turn == 0) return Place::Border;
        if ((turn > 0) == b_above) inside = !inside;
    }
    return inside ? Place::Inside : Place::Outside;
}

// Rings of a region touch in points only, so some corner or the middle of some side decides.
bool lies_in(const Ring& inner, const Ring& outer)
{
    for (const Vec2& p : inner) {
        const Place place = place_in_ring(outer, p);
        if (place != Place::Border) return place == Place::Inside;
    }
    for (std::size_t i = 0; i < inner.size(); ++i) {
        const Vec2 middle = 0.5 * inner[i] + 0.5 * inner[(i + 1) % inner.size()];
        const Place place = place_in_ring(outer, middle);
        if (place != Place::Border) return place == Place::Inside;
    }
    return false;
}

}  // namespace

Region make_region(std::span<const Ring> rings, FillRule rule)
{
    RingViews views;
    for (const Ring& ring : rings) views.emplace_back(ring);
    const PlanarArrangement arrangement({std::move(views), RingViews{}});
    return {arrangement.border([rule](const Winding& w) { return accepts(rule, w[0]); })};
}

Region unite(std::span<const Region> regions)
{
    RingViews views;
    for (const Region& region : regions) append(views, region);
    const PlanarArrangement arrangement({std::move(views), RingViews{}});
    return {arrangement.border([](const Winding& w) { return w[0] > 0; })};
}

Region intersect(std::span<const Region> regions)
{
    if (regions.empty()) return {};
    RingViews views;
    for (const Region& region : regions) append(views, region);
    const PlanarArrangement arrangement({std::move(views), RingViews{}});
    const auto all = static_cast<std::int32_t>(regions.size());
    return {arrangement.border([all](const Winding& w) { return w[0] == all; })};
}

Region subtract(std::span<const Region> regions)
{
    if (regions.empty()) return {};
    RingViews first, others;
    append(first, regions[0]);
    for (const Region& region : regions.subspan(1)) append(others, region);
    const PlanarArrangement arrangement({std::move(first), std::move(others)});
    return {arrangement.border([](const Winding& w) { return w[0] > 0 && w[1] == 0; })};
}

Region offset(const Region& region, double distance, const OffsetOptions& options)
{
    require(std::isfinite(distance), "offset: distance", distance, "finite");
    require(options.fragments >= 3 && options.fragments <= kMostFragments, "offset: fragments",
            options.fragments, "between 3 and 1048576");
    if (distance == 0.0) return region;
    // Shrinking is growing the outside: the rings turned round, with one turn everywhere on top.
    const bool shrink = distance < 0.0;
    const auto lines = offset_lines(region, std::fabs(distance), options, shrink);
    RingViews views;
    for (const Ring& line : lines) views.emplace_back(line);
    const PlanarArrangement arrangement({std::move(views), RingViews{}});
    return {arrangement.border(
        [shrink](const Winding& w) { return shrink ? w[0] + 1 <= 0 : w[0] > 0; })};
}

Ring convex_hull(std::span<const Vec2> points)
{
    for (const Vec2& p : points) require(is_finite(p), "convex_hull: a point is not finite");
    std::vector<Vec2> sorted(points.begin(), points.end());
    const auto before = [](const Vec2& a, const Vec2& b) {
        return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
    };
    std::sort(sorted.begin(), sorted.end(), before);
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    Ring hull;
    const auto add_chain = [&hull](auto begin, auto end) {
        const std::size_t base = hull.size();
        for (auto p = begin; p != end; ++p) {
            while (hull.size() >= base + 2 && orient2d(hull[hull.size() - 2], hull.back(), *p) <= 0)
                hull.pop_back();
            hull.push_back(*p);
        }
        hull.pop_back();  // the first point of the other chain
    };
    if (sorted.size() < 3) return {};
    add_chain(sorted.begin(), sorted.end());
    add_chain(sorted.rbegin(), sorted.rend());
    return hull.size() >= 3 ? hull : Ring{};
}

double area(const Ring& ring)
{
    return 0.5 * doubled_area(ring);
}

double area(const Region& region)
{
    double sum = 0.0;
    for (const Ring& ring : region.rings) sum += area(ring);
    return sum;
}

Box2 bounds(const Region& region)
{
    Box2 box;
    for (const Ring& ring : region.rings)
        for (const Vec2& p : ring) box.add(p);
    return box;
}

std::vector<Polygon> polygons(const Region& region)
{
    struct Outer {
        const Ring* ring;
        Box2 box;
        double area;
        std::size_t polygon;
    };
    const auto box_of = [](const Ring& ring) {
        Box2 box;
        for (const Vec2& p : ring) box.add(p);
        return box;
    };
    std::vector<Polygon> result;
    std::vector<Outer> outers;
    for (const Ring& ring : region.rings)
        if (const double size = area(ring); size > 0.0) {
            outers.push_back({&ring, box_of(ring), size, result.size()});
            result.push_back({ring, {}});
        }
    // A hole belongs to the smallest ring round it.
    std::sort(outers.begin(), outers.end(), [](const Outer& a, const Outer& b) {
        return a.area != b.area ? a.area < b.area : a.polygon < b.polygon;
    });
    for (const Ring& ring : region.rings) {
        const double size = area(ring);
        if (size >= 0.0) continue;
        const Box2 box = box_of(ring);
        for (const Outer& outer : outers) {
            if (outer.area < -size || !outer.box.contains(box)) continue;
            if (!lies_in(ring, *outer.ring)) continue;
            result[outer.polygon].holes.push_back(ring);
            break;
        }
    }
    return result;
}

bool contains(const Region& region, const Vec2& p)
{
    int turns = 0;
    for (const Ring& ring : region.rings) {
        const Place place = place_in_ring(ring, p);
        if (place == Place::Border) return true;
        if (place == Place::Inside) turns += area(ring) > 0.0 ? 1 : -1;
    }
    return turns > 0;
}

}  // namespace genus
