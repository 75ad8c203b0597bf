#include "genus/model/flexible_mesh.h"

#include <algorithm>
#include <array>

#include "genus/base/error.h"
#include "genus/mesh/sides.h"
#include "genus/model/fans.h"

namespace genus {

FlexibleMesh::FlexibleMesh(SurfaceMesh&& mesh)
    : points_(std::move(mesh.mesh.vertices)),
      size_(std::move(mesh.cell_size)),
      surfaces_(std::move(mesh.surfaces_of_vertex)),
      label_(std::move(mesh.surface_of_face)),
      touch_(std::move(mesh.touch_of_vertex))
{
    const TriangleSides sides(mesh.mesh);
    const EdgeTable edges =
        make_edge_table(sides, points_.size(), [](std::size_t) { return false; });
    twin_ = twins(edges, sides.n_sides());
    out_.assign(points_.size(), -1);
    from_.resize(sides.n_sides());
    for (std::int32_t s = 0; s < n_sides(); ++s) {
        from_[s] = sides.from(s);
        out_[from_[s]] = s;
        require(twin_[s] >= 0, "surface mesh is not closed");
    }
    places_ = vertices_by_place(touch_);
}

SurfaceMesh FlexibleMesh::release()
{
    SurfaceMesh mesh;
    std::vector<std::int32_t> number(points_.size(), -1);
    for (std::size_t v = 0; v < points_.size(); ++v) {
        if (out_[v] < 0) continue;
        number[v] = static_cast<std::int32_t>(mesh.mesh.n_vertices());
        mesh.mesh.vertices.push_back(points_[v]);
        mesh.surfaces_of_vertex.push_back(surfaces_[v]);
        mesh.cell_size.push_back(size_[v]);
        if (!touch_.empty()) mesh.touch_of_vertex.push_back(touch_[v]);
    }
    for (std::size_t f = 0; f < label_.size(); ++f) {
        if (from_[3 * f] < 0) continue;
        mesh.mesh.faces.push_back(
            {number[from_[3 * f]], number[from_[3 * f + 1]], number[from_[3 * f + 2]]});
        mesh.surface_of_face.push_back(label_[f]);
    }
    *this = FlexibleMesh(SurfaceMesh{});
    return mesh;
}

int FlexibleMesh::n_creases(std::int32_t v) const
{
    int n = 0;
    visit_ring(v, [&](std::int32_t s) { n += is_crease(s); });
    return n;
}

std::vector<std::int32_t> FlexibleMesh::coincident(std::int32_t s) const
{
    std::vector<std::int32_t> edges{s};
    if (!touches(from_[s]) || !touches(to(s))) return edges;
    const std::int32_t end = touch_[to(s)];
    for (const std::int32_t v : places_[touch_[from_[s]]]) {
        if (!exists(v)) continue;
        visit_ring(v, [&](std::int32_t x) {
            if (x != s && touch_[to(x)] == end) edges.push_back(x);
        });
    }
    return edges;
}

std::int32_t FlexibleMesh::side(std::int32_t from, std::int32_t to) const
{
    std::int32_t found = -1;
    visit_ring(from, [&](std::int32_t x) {
        if (this->to(x) == to) found = x;
    });
    return found;
}

bool FlexibleMesh::can_collapse_together(const std::vector<std::int32_t>& edges) const
{
    std::vector<std::int32_t> origins, rings;
    for (const std::int32_t s : edges) {
        origins.push_back(from_[s]);
        visit_ring(from_[s], [&](std::int32_t x) {
            if (x != s) rings.push_back(to(x));
        });
    }
    const auto all_differ = [](std::vector<std::int32_t>& list) {
        std::sort(list.begin(), list.end());
        return std::adjacent_find(list.begin(), list.end()) == list.end();
    };
    const std::vector<std::int32_t>& here = places_[touch_[origins[0]]];
    const auto n_here =
        std::count_if(here.begin(), here.end(), [&](std::int32_t v) { return exists(v); });
    if (static_cast<std::size_t>(n_here) != origins.size()) return false;
    rings.insert(rings.end(), origins.begin(), origins.end());
    return all_differ(origins) && all_differ(rings);
}

void FlexibleMesh::note_touch(const std::vector<std::int32_t>& vertices)
{
    if (touch_.empty() || vertices.size() < 2) return;
    for (const std::int32_t v : vertices) touch_[v] = static_cast<std::int32_t>(places_.size());
    places_.push_back(vertices);
}

std::int32_t FlexibleMesh::add_face(std::int32_t a, std::int32_t b, std::int32_t c,
                                    std::int32_t label)
{
    const std::int32_t s = n_sides();
    from_.insert(from_.end(), {a, b, c});
    twin_.insert(twin_.end(), {-1, -1, -1});
    label_.push_back(label);
    return s;
}

//        c                  c
//      / | \   the faces  /   \   s runs from a to b; the new face on each side takes the
//     a--m--b            a-----b  half towards b on s's side, towards a on the other.
//      \ | /              \   /
//        d                  d
std::int32_t FlexibleMesh::split(std::int32_t s, const Vec3& p,
                                 const std::array<std::int32_t, 3>& surfaces)
{
    const std::int32_t t = twin_[s];
    const std::int32_t a = from_[s], b = from_[t], c = apex(s), d = apex(t);
    const auto m = static_cast<std::int32_t>(points_.size());
    points_.push_back(p);
    size_.push_back(std::min(size_[a], size_[b]));
    surfaces_.push_back(surfaces);
    if (!touch_.empty()) touch_.push_back(-1);

    const std::int32_t bc = twin_[next(s)], ad = twin_[next(t)];
    const std::int32_t s2 = add_face(m, b, c, label_[s / 3]);
    const std::int32_t t2 = add_face(m, a, d, label_[t / 3]);
    from_[next(s)] = m;
    from_[next(t)] = m;
    join(s2 + 1, bc);
    join(t2 + 1, ad);
    join(s2 + 2, next(s));
    join(t2 + 2, next(t));
    join(s, t2);
    join(t, s2);
    out_.push_back(s2);
    out_[a] = s;
    out_[b] = t;
    return m;
}

bool FlexibleMesh::flip(std::int32_t s)
{
    const std::int32_t t = twin_[s];
    const std::int32_t a = from_[s], b = from_[t], c = apex(s), d = apex(t);
    if (c == d) return false;
    bool joined = false;
    visit_ring(c, [&](std::int32_t side) { joined = joined || to(side) == d; });
    if (joined) return false;
    // Faces (a, b, c) and (b, a, d) become (d, c, a) and (c, d, b).
    const std::int32_t bc = twin_[next(s)], ca = twin_[previous(s)];
    const std::int32_t ad = twin_[next(t)], db = twin_[previous(t)];
    from_[s] = d;
    from_[next(s)] = c;
    from_[previous(s)] = a;
    from_[t] = c;
    from_[next(t)] = d;
    from_[previous(t)] = b;
    join(next(s), ca);
    join(previous(s), ad);
    join(next(t), db);
    join(previous(t), bc);
    out_[a] = previous(s);
    out_[b] = previous(t);
    out_[c] = t;
    out_[d] = s;
    return true;
}

bool FlexibleMesh::can_collapse(std::int32_t s) const
{
    const std::int32_t a = from_[s], b = to(s);
    if (apex(s) == apex(twin_[s])) return false;
    std::array<std::int32_t, 32> ring;
    std::size_t valence_a = 0, valence_b = 0, common = 0;
    visit_ring(b, [&](std::int32_t y) {
        if (valence_b < ring.size()) ring[valence_b] = to(y);
        ++valence_b;
    });
    const bool fits = valence_b <= ring.size();
    visit_ring(a, [&](std::int32_t x) {
        ++valence_a;
        const std::int32_t w = to(x);
        if (w == b) return;
        if (fits)
            common +=
                static_cast<std::size_t>(std::count(ring.begin(), ring.begin() + valence_b, w));
        else
            visit_ring(b, [&](std::int32_t y) { common += to(y) == w; });
    });
    return common == 2 && valence_a + valence_b > 7;
}

void FlexibleMesh::collapse(std::int32_t s)
{
    const std::int32_t t = twin_[s];
    const std::int32_t a = from_[s], b = from_[t], c = apex(s), d = apex(t);
    visit_ring(a, [&](std::int32_t x) { from_[x] = b; });
    const std::int32_t bc = twin_[next(s)], ca = twin_[previous(s)];
    const std::int32_t ad = twin_[next(t)], db = twin_[previous(t)];
    join(bc, ca);
    join(ad, db);
    out_[a] = -1;
    out_[b] = ca;  // ran from a to c
    out_[c] = bc;  // runs from c to b
    out_[d] = ad;  // runs from d to b
    for (const std::int32_t x : {s, t}) from_[x] = from_[next(x)] = from_[previous(x)] = -1;
}

}  // namespace genus
