#include "genus/mesh/dual.h"

#include <algorithm>
#include <string>

#include "genus/base/error.h"
#include "genus/mesh/halfedge_mesh.h"

namespace genus {

namespace {

// Relative to the first corner, so that a mesh far out loses nothing.
Vec3 barycentre(const HalfedgeMesh& mesh, Face f)
{
    const Vec3 origin = mesh.point(mesh.to(mesh.halfedge(f)));
    Vec3 sum;
    int n = 0;
    for (const Halfedge h : mesh.around(f)) {
        sum += mesh.point(mesh.to(h)) - origin;
        ++n;
    }
    return origin + sum / n;
}

PolygonMesh dual_of(const HalfedgeMesh& mesh)
{
    const std::vector<Halfedge> boundary = mesh.boundary_loops();
    if (!boundary.empty())
        throw InvalidInput("dual: the mesh is open at the edge from vertex " +
                           std::to_string(mesh.from(boundary[0]).index) + " to vertex " +
                           std::to_string(mesh.to(boundary[0]).index));
    PolygonMesh out;
    out.vertices.reserve(mesh.n_faces());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f)
        out.vertices.push_back(barycentre(mesh, Face(f)));
    std::vector<std::int32_t> face;
    for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
        face.clear();
        for (const Halfedge h : mesh.outgoing(Vertex(v))) face.push_back(mesh.face(h).index);
        if (face.size() < 3)
            throw InvalidInput("dual: vertex " + std::to_string(v) + " has " +
                               std::to_string(face.size()) + " edges, must have at least 3");
        std::reverse(face.begin(), face.end());  // the halfedges turn clockwise
        out.add_face(face);
    }
    return out;
}

}  // namespace

PolygonMesh dual(const PolygonMesh& mesh)
{
    return dual_of(HalfedgeMesh(mesh));
}

PolygonMesh dual(const IndexedMesh& mesh)
{
    return dual_of(HalfedgeMesh(mesh));
}

}  // namespace genus
