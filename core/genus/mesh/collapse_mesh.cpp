#include "genus/mesh/collapse_mesh.h"

#include <algorithm>

namespace genus {

CollapseMesh::CollapseMesh(const TriangleHalfedgeMesh& mesh)
    : corners_(mesh.n_halfedges()), leaving_(mesh.vertex_halfedges()), n_faces_(mesh.n_faces())
{
    for (std::size_t s = 0; s < corners_.size(); ++s)
        corners_[s] = {mesh.from(Halfedge(s)).index, mesh.opposites()[s]};
}

void CollapseMesh::gather_ring(std::int32_t v, std::vector<std::int32_t>& ring) const
{
    ring.clear();
    Side last = kNone;
    visit_leaving(v, [&](Side s) {
        ring.push_back(to(s));
        last = s;
    });
    if (opposite(previous(last)) == kNone) ring.push_back(from(previous(last)));
}

bool CollapseMesh::can_collapse(Side s)
{
    const Side o = opposite(s);
    const std::int32_t a = from(s), b = to(s);
    if (o != kNone && is_boundary(a) && is_boundary(b)) return false;
    std::size_t third_corners = 0;
    for (const Side side : {s, o}) {
        if (side == kNone) continue;
        // The edges to the third corner become one: enough others must be left there.
        const std::int32_t c = from(previous(side));
        gather_ring(c, ring_a_);
        if (ring_a_.size() < (is_boundary(c) ? 3 : 4)) return false;
        ++third_corners;
    }
    gather_ring(a, ring_a_);
    gather_ring(b, ring_b_);
    std::size_t common = 0;
    for (const std::int32_t x : ring_a_)
        common += std::find(ring_b_.begin(), ring_b_.end(), x) != ring_b_.end();
    return common == third_corners;
}

void CollapseMesh::join(Side s, Side t)
{
    if (s != kNone) corners_[s].opposite = t;
    if (t != kNone) corners_[t].opposite = s;
}

// The face of s is gone: those beyond its two other sides become neighbours.
void CollapseMesh::close(Side s)
{
    const Side n = next(s), p = previous(s);
    const Side beyond_n = opposite(n), beyond_p = opposite(p);
    const std::int32_t c = from(p);
    join(beyond_n, beyond_p);
    for (const Side side : {s, n, p}) corners_[side] = {-1, kNone};
    --n_faces_;
    // Of the sides beyond, one leaves the third corner and the other comes to it.
    leaving_[c] = beyond_n != kNone ? beyond_n : next(beyond_p);
    start_at(leaving_[c]);
}

// Makes `s`, or the last one clockwise from it, that from which its vertex is walked round.
void CollapseMesh::start_at(Side s)
{
    Side first = s;
    while (opposite(first) != kNone) {
        first = next(opposite(first));
        if (first == s) break;
    }
    leaving_[from(s)] = first;
}

bool CollapseMesh::collapse(Side s)
{
    if (!can_collapse(s)) return false;
    const Side o = opposite(s);
    const std::int32_t a = from(s), b = to(s);
    moved_.clear();
    for (const std::int32_t v : {a, b}) visit_leaving(v, [&](Side x) { moved_.push_back(x); });
    for (const Side x : moved_) corners_[x].vertex = b;
    close(s);
    if (o != kNone) close(o);
    leaving_[a] = kNone;
    for (const Side x : moved_)
        if (is_alive(x)) {
            start_at(x);
            break;
        }
    return true;
}

}  // namespace genus
