#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "genus/mesh/halfedge_mesh.h"

namespace genus {

/// The neighbours of all vertices: those of vertex v are `vertices[starts[v]] ..
/// vertices[starts[v + 1] - 1]`, counterclockwise.
struct OneRings {
    std::vector<std::int64_t> starts{0};
    std::vector<std::int32_t> vertices;
};

/// O(V + E). Vertices that are dead or isolated have none.
OneRings one_rings(const HalfedgeMesh& mesh);
OneRings one_rings(const TriangleHalfedgeMesh& mesh);

/// For each vertex the sum of its neighbours' values, `width` numbers each. The same bits at
/// any thread count. Throws InvalidInput unless there are `width` values for each vertex slot.
std::vector<double> ring_sums(const HalfedgeMesh& mesh, std::span<const double> values,
                              std::size_t width);
std::vector<double> ring_sums(const TriangleHalfedgeMesh& mesh, std::span<const double> values,
                              std::size_t width);

}  // namespace genus
