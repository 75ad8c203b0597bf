#include "genus/polygon/planar_arrangement.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "genus/base/box.h"
#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/polygon/box_pairs.h"

namespace genus {

namespace {

__extension__ using Wide = __int128;

constexpr int kGridBits = 40;    // coordinates stay below 2^41: products of three fit in 126 bits
constexpr int kMostRounds = 64;  // of cutting; two or three are usual
constexpr int kRoundsBeforeSnap = 8;

int sign(Wide x)
{
    return (x > 0) - (x < 0);
}

// n / d to the nearest integer, halves upward.
std::int64_t divide_rounded(Wide n, Wide d)
{
    if (d < 0) {
        n = -n;
        d = -d;
    }
    const Wide doubled = 2 * n + d;
    Wide quotient = doubled / (2 * d);
    if (doubled % (2 * d) < 0) --quotient;
    return static_cast<std::int64_t>(quotient);
}

std::uint64_t edge_key(std::int32_t from, std::int32_t to)
{
    return static_cast<std::uint64_t>(from) << 32 | static_cast<std::uint32_t>(to);
}

}  // namespace

PlanarArrangement::PlanarArrangement(const std::array<std::vector<std::span<const Vec2>>, 2>& rings)
{
    snap(rings);
    cut_until_no_two_cross();
    sweep();
}

void PlanarArrangement::snap(const std::array<std::vector<std::span<const Vec2>>, 2>& rings)
{
    Box2 box;
    for (const auto& channel : rings)
        for (const auto& ring : channel)
            for (const Vec2& p : ring) {
                require(is_finite(p), "region: a coordinate is not finite");
                box.add(p);
            }
    if (box.empty()) return;
    // Round numbers stay round as long as the plane's origin is not far away.
    const double extent = std::max(box.size()[0], box.size()[1]);
    double reach = 0.0;
    for (int i = 0; i < 2; ++i)
        reach = std::max({reach, std::fabs(box.min[i]), std::fabs(box.max[i])});
    if (reach > 1024.0 * extent) {
        origin_ = box.center();
        reach = extent;
    }
    require(std::isfinite(reach), "region: the coordinates are too far apart");
    exponent_ = reach > 0.0 ? kGridBits - (std::ilogb(reach) + 1) : 0;

    const auto snapped = [&](double x, int axis) {
        const auto n = std::llround(std::ldexp(x - origin_[axis], exponent_));
        originals_[axis].push_back({n, x});
        return n;
    };
    std::map<Point, std::int32_t> numbers;
    const auto number = [&](const Vec2& p) {
        const Point q{snapped(p[0], 0), snapped(p[1], 1)};
        const auto [place, is_new] = numbers.try_emplace(q, static_cast<int>(points_.size()));
        if (is_new) points_.push_back(q);
        return place->second;
    };
    std::int32_t source = 0;
    for (int channel = 0; channel < 2; ++channel)
        for (const auto& ring : rings[channel]) {
            if (ring.size() < 3) continue;
            std::int32_t last = number(ring.back());
            for (const Vec2& p : ring) {
                const std::int32_t next = number(p);
                if (next != last) {
                    const bool forward = points_[last] < points_[next];
                    Edge edge{forward ? last : next, forward ? next : last, source++, {}, {}};
                    edge.turns[channel] = forward ? 1 : -1;
                    edges_.push_back(edge);
                }
                last = next;
            }
        }
    is_input_.assign(points_.size(), true);
    for (auto& axis : originals_) {
        std::stable_sort(axis.begin(), axis.end(), [](const Coordinate& a, const Coordinate& b) {
            return a.snapped < b.snapped;
        });
        const auto same = [](const Coordinate& a, const Coordinate& b) {
            return a.snapped == b.snapped;
        };
        axis.erase(std::unique(axis.begin(), axis.end(), same), axis.end());
    }
}

// Pieces of two edges may cross anew once their crossing was rounded, though only by a grid step;
// cutting goes on until nothing is left to cut.
void PlanarArrangement::cut_until_no_two_cross()
{
    merge_coincident();
    const std::vector<Edge> given = edges_;
    const std::size_t n_given = points_.size();
    for (int round = 0; cut_once(); ++round) {
        if (round == kRoundsBeforeSnap) {
            edges_ = given;
            points_.resize(n_given);
            is_input_.resize(n_given);
            snap_to_squares();
        }
        if (round == kMostRounds)
            throw Error("region: crossings did not settle on the grid; scale the polygon down");
        merge_coincident();
    }
}

// Pieces of nearly parallel edges can move on with every round. Then all crossings of the edges as
// they were given are rounded, and each of these edges is led through all points whose grid squares
// it passes: the result has no crossings but for edges that touch a square in a corner.
void PlanarArrangement::snap_to_squares()
{
    const auto box_of = [&](const Point& p) {
        Box2 box;
        box.add(Vec2{{static_cast<double>(p.x), static_cast<double>(p.y)}});
        return box;
    };
    std::vector<Box2> boxes;
    for (const Edge& e : edges_) {
        Box2 box = box_of(points_[e.from]);
        box.add(box_of(points_[e.to]));
        boxes.push_back(box.inflated(0.5));
    }
    const auto n_edges = static_cast<std::int32_t>(edges_.size());
    for (const auto& [i, j] : overlapping_pairs(boxes)) {
        const Edge &a = edges_[i], &b = edges_[j];
        if (side(a, points_[b.from]) * side(a, points_[b.to]) >= 0) continue;
        if (side(b, points_[a.from]) * side(b, points_[a.to]) >= 0) continue;
        points_.push_back(rounded_crossing(a, b));
    }
    // Equal points are one: the first of them, those given before.
    std::map<Point, std::int32_t> numbers;
    std::vector<Point> distinct;
    for (std::size_t v = 0; v < points_.size(); ++v)
        if (v < is_input_.size() || numbers.find(points_[v]) == numbers.end()) {
            numbers.try_emplace(points_[v], static_cast<std::int32_t>(distinct.size()));
            distinct.push_back(points_[v]);
        }
    points_ = std::move(distinct);
    is_input_.resize(points_.size(), false);

    for (const Point& p : points_) boxes.push_back(box_of(p));
    std::vector<std::pair<std::int32_t, std::int32_t>> cuts;  // edge, vertex
    for (const auto& [i, j] : overlapping_pairs(boxes)) {
        const std::int32_t edge = std::min(i, j), v = std::max(i, j) - n_edges;
        if (edge >= n_edges || v < 0) continue;
        const Edge& e = edges_[edge];
        if (v != e.from && v != e.to && passes_square(e, points_[v])) cuts.emplace_back(edge, v);
    }
    split(cuts);
    merge_coincident();
}

bool PlanarArrangement::passes_square(const Edge& e, const Point& r) const
{
    const Point p = points_[e.from], q = points_[e.to];
    const Wide dx = q.x - p.x, dy = q.y - p.y, ex = r.x - p.x, ey = r.y - p.y;
    const Wide off = 2 * (dx * ey - dy * ex);
    const Wide reach = (dx < 0 ? -dx : dx) + (dy < 0 ? -dy : dy), on = dx * ex + dy * ey;
    return -reach < off && off <= reach && on > 0 && on < dx * dx + dy * dy;
}

PlanarArrangement::Point PlanarArrangement::rounded_crossing(const Edge& a, const Edge& b) const
{
    const Point p = points_[a.from], q = points_[a.to];
    const Point r = points_[b.from], s = points_[b.to];
    const Wide den = Wide(q.x - p.x) * (s.y - r.y) - Wide(q.y - p.y) * (s.x - r.x);
    const Wide num = Wide(r.x - p.x) * (s.y - r.y) - Wide(r.y - p.y) * (s.x - r.x);
    return {p.x + divide_rounded((q.x - p.x) * num, den),
            p.y + divide_rounded((q.y - p.y) * num, den)};
}

bool PlanarArrangement::cut_once()
{
    std::vector<Box2> boxes(edges_.size());
    for (std::size_t i = 0; i < edges_.size(); ++i)
        for (const std::int32_t end : {edges_[i].from, edges_[i].to})
            boxes[i].add(
                Vec2{{static_cast<double>(points_[end].x), static_cast<double>(points_[end].y)}});

    std::vector<std::pair<std::int32_t, std::int32_t>> cuts;  // edge, vertex
    const auto cut_at = [&](std::int32_t e, std::int32_t v) {
        if (v != edges_[e].from && v != edges_[e].to) cuts.emplace_back(e, v);
    };
    const auto strictly_within = [&](const Edge& e, std::int32_t v) {
        return points_[e.from] < points_[v] && points_[v] < points_[e.to];
    };
    std::map<Point, std::int32_t> numbers;
    for (std::size_t i = 0; i < points_.size(); ++i)
        numbers.emplace(points_[i], static_cast<std::int32_t>(i));
    const auto number = [&](const Point& p) {
        const auto [place, is_new] = numbers.try_emplace(p, static_cast<int>(points_.size()));
        if (is_new) {
            points_.push_back(p);
            is_input_.push_back(false);
        }
        return place->second;
    };
    for (const auto& [i, j] : overlapping_pairs(boxes)) {
        const Edge a = edges_[i], b = edges_[j];
        const int b_from = side(a, points_[b.from]), b_to = side(a, points_[b.to]);
        const int a_from = side(b, points_[a.from]), a_to = side(b, points_[a.to]);
        if (b_from * b_to > 0 || a_from * a_to > 0) continue;
        // End points on the other edge, among them all ends of collinear overlaps.
        bool touch = false;
        const auto end_on_edge = [&](std::int32_t edge, const Edge& e, std::int32_t v, int where) {
            if (where != 0) return;
            touch = true;
            if (strictly_within(e, v)) cut_at(edge, v);
        };
        end_on_edge(i, a, b.from, b_from);
        end_on_edge(i, a, b.to, b_to);
        end_on_edge(j, b, a.from, a_from);
        end_on_edge(j, b, a.to, a_to);
        if (touch) continue;
        const std::int32_t v = number(rounded_crossing(a, b));
        cut_at(i, v);
        cut_at(j, v);
    }
    if (cuts.empty()) return false;
    split(cuts);
    return true;
}

void PlanarArrangement::split(std::vector<std::pair<std::int32_t, std::int32_t>>& cuts)
{
    const auto along = [&](const Edge& e, std::int32_t v) {
        const Point p = points_[e.from], q = points_[e.to], r = points_[v];
        return Wide(q.x - p.x) * (r.x - p.x) + Wide(q.y - p.y) * (r.y - p.y);
    };
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
    std::vector<Edge> pieces;
    pieces.reserve(edges_.size() + 2 * cuts.size());
    std::size_t next = 0;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        const Edge& edge = edges_[i];
        std::vector<std::int32_t> chain{edge.from};
        const std::size_t first = next;
        while (next < cuts.size() && cuts[next].first == static_cast<std::int32_t>(i)) ++next;
        for (std::size_t k = first; k < next; ++k) chain.push_back(cuts[k].second);
        std::sort(chain.begin() + 1, chain.end(),
                  [&](std::int32_t u, std::int32_t v) { return along(edge, u) < along(edge, v); });
        chain.push_back(edge.to);
        for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
            // Rounding may turn a piece round: from stays the smaller end.
            const bool forward = points_[chain[k]] < points_[chain[k + 1]];
            Edge piece = edge;
            piece.from = chain[forward ? k : k + 1];
            piece.to = chain[forward ? k + 1 : k];
            if (!forward)
                for (auto& turn : piece.turns) turn = -turn;
            pieces.push_back(piece);
        }
    }
    edges_ = std::move(pieces);
}

void PlanarArrangement::merge_coincident()
{
    std::sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) {
        return edge_key(a.from, a.to) < edge_key(b.from, b.to);
    });
    std::vector<Edge> merged;
    for (const Edge& edge : edges_) {
        if (merged.empty() || merged.back().from != edge.from || merged.back().to != edge.to) {
            merged.push_back(edge);
            continue;
        }
        for (int channel = 0; channel < 2; ++channel)
            merged.back().turns[channel] += edge.turns[channel];
        if (merged.back().source != edge.source) merged.back().source = -1;
    }
    std::erase_if(merged, [](const Edge& e) { return e.turns == Winding{}; });
    edges_ = std::move(merged);
}

// 1 if p lies above the edge, that is left of it from its smaller to its larger end.
int PlanarArrangement::side(const Edge& edge, const Point& p) const
{
    const Point a = points_[edge.from], b = points_[edge.to];
    return sign(Wide(b.x - a.x) * (p.y - a.y) - Wide(b.y - a.y) * (p.x - a.x));
}

// Edges in lexicographic order of their points; the status holds those over the sweep line from
// below to above. Vertical edges count as leaning to the right.
void PlanarArrangement::sweep()
{
    const auto below = [this](std::int32_t i, std::int32_t j) {
        if (i == j) return false;
        const Edge &a = edges_[i], &b = edges_[j];
        if (points_[a.from] <= points_[b.from]) {
            const int where = side(a, points_[b.from]);
            return where != 0 ? where > 0 : side(a, points_[b.to]) > 0;
        }
        const int where = side(b, points_[a.from]);
        return where != 0 ? where < 0 : side(b, points_[a.to]) < 0;
    };
    std::vector<std::int32_t> by_start(edges_.size()), by_end(edges_.size());
    std::iota(by_start.begin(), by_start.end(), 0);
    by_end = by_start;
    std::sort(by_start.begin(), by_start.end(), [&](std::int32_t i, std::int32_t j) {
        if (edges_[i].from != edges_[j].from)
            return points_[edges_[i].from] < points_[edges_[j].from];
        return below(i, j);
    });
    std::sort(by_end.begin(), by_end.end(), [&](std::int32_t i, std::int32_t j) {
        return points_[edges_[i].to] < points_[edges_[j].to];
    });
    std::set<std::int32_t, decltype(below)> status(below);
    std::vector<decltype(status)::iterator> place(edges_.size());
    std::size_t ended = 0;
    for (const std::int32_t i : by_start) {
        const Point start = points_[edges_[i].from];
        while (ended < by_end.size() && points_[edges_[by_end[ended]].to] <= start)
            status.erase(place[by_end[ended++]]);
        place[i] = status.insert(i).first;
        if (place[i] == status.begin()) continue;
        const Edge& lower = edges_[*std::prev(place[i])];
        for (int channel = 0; channel < 2; ++channel)
            edges_[i].below[channel] = lower.below[channel] + lower.turns[channel];
    }
}

std::vector<Ring> PlanarArrangement::border(const std::function<bool(const Winding&)>& inside) const
{
    std::vector<Edge> kept;  // directed, inside on the left
    for (const Edge& edge : edges_) {
        Winding above = edge.below;
        for (int channel = 0; channel < 2; ++channel) above[channel] += edge.turns[channel];
        const bool inside_above = inside(above);
        if (inside_above == inside(edge.below)) continue;
        kept.push_back(edge);
        if (!inside_above) std::swap(kept.back().from, kept.back().to);
    }
    const auto traced = trace(kept);
    // Where rings touch, the point stays a corner of each of them.
    std::vector<std::int32_t> n_rings(points_.size(), 0);
    for (const auto& ring : traced)
        for (const std::int32_t v : ring) ++n_rings[v];
    std::vector<Ring> rings, on_grid;
    for (const auto& ring : traced) {
        const auto corners = without_flat_corners(ring, n_rings);
        if (corners.size() < 3) continue;
        rings.push_back(to_ring(corners, true));
    }
    if (!rings_cross(rings)) return rings;
    // Original coordinates differ from the grid by half a step at most, yet that was too much
    // somewhere. The grid is always right.
    for (const auto& ring : traced) on_grid.push_back(to_ring(ring, false));
    return on_grid;
}

// At a vertex where several rings meet, turn into the edge that bounds the same piece of the
// inside: the first one clockwise from the way back.
std::vector<std::vector<std::int32_t>> PlanarArrangement::trace(const std::vector<Edge>& kept) const
{
    std::vector<std::int32_t> start(points_.size() + 1, 0), out(kept.size());
    for (const Edge& e : kept) ++start[e.from + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    std::vector<std::int32_t> fill(start.begin(), start.end() - 1);
    for (std::size_t i = 0; i < kept.size(); ++i) out[fill[kept[i].from]++] = static_cast<int>(i);

    const auto direction = [&](std::int32_t from, std::int32_t to) {
        return Point{points_[to].x - points_[from].x, points_[to].y - points_[from].y};
    };
    const auto cross_sign = [](const Point& a, const Point& b) {
        return sign(Wide(a.x) * b.y - Wide(a.y) * b.x);
    };
    // Clockwise angle from `back` to a direction: 0 for (0, 180), 1 for 180, 2 for (180, 360).
    const auto half = [&](const Point& back, const Point& d) {
        const int turn = cross_sign(back, d);
        return turn < 0 ? 0 : turn > 0 ? 2 : 1;
    };
    const auto comes_first = [&](const Point& back, const Point& a, const Point& b) {
        const int ha = half(back, a), hb = half(back, b);
        return ha != hb ? ha < hb : cross_sign(a, b) < 0;
    };
    const auto next_edge = [&](const Edge& edge) {
        const Point back = direction(edge.to, edge.from);
        std::int32_t best = out[start[edge.to]];
        for (std::int32_t k = start[edge.to] + 1; k < start[edge.to + 1]; ++k)
            if (comes_first(back, direction(edge.to, kept[out[k]].to),
                            direction(edge.to, kept[best].to)))
                best = out[k];
        return best;
    };
    std::vector<std::vector<std::int32_t>> rings;
    std::vector<bool> used(kept.size(), false);
    for (std::size_t first = 0; first < kept.size(); ++first) {
        if (used[first]) continue;
        std::vector<std::int32_t> ring;
        for (auto e = static_cast<std::int32_t>(first); !used[e]; e = next_edge(kept[e])) {
            used[e] = true;
            ring.push_back(kept[e].from);
        }
        rings.push_back(std::move(ring));
    }
    return rings;
}

// A corner that is straight on the grid, or that only stands where a cut through an input edge was
// rounded, is not a corner of the region.
std::vector<std::int32_t> PlanarArrangement::without_flat_corners(
    const std::vector<std::int32_t>& ring, const std::vector<std::int32_t>& n_rings) const
{
    const auto flat = [&](std::int32_t u, std::int32_t v, std::int32_t w) {
        if (n_rings[v] > 1) return false;
        const Point a = points_[u], b = points_[v], c = points_[w];
        const Wide area = Wide(b.x - a.x) * (c.y - a.y) - Wide(b.y - a.y) * (c.x - a.x);
        if (area == 0) return true;
        if (is_input_[v]) return false;
        const Wide dx = c.x - a.x, dy = c.y - a.y;
        // Off the line by less than a grid step: area^2 <= |c - a|^2, and between the ends.
        const Wide limit = (dx < 0 ? -dx : dx) + (dy < 0 ? -dy : dy);
        const Wide along = dx * (b.x - a.x) + dy * (b.y - a.y);
        return (area < 0 ? -area : area) <= limit && along > 0 && along < dx * dx + dy * dy;
    };
    std::vector<std::int32_t> kept;
    const std::size_t n = ring.size();
    std::size_t first = 0;
    while (first < n && flat(ring[(first + n - 1) % n], ring[first], ring[(first + 1) % n]))
        ++first;
    if (first == n) return kept;
    kept.push_back(ring[first]);
    for (std::size_t k = 1; k < n; ++k) {
        const std::int32_t v = ring[(first + k) % n], w = ring[(first + k + 1) % n];
        if (!flat(kept.back(), v, w)) kept.push_back(v);
    }
    return kept;
}

Ring PlanarArrangement::to_ring(const std::vector<std::int32_t>& ring, bool original) const
{
    Ring points;
    points.reserve(ring.size());
    for (const std::int32_t v : ring)
        points.push_back(
            {{coordinate(points_[v].x, 0, original), coordinate(points_[v].y, 1, original)}});
    return points;
}

double PlanarArrangement::coordinate(std::int64_t snapped, int axis, bool original) const
{
    if (original) {
        const auto& known = originals_[axis];
        const auto at = std::lower_bound(
            known.begin(), known.end(), snapped,
            [](const Coordinate& c, std::int64_t value) { return c.snapped < value; });
        if (at != known.end() && at->snapped == snapped) return at->original;
    }
    return std::ldexp(static_cast<double>(snapped), -exponent_) + origin_[axis];
}

bool rings_cross(std::span<const Ring> rings)
{
    struct Side {
        Vec2 a, b;
    };
    std::vector<Side> sides;
    std::vector<Box2> boxes;
    for (const Ring& ring : rings)
        for (std::size_t i = 0; i < ring.size(); ++i) {
            sides.push_back({ring[i], ring[(i + 1) % ring.size()]});
            Box2 box;
            box.add(sides.back().a);
            box.add(sides.back().b);
            boxes.push_back(box);
        }
    for (const auto& [i, j] : overlapping_pairs(boxes)) {
        const auto& [a, b] = sides[i];
        const auto& [c, d] = sides[j];
        const int c_side = orient2d(a, b, c), d_side = orient2d(a, b, d);
        const int a_side = orient2d(c, d, a), b_side = orient2d(c, d, b);
        if (c_side * d_side < 0 && a_side * b_side < 0) return true;
        if (c_side != 0 || d_side != 0) continue;
        // On one line: an overlap longer than a point.
        const Box2 common = intersection(boxes[i], boxes[j]);
        if (common.size()[0] > 0.0 || common.size()[1] > 0.0) return true;
    }
    return false;
}

}  // namespace genus
