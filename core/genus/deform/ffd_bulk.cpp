#include "genus/deform/ffd_bulk.h"

#include "genus/patch/bulk.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define GENUS_WIDE_VECTORS 1
#endif

// Packs are passed between functions of one file only, where it does not matter how.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace genus::bulk {

namespace {

namespace narrow {
constexpr int kLanes = 2;
using Pack = double __attribute__((vector_size(16)));
#include "genus/deform/ffd_kernels.inc"
}  // namespace narrow

#ifdef GENUS_WIDE_VECTORS
// AVX2 without fused multiply-add: the same bits, twice as many lanes.
#pragma GCC push_options
#pragma GCC target("avx2")
namespace wide {
constexpr int kLanes = 4;
using Pack = double __attribute__((vector_size(32)));
#include "genus/deform/ffd_kernels.inc"
}  // namespace wide
#pragma GCC pop_options
#endif

}  // namespace

void deform(const FfdData& f, const double* in, std::size_t count, double* out)
{
#ifdef GENUS_WIDE_VECTORS
    if (wide_vectors()) return wide::run(f, in, count, out);
#endif
    narrow::run(f, in, count, out);
}

}  // namespace genus::bulk
