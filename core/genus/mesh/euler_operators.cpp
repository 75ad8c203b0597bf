// The Euler operators of HalfedgeMesh.
//
// Implements [mantyla1988], chapter 9 (operators on halfedges), for faces bounded by one loop;
// the link condition of the edge collapse as in [botsch2010], section 7.2.

#include <array>
#include <string>
#include <vector>

#include "genus/base/error.h"
#include "genus/mesh/halfedge_mesh.h"

namespace genus {

namespace {

[[noreturn]] void refuse(const char* operation, Halfedge h, const char* reason)
{
    throw InvalidInput(std::string(operation) + " at halfedge " + std::to_string(h.index) + ": " +
                       reason);
}

}  // namespace

// ---- elements ---------------------------------------------------------------------------------

Vertex HalfedgeMesh::add_vertex(const Vec3& point)
{
    points_.push_back(point);
    vertex_halfedge_.push_back(-1);
    vertex_properties_.resize(points_.size());
    return Vertex(points_.size() - 1);
}

// Two halfedges, there and back, not linked to anything.
Halfedge HalfedgeMesh::add_edge(Vertex from, Vertex to)
{
    const auto h = static_cast<std::int32_t>(to_.size());
    to_.insert(to_.end(), {to.index, from.index});
    opposite_.insert(opposite_.end(), {h + 1, h});
    next_.insert(next_.end(), {-1, -1});
    face_.insert(face_.end(), {-1, -1});
    halfedge_properties_.resize(to_.size());
    return Halfedge(h);
}

Face HalfedgeMesh::add_face()
{
    face_halfedge_.push_back(-1);
    face_properties_.resize(face_halfedge_.size());
    return Face(face_halfedge_.size() - 1);
}

void HalfedgeMesh::set_loop(std::initializer_list<Halfedge> loop, Face f)
{
    for (auto h = loop.begin(); h != loop.end(); ++h) {
        link(*h, h + 1 != loop.end() ? h[1] : *loop.begin());
        set_face(*h, f);
    }
    face_halfedge_[f.index] = loop.begin()->index;
}

void HalfedgeMesh::remove_edge(Halfedge h)
{
    const Halfedge o = opposite(h);
    for (const Halfedge x : {h, o}) to_[x.index] = opposite_[x.index] = next_[x.index] = kDead;
    ++dead_edges_;
}

void HalfedgeMesh::remove_face(Face f)
{
    face_halfedge_[f.index] = kDead;
    ++dead_faces_;
}

// ---- faces ------------------------------------------------------------------------------------

Vertex HalfedgeMesh::split_face(Face f, const Vec3& point)
{
    std::vector<Halfedge> sides;
    for (const Halfedge h : around(f)) sides.push_back(h);
    const Vertex center = add_vertex(point);
    std::vector<Halfedge> inward;  // from the start of each side to the centre
    for (const Halfedge h : sides) inward.push_back(add_edge(from(h), center));
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const Halfedge in = inward[i + 1 < sides.size() ? i + 1 : 0];
        set_loop({sides[i], in, opposite(inward[i])}, i == 0 ? f : add_face());
    }
    vertex_halfedge_[center.index] = opposite(inward[0]).index;
    return center;
}

bool HalfedgeMesh::can_split_face(Halfedge a, Halfedge b) const
{
    return a != b && !is_boundary(a) && face(a) == face(b) && next(a) != b && next(b) != a &&
           !find(from(a), from(b)).valid();
}

Halfedge HalfedgeMesh::split_face(Halfedge a, Halfedge b)
{
    if (!can_split_face(a, b))
        refuse("split_face", a, "the corners are neighbours or not of one face");
    const Face f = face(a), g = add_face();
    const Halfedge before_a = previous(a), before_b = previous(b);
    const Halfedge h = add_edge(from(a), from(b)), o = opposite(h);
    link(before_a, h);
    link(h, b);
    link(before_b, o);
    link(o, a);
    set_face(h, f);
    face_halfedge_[f.index] = h.index;
    face_halfedge_[g.index] = o.index;
    for (const Halfedge x : around(o)) set_face(x, g);
    return h;
}

bool HalfedgeMesh::can_join_faces(Halfedge h) const
{
    const Halfedge o = opposite(h);
    if (is_boundary(h) || is_boundary(o) || face(h) == face(o)) return false;
    if (valence(from(h)) < 3 || valence(to(h)) < 3) return false;
    std::size_t common = 0;  // corners of both faces: the ends of the edge, no more
    for (const Halfedge x : around(face(h)))
        for (const Halfedge y : around(face(o))) common += to(x) == to(y);
    return common == 2;
}

void HalfedgeMesh::join_faces(Halfedge h)
{
    if (!can_join_faces(h)) refuse("join_faces", h, "the faces share more than one edge, or none");
    const Halfedge o = opposite(h);
    const Face f = face(h), g = face(o);
    const Halfedge after_h = next(h), after_o = next(o);
    const Vertex a = from(h), b = to(h);
    link(previous(h), after_o);
    link(previous(o), after_h);
    for (const Halfedge x : around(after_o)) set_face(x, f);
    face_halfedge_[f.index] = after_h.index;
    if (halfedge(a) == h) vertex_halfedge_[a.index] = after_o.index;
    if (halfedge(b) == o) vertex_halfedge_[b.index] = after_h.index;
    remove_face(g);
    remove_edge(h);
}

// ---- edges ------------------------------------------------------------------------------------

//        c                     c
//      /   \                 / | \ .
//     a --h-> b     ->      a -v- b       h leads from a to v, the new halfedge from v to b
//      \   /                 \ | /
//        d                     d
Vertex HalfedgeMesh::split_edge(Halfedge h, const Vec3& point)
{
    const Halfedge o = opposite(h), after_h = next(h), before_o = previous(o);
    const bool cut_left = is_triangle(h), cut_right = is_triangle(o);
    const Vertex b = to(h), v = add_vertex(point);
    const Halfedge onward = add_edge(v, b), back = opposite(onward);
    to_[h.index] = v.index;
    link(h, onward);
    link(onward, after_h);
    link(before_o, back);
    link(back, o);
    face_[onward.index] = face_[h.index];
    face_[back.index] = face_[o.index];
    if (halfedge(b) == o) vertex_halfedge_[b.index] = back.index;
    vertex_halfedge_[v.index] = is_boundary(o) ? o.index : onward.index;
    if (cut_left) split_face(onward, next(after_h));
    if (cut_right) split_face(o, before_o);
    return v;
}

bool HalfedgeMesh::can_flip_edge(Halfedge h) const
{
    const Halfedge o = opposite(h);
    return is_triangle(h) && is_triangle(o) && !find(to(next(h)), to(next(o))).valid();
}

//        c                 c
//      /   \             / | \ .
//     a --h-> b    ->   a  h  b      h leads from d to c
//      \   /             \ | /
//        d                 d
void HalfedgeMesh::flip_edge(Halfedge h)
{
    if (!can_flip_edge(h))
        refuse("flip_edge", h, "not between two triangles whose far corners are apart");
    const Halfedge o = opposite(h);
    const Halfedge bc = next(h), ca = next(bc), ad = next(o), db = next(ad);
    const Vertex a = to(o), b = to(h);
    if (halfedge(a) == h) vertex_halfedge_[a.index] = ad.index;
    if (halfedge(b) == o) vertex_halfedge_[b.index] = bc.index;
    to_[h.index] = to(bc).index;
    to_[o.index] = to(ad).index;
    const Face f = face(h), g = face(o);
    set_loop({h, ca, ad}, f);
    set_loop({o, db, bc}, g);
}

// So many at least.
bool HalfedgeMesh::has_edges(Vertex v, int n) const
{
    for ([[maybe_unused]] const Halfedge h : outgoing(v))
        if (--n == 0) return true;
    return false;
}

bool HalfedgeMesh::can_collapse_edge(Halfedge h) const
{
    const Halfedge o = opposite(h);
    const Vertex a = from(h), b = to(h);
    const bool edge_on_boundary = is_boundary(h) || is_boundary(o);
    if (is_boundary(a) && is_boundary(b) && !edge_on_boundary) return false;
    std::size_t third_corners = 0;
    for (const Halfedge side : {h, o}) {
        // The edges to the third corner become one: enough others must be left there.
        if (is_triangle(side)) {
            const Vertex c = to(next(side));
            if (!has_edges(c, is_boundary(c) ? 3 : 4)) return false;
            ++third_corners;
        }
        // A hole of three sides would vanish.
        if (is_boundary(side) && next(next(next(side))) == side) return false;
    }
    std::size_t common = 0;
    for (const Halfedge x : outgoing(a)) {
        common += find(b, to(x)).valid();
        // No other face may have both ends as corners.
        if (is_boundary(x) || face(x) == face(h) || face(x) == face(o)) continue;
        for (const Halfedge y : around(face(x)))
            if (to(y) == b) return false;
    }
    return common == third_corners;
}

// Two halfedges there and back are left of a triangle: their opposites become one edge.
void HalfedgeMesh::close_digon(Halfedge h)
{
    const Halfedge g = next(h), beyond_h = opposite(h), beyond_g = opposite(g);
    const Vertex c = to(h);
    remove_face(face(h));
    opposite_[beyond_h.index] = beyond_g.index;
    opposite_[beyond_g.index] = beyond_h.index;
    if (halfedge(c) == g) vertex_halfedge_[c.index] = beyond_h.index;
    to_[h.index] = to_[g.index] = kDead;
    opposite_[h.index] = opposite_[g.index] = next_[h.index] = next_[g.index] = kDead;
    ++dead_edges_;
}

void HalfedgeMesh::collapse_edge(Halfedge h)
{
    if (!try_collapse_edge(h)) refuse("collapse_edge", h, "the link condition does not hold");
}

bool HalfedgeMesh::try_collapse_edge(Halfedge h)
{
    if (!can_collapse_edge(h)) return false;
    const Halfedge o = opposite(h);
    const Vertex a = from(h), b = to(h);
    std::vector<Halfedge> leaving;  // b afterwards
    leaving.reserve(16);
    for (const Halfedge x : outgoing(a)) leaving.push_back(x);
    for (const Halfedge x : leaving) to_[opposite(x).index] = b.index;
    for (const Halfedge x : outgoing(b)) leaving.push_back(x);
    const std::array<Halfedge, 2> after{next(h), next(o)};
    for (const Halfedge side : {h, o}) {
        const Halfedge following = next(side);
        link(previous(side), following);
        if (!is_boundary(side)) face_halfedge_[face(side).index] = following.index;
    }
    vertex_halfedge_[a.index] = kDead;
    ++dead_vertices_;
    remove_edge(h);
    for (const Halfedge side : after)
        if (!is_boundary(side) && next(next(side)) == side) close_digon(side);
    vertex_halfedge_[b.index] = -1;
    for (const Halfedge x : leaving)
        if (is_alive(x) && (!halfedge(b).valid() || is_boundary(x)))
            vertex_halfedge_[b.index] = x.index;
    return true;
}

// ---- numbers ----------------------------------------------------------------------------------

void HalfedgeMesh::compact()
{
    const auto number = [](std::size_t slots, const auto& alive) {
        std::vector<std::int32_t> numbers(slots, -1);
        std::int32_t n = 0;
        for (std::size_t i = 0; i < slots; ++i)
            if (alive(i)) numbers[i] = n++;
        return numbers;
    };
    const auto vertices = number(vertex_slots(), [&](auto i) { return is_alive(Vertex(i)); });
    const auto halfedges = number(halfedge_slots(), [&](auto i) { return is_alive(Halfedge(i)); });
    const auto faces = number(face_slots(), [&](auto i) { return is_alive(Face(i)); });
    const auto renamed = [](const std::vector<std::int32_t>& numbers, std::int32_t i) {
        return i >= 0 ? numbers[i] : i;
    };
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (vertices[i] < 0) continue;
        points_[vertices[i]] = points_[i];
        vertex_halfedge_[vertices[i]] = renamed(halfedges, vertex_halfedge_[i]);
        vertex_properties_.move_entry(i, vertices[i]);
    }
    for (std::size_t i = 0; i < halfedges.size(); ++i) {
        const std::int32_t h = halfedges[i];
        if (h < 0) continue;
        opposite_[h] = halfedges[opposite_[i]];
        next_[h] = halfedges[next_[i]];
        to_[h] = vertices[to_[i]];
        face_[h] = renamed(faces, face_[i]);
        halfedge_properties_.move_entry(i, h);
    }
    for (std::size_t i = 0; i < faces.size(); ++i) {
        if (faces[i] < 0) continue;
        face_halfedge_[faces[i]] = halfedges[face_halfedge_[i]];
        face_properties_.move_entry(i, faces[i]);
    }
    const std::size_t nv = n_vertices(), nh = n_halfedges(), nf = n_faces();
    points_.resize(nv);
    vertex_halfedge_.resize(nv);
    for (auto* array : {&opposite_, &next_, &to_, &face_}) array->resize(nh);
    face_halfedge_.resize(nf);
    vertex_properties_.resize(nv);
    halfedge_properties_.resize(nh);
    face_properties_.resize(nf);
    dead_vertices_ = dead_edges_ = dead_faces_ = 0;
}

}  // namespace genus
