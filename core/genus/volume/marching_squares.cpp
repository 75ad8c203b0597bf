#include "genus/volume/marching_squares.h"

#include <cmath>
#include <limits>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/volume/linear_root.h"

namespace genus {

namespace {

constexpr std::int32_t kNone = -1;

template <typename Value>
class Squares {
public:
    Squares(std::span<const Value> values, const std::array<std::int32_t, 2>& size,
            const SquareFrame& frame, const MarchingSquaresOptions& options)
        : values_(values), size_(size), frame_(frame), level_(options.level)
    {
        const bool first = options.order == SampleOrder::FirstFastest;
        step_ = {first ? 1 : std::ptrdiff_t{size[1]}, first ? std::ptrdiff_t{size[0]} : 1};
        begin_ = options.close_border ? -1 : 0;
        end_ = {size[0] + (options.close_border ? 1 : 0), size[1] + (options.close_border ? 1 : 0)};
    }

    std::vector<Contour> run()
    {
        // Vertices on the edges along x of the row below and above a row of squares, and on the
        // edge along y at its left.
        const auto n = static_cast<std::size_t>(end_[0] - begin_);
        std::vector<std::int32_t> below(n, kNone), above(n, kNone);
        cross_row(begin_, below);
        for (std::int32_t j = begin_; j + 1 < end_[1]; ++j) {
            if (j % 64 == 0) current_progress().check();
            cross_row(j + 1, above);
            std::int32_t left = crossing(begin_, j, 1);
            for (std::int32_t i = begin_; i + 1 < end_[0]; ++i) {
                const std::int32_t right = crossing(i + 1, j, 1);
                const auto at = static_cast<std::size_t>(i - begin_);
                link(i, j, {below[at], right, above[at], left});
                left = right;
            }
            below.swap(above);
        }
        return follow();
    }

private:
    // Value less the level; infinity beyond the border.
    double relative(std::int32_t i, std::int32_t j) const
    {
        if (i < 0 || j < 0 || i >= size_[0] || j >= size_[1])
            return std::numeric_limits<double>::infinity();
        return static_cast<double>(values_[i * step_[0] + j * step_[1]]) - level_;
    }

    void cross_row(std::int32_t j, std::vector<std::int32_t>& vertices)
    {
        for (std::int32_t i = begin_; i + 1 < end_[0]; ++i)
            vertices[static_cast<std::size_t>(i - begin_)] = crossing(i, j, 0);
    }

    // The number of the vertex on the edge from (i, j) along an axis, if it is crossed.
    std::int32_t crossing(std::int32_t i, std::int32_t j, std::size_t axis)
    {
        const double a = relative(i, j), b = relative(i + (axis == 0), j + (axis == 1));
        if ((a < 0.0) == (b < 0.0)) return kNone;
        require(points_.size() < std::numeric_limits<std::int32_t>::max(),
                "marching_squares: the lines have more than 2^31 points");
        Vec2 at{{static_cast<double>(i), static_cast<double>(j)}};
        at[axis] += linear_root(a, b);
        points_.push_back({{frame_.origin[0] + at[0] * frame_.spacing[0],
                            frame_.origin[1] + at[1] * frame_.spacing[1]}});
        next_.push_back(kNone);
        has_previous_.push_back(0);
        return static_cast<std::int32_t>(points_.size()) - 1;
    }

    // Joins the crossed sides of a square: below, right, above, left. Side k runs from corner k to
    // k + 1, counterclockwise from (i, j).
    void link(std::int32_t i, std::int32_t j, const std::array<std::int32_t, 4>& side)
    {
        std::array<bool, 4> inside{};
        std::array<double, 4> value;
        for (std::size_t k = 0; k < 4; ++k) {
            value[k] = relative(i + (k == 1 || k == 2), j + (k >= 2));
            inside[k] = value[k] < 0.0;
        }
        const bool ambiguous =
            inside[0] == inside[2] && inside[1] == inside[3] && inside[0] != inside[1];
        bool joined = false;
        if (ambiguous) {
            const std::size_t first = inside[0] ? 0 : 1;
            const auto v = [&](std::size_t n) { return value[(first + n) % 4]; };
            joined = orient2d({{v(0), v(1)}}, {{v(3), v(2)}}, {{0.0, 0.0}}) > 0;
        }
        for (std::size_t k = 0; k < 4; ++k) {
            // A line comes in where, going round, the inside ends, and keeps the inside on its
            // left: it goes out where that stretch of the inside began, or, if the inside is
            // joined through the middle, where the next one begins.
            if (!inside[k] || inside[(k + 1) % 4]) continue;
            std::size_t out = (k + 3) % 4;
            if (joined) {
                out = (k + 1) % 4;
            } else {
                while (inside[out]) out = (out + 3) % 4;
            }
            next_[side[k]] = side[out];
            has_previous_[side[out]] = 1;
        }
    }

    std::vector<Contour> follow()
    {
        std::vector<Contour> contours;
        std::vector<char> done(points_.size(), 0);
        const auto walk = [&](std::int32_t from) {
            Contour line;
            std::int32_t at = from;
            for (; at != kNone && done[at] == 0; at = next_[at]) {
                done[at] = 1;
                line.points.push_back(points_[at]);
            }
            line.closed = at != kNone;
            contours.push_back(std::move(line));
        };
        for (std::size_t v = 0; v < points_.size(); ++v)
            if (has_previous_[v] == 0) walk(static_cast<std::int32_t>(v));
        for (std::size_t v = 0; v < points_.size(); ++v)
            if (done[v] == 0) walk(static_cast<std::int32_t>(v));
        return contours;
    }

    std::span<const Value> values_;
    std::array<std::int32_t, 2> size_;
    SquareFrame frame_;
    double level_;
    std::array<std::ptrdiff_t, 2> step_{};
    std::int32_t begin_ = 0;             // of samples, along both axes
    std::array<std::int32_t, 2> end_{};  // with the layer beyond the border, if closed
    std::vector<Vec2> points_;
    std::vector<std::int32_t> next_;
    std::vector<char> has_previous_;
};

template <typename Value>
std::vector<Contour> march(std::span<const Value> values, const std::array<std::int32_t, 2>& size,
                           const SquareFrame& frame, const MarchingSquaresOptions& options)
{
    for (int axis = 0; axis < 2; ++axis) {
        require(size[axis] >= 2, "marching_squares: samples along an axis", size[axis],
                "2 or more");
        require(frame.spacing[axis] > 0.0 && std::isfinite(frame.spacing[axis]),
                "marching_squares: spacing", frame.spacing[axis], "positive");
    }
    require(static_cast<double>(values.size()) == 1.0 * size[0] * size[1],
            "marching_squares: number of values", static_cast<double>(values.size()),
            "the product of the sizes");
    require(std::isfinite(options.level), "marching_squares: level", options.level, "finite");
    return Squares(values, size, frame, options).run();
}

}  // namespace

std::vector<Contour> marching_squares(std::span<const float> values,
                                      const std::array<std::int32_t, 2>& size,
                                      const SquareFrame& frame,
                                      const MarchingSquaresOptions& options)
{
    return march(values, size, frame, options);
}

std::vector<Contour> marching_squares(std::span<const double> values,
                                      const std::array<std::int32_t, 2>& size,
                                      const SquareFrame& frame,
                                      const MarchingSquaresOptions& options)
{
    return march(values, size, frame, options);
}

}  // namespace genus
