#include "genus/polygon/sweep.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/polygon/sweep_status.h"

namespace genus {

namespace {

// Vertices are numbered in the order in which the line meets them, by x, then y: of two numbers
// the smaller is the left one.
using Vertex = std::int32_t;

struct EdgeEnd {
    Vertex right;
    std::int32_t turn;  // what the winding number grows by from below to above
};

class SweepTriangulator {
public:
    explicit SweepTriangulator(std::span<const OrientedRing> rings)
    {
        number_points(rings);
        list_edges(rings);
    }

    SweepTriangulation run()
    {
        triangles_.reserve(points_.size() + 16);
        ending_at_.assign(points_.size(), kNone);
        for (Vertex v = 0; v < static_cast<Vertex>(points_.size()); ++v) {
            if (v % 1024 == 1023) current_progress().check();
            collect_right_edges(v);
            if (ending_at_[v] == kNone)
                begin_at(v);
            else
                pass(v);
        }
        for (PolygonTriangle& t : triangles_)
            for (std::int32_t& corner : t) corner = name_[corner];
        for (std::int32_t& vertex : vertex_of_) vertex = name_[vertex];
        return {std::move(triangles_), std::move(vertex_of_)};
    }

private:
    static constexpr std::int32_t kNone = SweepStatus::kNone;

    // ---- preparation ---------------------------------------------------------------------------

    struct Numbered {
        double x, y;
        std::int32_t name;
    };

    void number_points(std::span<const OrientedRing> rings)
    {
        std::size_t n = 0;
        for (const OrientedRing& ring : rings) n += ring.points.size();
        require(n < (std::size_t{1} << 30), "triangulate: more than 2^30 points");
        std::vector<Numbered> order;
        order.reserve(n);
        for (const OrientedRing& ring : rings)
            for (const Vec2& p : ring.points) {
                if (!is_finite(p))
                    throw InvalidInput("triangulate: point " + std::to_string(order.size()) +
                                       " is not finite");
                order.push_back({p[0], p[1], static_cast<std::int32_t>(order.size())});
            }
        std::sort(order.begin(), order.end(), [](const Numbered& a, const Numbered& b) {
            if (a.x != b.x) return a.x < b.x;
            return a.y != b.y ? a.y < b.y : a.name < b.name;
        });
        vertex_of_.resize(n);
        for (const Numbered& p : order) {
            const Vec2 at{{p.x, p.y}};
            if (points_.empty() || points_.back() != at) {
                points_.push_back(at);
                name_.push_back(p.name);
            }
            vertex_of_[p.name] = static_cast<Vertex>(points_.size()) - 1;
        }
    }

    // Edges by left end: those of v are edges_[first_edge_[v]] .. edges_[first_edge_[v + 1] - 1].
    void list_edges(std::span<const OrientedRing> rings)
    {
        const auto for_each_edge = [&](auto&& visit) {
            std::size_t first = 0;
            for (const OrientedRing& ring : rings) {
                const std::size_t n = ring.points.size();
                const int forward = ring.reversed ? -1 : 1;
                for (std::size_t i = 0; i < n; ++i) {
                    const Vertex a = vertex_of_[first + i];
                    const Vertex b = vertex_of_[i + 1 < n ? first + i + 1 : first];
                    if (a < b) visit(a, b, forward);
                    if (b < a) visit(b, a, -forward);
                }
                first += n;
            }
        };
        first_edge_.assign(points_.size() + 1, 0);
        for_each_edge([&](Vertex left, Vertex, int) { ++first_edge_[left + 1]; });
        for (std::size_t v = 0; v < points_.size(); ++v) first_edge_[v + 1] += first_edge_[v];
        edges_.resize(first_edge_.back());
        std::vector<std::int32_t> cursor(first_edge_.begin(), first_edge_.end() - 1);
        for_each_edge([&](Vertex left, Vertex right, int turn) {
            edges_[cursor[left]++] = {right, turn};
        });
    }

    int orient(Vertex a, Vertex b, Vertex c) const
    {
        return orient2d(points_[a], points_[b], points_[c]);
    }

    // The edges to the right of v from bottom to top, equal ones as one.
    void collect_right_edges(Vertex v)
    {
        right_edges_.assign(edges_.begin() + first_edge_[v], edges_.begin() + first_edge_[v + 1]);
        std::sort(right_edges_.begin(), right_edges_.end(),
                  [&](const EdgeEnd& a, const EdgeEnd& b) {
                      const int turn = orient(v, a.right, b.right);
                      return turn != 0 ? turn > 0 : a.right < b.right;
                  });
        std::size_t kept = 0;
        for (const EdgeEnd& edge : right_edges_) {
            if (kept > 0 && right_edges_[kept - 1].right == edge.right) {
                right_edges_[kept - 1].turn += edge.turn;
                continue;
            }
            if (kept > 0 && orient(v, right_edges_[kept - 1].right, edge.right) == 0)
                refuse_point_on_edge(right_edges_[kept - 1].right, v, edge.right);
            right_edges_[kept++] = edge;
        }
        right_edges_.resize(kept);
    }

    // ---- refusals ------------------------------------------------------------------------------

    std::string text(Vertex v) const
    {
        std::string out = std::to_string(name_[v]);
        out += " (" + to_text(points_[v][0]) + ", " + to_text(points_[v][1]) + ")";
        return out;
    }

    [[noreturn]] void refuse_point_on_edge(Vertex p, Vertex a, Vertex b) const
    {
        throw InvalidInput("triangulate: point " + text(p) + " lies on the edge from point " +
                           text(a) + " to point " + text(b));
    }

    [[noreturn]] void refuse_crossing(Vertex a, Vertex b, Vertex c, Vertex d) const
    {
        throw InvalidInput("triangulate: the edge from point " + text(a) + " to point " + text(b) +
                           " meets the edge from point " + text(c) + " to point " + text(d));
    }

    [[noreturn]] void refuse_winding(Vertex v, int winding) const
    {
        throw InvalidInput("triangulate: beside point " + text(v) + " the rings wind " +
                           std::to_string(winding) +
                           " times: rings overlap, or a hole is not inside");
    }

    // Both edges cross the line, one just above the other. They will meet before one of them ends
    // if the first right end is not on its side of the other edge.
    void check_neighbours(std::int32_t lower, std::int32_t upper) const
    {
        if (lower == kNone || upper == kNone) return;
        const auto [a, b] = ends(lower);
        const auto [c, d] = ends(upper);
        // Common left ends are sorted by angle. With a common right end they may overlap.
        if (b < d) {
            const int side = orient(c, d, b);
            if (side == 0 && a != c) refuse_point_on_edge(b, c, d);
            if (side > 0) refuse_crossing(a, b, c, d);
        } else if (d < b) {
            const int side = orient(a, b, d);
            if (side == 0 && a != c) refuse_point_on_edge(d, a, b);
            if (side < 0) refuse_crossing(a, b, c, d);
        } else if (a != c && orient(std::min(a, c), b, std::max(a, c)) == 0) {
            refuse_point_on_edge(std::max(a, c), std::min(a, c), b);
        }
    }

    std::array<Vertex, 2> ends(std::int32_t edge) const
    {
        return {status_[edge].left, status_[edge].right};
    }

    // ---- chains --------------------------------------------------------------------------------

    // What lies between two neighbouring edges of the line, left of it, is triangulated up to a
    // chain of vertices from the left end of the lower edge to that of the upper. Between its
    // ends the chain bends away nowhere: seen from the free side no three links in a row are
    // convex, but for the rightmost vertex, where it turns back.
    using Chain = SweepStatus::Chain;

    struct Link {
        Vertex vertex;
        std::int32_t down, up;
    };

    std::int32_t new_link(Vertex v)
    {
        links_.push_back({v, kNone, kNone});
        return static_cast<std::int32_t>(links_.size()) - 1;
    }

    void connect(std::int32_t lower, std::int32_t upper)
    {
        links_[lower].up = upper;
        links_[upper].down = lower;
    }

    // Cuts off the triangle of v with a link and the one above, if it is one.
    bool cut(std::int32_t lower, Vertex v, std::int32_t upper)
    {
        const Vertex a = links_[lower].vertex, b = links_[upper].vertex;
        if (orient(a, v, b) <= 0) return false;
        triangles_.push_back({a, v, b});
        return true;
    }

    std::int32_t cut_upward(std::int32_t from, Vertex v)
    {
        while (links_[from].up != kNone && cut(from, v, links_[from].up)) from = links_[from].up;
        return from;
    }

    std::int32_t cut_downward(std::int32_t from, Vertex v)
    {
        while (links_[from].down != kNone && cut(links_[from].down, v, from))
            from = links_[from].down;
        return from;
    }

    // v is where the upper edge of the chain's stretch ends.
    void end_at_top(Chain& chain, Vertex v)
    {
        const std::int32_t last = cut_downward(chain.top, v), link = new_link(v);
        connect(last, link);
        chain.top = chain.rightmost = link;
    }

    void end_at_bottom(Chain& chain, Vertex v)
    {
        const std::int32_t last = cut_upward(chain.bottom, v), link = new_link(v);
        connect(link, last);
        chain.bottom = chain.rightmost = link;
    }

    // v is where both edges of the stretch end: it sees the whole chain.
    void close(const Chain& chain, Vertex v)
    {
        if (cut_upward(chain.bottom, v) != chain.top)
            throw InvalidInput("triangulate: edges overlap left of point " + text(v));
    }

    Chain single(Vertex v)
    {
        const std::int32_t link = new_link(v);
        return {link, link, link};
    }

    // v appears within the stretch. Returns the chain above v; `chain` becomes the one below.
    Chain split(Chain& chain, Vertex v)
    {
        const std::int32_t upper = cut_upward(chain.rightmost, v);
        const std::int32_t lower = cut_downward(chain.rightmost, v);
        std::int32_t first_above = upper;
        Chain above = chain;
        if (upper == lower) {  // it belongs to both
            first_above = new_link(links_[upper].vertex);
            if (links_[upper].up != kNone)
                connect(first_above, links_[upper].up);
            else
                above.top = first_above;
        }
        const std::int32_t link_below = new_link(v), link_above = new_link(v);
        connect(lower, link_below);
        chain.top = chain.rightmost = link_below;
        connect(link_above, first_above);
        above.bottom = above.rightmost = link_above;
        return above;
    }

    // The chains of two stretches that v, where the edges between them end, makes one.
    void join(Chain& lower, const Chain& upper)
    {
        const std::int32_t second = links_[upper.bottom].up;
        lower.rightmost = lower.top;
        if (second == kNone) return;
        connect(lower.top, second);
        lower.top = upper.top;
    }

    // ---- events --------------------------------------------------------------------------------

    int winding_above(std::int32_t edge) const
    {
        return edge == kNone ? 0 : status_[edge].winding_above;
    }

    // No edge comes from the left.
    void begin_at(Vertex v)
    {
        if (right_edges_.empty()) return;
        const auto side = [&](std::int32_t edge) {
            const auto [a, b] = ends(edge);
            const int turn = orient(a, b, v);
            if (turn == 0) refuse_point_on_edge(v, a, b);
            return turn;
        };
        const std::int32_t below = status_.last_below(side);
        Chain above{};
        if (winding_above(below) == 1) above = split(status_[below].chain, v);
        insert_right_edges(v, below, above);
    }

    void pass(Vertex v)
    {
        std::int32_t lowest = ending_at_[v], highest = lowest;
        while (status_.below(lowest) != kNone && status_[status_.below(lowest)].right == v)
            lowest = status_.below(lowest);
        while (status_.above(highest) != kNone && status_[status_.above(highest)].right == v)
            highest = status_.above(highest);
        const std::int32_t below = status_.below(lowest);
        if (winding_above(below) == 1) end_at_top(status_[below].chain, v);
        for (std::int32_t e = lowest; e != highest; e = status_.above(e))
            if (winding_above(e) == 1) close(status_[e].chain, v);
        const int winding = winding_above(highest);
        if (winding == 1) end_at_bottom(status_[highest].chain, v);

        if (lowest == highest && right_edges_.size() == 1) {
            go_on(lowest, v);
            return;
        }
        const Chain above = status_[highest].chain;
        while (lowest != highest) {
            const std::int32_t next = status_.above(lowest);
            status_.erase(lowest);
            lowest = next;
        }
        status_.erase(highest);
        if (right_edges_.empty()) {
            if (winding == 1) join(status_[below].chain, above);
            check_neighbours(below, status_.first_above(below));
        } else {
            insert_right_edges(v, below, above);
        }
    }

    // One edge in, one edge out: it takes the other's place in the line.
    void go_on(std::int32_t edge, Vertex v)
    {
        const EdgeEnd& next = right_edges_[0];
        status_[edge].left = v;
        status_[edge].right = next.right;
        ending_at_[next.right] = edge;
        check_neighbours(status_.below(edge), edge);
        check_neighbours(edge, status_.above(edge));
    }

    void insert_right_edges(Vertex v, std::int32_t below, const Chain& above)
    {
        int winding = winding_above(below);
        std::int32_t edge = below;
        for (std::size_t i = 0; i < right_edges_.size(); ++i) {
            edge = status_.insert_after(edge);
            SweepStatus::Edge& inserted = status_[edge];
            inserted.left = v;
            inserted.right = right_edges_[i].right;
            winding += right_edges_[i].turn;
            if (winding < 0 || winding > 1) refuse_winding(v, winding);
            inserted.winding_above = winding;
            ending_at_[inserted.right] = edge;
            if (winding == 1) inserted.chain = i + 1 < right_edges_.size() ? single(v) : above;
            if (i == 0) check_neighbours(below, edge);
        }
        check_neighbours(edge, status_.above(edge));
    }

    std::vector<Vec2> points_;
    std::vector<std::int32_t> name_;  // of a vertex: the first point at its place
    std::vector<Vertex> vertex_of_;   // of a point
    std::vector<std::int32_t> first_edge_;
    std::vector<EdgeEnd> edges_;
    std::vector<EdgeEnd> right_edges_;     // of the current vertex
    std::vector<std::int32_t> ending_at_;  // an edge of the line that ends at a vertex
    SweepStatus status_;
    std::vector<Link> links_;
    std::vector<PolygonTriangle> triangles_;
};

}  // namespace

SweepTriangulation sweep_triangulation(std::span<const OrientedRing> rings)
{
    return SweepTriangulator(rings).run();
}

}  // namespace genus
