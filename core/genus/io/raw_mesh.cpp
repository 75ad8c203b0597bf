#include "genus/io/raw_mesh.h"

#include <cassert>
#include <utility>

namespace genus::io {

void FaceList::make_polygonal()
{
    starts_.reserve(triangles_.size() + 2);
    corners_.reserve(3 * triangles_.size() + 16);
    for (const Triangle& face : triangles_) {
        starts_.push_back(static_cast<std::int64_t>(corners_.size()));
        corners_.insert(corners_.end(), face.begin(), face.end());
    }
    starts_.push_back(static_cast<std::int64_t>(corners_.size()));
    triangles_ = {};
    polygonal_ = true;
}

void FaceList::add_polygon(std::span<const std::int32_t> face)
{
    if (!polygonal_) make_polygonal();
    corners_.insert(corners_.end(), face.begin(), face.end());
    starts_.push_back(static_cast<std::int64_t>(corners_.size()));
}

void FaceList::append(const FaceList& other)
{
    if (!polygonal_ && !other.polygonal_) {
        triangles_.insert(triangles_.end(), other.triangles_.begin(), other.triangles_.end());
        return;
    }
    if (!polygonal_) make_polygonal();
    if (!other.polygonal_) {
        for (const Triangle& face : other.triangles_) add_polygon(face);
        return;
    }
    const auto offset = static_cast<std::int64_t>(corners_.size());
    corners_.insert(corners_.end(), other.corners_.begin(), other.corners_.end());
    for (std::size_t f = 1; f < other.starts_.size(); ++f)
        starts_.push_back(offset + other.starts_[f]);
}

void FaceList::move_to(PolygonMesh& mesh) &&
{
    if (!polygonal_) make_polygonal();
    mesh.starts = std::move(starts_);
    mesh.corners = std::move(corners_);
}

MeshFile to_mesh_file(RawMesh&& raw)
{
    MeshFile file;
    file.mesh.vertices = std::move(raw.vertices);
    std::move(raw.faces).move_to(file.mesh);
    file.vertex_colors = std::move(raw.vertex_colors);
    file.face_colors = std::move(raw.face_colors);
    file.unit = raw.unit;
    if (!file.vertex_colors.empty()) file.vertex_colors.resize(file.mesh.n_vertices());
    if (!file.face_colors.empty()) file.face_colors.resize(file.mesh.n_faces());
    return file;
}

IndexedMesh to_indexed_mesh(RawMesh&& raw)
{
    if (!raw.faces.all_triangles()) {
        PolygonMesh polygons;
        polygons.vertices = std::move(raw.vertices);
        std::move(raw.faces).move_to(polygons);
        return to_triangles(polygons);
    }
    IndexedMesh mesh;
    mesh.vertices = std::move(raw.vertices);
    mesh.faces = std::move(raw.faces).take_triangles();
    return mesh;
}

ColoredTriangles to_colored_triangles(const MeshFile& file)
{
    ColoredTriangles triangles;
    triangles.faces = to_triangles(file.mesh).faces;
    if (file.face_colors.empty()) return triangles;
    triangles.colors.reserve(triangles.faces.size());
    // Every face of n corners became n - 2 triangles, in its place.
    for (std::size_t f = 0; f < file.mesh.n_faces(); ++f)
        triangles.colors.insert(triangles.colors.end(), file.mesh.face(f).size() - 2,
                                file.face_colors[f]);
    assert(triangles.colors.size() == triangles.faces.size());
    return triangles;
}

}  // namespace genus::io
