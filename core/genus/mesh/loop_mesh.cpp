#include "genus/mesh/loop_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "genus/base/error.h"
#include "genus/mesh/disjoint_sets.h"
#include "genus/polygon/triangulate.h"

namespace genus {

namespace {

[[noreturn]] void refuse(const char* operation, const std::string& reason)
{
    throw InvalidInput(std::string(operation) + ": " + reason);
}

std::string text(const char* what, std::int32_t i)
{
    return std::string(what) + " " + std::to_string(i);
}

// A number that is free, or a new one.
template <class Grow>
std::int32_t take_number(std::vector<std::int32_t>& free, std::size_t n, const Grow& grow)
{
    if (free.empty()) {
        grow();
        return static_cast<std::int32_t>(n);
    }
    const std::int32_t i = free.back();
    free.pop_back();
    return i;
}

}  // namespace

// ---- elements ---------------------------------------------------------------------------------

void LoopMesh::demand_alive(Halfedge h, const char* operation) const
{
    if (!is_alive(h)) refuse(operation, text("there is no halfedge", h.index));
}

void LoopMesh::demand_alive(Corner c, const char* operation) const
{
    if (c.halfedge.valid()) return demand_alive(c.halfedge, operation);
    if (!is_alive(c.vertex)) refuse(operation, text("there is no vertex", c.vertex.index));
    if (!is_lone(c.vertex))
        refuse(operation,
               text("name a corner by its halfedge, there are edges at vertex", c.vertex.index));
}

Vertex LoopMesh::add_vertex(const Vec3& point)
{
    const Vertex v(take_number(free_vertices_, points_.size(), [&] {
        points_.emplace_back();
        vertex_link_.push_back(kDead);
    }));
    points_[v.index] = point;
    return v;
}

// Two halfedges, linked to nothing.
Halfedge LoopMesh::add_edge(Vertex from, Vertex to)
{
    const std::int32_t e = take_number(free_edges_, next_.size() / 2, [&] {
        for (auto* array : {&from_, &next_, &previous_, &loop_})
            array->resize(array->size() + 2, kDead);
    });
    const Halfedge h(2 * e);
    from_[h.index] = from.index;
    from_[h.index + 1] = to.index;
    vertex_link_[from.index] = h.index;
    vertex_link_[to.index] = h.index + 1;
    return h;
}

Loop LoopMesh::add_loop(Face f)
{
    const Loop l(take_number(free_loops_, loops_.size(), [&] { loops_.emplace_back(); }));
    loops_[l.index] = {};
    loops_[l.index].face = f.index;
    append_loop(f, l);
    return l;
}

Face LoopMesh::add_face()
{
    const Face f(take_number(free_faces_, face_loop_.size(), [&] { face_loop_.push_back(-1); }));
    face_loop_[f.index] = -1;
    return f;
}

void LoopMesh::kill(Vertex v)
{
    vertex_link_[v.index] = kDead;
    free_vertices_.push_back(v.index);
}

void LoopMesh::kill_edge(Halfedge h)
{
    for (const Halfedge x : {h, opposite(h)})
        from_[x.index] = next_[x.index] = previous_[x.index] = loop_[x.index] = kDead;
    free_edges_.push_back(h.index / 2);
}

void LoopMesh::kill_loop(Loop l)
{
    unlink_loop(l);
    loops_[l.index].face = kDead;
    free_loops_.push_back(l.index);
}

void LoopMesh::kill(Face f)
{
    face_loop_[f.index] = kDead;
    free_faces_.push_back(f.index);
}

void LoopMesh::make_lone(Vertex v, Loop l)
{
    vertex_link_[v.index] = -3 - l.index;
    loops_[l.index].halfedge = -1;
    loops_[l.index].vertex = v.index;
}

void LoopMesh::link(Halfedge h, Halfedge next)
{
    next_[h.index] = next.index;
    previous_[next.index] = h.index;
}

void LoopMesh::insert_before(Halfedge h, Halfedge fresh)
{
    link(previous(h), fresh);
    link(fresh, h);
    loop_[fresh.index] = loop_[h.index];
}

// The cycle closes behind h; a loop that began with h begins with the next one, or has none.
void LoopMesh::take_out(Halfedge h)
{
    LoopEntry& entry = loops_[loop_[h.index]];
    if (next(h) == h) {
        entry.halfedge = -1;
        return;
    }
    if (entry.halfedge == h.index) entry.halfedge = next_[h.index];
    link(previous(h), next(h));
}

// The start of h shall not know it any more. Halfedges that leave it are opposites of those before.
void LoopMesh::leave(Halfedge h)
{
    std::int32_t& link = vertex_link_[from_[h.index]];
    if (link == h.index) link = opposite(previous(h)).index;
}

void LoopMesh::name_loop(Halfedge first, Loop l)
{
    loops_[l.index].halfedge = first.index;
    loops_[l.index].vertex = -1;
    Halfedge h = first;
    do {
        loop_[h.index] = l.index;
        h = next(h);
    } while (h != first);
}

void LoopMesh::append_loop(Face f, Loop l)
{
    loops_[l.index].next = -1;
    loops_[l.index].face = f.index;
    std::int32_t* last = &face_loop_[f.index];
    while (*last >= 0) last = &loops_[*last].next;
    *last = l.index;
}

void LoopMesh::unlink_loop(Loop l)
{
    std::int32_t* at = &face_loop_[loops_[l.index].face];
    while (*at != l.index) at = &loops_[*at].next;
    *at = loops_[l.index].next;
    loops_[l.index].next = -1;
}

Halfedge LoopMesh::halfedge(Vertex v) const
{
    return is_lone(v) ? Halfedge() : Halfedge(vertex_link_[v.index]);
}

std::vector<Loop> LoopMesh::loops(Face f) const
{
    std::vector<Loop> out;
    for (std::int32_t l = face_loop_[f.index]; l >= 0; l = loops_[l].next) out.emplace_back(l);
    return out;
}

// ---- vertex, face, shell ----------------------------------------------------------------------

Vertex LoopMesh::mvfs(const Vec3& point)
{
    const Vertex v = add_vertex(point);
    make_lone(v, add_loop(add_face()));
    return v;
}

void LoopMesh::kvfs(Vertex v)
{
    demand_alive(Corner(v), "kvfs");
    const Loop l = loop(v);
    const Face f = face(l);
    if (outer(f) != l || loops_[l.index].next >= 0)
        refuse("kvfs", text("there is more than the vertex in face", f.index));
    kill_loop(l);
    kill(f);
    kill(v);
}

// ---- edge, vertex -----------------------------------------------------------------------------

Halfedge LoopMesh::mev(Corner corner, const Vec3& point)
{
    demand_alive(corner, "mev");
    if (corner.halfedge.valid()) return mev(corner.halfedge, corner.halfedge, point);
    const Loop l = loop(corner.vertex);
    const Halfedge h = add_edge(corner.vertex, add_vertex(point));
    link(h, opposite(h));
    link(opposite(h), h);
    name_loop(h, l);
    return h;
}

// Before a: the new halfedge, before b: its opposite. All between is seen from the new vertex.
Halfedge LoopMesh::mev(Halfedge a, Halfedge b, const Vec3& point)
{
    demand_alive(a, "mev");
    demand_alive(b, "mev");
    if (from(a) != from(b))
        refuse("mev", "halfedges " + std::to_string(a.index) + " and " + std::to_string(b.index) +
                          " leave different vertices");
    std::vector<Halfedge> moved;
    for (Halfedge h = a; h != b; h = next(opposite(h))) moved.push_back(h);
    const Vertex v = from(a), w = add_vertex(point);
    const Halfedge h = add_edge(v, w);
    insert_before(a, h);
    insert_before(b, opposite(h));
    for (const Halfedge x : moved) from_[x.index] = w.index;
    return h;
}

void LoopMesh::kev(Halfedge h)
{
    demand_alive(h, "kev");
    const Vertex v = from(h), w = to(h);
    const Halfedge o = opposite(h);
    if (v == w) refuse("kev", text("one vertex on both ends of halfedge", h.index));
    const Loop last = loop(h);
    if (next(h) == o && next(o) == h) {
        kill_edge(h);
        make_lone(v, last);
        return kill(w);
    }
    std::vector<Halfedge> moved;
    for (Halfedge x = next(h); x != o; x = next(opposite(x))) moved.push_back(x);
    leave(h);
    if (vertex_link_[v.index] == h.index) vertex_link_[v.index] = -1;  // a strut, seen from its tip
    take_out(h);
    take_out(o);
    for (const Halfedge x : moved) from_[x.index] = v.index;
    if (!moved.empty()) vertex_link_[v.index] = moved.front().index;
    kill_edge(h);
    kill(w);
}

// ---- edge, face -------------------------------------------------------------------------------

Halfedge LoopMesh::mef(Corner a, Corner b)
{
    demand_alive(a, "mef");
    demand_alive(b, "mef");
    const Loop l = loop(a);
    if (l != loop(b)) refuse("mef", "the corners are of different loops");
    const Halfedge h = add_edge(vertex(a), vertex(b)), o = opposite(h);
    const Loop fresh = add_loop(add_face());
    if (!a.halfedge.valid() || a.halfedge == b.halfedge) {
        link(o, o);
        if (a.halfedge.valid())
            insert_before(a.halfedge, h);
        else
            link(h, h);
    } else {
        const Halfedge before_a = previous(a.halfedge), before_b = previous(b.halfedge);
        link(before_a, h);
        link(h, b.halfedge);
        link(before_b, o);
        link(o, a.halfedge);
    }
    name_loop(h, l);
    name_loop(o, fresh);
    return h;
}

void LoopMesh::kef(Halfedge h)
{
    demand_alive(h, "kef");
    const Halfedge o = opposite(h);
    const Face g = face(o);
    if (face(h) == g) refuse("kef", text("one face on both sides of halfedge", h.index));
    if (loops_[face_loop_[g.index]].next >= 0)
        refuse("kef", text("there are rings in face", g.index));
    const Loop kept = loop(h), gone = loop(o);
    const Vertex v = from(h);
    const bool alone_h = next(h) == h, alone_o = next(o) == o;
    const Halfedge rest = !alone_h ? next(h) : next(o);
    if (!(alone_h && alone_o)) {
        const Halfedge before_h = previous(h), before_o = previous(o);
        const Halfedge after_h = next(h), after_o = next(o);
        if (alone_h || alone_o) {
            const Halfedge x = alone_h ? o : h;
            // A vertex with nothing but this edge, both of whose ends it is, would be alone.
            link(previous(x), next(x));
            vertex_link_[v.index] = next(x).index;
        } else {
            link(before_h, after_o);
            link(before_o, after_h);
            vertex_link_[from_[o.index]] = after_h.index;
            vertex_link_[v.index] = after_o.index;
        }
    }
    kill_edge(h);
    kill_loop(gone);
    kill(g);
    if (alone_h && alone_o)
        make_lone(v, kept);
    else
        name_loop(rest, kept);
}

// ---- edge, ring -------------------------------------------------------------------------------

Loop LoopMesh::kemr(Halfedge h)
{
    demand_alive(h, "kemr");
    const Halfedge o = opposite(h);
    if (loop(h) != loop(o))
        refuse("kemr", text("different loops on both sides of halfedge", h.index));
    const Loop kept = loop(h), ring = add_loop(face(kept));
    const Vertex v = from(h), w = to(h);
    const Halfedge after_h = next(h), after_o = next(o);
    const Halfedge before_h = previous(h), before_o = previous(o);
    kill_edge(h);
    if (after_o == h) {
        make_lone(v, kept);
    } else {
        link(before_h, after_o);
        vertex_link_[v.index] = after_o.index;
        name_loop(after_o, kept);
    }
    if (after_h == o) {
        make_lone(w, ring);
    } else {
        link(before_o, after_h);
        vertex_link_[w.index] = after_h.index;
        name_loop(after_h, ring);
    }
    return ring;
}

Halfedge LoopMesh::mekr(Corner a, Corner b)
{
    demand_alive(a, "mekr");
    demand_alive(b, "mekr");
    const Loop kept = loop(a), gone = loop(b);
    if (kept == gone) refuse("mekr", "the corners are of one loop");
    const Face f = face(kept);
    if (f != face(gone)) refuse("mekr", "the corners are of different faces");
    const Halfedge h = add_edge(vertex(a), vertex(b)), o = opposite(h);
    const Halfedge before_a = a.halfedge.valid() ? previous(a.halfedge) : o;
    const Halfedge before_b = b.halfedge.valid() ? previous(b.halfedge) : h;
    link(before_a, h);
    link(h, b.halfedge.valid() ? b.halfedge : o);
    link(before_b, o);
    link(o, a.halfedge.valid() ? a.halfedge : h);
    const bool was_outer = outer(f) == gone;
    kill_loop(gone);
    if (was_outer) {
        unlink_loop(kept);
        loops_[kept.index].next = face_loop_[f.index];
        face_loop_[f.index] = kept.index;
    }
    name_loop(h, kept);
    return h;
}

// ---- face, ring, hole -------------------------------------------------------------------------

void LoopMesh::kfmrh(Face f, Face g)
{
    for (const Face x : {f, g})
        if (!is_alive(x)) refuse("kfmrh", text("there is no face", x.index));
    if (f == g) refuse("kfmrh", "the faces are one");
    const Loop l = outer(g);
    if (loops_[l.index].next >= 0) refuse("kfmrh", text("there are rings in face", g.index));
    kill(g);
    append_loop(f, l);
}

Face LoopMesh::mfkrh(Loop ring)
{
    if (!is_alive(ring)) refuse("mfkrh", text("there is no loop", ring.index));
    if (outer(face(ring)) == ring)
        refuse("mfkrh", text("the outer one of its face is loop", ring.index));
    unlink_loop(ring);
    const Face f = add_face();
    append_loop(f, ring);
    return f;
}

// ---- the whole --------------------------------------------------------------------------------

// Faces hang together by edges. Numbers in the order of faces; -1 for dead ones.
std::vector<std::int32_t> LoopMesh::shell_of_face() const
{
    DisjointSets sets(face_slots());
    for (std::size_t h = 0; h < next_.size(); h += 2)
        if (is_alive(Halfedge(h)))
            sets.unite(face(Halfedge(h)).index, face(opposite(Halfedge(h))).index);
    std::vector<std::int32_t> shell(face_slots(), -1), number(face_slots(), -1);
    std::int32_t n = 0;
    for (std::size_t f = 0; f < face_slots(); ++f) {
        if (!is_alive(Face(f))) continue;
        std::int32_t& i = number[sets.find(static_cast<std::int32_t>(f))];
        if (i < 0) i = n++;
        shell[f] = i;
    }
    return shell;
}

std::vector<EulerCounts> LoopMesh::shells() const
{
    const std::vector<std::int32_t> shell = shell_of_face();
    const auto last = std::max_element(shell.begin(), shell.end());
    const std::size_t n = last == shell.end() ? 0 : static_cast<std::size_t>(*last + 1);
    std::vector<EulerCounts> counts(n);
    std::vector<std::int32_t> first(n, -1);
    for (EulerCounts& c : counts) c.shells = 1;
    for (std::size_t f = 0; f < face_slots(); ++f)
        if (shell[f] >= 0) ++counts[shell[f]].faces;
    for (std::size_t l = 0; l < loop_slots(); ++l)
        if (is_alive(Loop(l))) ++counts[shell[loops_[l].face]].loops;
    for (std::size_t h = 0; h < next_.size(); h += 2)
        if (is_alive(Halfedge(h))) ++counts[shell[face(Halfedge(h)).index]].edges;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const Vertex v(i);
        if (!is_alive(v)) continue;
        const std::int32_t s = shell[(is_lone(v) ? face(loop(v)) : face(halfedge(v))).index];
        ++counts[s].vertices;
        if (first[s] < 0) first[s] = v.index;
    }
    std::vector<std::size_t> order(n);
    for (std::size_t i = 0; i < n; ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return first[a] < first[b]; });
    std::vector<EulerCounts> sorted;
    for (const std::size_t i : order) sorted.push_back(counts[i]);
    return sorted;
}

EulerCounts LoopMesh::counts() const
{
    EulerCounts sum;
    for (const EulerCounts& c : shells()) {
        sum.vertices += c.vertices;
        sum.edges += c.edges;
        sum.faces += c.faces;
        sum.loops += c.loops;
        ++sum.shells;
    }
    return sum;
}

namespace {

// The plane in which a face is cut: that of its greatest shadow, by Newell's sum.
struct FacePlane {
    std::size_t x = 0, y = 1;

    FacePlane(const std::vector<Vec3>& ring)
    {
        Vec3 normal;
        for (std::size_t i = 0; i < ring.size(); ++i)
            normal += cross(ring[i] - ring[0], ring[(i + 1) % ring.size()] - ring[0]);
        std::size_t axis = 0;
        for (std::size_t i = 1; i < 3; ++i)
            if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
        x = (axis + 1) % 3;
        y = (axis + 2) % 3;
        if (normal[axis] < 0.0) std::swap(x, y);
    }

    Ring shadow(const std::vector<Vec3>& ring) const
    {
        Ring out;
        for (const Vec3& p : ring) out.push_back({{p[x], p[y]}});
        return out;
    }
};

}  // namespace

PolygonMesh LoopMesh::to_polygons() const
{
    PolygonMesh mesh;
    std::vector<std::int32_t> number(points_.size(), -1);
    for (std::size_t v = 0; v < points_.size(); ++v) {
        if (!is_alive(Vertex(v))) continue;
        number[v] = static_cast<std::int32_t>(mesh.n_vertices());
        mesh.vertices.push_back(points_[v]);
    }
    for (std::size_t f = 0; f < face_slots(); ++f) {
        if (!is_alive(Face(f))) continue;
        std::vector<std::int32_t> corners;
        Polygon polygon;
        std::vector<std::vector<Vec3>> rings;
        for (const Loop l : loops(Face(f))) {
            rings.emplace_back();
            Halfedge h = halfedge(l);
            while (h.valid()) {
                corners.push_back(number[from(h).index]);
                rings.back().push_back(point(from(h)));
                h = next(h) == halfedge(l) ? Halfedge() : next(h);
            }
            if (rings.back().size() < 3)
                refuse("to_polygons", text("fewer than three corners in loop", l.index));
        }
        if (rings.size() == 1) {
            mesh.add_face(corners);
            continue;
        }
        const FacePlane plane(rings[0]);
        polygon.outer = plane.shadow(rings[0]);
        for (std::size_t r = 1; r < rings.size(); ++r)
            polygon.holes.push_back(plane.shadow(rings[r]));
        try {
            for (const auto& [a, b, c] : triangulate(polygon))
                mesh.add_face(Triangle{corners[a], corners[b], corners[c]});
        } catch (const InvalidInput& e) {
            refuse("to_polygons", text("face", static_cast<std::int32_t>(f)) + ": " + e.what());
        }
    }
    return mesh;
}

void LoopMesh::check() const
{
    const auto demand = [](bool holds, const char* what, std::size_t i) {
        if (!holds)
            throw InvalidInput(std::string("loop mesh: ") + what + " " + std::to_string(i) +
                               " is linked wrongly");
    };
    std::vector<std::int32_t> n_leaving(points_.size(), 0), n_in_loop(loops_.size(), 0);
    for (std::size_t i = 0; i < next_.size(); ++i) {
        const Halfedge h(i);
        if (!is_alive(h)) continue;
        demand(is_alive(opposite(h)) && is_alive(next(h)) && is_alive(previous(h)), "halfedge", i);
        demand(next(previous(h)) == h && previous(next(h)) == h, "halfedge", i);
        demand(is_alive(from(h)) && from(next(h)) == to(h), "halfedge", i);
        demand(is_alive(loop(h)) && loop(next(h)) == loop(h), "halfedge", i);
        ++n_leaving[from(h).index];
        ++n_in_loop[loop(h).index];
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const Vertex v(i);
        if (!is_alive(v)) continue;
        if (is_lone(v)) {
            demand(n_leaving[i] == 0 && is_alive(loop(v)) && vertex(loop(v)) == v, "vertex", i);
            continue;
        }
        // Turning round the vertex meets all halfedges that leave it.
        const Halfedge first = halfedge(v);
        demand(is_alive(first) && from(first) == v, "vertex", i);
        std::int32_t n = 0;
        Halfedge h = first;
        do {
            ++n;
            h = next(opposite(h));
        } while (h != first && n <= n_leaving[i]);
        demand(n == n_leaving[i], "vertex", i);
    }
    std::size_t n_loops_of_faces = 0;
    for (std::size_t f = 0; f < face_slots(); ++f) {
        if (!is_alive(Face(f))) continue;
        demand(is_alive(outer(Face(f))), "face", f);
        for (const Loop l : loops(Face(f))) {
            demand(is_alive(l) && face(l) == Face(f), "loop", l.index);
            ++n_loops_of_faces;
        }
    }
    demand(n_loops_of_faces == n_loops(), "some loop of all", n_loops());
    for (std::size_t i = 0; i < loops_.size(); ++i) {
        const Loop l(i);
        if (!is_alive(l)) continue;
        if (!halfedge(l).valid()) {
            demand(n_in_loop[i] == 0 && is_alive(vertex(l)) && is_lone(vertex(l)), "loop", i);
            continue;
        }
        demand(is_alive(halfedge(l)) && loop(halfedge(l)) == l, "loop", i);
        std::int32_t n = 0;
        Halfedge h = halfedge(l);
        do {
            ++n;
            h = next(h);
        } while (h != halfedge(l) && n <= n_in_loop[i]);
        demand(n == n_in_loop[i], "loop", i);
    }
}

}  // namespace genus
