#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "genus/base/vec.h"
#include "genus/volume/crossed_cells.h"
#include "genus/volume/field_samples.h"
#include "genus/volume/grid.h"
#include "genus/volume/linear_root.h"
#include "genus/volume/padded_samples.h"

namespace genus {

using GridIndex = std::array<std::int32_t, 3>;

/// A root of f in [0, 1], where f(0) and f(1), given, have different signs (zero counts with the
/// positive ones). The returned t is one of two doubles within 2^-52 between which the sign
/// changes; the one with the smaller |f|. At most some 120 calls, usually about six, three for a
/// linear f.
///
/// Implements [brent1973], chapter 4.
double find_root(const std::function<double(double)>& f, double f0, double f1);

/// Points of the surface on samples, by linear interpolation along grid edges; the true sample
/// itself where the other end lies in the padding. Samples in the order of LastFastest have their
/// first axis as z of the result.
template <typename Value>
class LinearCrossings {
public:
    LinearCrossings(const PaddedSamples<Value>& samples, const GridFrame& frame, SampleOrder order)
        : samples_(samples), frame_(frame), mirrored_(order == SampleOrder::LastFastest)
    {
        if (mirrored_) {
            std::swap(frame_.origin[0], frame_.origin[2]);
            std::swap(frame_.spacing[0], frame_.spacing[2]);
        }
    }

    bool mirrored() const { return mirrored_; }

    Vec3 operator()(int axis, std::int32_t i, std::int32_t j, std::int32_t k) const
    {
        GridIndex end{i, j, k};
        ++end[axis];
        const double t =
            linear_root(samples_.relative(i, j, k), samples_.relative(end[0], end[1], end[2]));
        GridIndex at{i - samples_.pad(), j - samples_.pad(), k - samples_.pad()};
        Vec3 p = frame_.point(at[0], at[1], at[2]);
        p[axis] = frame_.origin[axis] + (at[axis] + t) * frame_.spacing[axis];
        return in_order(p);
    }
    Vec3 inner(const CrossedCell& cell, const Vec3& unit) const
    {
        const double pad = samples_.pad();
        return in_order(
            frame_.point(cell.i - pad + unit[0], cell.j - pad + unit[1], cell.k - pad + unit[2]));
    }

private:
    Vec3 in_order(const Vec3& p) const { return mirrored_ ? Vec3{{p[2], p[1], p[0]}} : p; }

    const PaddedSamples<Value>& samples_;
    GridFrame frame_;
    bool mirrored_;
};

/// The same where the field itself crosses the level.
class ExactCrossings {
public:
    explicit ExactCrossings(const FieldSamples& samples) : samples_(samples) {}

    static constexpr bool mirrored() { return false; }
    Vec3 operator()(int axis, std::int32_t i, std::int32_t j, std::int32_t k) const;
    Vec3 inner(const CrossedCell& cell, const Vec3& unit) const
    {
        const double pad = samples_.pad();
        return samples_.frame().point(cell.i - pad + unit[0], cell.j - pad + unit[1],
                                      cell.k - pad + unit[2]);
    }

private:
    const FieldSamples& samples_;
};

}  // namespace genus
