#include "genus/mesh/hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

struct Facet {
    Triangle corner;                     // counterclockwise from outside
    std::array<std::int32_t, 3> across;  // neighbour over the side corner[i], corner[i + 1]
    std::vector<std::int32_t> above;     // points that see it, each listed with one facet
    bool alive = true;
};

class Hull {
public:
    explicit Hull(std::span<const Vec3> points) : points_(points) {}

    // False if all points lie in one plane.
    bool build()
    {
        if (!start()) return false;
        for (std::size_t f = 0; f < facets_.size(); ++f) {
            if (!facets_[f].alive || facets_[f].above.empty()) continue;
            current_progress().check();
            add(farthest(facets_[f]), static_cast<std::int32_t>(f));
        }
        return true;
    }

    PolygonMesh polygons() const;

private:
    bool sees(std::int32_t point, const Facet& f) const
    {
        return orient3d(points_[f.corner[0]], points_[f.corner[1]], points_[f.corner[2]],
                        points_[point]) < 0;
    }

    bool start();
    void add(std::int32_t apex, std::int32_t seen);
    std::int32_t farthest(const Facet& facet) const;
    void hand_out(const std::vector<std::int32_t>& points, std::size_t first_facet);
    std::vector<std::int32_t> planes() const;

    std::span<const Vec3> points_;
    std::vector<Facet> facets_;
};

// Four points that span space: the extremes first, so that most others fall inside.
bool Hull::start()
{
    if (points_.size() < 4) return false;
    const auto by_x = [&](const Vec3& a, const Vec3& b) { return a.c < b.c; };
    const auto [low, high] = std::minmax_element(points_.begin(), points_.end(), by_x);
    const auto a = static_cast<std::int32_t>(low - points_.begin());
    const auto b = static_cast<std::int32_t>(high - points_.begin());
    const auto n = static_cast<std::int32_t>(points_.size());
    const auto best = [&](auto&& size, auto&& is_proper) {
        std::int32_t found = -1;
        double largest = -1.0;
        for (std::int32_t i = 0; i < n; ++i)
            if (const double s = size(points_[i]); s > largest && is_proper(i)) {
                largest = s;
                found = i;
            }
        return found;
    };
    const Vec3 pa = points_[a], pb = points_[b];
    // Off the line if off it in one of the three coordinate planes.
    const auto off_line = [&](std::int32_t i) {
        for (int k = 0; k < 3; ++k) {
            const int l = (k + 1) % 3;
            const auto flat = [&](const Vec3& p) { return Vec2{{p[k], p[l]}}; };
            if (orient2d(flat(pa), flat(pb), flat(points_[i])) != 0) return true;
        }
        return false;
    };
    const auto c = best([&](const Vec3& p) { return norm(cross(pb - pa, p - pa)); }, off_line);
    if (c < 0) return false;
    const Vec3 pc = points_[c], normal = cross(pb - pa, pc - pa);
    const auto d = best([&](const Vec3& p) { return std::fabs(dot(normal, p - pa)); },
                        [&](std::int32_t i) { return orient3d(pa, pb, pc, points_[i]) != 0; });
    if (d < 0) return false;
    // d below a, b, c.
    const bool turned = orient3d(pa, pb, pc, points_[d]) < 0;
    const std::int32_t p = a, q = turned ? c : b, r = turned ? b : c;
    facets_.push_back({{p, q, r}, {1, 2, 3}, {}});
    facets_.push_back({{q, p, d}, {0, 3, 2}, {}});
    facets_.push_back({{r, q, d}, {0, 1, 3}, {}});
    facets_.push_back({{p, r, d}, {0, 2, 1}, {}});
    std::vector<std::int32_t> all(n);
    std::iota(all.begin(), all.end(), 0);
    hand_out(all, 0);
    return true;
}

// Gives each point to the first of the new facets that it sees; who sees none is inside.
void Hull::hand_out(const std::vector<std::int32_t>& points, std::size_t first_facet)
{
    for (const std::int32_t p : points)
        for (std::size_t f = first_facet; f < facets_.size(); ++f)
            if (sees(p, facets_[f])) {
                facets_[f].above.push_back(p);
                break;
            }
}

std::int32_t Hull::farthest(const Facet& facet) const
{
    const Vec3 origin = points_[facet.corner[0]];
    const Vec3 normal = cross(points_[facet.corner[1]] - origin, points_[facet.corner[2]] - origin);
    return *std::max_element(
        facet.above.begin(), facet.above.end(), [&](std::int32_t i, std::int32_t j) {
            return dot(normal, points_[i] - origin) < dot(normal, points_[j] - origin);
        });
}

// Replaces the facets that the apex sees by a fan from it to their rim.
void Hull::add(std::int32_t apex, std::int32_t seen)
{
    std::vector<std::int32_t> visible{seen}, orphans;
    facets_[seen].alive = false;
    struct RimSide {
        std::int32_t from, to, outer;
    };
    std::vector<RimSide> rim;
    for (std::size_t k = 0; k < visible.size(); ++k) {
        const std::int32_t f = visible[k];
        for (int i = 0; i < 3; ++i) {
            const std::int32_t g = facets_[f].across[i];
            if (!facets_[g].alive) continue;
            if (sees(apex, facets_[g])) {
                facets_[g].alive = false;
                visible.push_back(g);
            }
        }
        orphans.insert(orphans.end(), facets_[f].above.begin(), facets_[f].above.end());
        facets_[f].above = {};
    }
    for (const std::int32_t f : visible)
        for (int i = 0; i < 3; ++i)
            if (const std::int32_t g = facets_[f].across[i]; facets_[g].alive)
                rim.push_back({facets_[f].corner[i], facets_[f].corner[(i + 1) % 3], g});
    const std::size_t first = facets_.size();
    std::unordered_map<std::int32_t, std::int32_t> starting_at;
    for (const RimSide& side : rim) {
        const auto f = static_cast<std::int32_t>(facets_.size());
        starting_at[side.from] = f;
        facets_.push_back({{side.from, side.to, apex}, {side.outer, -1, -1}, {}});
        Facet& outer = facets_[side.outer];
        for (int i = 0; i < 3; ++i)
            if (outer.corner[i] == side.to && outer.corner[(i + 1) % 3] == side.from)
                outer.across[i] = f;
    }
    for (std::size_t f = first; f < facets_.size(); ++f) {
        const std::int32_t next = starting_at.at(facets_[f].corner[1]);
        facets_[f].across[1] = next;
        facets_[next].across[2] = static_cast<std::int32_t>(f);
    }
    std::erase(orphans, apex);
    hand_out(orphans, first);
}

// Number of the face plane of each facet: coplanar neighbours share one.
std::vector<std::int32_t> Hull::planes() const
{
    std::vector<std::int32_t> plane(facets_.size(), -1);
    std::int32_t n_planes = 0;
    for (std::size_t f = 0; f < facets_.size(); ++f) {
        if (!facets_[f].alive || plane[f] >= 0) continue;
        const Triangle base = facets_[f].corner;
        std::vector<std::int32_t> open{static_cast<std::int32_t>(f)};
        plane[f] = n_planes;
        while (!open.empty()) {
            const Facet& facet = facets_[open.back()];
            open.pop_back();
            for (const std::int32_t g : facet.across) {
                if (plane[g] >= 0) continue;
                const auto in_plane = [&](std::int32_t v) {
                    return orient3d(points_[base[0]], points_[base[1]], points_[base[2]],
                                    points_[v]) == 0;
                };
                const Triangle& corner = facets_[g].corner;
                if (!std::all_of(corner.begin(), corner.end(), in_plane)) continue;
                plane[g] = n_planes;
                open.push_back(g);
            }
        }
        ++n_planes;
    }
    return plane;
}

PolygonMesh Hull::polygons() const
{
    const std::vector<std::int32_t> plane = planes();
    // The border of each face, and how many faces meet at a point: at a true vertex three or more.
    std::vector<std::unordered_map<std::int32_t, std::int32_t>> border;
    std::vector<std::int32_t> n_faces(points_.size(), 0);
    for (std::size_t f = 0; f < facets_.size(); ++f) {
        if (!facets_[f].alive) continue;
        border.resize(std::max<std::size_t>(border.size(), plane[f] + 1));
        for (int i = 0; i < 3; ++i) {
            if (plane[facets_[f].across[i]] == plane[f]) continue;
            const std::int32_t from = facets_[f].corner[i];
            border[plane[f]][from] = facets_[f].corner[(i + 1) % 3];
            ++n_faces[from];  // a point starts one side of each face it is on
        }
    }
    PolygonMesh mesh;
    std::vector<std::int32_t> number(points_.size(), -1);
    for (std::size_t i = 0; i < points_.size(); ++i)
        if (n_faces[i] >= 3) {
            number[i] = static_cast<std::int32_t>(mesh.vertices.size());
            mesh.vertices.push_back(points_[i]);
        }
    for (const auto& next : border) {
        std::int32_t first = next.begin()->first;
        for (const auto& [from, to] : next) first = std::min(first, from);
        std::vector<std::int32_t> face;
        std::int32_t v = first;
        do {
            if (number[v] >= 0) face.push_back(number[v]);
            v = next.at(v);
        } while (v != first);
        mesh.add_face(face);
    }
    return mesh;
}

}  // namespace

PolygonMesh convex_hull(std::span<const Vec3> points)
{
    std::vector<Vec3> distinct;
    distinct.reserve(points.size());
    std::vector<std::int32_t> order(points.size());
    for (const Vec3& p : points) require(is_finite(p), "convex_hull: a point is not finite");
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::int32_t i, std::int32_t j) { return points[i].c < points[j].c; });
    std::vector<bool> repeated(points.size(), false);
    for (std::size_t k = 1; k < order.size(); ++k)
        repeated[order[k]] = points[order[k]] == points[order[k - 1]];
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!repeated[i]) distinct.push_back(points[i]);
    Hull hull(distinct);
    return hull.build() ? hull.polygons() : PolygonMesh{};
}

}  // namespace genus
