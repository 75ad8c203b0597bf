#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "genus/polygon/polygon.h"

namespace genus {

/// Edges of several operands, snapped to a common grid and cut at all their crossings, so that two
/// edges share end points or nothing; with the winding numbers of two channels on both sides.
/// The workhorse of region.h, which tells its method.
class PlanarArrangement {
public:
    /// Winding numbers of channels 0 and 1 at a point.
    using Winding = std::array<std::int32_t, 2>;

    /// `rings[channel]` are the rings counted in that channel.
    explicit PlanarArrangement(const std::array<std::vector<std::span<const Vec2>>, 2>& rings);

    /// The border of the points that `inside` accepts, as rings with the inside on the left.
    std::vector<Ring> border(const std::function<bool(const Winding&)>& inside) const;

private:
    struct Point {
        std::int64_t x, y;
        bool operator==(const Point&) const = default;
        auto operator<=>(const Point&) const = default;
    };
    // A piece of an input edge between two vertices, from the lexicographically smaller to the
    // larger; `turns` is what the winding numbers grow by from below to above.
    struct Edge {
        std::int32_t from, to;
        std::int32_t source;  // input edge, or -1 where several coincide
        Winding turns;
        Winding below;
    };
    // Original coordinates of snapped ones, sorted.
    struct Coordinate {
        std::int64_t snapped;
        double original;
    };

    void snap(const std::array<std::vector<std::span<const Vec2>>, 2>& rings);
    void cut_until_no_two_cross();
    bool cut_once();
    void snap_to_squares();
    /// Cuts edges at vertices: pairs of both, in any order.
    void split(std::vector<std::pair<std::int32_t, std::int32_t>>& cuts);
    bool passes_square(const Edge& e, const Point& r) const;
    Point rounded_crossing(const Edge& a, const Edge& b) const;
    void merge_coincident();
    void sweep();
    int side(const Edge& edge, const Point& p) const;
    std::int32_t vertex(const Point& p);
    std::vector<std::vector<std::int32_t>> trace(const std::vector<Edge>& kept) const;
    std::vector<std::int32_t> without_flat_corners(const std::vector<std::int32_t>& ring,
                                                   const std::vector<std::int32_t>& n_rings) const;
    Ring to_ring(const std::vector<std::int32_t>& ring, bool original) const;
    double coordinate(std::int64_t snapped, int axis, bool original) const;

    Vec2 origin_{};
    int exponent_ = 0;  // a grid step is 2^-exponent_
    std::vector<Point> points_;
    std::vector<bool> is_input_;
    std::vector<Edge> edges_;
    std::array<std::vector<Coordinate>, 2> originals_;
};

/// True if two of the edges of the rings cross or overlap; touching in points is no crossing.
/// Exact on doubles.
bool rings_cross(std::span<const Ring> rings);

}  // namespace genus
