#include "genus/volume/grid.h"

#include <algorithm>
#include <cmath>

#include "genus/base/error.h"
#include "genus/base/parallel.h"

namespace genus {

namespace {

constexpr double kMostSamples = 0x1p40;
constexpr double kMostStoredSamples = 0x1p31;
constexpr double kLongestSide = 0x1p30;

template <typename Value>
Value blend(const std::array<Value, 8>& corner, const Vec3& part)
{
    const auto mix = [](const Value& a, const Value& b, double t) { return a * (1.0 - t) + b * t; };
    const Value y0 =
        mix(mix(corner[0], corner[1], part[0]), mix(corner[2], corner[3], part[0]), part[1]);
    const Value y1 =
        mix(mix(corner[4], corner[5], part[0]), mix(corner[6], corner[7], part[0]), part[1]);
    return mix(y0, y1, part[2]);
}

}  // namespace

Grid::Grid(const GridSize& size, std::vector<double> values, const GridFrame& frame)
    : size_(size), values_(std::move(values)), frame_(frame)
{
    double samples = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        require(size[axis] >= 2, "Grid: samples along an axis", size[axis], "2 or more");
        require(frame.spacing[axis] > 0.0 && std::isfinite(frame.spacing[axis]), "Grid: spacing",
                frame.spacing[axis], "positive");
        samples *= size[axis];
    }
    require(static_cast<double>(values_.size()) == samples, "Grid: number of values",
            static_cast<double>(values_.size()), "the product of the sizes");
    const auto finite = [](double v) { return std::isfinite(v); };
    require(std::all_of(values_.begin(), values_.end(), finite), "Grid: a value is not finite");
}

Box3 Grid::bounds() const
{
    return {frame_.origin, frame_.point(size_[0] - 1, size_[1] - 1, size_[2] - 1)};
}

Grid::Place Grid::place(const Vec3& p) const
{
    Place place;
    for (int axis = 0; axis < 3; ++axis) {
        const double last = size_[axis] - 1;
        const double x =
            std::clamp((p[axis] - frame_.origin[axis]) / frame_.spacing[axis], 0.0, last);
        place.cell[axis] = static_cast<std::int32_t>(std::min(std::floor(x), last - 1.0));
        place.part[axis] = x - place.cell[axis];
    }
    return place;
}

double Grid::value(const Vec3& p) const
{
    const auto [cell, part] = place(p);
    std::array<double, 8> corner;
    for (int c = 0; c < 8; ++c)
        corner[c] = at(cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2 & 1));
    return blend(corner, part);
}

Vec3 Grid::gradient(const Vec3& p) const
{
    const auto [cell, part] = place(p);
    std::array<Vec3, 8> corner;
    for (int c = 0; c < 8; ++c)
        corner[c] = difference(cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2 & 1));
    return blend(corner, part);
}

Vec3 Grid::difference(std::int32_t i, std::int32_t j, std::int32_t k) const
{
    Vec3 d;
    for (int axis = 0; axis < 3; ++axis) {
        std::array<std::int32_t, 3> low{i, j, k}, high{i, j, k};
        low[axis] = std::max(low[axis] - 1, 0);
        high[axis] = std::min(high[axis] + 1, size_[axis] - 1);
        d[axis] = (at(high[0], high[1], high[2]) - at(low[0], low[1], low[2])) /
                  ((high[axis] - low[axis]) * frame_.spacing[axis]);
    }
    return d;
}

GridLayout cover(const Box3& box, double cell_size)
{
    require(cell_size > 0.0 && std::isfinite(cell_size), "cell_size", cell_size, "positive");
    require(!box.empty() && box.bounded(), "grid: the box is empty or unbounded");
    GridLayout grid{{}, {box.min, {}}};
    double samples = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double cells = std::max(1.0, std::ceil(box.size()[axis] / cell_size));
        samples *= cells + 1.0;
        require(cells < kLongestSide && samples <= kMostSamples, "cell_size", cell_size,
                "larger: the grid would have too many samples");
        grid.size[axis] = static_cast<std::int32_t>(cells) + 1;
        grid.frame.spacing[axis] = box.size()[axis] > 0.0 ? box.size()[axis] / cells : cell_size;
    }
    return grid;
}

Grid sample(const Implicit& field, const Box3& box, double cell_size)
{
    const auto [size, frame] = cover(box, cell_size);
    const double samples = 1.0 * size[0] * size[1] * size[2];
    require(samples <= kMostStoredSamples, "sample: cell_size", cell_size,
            "larger: the grid would have more than 2^31 samples");
    std::vector<double> values(static_cast<std::size_t>(samples));
    const auto n_rows = static_cast<std::size_t>(size[1]) * size[2];
    parallel_for(n_rows, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const double j = static_cast<double>(row % size[1]);
            const double k = static_cast<double>(row / size[1]);
            for (std::int32_t i = 0; i < size[0]; ++i)
                values[row * size[0] + i] = field.value(frame.point(i, j, k));
        }
    });
    return Grid(size, std::move(values), frame);
}

}  // namespace genus
