#include "genus/polygon/delaunay.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

using Side = std::int32_t;  // 3 t + i runs from corner i of triangle t to the next
constexpr Side kNone = -1;

Side next(Side s)
{
    return s % 3 == 2 ? s - 2 : s + 1;
}

Side previous(Side s)
{
    return s % 3 == 0 ? s + 2 : s - 1;
}

// For each side the one of the triangle beyond it, kNone where nothing or a fixed edge is.
// Sides are joined in buckets by the smaller end.
class SideJoiner {
public:
    SideJoiner(std::size_t n_points, const std::vector<PolygonTriangle>& triangles)
        : triangles_(triangles), bucket_(n_points + 1, 0), by_smaller_(3 * triangles.size())
    {
        const auto n = static_cast<Side>(by_smaller_.size());
        for (Side s = 0; s < n; ++s) ++bucket_[std::min(from(s), to(s)) + 1];
        std::partial_sum(bucket_.begin(), bucket_.end(), bucket_.begin());
        std::vector<std::int32_t> cursor(bucket_.begin(), bucket_.end() - 1);
        for (Side s = 0; s < n; ++s) by_smaller_[cursor[std::min(from(s), to(s))]++] = s;
    }

    std::vector<Side> twins(std::span<const std::array<std::int32_t, 2>> fixed)
    {
        std::vector<Side> twin(by_smaller_.size(), kNone);
        for (std::size_t v = 0; v + 1 < bucket_.size(); ++v) {
            const auto begin = by_smaller_.begin() + bucket_[v];
            const auto end = by_smaller_.begin() + bucket_[v + 1];
            std::sort(begin, end, [&](Side a, Side b) {
                return larger(a) != larger(b) ? larger(a) < larger(b) : a < b;
            });
            for (auto i = begin; i != end && i + 1 != end; ++i)
                if (from(i[0]) == to(i[1]) && to(i[0]) == from(i[1])) {
                    twin[i[0]] = i[1];
                    twin[i[1]] = i[0];
                }
        }
        for (const auto& [a, b] : fixed)
            for (std::int32_t i = bucket_[std::min(a, b)]; i < bucket_[std::min(a, b) + 1]; ++i)
                if (larger(by_smaller_[i]) == std::max(a, b)) twin[by_smaller_[i]] = kNone;
        return twin;
    }

private:
    std::int32_t from(Side s) const { return triangles_[s / 3][s % 3]; }
    std::int32_t to(Side s) const { return from(next(s)); }
    std::int32_t larger(Side s) const { return std::max(from(s), to(s)); }

    const std::vector<PolygonTriangle>& triangles_;
    std::vector<std::int32_t> bucket_;
    std::vector<Side> by_smaller_;
};

// Diagonals, each by one of its sides, in an order such that pieces of the region that open
// diagonals hold together grow in O(log n) rounds, and in each round a piece is joined to one
// other only. A spanning tree of triangles is contracted: its nodes never have more than three
// neighbours, so that a part of them that does not depend on n can be joined in pairs each time.
// Diagonals that are not in the tree follow as soon as both their sides belong to one piece.
class JoiningOrder {
public:
    explicit JoiningOrder(const std::vector<Side>& twin)
        : twin_(twin), parent_(twin.size() / 3), degree_(parent_.size(), 0)
    {
        reset();
        for (Side s = 0; s < static_cast<Side>(twin.size()); ++s) {
            if (twin[s] < s) continue;
            const std::int32_t a = piece(s / 3), b = piece(twin[s] / 3);
            (a == b ? cycle_ : tree_).push_back(s);
            parent_[b] = a;
            if (a == b) continue;
            ++degree_[s / 3];
            ++degree_[twin[s] / 3];
        }
        reset();
    }

    std::vector<Side> run()
    {
        order_.reserve(tree_.size() + cycle_.size());
        for (joined_.assign(parent_.size(), 0); !tree_.empty(); ++round_) {
            current_progress().check();
            std::erase_if(tree_, [&](Side s) { return join(s); });
            std::erase_if(cycle_, [&](Side s) {
                const bool one_piece = piece(s / 3) == piece(twin_[s] / 3);
                if (one_piece) order_.push_back(s);
                return one_piece;
            });
        }
        return std::move(order_);
    }

private:
    void reset() { std::iota(parent_.begin(), parent_.end(), 0); }

    std::int32_t piece(std::int32_t t)
    {
        while (parent_[t] != t) t = parent_[t] = parent_[parent_[t]];
        return t;
    }

    bool join(Side s)
    {
        const std::int32_t a = piece(s / 3), b = piece(twin_[s] / 3);
        const int degree = degree_[a] + degree_[b] - 2;
        if (joined_[a] == round_ || joined_[b] == round_ || degree > 3) return false;
        parent_[b] = a;
        degree_[a] = static_cast<std::int8_t>(degree);
        joined_[a] = round_;
        order_.push_back(s);
        return true;
    }

    const std::vector<Side>& twin_;
    std::vector<std::int32_t> parent_;
    std::vector<std::int8_t> degree_;
    std::vector<std::int16_t> joined_;  // the last round in which the piece grew
    std::vector<Side> tree_, cycle_, order_;
    std::int16_t round_ = 1;
};

// Starts with all diagonals closed, as if they were fixed, and opens one after the other. Edges
// that come with an open diagonal all cross it, so the new triangles stand in a row along it.
class Opener {
public:
    Opener(std::vector<Vec2> points, std::vector<PolygonTriangle>& triangles,
           std::vector<Side> twin)
        : points_(std::move(points)),
          triangles_(triangles),
          twin_(std::move(twin)),
          side_of_(JoiningOrder(twin_).run()),
          diagonal_(twin_.size(), kNone)
    {
        for (std::int32_t d = 0; d < static_cast<std::int32_t>(side_of_.size()); ++d)
            diagonal_[side_of_[d]] = diagonal_[twin_[side_of_[d]]] = d;
    }

    void run()
    {
        for (std::size_t d = 0; d < side_of_.size(); ++d) {
            if (d % 1024 == 0) current_progress().check();
            open(side_of_[d]);
        }
    }

private:
    // An edge of the part of a cavity above or below the diagonal; triangles beyond it stay, so
    // far. From `near` to `far` leads along the diagonal.
    struct Rim {
        std::int32_t near, far;
        Side beyond;  // kNone at the border of the region
    };

    // The rim from the last new triangle to the end of the diagonal, next edge last.
    using Chain = std::vector<Rim>;

    std::int32_t from(Side s) const { return triangles_[s / 3][s % 3]; }
    const Vec2& at(std::int32_t v) const { return points_[v]; }

    bool holds(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const
    {
        return in_circle(at(a), at(b), at(c), at(d)) > 0;
    }

    bool turns_left(std::int32_t a, std::int32_t b, std::int32_t c) const
    {
        return orient2d(at(a), at(b), at(c)) > 0;
    }

    //       w              diagonal from a to b, inside above and below; the cavity is filled from
    //   /       \          a on. Its rim above is kept as edges a w, w b and whatever comes in
    //  a ------- b         their place, that below alike.
    //   \       /
    //       x
    void open(Side e)
    {
        const Side f = twin_[e];
        diagonal_[e] = diagonal_[f] = kNone;
        const std::int32_t a = from(e), b = from(f), w = from(previous(e)), x = from(previous(f));
        if (!holds(a, b, w, x)) return;
        free_ = {e / 3, f / 3};
        above_ = {{w, b, twin_[next(e)]}, {a, w, twin_[previous(e)]}};
        below_ = {{x, b, twin_[previous(f)]}, {a, x, twin_[next(f)]}};
        begin_row(a);
        while (extend_row()) {
        }
        end_row();
    }

    // The triangle beyond the next edge of a chain goes if its third corner lies in the circle
    // through a, b, c, two of which are the ends of that edge.
    bool grow(Chain& chain, std::int32_t a, std::int32_t b, std::int32_t c)
    {
        const auto [near, far, side] = chain.back();
        if (!is_open(side)) return false;
        const std::int32_t apex = from(previous(side));
        if (!holds(a, b, c, apex)) return false;
        const bool above = &chain == &above_;
        chain.back() = {apex, far, twin_[above ? next(side) : previous(side)]};
        chain.push_back({near, apex, twin_[above ? previous(side) : next(side)]});
        free_.push_back(side / 3);
        return true;
    }

    bool is_open(Side beyond) const { return beyond != kNone && diagonal_[beyond] == kNone; }

    // Inversion at a makes the neighbours of a above and below two convex chains: their common
    // tangent is the first triangle.
    void begin_row(std::int32_t a)
    {
        while (grow(above_, a, below_.back().far, above_.back().far) ||
               grow(below_, a, below_.back().far, above_.back().far)) {
        }
        upper_ = above_.back().far;
        lower_ = below_.back().far;
        const Side s = new_triangle(a, lower_, upper_);
        join(s, pop(below_));
        join(s + 2, pop(above_));
        base_ = s + 1;
    }

    // The next triangle on the base from lower to upper has the next point above or below as apex.
    // False if that is the end of the diagonal.
    bool extend_row()
    {
        const bool above = turns_left(upper_, lower_, above_.back().far);
        const bool below = turns_left(upper_, lower_, below_.back().far);
        while (above && grow(above_, upper_, lower_, above_.back().far)) {
        }
        while (below && grow(below_, upper_, lower_, below_.back().far)) {
        }
        if (above_.size() == 1 && below_.size() == 1) return false;
        const std::int32_t p = above_.back().far, q = below_.back().far;
        const bool take_above = below_.size() == 1 || (above_.size() > 1 && above &&
                                                       !(below && holds(upper_, lower_, p, q)));
        const Side s = new_triangle(upper_, lower_, take_above ? p : q);
        join(s, base_);
        if (take_above) {
            join(s + 2, pop(above_));
            upper_ = p;
            base_ = s + 1;
        } else {
            join(s + 1, pop(below_));
            lower_ = q;
            base_ = s + 2;
        }
        return true;
    }

    void end_row()
    {
        const Side s = new_triangle(upper_, lower_, above_.back().far);
        join(s, base_);
        join(s + 1, pop(below_));
        join(s + 2, pop(above_));
    }

    // There are always enough: n triangles that are gone leave n + 2 points on the rim.
    Side new_triangle(std::int32_t a, std::int32_t b, std::int32_t c)
    {
        const std::int32_t t = free_.back();
        free_.pop_back();
        triangles_[t] = {a, b, c};
        diagonal_[3 * t] = diagonal_[3 * t + 1] = diagonal_[3 * t + 2] = kNone;
        return 3 * t;
    }

    static Side pop(Chain& chain)
    {
        const Side beyond = chain.back().beyond;
        chain.pop_back();
        return beyond;
    }

    void join(Side s, Side beyond)
    {
        twin_[s] = beyond;
        if (beyond == kNone) return;
        twin_[beyond] = s;
        diagonal_[s] = diagonal_[beyond];
        if (diagonal_[s] != kNone) side_of_[diagonal_[s]] = s;
    }

    std::vector<Vec2> points_;
    std::vector<PolygonTriangle>& triangles_;
    std::vector<Side> twin_;
    std::vector<Side> side_of_;           // of each diagonal, in the order of opening
    std::vector<std::int32_t> diagonal_;  // for each side of a closed diagonal
    Chain above_, below_;
    std::vector<std::int32_t> free_;  // triangles that are gone
    std::int32_t upper_ = 0, lower_ = 0;
    Side base_ = kNone;
};

// The largest coordinate comes to between 1 and 2, exactly: signs of fourth powers of any input
// stay in the range of doubles.
std::vector<Vec2> scaled(std::span<const Vec2> points)
{
    double largest = 0.0;
    for (const Vec2& p : points) largest = std::max({largest, std::fabs(p[0]), std::fabs(p[1])});
    const int shift = largest > 0.0 ? -std::ilogb(largest) : 0;
    std::vector<Vec2> out;
    out.reserve(points.size());
    for (const Vec2& p : points)
        out.push_back({{std::scalbn(p[0], shift), std::scalbn(p[1], shift)}});
    return out;
}

}  // namespace

void make_delaunay(std::span<const Vec2> points, std::vector<PolygonTriangle>& triangles,
                   std::span<const std::array<std::int32_t, 2>> fixed)
{
    require(triangles.size() < (std::size_t{1} << 29), "make_delaunay: more than 2^29 triangles");
    Opener(scaled(points), triangles, SideJoiner(points.size(), triangles).twins(fixed)).run();
}

}  // namespace genus
