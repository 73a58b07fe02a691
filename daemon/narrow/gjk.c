/* gjk: Gilbert-Johnson-Keerthi with a duality-gap stop. Pure; any thread.
 *
 * What holds: for every unit axis n tried, min over B - A of dot(n, w) is a lower bound; every convex combination of
 * points of B - A is an upper bound. The bracket of the best of both is kept apart from the search, which may stall. */
#include "gjk.h"

#include "near_features.h"
#include "scalar.h"

enum { ITERATIONS_MAX = 128 };

static bool known(const simplex *s, vec3 w)
{
    for (int i = 0; i < s->count; i++)
        if (s->v[i].w.x == w.x && s->v[i].w.y == w.y && s->v[i].w.z == w.z) return true;
    return false;
}

static void raise_lower(span *best, double separation, vec3 axis)
{
    if (!(separation > best->lo)) return;
    best->lo = separation;
    best->axis = axis;
}

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

static void lower_upper(span *best, double norm, const simplex *s)
{
    best->hi = norm;
    simplex_witness(s, &best->point_a, &best->point_b);
}

/* One step: the newest point, at s->v[s->count], joins; the simplex shrinks to its nearest feature. False when the
 * search is over. */
static bool advance(const unit_pair *p, gjk_result *out, support_hints *hints, vec3 *axis)
{
    simplex *s = &out->simplex;
    span *best = &out->span;
    double touch = 8 * UNIT_ROUNDOFF * p->size;
    s->count++;
    nearest_feature n = simplex_reduce(s);
    if (n.inside) {
        out->state = GJK_INSIDE;
        lower_upper(best, 0, s);
        return false;
    }
    bool decreased = n.norm < best->hi || best->iterations == 1;
    if (n.norm < best->hi) lower_upper(best, n.norm, s);
    *axis = n.axis;
    if (best->hi > touch && decreased) return true;
    raise_lower(best, vec_dot(n.axis, unit_pair_nearest_from(p, n.axis, hints).w), n.axis);
    return false;
}

static void start(gjk_result *out)
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
    start(out);
    for (best->iterations = 1; best->iterations <= ITERATIONS_MAX; best->iterations++) {
        minkowski *m = &out->simplex.v[out->simplex.count];
        unit_pair_nearest_to(p, axis, &hints, m);
        raise_lower(best, vec_dot(axis, m->w), axis);
        if (best->iterations == 1) first_upper(best, m);
        if (narrow_goal_reached(goal, best->lo, best->hi) || known(&out->simplex, m->w) ||
            !advance(p, out, &hints, &axis))
            break;
    }
    if (out->state == GJK_TOUCH && (best->lo > 0 || narrow_goal_reached(goal, best->lo, best->hi)))
        out->state = GJK_APART;
    const simplex *s = &out->simplex;
    const minkowski *m[3] = {&s->v[0], &s->v[1], &s->v[2]};
    if (out->state == GJK_APART && s->count <= 3 && p->a.type == SHAPE_HULL && p->b.type == SHAPE_HULL)
        hull_features_of(m, s->count, &best->nearest);
}
