/* Marching a separating plane. The corners w_i(t) = (1 - t) w_i(0) + t w_i(1) of the polygon of differences move along
 * lines, so d . w_i(t) is linear in t for a fixed direction d: where it exceeds the separation, times |d|, at both ends
 * of an interval and for every corner, the whole interval is free. d may be any direction, however sloppy; only the
 * products are proved. So: take d towards the polygon at t, go to the time at which it stops to separate, repeat. A
 * fixed direction gains only a constant factor a step where a face turns about the point of contact; one that turns
 * linearly from d to e has products quadratic in t, which are proved by their Bernstein coefficients, and gains
 * quadratically. A hit takes about six steps.
 *
 * Rounding, u = 2^-53. All differences are divided by a power of two such that none exceeds 1. A difference is off by u
 * of itself, a product by u, the sum of three by 2 u, the interpolation in t by 3 u: together below 8 u sum |d_k| max
 * |w_k|, max over corners and both ends. We ask for 16 u of it, which covers the rounding of the bound as well, and for
 * 2^-1000 against underflow. */
#include "elementary.h"

#include "narrow/math/scalar.h"

#include <float.h>
#include <stdbool.h>

#define PRODUCT_BOUND 0x1p-49 /* 16 u, see above */
#define UNDERFLOW 0x1p-1000   /* some 2^-1074 are lost below the smallest number, times |d| <= 8 */
/* A point of the polygon at t, for |w| <= 1: corners are off by 5 u, edges (up to 2) by 12 u, w0 + a e1 + b e2 with
 * a, b >= 0 of a sum <= 2 by less than 5 + 2 * 12 + 8 = 37 u a coordinate, so 64 u of the norm; twice that is taken. */
#define POINT_BOUND 0x1p-46
/* w0 . (w1 x w2): 6 products of 3 numbers <= 1 off by 5 u are off by 90 u, the operations add 30 u; twice that. */
#define VOLUME_BOUND 0x1p-45
/* n . (x x y), |n| = 1: coordinates of the cross product off by 24 u, by sqrt(3), and 11 u of operations: 53 u. */
#define AREA_BOUND 0x1p-46
enum { CREEP_MAX = 1 };     /* steps from within twice POINT_BOUND of contact; each gains less than the one before */
enum { VERDICT_STEPS = 2 }; /* most pairs that are free are so by then, and few that meet are found */
#define GREATEST 0x1p1000   /* differences beyond are not looked at */

typedef struct moving { /* the polygon of differences, scaled to at most 1; not cleared: only its corners are set */
    vec3 start[4], end[4];
    int corners; /* 3, or 4 of a parallelogram, in cyclic order */
    vec3 most;   /* greatest |coordinate| on each axis */
    double separation, until;
    bool verdict;
    bool met,
        meets;    /* corners of both are one point at the start, at the end; before scaling, which may lose a little */
    int exponent; /* lengths are in units of 2^exponent m */
} moving;

typedef enum part { PART_CORNER, PART_EDGE, PART_FACE } part;

typedef struct nearest { /* the point of the polygon that is nearest to the origin, up to rounding */
    vec3 point;          /* w0 + along (w1 - w0) + across (w_last - w0) */
    double along, across;
    part part;
    int index; /* of the corner, or of the edge's first corner */
} nearest;

/* ---- the polygon ---- */

static vec3 between(vec3 a, vec3 b, double t)
{
    return vec_add(vec_scale(a, 1 - t), vec_scale(b, t));
}

static vec3 corner_at(const moving *m, int i, double t)
{
    return between(m->start[i], m->end[i], t);
}

static vec3 combine(vec3 w0, vec3 w1, vec3 last, double along, double across)
{
    return vec_madd(vec_madd(w0, along, vec_sub(w1, w0)), across, vec_sub(last, w0));
}

static double share(double part_of, double whole)
{
    return whole > 0 ? clamp_to(part_of / whole - 0.5, 0.5) + 0.5 : 0;
}

/* A triangle without area, as good as: the nearest of its edges. */
static void nearest_of_edges(const vec3 w[3], nearest *out)
{
    double least = INFINITY;
    for (int i = 0; i < 3; i++) {
        vec3 from = w[i], e = vec_sub(w[(i + 1) % 3], from);
        double x = share(-vec_dot(from, e), vec_norm2(e)), distance2 = vec_norm2(vec_madd(from, x, e));
        if (!(distance2 < least)) continue;
        least = distance2;
        *out = (nearest){.part = x > 0 && x < 1 ? PART_EDGE : PART_CORNER, .index = x < 1 ? i : (i + 1) % 3};
        out->along = i == 0 ? x : i == 1 ? 1 - x : 0;
        out->across = i == 0 ? 0 : i == 1 ? x : 1 - x;
    }
}

/* The regions of a triangle, as in Ericson, Real-Time Collision Detection, 5.1.5. */
static void nearest_in_triangle(const vec3 w[3], nearest *out)
{
    vec3 e1 = vec_sub(w[1], w[0]), e2 = vec_sub(w[2], w[0]);
    double d1 = -vec_dot(e1, w[0]), d2 = -vec_dot(e2, w[0]), d3 = -vec_dot(e1, w[1]), d4 = -vec_dot(e2, w[1]);
    double d5 = -vec_dot(e1, w[2]), d6 = -vec_dot(e2, w[2]);
    double a = d1 - d3, b = d2 - d4, c = d2 - d6; /* e1 . e1, e1 . e2, e2 . e2 */
    if (!(a * c - b * b > 0x1p-40 * (a * c))) return nearest_of_edges(w, out);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    *out = (nearest){.part = PART_CORNER, .index = 0};
    if (d1 <= 0 && d2 <= 0) return;
    if (d3 >= 0 && d4 <= d3) {
        out->index = 1, out->along = 1;
    } else if (d6 >= 0 && d5 <= d6) {
        out->index = 2, out->across = 1;
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        out->part = PART_EDGE, out->along = share(d1, d1 - d3);
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        out->part = PART_EDGE, out->index = 2, out->across = share(d2, d2 - d6);
    } else if (va <= 0 && d4 >= d3 && d5 >= d6) {
        out->part = PART_EDGE, out->index = 1;
        out->across = share(d4 - d3, d4 - d3 + (d5 - d6)), out->along = 1 - out->across;
    } else {
        out->part = PART_FACE;
        out->along = share(vb, va + vb + vc), out->across = min_of(share(vc, va + vb + vc), 1 - out->along);
    }
}

/* Two segments, as in Ericson, 5.1.9: least |w0 + along e1 + across e2|, both within [0, 1]. */
static void nearest_in_parallelogram(const vec3 w[4], nearest *out)
{
    vec3 e1 = vec_sub(w[1], w[0]), e2 = vec_sub(w[3], w[0]);
    double a = vec_norm2(e1), b = vec_dot(e1, e2), c = vec_norm2(e2);
    double d = vec_dot(e1, w[0]), f = vec_dot(e2, w[0]), determinant = a * c - b * b;
    double along = determinant > 0x1p-46 * (a * c) ? share(b * f - c * d, determinant) : share(-d, a);
    double across = share(-f - b * along, c);
    if (across <= 0 || across >= 1) along = share(-d - b * across, a);
    bool inner1 = along > 0 && along<1, inner2 = across> 0 && across < 1;
    *out = (nearest){.along = along, .across = across};
    if (inner1 && inner2)
        out->part = PART_FACE;
    else if (inner1)
        out->part = PART_EDGE, out->index = across < 1 ? 0 : 2;
    else if (inner2)
        out->part = PART_EDGE, out->index = along < 1 ? 3 : 1;
    else
        out->part = PART_CORNER, out->index = along < 1 ? (across < 1 ? 0 : 3) : (across < 1 ? 1 : 2);
}

static nearest nearest_at(const moving *m, double t)
{
    nearest n;
    vec3 w[4];
    for (int i = 0; i < m->corners; i++) w[i] = t > 0 ? corner_at(m, i, t) : m->start[i];
    if (m->corners == 3)
        nearest_in_triangle(w, &n);
    else
        nearest_in_parallelogram(w, &n);
    n.point = combine(w[0], w[1], w[m->corners - 1], n.along, n.across);
    return n;
}

/* The distance at the time of n is at most this, in units of 2^exponent. */
static double distance_bound(const nearest *n)
{
    return vec_norm(n->point) * (1 + 0x1p-50) + POINT_BOUND;
}

/* ---- directions ---- */

/* From the origin to the line through corner i and the next one, made orthogonal to it a second time: a point near
 * contact is all rounding error, its component along the edge too. */
static vec3 edge_axis(const moving *m, int i, double t)
{
    vec3 w = corner_at(m, i, t), e = vec_sub(corner_at(m, (i + 1) % m->corners, t), w);
    double ee = vec_norm2(e);
    if (!(ee > 0)) return w;
    w = vec_madd(w, -vec_dot(w, e) / ee, e);
    return vec_madd(w, -vec_dot(w, e) / ee, e);
}

static vec3 face_axis(const moving *m, double t)
{
    vec3 w0 = corner_at(m, 0, t);
    return vec_cross(vec_sub(corner_at(m, 1, t), w0), vec_sub(corner_at(m, m->corners - 1, t), w0));
}

static vec3 axis_at(const moving *m, const nearest *n, double t)
{
    if (n->part == PART_FACE) return face_axis(m, t);
    return n->part == PART_EDGE ? edge_axis(m, n->index, t) : corner_at(m, n->index, t);
}

static double product_bound(const moving *m, vec3 d)
{
    return PRODUCT_BOUND * (fabs(d.x) * m->most.x + fabs(d.y) * m->most.y + fabs(d.z) * m->most.z) + UNDERFLOW;
}

static double separation_along(const moving *m, vec3 d)
{
    return m->separation > 0 ? m->separation * vec_norm(d) * (1 + 0x1p-49) : 0;
}

/* The time until which the direction, or its opposite, separates without interruption from t on; proved. -1: not at t.
 */
static double reach(const moving *m, vec3 axis, double t)
{
    double first[4], last[4], until = 1, s = 1 - t;
    double sign = s * vec_dot(axis, m->start[0]) + t * vec_dot(axis, m->end[0]) < 0 ? -1 : 1;
    double bound = product_bound(m, axis), enough = bound + separation_along(m, axis);
    double aim = enough + bound; /* aim at twice the bound, and prove the bound */
    for (int i = 0; i < m->corners; i++) {
        first[i] = sign * vec_dot(axis, m->start[i]), last[i] = sign * vec_dot(axis, m->end[i]);
        if (!(s * first[i] + t * last[i] > enough)) return -1;
        if (!(last[i] > aim)) until = min_of((first[i] - aim) / (first[i] - last[i]), until);
    }
    if (!(until > t)) return t;
    s = 1 - until;
    for (int i = 0; i < m->corners; i++)
        if (!(s * first[i] + until * last[i] > enough)) return t;
    return until;
}

/* ---- a plane that turns ---- */

/* The feature's unit direction at that time, on the side of d. */
static vec3 turned(const moving *m, const nearest *n, double then, vec3 d)
{
    vec3 unit = direction_of(axis_at(m, n, then));
    return vec_dot(unit, d) < 0 ? vec_neg(unit) : unit;
}

/* The direction ((b - t) d + (t - a) e) / (b - a) separates at every t in [a, b]: its product with a corner is a
 * quadratic in t, positive where its Bernstein coefficients are; the separation times its length is at most linear. */
static bool turning_separates(const moving *m, vec3 d, double a, vec3 e, double b)
{
    double need_d = product_bound(m, d) + separation_along(m, d);
    double need_e = product_bound(m, e) + separation_along(m, e);
    for (int i = 0; i < m->corners; i++) {
        vec3 at_a = corner_at(m, i, a), at_b = corner_at(m, i, b);
        if (!(vec_dot(d, at_a) > need_d && vec_dot(e, at_b) > need_e)) return false;
        if (!(vec_dot(d, at_b) + vec_dot(e, at_a) > need_d + need_e)) return false;
    }
    return true;
}

/* Where no fixed direction gets far, as of a face that turns about a point on it, one that turns with the nearest
 * feature does. Up to just before the feature reaches the separation: a Newton step (its velocity along the direction
 * is exact to first order), a secant, and a margin for what that may be off. */
static double reach_turning(const moving *m, const nearest *n, vec3 axis, double t)
{
    int last = m->corners - 1;
    vec3 velocity = combine(vec_sub(m->end[0], m->start[0]), vec_sub(m->end[1], m->start[1]),
        vec_sub(m->end[last], m->start[last]), n->along, n->across);
    vec3 d = direction_of(axis);
    double height = vec_dot(d, corner_at(m, n->index, t));
    if (height < 0) d = vec_neg(d), height = -height;
    double rate = vec_dot(d, velocity);
    height -= m->separation;
    double then = rate < 0 ? min_of(t - height / rate, 1) : 1;
    if (!(then > t)) return -1;
    double rest = vec_dot(turned(m, n, then, d), corner_at(m, n->index, then)) - m->separation, until = 1;
    if (then < 1 || rest <= 2 * product_bound(m, d)) {
        double slope = (height - rest) / (then - t);
        if (!(slope > 0)) return -1;
        double root = t + height / slope;
        until = min_of(root - 0.25 * fabs(root - then) - 3 * product_bound(m, d) / slope, 1);
    }
    for (int tries = 0; tries < 2 && until > t; tries++, until = t + 0.25 * (until - t))
        if (turning_separates(m, d, t, turned(m, n, until, d), until)) return until;
    return -1;
}

/* When the direction of the nearest point fails, or gets no further: all that the polygon offers at t, and the axes. */
static double reach_otherwise(const moving *m, const nearest *n, double t)
{
    double best = max_of(reach(m, n->point, t), reach(m, face_axis(m, t), t));
    for (int i = 0; i < m->corners; i++)
        best = max_of(best, max_of(reach(m, edge_axis(m, i, t), t), reach(m, corner_at(m, i, t), t)));
    best = max_of(best, reach(m, vec(1, 0, 0), t));
    best = max_of(best, reach(m, vec(0, 1, 0), t));
    return max_of(best, reach(m, vec(0, 0, 1), t));
}

/* ---- proofs of contact ---- */

static double volume_at(const moving *m, double t)
{
    return vec_dot(corner_at(m, 0, t), vec_cross(corner_at(m, 1, t), corner_at(m, 2, t)));
}

/* n . (w_i x w_next) has one sign for all corners and all times in [a, b]: its Bernstein coefficients have. */
static bool surrounds(const moving *m, vec3 n, double a, double b)
{
    double sign = 0;
    for (int i = 0; i < m->corners; i++) {
        int k = (i + 1) % m->corners;
        vec3 ia = corner_at(m, i, a), ib = corner_at(m, i, b), ka = corner_at(m, k, a), kb = corner_at(m, k, b);
        double c[3] = {vec_dot(n, vec_cross(ia, ka)),
            0.5 * (vec_dot(n, vec_cross(ia, kb)) + vec_dot(n, vec_cross(ib, ka))), vec_dot(n, vec_cross(ib, kb))};
        if (i == 0) sign = c[0] < 0 ? -1 : 1;
        for (int j = 0; j < 3; j++)
            if (!(sign * c[j] > AREA_BOUND)) return false;
    }
    return true;
}

/* The volume w0 . (w1 x w2) changes its sign between a and b, so it vanishes at some time; and for every n,
 * n volume = sum of (n . (w_j x w_k)) w_i over the cyclic (i, j, k) of three corners. At that time, if these factors
 * are all positive, the origin is a convex combination of the corners. (For the parallelogram w00, w01, w11, w10 the
 * same identity for its two edges and w00 gives both parameters within (0, 1) from its four factors.) */
static bool crosses(const moving *m, vec3 n, double a, double b)
{
    double va = volume_at(m, a), vb = volume_at(m, b);
    return ((va > VOLUME_BOUND && vb < -VOLUME_BOUND) || (va < -VOLUME_BOUND && vb > VOLUME_BOUND)) &&
           surrounds(m, n, a, b);
}

/* Looks for a proof that the separation is reached soon after t; *until = by when. The intervals grow from what the
 * smallest bounds need for a fast body to what a slow one needs. */
static bool prove(const moving *m, double t, double *until)
{
    vec3 n = direction_of(face_axis(m, t));
    for (double width = 0x1p-46; width < 0.1; width *= 0x1p8) {
        double a = max_of(t - width, 0), b = min_of(t + width, 1);
        *until = b;
        if (m->separation > 0x1p-900) {
            nearest at_b = nearest_at(m, b);
            if (distance_bound(&at_b) <= m->separation) return true;
        }
        if (crosses(m, n, a, b)) return true;
    }
    return false;
}

static bool coincident(const moving *m, const vec3 *corners)
{
    for (int i = 0; i < m->corners; i++)
        if (corners[i].x == 0 && corners[i].y == 0 && corners[i].z == 0) return true;
    return false;
}

/* ---- the march ---- */

/* A bound in units of 2^exponent as one in metres; the product may be lost below the smallest number. */
static double in_metres(const moving *m, double x)
{
    int half = m->exponent / 2;
    return x * power_of_two(half) * power_of_two(m->exponent - half) + DBL_TRUE_MIN;
}

/* Comparisons with what is no number are false, so it has separated nowhere, and t is still 0. */
static bool is_number(const moving *m)
{
    bool number = true;
    for (int i = 0; i < m->corners; i++) number = number && vec_finite(m->start[i]) && vec_finite(m->end[i]);
    return number;
}

static void tell_hit(const moving *m, double t, const nearest *n, elementary_result *out)
{
    double gap = distance_bound(n) - m->separation, until;
    out->status = ELEMENTARY_HIT;
    out->t_lo = out->t_hi = t;
    if (!is_number(m)) {
        out->proof = ELEMENTARY_UNDECIDED, out->gap = INFINITY;
    } else if (t <= 0 && (m->met || gap <= 0)) {
        out->proof = ELEMENTARY_CERTAIN, out->gap = 0;
    } else if (prove(m, t, &until)) {
        out->proof = ELEMENTARY_CERTAIN, out->gap = 0, out->t_hi = until;
    } else if (m->meets) {
        out->proof = ELEMENTARY_CERTAIN, out->gap = 0, out->t_hi = 1;
    } else {
        gap += 0x1p-52 * m->separation; /* of the difference above */
        out->proof = gap <= ELEMENTARY_NEAR / 2 ? ELEMENTARY_WITHIN : ELEMENTARY_UNDECIDED; /* the extent is >= 1/2 */
        out->gap = in_metres(m, gap);
    }
}

/* Halves the way towards a change of sign of the volume until the corners are proven to surround the origin all through
 * what is left: a contact, whenever. False: not shown so, which says nothing. */
static bool meets_on_the_way(const moving *m, double a, double *until)
{
    enum { HALVINGS = 4 };
    double b = 1, va = volume_at(m, a), vb = volume_at(m, b);
    if (!((va > VOLUME_BOUND && vb < -VOLUME_BOUND) || (va < -VOLUME_BOUND && vb > VOLUME_BOUND))) return false;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = 0.5 * (a + b), v = volume_at(m, middle);
        vec3 n = direction_of(face_axis(m, middle));
        if (surrounds(m, n, a, b)) {
            *until = b;
            return true;
        }
        if (!(v > VOLUME_BOUND || v < -VOLUME_BOUND)) return false;
        if ((v > 0) == (va > 0))
            a = middle;
        else
            b = middle;
    }
    return false;
}

static void march(const moving *m, elementary_result *out)
{
    double t = 0, end = m->until;
    int creeping = 0;
    *out = (elementary_result){.status = ELEMENTARY_FREE, .proof = ELEMENTARY_CERTAIN, .t_lo = end, .t_hi = end};
    for (; t < end; out->steps++) { /* up to 1 as without an end: what is told before it depends on nothing beyond */
        if (m->verdict && end >= 1 && out->steps == VERDICT_STEPS && meets_on_the_way(m, t, &out->t_hi)) {
            out->status = ELEMENTARY_HIT, out->t_lo = t;
            return;
        }
        nearest n = nearest_at(m, t);
        vec3 axis = axis_at(m, &n, t);
        double next = reach(m, axis, t);
        if (next >= 1) return;
        bool touching = !(distance_bound(&n) - m->separation > 2 * POINT_BOUND);
        creeping += touching;
        if (out->steps == ELEMENTARY_STEPS_MAX || creeping > CREEP_MAX) return tell_hit(m, t, &n, out);
        if (!touching) next = max_of(next, reach_turning(m, &n, axis, t));
        if (next <= t && !touching) next = reach_otherwise(m, &n, t);
        if (next >= 1) return;
        if (!(next > t)) return tell_hit(m, t, &n, out);
        t = next;
    }
}

/* ---- from points to the polygon ---- */

static bool before(const vec3 *start, const vec3 *end, int a, int b) /* by coordinates: any total order serves */
{
    if (start[a].x != start[b].x) return start[a].x < start[b].x;
    if (start[a].y != start[b].y) return start[a].y < start[b].y;
    if (start[a].z != start[b].z) return start[a].z < start[b].z;
    if (end[a].x != end[b].x) return end[a].x < end[b].x;
    if (end[a].y != end[b].y) return end[a].y < end[b].y;
    return end[a].z < end[b].z;
}

static void order(const vec3 *start, const vec3 *end, int *a, int *b)
{
    int change = (*a ^ *b) & -(int)before(start, end, *b, *a); /* no branch: which way it goes is anybody's guess */
    *a ^= change, *b ^= change;
}

static void scale(moving *m, double by)
{
    for (int i = 0; i < m->corners; i++) {
        m->start[i] = vec_scale(m->start[i], by);
        m->end[i] = vec_scale(m->end[i], by);
    }
    m->most = vec_scale(m->most, by);
    m->separation *= by;
}

static vec3 most_of(vec3 a, vec3 b)
{
    return vec(max_of(a.x, fabs(b.x)), max_of(a.y, fabs(b.y)), max_of(a.z, fabs(b.z)));
}

/* Scales the polygon; false: its numbers are beyond what is looked at. */
static bool fit(moving *m)
{
    m->met = coincident(m, m->start);
    m->meets = coincident(m, m->end);
    m->most = VEC_ZERO;
    for (int i = 0; i < m->corners; i++) m->most = most_of(most_of(m->most, m->start[i]), m->end[i]);
    m->exponent = 0;
    double most = vec_greatest(m->most);
    if (!(m->separation >= 0 && most <= GREATEST)) return false;
    if (most < 0x1p-600) { /* so that what follows is a normal power of two */
        scale(m, 0x1p600);
        m->exponent = -600;
    }
    if (most > 0) { /* else all coincide */
        int exponent = exponent_above(vec_greatest(m->most));
        scale(m, power_of_two(-exponent));
        m->exponent += exponent;
    }
    return true;
}

static void answer(moving *m, const elementary_terms *terms, elementary_result *out)
{
    m->separation = terms->separation, m->until = terms->until, m->verdict = terms->verdict;
    if (fit(m))
        march(m, out);
    else
        *out = (elementary_result){.status = ELEMENTARY_HIT, .proof = ELEMENTARY_UNDECIDED, .gap = INFINITY};
}

static void make_vertex_face(const vec3 start[4], const vec3 end[4], moving *m)
{
    int at[3] = {1, 2, 3};
    order(start, end, &at[0], &at[1]);
    order(start, end, &at[1], &at[2]);
    order(start, end, &at[0], &at[1]);
    for (int i = 0; i < 3; i++) {
        m->start[i] = vec_sub(start[at[i]], start[0]);
        m->end[i] = vec_sub(end[at[i]], end[0]);
    }
    m->corners = 3;
}

static void make_edge_edge(const vec3 start[4], const vec3 end[4], moving *m)
{
    static const int AROUND[4][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}}; /* end of a, end of b */
    int a[2] = {0, 1}, b[2] = {2, 3};
    order(start, end, &a[0], &a[1]);
    order(start, end, &b[0], &b[1]);
    bool swap = before(start, end, b[0], a[0]) || (!before(start, end, a[0], b[0]) && before(start, end, b[1], a[1]));
    for (int i = 0; i < 4; i++) {
        int from = swap ? b[AROUND[i][0]] : a[AROUND[i][0]], to = swap ? a[AROUND[i][1]] : b[AROUND[i][1]];
        m->start[i] = vec_sub(start[to], start[from]);
        m->end[i] = vec_sub(end[to], end[from]);
    }
    m->corners = 4;
}

void elementary_vertex_face_on(
    const vec3 start[4], const vec3 end[4], const elementary_terms *terms, elementary_result *out)
{
    moving m;
    make_vertex_face(start, end, &m);
    answer(&m, terms, out);
}

void elementary_edge_edge_on(
    const vec3 start[4], const vec3 end[4], const elementary_terms *terms, elementary_result *out)
{
    moving m;
    make_edge_edge(start, end, &m);
    answer(&m, terms, out);
}

void elementary_vertex_face(const vec3 start[4], const vec3 end[4], double separation, elementary_result *out)
{
    elementary_vertex_face_on(start, end, &(elementary_terms){.separation = separation, .until = 1}, out);
}

void elementary_edge_edge(const vec3 start[4], const vec3 end[4], double separation, elementary_result *out)
{
    elementary_edge_edge_on(start, end, &(elementary_terms){.separation = separation, .until = 1}, out);
}

/* ---- one time ---- */

/* The plane across the direction of the nearest point has all corners beyond the least product. */
static void tell_distance(moving *m, double *lo, double *hi)
{
    m->separation = 0;
    *lo = 0, *hi = INFINITY;
    if (!fit(m)) return;
    nearest n = nearest_at(m, 0);
    *hi = in_metres(m, distance_bound(&n)) * (1 + 0x1p-50);
    vec3 axes[2] = {axis_at(m, &n, 0), n.point};
    for (int k = 0; k < 2; k++) {
        vec3 d = direction_of(axes[k]);
        if (vec_dot(d, n.point) < 0) d = vec_neg(d);
        double least = INFINITY;
        for (int i = 0; i < m->corners; i++) least = min_of(least, vec_dot(d, m->start[i]));
        least = (least - product_bound(m, d)) * (1 - 0x1p-48); /* |d| is 1, but for its rounding */
        if (least > 0) *lo = max_of(*lo, in_metres(m, least) * (1 - 0x1p-50) - 2 * DBL_TRUE_MIN);
    }
    *lo = max_of(*lo, 0);
}

void elementary_vertex_face_distance(const vec3 at[4], double *lo, double *hi)
{
    moving m;
    make_vertex_face(at, at, &m);
    tell_distance(&m, lo, hi);
}

void elementary_edge_edge_distance(const vec3 at[4], double *lo, double *hi)
{
    moving m;
    make_edge_edge(at, at, &m);
    tell_distance(&m, lo, hi);
}
