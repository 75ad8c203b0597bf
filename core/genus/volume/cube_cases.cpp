#include "genus/volume/cube_cases.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace genus {

namespace {

constexpr int kNone = -1;

int edge_between(int a, int b)
{
    for (int e = 0; e < 12; ++e)
        if ((kCubeEdges[e].from == a && kCubeEdges[e].to == b) ||
            (kCubeEdges[e].from == b && kCubeEdges[e].to == a))
            return e;
    return kNone;
}

bool edge_on_face(int edge, int face)
{
    const auto& corners = kCubeFaces[face];
    const auto on_face = [&](int c) {
        return std::find(corners.begin(), corners.end(), c) != corners.end();
    };
    return on_face(kCubeEdges[edge].from) && on_face(kCubeEdges[edge].to);
}

bool share_face(int a, int b)
{
    for (int face = 0; face < 6; ++face)
        if (edge_on_face(a, face) && edge_on_face(b, face)) return true;
    return false;
}

// next[e] is the edge that follows e on its loop.
std::array<int, 12> link_edges(int inside, int joined)
{
    std::array<int, 12> next;
    next.fill(kNone);
    for (int face = 0; face < 6; ++face) {
        const auto& corner = kCubeFaces[face];
        const auto is_inside = [&](int k) { return (inside >> corner[k % 4] & 1) != 0; };
        const bool ambiguous = is_inside(0) == is_inside(2) && is_inside(1) == is_inside(3) &&
                               is_inside(0) != is_inside(1);
        const bool join = ambiguous && (joined >> face & 1) != 0;
        for (int k = 0; k < 4; ++k) {
            if (is_inside(k) || !is_inside(k + 1)) continue;  // side k leads into the inside
            int last = k + 1;
            while (is_inside(last + 1)) ++last;
            if (join) last += 2;  // leave after the other inside corner
            const int from = edge_between(corner[k], corner[(k + 1) % 4]);
            next[from] = edge_between(corner[last % 4], corner[(last + 1) % 4]);
        }
    }
    return next;
}

using Triangles = std::vector<std::array<std::uint8_t, 3>>;

// A triangulation of the loop's corners i..j that uses allowed diagonals only, if there is one.
std::optional<Triangles> triangulate(const std::vector<std::uint8_t>& edges, int i, int j)
{
    if (j - i < 2) return Triangles{};
    const auto allowed = [&](int a, int b) {
        const int n = static_cast<int>(edges.size());
        return b - a == 1 || b - a == n - 1 || !share_face(edges[a], edges[b]);
    };
    for (int m = i + 1; m < j; ++m) {
        if (!allowed(i, m) || !allowed(m, j)) continue;
        auto left = triangulate(edges, i, m);
        if (!left) continue;
        const auto right = triangulate(edges, m, j);
        if (!right) continue;
        left->insert(left->end(), right->begin(), right->end());
        left->push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(m),
                         static_cast<std::uint8_t>(j)});
        return left;
    }
    return std::nullopt;
}

CubeCase make_case(int inside, int joined)
{
    CubeCase result;
    std::array<int, 12> next = link_edges(inside, joined);
    for (int first = 0; first < 12; ++first) {
        if (next[first] == kNone) continue;
        CubeCase::Loop loop;
        for (int e = first; next[e] != kNone;) {
            loop.edges.push_back(static_cast<std::uint8_t>(e));
            e = std::exchange(next[e], kNone);
        }
        const int n = static_cast<int>(loop.edges.size());
        if (auto triangles = triangulate(loop.edges, 0, n - 1)) {
            loop.triangles = std::move(*triangles);
            result.n_triangles += static_cast<std::uint8_t>(n - 2);
        } else {
            result.n_triangles += static_cast<std::uint8_t>(n);
            ++result.n_inner_vertices;
        }
        result.loops.push_back(std::move(loop));
    }
    return result;
}

// Is there a way for the corners to pass from below to above such that a slice between has those
// of one diagonal inside and those of the other outside?
bool may_have_tunnel(int inside)
{
    constexpr std::array<int, 4> below{0, 1, 3, 2}, above{4, 5, 7, 6};
    for (const int first : {0, 1}) {
        bool possible = true;
        for (int k = 0; k < 4; ++k) {
            const bool wanted = k % 2 == first;
            const auto is = [&](int corner) { return (inside >> corner & 1) != 0; };
            possible &= is(below[k]) == wanted || is(above[k]) == wanted;
        }
        if (possible) return true;
    }
    return false;
}

// Once for the table: triangles of all loops in one row.
void list_triangles(CubeCase& result)
{
    if (result.n_inner_vertices > 0) return;
    std::size_t n = 0;
    for (const CubeCase::Loop& loop : result.loops)
        for (const auto& t : loop.triangles)
            result.all_triangles[n++] = {loop.edges[t[0]], loop.edges[t[1]], loop.edges[t[2]]};
}

}  // namespace

CubeCases::CubeCases() : cases_(256 * 64)
{
    for (int inside = 0; inside < 256; ++inside)
        for (int joined = 0; joined < 64; ++joined) {
            if ((joined & ~kAmbiguousFaces[inside]) != 0) continue;
            CubeCase& made = cases_[inside * 64 + joined] = make_case(inside, joined);
            made.may_have_tunnel = made.loops.size() >= 2 && may_have_tunnel(inside);
            list_triangles(made);
        }
}

const CubeCases& cube_cases()
{
    static const CubeCases cases;
    return cases;
}

}  // namespace genus
