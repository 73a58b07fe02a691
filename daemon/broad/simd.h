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

/* A box that moves along a line, ready for many boxes: see tree_ray.c. By axis, with a fourth number that is ignored:
 * from where and by what factor a side's distance becomes a length of the way; `forward` where it moves upward. */
typedef struct simd_ray {
    __m128 near_from, near_scale, far_from, far_scale, forward;
} simd_ray;

static inline simd_ray simd_make_ray(const float near_from[3], const float near_scale[3], const float far_from[3],
    const float far_scale[3], const bool forward[3])
{
    return (simd_ray){_mm_setr_ps(near_from[0], near_from[1], near_from[2], 0),
        _mm_setr_ps(near_scale[0], near_scale[1], near_scale[2], 0),
        _mm_setr_ps(far_from[0], far_from[1], far_from[2], 0), _mm_setr_ps(far_scale[0], far_scale[1], far_scale[2], 0),
        _mm_castsi128_ps(_mm_setr_epi32(-forward[0], -forward[1], -forward[2], 0))};
}

/* From which length on it meets the box, if that is at most `far`; otherwise infinity. What is no number (0 times
 * infinity: along a side) is passed over, which is why the operands stand in this order. */
static inline float simd_enters(const simd_ray *r, simd_box b, float far)
{
    __m128 first = _mm_or_ps(_mm_and_ps(r->forward, b.lo), _mm_andnot_ps(r->forward, b.hi));
    __m128 last = _mm_or_ps(_mm_and_ps(r->forward, b.hi), _mm_andnot_ps(r->forward, b.lo));
    __m128 enter = _mm_max_ps(_mm_mul_ps(_mm_sub_ps(first, r->near_from), r->near_scale), _mm_setzero_ps());
    __m128 leave = _mm_min_ps(_mm_mul_ps(_mm_sub_ps(last, r->far_from), r->far_scale), _mm_set1_ps(far));
    enter = _mm_max_ps(_mm_max_ps(enter, _mm_shuffle_ps(enter, enter, 0xc9)), _mm_shuffle_ps(enter, enter, 0xd2));
    leave = _mm_min_ps(_mm_min_ps(leave, _mm_shuffle_ps(leave, leave, 0xc9)), _mm_shuffle_ps(leave, leave, 0xd2));
    __m128 meets = _mm_cmple_ss(enter, leave);
    return _mm_cvtss_f32(_mm_or_ps(_mm_and_ps(meets, enter), _mm_andnot_ps(meets, _mm_set_ss(INFINITY))));
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

typedef struct simd_ray {
    float near_from[3], near_scale[3], far_from[3], far_scale[3];
    bool forward[3];
} simd_ray;

static inline simd_ray simd_make_ray(const float near_from[3], const float near_scale[3], const float far_from[3],
    const float far_scale[3], const bool forward[3])
{
    simd_ray r;
    for (int k = 0; k < 3; k++) {
        r.near_from[k] = near_from[k], r.near_scale[k] = near_scale[k];
        r.far_from[k] = far_from[k], r.far_scale[k] = far_scale[k];
        r.forward[k] = forward[k];
    }
    return r;
}

static inline float simd_enters(const simd_ray *r, simd_box b, float far)
{
    float enter = 0, leave = far;
    for (int k = 0; k < 3; k++) {
        float first = r->forward[k] ? b.lo[k] : b.hi[k], last = r->forward[k] ? b.hi[k] : b.lo[k];
        float from = (first - r->near_from[k]) * r->near_scale[k], to = (last - r->far_from[k]) * r->far_scale[k];
        if (from > enter) enter = from;
        if (to < leave) leave = to;
    }
    return enter <= leave ? enter : INFINITY;
}

#endif

#endif
