#include "genus/patch/cubic_spline.h"

#include "genus/base/error.h"

namespace genus {

CubicSpline::CubicSpline(std::vector<Vec3> a_frame_points, CubicEnds ends)
    : points_(std::move(a_frame_points)), ends_(ends), all_(points_)
{
    const std::size_t least = ends == CubicEnds::Natural ? 2 : ends == CubicEnds::Free ? 4 : 3;
    require(points_.size() >= least, "CubicSpline: number of A-frame points",
            static_cast<double>(points_.size()), "at least 2 (natural), 4 (free) or 3 (closed)");
    for (const Vec3& p : points_) require(is_finite(p), "CubicSpline: a point is not finite");
    const std::size_t n = points_.size();
    if (ends == CubicEnds::Natural) {
        // Points beyond the ends that put the joint on the end and take the curvature away.
        all_.insert(all_.begin(), 2.0 * points_[0] - points_[1]);
        all_.push_back(2.0 * points_[n - 1] - points_[n - 2]);
    } else if (ends == CubicEnds::Closed) {
        all_.insert(all_.begin(), points_[n - 1]);
        all_.push_back(points_[0]);
        all_.push_back(points_[1]);
    }
}

std::vector<Vec3> CubicSpline::bezier_points() const
{
    const auto joint = [&](std::size_t i) {
        return (all_[i - 1] + 4.0 * all_[i] + all_[i + 1]) / 6.0;
    };
    std::vector<Vec3> b = {joint(1)};
    for (std::size_t i = 1; i <= n_pieces(); ++i) {
        b.push_back((2.0 * all_[i] + all_[i + 1]) / 3.0);
        b.push_back((all_[i] + 2.0 * all_[i + 1]) / 3.0);
        b.push_back(joint(i + 1));
    }
    return b;
}

std::vector<BezierCurve> CubicSpline::bezier_segments() const
{
    const auto b = bezier_points();
    std::vector<BezierCurve> result;
    for (std::size_t i = 0; i < n_pieces(); ++i)
        result.emplace_back(std::vector<Vec3>(b.begin() + 3 * static_cast<std::ptrdiff_t>(i),
                                              b.begin() + 3 * static_cast<std::ptrdiff_t>(i) + 4));
    return result;
}

Vec3 CubicSpline::value(double t) const
{
    return to_bspline().value(t);
}

Vec3 CubicSpline::derivative(double t, int order) const
{
    return to_bspline().derivative(t, order);
}

void CubicSpline::evaluate(std::span<const double> t, std::span<Vec3> out) const
{
    to_bspline().evaluate(t, out);
}

FlattenedCurve CubicSpline::flatten(double tolerance) const
{
    return to_bspline().flatten(tolerance);
}

BSpline CubicSpline::to_bspline() const
{
    return BSpline(all_, KnotVector::uniform(3, static_cast<int>(all_.size())));
}

namespace {

// d_(i-1) + 4 d_i + d_(i+1) = 6 p_i along a line, by elimination; diagonally dominant.
std::vector<Vec3> solve_line(std::vector<Vec3> right)
{
    std::vector<double> pivot(right.size(), 4.0);
    for (std::size_t i = 1; i < right.size(); ++i) {
        pivot[i] -= 1.0 / pivot[i - 1];
        right[i] -= right[i - 1] / pivot[i - 1];
    }
    for (std::size_t i = right.size(); i-- > 0;) {
        if (i + 1 < right.size()) right[i] -= right[i + 1];
        right[i] = right[i] / pivot[i];
    }
    return right;
}

// The same on a ring: the first unknown is split off, [farin2002], chapter 9.
std::vector<Vec3> solve_ring(const std::vector<Vec3>& right)
{
    const std::size_t n = right.size();
    std::vector<Vec3> rest(right.begin() + 1, right.end());
    std::vector<Vec3> unit(n - 1);
    unit.front()[0] += 1.0;
    unit.back()[0] += 1.0;
    const auto d = solve_line(rest), e = solve_line(unit);
    const Vec3 first = (right[0] - d.front() - d.back()) / (4.0 - e.front()[0] - e.back()[0]);
    std::vector<Vec3> all = {first};
    for (std::size_t i = 0; i + 1 < n; ++i) all.push_back(d[i] - e[i][0] * first);
    return all;
}

}  // namespace

CubicSpline cubic_spline_through(std::span<const Vec3> points, CubicEnds ends)
{
    require(ends != CubicEnds::Free, "cubic_spline_through: free ends leave two points open");
    require(points.size() >= (ends == CubicEnds::Closed ? 3u : 2u),
            "cubic_spline_through: number of points", static_cast<double>(points.size()),
            "at least 2, closed 3");
    std::vector<Vec3> right;
    for (const Vec3& p : points) right.push_back(6.0 * p);
    if (ends == CubicEnds::Closed) return CubicSpline(solve_ring(right), ends);
    // The natural ends are A-frame points themselves.
    const Vec3 first = points.front(), last = points.back();
    if (points.size() == 2) return CubicSpline({first, last}, ends);
    right.erase(right.begin());
    right.pop_back();
    right.front() -= first;
    right.back() -= last;
    auto d = solve_line(std::move(right));
    d.insert(d.begin(), first);
    d.push_back(last);
    return CubicSpline(std::move(d), ends);
}

}  // namespace genus
