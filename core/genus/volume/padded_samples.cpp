#include "genus/volume/padded_samples.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace genus {

namespace {

template <typename Value>
std::uint64_t one_by_one(const Value* values, std::int32_t from, std::int32_t n, Value threshold)
{
    std::uint64_t found = 0;
    for (std::int32_t i = from; i < n; ++i) found |= std::uint64_t{values[i] < threshold} << i;
    return found;
}

}  // namespace

#if defined(__SSE2__)

std::uint64_t below(const float* values, std::int32_t n, float threshold)
{
    const __m128 bound = _mm_set1_ps(threshold);
    std::uint64_t found = 0;
    std::int32_t i = 0;
    for (; i + 16 <= n; i += 16) {
        const auto four = [&](std::int32_t at) {
            return _mm_castps_si128(_mm_cmplt_ps(_mm_loadu_ps(values + i + at), bound));
        };
        // Masks of 32 bits become masks of 8 bits; each keeps its sign.
        const __m128i low = _mm_packs_epi32(four(0), four(4));
        const __m128i high = _mm_packs_epi32(four(8), four(12));
        const auto bits = static_cast<unsigned>(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
        found |= static_cast<std::uint64_t>(bits) << i;
    }
    return found | one_by_one(values, i, n, threshold);
}

std::uint64_t below(const double* values, std::int32_t n, double threshold)
{
    const __m128d bound = _mm_set1_pd(threshold);
    std::uint64_t found = 0;
    std::int32_t i = 0;
    for (; i + 4 <= n; i += 4) {
        const __m128d low = _mm_cmplt_pd(_mm_loadu_pd(values + i), bound);
        const __m128d high = _mm_cmplt_pd(_mm_loadu_pd(values + i + 2), bound);
        // Of each 64-bit mask the upper half is enough.
        const __m128 four = _mm_shuffle_ps(_mm_castpd_ps(low), _mm_castpd_ps(high), 0xdd);
        found |= static_cast<std::uint64_t>(static_cast<unsigned>(_mm_movemask_ps(four))) << i;
    }
    return found | one_by_one(values, i, n, threshold);
}

#else

std::uint64_t below(const float* values, std::int32_t n, float threshold)
{
    return one_by_one(values, 0, n, threshold);
}

std::uint64_t below(const double* values, std::int32_t n, double threshold)
{
    return one_by_one(values, 0, n, threshold);
}

#endif

}  // namespace genus
