#pragma once

#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/polygon/polygon.h"

namespace genus {

/// A closed part of the plane. Rings do not cross each other or themselves, they may touch in
/// points; what lies inside is on their left, so outer rings turn counterclockwise and holes
/// clockwise. Every function below takes regions of this kind and returns one.
struct Region {
    std::vector<Ring> rings;

    bool empty() const { return rings.empty(); }
    bool operator==(const Region&) const = default;
};

/// Which points are inside when rings overlap, by the number of turns round them.
enum class FillRule { NonZero, EvenOdd, Positive };

/// The region that any rings describe: crossing, overlapping, touching, repeated, of any
/// orientation. Rings that enclose no area vanish.
///
/// Coordinates are snapped once to a grid of about 2^40 steps across; crossings are computed
/// exactly and rounded to the grid until no two edges cross, so no later decision is rounded.
/// Coordinates that came in go out with the same bits. Throws InvalidInput for coordinates that
/// are not finite. O((n + k) log n) for n edges with k crossings, where boxes separate the edges.
///
/// Implements [hobby1999] (rounding of crossings, here repeated until stable) and
/// [bentley1979], section 3 (sweep), on edges that no longer cross.
Region make_region(std::span<const Ring> rings, FillRule rule = FillRule::NonZero);

/// What any, all, or the first but no other of the regions cover; by the method of make_region,
/// all operands at once.
Region unite(std::span<const Region> regions);
Region intersect(std::span<const Region> regions);
Region subtract(std::span<const Region> regions);

enum class JoinStyle {
    Round,   ///< arcs; grows or shrinks by exactly the distance up to their facets
    Miter,   ///< straight edges prolonged until they meet
    Chamfer  ///< prolonged, then cut off square at the distance
};

struct OffsetOptions {
    JoinStyle join = JoinStyle::Round;
    int fragments = 32;        // sides of a full circle of round joins
    double miter_limit = 1e6;  // longest miter, in distances; a chamfer beyond
};

/// All points within `distance` of the region; for a negative distance all points of the region
/// that far inside it. Throws InvalidInput if `distance` is not finite or fragments < 3.
Region offset(const Region& region, double distance, const OffsetOptions& options = {});

/// The smallest convex ring that holds the points, counterclockwise, without flat corners; empty
/// if they lie on one line. Exact decisions. O(n log n).
///
/// Implements [andrew1979].
Ring convex_hull(std::span<const Vec2> points);

/// Signed area of a ring, positive counterclockwise.
double area(const Ring& ring);
double area(const Region& region);
Box2 bounds(const Region& region);

/// Each outer ring with the holes that lie in it, for triangulation. A ring of a region that
/// touches itself stays one ring.
std::vector<Polygon> polygons(const Region& region);

/// True if p is inside or on the border, decided exactly.
bool contains(const Region& region, const Vec2& p);

}  // namespace genus
