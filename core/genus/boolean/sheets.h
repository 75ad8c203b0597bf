#pragma once

#include <cstdint>
#include <vector>

#include "genus/boolean/arrangement.h"

namespace genus::exact {

/// One side of a directed edge: a piece of surface that ends there.
struct Sheet {
    std::uint64_t edge;  // the numbers of both points, lower one first
    std::int32_t item;   // whatever the caller numbers
    std::int32_t plane;  // a face of the soup in the same plane
    bool flipped;        // the sheet turns against that face
    bool forward;        // the sheet turns along the edge from the lower to the higher number
};

std::uint64_t edge_key(std::int32_t a, std::int32_t b);

/// Sorts the sheets of one edge counterclockwise round it, looking against the edge from the
/// lower to the higher number, starting at the first. Exact. Throws Error if two of them
/// coincide.
void sort_round_edge(const Soup& soup, const std::vector<PointRef>& points, Sheet* begin,
                     Sheet* end);

/// True if the planes of the faces are parallel. Exact.
bool parallel_faces(const Soup& soup, std::int32_t f, std::int32_t g);

/// Sorts by edge, then item, then direction.
void sort_sheets(std::vector<Sheet>& sheets);

}  // namespace genus::exact
