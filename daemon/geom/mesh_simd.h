/* mesh_simd: the four boxes of a node against one box or one direction, side by side. The one place of the meshes with
 * instructions of a particular processor: SSE2 is part of every x86-64; elsewhere plain C says the same, bit for bit.
 * Pure. Empty places of a node give numbers of no meaning. */
#ifndef COLLIDED_GEOM_MESH_SIMD_H
#define COLLIDED_GEOM_MESH_SIMD_H

#include "mesh.h"

#if defined(__SSE2__)

#include <emmintrin.h>

/* The squared distances of the boxes from the box [lo, hi], as floats round them. */
static inline void mesh_distances2(const mesh_node *n, const float lo[3], const float hi[3], float out[MESH_WIDTH])
{
    __m128 sum = _mm_setzero_ps();
    for (int k = 0; k < 3; k++) {
        __m128 below = _mm_sub_ps(_mm_set1_ps(lo[k]), _mm_loadu_ps(n->hi[k]));
        __m128 above = _mm_sub_ps(_mm_loadu_ps(n->lo[k]), _mm_set1_ps(hi[k]));
        __m128 gap = _mm_max_ps(_mm_max_ps(below, above), _mm_setzero_ps());
        sum = _mm_add_ps(sum, _mm_mul_ps(gap, gap));
    }
    _mm_storeu_ps(out, sum);
}

/* The least dot(direction, x) over each box, as floats round it. */
static inline void mesh_heights(const mesh_node *n, const float direction[3], float out[MESH_WIDTH])
{
    __m128 sum = _mm_setzero_ps();
    for (int k = 0; k < 3; k++) {
        const float *side = direction[k] > 0 ? n->lo[k] : n->hi[k];
        sum = _mm_add_ps(sum, _mm_mul_ps(_mm_set1_ps(direction[k]), _mm_loadu_ps(side)));
    }
    _mm_storeu_ps(out, sum);
}

#else

static inline void mesh_distances2(const mesh_node *n, const float lo[3], const float hi[3], float out[MESH_WIDTH])
{
    for (int i = 0; i < MESH_WIDTH; i++) {
        float sum = 0;
        for (int k = 0; k < 3; k++) {
            float below = lo[k] - n->hi[k][i], above = n->lo[k][i] - hi[k];
            float gap = below > above ? below : above;
            gap = gap > 0 ? gap : 0;
            sum += gap * gap;
        }
        out[i] = sum;
    }
}

static inline void mesh_heights(const mesh_node *n, const float direction[3], float out[MESH_WIDTH])
{
    for (int i = 0; i < MESH_WIDTH; i++) {
        float sum = 0;
        for (int k = 0; k < 3; k++) sum += direction[k] * (direction[k] > 0 ? n->lo[k][i] : n->hi[k][i]);
        out[i] = sum;
    }
}

#endif

#endif
