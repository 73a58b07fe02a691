/* gjk: Gilbert-Johnson-Keerthi with a duality-gap stop. Pure; any thread.
 *
 * What holds: for every unit axis n tried, min over B - A of dot(n, w) is a lower bound; every convex combination of
 * points of B - A is an upper bound. The bracket of the best of both is kept apart from the search, which may stall. */
#include "gjk.h"

#include "features.h"
#include "narrow/math/scalar.h"

enum { ITERATIONS_MAX = 128 };

static vec3 first_axis(const unit_pair *p, vec3 seed)
{
    vec3 axis = vec_norm2(seed) > 0 ? seed : direction_of(p->b_in_a.t);
    return vec_norm2(axis) > 0 ? axis : vec(1, 0, 0);
}

/* Before there is a simplex, the first point of B - A stands for the upper bound. */
static void first_upper(span *best, const minkowski *m)
{
    best->hi = vec_norm(m->w);
    best->point_a = m->a;
    best->point_b = m->b;
}

/* One step: the newest point, at s->v[s->count], joins; the simplex shrinks to its nearest feature. False when the
 * search is over. */
static bool gjk_advance(const unit_pair *p, gjk_result *out, support_hints *hints, vec3 *axis)
{
    simplex *s = &out->simplex;
    span *best = &out->span;
    double touch = 8 * UNIT_ROUNDOFF * p->size;
    s->count++;
    nearest_feature n = simplex_reduce(s);
    if (n.inside) {
        out->state = GJK_INSIDE;
        simplex_lower_upper(s, 0, best);
        return false;
    }
    bool decreased = n.norm < best->hi || best->iterations == 1;
    if (n.norm < best->hi) simplex_lower_upper(s, n.norm, best);
    *axis = n.axis;
    if (best->hi > touch && decreased) return true;
    span_raise_lower(best, vec_dot(n.axis, unit_pair_nearest_from(p, n.axis, hints).w), n.axis);
    return false;
}

static void gjk_start(gjk_result *out)
{
    out->state = GJK_TOUCH;
    out->span.lo = -INFINITY;
    out->span.hi = INFINITY;
    out->span.method = NARROW_BY_GJK;
    out->span.nearest = (narrow_features){.count_a = 0};
    out->simplex.count = 0;
}

void gjk_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out)
{
    span *best = &out->span;
    support_hints hints = NO_HINTS;
    vec3 axis = first_axis(p, seed);
    gjk_start(out);
    for (best->iterations = 1; best->iterations <= ITERATIONS_MAX; best->iterations++) {
        minkowski *m = &out->simplex.v[out->simplex.count];
        unit_pair_nearest_to(p, axis, &hints, m);
        span_raise_lower(best, vec_dot(axis, m->w), axis);
        if (best->iterations == 1) first_upper(best, m);
        if (narrow_goal_reached(goal, best->lo, best->hi) || simplex_has(&out->simplex, m->w) ||
            !gjk_advance(p, out, &hints, &axis))
            break;
    }
    if (out->state == GJK_TOUCH && (best->lo > 0 || narrow_goal_reached(goal, best->lo, best->hi)))
        out->state = GJK_APART;
    const simplex *s = &out->simplex;
    const minkowski *m[3] = {&s->v[0], &s->v[1], &s->v[2]};
    if (out->state == GJK_APART && s->count <= 3 && p->a.type == SHAPE_HULL && p->b.type == SHAPE_HULL)
        hull_features_of(m, s->count, &best->nearest);
}

/* ---- rough depth ---- */

/* Bounds from a tetrahedron that holds the origin. */

/* Twice a face's area, of the square of the size: with less its normal is not sure enough. A normal is off by at most a
 * few roundings of the square of the size, relative to that area; so its plane by far less than the slack. */
#define LEAST_AREA 0x1p-20
#define PLANE_SLACK 0x1p-24

enum { FACES = 4 };

typedef struct face {
    vec3 out; /* unit, away from the fourth corner */
    double offset;
} face;

static bool face_of(const simplex *s, int opposite, double size, face *out)
{
    vec3 a = s->v[(opposite + 1) % FACES].w, b = s->v[(opposite + 2) % FACES].w, c = s->v[(opposite + 3) % FACES].w;
    vec3 n = triangle_normal(a, b, c);
    double norm = vec_norm(n);
    if (!(norm >= LEAST_AREA * size * size)) return false;
    double side = vec_dot(n, vec_sub(s->v[opposite].w, a)) > 0 ? -1 : 1;
    out->out = vec_scale(n, side / norm);
    out->offset = vec_dot(out->out, a);
    return true;
}

/* The point along the known axis; or, for a measure, along the best of it and of those of the faces. */
static minkowski raise_by_faces(const unit_pair *p, bool measured, const face *faces, span *out)
{
    support_hints hints = NO_HINTS;
    minkowski top = unit_pair_nearest_from(p, out->axis, &hints), m;
    for (int i = 0; measured && i < FACES; i++) {
        vec3 axis = vec_neg(faces[i].out);
        unit_pair_nearest_to(p, axis, &hints, &m);
        double separation = vec_dot(axis, m.w);
        if (!(separation > out->lo)) continue;
        out->lo = separation;
        out->axis = axis;
        top = m;
    }
    return top;
}

bool rough_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out)
{
    face faces[FACES];
    double least = INFINITY;
    if (start->state != GJK_INSIDE || start->simplex.count < FACES) return false;
    for (int i = 0; i < FACES; i++) {
        if (!face_of(&start->simplex, i, p->size, &faces[i])) return false;
        least = min_of(least, faces[i].offset);
    }
    double inside = least - PLANE_SLACK * p->size;
    if (!(inside > 0)) return false;
    span found = *out;
    minkowski top = raise_by_faces(p, goal->near == -INFINITY, faces, &found);
    found.hi = max_of(-inside, found.lo);
    found.iterations += FACES;
    found.point_a = top.a;
    found.point_b = top.b;
    if (!narrow_goal_reached(goal, found.lo, found.hi)) return false;
    *out = found;
    return true;
}

/* ---- moved apart ---- */

/* B is moved along the axis by twice the overlap that it proves, which leaves a gap; the axis of that gap
 * is known for certain, and it is off from the one that is looked for by as much as the surface bends over so short a
 * way. So the overlap along it is about the square of the overlap before, over the radius of the bend. */

enum { ROUNDS_MAX = 8 };

#define ALMOST_NOTHING 0x1p-10 /* of the size: deeper overlaps have other nearest faces */

void moved_apart_raise(const unit_pair *p, span *s)
{
    for (int k = 0; k < ROUNDS_MAX && s->lo < 0 && s->hi - s->lo > p->error; k++) {
        if (-s->lo > ALMOST_NOTHING * p->size) return;
        unit_pair moved = *p;
        moved.b_in_a.t = vec_madd(p->b_in_a.t, max_of(-2 * s->lo, 4 * p->error), s->axis);
        const narrow_goal measure = {p->error, p->error, INFINITY, -INFINITY, -INFINITY, INFINITY, false};
        gjk_result r;
        gjk_distance(&moved, &measure, s->axis, &r);
        s->iterations += r.span.iterations;
        if (r.state != GJK_APART) return;
        double proved = vec_dot(r.span.axis, unit_pair_nearest_along(p, r.span.axis).w);
        if (!(proved > s->lo)) return;
        s->lo = min_of(proved, s->hi);
        s->axis = r.span.axis;
    }
}
