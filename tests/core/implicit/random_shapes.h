#pragma once

#include <cmath>
#include <random>

#include "genus/base/box.h"
#include "genus/base/transform.h"

namespace genus {

/// Random numbers, points, boxes and maps for tests; the seed is named by the test.
struct RandomShapes {
    std::mt19937_64 engine;

    explicit RandomShapes(std::uint64_t seed) : engine(seed) {}

    double in(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(engine);
    }
    int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine); }
    Vec3 point(double size = 2.0) { return {{in(-size, size), in(-size, size), in(-size, size)}}; }
    Vec3 point_in(const Box3& box)
    {
        Vec3 p;
        // Now and then on a side of the box, where extremes are.
        for (int i = 0; i < 3; ++i) {
            const int pick = below(8);
            p[i] = pick == 0 ? box.min[i]
                   : pick == 1
                       ? box.max[i]
                       : std::fmin(box.max[i], std::fmax(box.min[i], in(box.min[i], box.max[i])));
        }
        return p;
    }
    Box3 box(double size = 2.0)
    {
        Box3 b;
        const double scale = std::pow(10.0, in(-4.0, 0.0));
        const Vec3 c = point(size);
        b.add(c);
        b.add(c + scale * point(size));
        return b;
    }
    /// Rotation, then stretching by up to `stretch` either way, a shear, a step.
    Transform affine(double stretch = 3.0, double step = 2.0)
    {
        const auto factor = [&] {
            const double f = std::pow(stretch, in(-1.0, 1.0));
            return below(4) == 0 ? -f : f;
        };
        const Vec3 factors{{factor(), factor(), factor()}};
        return translation(point(step)) * rotation(point(180.0)) * scaling(factors) *
               rotation(point(180.0));
    }
};

}  // namespace genus
