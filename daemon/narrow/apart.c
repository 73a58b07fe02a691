/* apart: separation proven along one of a few axes, each by one support point a shape. Pure; any thread.
 *
 * The points of B - A that the first axes led to are a simplex, as in GJK (gjk.h); the next axis is the direction of
 * its nearest point. A search that has not found an axis after a few of them is left to those that measure. */
#include "scalar.h"
#include "simplex.h"

enum { STEPS_MAX = 4 }; /* after what is remembered and what is guessed */

typedef struct trial {
    unit_pair p;
    support_hints hints;
    simplex points;
    double limit, lower; /* m */
    vec3 axis;
} trial;

static bool is_plane(const shape *s)
{
    return s->type == SHAPE_HALFSPACE;
}

/* One axis more. The separation is that of narrow_separation, to the bit. */
static bool try_axis(trial *t, vec3 axis)
{
    minkowski *m = &t->points.v[t->points.count++];
    unit_pair_nearest_to(&t->p, axis, &t->hints, m);
    t->axis = axis;
    t->lower = (vec_dot(axis, m->w) - t->p.radius - t->p.error - t->p.excess) * t->p.unit;
    return t->lower > t->limit;
}

static bool is_axis(vec3 v)
{
    return v.x != 0 || v.y != 0 || v.z != 0;
}

static bool search(trial *t, const shape *a, const shape *b, const pose *b_in_a, vec3 remembered)
{
    if (is_axis(remembered) && try_axis(t, remembered)) return true;
    vec3 guess = narrow_guess_axis(a, b, b_in_a);
    if (is_axis(guess) && try_axis(t, guess)) return true;
    for (int i = 0; i < STEPS_MAX && t->points.count > 0; i++) {
        nearest_feature n = simplex_reduce(&t->points);
        if (n.inside || !((n.norm - t->p.radius) * t->p.unit > t->limit)) return false; /* as near as that they are */
        if (try_axis(t, n.axis)) return true;
    }
    return false;
}

bool narrow_apart(const shape *a, const shape *b, const pose *b_in_a, double limit, narrow_cache *cache)
{
    trial t;
    unit_pair_init(&t.p, a, b, b_in_a);
    t.hints = (support_hints){cache->hint_a, cache->hint_b};
    t.points.count = 0;
    t.limit = limit;
    bool found = false;
    if (is_plane(a) || is_plane(b)) {
        t.axis = cache->axis;
        t.lower = unit_pair_separation(&t.p, t.axis, NULL, NULL);
        found = t.lower > limit;
    } else {
        found = search(&t, a, b, b_in_a, cache->axis);
        cache->hint_a = t.hints.a, cache->hint_b = t.hints.b;
    }
    if (!found) return false;
    cache->axis = t.axis;
    cache->lower = t.lower;
    cache->b_in_a = *b_in_a;
    return true;
}
