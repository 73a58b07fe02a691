/* Four triangles side by side in registers of 32 bytes. Pure; any thread. */
#include "mesh_row.h"

#if defined(__x86_64__)

#include <immintrin.h>

/* All that follows, simd.h too: clang passes no wide register to a function that is not for AVX2, inlined or not. */
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif

#include "geom/simd.h"

LANES_INLINE lanes pick_by_permutation(const double v[LANES], uint32_t which)
{
    __m256i lane = _mm256_cvtepu8_epi64(_mm_cvtsi32_si128((int32_t)which)), twice = _mm256_add_epi64(lane, lane);
    __m256i halves = _mm256_or_si256(twice, _mm256_slli_epi64(twice, 32)); /* of lane k: 2 k and 2 k + 1 */
    halves = _mm256_or_si256(halves, _mm256_set1_epi64x((int64_t)1 << 32));
    return (lanes)_mm256_permutevar8x32_ps((__m256)lanes_load(v), halves);
}

#define row_greater_of(x, y) ((lanes)_mm256_max_pd(x, y)) /* x > y ? x : y */
#define row_lesser_of(x, y) ((lanes)_mm256_min_pd(x, y))  /* x < y ? x : y */
#define row_choose(m, yes, no) ((lanes)_mm256_blendv_pd(no, yes, (__m256d)(m)))
#define row_pick pick_by_permutation
#define row_bits_of(m) (unsigned)_mm256_movemask_pd((__m256d)(m))

#include "mesh_row_lanes.h"

#if defined(__clang__)
#pragma clang attribute pop
#endif

const mesh_row_kernel *const mesh_row_wide = &KERNEL;

#else /* lanes_wide() is false: never called */

const mesh_row_kernel *const mesh_row_wide = NULL;

#endif
