#include "genus/mesh/t_junctions.h"

#include <algorithm>

#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/sides.h"

namespace genus {

namespace {

struct OpenSides {
    std::vector<std::int32_t> sides;
    std::vector<Box3> boxes;              // round each, widened by the tolerance
    std::vector<std::uint8_t> on_border;  // by vertex
};

OpenSides open_sides(const IndexedMesh& mesh, double tolerance)
{
    const TriangleSides sides(mesh);
    check_indices(sides, mesh.n_vertices());
    const auto all = [](std::size_t) { return false; };
    const std::vector<std::int32_t> twin =
        twins(make_edge_table(sides, mesh.n_vertices(), all), sides.n_sides());
    OpenSides open;
    open.on_border.assign(mesh.n_vertices(), 0);
    const Vec3 margin{{tolerance, tolerance, tolerance}};
    for (std::int32_t s = 0; s < static_cast<std::int32_t>(twin.size()); ++s) {
        if (twin[s] != kBoundarySide) continue;
        Box3 box;
        for (const std::int32_t v : {sides.from(s), sides.to(s)}) {
            open.on_border[v] = 1;
            box.add(mesh.vertices[v] + margin);
            box.add(mesh.vertices[v] - margin);
        }
        open.sides.push_back(s);
        open.boxes.push_back(box);
    }
    return open;
}

bool on_one_line(const Vec3& a, const Vec3& b, const Vec3& p)
{
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        if (orient2d({{a[i], a[j]}}, {{b[i], b[j]}}, {{p[i], p[j]}}) != 0) return false;
    }
    return true;
}

}  // namespace

std::vector<TJunction> find_t_junctions(const IndexedMesh& mesh, double tolerance)
{
    const OpenSides open = open_sides(mesh, tolerance);
    const BoxTree tree(open.boxes);
    std::vector<TJunction> found;
    for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
        if (v % 4096 == 4095) current_progress().check();
        if (!open.on_border[v]) continue;
        const Vec3& p = mesh.vertices[v];
        Box3 box;
        box.add(p);
        for (const std::int32_t i : tree.overlapping(box)) {
            const std::int32_t side = open.sides[i];
            const Triangle& face = mesh.faces[side / 3];
            const auto vertex = static_cast<std::int32_t>(v);
            if (std::find(face.begin(), face.end(), vertex) != face.end()) continue;
            const Vec3& a = mesh.vertices[face[side % 3]];
            const Vec3& b = mesh.vertices[face[(side % 3 + 1) % 3]];
            const double along = dot(p - a, b - a) / dot(b - a, b - a);
            if (!(along > 0.0 && along < 1.0)) continue;
            const bool on_edge = tolerance > 0.0 ? distance(p, a + along * (b - a)) <= tolerance
                                                 : on_one_line(a, b, p);
            if (on_edge) found.push_back({side, along, vertex});
        }
    }
    std::sort(found.begin(), found.end());
    return found;
}

}  // namespace genus
