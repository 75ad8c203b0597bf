#include "genus/patch/bulk.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <vector>

#include "genus/patch/bernstein.h"

#ifdef GENUS_WIDE_VECTORS
#include <immintrin.h>
#endif

namespace genus::bulk {

namespace {

#define GENUS_KERNELS "genus/patch/bulk_kernels.inc"
#include "genus/patch/vector_widths.inc"

std::atomic<bool> narrow_forced{false};

std::vector<double> binomials(int n)
{
    std::vector<double> b;
    for (int k = 0; k <= n; ++k) b.push_back(bernstein::binomial(n, k));
    return b;
}

// n! / (i! j! k!) for i + j + k = n, in the order of the control points.
std::vector<double> multinomials(int n)
{
    std::vector<double> m;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n - i; ++j)
            m.push_back(bernstein::binomial(n, i) * bernstein::binomial(n - i, j));
    return m;
}

// Squared length below which a tangent, a difference of points, has lost half of its digits.
double least_tangent(const double* c, std::size_t points, int dim)
{
    double largest = 0.0;
    for (std::size_t i = 0; i < points * static_cast<std::size_t>(dim); ++i)
        largest = std::max(largest, std::fabs(c[i]));
    return std::max(1e-16 * largest * largest, 1e-290);
}

}  // namespace

void force_narrow_vectors(bool force)
{
    narrow_forced = force;
}

bool wide_vectors()
{
#ifdef GENUS_WIDE_VECTORS
    static const bool has = __builtin_cpu_supports("avx2") != 0;
    return has && !narrow_forced;
#else
    return false;
#endif
}

void curve(const double* c, int n, int dim, const double* t, std::size_t count, double* out)
{
    const auto choose = binomials(n);
    GENUS_DISPATCH(run_curve, c, n, dim, choose.data(), t, count, out);
}

void tensor(const double* c, int m, int n, int dim, const double* u, const double* v,
            std::size_t count, double* points, double* normals)
{
    if (!normals) {
        const auto choose_m = binomials(m), choose_n = binomials(n);
        GENUS_DISPATCH(run_tensor_points, c, m, n, dim, choose_m.data(), choose_n.data(), u, v,
                       count, points);
        return;
    }
    const auto choose_m = binomials(m - 1), choose_n = binomials(n - 1);
    const double least =
        least_tangent(c, static_cast<std::size_t>(m + 1) * static_cast<std::size_t>(n + 1), dim);
    GENUS_DISPATCH(run_tensor_normals, c, m, n, dim, choose_m.data(), choose_n.data(), least, u, v,
                   count, points, normals);
}

void triangle(const double* c, int n, int dim, const double* u, const double* v, std::size_t count,
              double* points, double* normals)
{
    const auto choose = multinomials(n - 1);
    const double least = least_tangent(
        c, static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n + 2) / 2, dim);
    GENUS_DISPATCH(run_triangle, c, n, dim, choose.data(), least, u, v, count, points, normals);
}

}  // namespace genus::bulk
