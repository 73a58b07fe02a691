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

/* Lower bounds of dot(direction, x) over each box and below its plane, as floats round them: with d = -direction,
 * dot(d, x) <= l top + max over the box of dot(d - l normal, x) for any l >= 0; l = 0 and l = dot(d, normal) are tried.
 */
static inline void mesh_heights(const mesh_node *n, const float direction[3], float out[MESH_WIDTH])
{
    __m128 share = _mm_setzero_ps(), box = _mm_setzero_ps(), cut = _mm_setzero_ps();
    for (int k = 0; k < 3; k++)
        share = _mm_sub_ps(share, _mm_mul_ps(_mm_set1_ps(direction[k]), _mm_loadu_ps(n->normal[k])));
    share = _mm_max_ps(share, _mm_setzero_ps());
    cut = _mm_mul_ps(share, _mm_loadu_ps(n->top));
    for (int k = 0; k < 3; k++) {
        __m128 lo = _mm_loadu_ps(n->lo[k]), hi = _mm_loadu_ps(n->hi[k]), d = _mm_set1_ps(-direction[k]);
        __m128 rest = _mm_sub_ps(d, _mm_mul_ps(share, _mm_loadu_ps(n->normal[k])));
        box = _mm_add_ps(box, _mm_max_ps(_mm_mul_ps(d, lo), _mm_mul_ps(d, hi)));
        cut = _mm_add_ps(cut, _mm_max_ps(_mm_mul_ps(rest, lo), _mm_mul_ps(rest, hi)));
    }
    _mm_storeu_ps(out, _mm_sub_ps(_mm_setzero_ps(), _mm_min_ps(box, cut)));
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
        float share = 0, box = 0;
        for (int k = 0; k < 3; k++) share -= direction[k] * n->normal[k][i];
        share = share > 0 ? share : 0;
        float cut = share * n->top[i];
        for (int k = 0; k < 3; k++) {
            float d = -direction[k], rest = d - share * n->normal[k][i];
            float box_lo = d * n->lo[k][i], box_hi = d * n->hi[k][i];
            float cut_lo = rest * n->lo[k][i], cut_hi = rest * n->hi[k][i];
            box += box_lo > box_hi ? box_lo : box_hi;
            cut += cut_lo > cut_hi ? cut_lo : cut_hi;
        }
        out[i] = 0 - (box < cut ? box : cut);
    }
}

#endif

#endif
