#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "genus/base/vec.h"

namespace genus {

/// Closed sequence of points; the last is joined to the first and not repeated.
using Ring = std::vector<Vec2>;

/// A ring as it is, or read from back to front.
struct OrientedRing {
    std::span<const Vec2> points;
    bool reversed = false;
};

/// A region of the plane: the inside of `outer` less the insides of `holes`. Either orientation
/// of the rings will do.
struct Polygon {
    Ring outer;
    std::vector<Ring> holes;
};

/// Three point numbers of a polygon: outer ring first, then the holes one after the other.
using PolygonTriangle = std::array<std::int32_t, 3>;

}  // namespace genus
