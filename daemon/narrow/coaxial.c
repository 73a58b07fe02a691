/* coaxial: B - A of two bodies of revolution about one axis is another, so the depth is that of two polygons in a half-
 * plane: the least overlap along the normals of either outline. Pure; any thread. */
#include "coaxial.h"

#include "scalar.h"

/* Farther from one axis than this part of the size, the pair is not worth a look. */
#define COAXIAL 0x1p-10

/* Corners (r, z) and outward unit normals (r, z) of the outline; those on the axis of revolution are left out. */
typedef struct outline {
    int corners, normals;
    double r[3], z[3], nr[3], nz[3];
} outline;

/* `side`: +1, or -1 for a shape that stands on its head; `at`: its height. */
static outline outline_of(const shape *s, double side, double at)
{
    double r = s->half.x, h = s->half.z, length = sqrt(r * r + 4 * h * h), top = at + side * h, foot = at - side * h;
    if (s->type == SHAPE_CAPSULE) return (outline){2, 1, {0, 0}, {top, foot}, {1}, {0}};
    if (s->type == SHAPE_CYLINDER) return (outline){2, 3, {r, r}, {top, foot}, {1, 0, 0}, {0, 1, -1}};
    return (outline){2, 2, {0, r}, {top, foot}, {2 * h / length, 0}, {side * r / length, -side}};
}

static double separation(const outline *a, const outline *b, double nr, double nz)
{
    double top_a = -INFINITY, foot_b = INFINITY;
    for (int i = 0; i < a->corners; i++) top_a = max_of(top_a, nr * a->r[i] + nz * a->z[i]);
    for (int i = 0; i < b->corners; i++) foot_b = min_of(foot_b, nz * b->z[i] - nr * b->r[i]);
    return foot_b - top_a;
}

static bool revolved(const shape *s)
{
    return s->type == SHAPE_CAPSULE || s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE;
}

typedef struct plane_axis {
    double separation, r, z;
} plane_axis;

static void try_normal(const outline *a, const outline *b, double nr, double nz, plane_axis *best)
{
    double s = separation(a, b, nr, nz);
    if (s > best->separation) *best = (plane_axis){s, nr, nz};
}

/* Where B is off the axis, or across where it leans: there the separation is greatest. */
static vec3 towards(vec3 off, vec3 lean)
{
    bool leans = lean.x * lean.x + lean.y * lean.y > off.x * off.x + off.y * off.y;
    vec3 n = direction_of(leans ? vec(-lean.y, lean.x, 0) : vec(off.x, off.y, 0));
    return vec_norm2(n) > 0 ? n : vec(1, 0, 0);
}

void coaxial_depth(const unit_pair *p, span *s)
{
    vec3 up = p->b_in_a.r.z, t = p->b_in_a.t;
    double off = vec_norm(vec(t.x, t.y, 0)) + vec_norm(vec(up.x, up.y, 0)) * p->size;
    if (!revolved(&p->a) || !revolved(&p->b) || off > COAXIAL * p->size) return;
    outline a = outline_of(&p->a, 1, 0), b = outline_of(&p->b, up.z < 0 ? -1 : 1, t.z);
    plane_axis best = {.separation = -INFINITY};
    for (int i = 0; i < a.normals; i++) try_normal(&a, &b, a.nr[i], a.nz[i], &best);
    for (int i = 0; i < b.normals; i++) try_normal(&a, &b, b.nr[i], -b.nz[i], &best);
    vec3 side = towards(t, vec_scale(up, p->size)), axis = vec(best.r * side.x, best.r * side.y, best.z);
    double proved = vec_dot(axis, unit_pair_nearest_along(p, axis).w);
    if (proved > s->lo) {
        s->lo = proved;
        s->axis = axis;
    }
    double high = best.separation + off; /* moved onto the axis by `off`, B is where the one formula is the truth */
    s->hi = max_of(s->lo, min_of(s->hi, high));
}
