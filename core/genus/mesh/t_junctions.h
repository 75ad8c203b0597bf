#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// A vertex that lies within an edge of one face, from which the face does not turn.
struct TJunction {
    std::int32_t side;  // 3 f + i: the edge from corner i of face f to the next
    double along;       // where on it, between 0 and 1
    std::int32_t vertex;
    auto operator<=>(const TJunction&) const = default;
};

/// All of them, by side, then place: vertices that have an open edge themselves and lie on another
/// one, no farther from it than `tolerance`, with 0 exactly on it. O(n log n) for n open edges
/// beside finding those, O(F). Throws InvalidInput for a vertex number out of range or, where
/// there are open edges, a coordinate of one that is not finite.
std::vector<TJunction> find_t_junctions(const IndexedMesh& mesh, double tolerance = 0.0);

}  // namespace genus
