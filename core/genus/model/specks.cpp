#include "genus/model/specks.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/halves.h"
#include "genus/mesh/aabb_tree.h"

namespace genus {

namespace {

// The least vertex of the part each vertex belongs to.
std::vector<std::int32_t> parts_of_vertices(const IndexedMesh& mesh)
{
    std::vector<std::int32_t> least(mesh.n_vertices());
    std::iota(least.begin(), least.end(), 0);
    const auto root = [&](std::int32_t v) {
        while (least[v] != v) v = least[v] = least[least[v]];
        return v;
    };
    for (const Triangle& t : mesh.faces)
        for (const std::int32_t v : {t[1], t[2]}) {
            const auto [low, high] = std::minmax({root(t[0]), root(v)});
            least[high] = low;
        }
    for (std::size_t v = 0; v < least.size(); ++v) least[v] = least[least[v]];
    return least;
}

// Is the field positive, or negative, on all sides of the box?
bool keeps_sign_round(const Implicit& field, const Box3& box)
{
    constexpr std::size_t kMostBounds = 400;
    std::vector<Box3> open;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        open.insert(open.end(), 2, box);
        open[2 * axis].max[axis] = box.min[axis];
        open[2 * axis + 1].min[axis] = box.max[axis];
    }
    int sign = 0;
    for (std::size_t n = 0; !open.empty(); ++n) {
        if (n == kMostBounds) return false;
        const Box3 side = open.back();
        open.pop_back();
        const Interval range = field.bound(side);
        const int own = range.lo > 0.0 ? 1 : range.hi < 0.0 ? -1 : 0;
        if (own * sign < 0) return false;
        sign += sign == 0 ? own : 0;
        if (own != 0) continue;
        const auto [low, high] = halves(side);
        open.push_back(high);
        open.push_back(low);
    }
    return true;
}

bool is_by_itself(const Implicit& field, const Box3& box, double cell)
{
    constexpr std::array<double, 3> kRooms{1.0, 0.5, 0.25};  // in cells
    return std::any_of(kRooms.begin(), kRooms.end(), [&](double room) {
        return keeps_sign_round(field, box.inflated(room * cell));
    });
}

// The faces of vertices that stay, with these numbered anew.
IndexedMesh kept(const IndexedMesh& mesh, const std::vector<char>& stays)
{
    IndexedMesh result;
    std::vector<std::int32_t> number(mesh.n_vertices(), -1);
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (stays[v] == 0) continue;
        number[v] = static_cast<std::int32_t>(result.n_vertices());
        result.vertices.push_back(mesh.vertices[v]);
    }
    for (const Triangle& t : mesh.faces)
        if (stays[t[0]] != 0) result.faces.push_back({number[t[0]], number[t[1]], number[t[2]]});
    return result;
}

}  // namespace

std::int64_t leave_out_specks(IndexedMesh& mesh, const Implicit& field, double cell, double most)
{
    const std::vector<std::int32_t> part = parts_of_vertices(mesh);
    std::vector<Box3> boxes(mesh.n_vertices());  // of the parts, at their least vertices
    for (std::size_t v = 0; v < part.size(); ++v) boxes[part[v]].add(mesh.vertices[v]);
    std::int32_t largest = 0;
    for (std::size_t v = 0; v < boxes.size(); ++v)
        if (!boxes[v].empty() && boxes[v].diagonal() > boxes[largest].diagonal())
            largest = static_cast<std::int32_t>(v);
    std::vector<std::int32_t> small;
    for (std::size_t v = 0; v < boxes.size(); ++v)
        if (!boxes[v].empty() && static_cast<std::int32_t>(v) != largest &&
            boxes[v].diagonal() <= 2.0 * most && !is_by_itself(field, boxes[v], cell))
            small.push_back(static_cast<std::int32_t>(v));
    if (small.empty()) return 0;

    std::vector<char> is_small(mesh.n_vertices(), 0), stays(mesh.n_vertices(), 1);
    for (const std::int32_t s : small) is_small[s] = 1;
    for (std::size_t v = 0; v < part.size(); ++v) stays[v] = is_small[part[v]] == 0 ? 1 : 0;
    const IndexedMesh others = kept(mesh, stays);
    const MeshTree tree(others);
    for (std::size_t v = 0; v < part.size(); ++v)
        if (stays[v] == 0 && tree.nearest(mesh.vertices[v], most).face < 0) is_small[part[v]] = 0;
    for (std::size_t v = 0; v < part.size(); ++v) stays[v] = is_small[part[v]] == 0 ? 1 : 0;
    const auto n = std::count(is_small.begin(), is_small.end(), 1);
    if (n > 0) mesh = kept(mesh, stays);
    return n;
}

}  // namespace genus
