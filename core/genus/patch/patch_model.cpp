#include "genus/patch/patch_model.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "genus/base/error.h"

namespace genus {

PatchModel::PatchModel(std::vector<Patch> patches)
    : patches_(std::move(patches)), edges_(common_edges(patches_))
{
}

bool PatchModel::is_closed() const
{
    return std::all_of(edges_.begin(), edges_.end(),
                       [](const auto& users) { return users.size() == 2; });
}

bool PatchModel::is_oriented() const
{
    return std::all_of(edges_.begin(), edges_.end(), [](const auto& users) {
        return users.size() == 1 || (users.size() == 2 && users[0].forward != users[1].forward);
    });
}

namespace {

struct Sample {
    Vec3 point, normal;
};

Sample sample(const Patch& patch, const PatchEdgeUse& use, double s)
{
    return std::visit(
        [&](const auto& p) {
            const Vec2 q = p.on_edge(use.edge, use.forward ? s : 1.0 - s);
            return Sample{p.value(q[0], q[1]), p.normal(q[0], q[1])};
        },
        patch);
}

}  // namespace

std::vector<PatchJoin> PatchModel::joins(int samples) const
{
    require(samples >= 1 && samples <= (1 << 20), "PatchModel::joins: samples", samples,
            "in [1, 2^20]");
    std::vector<PatchJoin> result;
    for (const auto& users : edges_) {
        if (users.size() != 2) continue;
        PatchJoin j{users[0], users[1], 0.0, 0.0};
        for (int i = 0; i <= samples; ++i) {
            const double s = static_cast<double>(i) / samples;
            const Sample a = sample(patches_[static_cast<std::size_t>(j.a.patch)], j.a, s);
            const Sample b = sample(patches_[static_cast<std::size_t>(j.b.patch)], j.b, s);
            j.gap = std::max(j.gap, distance(a.point, b.point));
            j.turn = std::max(j.turn,
                              std::atan2(norm(cross(a.normal, b.normal)), dot(a.normal, b.normal)));
        }
        result.push_back(j);
    }
    return result;
}

TessellatedPatches PatchModel::tessellate(const TessellateOptions& options) const
{
    return genus::tessellate(patches_, options);
}

Box3 PatchModel::bounds() const
{
    Box3 box;
    for (const Patch& patch : patches_)
        std::visit([&](const auto& p) { box.add(p.bounds()); }, patch);
    return box;
}

PatchModel transformed(const PatchModel& model, const Transform& map)
{
    std::vector<Patch> patches;
    for (const Patch& patch : model.patches())
        std::visit([&](const auto& p) { patches.emplace_back(transformed(p, map)); }, patch);
    return PatchModel(std::move(patches));
}

namespace {

void check_indices(const IndexedMesh& mesh)
{
    const auto n = static_cast<std::int64_t>(mesh.n_vertices());
    for (const Triangle& t : mesh.faces)
        for (const std::int32_t v : t)
            require(v >= 0 && v < n, "pn_triangles: a face names a vertex that is not there");
}

}  // namespace

std::vector<Vec3> vertex_normals(const IndexedMesh& mesh)
{
    check_indices(mesh);
    std::vector<Vec3> normals(mesh.n_vertices());
    for (const Triangle& t : mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& p = mesh.vertices[static_cast<std::size_t>(t[k])];
            const Vec3 a = mesh.vertices[static_cast<std::size_t>(t[(k + 1) % 3])] - p;
            const Vec3 b = mesh.vertices[static_cast<std::size_t>(t[(k + 2) % 3])] - p;
            const Vec3 n = cross(a, b);
            normals[static_cast<std::size_t>(t[k])] +=
                std::atan2(norm(n), dot(a, b)) * normalized(n);
        }
    for (Vec3& n : normals) n = normalized(n);
    return normals;
}

PatchModel pn_triangles(const IndexedMesh& mesh, std::span<const Vec3> normals)
{
    check_indices(mesh);
    require(normals.size() == mesh.n_vertices(), "pn_triangles: number of normals",
            static_cast<double>(normals.size()), "that of the vertices");
    std::vector<Patch> patches;
    patches.reserve(mesh.n_faces());
    for (const Triangle& t : mesh.faces) {
        const auto vertex = [&](std::size_t k) {
            return mesh.vertices[static_cast<std::size_t>(t[k])];
        };
        // Third of the way from corner a to b, moved into the tangent plane of a. Formed from the
        // data of the edge alone, so both its triangles get the same bits.
        const auto on_edge = [&](std::size_t a, std::size_t b) {
            const Vec3 n = normals[static_cast<std::size_t>(t[a])];
            return (2.0 * vertex(a) + vertex(b) - dot(vertex(b) - vertex(a), n) * n) / 3.0;
        };
        std::vector<Vec3> c(10);
        const auto put = [&](int i, int j, const Vec3& p) {
            c[BezierTriangle::index(3, i, j)] = p;
        };
        put(0, 0, vertex(0));
        put(3, 0, vertex(1));
        put(0, 3, vertex(2));
        put(1, 0, on_edge(0, 1));
        put(2, 0, on_edge(1, 0));
        put(2, 1, on_edge(1, 2));
        put(1, 2, on_edge(2, 1));
        put(0, 2, on_edge(2, 0));
        put(0, 1, on_edge(0, 2));
        const Vec3 edges = (on_edge(0, 1) + on_edge(1, 0) + on_edge(1, 2) + on_edge(2, 1) +
                            on_edge(2, 0) + on_edge(0, 2)) /
                           6.0;
        put(1, 1, 1.5 * edges - 0.5 * ((vertex(0) + vertex(1) + vertex(2)) / 3.0));
        patches.emplace_back(BezierTriangle(3, std::move(c)));
    }
    return PatchModel(std::move(patches));
}

PatchModel pn_triangles(const IndexedMesh& mesh)
{
    return pn_triangles(mesh, vertex_normals(mesh));
}

}  // namespace genus
