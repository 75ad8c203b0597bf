#include "genus/polygon/triangulate.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <string>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/polygon/delaunay.h"
#include "genus/polygon/ear_clipping.h"
#include "genus/polygon/sweep.h"

namespace genus {

namespace {

bool before(const Vec2& a, const Vec2& b)
{
    return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
}

double rounded_area(const Ring& ring)
{
    double sum = 0.0;
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
        const Vec2 a = ring[i] - ring[0], b = ring[i + 1] - ring[0];
        sum += a[0] * b[1] - a[1] * b[0];
    }
    return sum;
}

// 1 if the ring turns counterclockwise. The lowest edge at the leftmost point decides, exactly:
// it leaves that point if the inside is above. Edges there and back cancel; where nothing else
// is left at that point, the tip of a spike, the rounded area must do.
int turn_of(const Ring& ring)
{
    struct End {
        Vec2 to;
        int net;  // 1 away from the leftmost point, -1 towards it
    };
    const auto at = std::min_element(ring.begin(), ring.end(), before);
    if (at == ring.end()) return 0;
    const Vec2 leftmost = *at;
    std::vector<End> ends;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vec2 &p = ring[i], &q = ring[i + 1 < ring.size() ? i + 1 : 0];
        if (p == q) continue;
        if (p == leftmost) ends.push_back({q, 1});
        if (q == leftmost) ends.push_back({p, -1});
    }
    const auto lower = [&](const End& a, const End& b) {
        return orient2d(leftmost, a.to, b.to) > 0;
    };
    std::sort(ends.begin(), ends.end(), lower);
    for (std::size_t i = 0; i < ends.size();) {
        int net = 0;
        std::size_t j = i;
        for (; j < ends.size() && !lower(ends[i], ends[j]); ++j) net += ends[j].net;
        if (net != 0) return net > 0 ? 1 : -1;
        i = j;
    }
    const double area = rounded_area(ring);
    return area > 0.0 ? 1 : area < 0.0 ? -1 : 0;
}

std::vector<const Ring*> rings_of(const Polygon& polygon)
{
    std::vector<const Ring*> rings{&polygon.outer};
    for (const Ring& hole : polygon.holes) rings.push_back(&hole);
    return rings;
}

std::vector<OrientedRing> oriented(const std::vector<const Ring*>& rings)
{
    std::vector<OrientedRing> out;
    std::size_t first = 0;
    for (std::size_t r = 0; r < rings.size(); ++r) {
        for (std::size_t i = 0; i < rings[r]->size(); ++i)
            if (!is_finite((*rings[r])[i]))
                throw InvalidInput("triangulate: point " + std::to_string(first + i) +
                                   " is not finite");
        const int turn = turn_of(*rings[r]);
        if (turn == 0)
            throw InvalidInput(
                "triangulate: " +
                (r == 0 ? std::string("the outer ring") : "hole " + std::to_string(r - 1)) +
                ", from point " + std::to_string(first) + " on, has no area");
        out.push_back({*rings[r], (turn > 0) != (r == 0)});
        first += rings[r]->size();
    }
    return out;
}

std::vector<Vec2> points_of(const std::vector<OrientedRing>& rings)
{
    std::vector<Vec2> points;
    for (const OrientedRing& ring : rings)
        points.insert(points.end(), ring.points.begin(), ring.points.end());
    return points;
}

// The rings as point numbers, outer one counterclockwise, holes clockwise, without repeats.
std::vector<std::vector<std::int32_t>> loops_of(const std::vector<OrientedRing>& rings,
                                                const std::vector<std::int32_t>& first_at)
{
    std::vector<std::vector<std::int32_t>> loops;
    auto at = first_at.begin();
    for (const OrientedRing& ring : rings) {
        const auto end = at + static_cast<std::ptrdiff_t>(ring.points.size());
        std::vector<std::int32_t> loop;
        std::unique_copy(at, end, std::back_inserter(loop));
        while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
        if (ring.reversed) std::reverse(loop.begin(), loop.end());
        loops.push_back(std::move(loop));
        at = end;
    }
    return loops;
}

bool have_common_points(const std::vector<std::vector<std::int32_t>>& loops, std::size_t n)
{
    std::vector<std::uint8_t> seen(n, 0);
    for (const std::vector<std::int32_t>& loop : loops)
        for (const std::int32_t p : loop)
            if (seen[p]++) return true;
    return false;
}

// Edges that may have the inside on both sides: only where points share a place.
std::vector<std::array<std::int32_t, 2>> inner_edges(const std::vector<OrientedRing>& rings,
                                                     const std::vector<std::int32_t>& first_at)
{
    std::vector<std::array<std::int32_t, 2>> edges;
    for (std::size_t i = 0; i < first_at.size(); ++i) {
        if (first_at[i] == static_cast<std::int32_t>(i)) continue;
        for (const std::vector<std::int32_t>& loop : loops_of(rings, first_at))
            for (std::size_t k = 0; k < loop.size(); ++k)
                edges.push_back({loop[k], loop[k + 1 < loop.size() ? k + 1 : 0]});
        break;
    }
    return edges;
}

}  // namespace

std::vector<PolygonTriangle> triangulate(const Polygon& polygon, TriangulateMethod method)
{
    constexpr std::size_t kFewPoints = 64;
    const std::vector<OrientedRing> rings = oriented(rings_of(polygon));
    // The sweep also checks the polygon, for all methods.
    SweepTriangulation sweep = sweep_triangulation(rings);
    const std::size_t n = sweep.first_at.size();
    if (method == TriangulateMethod::Sweep) return std::move(sweep.triangles);
    if (method == TriangulateMethod::Auto && n > kFewPoints) return std::move(sweep.triangles);
    if (method == TriangulateMethod::Delaunay) {
        make_delaunay(points_of(rings), sweep.triangles, inner_edges(rings, sweep.first_at));
        return std::move(sweep.triangles);
    }
    const std::vector<std::vector<std::int32_t>> loops = loops_of(rings, sweep.first_at);
    if (have_common_points(loops, n)) return std::move(sweep.triangles);
    auto cut = cut_corners(points_of(rings), loops);
    return cut ? *std::move(cut) : std::move(sweep.triangles);
}

}  // namespace genus
