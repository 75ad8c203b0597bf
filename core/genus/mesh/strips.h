#pragma once

#include <cstdint>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// Triangles in strips: three neighbouring points of a strip are a triangle, every other one of
/// them turned over. Strip s has the points `points[starts[s]] .. points[starts[s + 1] - 1]`.
struct TriangleStrips {
    std::vector<Vec3> points;
    std::vector<std::int32_t> starts{0};

    std::size_t n_strips() const { return starts.size() - 1; }
    std::size_t n_faces() const { return points.size() - 2 * n_strips(); }
    double triangles_per_strip() const
    {
        return n_strips() > 0 ? static_cast<double>(n_faces()) / static_cast<double>(n_strips())
                              : 0;
    }
    /// Bytes held, at so many bytes a coordinate.
    std::size_t memory_bytes(std::size_t bytes_per_coordinate = sizeof(double)) const
    {
        return 3 * bytes_per_coordinate * points.size() + sizeof(std::int32_t) * starts.size();
    }
};

/// Greedy: begins where the fewest neighbours are left, in the direction in which the strip gets
/// longest. All faces are kept as they turn, whatever the topology. O(F). Throws InvalidInput
/// for a vertex number out of range or more than 2^30 faces.
///
/// Implements [evans1996], section 3 (local choice by least adjacency), with strips tried ahead.
TriangleStrips to_strips(const IndexedMesh& mesh);

/// Strip by strip; equal points become one vertex, see triangle_list.h.
IndexedMesh to_indexed(const TriangleStrips& strips);

}  // namespace genus
