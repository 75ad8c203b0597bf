#include "genus/polygon/ear_clipping.h"

#include <algorithm>
#include <queue>
#include <utility>

#include "genus/base/predicates.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

// The ring that is left, as a doubly linked list of its corners, and beside it the list of those
// corners that are not strictly convex: only they can lie in an ear. A corner once convex stays
// so when ears beside it are cut, so the second list only shrinks.
class EarClipper {
public:
    EarClipper(std::span<const Vec2> points, std::span<const std::int32_t> loop)
        : points_(points), loop_(loop), next_(loop.size()), previous_(loop.size())
    {
        const auto n = static_cast<std::int32_t>(loop.size());
        for (std::int32_t i = 0; i < n; ++i) {
            next_[i] = i + 1 < n ? i + 1 : 0;
            previous_[i] = i > 0 ? i - 1 : n - 1;
        }
        convex_.resize(n);
        for (std::int32_t i = 0; i < n; ++i) {
            convex_[i] = is_convex(i);
            if (!convex_[i]) blockers_.push_back(i);
        }
    }

    std::optional<std::vector<PolygonTriangle>> run()
    {
        std::vector<PolygonTriangle> triangles;
        auto left = static_cast<std::int32_t>(loop_.size());
        if (left < 3) return std::nullopt;
        triangles.reserve(left - 2);
        std::int32_t corner = 0;
        std::int32_t tried = 0;
        while (left > 3) {
            if (!is_ear(corner)) {
                corner = next_[corner];
                if (++tried > left) return std::nullopt;
                continue;
            }
            triangles.push_back(triangle(corner));
            // Going on two corners further alternates the ears and avoids long fans.
            corner = cut(corner);
            tried = 0;
            --left;
            if ((left & 0xff) == 0) current_progress().check();
        }
        if (!is_convex(corner)) return std::nullopt;
        triangles.push_back(triangle(corner));
        return triangles;
    }

    // Always the best-shaped of all ears. A blocked corner waits until some ear has been cut.
    std::optional<std::vector<PolygonTriangle>> run_by_shape()
    {
        std::vector<PolygonTriangle> triangles;
        auto left = static_cast<std::int32_t>(loop_.size());
        if (left < 3) return std::nullopt;
        std::vector<std::int32_t> stamp(loop_.size(), 0), blocked;
        std::priority_queue<Candidate> queue;
        const auto offer = [&](std::int32_t corner) {
            if (convex_[corner]) queue.push({shape(corner), corner, ++stamp[corner]});
        };
        for (std::int32_t corner = 0; corner < left; ++corner) offer(corner);
        while (left > 2) {
            if (queue.empty()) return std::nullopt;
            const Candidate best = queue.top();
            queue.pop();
            if (next_[best.corner] < 0 || stamp[best.corner] != best.stamp) continue;
            if (left > 3 && !is_ear(best.corner)) {
                blocked.push_back(best.corner);
                continue;
            }
            triangles.push_back(triangle(best.corner));
            const std::int32_t before = previous_[best.corner], after = next_[best.corner];
            cut(best.corner);
            --left;
            offer(before);
            offer(after);
            for (const std::int32_t corner : blocked)
                if (next_[corner] >= 0 && corner != before && corner != after) offer(corner);
            blocked.clear();
            if ((left & 0xff) == 0) current_progress().check();
        }
        return triangles;
    }

private:
    struct Candidate {
        double shape;
        std::int32_t corner;
        std::int32_t stamp;
        bool operator<(const Candidate& o) const
        {
            return shape != o.shape ? shape < o.shape : corner > o.corner;
        }
    };

    // Height over the longest side, relative to it.
    double shape(std::int32_t corner) const
    {
        const Vec2 &a = point(previous_[corner]), &b = point(corner), &c = point(next_[corner]);
        const Vec2 ab = b - a, bc = c - b, ca = a - c;
        const double longest = std::max({dot(ab, ab), dot(bc, bc), dot(ca, ca)});
        return (ab[0] * bc[1] - ab[1] * bc[0]) / longest;
    }

    const Vec2& point(std::int32_t corner) const { return points_[loop_[corner]]; }

    PolygonTriangle triangle(std::int32_t corner) const
    {
        return {loop_[previous_[corner]], loop_[corner], loop_[next_[corner]]};
    }

    bool is_convex(std::int32_t corner) const
    {
        return orient2d(point(previous_[corner]), point(corner), point(next_[corner])) > 0;
    }

    bool is_ear(std::int32_t corner)
    {
        if (!convex_[corner]) return false;
        const Vec2 a = point(previous_[corner]), b = point(corner), c = point(next_[corner]);
        std::size_t kept = 0;
        bool blocked = false;
        for (std::size_t i = 0; i < blockers_.size(); ++i) {
            const std::int32_t other = blockers_[i];
            if (next_[other] < 0 || convex_[other]) continue;  // drop from the list
            blockers_[kept++] = other;
            if (blocked || other == previous_[corner] || other == next_[corner]) continue;
            blocked = blocks(point(other), a, b, c);
        }
        blockers_.resize(kept);
        return !blocked;
    }

    // In the closed triangle, other than at a corner: a chain that passes through the point of a
    // corner enters the ear only if one of its next points does so too.
    static bool blocks(const Vec2& p, const Vec2& a, const Vec2& b, const Vec2& c)
    {
        if (p == a || p == b || p == c) return false;
        return orient2d(a, b, p) >= 0 && orient2d(b, c, p) >= 0 && orient2d(c, a, p) >= 0;
    }

    std::int32_t cut(std::int32_t corner)
    {
        const std::int32_t before = previous_[corner], after = next_[corner];
        next_[before] = after;
        previous_[after] = before;
        next_[corner] = -1;
        convex_[before] = is_convex(before);
        convex_[after] = is_convex(after);
        return next_[after];
    }

    std::span<const Vec2> points_;
    std::span<const std::int32_t> loop_;
    std::vector<std::int32_t> next_;
    std::vector<std::int32_t> previous_;
    std::vector<std::uint8_t> convex_;
    std::vector<std::int32_t> blockers_;
};

// Makes one loop of many: each hole, from the left to the right, is spliced in by a bridge from its
// leftmost point to a point further left that it sees.
class HoleJoiner {
public:
    HoleJoiner(std::span<const Vec2> points, const std::vector<std::vector<std::int32_t>>& loops)
        : points_(points), loop_(loops[0]), holes_(loops.begin() + 1, loops.end())
    {
    }

    std::optional<std::vector<std::int32_t>> run()
    {
        for (std::vector<std::int32_t>& hole : holes_)
            std::rotate(hole.begin(),
                        std::min_element(hole.begin(), hole.end(),
                                         [&](auto a, auto b) { return left_of(a, b); }),
                        hole.end());
        std::sort(holes_.begin(), holes_.end(), [&](const auto& a, const auto& b) {
            return a[0] != b[0] ? left_of(a[0], b[0]) : a < b;
        });
        for (std::size_t h = 0; h < holes_.size(); ++h)
            if (!splice(h)) return std::nullopt;
        return std::move(loop_);
    }

private:
    bool left_of(std::int32_t a, std::int32_t b) const
    {
        const Vec2 &p = points_[a], &q = points_[b];
        return p[0] != q[0] ? p[0] < q[0] : p[1] < q[1];
    }

    int orient(std::int32_t a, std::int32_t b, std::int32_t c) const
    {
        return orient2d(points_[a], points_[b], points_[c]);
    }

    bool splice(std::size_t h)
    {
        const std::vector<std::int32_t>& hole = holes_[h];
        const std::int32_t m = hole[0];
        const bool touches = std::find(loop_.begin(), loop_.end(), m) != loop_.end();
        const std::int32_t p = touches ? m : visible_point(h);
        if (p < 0) return false;
        std::vector<std::int32_t> inserted(hole.begin() + (touches ? 1 : 0), hole.end());
        if (!touches) inserted.push_back(m);
        inserted.push_back(p);
        const std::size_t at = place_in_loop(p, touches ? hole[1] : m);
        loop_.insert(loop_.begin() + static_cast<std::ptrdiff_t>(at) + 1, inserted.begin(),
                     inserted.end());
        return true;
    }

    // The nearest that is seen, in the order of rounded distances.
    std::int32_t visible_point(std::size_t h) const
    {
        const std::int32_t m = holes_[h][0];
        std::vector<std::pair<double, std::int32_t>> candidates;
        for (const std::int32_t p : loop_)
            if (left_of(p, m)) {
                const Vec2 d = points_[p] - points_[m];
                candidates.push_back({dot(d, d), p});
            }
        std::sort(candidates.begin(), candidates.end());
        for (const auto& [distance2, p] : candidates) {
            bool seen = !blocked(m, p, loop_);
            for (std::size_t k = h; k < holes_.size() && seen; ++k)
                seen = !blocked(m, p, holes_[k]);
            if (seen) return p;
        }
        return -1;
    }

    bool blocked(std::int32_t m, std::int32_t p, const std::vector<std::int32_t>& loop) const
    {
        for (std::size_t i = 0; i < loop.size(); ++i)
            if (meets(m, p, loop[i], loop[i + 1 < loop.size() ? i + 1 : 0])) return true;
        return false;
    }

    bool within(std::int32_t x, std::int32_t a, std::int32_t b) const
    {
        return (left_of(a, x) && left_of(x, b)) || (left_of(b, x) && left_of(x, a));
    }

    // Has the edge a b a point strictly between m and p, or m or p between its ends?
    bool meets(std::int32_t m, std::int32_t p, std::int32_t a, std::int32_t b) const
    {
        const int s = orient(m, p, a), t = orient(m, p, b);
        if ((s == 0 && within(a, m, p)) || (t == 0 && within(b, m, p))) return true;
        if (a == m || a == p || b == m || b == p) return (a == m && b == p) || (a == p && b == m);
        const int u = orient(a, b, m), v = orient(a, b, p);
        if ((u == 0 && within(m, a, b)) || (v == 0 && within(p, a, b))) return true;
        return s * t < 0 && u * v < 0;
    }

    // The corner of the loop at p whose inner side holds the direction to `target`.
    std::size_t place_in_loop(std::int32_t p, std::int32_t target) const
    {
        std::size_t any = 0;
        for (std::size_t i = 0; i < loop_.size(); ++i) {
            if (loop_[i] != p) continue;
            any = i;
            const std::int32_t before = loop_[i > 0 ? i - 1 : loop_.size() - 1];
            const std::int32_t after = loop_[i + 1 < loop_.size() ? i + 1 : 0];
            const bool left_of_in = orient(before, p, target) > 0;
            const bool left_of_out = orient(p, after, target) > 0;
            const bool convex = orient(before, p, after) > 0;
            if (convex ? left_of_in && left_of_out : left_of_in || left_of_out) return i;
        }
        return any;
    }

    std::span<const Vec2> points_;
    std::vector<std::int32_t> loop_;
    std::vector<std::vector<std::int32_t>> holes_;
};

}  // namespace

std::optional<std::vector<PolygonTriangle>> clip_ears(std::span<const Vec2> points,
                                                      std::span<const std::int32_t> loop,
                                                      EarOrder order)
{
    EarClipper clipper(points, loop);
    return order == EarOrder::InTurn ? clipper.run() : clipper.run_by_shape();
}

std::optional<std::vector<PolygonTriangle>> cut_corners(
    std::span<const Vec2> points, const std::vector<std::vector<std::int32_t>>& loops)
{
    const auto loop = HoleJoiner(points, loops).run();
    if (!loop) return std::nullopt;
    return clip_ears(points, *loop, EarOrder::BestShape);
}

}  // namespace genus
