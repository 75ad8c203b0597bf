#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/error.h"
#include "genus/base/transform.h"
#include "genus/base/vec.h"

// What curves and patches of all kinds do with their control points and weights; internal to core.
namespace genus::control {

/// Throws InvalidInput, in the name of the class, unless points are finite, and weights absent or
/// as many and positive.
inline void check(const char* name, std::span<const Vec3> points, std::span<const double> weights)
{
    const std::string of = std::string(name) + ": ";
    require(weights.empty() || weights.size() == points.size(), (of + "number of weights").c_str(),
            static_cast<double>(weights.size()), "0 or that of the points");
    for (const Vec3& p : points)
        if (!is_finite(p)) throw InvalidInput(of + "a coordinate is not finite");
    for (const double w : weights)
        require(w > 0.0 && std::isfinite(w), (of + "weight").c_str(), w, "positive and finite");
}

/// (x w, y w, z w, w), with w = 1 where there are no weights.
inline std::vector<Vec4> homogeneous(std::span<const Vec3> points, std::span<const double> weights)
{
    std::vector<Vec4> h;
    h.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double w = weights.empty() ? 1.0 : weights[i];
        h.push_back({{points[i][0] * w, points[i][1] * w, points[i][2] * w, w}});
    }
    return h;
}

struct Weighted {
    std::vector<Vec3> points;
    std::vector<double> weights;
};

/// The way back. Throws InvalidInput, in the name of the class, if a weight is not positive.
inline Weighted projected(const char* name, std::span<const Vec4> h)
{
    Weighted result;
    for (const Vec4& p : h) {
        require(p[3] > 0.0, (std::string(name) + ": weight").c_str(), p[3], "positive and finite");
        result.points.push_back({{p[0] / p[3], p[1] / p[3], p[2] / p[3]}});
        result.weights.push_back(p[3]);
    }
    return result;
}

inline Box3 bounds(std::span<const Vec3> points)
{
    Box3 box;
    for (const Vec3& p : points) box.add(p);
    return box;
}

/// The points at a size near 1, by a power of two, if they are so large or so small that products
/// of two lengths overflow or vanish; else nothing. Normals are those of the points themselves.
inline std::optional<std::vector<Vec3>> of_usual_size(std::span<const Vec3> points)
{
    constexpr double kLeast = 1e-60, kMost = 1e60;
    double size = 0.0;
    for (const Vec3& p : points)
        for (std::size_t k = 0; k < 3; ++k)
            size = std::max(size, std::fabs(0.5 * p[k] - 0.5 * points[0][k]));
    if (size == 0.0 || (size > kLeast && size < kMost)) return std::nullopt;
    const int exponent = -std::ilogb(size);
    std::vector<Vec3> result(points.begin(), points.end());
    for (Vec3& p : result)
        for (double& x : p.c) x = std::ldexp(x, exponent);
    return result;
}

/// Images under an affine map. Throws InvalidInput for a projection.
inline std::vector<Vec3> transformed(std::span<const Vec3> points, const Transform& map)
{
    require(map.is_affine(), "transformed: the map of a curve or patch must be affine");
    std::vector<Vec3> result;
    result.reserve(points.size());
    for (const Vec3& p : points) result.push_back(apply(map, p));
    return result;
}

}  // namespace genus::control
