#include "genus/boolean/split.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "genus/base/error.h"

namespace genus {

namespace {

// Room between the mesh and the sides of the prism, in diagonals of the mesh.
constexpr double kRoom = 0.0625;

// The part of the box on the side of the plane that the normal, along one axis, points away from.
IndexedMesh cut_box(const Box3& box, int axis, double at, bool upward)
{
    Box3 part = box;
    (upward ? part.max : part.min)[axis] = at;
    IndexedMesh mesh;
    for (std::size_t k = 0; k < 8; ++k) mesh.vertices.push_back(part.corner(k));
    mesh.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                  {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

// A prism below one triangle of the plane, so that all of the cut is exactly plane.
IndexedMesh prism_below(const Vec3& centre, const Vec3& n, double reach)
{
    const Vec3 helper = std::fabs(n[0]) < 0.6 ? Vec3{{1.0, 0.0, 0.0}} : Vec3{{0.0, 1.0, 0.0}};
    const Vec3 u = normalized(cross(n, helper)), v = cross(n, u);
    const double half_root3 = 0.5 * std::sqrt(3.0);
    const std::array<Vec2, 3> corners{Vec2{{1.0, 0.0}}, Vec2{{-0.5, half_root3}},
                                      Vec2{{-0.5, -half_root3}}};
    IndexedMesh mesh;
    for (const double depth : {0.0, reach})
        for (const Vec2& c : corners)
            mesh.vertices.push_back(centre + 1.1 * reach * (c[0] * u + c[1] * v) - depth * n);
    mesh.faces = {{0, 1, 2}, {5, 4, 3}, {0, 3, 4}, {0, 4, 1},
                  {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}};
    return mesh;
}

MeshBooleanResult whole(const IndexedMesh& mesh)
{
    const IndexedMesh operands[] = {mesh};
    return mesh_boolean(operands, BooleanFormula::union_of(1));
}

}  // namespace

SplitMesh split(const IndexedMesh& mesh, const Vec3& normal, double offset)
{
    require(is_finite(normal) && normal != Vec3{}, "split: the normal is zero or not finite");
    require(std::isfinite(offset), "split: offset", offset, "finite");
    const Box3 box = bounds(mesh);
    if (box.empty()) return {};
    // Scaled first, so that no square overflows or vanishes.
    const double largest =
        std::max({std::fabs(normal[0]), std::fabs(normal[1]), std::fabs(normal[2])});
    const Vec3 scaled = normal / largest;
    const double length = norm(scaled);
    const Vec3 n = scaled / length;
    const Vec3 middle = 0.5 * box.min + 0.5 * box.max;
    const double away = offset / largest / length - dot(n, middle);
    const double reach = (0.5 + kRoom) * box.diagonal();
    if (away > reach) return {whole(mesh), {}};
    if (away < -reach) return {{}, whole(mesh)};

    IndexedMesh side;
    int axis = -1;
    for (int i = 0; i < 3; ++i)
        if (normal[(i + 1) % 3] == 0.0 && normal[(i + 2) % 3] == 0.0) axis = i;
    if (axis >= 0) {
        const double at = offset / normal[axis];
        const Box3 room = box.inflated(kRoom * box.diagonal());
        if (at >= room.max[axis] || at <= room.min[axis]) {
            const bool is_below = (normal[axis] > 0.0) == (at >= room.max[axis]);
            return is_below ? SplitMesh{whole(mesh), {}} : SplitMesh{{}, whole(mesh)};
        }
        side = cut_box(room, axis, at, normal[axis] > 0.0);
    } else {
        side = prism_below(middle + away * n, n, 2.0 * reach);
    }
    const IndexedMesh operands[] = {mesh, std::move(side)};
    return {mesh_boolean(operands, BooleanFormula::intersection_of(2)),
            mesh_boolean(operands, BooleanFormula::difference_of(2))};
}

}  // namespace genus
