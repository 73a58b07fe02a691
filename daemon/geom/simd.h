/* simd: numbers side by side, each rounded like a scalar: the same bits whatever the processor makes of them. Vector
 * types, which registers there are, and operations on four doubles (`lanes`) or on a 3-vector in the first three.
 *
 * In a function of LANES_WIDE the compiler may use 32-byte registers (AVX2), elsewhere it takes two of 16 (SSE2, NEON).
 * Whoever has such a function asks lanes_wide() which to call. No fused multiply-add. Pure. */
#ifndef COLLIDED_GEOM_SIMD_H
#define COLLIDED_GEOM_SIMD_H

#include "geom/vec.h"

#include <math.h>
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

/* Defines name_wide, which may use registers of 32 bytes, and name_narrow: both are `body`, a function of LANES_INLINE.
 * `how`: LANES_WIDE or LANES_WHOLE. A semicolon follows. LANES_CHOSEN is the one for this processor. */
#define LANES_TWINS(how, type, name, body, parameters, arguments)                                                      \
    how static type name##_wide parameters                                                                             \
    {                                                                                                                  \
        return body arguments;                                                                                         \
    }                                                                                                                  \
    static type name##_narrow parameters                                                                               \
    {                                                                                                                  \
        return body arguments;                                                                                         \
    }                                                                                                                  \
    static type name##_narrow parameters
#define LANES_CHOSEN(name) (lanes_wide() ? name##_wide : name##_narrow)

#if defined(__x86_64__)

#include <emmintrin.h>

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

/* ---- a vector in the first three lanes ---- */

LANES_INLINE lanes lanes_each(lanes v, int k) /* k constant */
{
    return k == 0   ? __builtin_shufflevector(v, v, 0, 0, 0, 0)
           : k == 1 ? __builtin_shufflevector(v, v, 1, 1, 1, 1)
                    : __builtin_shufflevector(v, v, 2, 2, 2, 2);
}

LANES_INLINE lane_mask lanes_sign(lanes v)
{
    return (lane_mask)v & (lane_mask)lanes_of(-0.0);
}

LANES_INLINE lanes lanes_abs(lanes v)
{
    return (lanes)((lane_mask)v & ~(lane_mask)lanes_of(-0.0));
}

LANES_INLINE lanes lanes_clamp(lanes v, lanes most) /* -most <= v <= most */
{
    lanes least = 0 - most;
    for (int k = 0; k < LANES; k++) v[k] = v[k] < most[k] ? v[k] : most[k];
    for (int k = 0; k < LANES; k++) v[k] = v[k] > least[k] ? v[k] : least[k];
    return v;
}

LANES_INLINE lanes3 lanes3_transposed(lanes3 m)
{
    lanes even = __builtin_shufflevector(m.x, m.y, 0, 4, 2, 6), odd = __builtin_shufflevector(m.x, m.y, 1, 5, 3, 7);
    return (lanes3){__builtin_shufflevector(even, m.z, 0, 1, 4, 5), __builtin_shufflevector(odd, m.z, 0, 1, 5, 6),
        __builtin_shufflevector(even, m.z, 2, 3, 6, 7)};
}

/* m v, for a matrix of these columns: of a vector in lanes, and of one in memory. */
LANES_INLINE lanes lanes3_mul(lanes3 m, lanes v)
{
    return m.x * lanes_each(v, 0) + m.y * lanes_each(v, 1) + m.z * lanes_each(v, 2);
}

LANES_INLINE lanes lanes3_mul_vec(lanes3 m, const vec3 *v)
{
    return m.x * v->x + m.y * v->y + m.z * v->z;
}

/* Of three lanes. */
LANES_INLINE double lanes_norm2(lanes v)
{
    lanes squares = v * v;
    return squares[0] + squares[1] + squares[2];
}

LANES_INLINE double lanes_sum3(lanes v)
{
    return v[0] + v[1] + v[2];
}

LANES_INLINE lanes lanes_cross(lanes a, lanes b)
{
    lanes a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3), a2 = __builtin_shufflevector(a, a, 2, 0, 1, 3);
    lanes b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3), b2 = __builtin_shufflevector(b, b, 2, 0, 1, 3);
    return a1 * b2 - a2 * b1;
}

#endif
