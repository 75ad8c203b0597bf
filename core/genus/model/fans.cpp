#include "genus/model/fans.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "genus/mesh/disjoint_sets.h"
#include "genus/mesh/sides.h"

namespace genus {

namespace {

// What stays together at an edge of several faces.
enum class Wedge { Matter, Space };

// Pairs the sides of an edge so that each pair bounds one wedge. Seen along the edge, matter lies
// clockwise of a face that runs along it and counterclockwise of one that runs against.
bool pair_sides(const IndexedMesh& mesh, const TriangleSides& sides,
                std::span<const std::int32_t> on_edge, Wedge wedge, std::vector<std::int32_t>& twin)
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
        bool ends;  // the wedge before it, counterclockwise
        std::int32_t side;
    };
    std::vector<Spoke> spokes;
    int balance = 0;
    for (const std::int32_t s : on_edge) {
        const Vec3 e = mesh.vertices[sides.to(sides.next(s))] - mesh.vertices[a];
        const bool ends = (sides.from(s) == a) == (wedge == Wedge::Matter);
        spokes.push_back({std::atan2(dot(e, y), dot(e, x)), ends, s});
        balance += ends ? 1 : -1;
    }
    if (balance != 0) return false;
    // Of two faces in one direction the one that ends a wedge comes first.
    std::sort(spokes.begin(), spokes.end(), [](const Spoke& p, const Spoke& q) {
        if (p.angle != q.angle) return p.angle < q.angle;
        return p.ends != q.ends ? p.ends : p.side < q.side;
    });
    const std::size_t n = spokes.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (spokes[i].ends) continue;
        const Spoke& end = spokes[(i + 1) % n];
        if (!end.ends) return false;
        twin[spokes[i].side] = end.side;
        twin[end.side] = spokes[i].side;
    }
    return true;
}

// The fan of each corner, named by the least of its corners, numbered as the sides that start
// there; the vertices at edges of more than two faces; and of such edges those that several pairs
// of faces have in one fan at either end, so that no choice of fans takes them apart.
struct Fans {
    std::vector<std::int32_t> of_corner;
    std::vector<char> at_complex_edge;
    std::vector<std::vector<std::int32_t>> inseparable;  // the sides there
};

std::optional<Fans> find_fans(const IndexedMesh& mesh, Wedge wedge)
{
    const TriangleSides sides(mesh);
    const EdgeTable edges =
        make_edge_table(sides, mesh.n_vertices(), [](std::size_t) { return false; });
    std::vector<std::int32_t> twin(sides.n_sides(), -1);
    Fans fans;
    std::vector<std::vector<std::int32_t>> complex_edges;
    fans.at_complex_edge.assign(mesh.n_vertices(), 0);
    for (std::size_t e = 0; e < edges.n_edges(); ++e) {
        const auto first = edges.sides.begin() + edges.starts[e];
        const auto last = edges.sides.begin() + edges.starts[e + 1];
        if (!pair_sides(mesh, sides, std::span(first, last), wedge, twin)) return std::nullopt;
        if (last - first == 2) continue;
        fans.at_complex_edge[sides.from(*first)] = fans.at_complex_edge[sides.to(*first)] = 1;
        complex_edges.emplace_back(first, last);
    }
    // Corners of one fan are joined across sides.
    const auto n_sides = static_cast<std::int32_t>(sides.n_sides());
    DisjointSets joined(sides.n_sides());
    for (std::int32_t s = 0; s < n_sides; ++s) {
        if (twin[s] < 0) return std::nullopt;
        joined.unite(s, sides.next(twin[s]));
    }
    std::vector<std::int32_t>& fan = fans.of_corner;
    for (std::int32_t s = 0; s < n_sides; ++s) fan.push_back(joined.find(s));
    for (std::vector<std::int32_t>& edge : complex_edges) {
        std::vector<std::pair<std::int32_t, std::int32_t>> ends;
        for (const std::int32_t s : edge)
            if (sides.from(s) < sides.to(s)) ends.emplace_back(fan[s], fan[sides.next(s)]);
        std::sort(ends.begin(), ends.end());
        if (std::adjacent_find(ends.begin(), ends.end()) != ends.end())
            fans.inseparable.push_back(std::move(edge));
    }
    return fans;
}

// Puts a vertex in the middle of those edges, at most one a face.
void halve_edges(SurfaceMesh& surface, const std::vector<std::vector<std::int32_t>>& edges)
{
    IndexedMesh& mesh = surface.mesh;
    std::vector<char> used(mesh.n_faces(), 0);
    for (const std::vector<std::int32_t>& edge : edges) {
        if (std::any_of(edge.begin(), edge.end(), [&](std::int32_t s) { return used[s / 3] != 0; }))
            continue;
        const auto corner = [&](std::int32_t s, int by) {
            return mesh.faces[s / 3][(s % 3 + by) % 3];
        };
        const std::int32_t a = corner(edge[0], 0), b = corner(edge[0], 1);
        const auto m = static_cast<std::int32_t>(mesh.n_vertices());
        mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
        surface.cell_size.push_back(std::min(surface.cell_size[a], surface.cell_size[b]));
        std::vector<std::int32_t> on;
        for (const std::int32_t s : edge) on.push_back(surface.surface_of_face[s / 3] >> 1);
        std::sort(on.begin(), on.end());
        on.erase(std::unique(on.begin(), on.end()), on.end());
        on.resize(3, -1);
        surface.surfaces_of_vertex.push_back({on[0], on[1], on[2]});
        for (const std::int32_t s : edge) {
            used[s / 3] = 1;
            const Triangle second{m, corner(s, 1), corner(s, 2)};
            mesh.faces[s / 3][(s % 3 + 1) % 3] = m;
            mesh.faces.push_back(second);
            surface.surface_of_face.push_back(surface.surface_of_face[s / 3]);
        }
    }
}

}  // namespace

std::vector<std::vector<std::int32_t>> vertices_by_place(std::span<const std::int32_t> touch)
{
    std::vector<std::vector<std::int32_t>> places;
    for (std::size_t v = 0; v < touch.size(); ++v) {
        if (touch[v] < 0) continue;
        const auto place = static_cast<std::size_t>(touch[v]);
        if (place >= places.size()) places.resize(place + 1);
        places[place].push_back(static_cast<std::int32_t>(v));
    }
    return places;
}

bool separate_fans(SurfaceMesh& surface)
{
    IndexedMesh& mesh = surface.mesh;
    std::optional<Fans> fans = find_fans(mesh, Wedge::Matter);
    while (fans && !fans->inseparable.empty()) {
        halve_edges(surface, fans->inseparable);
        fans = find_fans(mesh, Wedge::Matter);
    }
    if (!fans) return false;
    const std::size_t n = mesh.n_vertices();
    std::vector<std::int32_t> touch(n, -1);
    std::int32_t places = 0;
    for (std::size_t v = 0; v < n; ++v)
        if (fans->at_complex_edge[v] != 0) touch[v] = places++;
    std::vector<char> owned(n, 0);
    std::vector<std::int32_t> number(fans->of_corner.size(), -1);
    for (std::size_t s = 0; s < number.size(); ++s) {
        std::int32_t& corner = mesh.faces[s / 3][s % 3];
        const std::int32_t v = corner;
        std::int32_t& own = number[fans->of_corner[s]];
        if (own < 0 && owned[v] == 0) {
            own = v;
            owned[v] = 1;
        } else if (own < 0) {
            own = static_cast<std::int32_t>(mesh.n_vertices());
            mesh.vertices.push_back(mesh.vertices[v]);
            surface.surfaces_of_vertex.push_back(surface.surfaces_of_vertex[v]);
            surface.cell_size.push_back(surface.cell_size[v]);
            touch.push_back(touch[v]);
        }
        corner = own;
    }
    surface.touch_of_vertex = places > 0 ? std::move(touch) : std::vector<std::int32_t>{};
    return true;
}

std::optional<FansOfSpace> fans_of_space(const SurfaceMesh& surface)
{
    FansOfSpace result;
    const std::vector<std::int32_t>& touch = surface.touch_of_vertex;
    // With one vertex a place, then one a fan.
    IndexedMesh joined = surface.mesh;
    const std::vector<std::vector<std::int32_t>> places = vertices_by_place(touch);
    const auto touches = [&](std::int32_t v) { return !places.empty() && touch[v] >= 0; };
    for (Triangle& t : joined.faces)
        for (std::int32_t& v : t)
            if (touches(v)) v = places[touch[v]].front();
    const std::optional<Fans> fans = find_fans(joined, Wedge::Space);
    if (!fans) return std::nullopt;
    std::vector<std::int32_t> number(fans->of_corner.size(), -1);
    const auto n = static_cast<std::int32_t>(touch.size());
    result.faces = std::move(joined.faces);
    for (std::size_t s = 0; s < number.size(); ++s) {
        std::int32_t& corner = result.faces[s / 3][s % 3];
        if (!touches(corner)) continue;
        std::int32_t& own = number[fans->of_corner[s]];
        if (own < 0) {
            own = n + static_cast<std::int32_t>(result.original.size());
            result.original.push_back(corner);
        }
        corner = own;
    }
    return result;
}

}  // namespace genus
