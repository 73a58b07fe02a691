/* simd: numbers side by side, each rounded like a scalar: the same bits whatever the processor makes of them. The
 * vector types of the layers above, and which registers there are.
 *
 * In a function of LANES_WIDE the compiler may use 32-byte registers (AVX2), elsewhere it takes two of 16 (SSE2, NEON).
 * Whoever has such a function asks lanes_wide() which to call. No fused multiply-add. Pure. */
#ifndef COLLIDED_GEOM_SIMD_H
#define COLLIDED_GEOM_SIMD_H

#include <stdbool.h>
#include <stdint.h>

enum { LANES = 4 };

typedef double lanes __attribute__((vector_size(32)));
typedef int64_t lane_mask __attribute__((vector_size(32))); /* -1 or 0 in each lane */
typedef double lanes_anywhere __attribute__((vector_size(32), aligned(8), may_alias));

typedef double two __attribute__((vector_size(16)));
typedef int64_t two_masks __attribute__((vector_size(16)));

typedef float four_singles __attribute__((vector_size(16)));

typedef float singles __attribute__((vector_size(32)));
typedef int32_t words __attribute__((vector_size(32)));
typedef singles singles_anywhere __attribute__((aligned(4), may_alias));
typedef words words_anywhere __attribute__((aligned(4), may_alias));

#define LANES_INLINE __attribute__((always_inline)) static inline

#if defined(__x86_64__)
#define LANES_WIDE __attribute__((target("avx2")))
static inline bool lanes_wide(void)
{
    return __builtin_cpu_supports("avx2");
}
#else
#define LANES_WIDE
static inline bool lanes_wide(void)
{
    return false;
}
#endif

/* The same with all that it calls inlined: gcc calls functions without AVX2 and leaves the upper halves of registers in
 * use, which costs 100 ns there. */
#define LANES_WHOLE __attribute__((flatten)) LANES_WIDE

#endif
