/* capsule_box: the formula of a capsule and a box. Pure; any thread.
 *
 * The capsule's core is a segment x(s) = c + s d, |s| <= h, seen from the box. The square of its distance from the box
 * is convex in s; its slope, d.beyond with beyond = x - (the box's point nearest to x), is linear between the places
 * where the segment crosses planes of faces. Newton's method ends on the piece where it is zero, or at an end. Along n
 * = -beyond / |beyond| the box has no point farther than that nearest one (n is zero where x is between two faces), the
 * segment is farther by |n.d| (h -+ s) at its end: so |beyond| less that is a lower bound, whatever led to s.
 *
 * A segment in the box: B - A has the faces of B, and those that an edge of B and the segment span; the greatest
 * separation along these six is minus the depth.
 *
 * Rounding, in u = 2^-53. A matrix is off by less than 6.5 u (the most seen in 2 10^7 is 6.15 u; test_primitive_boxes),
 * t by 1 u, its product with a matrix by 3.7 u (1 u of each product, of which a row has 5/3 at most, and 1 u of each
 * sum). With h the half length, g the half diagonal of the box, e <= |t| the gap: hi: c by 6.5 + 4.7 of |t|; d by 13
 * + 3.7, times s, of which |s| <= h, |s| <= |t| + g and, but for g, s^2 + e^2 <= |t|^2; x by |s| + e + g, |beyond|
 * by 3.5 e and set_bounds by 2 e: 11.2 |t| + 17.7 |s| + 6.5 e + g, less than 16 (|t| + h + g) + 2 e. lo, along the
 * matrix times n: the box's height by 6.5 g, the segment's by (6.5 + 3.7) h, t by 4.7 |t|, x by |s| + e
 *     + g, |beyond| by 3.5 e and set_bounds by 2 e, the length of the axis by 6.5 e, |n.d| by 3, times h -+ s: 4.7 |t|
 * + 13 e + 7.5 g + 13.2 h + 4 |s|, less than 16 (|t| + h + g) + 2 e. An overlap: c and d as for hi, times 1 and h, and
 * 3 of each along an axis: 14.2 |t| + 19.7 h + 3 g. The error is 20 of them all there. */
#include "primitive_pair.h"

enum { NEWTON_MAX = 6 };

#define PARALLEL2 0x1p-120 /* less than 2^-60 h is lost by it */
#define TOUCHING 0x1p-60   /* sizes: cores that are nearer to each other touch, for all that is known here */

/* The segment in the box's frame, and the box's sides. */
typedef struct beam {
    vec3 c, d, box;
    double half, touching2; /* the latter: the square of a distance that is none */
} beam;

/* A place on the segment: how far it is outside of the box, by coordinates, and the slope of half the square. */
typedef struct beam_place {
    double s, slope;
    vec3 beyond;
} beam_place;

INLINE double beyond_of(double x, double half)
{
    return x - clamp_to(x, half);
}

INLINE beam_place capsule_box_place_at(const beam *g, double s)
{
    vec3 x = vec_madd(g->c, s, g->d);
    vec3 beyond = {beyond_of(x.x, g->box.x), beyond_of(x.y, g->box.y), beyond_of(x.z, g->box.z)};
    return (beam_place){s, vec_dot(g->d, beyond), beyond};
}

/* d, in the coordinates in which the place is outside. */
INLINE vec3 outer_part(const beam *g, vec3 beyond)
{
    return vec(beyond.x != 0 ? g->d.x : 0, beyond.y != 0 ? g->d.y : 0, beyond.z != 0 ? g->d.z : 0);
}

/* By how much the segment is nearer to the box at an end than at the place, along the line there, times its length. */
INLINE double missed_by(const beam *g, const beam_place *at)
{
    return at->slope > 0 ? at->slope * (g->half + at->s) : -at->slope * (g->half - at->s);
}

/* To within `close`, or touching. */
INLINE bool is_nearest(const beam *g, const beam_place *at, double close)
{
    double missed = missed_by(g, at), norm2 = vec_norm2(at->beyond);
    return missed * missed <= close * close * norm2 || norm2 <= g->touching2;
}

/* Where the slope is zero on the piece that is outside as both ends are; in the middle where it is nowhere zero. */
INLINE double capsule_box_between(const beam *g, vec3 beyond)
{
    vec3 outer = outer_part(g, beyond),
         from = vec(g->c.x - copysign(g->box.x, beyond.x), g->c.y - copysign(g->box.y, beyond.y),
             g->c.z - copysign(g->box.z, beyond.z));
    double bend = vec_norm2(outer);
    return bend > 0 ? -vec_dot(outer, from) / bend : 0;
}

/* The nearest place: an end; or from between both on. False when not found soon. */
INLINE bool find_place(const beam *g, double close, beam_place *at)
{
    const beam_place low = capsule_box_place_at(g, -g->half), high = capsule_box_place_at(g, g->half);
    *at = low.slope >= 0 ? low : high;
    if ((low.slope >= 0) | (high.slope <= 0)) return true;
    *at = capsule_box_place_at(g, clamp_to(capsule_box_between(g, vec_add(low.beyond, high.beyond)), g->half));
    for (int i = 0; i < NEWTON_MAX; i++) {
        if (is_nearest(g, at, close)) return true;
        *at = capsule_box_place_at(g, clamp_to(at->s - at->slope / vec_norm2(outer_part(g, at->beyond)), g->half));
    }
    return is_nearest(g, at, close);
}

/* The segment's point and the box's face each other along n, unit, in the box's frame, from the segment to the box. */
typedef struct gap {
    double lo, hi, s;
    vec3 n;
} gap;

INLINE gap capsule_box_gap_at(const beam *g, const beam_place *at)
{
    double norm2 = vec_norm2(at->beyond), length = sqrt(norm2), per = length * (1 / norm2);
    return (gap){length - missed_by(g, at) * per, length, at->s, vec_scale(at->beyond, -per)};
}

/* Near the box the slope is lost in the rounding of x: the line is made orthogonal to the segment instead, in the
 * coordinates in which x is outside. False where that would turn it to another side of the box. */
__attribute__((noinline, cold)) static bool squared_gap(const beam *g, const beam_place *at, gap *out)
{
    vec3 outer = outer_part(g, at->beyond), v = at->beyond;
    double bend = vec_norm2(outer);
    if (!(bend > 0)) return false;
    v = vec_madd(v, -vec_dot(v, outer) / bend, outer);
    v = vec_madd(v, -vec_dot(v, outer) / bend, outer);
    if (v.x * at->beyond.x < 0 || v.y * at->beyond.y < 0 || v.z * at->beyond.z < 0) return false;
    const vec3 line = direction_of(v);
    const beam_place there = {at->s, vec_dot(g->d, line), line};
    *out = (gap){vec_dot(line, at->beyond) - missed_by(g, &there), vec_norm(at->beyond), at->s, vec_neg(line)};
    return vec_norm2(line) > 0.5;
}

/* ---- the segment in the box ---- */

/* The greatest separation along the six axes; face 0 to 2, or 3 + the edge of the box. */
typedef struct parting {
    double by;
    int index;
} parting;

typedef struct beam_arrays {
    double c[3], d[3], box[3], half;
} beam_arrays;

INLINE void capsule_box_try_face(const beam_arrays *g, int j, parting *best)
{
    double by = fabs(g->c[j]) - g->box[j] - fabs(g->d[j]) * g->half;
    if (by > best->by) *best = (parting){by, j};
}

/* Along (0, -d_l, d_k), of which the product with d is zero to the last bit. */
INLINE void capsule_box_try_edge(const beam_arrays *g, int j, parting *best)
{
    int k = (j + 1) % 3, l = (j + 2) % 3;
    double dk = g->d[k], dl = g->d[l], norm2 = dk * dk + dl * dl;
    double by = fabs(dk * g->c[l] - dl * g->c[k]) - (fabs(dl) * g->box[k] + fabs(dk) * g->box[l]);
    bool less = by < 0 && best->by < 0 && by * by >= best->by * best->by * norm2;
    if (less || !(norm2 > PARALLEL2)) return;
    by /= sqrt(norm2);
    if (by > best->by) *best = (parting){by, 3 + j};
}

/* The points that face each other along a face's normal: an end of the segment; where that is beside the face, they
 * are to be found elsewhere. */
INLINE bool meet_face(const beam_arrays *g, int j, double slack, double n[3], double *s)
{
    int k = (j + 1) % 3, l = (j + 2) % 3;
    n[j] = g->c[j] > 0 ? -1 : 1;
    *s = copysign(g->half, n[j] * g->d[j]);
    return fabs(g->c[k] + *s * g->d[k]) <= g->box[k] + slack && fabs(g->c[l] + *s * g->d[l]) <= g->box[l] + slack;
}

/* The same of an edge: the nearest points of the two lines. */
INLINE bool meet_edge(const beam_arrays *g, int j, double slack, double n[3], double *s)
{
    int k = (j + 1) % 3, l = (j + 2) % 3;
    double dk = g->d[k], dl = g->d[l], per = 1 / sqrt(dk * dk + dl * dl);
    if (dk * g->c[l] > dl * g->c[k]) per = -per;
    n[k] = -dl * per, n[l] = dk * per;
    double wk = copysign(g->box[k], -n[k]) - g->c[k], wl = copysign(g->box[l], -n[l]) - g->c[l];
    *s = (wk * dk + wl * dl) * (per * per);
    return fabs(*s) <= g->half + slack && fabs(g->c[j] + *s * g->d[j]) <= g->box[j] + slack;
}

__attribute__((noinline, cold)) static bool capsule_box_depth_of(const beam *of, double slack, gap *out)
{
    const beam_arrays g = {
        {of->c.x, of->c.y, of->c.z}, {of->d.x, of->d.y, of->d.z}, {of->box.x, of->box.y, of->box.z}, of->half};
    parting best = {-INFINITY, 0};
    for (int j = 0; j < 3; j++) capsule_box_try_face(&g, j, &best);
    for (int j = 0; j < 3; j++) capsule_box_try_edge(&g, j, &best);
    double n[3] = {0, 0, 0}, s;
    if (!(best.by < -0x1p-8 * slack)) return false; /* touching */
    bool met = best.index < 3 ? meet_face(&g, best.index, slack, n, &s) : meet_edge(&g, best.index - 3, slack, n, &s);
    *out = (gap){best.by, best.by, clamp_to(s, g.half), vec(n[0], n[1], n[2])};
    return met;
}

bool capsule_beside_box(primitive_pair *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    if (!is_in_range(q, &p)) return false;
    const beam g = {vec_neg(mat_tmul(q->turn_b, p.b_in_a.t)), mat_tmul(q->turn_b, q->along_a),
        vec_scale(q->b->half, p.scale), q->a->half.z * p.scale, TOUCHING * TOUCHING * p.size * p.size};
    beam_place at;
    gap found;
    double close = 0.25 * p.error;
    bool there = find_place(&g, close, &at);
    if (!(vec_norm2(at.beyond) > g.touching2)) {
        p.error *= 1.25;
        if (!capsule_box_depth_of(&g, p.error, &found)) return false;
    } else {
        found = capsule_box_gap_at(&g, &at);
        if (!there && !squared_gap(&g, &at, &found)) return false;
        if (!(found.hi - found.lo <= close)) return false;
        p.error += 2 * UNIT_ROUNDOFF * found.hi;
    }
    vec3 n = mat_mul(q->turn_b, found.n), towards = n;
    span s = {.lo = found.lo, .hi = found.hi, .method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    s.axis = direction_again(n);
    s.point_a = vec_scale(q->along_a, found.s);
    s.point_b = vec_madd(s.point_a, found.hi, n);
    return end(q, &p, &s, towards, out);
}
