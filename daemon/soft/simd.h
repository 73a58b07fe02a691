/* simd: what the boxes of soft meshes need of a particular processor: SSE2 is part of every x86-64; elsewhere plain C
 * says the same. Pure. */
#ifndef COLLIDED_SOFT_SIMD_H
#define COLLIDED_SOFT_SIMD_H

#include "geom/simd.h"

#if defined(__x86_64__)

#include <emmintrin.h>

/* Bit k: mask[k] is set. */
LANES_INLINE unsigned words_bits(words mask)
{
    __m128 low = (__m128)__builtin_shufflevector(mask, mask, 0, 1, 2, 3);
    __m128 high = (__m128)__builtin_shufflevector(mask, mask, 4, 5, 6, 7);
    return (unsigned)_mm_movemask_ps(low) | (unsigned)_mm_movemask_ps(high) << 4;
}

LANES_INLINE four_singles lesser(four_singles a, four_singles b) /* a < b ? a : b */
{
    return _mm_min_ps(a, b);
}

#else

LANES_INLINE unsigned words_bits(words mask)
{
    unsigned bits = 0;
    for (int k = 0; k < 8; k++) bits |= (unsigned)(mask[k] & 1) << k;
    return bits;
}

LANES_INLINE four_singles lesser(four_singles a, four_singles b)
{
    for (int k = 0; k < 4; k++) a[k] = a[k] < b[k] ? a[k] : b[k];
    return a;
}

#endif

#endif
