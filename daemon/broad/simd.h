/* simd: the one place with instructions of a particular processor: SSE2 is part of every x86-64; elsewhere plain C says
 * the same. Pure. */
#ifndef COLLIDED_BROAD_SIMD_H
#define COLLIDED_BROAD_SIMD_H

#include "fbox.h"

#if defined(__SSE2__)

#include <emmintrin.h>

/* Of the four numbers of a corner three are the box's; the last is ignored. */
typedef struct simd_box {
    __m128 lo, hi;
} simd_box;

/* Reads four floats from each corner. */
static inline simd_box simd_load_box(const float *lo, const float *hi)
{
    return (simd_box){_mm_loadu_ps(lo), _mm_loadu_ps(hi)};
}

static inline bool simd_overlap(simd_box a, simd_box b)
{
    __m128 apart = _mm_or_ps(_mm_cmpgt_ps(a.lo, b.hi), _mm_cmpgt_ps(b.lo, a.hi));
    return (_mm_movemask_ps(apart) & 7) == 0;
}

#else

typedef fbox simd_box;

static inline simd_box simd_load_box(const float *lo, const float *hi)
{
    return (fbox){{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
}

static inline bool simd_overlap(simd_box a, simd_box b)
{
    return fbox_overlap(&a, &b);
}

#endif

#endif
