#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// The plainest form: every triangle with its own three points, nothing shared.
struct TriangleList {
    std::vector<std::array<Vec3, 3>> triangles;

    std::size_t n_faces() const { return triangles.size(); }
    /// Bytes held, at so many bytes a coordinate.
    std::size_t memory_bytes(std::size_t bytes_per_coordinate = sizeof(double)) const
    {
        return 9 * bytes_per_coordinate * triangles.size();
    }
    bool operator==(const TriangleList&) const = default;
};

/// Throws InvalidInput for a vertex number out of range.
TriangleList to_triangle_list(const IndexedMesh& mesh);

/// Points with equal coordinates become one vertex, in the order in which they first appear; 0 and
/// -0 are equal. Throws InvalidInput for coordinates that are not finite. O(n) expected.
IndexedMesh to_indexed(const TriangleList& list);

/// Bytes of points and faces in the shared-vertex form.
inline std::size_t memory_bytes(const IndexedMesh& mesh,
                                std::size_t bytes_per_coordinate = sizeof(double))
{
    return 3 * bytes_per_coordinate * mesh.n_vertices() + sizeof(Triangle) * mesh.n_faces();
}

}  // namespace genus
