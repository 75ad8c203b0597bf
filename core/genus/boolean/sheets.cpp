#include "genus/boolean/sheets.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "genus/base/error.h"

namespace genus::exact {

namespace {

constexpr double kEpsilon = 1.1102230246251565e-16;  // 2^-53

// A normal in floating point with a bound on the error of each component.
struct RoughNormal {
    Vec3 n;
    Vec3 error;
};

struct FacePoints {
    const Vec3& a;
    const Vec3& b;
    const Vec3& c;

    FacePoints(const Soup& soup, std::int32_t f)
        : a(soup.points[soup.faces[f][0]]),
          b(soup.points[soup.faces[f][1]]),
          c(soup.points[soup.faces[f][2]])
    {
    }
    Plane plane() const { return plane_through(a, b, c); }
    RoughNormal rough() const
    {
        RoughNormal r;
        const Vec3 ab = b - a;
        const Vec3 ac = c - a;
        for (int k = 0; k < 3; ++k) {
            const double left = ab[(k + 1) % 3] * ac[(k + 2) % 3];
            const double right = ab[(k + 2) % 3] * ac[(k + 1) % 3];
            r.n[k] = left - right;
            r.error[k] = 2.0 * kEpsilon * (std::abs(left) + std::abs(right));
        }
        return r;
    }
};

// Sign of component k of the cross product of the normals of f and g.
int cross_sign(const Soup& soup, int k, std::int32_t f, std::int32_t g)
{
    if (f == g) return 0;
    const FacePoints pf(soup, f);
    const FacePoints pg(soup, g);
    const RoughNormal a = pf.rough();
    const RoughNormal b = pg.rough();
    const int u = (k + 1) % 3;
    const int v = (k + 2) % 3;
    const double left = a.n[u] * b.n[v];
    const double right = a.n[v] * b.n[u];
    const double det = left - right;
    const auto spread = [](double x, double dx, double y, double dy) {
        return std::abs(x) * dy + std::abs(y) * dx + dx * dy;
    };
    const double bound = 1.01 * (spread(a.n[u], a.error[u], b.n[v], b.error[v]) +
                                 spread(a.n[v], a.error[v], b.n[u], b.error[u]) +
                                 4.0 * kEpsilon * (std::abs(left) + std::abs(right)));
    if (det > bound) return 1;
    if (det < -bound) return -1;
    if (left == 0.0 && right == 0.0 && bound == 0.0) return 0;
    return cross_sign(k, pf.plane(), pg.plane());
}

// 1 if parallel normals of f and g point the same way.
int same_direction(const Soup& soup, std::int32_t f, std::int32_t g)
{
    const FacePoints pf(soup, f);
    const FacePoints pg(soup, g);
    const int k = dominant_axis(pf.a, pf.b, pf.c);
    return turn(k, pf.a, pf.b, pf.c) * turn(k, pg.a, pg.b, pg.c);
}

}  // namespace

std::uint64_t edge_key(std::int32_t a, std::int32_t b)
{
    if (a > b) std::swap(a, b);
    return static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
}

// By lower end first, which leaves few sheets to compare.
void sort_sheets(std::vector<Sheet>& sheets)
{
    std::size_t n_low = 0;
    for (const Sheet& s : sheets) n_low = std::max<std::size_t>(n_low, (s.edge >> 32) + 1);
    std::vector<std::size_t> start(n_low + 1, 0);
    for (const Sheet& s : sheets) ++start[(s.edge >> 32) + 1];
    for (std::size_t i = 0; i < n_low; ++i) start[i + 1] += start[i];
    std::vector<Sheet> sorted(sheets.size());
    std::vector<std::size_t> fill(start.begin(), start.end());
    for (const Sheet& s : sheets) sorted[fill[s.edge >> 32]++] = s;
    for (std::size_t i = 0; i < n_low; ++i)
        std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(start[i]),
                  sorted.begin() + static_cast<std::ptrdiff_t>(start[i + 1]),
                  [](const Sheet& a, const Sheet& b) {
                      return std::tie(a.edge, a.item, a.forward) <
                             std::tie(b.edge, b.item, b.forward);
                  });
    sheets = std::move(sorted);
}

bool parallel_faces(const Soup& soup, std::int32_t f, std::int32_t g)
{
    for (int k = 0; k < 3; ++k)
        if (cross_sign(soup, k, f, g) != 0) return false;
    return true;
}

// A sheet lies in the direction normal x edge if it turns along the edge, so the angles of sheets
// are those of the normals, taken negative for sheets that turn against it. All normals are
// perpendicular to the edge: the sign of a component of their cross product, against that of the
// edge, tells which comes first.
void sort_round_edge(const Soup& soup, const std::vector<PointRef>& points, Sheet* begin,
                     Sheet* end)
{
    const PointRef& p = points[begin->edge >> 32];
    const PointRef& q = points[begin->edge & 0xffffffffu];
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(q.approx[k] - p.approx[k]) > std::abs(q.approx[axis] - p.approx[axis]))
            axis = k;
    int way = 0;
    for (int k = 0; k < 3 && way == 0; ++k, axis = way == 0 ? (axis + 1) % 3 : axis)
        way = compare_coordinate(axis, q, p);
    if (way == 0) throw Error("mesh_boolean: an edge has no length");

    const auto orientation = [](const Sheet& s) { return s.forward != s.flipped ? 1 : -1; };
    const auto cross = [&](const Sheet& a, const Sheet& b) {
        return way * orientation(a) * orientation(b) * cross_sign(soup, axis, a.plane, b.plane);
    };
    // 0: along the first sheet; 1: within the half turn after it; 2: opposite; 3: beyond.
    const Sheet first = *begin;
    const auto sector = [&](const Sheet& s) {
        const int c = cross(first, s);
        if (c != 0) return c > 0 ? 1 : 3;
        const int same =
            orientation(first) * orientation(s) * same_direction(soup, first.plane, s.plane);
        return same > 0 ? 0 : 2;
    };
    struct Placed {
        int sector;
        Sheet sheet;
    };
    std::vector<Placed> placed;
    for (const Sheet* s = begin; s != end; ++s) placed.push_back({s == begin ? 0 : sector(*s), *s});
    std::sort(placed.begin() + 1, placed.end(), [&](const Placed& a, const Placed& b) {
        if (a.sector != b.sector) return a.sector < b.sector;
        return cross(a.sheet, b.sheet) > 0;
    });
    for (std::size_t i = 1; i < placed.size(); ++i) {
        const auto& a = placed[i - 1];
        const auto& b = placed[i];
        if (a.sector == b.sector && (a.sector % 2 == 0 || cross(a.sheet, b.sheet) == 0))
            throw Error("mesh_boolean: two faces of operands " +
                        std::to_string(soup.given[a.sheet.plane].operand) + " and " +
                        std::to_string(soup.given[b.sheet.plane].operand) +
                        " cover each other where they were found apart");
    }
    for (std::size_t i = 0; i < placed.size(); ++i) begin[i] = placed[i].sheet;
}

}  // namespace genus::exact
