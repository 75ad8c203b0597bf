#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "genus/io/mesh_file.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus::io {

/// Faces in the order in which they are read. As long as all are triangles they are held as
/// triangles, so that the usual file becomes an IndexedMesh without another pass.
class FaceList {
public:
    FaceList() = default;
    explicit FaceList(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {}

    std::size_t size() const { return polygonal_ ? starts_.size() - 1 : triangles_.size(); }
    std::size_t n_corners() const { return polygonal_ ? corners_.size() : 3 * triangles_.size(); }
    bool all_triangles() const { return !polygonal_; }

    void reserve_triangles(std::size_t n) { triangles_.reserve(n); }
    void add(const Triangle& face)
    {
        if (polygonal_)
            add_polygon(face);
        else
            triangles_.push_back(face);
    }
    void add(std::span<const std::int32_t> face)
    {
        if (face.size() == 3)
            add(Triangle{face[0], face[1], face[2]});
        else
            add_polygon(face);
    }
    void append(const FaceList& other);

    /// Corner `i` of all corners in order of the faces.
    std::int32_t& corner(std::size_t i)
    {
        return polygonal_ ? corners_[i] : triangles_[i / 3][i % 3];
    }

    std::vector<Triangle> take_triangles() && { return std::move(triangles_); }
    /// Puts the faces into `mesh`, which has none.
    void move_to(PolygonMesh& mesh) &&;

private:
    void add_polygon(std::span<const std::int32_t> face);
    void make_polygonal();

    std::vector<Triangle> triangles_;
    std::vector<std::int64_t> starts_;
    std::vector<std::int32_t> corners_;
    bool polygonal_ = false;
};

/// What the readers of the formats give.
struct RawMesh {
    std::vector<Vec3> vertices;
    FaceList faces;
    std::vector<Rgba> vertex_colors;
    std::vector<Rgba> face_colors;
    double unit = 0.0;  // in millimetres; 0 where the file does not say
};

MeshFile to_mesh_file(RawMesh&& raw);
IndexedMesh to_indexed_mesh(RawMesh&& raw);

/// The faces of a mesh cut into triangles, which take over the colour of their face.
struct ColoredTriangles {
    std::vector<Triangle> faces;
    std::vector<Rgba> colors;  // empty where the faces have none
};
ColoredTriangles to_colored_triangles(const MeshFile& file);

/// Adds `color` for element `index` to a list that stays empty until the first colour comes;
/// elements passed over are white.
inline void add_color(std::vector<Rgba>& colors, std::size_t index, Rgba color)
{
    colors.resize(index);
    colors.push_back(color);
}

}  // namespace genus::io
