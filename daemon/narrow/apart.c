/* apart: separation proven along one of a few axes, each by one support point a shape. Pure; any thread.
 *
 * The points of B - A that the first axes led to are a simplex, as in GJK (gjk.h); the next axis is the direction of
 * its nearest point. A search that has not found an axis after a few of them is left to those that measure; and so are
 * two that were together when they were last looked at, unless the first axes part them. */
#include "scalar.h"
#include "simplex.h"

enum { AXES_MAX = 4 };

static const double NEAR = 0x1p-5; /* of the size: whether two that may be this near are apart takes more axes than it
                                      is worth to try before they are measured */

typedef struct trial {
    unit_pair p;
    support_hints hints;
    simplex points;
    double limit, lower; /* m */
    vec3 axis;
    int tried;
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
    t->tried++;
    t->lower = (vec_dot(axis, m->w) - t->p.radius - t->p.error - t->p.excess) * t->p.unit;
    return t->lower > t->limit;
}

static bool is_axis(vec3 v)
{
    return v.x != 0 || v.y != 0 || v.z != 0;
}

static bool search(trial *t, const shape *a, const shape *b, const pose *b_in_a, const narrow_cache *cache)
{
    bool remembers = is_axis(cache->axis), met = remembers && !(cache->lower > t->limit);
    if (remembers && try_axis(t, cache->axis)) return true;
    vec3 guess = narrow_guess_axis(a, b, b_in_a);
    if (is_axis(guess) && try_axis(t, guess)) return true;
    double near = NEAR * t->p.size + t->p.radius;
    while (!met && t->tried > 0 && t->tried < AXES_MAX) {
        nearest_feature n = simplex_reduce(&t->points);
        if (n.inside || !((n.norm - near) * t->p.unit > t->limit)) return false;
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
    t.tried = 0;
    bool found = false;
    if (is_plane(a) || is_plane(b)) {
        t.axis = cache->axis;
        t.lower = unit_pair_separation(&t.p, t.axis, NULL, NULL);
        found = t.lower > limit;
    } else {
        found = search(&t, a, b, b_in_a, cache);
        cache->hint_a = t.hints.a, cache->hint_b = t.hints.b;
    }
    if (!found) return false;
    cache->axis = t.axis;
    cache->lower = t.lower;
    cache->b_in_a = *b_in_a;
    return true;
}
