#pragma once

#include "genus/implicit/implicit.h"
#include "genus/volume/grid.h"

namespace genus {

/// The trilinear interpolant of a grid as a function; outside the grid that of its nearest point.
/// The grid must outlive it. A bound costs a look at every sample of the box; the gradient, which
/// is that of central differences, has none.
class GridField final : public Implicit {
public:
    explicit GridField(const Grid& grid) : grid_(grid) {}

    double value(const Vec3& p) const override { return grid_.value(p); }
    Vec3 gradient(const Vec3& p) const override { return grid_.gradient(p); }
    Interval bound(const Box3& box) const override;
    IntervalVec3 gradient_bound(const Box3&) const override
    {
        return {Interval::everything(), Interval::everything(), Interval::everything()};
    }

private:
    const Grid& grid_;
};

}  // namespace genus
