#pragma once

#include <cstddef>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define GENUS_WIDE_VECTORS 1
#endif

// Inner loops over many parameters, internal to core. Every point is computed by the same
// operations in the same order whatever the vector width: results have the same bits everywhere.
namespace genus::bulk {

/// For tests: work with the narrowest vectors, as on a machine that has no others.
void force_narrow_vectors(bool force);
/// True if wide vectors are there and not forbidden.
bool wide_vectors();

/// Points of a curve with n + 1 control points of `dim` (3 or 4) doubles each. With dim = 4 the
/// first three coordinates are divided by the fourth. `out` holds three doubles a parameter.
///
/// The basis is formed from powers of t and 1 - t, all factors positive, then summed in ascending
/// order: each term is exact to 3 n + 3 roundings. O(n) each.
void curve(const double* c, int n, int dim, const double* t, std::size_t count, double* out);

/// Points, and if `normals` is not null unit normals, of a tensor-product patch of degrees m, n,
/// with control point (i, j) at c[dim (i (n + 1) + j)]. A normal that cannot be trusted is
/// written as zero.
void tensor(const double* c, int m, int n, int dim, const double* u, const double* v,
            std::size_t count, double* points, double* normals);

/// The same for a triangle patch of degree n at barycentric coordinates (u, v, 1 - u - v);
/// control points in rows of equal u-index, see bezier_triangle.h.
void triangle(const double* c, int n, int dim, const double* u, const double* v, std::size_t count,
              double* points, double* normals);

}  // namespace genus::bulk
