#include "genus/model/refine.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "genus/base/parallel.h"
#include "genus/mesh/sides.h"

namespace genus {

namespace {

// Pairs the sides of an edge so that each pair bounds one wedge of matter. Seen along the edge,
// matter lies clockwise of a face that runs along it and counterclockwise of one that runs against.
bool pair_sides(const IndexedMesh& mesh, const TriangleSides& sides,
                std::span<const std::int32_t> on_edge, std::vector<std::int32_t>& twin)
{
    if (on_edge.size() == 2) {
        if (sides.from(on_edge[0]) != sides.to(on_edge[1])) return false;
        twin[on_edge[0]] = on_edge[1];
        twin[on_edge[1]] = on_edge[0];
        return true;
    }
    if (on_edge.size() % 2 != 0) return false;
    const std::int32_t a = std::min(sides.from(on_edge[0]), sides.to(on_edge[0]));
    const std::int32_t b = std::max(sides.from(on_edge[0]), sides.to(on_edge[0]));
    const Vec3 axis = normalized(mesh.vertices[b] - mesh.vertices[a]);
    std::size_t least = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (std::fabs(axis[i]) < std::fabs(axis[least])) least = i;
    Vec3 unit;
    unit[least] = 1.0;
    const Vec3 x = normalized(cross(axis, unit)), y = cross(axis, x);
    struct Spoke {
        double angle;
        bool along;
        std::int32_t side;
    };
    std::vector<Spoke> spokes;
    int balance = 0;
    for (const std::int32_t s : on_edge) {
        const Vec3 e = mesh.vertices[sides.to(sides.next(s))] - mesh.vertices[a];
        const bool along = sides.from(s) == a;
        spokes.push_back({std::atan2(dot(e, y), dot(e, x)), along, s});
        balance += along ? 1 : -1;
    }
    if (balance != 0) return false;
    // Of two faces in one direction the one that ends matter comes first.
    std::sort(spokes.begin(), spokes.end(), [](const Spoke& p, const Spoke& q) {
        if (p.angle != q.angle) return p.angle < q.angle;
        return p.along != q.along ? p.along : p.side < q.side;
    });
    const std::size_t n = spokes.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (spokes[i].along) continue;
        const Spoke& end = spokes[(i + 1) % n];
        if (!end.along) return false;
        twin[spokes[i].side] = end.side;
        twin[end.side] = spokes[i].side;
    }
    return true;
}

}  // namespace

bool separate_fans(SurfaceMesh& surface)
{
    IndexedMesh& mesh = surface.mesh;
    const TriangleSides sides(mesh);
    const EdgeTable edges =
        make_edge_table(sides, mesh.n_vertices(), [](std::size_t) { return false; });
    std::vector<std::int32_t> twin(sides.n_sides(), -1);
    for (std::size_t e = 0; e < edges.n_edges(); ++e) {
        const auto first = edges.sides.begin() + edges.starts[e];
        const auto last = edges.sides.begin() + edges.starts[e + 1];
        if (!pair_sides(mesh, sides, std::span(first, last), twin)) return false;
    }
    // Corners (numbered as the side that starts there) of one fan are joined across sides.
    std::vector<std::int32_t> fan(sides.n_sides());
    std::iota(fan.begin(), fan.end(), 0);
    const auto find = [&](std::int32_t c) {
        while (fan[c] != c) c = fan[c] = fan[fan[c]];
        return c;
    };
    for (std::size_t s = 0; s < twin.size(); ++s) {
        if (twin[s] < 0) return false;
        const std::int32_t here = find(static_cast<std::int32_t>(s));
        const std::int32_t there = find(sides.next(twin[s]));
        fan[std::max(here, there)] = std::min(here, there);
    }
    std::vector<std::int32_t> owner(mesh.n_vertices(), -1), number(twin.size(), -1);
    std::vector<Triangle> faces = mesh.faces;
    for (std::size_t s = 0; s < twin.size(); ++s) {
        const std::int32_t root = find(static_cast<std::int32_t>(s));
        const std::int32_t v = sides.from(static_cast<std::int32_t>(s));
        if (number[root] < 0) {
            if (owner[v] < 0) {
                owner[v] = root;
                number[root] = v;
            } else {
                number[root] = static_cast<std::int32_t>(mesh.n_vertices());
                const Vec3 p = mesh.vertices[v];
                const auto on = surface.surfaces_of_vertex[v];
                mesh.vertices.push_back(p);
                surface.surfaces_of_vertex.push_back(on);
            }
        }
        faces[s / 3][s % 3] = number[root];
    }
    mesh.faces.swap(faces);
    return true;
}

std::int64_t settle(SurfaceMesh& surface, const std::vector<SurfaceForm>& forms)
{
    IndexedMesh& mesh = surface.mesh;
    const std::vector<Vec3> start = mesh.vertices;
    std::vector<double> reach(mesh.n_vertices(), 0.0);
    for (const Triangle& t : mesh.faces)
        for (std::size_t i = 0; i < 3; ++i) {
            const double length = distance(start[t[i]], start[t[(i + 1) % 3]]);
            for (const std::size_t j : {i, (i + 1) % 3})
                reach[t[j]] = std::max(reach[t[j]], length);
        }
    std::vector<char> stays(mesh.n_vertices(), 0);
    parallel_for(mesh.n_vertices(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            std::array<const SurfaceForm*, 3> on{};
            std::size_t n = 0;
            for (const std::int32_t s : surface.surfaces_of_vertex[v])
                if (s >= 0) on[n++] = &forms[s];
            const auto p = project(std::span(on.data(), n), start[v], 0.5 * reach[v]);
            if (p)
                mesh.vertices[v] = *p;
            else
                stays[v] = 1;
        }
    });
    // A face keeps its normal to within 60 degrees, or its corners go back.
    constexpr double kCosine = 0.5;
    for (bool any = true; any;) {
        any = false;
        for (const Triangle& t : mesh.faces) {
            const Vec3 before = cross(start[t[1]] - start[t[0]], start[t[2]] - start[t[0]]);
            const Vec3 after = cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                                     mesh.vertices[t[2]] - mesh.vertices[t[0]]);
            if (dot(before, after) > kCosine * norm(before) * norm(after)) continue;
            for (const std::int32_t v : t) {
                if (mesh.vertices[v] == start[v]) continue;
                mesh.vertices[v] = start[v];
                stays[v] = 1;
                any = true;
            }
        }
    }
    return std::count(stays.begin(), stays.end(), 1);
}

}  // namespace genus
