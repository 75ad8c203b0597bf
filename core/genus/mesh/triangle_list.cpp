#include "genus/mesh/triangle_list.h"

#include "genus/mesh/point_table.h"
#include "genus/mesh/sides.h"

namespace genus {

TriangleList to_triangle_list(const IndexedMesh& mesh)
{
    check_indices(TriangleSides(mesh), mesh.n_vertices());
    TriangleList list;
    list.triangles.reserve(mesh.n_faces());
    for (const auto& [a, b, c] : mesh.faces)
        list.triangles.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
    return list;
}

IndexedMesh to_indexed(const TriangleList& list)
{
    PointTable table;
    IndexedMesh mesh;
    mesh.faces.reserve(list.n_faces());
    for (const auto& [a, b, c] : list.triangles) {
        const std::int32_t i = table.find_or_add(a), j = table.find_or_add(b);
        mesh.faces.push_back({i, j, table.find_or_add(c)});
        if (mesh.faces.size() % 4096 == 0) current_progress().check();
    }
    mesh.vertices = table.take_points();
    return mesh;
}

}  // namespace genus
