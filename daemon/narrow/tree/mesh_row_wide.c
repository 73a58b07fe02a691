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

#include "narrow/math/simd.h"

#define ROW_INLINE LANES_INLINE

ROW_INLINE lanes choose(lane_mask m, lanes yes, lanes no)
{
    return _mm256_blendv_pd(no, yes, (__m256d)m);
}
ROW_INLINE lanes greater_of(lanes x, lanes y) /* x > y ? x : y */
{
    return _mm256_max_pd(x, y);
}
ROW_INLINE lanes lesser_of(lanes x, lanes y) /* x < y ? x : y */
{
    return _mm256_min_pd(x, y);
}
ROW_INLINE lanes pick(const double v[LANES], uint32_t which)
{
    __m256i lane = _mm256_cvtepu8_epi64(_mm_cvtsi32_si128((int32_t)which)), twice = _mm256_add_epi64(lane, lane);
    __m256i halves = _mm256_or_si256(twice, _mm256_slli_epi64(twice, 32)); /* of lane k: 2 k and 2 k + 1 */
    halves = _mm256_or_si256(halves, _mm256_set1_epi64x((int64_t)1 << 32));
    return (lanes)_mm256_permutevar8x32_ps((__m256)lanes_load(v), halves);
}
ROW_INLINE unsigned bits_of(lane_mask m)
{
    return (unsigned)_mm256_movemask_pd((__m256d)m);
}

#include "mesh_row_lanes.h"

void mesh_four_set_wide(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a)
{
    four_set(f, corners, count, scale, b_in_a);
}

unsigned mesh_row_near_wide(const mesh_four *a, const mesh_four *b, const mesh_picks *p, double within2, mesh_row *out)
{
    return row_near(a, b, p, within2, out);
}

unsigned mesh_fours_near_wide(const mesh_four *a, const mesh_four *b, const double levels_a[MESH_LEAF_MAX],
    const double levels_b[MESH_LEAF_MAX], double within)
{
    return fours_near(a, b, levels_a, levels_b, within);
}

unsigned mesh_row_near_core_wide(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return core_near(b, a, near, within2, out);
}

unsigned mesh_row_near_box_wide(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return box_near(b, a, near, within2, out);
}

void mesh_four_levels_wide(const mesh_four *f, vec3 axis, double levels[MESH_LEAF_MAX])
{
    four_levels(f, axis, levels);
}

#if defined(__clang__)
#pragma clang attribute pop
#endif

#else /* lanes_wide() is false: never called */

void mesh_four_set_wide(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a)
{
    mesh_four_set(f, corners, count, scale, b_in_a);
}

unsigned mesh_row_near_wide(const mesh_four *a, const mesh_four *b, const mesh_picks *p, double within2, mesh_row *out)
{
    return mesh_row_near(a, b, p, within2, out);
}

unsigned mesh_fours_near_wide(const mesh_four *a, const mesh_four *b, const double levels_a[MESH_LEAF_MAX],
    const double levels_b[MESH_LEAF_MAX], double within)
{
    return mesh_fours_near(a, b, levels_a, levels_b, within);
}

unsigned mesh_row_near_core_wide(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return mesh_row_near_core(b, a, near, within2, out);
}

unsigned mesh_row_near_box_wide(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return mesh_row_near_box(b, a, near, within2, out);
}

void mesh_four_levels_wide(const mesh_four *f, vec3 axis, double levels[MESH_LEAF_MAX])
{
    mesh_four_levels(f, axis, levels);
}

#endif
