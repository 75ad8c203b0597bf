#include "genus/polygon/ear_clipping.h"

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

private:
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

}  // namespace

std::optional<std::vector<PolygonTriangle>> clip_ears(std::span<const Vec2> points,
                                                      std::span<const std::int32_t> loop)
{
    return EarClipper(points, loop).run();
}

}  // namespace genus
