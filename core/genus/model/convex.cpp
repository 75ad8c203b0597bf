#include "genus/model/convex.h"

#include <algorithm>
#include <cmath>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"

namespace genus {
namespace {

/// Newell's normal, twice the area long, taken about the first corner.
Vec3 face_normal(const PolygonMesh& mesh, std::size_t f)
{
    const auto face = mesh.face(f);
    Vec3 n;
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
        n += cross(mesh.vertices[face[i]] - mesh.vertices[face[0]],
                   mesh.vertices[face[i + 1]] - mesh.vertices[face[0]]);
    return n;
}

[[noreturn]] void refuse(const std::string& name, std::size_t face, const char* what)
{
    throw InvalidInput(name + ": face " + std::to_string(face) + " " + what);
}

/// Every directed edge once, and its opposite once.
void require_closed(const PolygonMesh& mesh, const std::string& name)
{
    struct Edge {
        std::int32_t from, to;
        std::size_t face;
    };
    std::vector<Edge> edges;
    edges.reserve(mesh.corners.size());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        for (std::size_t i = 0; i < face.size(); ++i)
            edges.push_back({face[i], face[(i + 1) % face.size()], f});
    }
    const auto before = [](const Edge& a, const Edge& b) {
        return std::pair(a.from, a.to) < std::pair(b.from, b.to);
    };
    std::sort(edges.begin(), edges.end(), before);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const Edge& e = edges[i];
        if (i > 0 && edges[i - 1].from == e.from && edges[i - 1].to == e.to)
            refuse(name, e.face, "uses an edge in the same direction as another face");
        if (!std::binary_search(edges.begin(), edges.end(), Edge{e.to, e.from, 0}, before))
            refuse(name, e.face, "has an open edge");
    }
}

/// A corner triangle of the face that is as large as three evenly spread corners make it.
std::array<Vec3, 3> spread_corners(const PolygonMesh& mesh, std::size_t f)
{
    const auto face = mesh.face(f);
    const std::size_t n = face.size();
    return {mesh.vertices[face[0]], mesh.vertices[face[n / 3]], mesh.vertices[face[2 * n / 3]]};
}

}  // namespace

std::vector<FacePlane> face_planes(const PolygonMesh& mesh)
{
    std::vector<FacePlane> planes;
    planes.reserve(mesh.n_faces());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        if (mesh.face(f).size() < 3) continue;
        const Vec3 n = face_normal(mesh, f);
        if (n == Vec3{}) continue;
        planes.push_back({n, dot(n, mesh.vertices[mesh.face(f)[0]])});
    }
    return planes;
}

std::vector<FacePlane> convex_face_planes(const PolygonMesh& mesh, const std::string& name)
{
    require_closed(mesh, name);
    if (static_cast<double>(mesh.n_faces()) * static_cast<double>(mesh.n_vertices()) > 1e10)
        throw InvalidInput(name + ": too many faces for a function of space");
    const double allowed = 1e-12 * bounds(mesh).diagonal();
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        current_progress().check();
        if (mesh.face(f).size() < 3) continue;
        const Vec3 n = normalized(face_normal(mesh, f));
        const auto [a, b, c] = spread_corners(mesh, f);
        for (const Vec3& v : mesh.vertices)
            if (orient3d(a, b, c, v) < 0 && dot(n, v - a) > allowed)
                refuse(name, f, "has a corner of the polyhedron above it: not convex");
    }
    return face_planes(mesh);
}

}  // namespace genus
