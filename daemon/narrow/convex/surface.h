/* surface: a closed surface of triangles between points of B - A around the origin, that grows: the machine of
 * polytope_depth.c. At most 64 points; facets in columns, looked at side by side; which facet is
 * left of a directed edge stands in a table. Inlined into functions of LANES_WIDE and others. Pure; any thread. About
 * 20 kB on the caller's stack. */
#ifndef COLLIDED_NARROW_CONVEX_SURFACE_H
#define COLLIDED_NARROW_CONVEX_SURFACE_H

#include "geom/simd.h"
#include "gjk.h"
#include "narrow/math/scalar.h"

#include <string.h>

/* Places for facets come in blocks, so that the loops over them run a number of rounds that can be foreseen. */
enum { POINTS_MAX = 64, FACETS_MAX = 2 * POINTS_MAX, HORIZON_MAX = POINTS_MAX, BLOCK = 4 * LANES, NONE = -1 };

/* As in epa.c: a triangle with a greater sine (squared) has a normal that is sure to 1e-10, so that its plane less the
 * slack is never farther from the origin than it. Slivers are left to epa.c. */
#define SURE_SINE2 1e-8
#define PLANE_SLACK 1e-9

/* Columns of facets. A place where none lives has the offset INFINITY: nothing sees it, and it is never the nearest. */
typedef struct surface {
    double nx[FACETS_MAX], ny[FACETS_MAX], nz[FACETS_MAX]; /* unit, outward */
    double offset[FACETS_MAX];                             /* of the plane, from the origin */
    double bound[FACETS_MAX]; /* no more than the distance of the facet; INFINITY when it is final, too */
    uint8_t corner[FACETS_MAX][3];
    uint8_t left_of[POINTS_MAX][POINTS_MAX]; /* the facet that has the directed edge */
    minkowski point[POINTS_MAX];
    int point_count, facet_count; /* facet_count: of places, with some where none lives any more */
    bool star;                    /* it need not be convex: every facet must have the origin on its inner side */
} surface;

/* Directed edges with the seen facets on their left. */
typedef struct horizon {
    int count;
    uint8_t from[HORIZON_MAX], to[HORIZON_MAX];
} horizon;

typedef struct facets {
    uint64_t word[FACETS_MAX / 64];
} facets;

static inline bool has(const facets *set, int f)
{
    return set->word[f >> 6] >> (f & 63) & 1;
}

/* Of all facets, by columns: those whose plane the point is above by more than eps. */
LANES_INLINE facets seen_by(const surface *s, vec3 w, double eps)
{
    facets seen = {{0}};
    lanes3 at = {lanes_of(w.x), lanes_of(w.y), lanes_of(w.z)};
    for (int block = 0; block < s->facet_count; block += BLOCK) {
        uint64_t bits = 0;
        for (int k = 0; k < BLOCK; k += LANES) {
            int i = block + k;
            lanes3 n = {lanes_load(s->nx + i), lanes_load(s->ny + i), lanes_load(s->nz + i)};
            lane_mask above = lanes3_dot(n, at) - lanes_load(s->offset + i) > lanes_of(eps);
            bits |= (uint64_t)lanes_bits(above) << k;
        }
        seen.word[block >> 6] |= bits << (block & 63);
    }
    return seen;
}

/* One by one: the bounds of a new cone are on their way to the cache, which a wider load would have to wait for. */
LANES_INLINE double least_bound(const surface *s)
{
    double least[LANES] = {INFINITY, INFINITY, INFINITY, INFINITY};
    for (int block = 0; block < s->facet_count; block += BLOCK)
        for (int i = block; i < block + BLOCK; i += LANES)
            for (int k = 0; k < LANES; k++) least[k] = min_of(least[k], s->bound[i + k]);
    return min_of(min_of(least[0], least[1]), min_of(least[2], least[3]));
}

/* The first facet with that bound. */
LANES_INLINE int nearest_of(const surface *s, double bound)
{
    for (int block = 0;; block += BLOCK) {
        unsigned bits = 0;
        for (int k = 0; k < BLOCK; k += LANES)
            bits |= lanes_bits(lanes_load(s->bound + block + k) <= lanes_of(bound)) << k;
        if (bits) return block + __builtin_ctz(bits);
    }
}

LANES_INLINE void clear_block(surface *s, int block)
{
    for (int i = block; i < block + BLOCK; i += LANES) {
        lanes_store(s->nx + i, lanes_of(0));
        lanes_store(s->ny + i, lanes_of(0));
        lanes_store(s->nz + i, lanes_of(0));
        lanes_store(s->offset + i, lanes_of(INFINITY));
        lanes_store(s->bound + i, lanes_of(INFINITY));
    }
}

/* A place of those that were seen, or a new one. */
LANES_INLINE int next_place(surface *s, facets *seen)
{
    for (int w = 0; w < FACETS_MAX / 64; w++)
        if (seen->word[w]) {
            int f = 64 * w + __builtin_ctzll(seen->word[w]);
            seen->word[w] &= seen->word[w] - 1;
            return f;
        }
    if (s->facet_count == FACETS_MAX) return NONE;
    if (s->facet_count % BLOCK == 0) clear_block(s, s->facet_count);
    return s->facet_count++;
}

/* Planes of the cone from a point over the horizon. `sure`: -1, or 0 of a sliver: see SURE_SINE2. */
typedef struct planes {
    double nx[HORIZON_MAX], ny[HORIZON_MAX], nz[HORIZON_MAX], offset[HORIZON_MAX];
    int64_t sure[HORIZON_MAX];
} planes;

LANES_INLINE lanes3 gather(const surface *s, const uint8_t index[LANES])
{
    vec3 a = s->point[index[0]].w, b = s->point[index[1]].w, c = s->point[index[2]].w, d = s->point[index[3]].w;
    return (lanes3){{a.x, b.x, c.x, d.x}, {a.y, b.y, c.y, d.y}, {a.z, b.z, c.z, d.z}};
}

/* Four triangles u, v, apex: unit normals by the cross product of the two shortest edges (the longest carries the most
 * rounding). */
LANES_INLINE void four_planes(lanes3 u, lanes3 v, lanes3 apex, int i, planes *out)
{
    lanes3 uv = lanes3_sub(v, u), va = lanes3_sub(apex, v), au = lanes3_sub(u, apex);
    lanes uv2 = lanes3_dot(uv, uv), va2 = lanes3_dot(va, va), au2 = lanes3_dot(au, au);
    lane_mask uv_longest = (uv2 >= va2) & (uv2 >= au2), va_longest = ~uv_longest & (va2 >= au2);
    lanes3 first = lanes3_choose(uv_longest, va, lanes3_choose(va_longest, au, uv));
    lanes3 second = lanes3_choose(uv_longest, au, lanes3_choose(va_longest, uv, va));
    lanes3 n = lanes3_cross(first, second);
    lanes n2 = lanes3_dot(n, n), norm = lanes_sqrt(n2);
    n.x /= norm, n.y /= norm, n.z /= norm;
    lanes_store(out->nx + i, n.x);
    lanes_store(out->ny + i, n.y);
    lanes_store(out->nz + i, n.z);
    lanes_store(out->offset + i, lanes3_dot(n, apex));
    lane_mask sure = n2 > lanes3_dot(first, first) * lanes3_dot(second, second) * lanes_of(SURE_SINE2);
    memcpy(out->sure + i, &sure, sizeof sure);
}

/* The horizon is filled up to a multiple of LANES with edges that there are. */
LANES_INLINE void cone_planes(const surface *s, const horizon *h, vec3 apex, planes *out)
{
    lanes3 at = {lanes_of(apex.x), lanes_of(apex.y), lanes_of(apex.z)};
    for (int i = 0; i < h->count; i += LANES) four_planes(gather(s, h->from + i), gather(s, h->to + i), at, i, out);
}

LANES_INLINE bool put_facet(surface *s, facets *places, int u, int v, int w, const planes *planes, int i)
{
    int f = next_place(s, places);
    if (f == NONE || !planes->sure[i] || (s->star && !(planes->offset[i] > 0))) return false;
    s->nx[f] = planes->nx[i], s->ny[f] = planes->ny[i], s->nz[f] = planes->nz[i];
    s->offset[f] = planes->offset[i];
    s->bound[f] = planes->offset[i] - PLANE_SLACK;
    s->corner[f][0] = (uint8_t)u, s->corner[f][1] = (uint8_t)v, s->corner[f][2] = (uint8_t)w;
    s->left_of[u][v] = s->left_of[v][w] = s->left_of[w][u] = (uint8_t)f;
    return true;
}

/* The facets from a point over all edges of the horizon, in the places of those that were seen. */
LANES_INLINE bool put_cone(surface *s, facets *seen, horizon *h, int apex)
{
    planes planes;
    for (int i = h->count; i % LANES; i++) h->from[i] = h->from[0], h->to[i] = h->to[0];
    cone_planes(s, h, s->point[apex].w, &planes);
    for (int i = 0; i < h->count; i++)
        if (!put_facet(s, seen, h->from[i], h->to[i], apex, &planes, i)) return false;
    for (int w = 0; w < FACETS_MAX / 64; w++)
        for (uint64_t rest = seen->word[w]; rest; rest &= rest - 1) {
            int f = 64 * w + __builtin_ctzll(rest);
            s->offset[f] = s->bound[f] = INFINITY;
        }
    return true;
}

LANES_INLINE bool start_tetrahedron(surface *s, const simplex *from)
{
    s->star = false;
    s->facet_count = 0;
    s->point_count = 4;
    for (int i = 0; i < 4; i++) s->point[i] = from->v[i];
    vec3 p0 = s->point[0].w, n = vec_cross(vec_sub(s->point[1].w, p0), vec_sub(s->point[2].w, p0));
    /* 2 and 3 see the facet a, b, . counter-clockwise from outside */
    uint8_t a = vec_dot(n, vec_sub(s->point[3].w, p0)) > 0, b = !a;
    facets none = {{0}};
    horizon h;
    h.count = 3;
    h.from[0] = h.to[2] = a, h.from[1] = h.to[0] = 2, h.from[2] = h.to[1] = b;
    if (!put_cone(s, &none, &h, 3)) return false;
    h.count = 1;
    h.from[0] = a, h.to[0] = b;
    return put_cone(s, &none, &h, 2);
}

/* Is the horizon of so many facets with these corners the rim of one disc? Each of its points begins one edge and ends
 * one, and Euler's formula holds. */
static inline bool is_rim(const horizon *h, int facets_seen, uint64_t corners, uint64_t from, uint64_t to)
{
    int inside = __builtin_popcountll(corners & ~from);
    return from == to && __builtin_popcountll(from) == h->count && h->count == facets_seen - 2 * inside + 2;
}

LANES_INLINE bool find_horizon(const surface *s, const facets *seen, horizon *h)
{
    uint64_t corners = 0, from = 0, to = 0;
    int count = 0, facets_seen = 0;
    for (int w = 0; w < FACETS_MAX / 64; w++)
        for (uint64_t rest = seen->word[w]; rest; rest &= rest - 1) {
            const uint8_t *c = s->corner[64 * w + __builtin_ctzll(rest)];
            facets_seen++;
            if (count > HORIZON_MAX - 3) return false;
            for (int k = 0; k < 3; k++) { /* without a branch: whether an edge is on the horizon is anybody's guess */
                int u = c[k], v = c[k == 2 ? 0 : k + 1];
                uint64_t on = !has(seen, s->left_of[v][u]);
                h->from[count] = (uint8_t)u, h->to[count] = (uint8_t)v;
                count += (int)on;
                from |= on << u, to |= on << v, corners |= (uint64_t)1 << u;
            }
        }
    h->count = count;
    return count >= 3 && is_rim(h, facets_seen, corners, from, to);
}

/* Replaces what the newest point sees by the cone from it over the horizon. False: what is left is of no use. `eps`: a
 * point that is no farther out than this is on the facet. */
LANES_INLINE bool expand(surface *s, double eps)
{
    horizon h;
    int apex = s->point_count++;
    facets seen = seen_by(s, s->point[apex].w, eps);
    return s->point_count < POINTS_MAX && find_horizon(s, &seen, &h) && put_cone(s, &seen, &h, apex);
}

/* The distance of the triangle itself: what its plane's is, only more certain. */
static inline double measure(const surface *s, int f, double weight[3])
{
    const uint8_t *c = s->corner[f];
    vec3 normal, axis;
    return triangle_nearest(s->point[c[0]].w, s->point[c[1]].w, s->point[c[2]].w, weight, &normal, &axis);
}

#endif
