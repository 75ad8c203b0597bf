#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "genus/boolean/exact_point.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus::exact {

/// A convex polygon cut into cells, with corners numbered as the polygon's.
struct PolygonCells {
    std::vector<Triangle> corners;  // counterclockwise
    std::vector<Triangle> across;   // the cell across edge i, from corner i on; -1 on sides, chords
};

/// Two places of a polygon.
using Chord = std::array<std::int32_t, 2>;

/// Triangulates a convex polygon, on the sides of which points may lie, so that all points and
/// chords are kept: what most faces that are cut come to. `points` go round counterclockwise as
/// their plane is seen along `axis`, from its negative end if `flipped`. Between its chords the
/// triangulation is Delaunay as far as rounding can tell; that no cell is flat or turned over is
/// decided exactly. Nothing if chords cross or lie along a side.
///
/// O(points^2) mostly; meant for few.
std::optional<PolygonCells> cut_by_chords(int axis, bool flipped, std::span<const PointRef> points,
                                          std::span<const Chord> chords);

}  // namespace genus::exact
