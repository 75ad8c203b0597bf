#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

// Sides are what a halfedge structure is made of: side s of a face runs from its corner s to the
// next corner of that face, and corner and side share one number. Two views give triangle and
// polygon meshes the same face, so that one text serves both.

class TriangleSides {
public:
    explicit TriangleSides(const IndexedMesh& mesh) : faces_(mesh.faces) {}

    std::size_t n_faces() const { return faces_.size(); }
    std::size_t n_sides() const { return 3 * faces_.size(); }
    std::int32_t from(std::int32_t s) const { return faces_[s / 3][s % 3]; }
    std::int32_t to(std::int32_t s) const { return from(next(s)); }
    std::int32_t next(std::int32_t s) const { return s % 3 == 2 ? s - 2 : s + 1; }
    std::int32_t previous(std::int32_t s) const { return s % 3 == 0 ? s + 2 : s - 1; }
    std::int32_t face(std::int32_t s) const { return s / 3; }
    std::int32_t first(std::size_t face) const { return static_cast<std::int32_t>(3 * face); }
    std::int32_t degree(std::size_t) const { return 3; }

private:
    const std::vector<Triangle>& faces_;
};

class PolygonSides {
public:
    explicit PolygonSides(const PolygonMesh& mesh) : mesh_(mesh), face_(mesh.corners.size())
    {
        const bool whole = !mesh.starts.empty() && mesh.starts.front() == 0 &&
                           std::is_sorted(mesh.starts.begin(), mesh.starts.end()) &&
                           mesh.starts.back() == static_cast<std::int64_t>(mesh.corners.size());
        require(whole, "polygon mesh: starts do not cut the corners into faces");
        for (std::size_t f = 0; f < mesh.n_faces(); ++f)
            std::fill(face_.begin() + mesh.starts[f], face_.begin() + mesh.starts[f + 1],
                      static_cast<std::int32_t>(f));
    }

    std::size_t n_faces() const { return mesh_.n_faces(); }
    std::size_t n_sides() const { return mesh_.corners.size(); }
    std::int32_t from(std::int32_t s) const { return mesh_.corners[s]; }
    std::int32_t to(std::int32_t s) const { return mesh_.corners[next(s)]; }
    std::int32_t next(std::int32_t s) const
    {
        return s + 1 < mesh_.starts[face_[s] + 1] ? s + 1 : first(face_[s]);
    }
    std::int32_t previous(std::int32_t s) const
    {
        const std::int32_t last = static_cast<std::int32_t>(mesh_.starts[face_[s] + 1] - 1);
        return s > first(face_[s]) ? s - 1 : last;
    }
    std::int32_t face(std::int32_t s) const { return face_[s]; }
    std::int32_t first(std::size_t face) const
    {
        return static_cast<std::int32_t>(mesh_.starts[face]);
    }
    std::int32_t degree(std::size_t face) const
    {
        return static_cast<std::int32_t>(mesh_.starts[face + 1] - mesh_.starts[face]);
    }

private:
    const PolygonMesh& mesh_;
    std::vector<std::int32_t> face_;
};

/// The edges of a mesh, each with the sides that lie on it: `sides[starts[e]] ..
/// sides[starts[e + 1] - 1]`, ascending. Edges are in the order of their smaller, then larger
/// vertex.
struct EdgeTable {
    std::vector<std::int32_t> starts{0};
    std::vector<std::int32_t> sides;

    std::size_t n_edges() const { return starts.size() - 1; }
    std::int32_t n_faces(std::size_t e) const { return starts[e + 1] - starts[e]; }
};

namespace detail {

struct SideEntry {
    std::int32_t larger;  // vertex of the edge; the bucket is the smaller one
    std::int32_t side;
    auto operator<=>(const SideEntry&) const = default;
};

// Buckets hold three sides on average: insertion beats any other sort there. The apex of a large
// fan has a large one.
inline void sort_bucket(SideEntry* begin, SideEntry* end)
{
    if (end - begin > 24) {
        std::sort(begin, end);
        return;
    }
    for (SideEntry* i = begin + 1; i < end; ++i) {
        const SideEntry entry = *i;
        SideEntry* j = i;
        for (; j > begin && entry < j[-1]; --j) *j = j[-1];
        *j = entry;
    }
}

}  // namespace detail

/// The sides in buckets by the smaller vertex of their edge, in each bucket by the larger one, then
/// by number: bucket v is entries[starts[v]] .. entries[starts[v + 1] - 1].
struct SideBuckets {
    std::vector<std::int32_t> starts;
    std::vector<detail::SideEntry> entries;
};

/// Sides for which `skip(face)` holds, and sides from a vertex to itself, are left out. A bucket
/// sort by smaller vertex, then a small sort in each bucket: O(V + F) for bounded valence, partly
/// in parallel, the same result at any thread count. All vertex numbers must be in range.
template <class Sides, class Skip>
SideBuckets make_side_buckets(const Sides& sides, std::size_t n_vertices, Skip&& skip)
{
    using detail::SideEntry;
    SideBuckets out;
    std::vector<std::int32_t>& bucket = out.starts;
    bucket.assign(n_vertices + 1, 0);
    const auto for_each_side = [&](auto&& visit) {
        for (std::size_t f = 0; f < sides.n_faces(); ++f) {
            if (skip(f)) continue;
            const std::int32_t first = sides.first(f), degree = sides.degree(f);
            for (std::int32_t i = 0; i < degree; ++i) {
                const std::int32_t a = sides.from(first + i);
                const std::int32_t b = sides.from(i + 1 < degree ? first + i + 1 : first);
                if (a != b) visit(std::min(a, b), std::max(a, b), first + i);
            }
        }
    };
    for_each_side([&](std::int32_t lo, std::int32_t, std::int32_t) { ++bucket[lo + 1]; });
    for (std::size_t v = 0; v < n_vertices; ++v) bucket[v + 1] += bucket[v];
    out.entries.resize(bucket[n_vertices]);
    std::vector<std::int32_t> cursor(bucket.begin(), bucket.end() - 1);
    for_each_side([&](std::int32_t lo, std::int32_t hi, std::int32_t side) {
        out.entries[cursor[lo]++] = {hi, side};
    });
    current_progress().check();
    parallel_for(n_vertices, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v)
            detail::sort_bucket(out.entries.data() + bucket[v], out.entries.data() + bucket[v + 1]);
    });
    return out;
}

/// Groups the sides by edge; see make_side_buckets.
template <class Sides, class Skip>
EdgeTable make_edge_table(const Sides& sides, std::size_t n_vertices, Skip&& skip)
{
    const SideBuckets buckets = make_side_buckets(sides, n_vertices, skip);
    const std::vector<std::int32_t>& bucket = buckets.starts;
    const std::vector<detail::SideEntry>& entries = buckets.entries;
    const auto begins_edge = [&](std::size_t v, std::int32_t i) {
        return i == bucket[v] || entries[i].larger != entries[i - 1].larger;
    };
    std::vector<std::int32_t> n_edges_before(n_vertices);
    parallel_for(n_vertices, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v)
            for (std::int32_t i = bucket[v]; i < bucket[v + 1]; ++i)
                n_edges_before[v] += begins_edge(v, i);
    });
    std::int32_t n_edges = 0;
    for (std::int32_t& count : n_edges_before) n_edges += std::exchange(count, n_edges);

    EdgeTable table;
    table.starts.resize(static_cast<std::size_t>(n_edges) + 1);
    table.starts[n_edges] = static_cast<std::int32_t>(entries.size());
    table.sides.resize(entries.size());
    parallel_for(n_vertices, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            std::int32_t edge = n_edges_before[v];
            for (std::int32_t i = bucket[v]; i < bucket[v + 1]; ++i) {
                table.sides[i] = entries[i].side;
                if (begins_edge(v, i)) table.starts[edge++] = i;
            }
        }
    });
    return table;
}

constexpr std::int32_t kBoundarySide = -1;  // the only side on its edge
constexpr std::int32_t kComplexSide = -2;   // on an edge of more than two faces
constexpr std::int32_t kNoEdge = -3;        // left out of the table

/// For each side the one across its edge, or one of the constants above.
std::vector<std::int32_t> twins(const EdgeTable& table, std::size_t n_sides);

/// Walks round vertex `v` from face to face, away through side `exit` of the face it stands on,
/// until `visit(corner)` returns false or the next edge has no second face. `corner` is the corner
/// at `v` of the face entered. Orientations need not agree. Returns the side where it stopped.
template <class Sides, class Visit>
std::int32_t walk_around(const Sides& sides, const std::vector<std::int32_t>& twin, std::int32_t v,
                         std::int32_t exit, Visit&& visit)
{
    while (twin[exit] >= 0) {
        const std::int32_t entered = twin[exit];
        const bool same_corner = sides.from(entered) == v;
        const std::int32_t corner = same_corner ? entered : sides.next(entered);
        if (!visit(corner)) break;
        exit = same_corner ? sides.previous(corner) : corner;
    }
    return exit;
}

/// Throws InvalidInput naming the first face with a vertex number out of range, or if there are
/// more sides or vertices than 2^31.
template <class Sides>
void check_indices(const Sides& sides, std::size_t n_vertices)
{
    require(sides.n_sides() < (std::size_t{1} << 31), "mesh has too many faces: 2^31 sides");
    require(n_vertices < (std::size_t{1} << 31), "mesh has too many vertices: 2^31");
    for (std::size_t s = 0; s < sides.n_sides(); ++s) {
        const std::int32_t v = sides.from(static_cast<std::int32_t>(s));
        if (v < 0 || static_cast<std::size_t>(v) >= n_vertices)
            throw InvalidInput("face " + std::to_string(sides.face(static_cast<std::int32_t>(s))) +
                               " names vertex " + std::to_string(v) + " of " +
                               std::to_string(n_vertices));
    }
}

/// True for faces of fewer than three corners too: they bound nothing.
template <class Sides>
bool names_a_vertex_twice(const Sides& sides, std::size_t face)
{
    const std::int32_t first = sides.first(face), degree = sides.degree(face);
    if (degree < 3) return true;
    if (degree == 3) {
        const std::int32_t a = sides.from(first), b = sides.from(first + 1);
        const std::int32_t c = sides.from(first + 2);
        return a == b || b == c || c == a;
    }
    std::vector<std::int32_t> corners(degree);
    for (std::int32_t i = 0; i < degree; ++i) corners[i] = sides.from(first + i);
    std::sort(corners.begin(), corners.end());
    return std::adjacent_find(corners.begin(), corners.end()) != corners.end();
}

}  // namespace genus
