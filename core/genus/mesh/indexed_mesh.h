#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/vec.h"

namespace genus {

using Triangle = std::array<std::int32_t, 3>;

/// The shared-vertex form: triangles as triples of vertex numbers, counterclockwise seen from
/// outside. Plain data with no invariant; `validate` says what holds of it.
///
/// Implements [botsch2010], section 2.1 (indexed face set).
struct IndexedMesh {
    std::vector<Vec3> vertices;
    std::vector<Triangle> faces;

    std::size_t n_vertices() const { return vertices.size(); }
    std::size_t n_faces() const { return faces.size(); }
    bool operator==(const IndexedMesh&) const = default;
};

/// The shared-vertex form with faces of any degree. Face f has the vertices
/// `corners[starts[f]] .. corners[starts[f + 1] - 1]`; `starts` has one entry more than faces.
struct PolygonMesh {
    std::vector<Vec3> vertices;
    std::vector<std::int64_t> starts{0};
    std::vector<std::int32_t> corners;

    std::size_t n_vertices() const { return vertices.size(); }
    std::size_t n_faces() const { return starts.size() - 1; }
    std::span<const std::int32_t> face(std::size_t f) const
    {
        return std::span(corners).subspan(starts[f], starts[f + 1] - starts[f]);
    }
    void add_face(std::span<const std::int32_t> face)
    {
        corners.insert(corners.end(), face.begin(), face.end());
        starts.push_back(static_cast<std::int64_t>(corners.size()));
    }
    bool operator==(const PolygonMesh&) const = default;
};

/// Box round all vertices, empty for a mesh without any.
Box3 bounds(const IndexedMesh& mesh);
Box3 bounds(const PolygonMesh& mesh);

PolygonMesh to_polygons(const IndexedMesh& mesh);

/// Cuts every face into triangles without new vertices. Faces of degree 3 are kept, planar and
/// nearly planar faces are triangulated in their own plane, exactly decided; a face that crosses
/// itself, or of more than 20,000 corners that touches itself, is cut as a fan. Faces with fewer
/// than three corners are dropped. Throws InvalidInput for a vertex number out of range. O(corners)
/// for small faces, O(n log n) for a face of n corners.
IndexedMesh to_triangles(const PolygonMesh& mesh);

}  // namespace genus
