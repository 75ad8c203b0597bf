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

// For each patch the number of its surface, and whether it shows its back where the first patch
// of the surface shows its front.
struct Surfaces {
    std::vector<int> number;
    std::vector<bool> turned;
    int count = 0;
};

Surfaces surfaces_of(const PatchModel& model)
{
    std::vector<std::vector<std::pair<std::size_t, bool>>> neighbours(model.patches().size());
    for (const auto& users : model.edges()) {
        if (users.size() != 2) continue;
        const auto a = static_cast<std::size_t>(users[0].patch);
        const auto b = static_cast<std::size_t>(users[1].patch);
        const bool against = users[0].forward == users[1].forward;
        neighbours[a].emplace_back(b, against);
        neighbours[b].emplace_back(a, against);
    }
    Surfaces s{std::vector<int>(neighbours.size(), -1), std::vector<bool>(neighbours.size()), 0};
    for (std::size_t seed = 0; seed < neighbours.size(); ++seed) {
        if (s.number[seed] >= 0) continue;
        std::vector<std::size_t> open{seed};
        s.number[seed] = s.count;
        while (!open.empty()) {
            const std::size_t at = open.back();
            open.pop_back();
            for (const auto& [next, against] : neighbours[at]) {
                if (s.number[next] >= 0) continue;
                s.number[next] = s.count;
                s.turned[next] = s.turned[at] != against;
                open.push_back(next);
            }
        }
        ++s.count;
    }
    return s;
}

Patch from_behind(const Patch& patch)
{
    if (const auto* tensor = std::get_if<TensorPatch>(&patch)) return tensor->transposed();
    // u and v exchanged: the rows become columns.
    const auto& t = std::get<BezierTriangle>(patch);
    const int n = t.degree();
    std::vector<Vec3> points;
    std::vector<double> weights;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n - i; ++j) {
            points.push_back(t.point(j, i));
            if (t.rational()) weights.push_back(t.weights()[BezierTriangle::index(n, j, i)]);
        }
    return BezierTriangle(n, std::move(points), std::move(weights));
}

PatchModel turned(const PatchModel& model, const std::vector<bool>& which)
{
    std::vector<Patch> patches;
    for (std::size_t k = 0; k < which.size(); ++k)
        patches.push_back(which[k] ? from_behind(model.patches()[k]) : model.patches()[k]);
    return PatchModel(std::move(patches));
}

}  // namespace

PatchModel oriented(const PatchModel& model)
{
    const Surfaces s = surfaces_of(model);
    const PatchModel agreed = turned(model, s.turned);
    const double size = agreed.bounds().diagonal();
    if (!(size > 0.0)) return agreed;
    // Of a coarse mesh: the side does not depend on details.
    const TessellatedPatches coarse = agreed.tessellate({0.02 * size, 2'000'000});
    std::vector<double> volumes(static_cast<std::size_t>(s.count), 0.0);
    const Vec3 middle = agreed.bounds().center();
    for (std::size_t f = 0; f < coarse.mesh.n_faces(); ++f) {
        const auto corner = [&](std::size_t k) {
            return coarse.mesh.vertices[static_cast<std::size_t>(coarse.mesh.faces[f][k])] - middle;
        };
        const auto patch = static_cast<std::size_t>(coarse.patch_of_face[f]);
        volumes[static_cast<std::size_t>(s.number[patch])] +=
            dot(corner(0), cross(corner(1), corner(2)));
    }
    std::vector<bool> inside_out;
    for (const int k : s.number) inside_out.push_back(volumes[static_cast<std::size_t>(k)] < 0.0);
    return turned(agreed, inside_out);
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
