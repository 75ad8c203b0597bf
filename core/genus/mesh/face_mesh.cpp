#include "genus/mesh/face_mesh.h"

#include <string>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/mesh/sides.h"

namespace genus {

namespace {

std::uint64_t key(std::int32_t from, std::int32_t to)
{
    return static_cast<std::uint64_t>(from) << 32 | static_cast<std::uint32_t>(to);
}

}  // namespace

void FaceMeshBuilder::add(const Triangle& t)
{
    std::vector<Triangle>& faces = mesh_.mesh_.faces;
    const auto face = static_cast<std::int32_t>(faces.size());
    require(face < (1 << 29), "face-based form: more than 2^29 faces");
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
        throw InvalidInput("face-based form: face " + std::to_string(face) + " has a vertex twice");
    for (std::size_t i = 0; i < 3; ++i) {
        const auto open = open_.find(key(t[i], t[(i + 1) % 3]));
        if (open == open_.end()) continue;
        throw InvalidInput("face-based form: faces " + std::to_string(open->second / 3) + " and " +
                           std::to_string(face) + " run the same way from vertex " +
                           std::to_string(t[i]) + " to " + std::to_string(t[(i + 1) % 3]));
    }
    faces.push_back(t);
    mesh_.neighbours_.push_back({-1, -1, -1});
    for (std::int32_t i = 0; i < 3; ++i) {
        const std::int32_t from = t[i], to = t[(i + 1) % 3];
        const auto opposite = open_.find(key(to, from));
        if (opposite == open_.end()) {
            open_[key(from, to)] = 3 * face + i;
            continue;
        }
        const std::int32_t other = opposite->second;
        mesh_.neighbours_[face][i] = other / 3;
        mesh_.neighbours_[other / 3][other % 3] = face;
        open_.erase(opposite);
    }
    if (face % 4096 == 0) current_progress().check();
}

void FaceMeshBuilder::add(const std::array<Vec3, 3>& triangle)
{
    const std::int32_t a = points_.find_or_add(triangle[0]), b = points_.find_or_add(triangle[1]);
    add(Triangle{a, b, points_.find_or_add(triangle[2])});
}

FaceMesh FaceMeshBuilder::finish()
{
    mesh_.mesh_.vertices = points_.take_points();
    mesh_.choose_vertex_faces();
    open_.clear();
    points_ = {};
    return std::exchange(mesh_, {});
}

FaceMesh::FaceMesh(const IndexedMesh& mesh)
{
    check_indices(TriangleSides(mesh), mesh.n_vertices());
    FaceMeshBuilder builder;
    for (const Triangle& t : mesh.faces) builder.add(t);
    *this = std::move(builder.mesh_);
    mesh_.vertices = mesh.vertices;
    choose_vertex_faces();
}

// On the boundary the face whose side from the vertex on is open.
void FaceMesh::choose_vertex_faces()
{
    vertex_face_.assign(n_vertices(), -1);
    for (std::size_t f = 0; f < n_faces(); ++f)
        for (std::size_t i = 0; i < 3; ++i) {
            std::int32_t& face = vertex_face_[mesh_.faces[f][i]];
            if (face < 0 || neighbours_[f][i] < 0) face = static_cast<std::int32_t>(f);
        }
}

std::size_t FaceMesh::memory_bytes(std::size_t bytes_per_coordinate) const
{
    constexpr std::size_t kLink = sizeof(std::int32_t);
    return 3 * bytes_per_coordinate * n_vertices() + kLink * vertex_face_.size() +
           kLink * 3 * (mesh_.faces.size() + neighbours_.size());
}

}  // namespace genus
