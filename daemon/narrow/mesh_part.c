/* The search of gjk.c, for a triangle of which all corners are in A's frame, and another or a convex core. Pure; any
 * thread. */
#include "mesh_part.h"

#include "core.h"
#include "scalar.h"
#include "simplex.h"

enum { ITERATIONS_MAX = 128, STALLS_MAX = 16 };

/* Share of the size: while the bounds are farther apart than this, it goes on without coming nearer. Of triangles that
 * are parallel to the other but for 1e-9 the points are the nearest to the last bit long before the axis is: an axis
 * that is off by x costs lo x, and the points by which it is found x^2. */
static const double STALLED = 0x1p-38;

static vec3 corner_along(const vec3 p[3], vec3 d)
{
    double h0 = vec_dot(d, p[0]), h1 = vec_dot(d, p[1]), h2 = vec_dot(d, p[2]);
    return h0 >= h1 ? (h0 >= h2 ? p[0] : p[2]) : (h1 >= h2 ? p[1] : p[2]);
}

static minkowski nearest_along(const mesh_walk *w, vec3 axis)
{
    minkowski m = {.b_local = VEC_ZERO};
    m.a = w->ma ? corner_along(w->spot_a->corner, axis) : core_support(&w->whole_a, w->part.scale, axis, NULL);
    m.b = corner_along(w->spot_b->corner, vec_neg(axis));
    m.w = vec_sub(m.b, m.a);
    return m;
}

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

static void lower_upper(span *best, double norm, const simplex *s)
{
    best->hi = norm;
    simplex_witness(s, &best->point_a, &best->point_b);
}

/* As in gjk.c, but for stalls. */
static bool advance(const mesh_walk *w, simplex *s, span *best, vec3 *axis, int *stalls)
{
    s->count++;
    nearest_feature n = simplex_reduce(s);
    if (n.inside) {
        lower_upper(best, 0, s);
        return false;
    }
    bool decreased = n.norm < best->hi || best->iterations == 1;
    if (n.norm < best->hi) lower_upper(best, n.norm, s);
    *axis = n.axis;
    bool goes_on = decreased || (best->hi - best->lo > STALLED * w->part.size && ++*stalls <= STALLS_MAX);
    if (best->hi > 8 * UNIT_ROUNDOFF * w->part.size && goes_on) return true;
    raise_lower(best, vec_dot(n.axis, nearest_along(w, n.axis).w), n.axis);
    return false;
}

void mesh_part_distance(const mesh_walk *w, const narrow_goal *goal, span *best)
{
    simplex s = {.count = 0};
    int stalls = 0;
    vec3 axis = direction_of(w->lead);
    if (!(vec_norm2(axis) > 0)) axis = vec(1, 0, 0);
    *best = (span){.lo = -INFINITY, .hi = INFINITY, .method = NARROW_BY_GJK};
    for (best->iterations = 1; best->iterations <= ITERATIONS_MAX; best->iterations++) {
        minkowski *m = &s.v[s.count];
        *m = nearest_along(w, axis);
        raise_lower(best, vec_dot(axis, m->w), axis);
        if (best->iterations == 1) {
            best->hi = vec_norm(m->w);
            best->point_a = m->a;
            best->point_b = m->b;
        }
        if (narrow_goal_reached(goal, best->lo, best->hi) || known(&s, m->w) || !advance(w, &s, best, &axis, &stalls))
            break;
    }
}
