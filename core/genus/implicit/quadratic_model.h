#pragma once

#include <array>
#include <vector>

#include "genus/base/interval.h"
#include "genus/base/vec.h"

namespace genus {

/// A smooth function to second order over a box round `at`: F(at + d) is value + gradient.d +
/// d.Hd / 2 within `rest`, and its gradient is gradient + Hd within `slope_rest`, and in `slope`.
/// `rest` falls with the third power of the size of the box where second derivatives are
/// continuous, with the second where these jump.
struct QuadraticModel {
    Vec3 at;
    double value = 0.0;
    Vec3 gradient;
    std::array<double, 6> hessian{};  // xx, yy, zz, xy, xz, yz
    double rest = 0.0;
    Vec3 slope_rest;
    IntervalVec3 slope;
};

}  // namespace genus
