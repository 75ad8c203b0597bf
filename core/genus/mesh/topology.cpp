#include "genus/mesh/topology.h"

#include <algorithm>
#include <limits>
#include <map>

#include "genus/mesh/disjoint_sets.h"
#include "genus/mesh/sides.h"

namespace genus {

namespace {

template <class Sides>
class TopologyBuilder {
public:
    TopologyBuilder(const Sides& sides, std::size_t n_vertices)
        : sides_(sides), n_vertices_(n_vertices), degenerate_(sides.n_faces(), 0)
    {
    }

    Topology run()
    {
        check_indices(sides_, n_vertices_);
        find_degenerate_faces();
        table_ =
            make_edge_table(sides_, n_vertices_, [&](std::size_t f) { return degenerate_[f]; });
        twin_ = twins(table_, sides_.n_sides());
        find_components();
        count_faces_and_vertices();
        look_at_edges();
        find_complex_vertices();
        count_boundary_loops();
        if (!flipped_in_.empty()) find_one_sided_components();
        conclude();
        return std::move(out_);
    }

private:
    void find_degenerate_faces()
    {
        for (std::size_t f = 0; f < sides_.n_faces(); ++f) {
            if (!names_a_vertex_twice(sides_, f)) continue;
            degenerate_[f] = 1;
            out_.degenerate_faces.push_back(static_cast<std::int32_t>(f));
        }
    }

    SurfaceKind& component_at(std::int32_t vertex)
    {
        return out_.components[out_.component_of_vertex[vertex]];
    }

    void find_components()
    {
        DisjointSets sets(n_vertices_);
        std::vector<std::uint8_t> used(n_vertices_, 0);
        for (std::size_t f = 0; f < sides_.n_faces(); ++f) {
            if (degenerate_[f]) continue;
            const std::int32_t first = sides_.first(f);
            for (std::int32_t i = 0; i < sides_.degree(f); ++i) {
                used[sides_.from(first + i)] = 1;
                if (i > 0) sets.unite(sides_.from(first), sides_.from(first + i));
            }
        }
        current_progress().check();
        std::vector<std::int32_t>& label = out_.component_of_vertex;
        label.assign(n_vertices_, -1);
        std::int32_t n = 0;
        for (std::size_t v = 0; v < n_vertices_; ++v) {
            if (!used[v]) continue;
            const std::int32_t root = sets.find(static_cast<std::int32_t>(v));
            if (label[root] < 0) label[root] = n++;
            label[v] = label[root];
        }
        out_.components.resize(n);
    }

    void count_faces_and_vertices()
    {
        for (std::size_t f = 0; f < sides_.n_faces(); ++f)
            if (!degenerate_[f]) ++component_at(sides_.from(sides_.first(f))).faces;
        for (const std::int32_t component : out_.component_of_vertex) {
            if (component < 0)
                ++out_.isolated_vertices;
            else
                ++out_.components[component].vertices;
        }
    }

    void look_at_edges()
    {
        valence_.assign(n_vertices_, 0);
        for (std::size_t e = 0; e < table_.n_edges(); ++e) {
            const std::int32_t* side = table_.sides.data() + table_.starts[e];
            const std::int32_t from = sides_.from(side[0]), to = sides_.to(side[0]);
            ++valence_[from];
            ++valence_[to];
            SurfaceKind& component = component_at(from);
            ++component.edges;
            const std::int32_t n = table_.n_faces(e);
            if (n == 1) {
                ++component.boundary_edges;
                boundary_.push_back(side[0]);
            } else if (n > 2) {
                add_complex_edge(side, n);
            } else if (sides_.from(side[1]) == from) {
                component.oriented = false;
                flipped_in_.push_back(out_.component_of_vertex[from]);
                out_.flipped_edges.push_back({std::min(from, to),
                                              std::max(from, to),
                                              {sides_.face(side[0]), sides_.face(side[1])}});
            }
        }
        std::sort(boundary_.begin(), boundary_.end());
        for (const std::int32_t side : boundary_)
            out_.open_edges.push_back({sides_.from(side), sides_.to(side), sides_.face(side)});
    }

    void add_complex_edge(const std::int32_t* side, std::int32_t n)
    {
        const std::int32_t from = sides_.from(side[0]), to = sides_.to(side[0]);
        ComplexEdge edge{std::min(from, to), std::max(from, to), {}};
        for (std::int32_t i = 0; i < n; ++i) edge.faces.push_back(sides_.face(side[i]));
        out_.complex_edges.push_back(std::move(edge));
        component_at(from).manifold = false;
    }

    // A vertex is regular if one walk round it meets all its corners.
    void find_complex_vertices()
    {
        std::vector<std::int32_t> first_corner(n_vertices_, -1), n_corners(n_vertices_, 0);
        for (std::size_t f = 0; f < sides_.n_faces(); ++f) {
            if (degenerate_[f]) continue;
            for (std::int32_t i = 0; i < sides_.degree(f); ++i) {
                const std::int32_t corner = sides_.first(f) + i, v = sides_.from(corner);
                if (n_corners[v]++ == 0) first_corner[v] = corner;
            }
        }
        std::vector<std::uint8_t> doubtful(n_vertices_, 0);
        parallel_for(n_vertices_, 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v)
                doubtful[v] = n_corners[v] > 0 && corners_of_fan(first_corner[v]) < n_corners[v];
        });
        if (std::find(doubtful.begin(), doubtful.end(), 1) != doubtful.end()) count_fans(doubtful);
    }

    std::int32_t corners_of_fan(std::int32_t start) const
    {
        std::int32_t count = 1;
        bool round = false;
        const auto visit = [&](std::int32_t corner) {
            round = corner == start;
            count += !round;
            return !round;
        };
        const std::int32_t v = sides_.from(start);
        walk_around(sides_, twin_, v, start, visit);
        if (!round) walk_around(sides_, twin_, v, sides_.previous(start), visit);
        return count;
    }

    // Unites the faces at each doubtful vertex across all edges, complex ones too.
    void count_fans(const std::vector<std::uint8_t>& doubtful)
    {
        std::vector<std::int32_t> corners;
        for (std::size_t f = 0; f < sides_.n_faces(); ++f)
            for (std::int32_t i = 0; i < sides_.degree(f) && !degenerate_[f]; ++i)
                if (doubtful[sides_.from(sides_.first(f) + i)])
                    corners.push_back(sides_.first(f) + i);
        const auto number = [&](std::int32_t corner) {
            const auto at = std::lower_bound(corners.begin(), corners.end(), corner);
            return static_cast<std::int32_t>(at - corners.begin());
        };
        const auto corner_of = [&](std::int32_t side, std::int32_t v) {
            return sides_.from(side) == v ? side : sides_.next(side);
        };
        DisjointSets fans(corners.size());
        for (std::size_t e = 0; e < table_.n_edges(); ++e) {
            const std::int32_t* side = table_.sides.data() + table_.starts[e];
            for (const std::int32_t v : {sides_.from(side[0]), sides_.to(side[0])}) {
                if (!doubtful[v]) continue;
                for (std::int32_t i = 1; i < table_.n_faces(e); ++i)
                    fans.unite(number(corner_of(side[0], v)), number(corner_of(side[i], v)));
            }
        }
        std::map<std::int32_t, std::int32_t> n_fans;
        for (std::size_t i = 0; i < corners.size(); ++i)
            n_fans[sides_.from(corners[i])] +=
                fans.find(static_cast<std::int32_t>(i)) == static_cast<std::int32_t>(i);
        for (const auto& [vertex, n] : n_fans) {
            if (n < 2) continue;
            out_.complex_vertices.push_back({vertex, n});
            component_at(vertex).manifold = false;
        }
    }

    // The boundary goes on where the fan at the end of a boundary edge has its other end.
    void count_boundary_loops()
    {
        const auto number = [&](std::int32_t side) {
            const auto at = std::lower_bound(boundary_.begin(), boundary_.end(), side);
            return static_cast<std::int32_t>(at - boundary_.begin());
        };
        DisjointSets loops(boundary_.size());
        const auto go_on = [&](std::int32_t from, std::int32_t vertex, std::int32_t exit) {
            const auto all = [](std::int32_t) { return true; };
            const std::int32_t end = walk_around(sides_, twin_, vertex, exit, all);
            if (twin_[end] == kBoundarySide) loops.unite(from, number(end));
        };
        for (std::size_t i = 0; i < boundary_.size(); ++i) {
            const std::int32_t side = boundary_[i], next = sides_.next(side);
            go_on(static_cast<std::int32_t>(i), sides_.from(side), sides_.previous(side));
            go_on(static_cast<std::int32_t>(i), sides_.from(next), next);
        }
        for (std::size_t i = 0; i < boundary_.size(); ++i)
            if (loops.find(static_cast<std::int32_t>(i)) == static_cast<std::int32_t>(i))
                ++component_at(sides_.from(boundary_[i])).boundary_loops;
    }

    // Node 2f stands for face f as it is, 2f + 1 for the face turned over. A component is one-sided
    // if some face hangs together with itself turned over.
    void find_one_sided_components()
    {
        require(sides_.n_faces() < (std::size_t{1} << 30), "mesh has too many faces: 2^30");
        DisjointSets sets(2 * sides_.n_faces());
        for (std::size_t e = 0; e < table_.n_edges(); ++e) {
            if (table_.n_faces(e) != 2) continue;
            const std::int32_t* side = table_.sides.data() + table_.starts[e];
            const std::int32_t flip = sides_.from(side[0]) == sides_.from(side[1]);
            const std::int32_t f = sides_.face(side[0]), g = sides_.face(side[1]);
            sets.unite(2 * f, 2 * g + flip);
            sets.unite(2 * f + 1, 2 * g + 1 - flip);
        }
        for (std::size_t f = 0; f < sides_.n_faces(); ++f) {
            const auto node = static_cast<std::int32_t>(2 * f);
            if (sets.find(node) == sets.find(node + 1))
                component_at(sides_.from(sides_.first(f))).orientable = false;
        }
    }

    void conclude()
    {
        out_.genus = 0;
        for (SurfaceKind& part : out_.components) {
            part.closed = part.boundary_edges == 0;
            part.euler = part.vertices - part.edges + part.faces;
            if (part.manifold && part.orientable)
                part.genus = (2 - part.euler - part.boundary_loops) / 2;
            add_to_total(part);
        }
        conclude_valences();
    }

    void add_to_total(const SurfaceKind& part)
    {
        out_.vertices += part.vertices;
        out_.edges += part.edges;
        out_.faces += part.faces;
        out_.boundary_edges += part.boundary_edges;
        out_.boundary_loops += part.boundary_loops;
        out_.euler += part.euler;
        out_.closed &= part.closed;
        out_.oriented &= part.oriented;
        out_.orientable &= part.orientable;
        out_.manifold &= part.manifold;
        if (part.genus && out_.genus)
            *out_.genus += *part.genus;
        else
            out_.genus.reset();
    }

    void conclude_valences()
    {
        const auto last = static_cast<std::int32_t>(out_.valences.size()) - 1;
        out_.least_valence = out_.vertices > 0 ? std::numeric_limits<std::int32_t>::max() : 0;
        for (std::size_t v = 0; v < n_vertices_; ++v) {
            if (out_.component_of_vertex[v] < 0) continue;
            ++out_.valences[std::min(valence_[v], last)];
            out_.least_valence = std::min(out_.least_valence, valence_[v]);
            out_.greatest_valence = std::max(out_.greatest_valence, valence_[v]);
        }
        if (out_.vertices > 0)
            out_.mean_valence =
                2.0 * static_cast<double>(out_.edges) / static_cast<double>(out_.vertices);
    }

    const Sides& sides_;
    std::size_t n_vertices_;
    std::vector<std::uint8_t> degenerate_;
    EdgeTable table_;
    std::vector<std::int32_t> twin_;
    std::vector<std::int32_t> valence_;
    std::vector<std::int32_t> boundary_;    // sides, ascending
    std::vector<std::int32_t> flipped_in_;  // components with flipped edges
    Topology out_;
};

EdgeTable edges_of(const IndexedMesh& mesh)
{
    const TriangleSides sides(mesh);
    check_indices(sides, mesh.n_vertices());
    return make_edge_table(sides, mesh.n_vertices(),
                           [&](std::size_t f) { return names_a_vertex_twice(sides, f); });
}

}  // namespace

Topology topology(const IndexedMesh& mesh)
{
    return TopologyBuilder(TriangleSides(mesh), mesh.n_vertices()).run();
}

Topology topology(const PolygonMesh& mesh)
{
    return TopologyBuilder(PolygonSides(mesh), mesh.n_vertices()).run();
}

bool is_closed(const IndexedMesh& mesh)
{
    const EdgeTable table = edges_of(mesh);
    for (std::size_t e = 0; e < table.n_edges(); ++e)
        if (table.n_faces(e) < 2) return false;
    return true;
}

bool is_oriented(const IndexedMesh& mesh)
{
    const TriangleSides sides(mesh);
    const EdgeTable table = edges_of(mesh);
    for (std::size_t e = 0; e < table.n_edges(); ++e) {
        const std::int32_t* side = table.sides.data() + table.starts[e];
        if (table.n_faces(e) == 2 && sides.from(side[0]) == sides.from(side[1])) return false;
    }
    return true;
}

}  // namespace genus
