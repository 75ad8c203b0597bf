#include "genus/deform/ffd.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/deform/lattice_net.h"

namespace genus {

using namespace lattice;

std::optional<Vec3> Lattice::newton(const Vec3& y, Vec3 s, int& steps) const
{
    const double goal = std::max(rounding(), 4.0 * kEpsilon * norm(y));
    // Inside the lattice only, with steps cut where they would leave it or make things worse.
    const auto clamped = [](Vec3 p) {
        for (std::size_t k = 0; k < 3; ++k) p[k] = std::clamp(p[k], 0.0, 1.0);
        return p;
    };
    const auto image = [&](const Vec3& p) {
        Vec3 sum = global(p);
        std::array<AxisBasis, 3> b;
        for (int a = 0; a < 3; ++a) b[at(a)] = axis_basis(a, p[at(a)], false);
        for (std::size_t i = 0; i < b[0].value.size(); ++i)
            for (std::size_t j = 0; j < b[1].value.size(); ++j) {
                const Vec3* row = &moves_[index(b[0].first + static_cast<int>(i),
                                                b[1].first + static_cast<int>(j), b[2].first)];
                Vec3 line;
                for (std::size_t k = 0; k < b[2].value.size(); ++k) line += b[2].value[k] * row[k];
                sum += (b[0].value[i] * b[1].value[j]) * line;
            }
        return sum;
    };
    s = clamped(s);
    Vec3 e = image(s) - y;
    for (int step = 0; step < 50; ++step) {
        const Columns3 d = local_derivative(s);
        if (determinant(d) == 0.0) return std::nullopt;
        const Vec3 move = times(inverted(d), e);
        if (!is_finite(move)) return std::nullopt;
        ++steps;
        Vec3 next, there;
        bool better = false;
        for (double share = 1.0; share > 1e-3 && !better; share *= 0.5) {
            next = clamped(s - share * move);
            there = image(next) - y;
            better = norm(there) < norm(e);
        }
        if (!better) break;
        s = next;
        e = there;
        if (norm(e) <= 0.25 * goal) break;
    }
    if (norm(e) <= 4.0 * goal) return s;
    return std::nullopt;
}

// Krawczyk: x - Y (F(x) - y) + (I - Y F'(X)) (X - x) inside X proves one solution in X. Returns
// the radius of X in (s, t, u), or infinity.
double Lattice::certify(const Vec3& y, const Vec3& s) const
{
    const Columns3 inverse_slope = inverted(local_derivative(s));
    const Vec3 x = global(s);
    const Vec3 e = apply(x) - y;
    const double slack = 2.0 * rounding() + 4.0 * kEpsilon * norm(y);
    Vec3 step;  // bound of |Y (F(x) - y)| by coordinates
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c)
            step[r] += std::fabs(inverse_slope[c][r]) * (std::fabs(e[c]) + slack);
    const double least = std::max({step[0], step[1], step[2]}) * 2.0 + 1e-12;
    const std::vector<Piece> all = pieces();
    for (double radius = least; radius <= 1e3 * least && radius < 0.25; radius *= 10.0) {
        const Box3 box = Box3{s, s}.inflated(radius);
        const auto d = derivative_bounds(all, box);
        bool inside = true;
        for (std::size_t r = 0; r < 3 && inside; ++r) {
            Interval reach;
            for (std::size_t c = 0; c < 3; ++c) {
                Interval entry(r == c ? 1.0 : 0.0);
                for (std::size_t k = 0; k < 3; ++k)
                    entry = entry - Interval(inverse_slope[k][r]) * d[c][k];
                reach = reach + Interval(entry.magnitude()) * Interval(radius);
            }
            inside = (reach + Interval(step[r])).hi < radius;
        }
        if (inside) return radius;
    }
    return std::numeric_limits<double>::infinity();
}

std::optional<Vec3> Lattice::solve(const Vec3& y, const Vec3& x) const
{
    int steps = 0;
    const auto s = newton(y, local(x), steps);
    return s ? std::optional(global(*s)) : std::nullopt;
}

InversePoint Lattice::inverse(const Vec3& y) const
{
    require(is_finite(y), "Lattice::inverse: the point is not finite");
    InversePoint result;
    const auto accept = [&](const Vec3& s) {
        result.point = global(s);
        result.found = true;
        const double radius = certify(y, s);
        result.certified = std::isfinite(radius);
        double size = 0.0;
        for (const Vec3& a : axes_) size += norm(a);
        result.bound = result.certified ? radius * size : std::numeric_limits<double>::infinity();
        return result;
    };
    if (const auto s = newton(y, local(y), result.steps)) return accept(*s);
    // Boxes of the lattice whose image may hold y, the largest first.
    struct Candidate {
        Net3<Vec3> net;
        Box3 box;
    };
    std::vector<Candidate> queue;
    for (Piece& piece : pieces()) queue.push_back({std::move(piece.net), piece.box});
    constexpr std::size_t kMaxCandidates = 4000;
    const double slack = rounding() + 4.0 * kEpsilon * norm(y);
    for (std::size_t next = 0; next < queue.size() && next < kMaxCandidates; ++next) {
        current_progress().check();
        const Candidate c = std::move(queue[next]);
        Box3 image;
        for (const Vec3& p : c.net.c) image.add(p);
        if (!image.inflated(slack).contains(y)) continue;
        if (const auto s = newton(y, c.box.center(), result.steps)) return accept(*s);
        const Vec3 size = c.box.size();
        const std::size_t axis = longest_axis(size);
        if (size[axis] < 0x1p-20) continue;
        auto nets = halves(c.net, axis);
        const auto boxes = halves(c.box, axis);
        for (const std::size_t k : {0u, 1u}) queue.push_back({std::move(nets[k]), boxes[k]});
    }
    // Nothing in the lattice goes there; outside, every point is its own image.
    result.found = !in_unit_cube(local(y));
    result.certified = result.found && queue.size() < kMaxCandidates;
    result.point = y;
    return result;
}

}  // namespace genus
