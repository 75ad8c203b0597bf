#pragma once

#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <span>
#include <vector>

#include "genus/base/vec.h"

// Evaluation in 113 bits, by de Casteljau, as the truth that bounds are held against.
namespace genus::reference {

__extension__ typedef __float128 Quad;

inline Quad magnitude(Quad x)
{
    return x < 0 ? -x : x;
}

template <std::size_t N>
std::array<Quad, N> value(std::span<const Vec<N>> c, double t)
{
    std::vector<std::array<Quad, N>> work(c.size());
    for (std::size_t i = 0; i < c.size(); ++i)
        for (std::size_t k = 0; k < N; ++k) work[i][k] = c[i][k];
    const Quad tt = t, s = Quad(1) - tt;
    for (std::size_t left = c.size() - 1; left > 0; --left)
        for (std::size_t i = 0; i < left; ++i)
            for (std::size_t k = 0; k < N; ++k) work[i][k] = s * work[i][k] + tt * work[i + 1][k];
    return work[0];
}

inline Vec3 random_vec(std::mt19937_64& random, double size = 1.0)
{
    std::uniform_real_distribution<double> x(-size, size);
    return {{x(random), x(random), x(random)}};
}

inline std::vector<Vec3> random_points(std::mt19937_64& random, int n, double size = 1.0)
{
    std::vector<Vec3> p;
    for (int i = 0; i < n; ++i) p.push_back(random_vec(random, size));
    return p;
}

/// True when the long forms of the tests are asked for.
inline bool long_run()
{
    const char* value = std::getenv("GENUS_LONG");
    return value != nullptr && *value != 0;
}

}  // namespace genus::reference
