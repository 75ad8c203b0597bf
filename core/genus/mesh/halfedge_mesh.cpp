#include "genus/mesh/halfedge_mesh.h"

#include <atomic>
#include <string>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/mesh/sides.h"
#include "genus/mesh/topology.h"

namespace genus {

namespace {

std::string edge_text(std::int32_t a, std::int32_t b)
{
    return "edge " + std::to_string(a) + "-" + std::to_string(b);
}

// Says what keeps the mesh from being a manifold; called where something does.
template <class Mesh>
[[noreturn]] void refuse(const Mesh& mesh)
{
    const Topology t = topology(mesh);
    std::string text = "halfedges: ";
    if (!t.degenerate_faces.empty()) {
        text += "face " + std::to_string(t.degenerate_faces[0]);
        text += " has fewer than three corners or a vertex twice";
    } else if (!t.complex_edges.empty()) {
        const ComplexEdge& e = t.complex_edges[0];
        text += edge_text(e.a, e.b) + " has " + std::to_string(e.faces.size()) + " faces";
    } else if (!t.flipped_edges.empty()) {
        const FlippedEdge& e = t.flipped_edges[0];
        text += "faces " + std::to_string(e.faces[0]) + " and " + std::to_string(e.faces[1]);
        text += " run the same way along " + edge_text(e.a, e.b);
    } else if (!t.complex_vertices.empty()) {
        const ComplexVertex& v = t.complex_vertices[0];
        text += "vertex " + std::to_string(v.vertex) + " has " + std::to_string(v.fans);
        text += " fans of faces";
    }
    throw InvalidInput(text);
}

// The side across each side, -1 on the boundary. False if some edge has more than two faces or two
// that run along it in the same direction, or a face names a vertex twice.
template <class Sides>
bool pair_sides(const Sides& sides, std::size_t n_vertices, std::vector<std::int32_t>& opposite)
{
    std::atomic<bool> good{true};
    parallel_for(sides.n_faces(), 8192, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f)
            if (names_a_vertex_twice(sides, f)) good.store(false);
    });
    if (!good.load()) return false;
    const SideBuckets buckets =
        make_side_buckets(sides, n_vertices, [](std::size_t) { return false; });
    parallel_for(n_vertices, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            std::int32_t i = buckets.starts[v];
            const std::int32_t last = buckets.starts[v + 1];
            const auto& entry = buckets.entries;
            while (i + 1 < last) {
                if (entry[i].larger != entry[i + 1].larger) {
                    ++i;
                    continue;
                }
                const std::int32_t s = entry[i].side, t = entry[i + 1].side;
                const bool third = i + 2 < last && entry[i + 2].larger == entry[i].larger;
                if (third || sides.from(s) == sides.from(t)) good.store(false);
                opposite[s] = t;
                opposite[t] = s;
                i += 2;
            }
        }
    });
    return good.load();
}

}  // namespace

HalfedgeMesh::HalfedgeMesh(const PolygonMesh& mesh) : points_(mesh.vertices)
{
    if (!build(PolygonSides(mesh))) refuse(mesh);
}

HalfedgeMesh::HalfedgeMesh(const IndexedMesh& mesh) : points_(mesh.vertices)
{
    if (!build(TriangleSides(mesh))) refuse(mesh);
}

template <class Sides>
bool HalfedgeMesh::build(const Sides& sides)
{
    check_indices(sides, n_vertices());
    require(sides.n_sides() < (std::size_t{1} << 30), "halfedges: more than 2^30 corners");
    const auto n = static_cast<std::int32_t>(sides.n_sides());
    opposite_.assign(n, -1);
    if (!pair_sides(sides, n_vertices(), opposite_)) return false;
    for (std::int32_t s = 0; s < n; ++s) {
        to_.push_back(sides.to(s));
        next_.push_back(sides.next(s));
        face_.push_back(sides.face(s));
    }
    for (std::size_t f = 0; f < sides.n_faces(); ++f) face_halfedge_.push_back(sides.first(f));
    vertex_halfedge_.assign(n_vertices(), -1);
    for (std::int32_t s = n; s-- > 0;) vertex_halfedge_[sides.from(s)] = s;
    if (!add_boundary(sides)) return false;
    vertex_properties_.resize(n_vertices());
    halfedge_properties_.resize(n_halfedges());
    face_properties_.resize(n_faces());
    return vertices_are_regular();
}

// False if two loops meet in a vertex.
template <class Sides>
bool HalfedgeMesh::add_boundary(const Sides& sides)
{
    const auto n = static_cast<std::int32_t>(sides.n_sides());
    for (std::int32_t s = 0; s < n; ++s) {
        if (opposite_[s] >= 0) continue;
        const auto h = static_cast<std::int32_t>(to_.size());
        if (vertex_halfedge_[to_[s]] >= n) return false;
        vertex_halfedge_[to_[s]] = h;
        opposite_[s] = h;
        opposite_.push_back(s);
        to_.push_back(sides.from(s));
        face_.push_back(-1);
        next_.push_back(-1);
    }
    for (std::size_t h = n; h < to_.size(); ++h) next_[h] = vertex_halfedge_[to_[h]];
    return true;
}

// Every vertex has one fan: turning round it meets all halfedges that leave it.
bool HalfedgeMesh::vertices_are_regular() const
{
    std::vector<std::int32_t> n_out(vertex_slots(), 0);
    for (std::size_t h = 0; h < halfedge_slots(); ++h)
        if (is_alive(Halfedge(h))) ++n_out[from(Halfedge(h)).index];
    std::atomic<bool> good{true};
    parallel_for(vertex_slots(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            std::int32_t count = 0;
            for ([[maybe_unused]] const Halfedge h : outgoing(Vertex(v)))
                if (++count > n_out[v]) break;
            if (count != n_out[v]) good.store(false);
        }
    });
    return good.load();
}

Halfedge HalfedgeMesh::find(Vertex a, Vertex b) const
{
    for (const Halfedge h : outgoing(a))
        if (to(h) == b) return h;
    return {};
}

Halfedge HalfedgeMesh::previous(Halfedge h) const
{
    if (is_boundary(h)) {
        // Turn round the start until a boundary halfedge comes in.
        Halfedge in = opposite(h);
        while (!is_boundary(in)) in = opposite(next(in));
        return in;
    }
    Halfedge p = h;
    while (next(p) != h) p = next(p);
    return p;
}

std::int32_t HalfedgeMesh::valence(Vertex v) const
{
    std::int32_t n = 0;
    for ([[maybe_unused]] const Halfedge h : outgoing(v)) ++n;
    return n;
}

std::int32_t HalfedgeMesh::degree(Face f) const
{
    std::int32_t n = 0;
    for ([[maybe_unused]] const Halfedge h : around(f)) ++n;
    return n;
}

std::vector<Halfedge> HalfedgeMesh::boundary_loops() const
{
    std::vector<Halfedge> loops;
    std::vector<std::uint8_t> seen(halfedge_slots(), 0);
    for (std::size_t i = 0; i < halfedge_slots(); ++i) {
        if (seen[i] || !is_alive(Halfedge(i)) || !is_boundary(Halfedge(i))) continue;
        loops.push_back(Halfedge(i));
        for (const Halfedge h : around(Halfedge(i))) seen[h.index] = 1;
    }
    return loops;
}

std::size_t HalfedgeMesh::memory_bytes(std::size_t bytes_per_coordinate) const
{
    constexpr std::size_t kLink = sizeof(std::int32_t);
    return 3 * bytes_per_coordinate * vertex_slots() + kLink * vertex_halfedge_.size() +
           kLink * (opposite_.size() + next_.size() + to_.size() + face_.size()) +
           kLink * face_halfedge_.size();
}

PolygonMesh HalfedgeMesh::to_polygons() const
{
    PolygonMesh mesh;
    std::vector<std::int32_t> number(vertex_slots(), -1);
    for (std::size_t v = 0; v < vertex_slots(); ++v) {
        if (!is_alive(Vertex(v))) continue;
        number[v] = static_cast<std::int32_t>(mesh.n_vertices());
        mesh.vertices.push_back(points_[v]);
    }
    std::vector<std::int32_t> corners;
    for (std::size_t f = 0; f < face_slots(); ++f) {
        if (!is_alive(Face(f))) continue;
        corners.clear();
        for (const Halfedge h : around(Face(f))) corners.push_back(number[from(h).index]);
        mesh.add_face(corners);
    }
    return mesh;
}

void HalfedgeMesh::check() const
{
    const auto fail = [](const char* what, std::size_t i) {
        throw InvalidInput(std::string("halfedges: ") + what + " " + std::to_string(i) +
                           " is linked wrongly");
    };
    const auto n = static_cast<std::int32_t>(halfedge_slots());
    const auto is_vertex = [&](std::int32_t i) {
        return i >= 0 && i < static_cast<std::int32_t>(vertex_slots()) && is_alive(Vertex(i));
    };
    const auto is_halfedge = [&](std::int32_t i) {
        return i >= 0 && i < n && is_alive(Halfedge(i));
    };
    const auto is_face = [&](std::int32_t i) {
        return i >= 0 && i < static_cast<std::int32_t>(face_slots()) && is_alive(Face(i));
    };
    std::vector<std::uint8_t> entered(halfedge_slots(), 0);
    for (std::int32_t h = 0; h < n; ++h) {
        if (!is_alive(Halfedge(h))) continue;
        const std::int32_t o = opposite_[h], x = next_[h];
        const bool whole = is_halfedge(o) && o != h && opposite_[o] == h && is_halfedge(x) &&
                           is_vertex(to_[h]) && face_[x] == face_[h] && is_halfedge(opposite_[x]) &&
                           to_[opposite_[x]] == to_[h] && to_[o] != to_[h] && !entered[x] &&
                           (face_[h] == -1 || is_face(face_[h]));
        if (!whole) fail("halfedge", h);
        entered[x] = 1;
    }
    for (std::size_t f = 0; f < face_slots(); ++f) {
        if (!is_alive(Face(f))) continue;
        if (!is_halfedge(face_halfedge_[f]) ||
            face_[face_halfedge_[f]] != static_cast<std::int32_t>(f))
            fail("face", f);
    }
    for (std::size_t v = 0; v < vertex_slots(); ++v) {
        const std::int32_t h = vertex_halfedge_[v];
        if (h == kDead || h == -1) continue;
        if (!is_halfedge(h) || from(Halfedge(h)) != Vertex(v)) fail("vertex", v);
        for (const Halfedge out : outgoing(Vertex(v)))
            if (is_boundary(out) && out.index != h) fail("boundary vertex", v);
    }
    if (!vertices_are_regular()) fail("some vertex, of those numbered below", vertex_slots());
}

// ---------------------------------------------------------------------------------------------

TriangleHalfedgeMesh::TriangleHalfedgeMesh(IndexedMesh mesh) : mesh_(std::move(mesh))
{
    const TriangleSides sides(mesh_);
    check_indices(sides, n_vertices());
    opposite_.assign(sides.n_sides(), -1);
    if (!pair_sides(sides, n_vertices(), opposite_)) refuse(mesh_);
    vertex_halfedge_.assign(n_vertices(), -1);
    std::vector<std::int32_t> n_corners(n_vertices(), 0);
    const auto n = static_cast<std::int32_t>(opposite_.size());
    for (std::int32_t h = 0; h < n; ++h) {
        const std::int32_t v = corners()[h];
        ++n_corners[v];
        if (vertex_halfedge_[v] < 0 || opposite_[h] < 0) vertex_halfedge_[v] = h;
    }
    std::atomic<bool> good{true};
    parallel_for(n_vertices(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            std::int32_t count = 0;
            visit_ring(Vertex(v), [&](Vertex) { ++count; });
            count -= count > 0 && is_boundary(Vertex(v));
            if (count != n_corners[v]) good.store(false);
        }
    });
    if (!good.load()) refuse(mesh_);
}

std::size_t TriangleHalfedgeMesh::memory_bytes(std::size_t bytes_per_coordinate) const
{
    constexpr std::size_t kLink = sizeof(std::int32_t);
    return 3 * bytes_per_coordinate * n_vertices() +
           kLink * (3 * n_faces() + opposite_.size() + vertex_halfedge_.size());
}

}  // namespace genus
