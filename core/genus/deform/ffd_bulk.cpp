#include "genus/deform/ffd_bulk.h"

#include <cmath>

#include "genus/patch/bulk.h"

#ifdef GENUS_WIDE_VECTORS
#include <immintrin.h>
#endif

namespace genus::bulk {

namespace {

#define GENUS_KERNELS "genus/deform/ffd_kernels.inc"
#include "genus/patch/vector_widths.inc"

}  // namespace

void deform(const FfdData& f, const double* in, std::size_t count, double* out)
{
    GENUS_DISPATCH(run, f, in, count, out);
}

}  // namespace genus::bulk
