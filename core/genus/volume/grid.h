#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/vec.h"
#include "genus/implicit/implicit.h"

namespace genus {

/// Numbers of samples along x, y, z.
using GridSize = std::array<std::int32_t, 3>;

/// How an array holds the samples of a grid: which index moves to the next number in memory.
enum class SampleOrder { FirstFastest, LastFastest };

/// Where the samples of a regular grid stand: sample (i, j, k) at origin + (i, j, k) * spacing.
struct GridFrame {
    Vec3 origin{};
    Vec3 spacing{{1.0, 1.0, 1.0}};

    Vec3 point(double i, double j, double k) const
    {
        return {
            {origin[0] + i * spacing[0], origin[1] + j * spacing[1], origin[2] + k * spacing[2]}};
    }
};

/// Samples of a function on a regular grid, trilinear in between. Sample (i, j, k) stands at
/// `values[(k * size[1] + j) * size[0] + i]`.
class Grid {
public:
    /// Throws InvalidInput unless there are two samples or more along each axis, as many values as
    /// the size says, all finite, and the spacing is positive.
    Grid(const GridSize& size, std::vector<double> values, const GridFrame& frame = {});

    const GridSize& size() const { return size_; }
    const GridFrame& frame() const { return frame_; }
    std::span<const double> values() const { return values_; }
    Box3 bounds() const;

    double at(std::int32_t i, std::int32_t j, std::int32_t k) const
    {
        return values_[(static_cast<std::size_t>(k) * size_[1] + j) * size_[0] + i];
    }
    /// Trilinear interpolant; outside the grid that of the nearest point of it.
    double value(const Vec3& p) const;
    /// Central differences of the samples, one-sided at the border, interpolated like the value.
    /// Second order in the spacing.
    Vec3 gradient(const Vec3& p) const;

private:
    struct Place {
        std::array<std::int32_t, 3> cell;
        Vec3 part;  // in [0, 1]
    };
    Place place(const Vec3& p) const;
    Vec3 difference(std::int32_t i, std::int32_t j, std::int32_t k) const;

    GridSize size_;
    std::vector<double> values_;
    GridFrame frame_;
};

/// The grid of cells of edge length at most `cell_size` that fill `box`.
struct GridLayout {
    GridSize size;
    GridFrame frame;
};
/// Throws InvalidInput if `cell_size` is not positive, `box` is empty or unbounded, or there would
/// be more than 2^40 samples.
GridLayout cover(const Box3& box, double cell_size);

/// Samples `field` on the grid of `cover`. In parallel. Throws as `cover` does, and for more than
/// 2^31 samples.
Grid sample(const Implicit& field, const Box3& box, double cell_size);

}  // namespace genus
