#include "genus/boolean/planar_triangulation.h"

#include <algorithm>
#include <cmath>

#include "genus/base/error.h"

namespace genus::exact {

namespace {

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

int prev(int i)
{
    return i == 0 ? 2 : i - 1;
}

int index_of(const PlanarTriangulation::Cell& cell, int point)
{
    return cell.v[0] == point ? 0 : (cell.v[1] == point ? 1 : 2);
}

int edge_towards(const PlanarTriangulation::Cell& cell, int neighbor)
{
    return cell.neighbor[0] == neighbor ? 0 : (cell.neighbor[1] == neighbor ? 1 : 2);
}

// How far along the curve through 2^bits x 2^bits places this one comes.
std::uint32_t place_on_curve(int bits, std::uint32_t x, std::uint32_t y)
{
    std::uint32_t place = 0;
    for (std::uint32_t half = 1u << (bits - 1); half > 0; half >>= 1) {
        const bool right = (x & half) != 0;
        const bool upper = (y & half) != 0;
        place = place << 2 | ((right ? 3u : 0u) ^ (upper ? 1u : 0u));
        if (upper) continue;
        if (right) {
            x = ~x;
            y = ~y;
        }
        std::swap(x, y);
    }
    return place;
}

}  // namespace

void sort_along_curve(int axis, const std::vector<PointRef>& points,
                      std::vector<std::int32_t>& which)
{
    const std::array<int, 2> axes{(axis + 1) % 3, (axis + 2) % 3};
    std::array<double, 2> low{1e300, 1e300};
    std::array<double, 2> high{-1e300, -1e300};
    for (const std::int32_t p : which)
        for (int i = 0; i < 2; ++i) {
            low[i] = std::min(low[i], points[p].approx[axes[i]]);
            high[i] = std::max(high[i], points[p].approx[axes[i]]);
        }
    // Some sixteen places a point.
    int bits = 4;
    while (bits < 16 && which.size() >> 2 * (bits - 2) > 0) ++bits;
    const double last = (1 << bits) - 1;
    std::array<double, 2> scale{};
    for (int i = 0; i < 2; ++i) scale[i] = high[i] > low[i] ? last / (high[i] - low[i]) : 0.0;
    std::vector<std::pair<std::uint32_t, std::int32_t>> placed;
    placed.reserve(which.size());
    for (const std::int32_t p : which) {
        const auto step = [&](int i) {
            return static_cast<std::uint32_t>((points[p].approx[axes[i]] - low[i]) * scale[i]);
        };
        placed.push_back({place_on_curve(bits, step(0), step(1)), p});
    }
    std::sort(placed.begin(), placed.end());
    for (std::size_t i = 0; i < placed.size(); ++i) which[i] = placed[i].second;
}

void PlanarTriangulation::start_with_polygon(const std::vector<PointRef>& corners)
{
    for (const PointRef& p : corners) add_point(p);
    const int n = static_cast<int>(corners.size()) - 2;
    cells_.resize(n);
    for (int i = 0; i < n; ++i)
        set(i, {0, i + 1, i + 2}, {i > 0 ? i - 1 : kNone, kNone, i + 1 < n ? i + 1 : kNone},
            {kNone, kNone, kNone});
}

void PlanarTriangulation::reserve(std::size_t n_points)
{
    points_.reserve(n_points);
    seen_.reserve(n_points);
    cell_of_.reserve(n_points);
    cells_.reserve(2 * n_points);
}

void PlanarTriangulation::start_with_rectangle(const Vec3& low, const Vec3& high)
{
    const int u = (axis_ + 1) % 3;
    const int v = (axis_ + 2) % 3;
    // Corners in the order that is counterclockwise for the side the plane is seen from.
    for (int i = 0; i < 4; ++i) {
        const int corner = sign_ > 0 ? i : 3 - i;
        Vec3 p;
        p[u] = corner == 0 || corner == 3 ? low[u] - 1.0 : high[u] + 1.0;
        p[v] = corner < 2 ? low[v] - 1.0 : high[v] + 1.0;
        add_point({p, nullptr});
    }
    cells_.resize(2);
    set(0, {0, 1, 2}, {kNone, kNone, 1}, {kNone, kNone, kNone});
    set(1, {0, 2, 3}, {0, kNone, kNone}, {kNone, kNone, kNone});
}

int PlanarTriangulation::add_point(const PointRef& point)
{
    points_.push_back(point);
    seen_.push_back({{point.approx[(axis_ + 1) % 3], point.approx[(axis_ + 2) % 3]}});
    cell_of_.push_back(kNone);
    return static_cast<int>(points_.size()) - 1;
}

void PlanarTriangulation::set(int cell, std::array<int, 3> v, std::array<int, 3> neighbor,
                              std::array<int, 3> carrier)
{
    cells_[cell] = {v, neighbor, carrier};
    for (const int p : v) cell_of_[p] = cell;
}

void PlanarTriangulation::relink(int cell, int from, int to)
{
    if (cell == kNone) return;
    cells_[cell].neighbor[edge_towards(cells_[cell], from)] = to;
}

void PlanarTriangulation::mark(int cell, int edge, int carrier)
{
    if (cells_[cell].carrier[edge] != kNone) return;
    cells_[cell].carrier[edge] = carrier;
    const int other = cells_[cell].neighbor[edge];
    if (other != kNone) cells_[other].carrier[edge_towards(cells_[other], cell)] = carrier;
}

int PlanarTriangulation::insert(const PointRef& point)
{
    const int p = add_point(point);
    int cell = last_;
    int from = kNone;
    while (true) {
        const Cell& c = cells_[cell];
        random_ = random_ * 1664525u + 1013904223u;
        int i = static_cast<int>((random_ >> 16) % 3);  // walks in circles cannot last
        int zero = kNone;
        int zeros = 0;
        bool moved = false;
        for (int n = 0; n < 3; ++n, i = next(i)) {
            if (from != kNone && c.neighbor[i] == from) continue;
            const int s = side(c.v[i], c.v[next(i)], p);
            if (s < 0) {
                if (c.neighbor[i] == kNone)
                    throw Error("planar triangulation: a point lies outside");
                from = cell;
                cell = c.neighbor[i];
                moved = true;
                break;
            }
            if (s == 0) {
                zero = i;
                ++zeros;
            }
        }
        if (moved) continue;
        if (zeros > 1) throw Error("planar triangulation: a point is given twice");
        if (zeros == 1)
            split_edge(cell, zero, p);
        else
            split_cell(cell, p);
        last_ = cell_of_[p];
        return p;
    }
}

void PlanarTriangulation::split_cell(int cell, int point)
{
    const Cell c = cells_[cell];
    const auto [a, b, d] = c.v;
    const int second = static_cast<int>(cells_.size());
    const int third = second + 1;
    cells_.resize(cells_.size() + 2);
    set(cell, {a, b, point}, {c.neighbor[0], second, third}, {c.carrier[0], kNone, kNone});
    set(second, {b, d, point}, {c.neighbor[1], third, cell}, {c.carrier[1], kNone, kNone});
    set(third, {d, a, point}, {c.neighbor[2], cell, second}, {c.carrier[2], kNone, kNone});
    relink(c.neighbor[1], cell, second);
    relink(c.neighbor[2], cell, third);
    doubtful_.assign({{cell, 0}, {second, 0}, {third, 0}});
    legalize(1000, true);
}

void PlanarTriangulation::split_edge(int cell, int edge, int point)
{
    const Cell c = cells_[cell];
    const int other = c.neighbor[edge];
    const int i = edge;
    const int a = c.v[i];
    const int b = c.v[next(i)];
    const int apex = c.v[prev(i)];
    const int carrier = c.carrier[i];
    const int near = static_cast<int>(cells_.size());
    const int far = other == kNone ? kNone : near + 1;
    cells_.resize(cells_.size() + (other == kNone ? 1 : 2));
    const int bc = c.neighbor[next(i)];
    const int ca = c.neighbor[prev(i)];
    set(cell, {a, point, apex}, {far, near, ca}, {carrier, kNone, c.carrier[prev(i)]});
    set(near, {point, b, apex}, {other, bc, cell}, {carrier, c.carrier[next(i)], kNone});
    relink(bc, cell, near);
    doubtful_.assign({{cell, 2}, {near, 1}});
    if (other != kNone) {
        const Cell o = cells_[other];
        const int j = edge_towards(o, cell);
        const int opposite = o.v[prev(j)];
        const int ad = o.neighbor[next(j)];
        const int db = o.neighbor[prev(j)];
        set(other, {b, point, opposite}, {near, far, db}, {carrier, kNone, o.carrier[prev(j)]});
        set(far, {point, a, opposite}, {cell, ad, other}, {carrier, o.carrier[next(j)], kNone});
        relink(ad, other, far);
        doubtful_.push_back({other, 2});
        doubtful_.push_back({far, 1});
    }
    legalize(1000, true);
}

bool PlanarTriangulation::convex(int cell, int edge) const
{
    const Cell& c = cells_[cell];
    const Cell& o = cells_[c.neighbor[edge]];
    const int apex = c.v[prev(edge)];
    const int opposite = o.v[prev(edge_towards(o, cell))];
    return side(c.v[edge], opposite, apex) > 0 && side(opposite, c.v[next(edge)], apex) > 0;
}

bool PlanarTriangulation::badly_shaped(int cell, int edge) const
{
    const Cell& c = cells_[cell];
    const int other = c.neighbor[edge];
    if (other == kNone || c.carrier[edge] != kNone) return false;
    const Cell& o = cells_[other];
    const Vec2 d = seen_[o.v[prev(edge_towards(o, cell))]];
    std::array<Vec2, 3> p;
    std::array<double, 3> q;
    for (int i = 0; i < 3; ++i) {
        p[i] = seen_[c.v[i]] - d;
        q[i] = p[i][0] * p[i][0] + p[i][1] * p[i][1];
    }
    double det = 0.0;
    for (int i = 0; i < 3; ++i) {
        const Vec2& a = p[next(i)];
        const Vec2& b = p[prev(i)];
        det += q[i] * (a[0] * b[1] - b[0] * a[1]);
    }
    if (sign_ * det <= 0.0) return false;
    double size = 0.0;
    for (int i = 0; i < 3; ++i) {
        const Vec2& a = p[next(i)];
        const Vec2& b = p[prev(i)];
        size += q[i] * (std::abs(a[0] * b[1]) + std::abs(b[0] * a[1]));
    }
    return sign_ * det > 1e-9 * size && convex(cell, edge);
}

void PlanarTriangulation::flip(int cell, int edge)
{
    const Cell c = cells_[cell];
    const int other = c.neighbor[edge];
    const Cell o = cells_[other];
    const int i = edge;
    const int j = edge_towards(o, cell);
    const int a = c.v[i];
    const int b = c.v[next(i)];
    const int apex = c.v[prev(i)];
    const int opposite = o.v[prev(j)];
    set(cell, {a, opposite, apex}, {o.neighbor[next(j)], other, c.neighbor[prev(i)]},
        {o.carrier[next(j)], kNone, c.carrier[prev(i)]});
    set(other, {opposite, b, apex}, {o.neighbor[prev(j)], c.neighbor[next(i)], cell},
        {o.carrier[prev(j)], c.carrier[next(i)], kNone});
    relink(o.neighbor[next(j)], other, cell);
    relink(c.neighbor[next(i)], cell, other);
}

// Flips what is badly shaped of the doubtful edges and of those that become so. With `is_new_point`
// each doubtful cell has a new point opposite to its edge, and so have the two that a flip makes;
// their other edges end in that point and are as they should be.
void PlanarTriangulation::legalize(std::size_t budget, bool is_new_point)
{
    while (!doubtful_.empty() && budget > 0) {
        const auto [cell, edge] = doubtful_.back();
        doubtful_.pop_back();
        if (!badly_shaped(cell, edge)) continue;
        const int other = cells_[cell].neighbor[edge];
        flip(cell, edge);
        --budget;
        doubtful_.push_back({cell, 0});
        if (!is_new_point) doubtful_.push_back({cell, 2});
        doubtful_.push_back({other, 0});
        if (!is_new_point) doubtful_.push_back({other, 1});
    }
}

void PlanarTriangulation::improve()
{
    doubtful_.clear();
    for (int cell = 0; cell < static_cast<int>(cells_.size()); ++cell)
        for (int i = 0; i < 3; ++i)
            if (cells_[cell].neighbor[i] > cell) doubtful_.push_back({cell, i});
    legalize(20 * cells_.size(), false);
}

// Calls visit(cell, index of point in cell) for all cells at `point` until it returns true.
template <class F>
bool PlanarTriangulation::round(int point, const F& visit) const
{
    const int start = cell_of_[point];
    int cell = start;
    do {
        const int i = index_of(cells_[cell], point);
        if (visit(cell, i)) return true;
        cell = cells_[cell].neighbor[prev(i)];
    } while (cell != kNone && cell != start);
    if (cell == start) return false;
    cell = cells_[start].neighbor[index_of(cells_[start], point)];
    while (cell != kNone) {
        const int i = index_of(cells_[cell], point);
        if (visit(cell, i)) return true;
        cell = cells_[cell].neighbor[i];
    }
    return false;
}

std::array<int, 2> PlanarTriangulation::find_edge(int a, int b) const
{
    std::array<int, 2> found{kNone, 0};
    round(a, [&](int cell, int i) {
        if (cells_[cell].v[next(i)] != b) return false;
        found = {cell, i};
        return true;
    });
    return found;
}

// For c on the line through a and b: on the same side of a as b?
bool PlanarTriangulation::ahead(int a, int b, int c) const
{
    for (int k = 1; k <= 2; ++k) {
        const int axis = (axis_ + k) % 3;
        const int towards_b = compare_coordinate(axis, points_[b], points_[a]);
        if (towards_b == 0) continue;
        return compare_coordinate(axis, points_[c], points_[a]) == towards_b;
    }
    return false;
}

void PlanarTriangulation::constrain(int a, int b, int carrier)
{
    while (a != b) a = advance(a, b, carrier);
}

// Keeps the first piece of the edge from a towards b, up to the next point on it, and returns
// that point.
int PlanarTriangulation::advance(int a, int b, int carrier)
{
    int reached = kNone;
    int cell = kNone;
    int edge = 0;
    round(a, [&](int at, int i) {
        const int p = cells_[at].v[next(i)];
        const int r = cells_[at].v[prev(i)];
        const int side_p = p == b ? 0 : side(a, b, p);
        if (side_p == 0 && (p == b || ahead(a, b, p))) {
            reached = p;
            mark(at, i, carrier);
            return true;
        }
        const int side_r = r == b ? 0 : side(a, b, r);
        if (side_r == 0 && (r == b || ahead(a, b, r))) {
            reached = r;
            mark(at, prev(i), carrier);
            return true;
        }
        if (side_p >= 0 || side_r <= 0) return false;
        cell = at;
        edge = next(i);
        return true;
    });
    if (reached != kNone) return reached;
    if (cell == kNone) throw Error("planar triangulation: no way from a point to its constraint");

    std::vector<std::array<int, 2>> crossed;
    while (reached == kNone) {
        const Cell c = cells_[cell];
        const int right = c.v[edge];
        const int left = c.v[next(edge)];
        if (c.carrier[edge] != kNone) {
            const int x = add_point(crossing_(c.carrier[edge], carrier));
            split_edge(cell, edge, x);
            reached = x;
            // The shape flips after the split may have changed what lies between.
            return a == x ? x : advance(a, x, carrier);
        }
        crossed.push_back({right, left});
        const int other = c.neighbor[edge];
        if (other == kNone) throw Error("planar triangulation: a constraint leaves the domain");
        const Cell& o = cells_[other];
        const int j = edge_towards(o, cell);
        const int apex = o.v[prev(j)];
        const int s = apex == b ? 0 : side(a, b, apex);
        if (s == 0)
            reached = apex;
        else
            edge = s > 0 ? next(j) : prev(j);
        cell = other;
    }
    clear_way(crossed, a, reached);
    const auto [found, i] = find_edge(a, reached);
    if (found != kNone) {
        mark(found, i, carrier);
    } else {
        const auto [back, k] = find_edge(reached, a);
        if (back == kNone) throw Error("planar triangulation: a constraint was not kept");
        mark(back, k, carrier);
    }
    return reached;
}

// Flips the crossed edges until the edge from a to b is free of them.
void PlanarTriangulation::clear_way(std::vector<std::array<int, 2>>& crossed, int a, int b)
{
    std::size_t head = 0;
    const std::size_t limit = 1000 + 10 * crossed.size() * crossed.size();
    while (head < crossed.size()) {
        if (head > limit) throw Error("planar triangulation: flips do not end");
        const auto [u, v] = crossed[head++];
        const auto [cell, edge] = find_edge(u, v);
        if (!convex(cell, edge)) {
            crossed.push_back({u, v});
            continue;
        }
        const int other = cells_[cell].neighbor[edge];
        flip(cell, edge);
        const int p = cells_[cell].v[1];
        const int q = cells_[other].v[2];
        if (p == a || p == b || q == a || q == b) continue;
        if (side(a, b, p) * side(a, b, q) < 0) crossed.push_back({p, q});
    }
}

}  // namespace genus::exact
