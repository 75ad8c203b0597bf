#include "genus/polygon/delaunay.h"

#include <algorithm>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

// Side 3 t + i of triangle t runs from its corner i to the next.
class Flipper {
public:
    Flipper(std::span<const Vec2> points, std::vector<PolygonTriangle>& triangles)
        : points_(points), triangles_(triangles), twin_(3 * triangles.size(), -1)
    {
        join_sides();
    }

    void fix(std::int32_t a, std::int32_t b)
    {
        const std::int32_t lo = std::min(a, b), hi = std::max(a, b);
        for (std::int32_t i = bucket_[lo]; i < bucket_[lo + 1]; ++i) {
            const std::int32_t side = by_smaller_[i];
            if (std::max(from(side), to(side)) == hi) twin_[side] = -1;
        }
    }

    void run()
    {
        std::vector<std::int32_t> stack;
        for (std::size_t s = twin_.size(); s-- > 0;)
            if (twin_[s] > static_cast<std::int32_t>(s))
                stack.push_back(static_cast<std::int32_t>(s));
        for (std::size_t n = 0; !stack.empty(); ++n) {
            if (n % 4096 == 0) current_progress().check();
            const std::int32_t side = stack.back();
            stack.pop_back();
            if (twin_[side] < 0 || !must_flip(side)) continue;
            for (const std::int32_t around : flip(side))
                if (twin_[around] >= 0) stack.push_back(around);
        }
    }

private:
    static std::int32_t next(std::int32_t s) { return s % 3 == 2 ? s - 2 : s + 1; }
    static std::int32_t previous(std::int32_t s) { return s % 3 == 0 ? s + 2 : s - 1; }
    std::int32_t from(std::int32_t s) const { return triangles_[s / 3][s % 3]; }
    std::int32_t to(std::int32_t s) const { return from(next(s)); }

    // Sides are joined in buckets by the smaller end.
    void join_sides()
    {
        bucket_.assign(points_.size() + 1, 0);
        const auto n = static_cast<std::int32_t>(twin_.size());
        for (std::int32_t s = 0; s < n; ++s) ++bucket_[std::min(from(s), to(s)) + 1];
        for (std::size_t v = 0; v < points_.size(); ++v) bucket_[v + 1] += bucket_[v];
        by_smaller_.resize(twin_.size());
        std::vector<std::int32_t> cursor(bucket_.begin(), bucket_.end() - 1);
        for (std::int32_t s = 0; s < n; ++s) by_smaller_[cursor[std::min(from(s), to(s))]++] = s;
        for (std::size_t v = 0; v < points_.size(); ++v) {
            const auto begin = by_smaller_.begin() + bucket_[v];
            const auto end = by_smaller_.begin() + bucket_[v + 1];
            std::sort(begin, end, [&](std::int32_t a, std::int32_t b) {
                const std::int32_t p = std::max(from(a), to(a)), q = std::max(from(b), to(b));
                return p != q ? p < q : a < b;
            });
            for (auto i = begin; i != end && i + 1 != end; ++i)
                if (from(i[0]) == to(i[1]) && to(i[0]) == from(i[1])) {
                    twin_[i[0]] = i[1];
                    twin_[i[1]] = i[0];
                }
        }
    }

    bool must_flip(std::int32_t e) const
    {
        const std::int32_t f = twin_[e];
        return in_circle(points_[from(e)], points_[to(e)], points_[from(previous(e))],
                         points_[from(previous(f))]) > 0;
    }

    // Side e from u to v becomes a side from x to w; the other four keep their triangles or
    // change them, and are returned.
    //
    //     w            w
    //   /   \        / | \ .
    //  u --- v  ->  u  |  v
    //   \   /        \ | /
    //     x            x
    std::array<std::int32_t, 4> flip(std::int32_t e)
    {
        const std::int32_t f = twin_[e];
        const std::int32_t u = from(e), v = to(e);
        const std::int32_t w = from(previous(e)), x = from(previous(f));
        const std::int32_t beyond_vw = twin_[next(e)], beyond_wu = twin_[previous(e)];
        const std::int32_t beyond_ux = twin_[next(f)], beyond_xv = twin_[previous(f)];
        const std::int32_t s = e / 3 * 3, t = f / 3 * 3;
        triangles_[s / 3] = {w, u, x};
        triangles_[t / 3] = {x, v, w};
        join(s, beyond_wu);
        join(s + 1, beyond_ux);
        join(t, beyond_xv);
        join(t + 1, beyond_vw);
        join(s + 2, t + 2);
        return {s, s + 1, t, t + 1};
    }

    void join(std::int32_t a, std::int32_t b)
    {
        twin_[a] = b;
        if (b >= 0) twin_[b] = a;
    }

    std::span<const Vec2> points_;
    std::vector<PolygonTriangle>& triangles_;
    std::vector<std::int32_t> twin_;  // -1 for a side that stays
    std::vector<std::int32_t> bucket_, by_smaller_;
};

}  // namespace

void make_delaunay(std::span<const Vec2> points, std::vector<PolygonTriangle>& triangles,
                   std::span<const std::array<std::int32_t, 2>> fixed)
{
    require(triangles.size() < (std::size_t{1} << 29), "make_delaunay: more than 2^29 triangles");
    Flipper flipper(points, triangles);
    for (const auto& [a, b] : fixed) flipper.fix(a, b);
    flipper.run();
}

}  // namespace genus
