#pragma once

#include <array>
#include <cstddef>

// The inner loop of Lattice::apply, internal to core. The same bits whatever the vector width.
namespace genus::bulk {

inline constexpr int kMaxFfdDegree = 64;

struct FfdData {
    std::array<int, 3> degree;
    const double* choose[3];  // binomials of each degree
    const double* moves;      // three a control point, the last index running fastest
    double origin[3];
    double inverse[3][3];  // rows take x - origin to (s, t, u)
    double slack[3];       // what is outside by no more is on the border
};

/// Deforms `count` points, three doubles each; `out` may be `in`.
void deform(const FfdData& f, const double* in, std::size_t count, double* out);

}  // namespace genus::bulk
