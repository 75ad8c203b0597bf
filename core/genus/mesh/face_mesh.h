#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "genus/mesh/handles.h"
#include "genus/mesh/indexed_mesh.h"
#include "genus/mesh/point_table.h"

namespace genus {

/// The face-based form: each triangle knows its three corners and its three neighbours, each
/// vertex one of its faces. Neighbour i lies across the side from corner i to the next; none (-1)
/// on the boundary.
class FaceMesh {
public:
    FaceMesh() = default;
    /// O(F) expected. Throws InvalidInput for a vertex number out of range, a face with a vertex
    /// twice, and where two faces run along an edge in the same direction.
    explicit FaceMesh(const IndexedMesh& mesh);

    std::size_t n_vertices() const { return mesh_.vertices.size(); }
    std::size_t n_faces() const { return mesh_.faces.size(); }
    const IndexedMesh& indexed() const { return mesh_; }
    /// By face and by vertex, for bulk work; -1 is none.
    const std::vector<std::array<std::int32_t, 3>>& neighbours() const { return neighbours_; }
    const std::vector<std::int32_t>& vertex_faces() const { return vertex_face_; }
    const Vec3& point(Vertex v) const { return mesh_.vertices[v.index]; }
    Vertex corner(Face f, std::size_t i) const { return Vertex(mesh_.faces[f.index][i]); }
    Face neighbour(Face f, std::size_t i) const { return Face(neighbours_[f.index][i]); }
    /// One of the faces at v: on the boundary the one from which turning counterclockwise meets
    /// all of its fan. None for an isolated vertex.
    Face face(Vertex v) const { return Face(vertex_face_[v.index]); }

    /// Calls `visit(Face)` for the faces of the fan of v, counterclockwise.
    template <class Visit>
    void visit_faces(Vertex v, Visit&& visit) const
    {
        const Face first = face(v);
        for (Face f = first; f.valid();) {
            visit(f);
            f = neighbour(f, (corner_number(f, v) + 2) % 3);
            if (f == first) break;
        }
    }

    /// Bytes held, at so many bytes a coordinate.
    std::size_t memory_bytes(std::size_t bytes_per_coordinate = sizeof(double)) const;

private:
    friend class FaceMeshBuilder;
    std::size_t corner_number(Face f, Vertex v) const
    {
        const Triangle& t = mesh_.faces[f.index];
        return t[0] == v.index ? 0 : t[1] == v.index ? 1 : 2;
    }
    void choose_vertex_faces();

    IndexedMesh mesh_;
    std::vector<std::array<std::int32_t, 3>> neighbours_;
    std::vector<std::int32_t> vertex_face_;
};

/// Builds the face-based form from triangles as they come, in O(1) expected each: a side whose
/// opposite is open is connected to it, else it is remembered as open; what stays open is the
/// boundary. Where more than two faces meet in an edge they are connected two by two, in the order
/// of arrival.
class FaceMeshBuilder {
public:
    /// Equal points are one vertex. Throws InvalidInput, and stays as it was, if a point is
    /// not finite, two are equal, or a side is open already in the same direction.
    void add(const std::array<Vec3, 3>& triangle);
    std::size_t n_open_sides() const { return open_.size(); }
    /// Ends the building.
    FaceMesh finish();

private:
    friend class FaceMesh;
    void add(const Triangle& t);

    FaceMesh mesh_;
    PointTable points_;
    std::unordered_map<std::uint64_t, std::int32_t> open_;  // directed edge to side 3 f + i
};

}  // namespace genus
