#include "genus/boolean/star_shaped.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "genus/base/parallel.h"
#include "genus/boolean/ray.h"

namespace genus::exact {

namespace {

constexpr std::size_t kGrain = 16384;

Vec3 middle_of(const Soup& soup, std::int32_t begin, std::int32_t end)
{
    Vec3 sum{};
    for (std::int32_t f = begin; f < end; ++f)
        for (const std::int32_t v : soup.faces[f]) sum += soup.points[v];
    for (double& c : sum.c) c = std::nearbyint(c / (3.0 * (end - begin)));
    return sum;
}

// Is p between the lowest and the highest corner along an axis?
bool spans(int axis, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p)
{
    return std::min({a[axis], b[axis], c[axis]}) <= p[axis] &&
           p[axis] <= std::max({a[axis], b[axis], c[axis]});
}

bool is_joined(const Soup& soup, std::int32_t f)
{
    const std::int32_t* twin = soup.twin.data() + 3 * static_cast<std::size_t>(f);
    return twin[0] >= 0 && twin[1] >= 0 && twin[2] >= 0;
}

}  // namespace

bool is_star_shaped(const Soup& soup, std::int32_t begin, std::int32_t end)
{
    if (begin == end) return false;
    const Vec3 middle = middle_of(soup, begin, end);
    const auto corner = [&](std::int32_t f, int i) -> const Vec3& {
        return soup.points[soup.faces[f][i]];
    };
    const auto side = [&](std::int32_t f) {
        return side_of_plane(corner(f, 0), corner(f, 1), corner(f, 2), middle);
    };
    const int first = side(begin);
    if (first == 0) return false;
    const Ray ray{0, middle, {{0.0, 1.0, 0.0}}, {{0.0, 0.0, 1.0}}};
    std::atomic<bool> fails{false};
    std::atomic<std::int64_t> n_hits{0};
    parallel_for(
        static_cast<std::size_t>(end - begin), kGrain, [&](std::size_t from, std::size_t to) {
            std::int64_t n = 0;
            for (std::size_t i = from; i < to && !fails.load(std::memory_order_relaxed); ++i) {
                const auto f = begin + static_cast<std::int32_t>(i);
                if (side(f) != first || !is_joined(soup, f)) fails = true;
                const Vec3 &a = corner(f, 0), &b = corner(f, 1), &c = corner(f, 2);
                if (spans(1, a, b, c, middle) && spans(2, a, b, c, middle))
                    n += hit(ray, a, b, c) != 0;
            }
            n_hits += n;
        });
    return !fails && n_hits == 1;
}

}  // namespace genus::exact
