#include "genus/boolean/closed_operand.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "genus/base/error.h"
#include "genus/mesh/disjoint_sets.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

constexpr double kLargest = 1e300;
constexpr Index kManyEdges = 64;  // at a corner: too many to look through for each

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

[[noreturn]] void refuse(Index number, Index face, const std::string& what)
{
    throw InvalidInput("mesh_boolean: operand " + std::to_string(number) + ", face " +
                       std::to_string(face) + ": " + what);
}

bool is_flat(const Triangle& t)
{
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

void check_numbers(const IndexedMesh& mesh, Index number)
{
    if (mesh.faces.size() > 700'000'000 || mesh.vertices.size() > 2'000'000'000)
        throw InvalidInput("mesh_boolean: operand " + std::to_string(number) +
                           " has more than 700 million faces");
    const auto n = static_cast<Index>(mesh.vertices.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        for (const Index v : mesh.faces[f]) {
            if (v < 0 || v >= n)
                refuse(number, static_cast<Index>(f),
                       "corner " + std::to_string(v) + " does not exist");
            for (int k = 0; k < 3; ++k)
                if (!(std::abs(mesh.vertices[v][k]) <= kLargest))
                    refuse(number, static_cast<Index>(f),
                           "a coordinate is " + to_text(mesh.vertices[v][k]));
        }
}

// Numbers of the first vertex at the same place.
std::vector<Index> first_at_place(const std::vector<Vec3>& vertices)
{
    std::vector<Index> order(vertices.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](Index v) {
        const Vec3& p = vertices[v];
        return std::tuple(p[0], p[1], p[2], v);
    };
    std::sort(order.begin(), order.end(), [&](Index a, Index b) { return key(a) < key(b); });
    std::vector<Index> first(vertices.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
        first[order[i]] = same ? first[order[i - 1]] : order[i];
    }
    return first;
}

bool has_flat(std::span<const Triangle> faces)
{
    return std::any_of(faces.begin(), faces.end(), is_flat);
}

void drop_flat(ClosedOperand& operand)
{
    if (!has_flat(operand.faces)) return;
    std::vector<Triangle> faces;
    std::vector<Index> source;
    for (std::size_t f = 0; f < operand.faces.size(); ++f) {
        if (is_flat(operand.faces[f])) continue;
        faces.push_back(operand.faces[f]);
        source.push_back(operand.source.empty() ? static_cast<Index>(f) : operand.source[f]);
    }
    operand.own_faces = std::move(faces);
    operand.faces = operand.own_faces;
    operand.source = std::move(source);
}

void find_components(const IndexedMesh& mesh, ClosedOperand& operand)
{
    DisjointSets sets(mesh.vertices.size());
    for (const Triangle& t : operand.faces) {
        sets.unite(t[0], t[1]);
        sets.unite(t[0], t[2]);
    }
    std::vector<Index> number(mesh.vertices.size(), -1);
    Index n = 0;
    for (const Triangle& t : operand.faces)
        if (Index& known = number[sets.find(t[0])]; known < 0) known = n++;
    operand.boxes.resize(n);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        // Nothing ends at a vertex of no component.
        const Index component = number[sets.find(static_cast<Index>(v))];
        if (component >= 0) operand.boxes[component].add(mesh.vertices[v]);
    }
    if (n < 2) return;
    operand.component.reserve(operand.faces.size());
    for (const Triangle& t : operand.faces) operand.component.push_back(number[sets.find(t[0])]);
}

// The usual case, in which every edge is passed once each way. False if it is not: `twin` then is
// good for nothing.
bool find_single_twins(std::size_t n_vertices, std::span<const Triangle> faces,
                       std::vector<Index>& twin)
{
    // Halfedges that go up, by their lower corner.
    std::vector<Index> start(n_vertices + 1, 0);
    for (const Triangle& t : faces)
        for (int i = 0; i < 3; ++i)
            if (t[i] < t[next(i)]) ++start[t[i] + 1];
    for (std::size_t v = 0; v < n_vertices; ++v) {
        if (start[v + 1] > kManyEdges) return false;
        start[v + 1] += start[v];
    }
    const std::size_t n_up = static_cast<std::size_t>(start[n_vertices]);
    if (2 * n_up != 3 * faces.size()) return false;
    struct Up {
        Index high;
        Index halfedge;  // -1 once its twin was found
    };
    std::vector<Up> up(n_up);
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (int i = 0; i < 3; ++i) {
            const Index a = faces[f][i];
            const Index b = faces[f][next(i)];
            if (a < b) up[start[a]++] = {b, static_cast<Index>(3 * f) + i};
        }
    // Now each starts where the next one did.
    twin.resize(3 * faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (int i = 0; i < 3; ++i) {
            const Index high = faces[f][i];
            const Index low = faces[f][next(i)];
            if (high < low) continue;
            const Index end = start[low];
            Index at = low == 0 ? 0 : start[low - 1];
            while (at < end && up[at].high != high) ++at;
            if (at == end || up[at].halfedge < 0) return false;
            const auto h = static_cast<Index>(3 * f) + i;
            twin[h] = std::exchange(up[at].halfedge, -1);
            twin[twin[h]] = h;
        }
    return true;
}

}  // namespace

std::int32_t find_twins(std::size_t n_vertices, std::span<const Triangle> faces,
                        std::vector<std::int32_t>& twin)
{
    if (find_single_twins(n_vertices, faces, twin)) return -1;
    const auto n = static_cast<Index>(3 * faces.size());
    // Halfedges by their lower corner.
    std::vector<Index> start(n_vertices + 1, 0);
    const auto low_end = [&](Index h) {
        return std::min(faces[h / 3][h % 3], faces[h / 3][next(h % 3)]);
    };
    for (Index h = 0; h < n; ++h) ++start[low_end(h) + 1];
    for (std::size_t v = 0; v < n_vertices; ++v) start[v + 1] += start[v];
    struct Entry {
        Index high;
        Index halfedge;
        bool operator<(const Entry& o) const
        {
            return std::tie(high, halfedge) < std::tie(o.high, o.halfedge);
        }
    };
    std::vector<Entry> entries(n);
    {
        std::vector<Index> fill(start.begin(), start.end() - 1);
        for (Index h = 0; h < n; ++h) {
            const Index a = faces[h / 3][h % 3];
            const Index b = faces[h / 3][next(h % 3)];
            entries[fill[std::min(a, b)]++] = {std::max(a, b), h};
        }
    }
    twin.assign(n, -1);
    Index open = -1;
    for (std::size_t v = 0; v < n_vertices; ++v) {
        const auto is_forward = [&](Index h) {
            return static_cast<std::size_t>(faces[h / 3][h % 3]) == v;
        };
        const auto end = entries.begin() + start[v + 1];
        std::sort(entries.begin() + start[v], end);
        for (auto e = entries.begin() + start[v]; e != end;) {
            auto last = e;
            int balance = 0;
            for (; last != end && last->high == e->high; ++last)
                balance += is_forward(last->halfedge) ? 1 : -1;
            if (balance != 0 && (open < 0 || e->halfedge < open)) open = e->halfedge;
            if (balance == 0 && last - e == 2) {
                twin[e->halfedge] = e[1].halfedge;
                twin[e[1].halfedge] = e->halfedge;
            }
            e = last;
        }
    }
    return open;
}

ClosedOperand close_operand(const IndexedMesh& mesh, std::int32_t number)
{
    check_numbers(mesh, number);
    ClosedOperand operand;
    operand.faces = mesh.faces;
    drop_flat(operand);
    if (find_twins(mesh.vertices.size(), operand.faces, operand.twin) >= 0) {
        const std::vector<Index> first = first_at_place(mesh.vertices);
        std::vector<Triangle> merged(operand.faces.begin(), operand.faces.end());
        for (Triangle& t : merged)
            for (Index& v : t) v = first[v];
        operand.own_faces = std::move(merged);
        operand.faces = operand.own_faces;
        drop_flat(operand);
        const Index open = find_twins(mesh.vertices.size(), operand.faces, operand.twin);
        if (open >= 0) {
            const Index face = operand.source.empty() ? open / 3 : operand.source[open / 3];
            refuse(number, face,
                   "not closed along the edge from corner " +
                       std::to_string(mesh.faces[face][open % 3]) + " to " +
                       std::to_string(mesh.faces[face][next(open % 3)]));
        }
    }
    find_components(mesh, operand);
    return operand;
}

}  // namespace genus::exact
