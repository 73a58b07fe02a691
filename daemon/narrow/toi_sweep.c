/* The gaps of parts along directions, at the ends of the pieces of a motion. Pure; any thread. */
#include "toi_sweep.h"

#include "core.h"
#include "scalar.h"

enum { ROUNDS_MAX = 8 };            /* directions are looked for so often in a piece */
static const double FINE = 0.004;   /* of the pair's size: so much may a gap dip in a piece, ... */
static const double COARSE = 0.1;   /* ... and where it would by more than this, no sweep is of use */
static const double LEAST_GAIN = 0.01; /* of a piece: below it no further direction is looked for */

bool sweep_init(sweep *s, const toi_mover *a, const toi_mover *b, const toi_request *request)
{
    course c;
    if (!course_init(&c, a, b, request->span)) return false;
    double size = c.reach_a + c.reach_b, dip = course_dip(&c, request->span);
    double pieces = 1 + sqrt(dip / (FINE * size));
    if (!(pieces < 0x1p20)) return false;
    s->pieces = c.straight ? 1 : pieces < SWEEP_PIECES_MAX ? (int)pieces : SWEEP_PIECES_MAX;
    s->piece = request->span / s->pieces;
    dip = course_dip(&c, s->piece);
    if (!(dip <= COARSE * size)) return false;
    for (int k = 0; k <= s->pieces; k++) {
        double time = k < s->pieces ? k * s->piece : request->span;
        course_place at = course_at(&c, time);
        mat3 turned = quat_matrix(at.b_in_a.q);
        sweep_place *p = &s->at[k];
        p->a = (transform){at.world_of_a, at.arm};
        p->b.r = (mat3){mat_mul(at.world_of_a, turned.x), mat_mul(at.world_of_a, turned.y),
            mat_mul(at.world_of_a, turned.z)};
        p->b.t = vec_add(at.arm, mat_mul(at.world_of_a, at.b_in_a.p));
        double far = vec_norm(p->b.t) + size;
        p->floor = request->threshold + c.slack + dip + 0.5 * request->wander * time * time * (1 + 4 * UNIT_ROUNDOFF) +
                   128 * UNIT_ROUNDOFF * far;
    }
    return true;
}

/* The greatest height of a part along a direction of its shape's frame. */
static double top_of(const toi_part *p, vec3 d)
{
    if (p->form == TOI_PART_BOX)
        return vec_dot(d, p->centre) + fabs(vec_dot(d, p->side[0])) + fabs(vec_dot(d, p->side[1])) +
               fabs(vec_dot(d, p->side[2]));
    if (p->form == TOI_PART_TRIANGLE) {
        double top = -INFINITY;
        for (int k = 0; k < 3; k++) top = max_of(top, d.x * p->x[k] + d.y * p->y[k] + d.z * p->z[k]);
        return top;
    }
    vec3 own = quat_rotate(quat_conj(p->local.q), d);
    return vec_dot(own, core_support(&p->shape, 1, own, NULL)) + vec_dot(d, p->local.p);
}

/* How far apart they are at a place along a unit direction of the course's frame, beyond the floor. */
static double gap_at(const sweep_place *at, const toi_part *a, const toi_part *b, vec3 d)
{
    double top = top_of(a, mat_tmul(at->a.r, d)) + vec_dot(d, at->a.t);
    double foot = vec_dot(d, at->b.t) - top_of(b, vec_neg(mat_tmul(at->b.r, d)));
    return foot - top - a->margin - b->margin - at->floor;
}

typedef struct way { /* through one piece */
    const sweep *s;
    const toi_part *a, *b;
    int piece;
    double share; /* of the piece that is free */
} way;

/* How far into the piece the gap along a direction lets the way go on. */
static void try_direction(way *w, vec3 towards)
{
    if (!(vec_norm2(towards) > 0)) return;
    vec3 d = direction_of(towards);
    double first = gap_at(&w->s->at[w->piece], w->a, w->b, d);
    if (!(first > 0) && w->share == 0) return;
    double last = gap_at(&w->s->at[w->piece + 1], w->a, w->b, d);
    if (!(first + (last - first) * w->share > 0)) return;
    w->share = last > 0 ? 1 : max_of(w->share, first / (first - last));
}

static vec3 between(const transform *from, const transform *to, double share, vec3 point)
{
    vec3 p = transform_point(from, point), q = transform_point(to, point);
    return vec_madd(p, share, vec_sub(q, p));
}

/* The point of a part's extents that is nearest to another point, both in the course's frame; the part where it is at
 * the beginning of the piece, but for its centre. */
static vec3 nearest_in(const toi_part *p, const mat3 *r, vec3 centre, vec3 point)
{
    vec3 nearest = centre, away = vec_sub(point, centre);
    for (int k = 0; k < 3; k++) {
        vec3 side = mat_mul(*r, p->side[k]);
        double norm2 = vec_norm2(side), along = vec_dot(away, side);
        if (norm2 > 0) nearest = vec_madd(nearest, clamp_to(along / norm2, 1), side);
    }
    return nearest;
}

static vec3 facing(vec3 n, vec3 towards)
{
    return vec_dot(n, towards) < 0 ? vec_neg(n) : n;
}

/* Directions that may have a gap at that share of the piece: between what is nearest of their extents, and across flat
 * parts. */
static void try_directions(way *w)
{
    const sweep_place *from = &w->s->at[w->piece], *to = from + 1;
    vec3 a = between(&from->a, &to->a, w->share, w->a->centre), b = between(&from->b, &to->b, w->share, w->b->centre);
    vec3 line = vec_sub(b, a);
    double before = w->share;
    vec3 on_a = nearest_in(w->a, &from->a.r, a, b);
    vec3 on_b = nearest_in(w->b, &from->b.r, b, on_a);
    try_direction(w, vec_sub(on_b, on_a));
    if (w->share > before) return;
    try_direction(w, vec_sub(b, on_a));
    if (w->share > before) return;
    try_direction(w, facing(mat_mul(from->b.r, w->b->normal), line));
    if (w->share > before) return;
    try_direction(w, facing(mat_mul(from->a.r, w->a->normal), line));
    if (w->share > before) return;
    try_direction(w, line);
}

double sweep_entry(const sweep *s, const toi_part *a, const toi_part *b, double from, double until)
{
    int piece = (int)(from / s->piece);
    if (piece >= s->pieces) piece = s->pieces - 1;
    double share = max_of(from / s->piece - piece, 0);
    for (; piece < s->pieces && piece * s->piece <= until; piece++, share = 0) {
        way w = {s, a, b, piece, min_of(share, 1)};
        for (int round = 0; round < ROUNDS_MAX && w.share < 1; round++) {
            double before = w.share;
            try_directions(&w);
            if (w.share - before < LEAST_GAIN) break;
        }
        if (w.share < 1) {
            double time = max_of((piece + w.share) * s->piece, from);
            return time > until ? INFINITY : time;
        }
    }
    return INFINITY;
}
