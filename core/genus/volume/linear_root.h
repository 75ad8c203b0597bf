#pragma once

#include <cmath>

namespace genus {

/// Where between values a and b of different signs the linear interpolant is zero, as a share of
/// the way from a to b; at the finite one if the other is infinite.
inline double linear_root(double a, double b)
{
    if (!std::isfinite(a)) return std::isfinite(b) ? 1.0 : 0.5;
    if (!std::isfinite(b)) return 0.0;
    // The difference overflows only if both are huge.
    const double difference = a - b;
    return std::isfinite(difference) ? a / difference : 0.5 * a / (0.5 * a - 0.5 * b);
}

}  // namespace genus
