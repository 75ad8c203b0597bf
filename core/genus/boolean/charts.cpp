#include "genus/boolean/charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "genus/boolean/star_shaped.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

// A chart takes faces whose normal has this share of its length along the axis of the chart, so
// that faces just beyond an octant's border do not make charts of their own.
constexpr double kAlong = 0.3;
// Operands with fewer faces are compared face by face: that costs less than their borders.
constexpr Index kFewFaces = 100;

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

class ChartMaker {
public:
    explicit ChartMaker(const Soup& soup) : soup_(soup), owner_(soup.faces.size(), -1) {}

    std::vector<Index> run()
    {
        number_operands();
        for (Index f = 0; f < n_faces(); ++f)
            if (owner_[f] < 0 && divided_[soup_.operand[f]]) grow(f);
        if (charts_.empty()) return std::move(owner_);
        list_borders();
        check_crossings();
        check_loops();
        for (Index& owner : owner_)
            if (owner >= first_ && !charts_[owner - first_].sound) owner = -1;
        return std::move(owner_);
    }

private:
    struct Chart {
        int axis;
        int sign;
        bool sound = true;
        int n_outer = 0;
    };
    // A halfedge whose twin lies outside of its chart.
    struct Border {
        Index chart;
        Index halfedge;
    };

    Index n_faces() const { return static_cast<Index>(soup_.faces.size()); }
    Index from(Index h) const { return soup_.faces[h / 3][h % 3]; }
    Index to(Index h) const { return soup_.faces[h / 3][next(h % 3)]; }

    void number_operands()
    {
        std::vector<Index> size;
        for (const Index operand : soup_.operand) {
            if (operand >= static_cast<Index>(size.size())) size.resize(operand + 1, 0);
            ++size[operand];
        }
        first_ = static_cast<Index>(size.size());
        divided_.assign(size.size(), 0);
        for (Index i = 0; i < first_; ++i) divided_[i] = crosses_itself(i) && size[i] >= kFewFaces;
        for (Index begin = 0, end = 0; begin < n_faces(); begin = end) {
            const Index operand = soup_.operand[begin];
            while (end < n_faces() && soup_.operand[end] == operand) ++end;
            // The faces of an operand are mostly in a row.
            if (divided_[operand] && size[operand] == end - begin &&
                is_star_shaped(soup_, begin, end))
                divided_[operand] = 0;
            else if (crosses_itself(operand))
                continue;
            std::fill(owner_.begin() + begin, owner_.begin() + end, operand);
        }
    }
    bool crosses_itself(Index operand) const
    {
        return !soup_.crosses_itself.empty() && soup_.crosses_itself[operand] != 0;
    }

    Vec3 normal(Index f) const
    {
        const Triangle& t = soup_.faces[f];
        const Vec3& a = soup_.points[t[0]];
        return cross(soup_.points[t[1]] - a, soup_.points[t[2]] - a);
    }
    bool looks_along(Index f, const Chart& chart) const
    {
        const Vec3 n = normal(f);
        const double along = chart.sign * n[chart.axis];
        if (!(along > 0.0) || along * along < kAlong * kAlong * dot(n, n)) return false;
        const Triangle& t = soup_.faces[f];
        return turn(chart.axis, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]) ==
               chart.sign;
    }

    void grow(Index seed)
    {
        const Vec3 n = normal(seed);
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (std::abs(n[k]) > std::abs(n[axis])) axis = k;
        const Chart chart{axis, n[axis] > 0.0 ? 1 : -1};
        if (!looks_along(seed, chart)) return;
        const Index number = first_ + static_cast<Index>(charts_.size());
        charts_.push_back(chart);
        owner_[seed] = number;
        stack_.assign(1, seed);
        while (!stack_.empty()) {
            const Index f = stack_.back();
            stack_.pop_back();
            for (int i = 0; i < 3; ++i) {
                const Index h = soup_.twin[3 * f + i];
                if (h < 0 || owner_[h / 3] >= 0 || !looks_along(h / 3, chart)) continue;
                owner_[h / 3] = number;
                stack_.push_back(h / 3);
            }
        }
    }

    bool is_border(Index h) const
    {
        const Index twin = soup_.twin[h];
        return twin < 0 || owner_[twin / 3] != owner_[h / 3];
    }

    void list_borders()
    {
        for (Index f = 0; f < n_faces(); ++f)
            for (Index h = 3 * f; owner_[f] >= first_ && h < 3 * f + 3; ++h)
                if (is_border(h)) borders_.push_back({owner_[f] - first_, h});
    }

    // Borders of one chart may meet in common corners only. The third coordinate of their boxes
    // is the number of the chart, which parts those of different ones.
    void check_crossings()
    {
        std::vector<FloatBox> boxes;
        boxes.reserve(borders_.size());
        for (const Border& border : borders_) {
            Vec3 a = soup_.points[from(border.halfedge)];
            Vec3 b = soup_.points[to(border.halfedge)];
            a[charts_[border.chart].axis] = b[charts_[border.chart].axis] = border.chart;
            boxes.push_back(box_of(a, b, b));
            // Along the first axis, whichever the chart looks along.
            const int axis = charts_[border.chart].axis;
            std::swap(boxes.back().low[0], boxes.back().low[axis]);
            std::swap(boxes.back().high[0], boxes.back().high[axis]);
        }
        const BoxTree tree(std::move(boxes), {});
        std::vector<std::vector<Index>> crossed;
        tree.visit_pairs([&](std::size_t parts) { crossed.resize(parts); },
                         [&](Index i, Index j, std::size_t part) {
                             const Border& a = borders_[i];
                             const Border& b = borders_[j];
                             if (a.chart == b.chart && meet(a, b)) crossed[part].push_back(a.chart);
                         });
        for (const auto& part : crossed)
            for (const Index chart : part) charts_[chart].sound = false;
    }

    // Do two borders, seen along the axis, meet in more than one common corner?
    bool meet(const Border& x, const Border& y) const
    {
        Index a = from(x.halfedge);
        Index b = to(x.halfedge);
        Index c = from(y.halfedge);
        Index d = to(y.halfedge);
        if (b == c || b == d) std::swap(a, b);
        if (a == d) std::swap(c, d);
        if (a == c) return b == d || (turn_at(x, a, b, d) == 0 && same_way(x, a, b, d));
        const int side_c = turn_at(x, a, b, c);
        const int side_d = turn_at(x, a, b, d);
        if (side_c * side_d > 0) return false;
        const int side_a = turn_at(x, c, d, a);
        const int side_b = turn_at(x, c, d, b);
        // In one line only those whose boxes overlap come here.
        return side_a * side_b <= 0;
    }
    int turn_at(const Border& border, Index a, Index b, Index c) const
    {
        return turn(charts_[border.chart].axis, soup_.points[a], soup_.points[b], soup_.points[c]);
    }
    // For b and c on one line with a: on the same side of it?
    bool same_way(const Border& border, Index a, Index b, Index c) const
    {
        for (int i = 1; i <= 2; ++i) {
            const int k = (charts_[border.chart].axis + i) % 3;
            const double to_b = soup_.points[b][k] - soup_.points[a][k];
            const double to_c = soup_.points[c][k] - soup_.points[a][k];
            if (to_b != 0.0 || to_c != 0.0) return (to_b > 0.0) == (to_c > 0.0);
        }
        return true;
    }

    // Follows the borders round their charts, and parts what meets itself in a corner into simple
    // loops.
    void check_loops()
    {
        seen_.assign(soup_.twin.size(), 0);
        place_.assign(soup_.points.size(), -1);
        for (const Border& border : borders_) {
            Chart& chart = charts_[border.chart];
            if (!chart.sound || seen_[border.halfedge]) continue;
            follow(border.halfedge, chart);
        }
        for (Chart& chart : charts_) chart.sound = chart.sound && chart.n_outer == 1;
    }

    void follow(Index start, Chart& chart)
    {
        loop_.clear();
        Index h = start;
        do {
            seen_[h] = 1;
            const Index corner = from(h);
            if (place_[corner] >= 0) close_loop(static_cast<std::size_t>(place_[corner]), chart);
            place_[corner] = static_cast<Index>(loop_.size());
            loop_.push_back(corner);
            h = next_in_face(h);
            while (!is_border(h)) h = next_in_face(soup_.twin[h]);
        } while (h != start);
        close_loop(0, chart);
    }

    // Takes off the corners from `begin` on: one simple loop.
    void close_loop(std::size_t begin, Chart& chart)
    {
        const std::span<const Index> loop(loop_.data() + begin, loop_.size() - begin);
        const int u = next(chart.axis);
        const int v = next(u);
        const auto before = [&](Index a, Index b) {
            const Vec3& p = soup_.points[a];
            const Vec3& q = soup_.points[b];
            return p[u] != q[u] ? p[u] < q[u] : p[v] < q[v];
        };
        // The first corner in this order is convex.
        const auto at = static_cast<std::size_t>(
            std::min_element(loop.begin(), loop.end(), before) - loop.begin());
        const std::size_t n = loop.size();
        const int way = turn(chart.axis, soup_.points[loop[(at + n - 1) % n]],
                             soup_.points[loop[at]], soup_.points[loop[(at + 1) % n]]);
        if (n < 3 || way == 0) chart.sound = false;
        if (way == chart.sign) ++chart.n_outer;
        for (const Index corner : loop) place_[corner] = -1;
        loop_.resize(begin);
    }

    const Soup& soup_;
    std::vector<Index> owner_;
    Index first_ = 0;            // number of the first chart; below are operands
    std::vector<char> divided_;  // by operand
    std::vector<Chart> charts_;
    std::vector<Border> borders_;
    std::vector<Index> stack_;
    std::vector<char> seen_;    // by halfedge
    std::vector<Index> place_;  // by point: in loop_, or -1
    std::vector<Index> loop_;
};

}  // namespace

std::vector<std::int32_t> find_owners(const Soup& soup)
{
    return ChartMaker(soup).run();
}

}  // namespace genus::exact
