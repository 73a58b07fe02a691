/* lanes: four doubles side by side, each rounded like a scalar: the same bits whatever the processor makes of them.
 *
 * In a function of LANES_WIDE the compiler may use 32-byte registers (AVX2), elsewhere it takes two of 16 (SSE2, NEON).
 * Whoever has such a function asks lanes_wide() which to call. No fused multiply-add. Pure. */
#ifndef COLLIDED_NARROW_LANES_H
#define COLLIDED_NARROW_LANES_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum { LANES = 4 };

typedef double lanes __attribute__((vector_size(32)));
typedef int64_t lane_mask __attribute__((vector_size(32))); /* -1 or 0 in each lane */
typedef double lanes_anywhere __attribute__((vector_size(32), aligned(8), may_alias));

/* The same with all that it calls inlined: gcc calls functions without AVX2 and leaves the upper halves of registers in
 * use, which costs 100 ns there. */
#define LANES_WHOLE __attribute__((flatten)) LANES_WIDE

#define LANES_INLINE __attribute__((always_inline)) static inline

#if defined(__x86_64__)

#include <emmintrin.h>

#define LANES_WIDE __attribute__((target("avx2")))

static inline bool lanes_wide(void)
{
    return __builtin_cpu_supports("avx2");
}

/* Bit k: lane k of the mask. */
LANES_INLINE unsigned lanes_bits(lane_mask m)
{
    __m128 low = (__m128)__builtin_shufflevector(m, m, 0, 1), high = (__m128)__builtin_shufflevector(m, m, 2, 3);
    return (unsigned)_mm_movemask_ps(_mm_shuffle_ps(low, high, _MM_SHUFFLE(3, 1, 3, 1)));
}

LANES_INLINE lanes lanes_sqrt(lanes x)
{
    __m128d low = _mm_sqrt_pd(__builtin_shufflevector(x, x, 0, 1));
    __m128d high = _mm_sqrt_pd(__builtin_shufflevector(x, x, 2, 3));
    return __builtin_shufflevector(low, high, 0, 1, 2, 3);
}

#else

#define LANES_WIDE

static inline bool lanes_wide(void)
{
    return false;
}

LANES_INLINE unsigned lanes_bits(lane_mask m)
{
    unsigned bits = 0;
    for (int k = 0; k < LANES; k++) bits |= (unsigned)(m[k] & 1) << k;
    return bits;
}

LANES_INLINE lanes lanes_sqrt(lanes x)
{
    for (int k = 0; k < LANES; k++) x[k] = sqrt(x[k]);
    return x;
}

#endif

/* The greatest of all eight. */
LANES_INLINE double lanes_greatest(lanes x, lanes y)
{
    for (int k = 0; k < LANES; k++) x[k] = x[k] > y[k] ? x[k] : y[k];
    double even = x[0] > x[2] ? x[0] : x[2], odd = x[1] > x[3] ? x[1] : x[3];
    return even > odd ? even : odd;
}

LANES_INLINE lanes lanes_of(double x)
{
    return (lanes){x, x, x, x};
}

/* Lane k in all. */
#define LANES_ALL(x, k) __builtin_shufflevector(x, x, k, k, k, k)

LANES_INLINE lanes lanes_load(const double *from)
{
    return *(const lanes_anywhere *)from;
}

LANES_INLINE void lanes_store(double *to, lanes x)
{
    *(lanes_anywhere *)to = x;
}

LANES_INLINE lanes lanes_choose(lane_mask m, lanes yes, lanes no)
{
    return (lanes)((m & (lane_mask)yes) | (~m & (lane_mask)no));
}

/* Three columns of coordinates. */
typedef struct lanes3 {
    lanes x, y, z;
} lanes3;

LANES_INLINE lanes3 lanes3_sub(lanes3 a, lanes3 b)
{
    return (lanes3){a.x - b.x, a.y - b.y, a.z - b.z};
}

LANES_INLINE lanes lanes3_dot(lanes3 a, lanes3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

LANES_INLINE lanes3 lanes3_cross(lanes3 a, lanes3 b)
{
    return (lanes3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

LANES_INLINE lanes3 lanes3_choose(lane_mask m, lanes3 yes, lanes3 no)
{
    return (lanes3){lanes_choose(m, yes.x, no.x), lanes_choose(m, yes.y, no.y), lanes_choose(m, yes.z, no.z)};
}

#endif
