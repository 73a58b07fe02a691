/* mesh_simd: the four boxes of a node against one box of another shape, side by side.
 *
 * The one place of the meshes with instructions of a particular processor: SSE2 is part of every x86-64; elsewhere
 * plain C says the same, bit for bit. Pure. Empty places of a node give numbers of no meaning. */
#ifndef COLLIDED_GEOM_MESH_SIMD_H
#define COLLIDED_GEOM_MESH_SIMD_H

#include "mesh.h"
#include "simd.h"

#include <string.h>

typedef four_singles mesh_lanes; /* + - * / lane by lane */

#if defined(__SSE2__)

#include <emmintrin.h>

LANES_INLINE mesh_lanes floats_max(mesh_lanes a, mesh_lanes b) /* a > b ? a : b */
{
    return _mm_max_ps(a, b);
}
LANES_INLINE mesh_lanes floats_min(mesh_lanes a, mesh_lanes b) /* a < b ? a : b */
{
    return _mm_min_ps(a, b);
}
LANES_INLINE mesh_lanes floats_abs(mesh_lanes a)
{
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), a);
}
LANES_INLINE mesh_lanes floats_sqrt(mesh_lanes a)
{
    return _mm_sqrt_ps(a);
}
LANES_INLINE unsigned floats_not_above(mesh_lanes a, mesh_lanes b) /* bit k: not a > b in lane k */
{
    return (unsigned)_mm_movemask_ps(_mm_cmpngt_ps(a, b));
}

#else

LANES_INLINE mesh_lanes floats_max(mesh_lanes a, mesh_lanes b)
{
    for (int i = 0; i < MESH_WIDTH; i++) a[i] = a[i] > b[i] ? a[i] : b[i];
    return a;
}
LANES_INLINE mesh_lanes floats_min(mesh_lanes a, mesh_lanes b)
{
    for (int i = 0; i < MESH_WIDTH; i++) a[i] = a[i] < b[i] ? a[i] : b[i];
    return a;
}
LANES_INLINE mesh_lanes floats_abs(mesh_lanes a)
{
    for (int i = 0; i < MESH_WIDTH; i++) a[i] = fabsf(a[i]);
    return a;
}
LANES_INLINE mesh_lanes floats_sqrt(mesh_lanes a)
{
    for (int i = 0; i < MESH_WIDTH; i++) a[i] = sqrtf(a[i]);
    return a;
}
LANES_INLINE unsigned floats_not_above(mesh_lanes a, mesh_lanes b)
{
    unsigned bits = 0;
    for (int i = 0; i < MESH_WIDTH; i++) bits |= (unsigned)!(a[i] > b[i]) << i;
    return bits;
}

#endif

LANES_INLINE mesh_lanes floats_of(float x)
{
    return (mesh_lanes){x, x, x, x};
}
LANES_INLINE mesh_lanes floats_load(const float *p)
{
    mesh_lanes v;
    memcpy(&v, p, sizeof v);
    return v;
}
/* Rows to columns. */
LANES_INLINE void floats_turn(mesh_lanes v[MESH_WIDTH])
{
    mesh_lanes a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5), b = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
    mesh_lanes c = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7), d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
    v[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
    v[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
    v[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
    v[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}
LANES_INLINE mesh_lanes floats_dot(const mesh_lanes u[3], const float v[3])
{
    return u[0] * floats_of(v[0]) + u[1] * floats_of(v[1]) + u[2] * floats_of(v[2]);
}
LANES_INLINE mesh_lanes floats_dots(const mesh_lanes u[3], const mesh_lanes v[3])
{
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

/* What a node's boxes are held against, in the node's frame and unit: a turned box. Vectors have a fourth place, 0, so
 * that each fills a register. */
typedef struct mesh_other {
    float centre[MESH_WIDTH], side[3][MESH_WIDTH]; /* side: from the centre to the middles of three faces */
    bool flat;                                     /* it is around a patch of a surface */
    float normal[MESH_WIDTH], half; /* whose mean normal is this (about unit): half its extent along it */
    float square[3][MESH_WIDTH];    /* otherwise: the directions of its sides (about unit, orthogonal) ... */
    float halves[3];                /* ... and half its extent along each */
    float axis[MESH_WIDTH], level;  /* a direction towards the node (about unit), and what no point is above along it */
    bool aimed;                     /* there is such a direction */
    float slack;                    /* what the rounding of floats may add to a bound */
    bool far;                       /* floats cannot hold it: nothing but this is set */
} mesh_other;

/* Half of what each box measures along u. */
LANES_INLINE mesh_lanes mesh_halves(const mesh_node *n, const mesh_lanes u[3])
{
    mesh_lanes along[3] = {floats_of(0), floats_of(0), floats_of(0)};
    for (int k = 0; k < 3; k++) {
        along[0] += u[k] * floats_load(n->side[0][k]);
        along[1] += u[k] * floats_load(n->side[1][k]);
        along[2] += u[k] * floats_load(n->normal[k]);
    }
    return floats_abs(along[0]) + floats_abs(along[1]) + floats_abs(along[2]) * floats_load(n->half);
}

LANES_INLINE mesh_lanes other_halves(const mesh_other *o, const mesh_lanes u[3])
{
    return floats_abs(floats_dot(u, o->side[0])) + floats_abs(floats_dot(u, o->side[1])) +
           floats_abs(floats_dot(u, o->side[2]));
}

LANES_INLINE void floats_spread(const float v[3], mesh_lanes out[3])
{
    for (int k = 0; k < 3; k++) out[k] = floats_of(v[k]);
}

/* The least heights of the patches along a direction (about unit). */
LANES_INLINE mesh_lanes mesh_lows(const mesh *m, const mesh_node *n, const float direction[3])
{
    const mesh_patch_point *p = &m->patch_points[n->first_point];
    mesh_lanes axis[3], low = floats_of(INFINITY), next = low;
    uint32_t k = 0;
    floats_spread(direction, axis);
    for (; k + 2 <= n->points; k += 2, p += 2) { /* two at a time: each least waits for the one before it */
        mesh_lanes at[3] = {floats_load(p->at[0]), floats_load(p->at[1]), floats_load(p->at[2])};
        mesh_lanes and[3] = {floats_load(p[1].at[0]), floats_load(p[1].at[1]), floats_load(p[1].at[2])};
        low = floats_min(floats_dots(at, axis), low);
        next = floats_min(floats_dots(and, axis), next);
    }
    low = floats_min(low, next);
    if (k < n->points) {
        mesh_lanes at[3] = {floats_load(p->at[0]), floats_load(p->at[1]), floats_load(p->at[2])};
        low = floats_min(floats_dots(at, axis), low);
    }
    return low - floats_load(n->excess);
}

/* From a box that is no patch to the boxes around the others along its sides: what is beyond it along each of three
 * orthogonal directions is so far away together. */
LANES_INLINE mesh_lanes mesh_beyond(const mesh_node *n, const mesh_other *o, const mesh_lanes away[3])
{
    mesh_lanes sum = floats_of(0);
    for (int k = 0; k < 3; k++) {
        mesh_lanes axis[3];
        floats_spread(o->square[k], axis);
        mesh_lanes gap = floats_abs(floats_dots(away, axis)) - mesh_halves(n, axis) - floats_of(o->halves[k]);
        gap = floats_max(gap, floats_of(0));
        sum += gap * gap;
    }
    return floats_sqrt(sum);
}

/* A box around a patch of another mesh, as the nodes of this one see it: the part of mesh_other that walks down two
 * meshes look at. */
typedef struct mesh_patch_box {
    _Alignas(16) float centre[MESH_WIDTH], side[2][MESH_WIDTH], normal[MESH_WIDTH];
    float half, slack;
} mesh_patch_box;

/* As mesh_bounds_from. */
LANES_INLINE unsigned mesh_patch_bounds(
    const mesh_node *n, const mesh_patch_box *o, mesh_lanes bound, unsigned near, float limit, float out[MESH_WIDTH])
{
    mesh_lanes own[3], away[3], normal[3], slack = floats_of(o->slack), half = floats_of(o->half);
    for (int k = 0; k < 3; k++) {
        own[k] = floats_load(n->normal[k]);
        away[k] = floats_load(n->centre[k]) - floats_of(o->centre[k]);
    }
    floats_spread(o->normal, normal);
    mesh_lanes up = floats_abs(floats_dots(away, normal)), along = floats_abs(floats_dots(own, normal));
    mesh_lanes side_0[3] = {floats_load(n->side[0][0]), floats_load(n->side[0][1]), floats_load(n->side[0][2])};
    mesh_lanes side_1[3] = {floats_load(n->side[1][0]), floats_load(n->side[1][1]), floats_load(n->side[1][2])};
    mesh_lanes own_half = floats_load(n->half), own_up = floats_abs(floats_dots(away, own));
    mesh_lanes length = floats_sqrt(floats_max(floats_dots(away, away), floats_of(0x1p-100f)));
    mesh_lanes halves =
        floats_abs(floats_dots(away, side_0)) + floats_abs(floats_dots(away, side_1)) + own_up * own_half;
    halves += floats_abs(floats_dot(away, o->side[0])) + floats_abs(floats_dot(away, o->side[1])) + up * half;
    bound = floats_max(bound, length - halves / length);
    near &= floats_not_above(bound - slack, floats_of(limit));
    if (!near) return 0;
    mesh_lanes mine = floats_abs(floats_dot(own, o->side[0])) + floats_abs(floats_dot(own, o->side[1])) + along * half;
    mesh_lanes its =
        floats_abs(floats_dots(side_0, normal)) + floats_abs(floats_dots(side_1, normal)) + along * own_half;
    bound = floats_max(bound, floats_max(own_up - own_half - mine, up - its - half)) - slack;
    memcpy(out, &bound, sizeof bound);
    return near & floats_not_above(bound, floats_of(limit));
}

/* Bounds that are known already (without slack), and which boxes are near by them, or by further ones along these
 * directions: the lines between the centres, the boxes' normals, and the other's normal or its sides (a box's own sides
 * are orthogonal to its normal but for 2^-21 of them, which the slack has room for). As mesh_bounds. */
LANES_INLINE unsigned mesh_bounds_from(
    const mesh_node *n, const mesh_other *o, mesh_lanes bound, unsigned near, float limit, float out[MESH_WIDTH])
{
    mesh_lanes own[3], away[3], slack = floats_of(o->slack);
    for (int k = 0; k < 3; k++) {
        own[k] = floats_load(n->normal[k]);
        away[k] = floats_load(n->centre[k]) - floats_of(o->centre[k]);
    }
    mesh_lanes length = floats_sqrt(floats_max(floats_dots(away, away), floats_of(0x1p-100f)));
    mesh_lanes between = length - (mesh_halves(n, away) + other_halves(o, away)) / length;
    bound = floats_max(bound, between);
    near &= floats_not_above(bound - slack, floats_of(limit));
    if (!near) return 0;
    mesh_lanes mine = floats_abs(floats_dots(away, own)) - floats_load(n->half) - other_halves(o, own);
    bound = floats_max(bound, mine);
    if (o->flat) {
        mesh_lanes normal[3];
        floats_spread(o->normal, normal);
        mesh_lanes its = floats_abs(floats_dots(away, normal)) - mesh_halves(n, normal) - floats_of(o->half);
        bound = floats_max(bound, its);
    } else {
        if (!(near & floats_not_above(bound - slack, floats_of(limit)))) return 0;
        bound = floats_max(bound, mesh_beyond(n, o, away));
    }
    bound -= slack;
    memcpy(out, &bound, sizeof bound);
    return near & floats_not_above(bound, floats_of(limit));
}

/* Lower bounds of the distances between the boxes and the other, along the given axis and those directions. Bit k of
 * what is returned: that of box k is not above `limit`; when no bit is left, no further direction is tried. */
LANES_INLINE unsigned mesh_bounds(
    const mesh *m, const mesh_node *n, const mesh_other *o, float limit, float out[MESH_WIDTH])
{
    mesh_lanes bound = floats_of(-INFINITY);
    unsigned near = (1u << n->used) - 1;
    if (o->aimed) {
        bound = mesh_lows(m, n, o->axis) - floats_of(o->level);
        near &= floats_not_above(bound - floats_of(o->slack), floats_of(limit));
        if (!near) return 0;
    }
    return mesh_bounds_from(n, o, bound, near, limit, out);
}

#endif
