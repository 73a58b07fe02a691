/* coaxial: B - A of two bodies of revolution about one axis is another, so the depth is that of two polygons in a half-
 * plane: the least overlap along the normals of either outline. Pure; any thread. */
#include "curved.h"
#include "narrow/closed/closed.h"
#include "narrow/math/scalar.h"

/* ---- inscribed ---- */

/* Balls in cores, and how deep the other core is in them. */

static const double NEARLY = 0x1p-10; /* of the size */

typedef struct ball {
    vec3 centre; /* in the core's frame */
    double radius;
} ball;

/* A ball in the core, as large as any whose centre is near `c`. */
static ball ball_towards(const shape *s, double shaved, vec3 c)
{
    vec3 h = s->half;
    double least = min_of(h.x, min_of(h.y, h.z)), r = h.x, length = sqrt(r * r + 4 * h.z * h.z);
    double lowest = -h.z + 2 * h.z * r / (length + r); /* a cone's largest ball touches its base and its mantle */
    switch (s->type) {
    case SHAPE_CAPSULE:
        return (ball){vec(0, 0, clamp_to(c.z, h.z)), 0};
    case SHAPE_BOX:
        return (ball){vec(clamp_to(c.x, h.x - least), clamp_to(c.y, h.y - least), clamp_to(c.z, h.z - least)), least};
    case SHAPE_CYLINDER:
        return (ball){vec(0, 0, clamp_to(c.z, max_of(h.z - r, 0))), min_of(r, h.z)};
    case SHAPE_CONE:
        c.z = min_of(max_of(c.z, lowest), h.z);
        return (ball){vec(0, 0, c.z), (h.z - c.z) * r / length};
    case SHAPE_ELLIPSOID:
        return (ball){VEC_ZERO, least - shaved};
    default:
        return (ball){VEC_ZERO, 0};
    }
}

/* The formula for a point beside a core; NULL: there is none. */
static closed_form *beside_point(shape_type type)
{
    static closed_form *const FORMS[SHAPE_CONVEX_COUNT] = {[SHAPE_SPHERE] = closed_box_box,
        [SHAPE_CAPSULE] = closed_box_box,
        [SHAPE_BOX] = closed_box_box,
        [SHAPE_CYLINDER] = closed_sphere_revolved,
        [SHAPE_CONE] = closed_sphere_revolved,
        [SHAPE_ELLIPSOID] = ellipsoid_pair_measure};
    return FORMS[type];
}

/* Narrows both bounds by one axis. Where the shapes may be apart nothing is done: there hi belongs to points. */
static void narrow_by(const unit_pair *p, vec3 axis, double hi, span *s)
{
    if (!(hi < -2 * p->error)) return;
    double lo = vec_dot(axis, unit_pair_nearest_along(p, axis).w);
    s->iterations++;
    if (lo > s->lo) s->lo = lo, s->axis = axis;
    if (hi < s->hi) s->hi = max_of(s->lo, hi);
}

/* The point is at the origin of `core_at`'s parent. */
static bool measure_point(
    const unit_pair *p, const narrow_goal *goal, const shape *core, const transform *core_at, span *s)
{
    unit_pair x = *p;
    x.a = (shape){.type = SHAPE_SPHERE};
    x.b = *core;
    x.b_in_a = *core_at;
    x.shaved_a = 0;
    x.shaved_b = core == &p->a ? p->shaved_a : p->shaved_b;
    return beside_point(core->type)(&x, goal, s);
}

bool inscribed_promises(const unit_pair *p)
{
    vec3 in_a = p->b_in_a.t, in_b = mat_tmul(p->b_in_a.r, in_a);
    double off_a = in_a.x * in_a.x + in_a.y * in_a.y, off_b = in_b.x * in_b.x + in_b.y * in_b.y;
    return min_of(off_a, off_b) < NEARLY * NEARLY * p->size * p->size;
}

void inscribed_depth(const unit_pair *p, const narrow_goal *goal, span *s)
{
    const transform *at = &p->b_in_a;
    span of;
    if (p->a.type == SHAPE_SPHERE) return; /* the formula has been asked */
    if (beside_point(p->b.type) && p->a.type != SHAPE_HULL) {
        ball in_a = ball_towards(&p->a, p->shaved_a, at->t);
        transform b_from_ball = {at->r, vec_sub(at->t, in_a.centre)};
        if (measure_point(p, goal, &p->b, &b_from_ball, &of)) narrow_by(p, of.axis, of.hi - in_a.radius + p->error, s);
    }
    if (beside_point(p->a.type) && p->b.type != SHAPE_HULL) {
        static const mat3 STRAIGHT = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        ball in_b = ball_towards(&p->b, p->shaved_b, vec_neg(mat_tmul(at->r, at->t)));
        transform a_from_ball = {STRAIGHT, vec_neg(vec_add(mat_mul(at->r, in_b.centre), at->t))};
        if (measure_point(p, goal, &p->a, &a_from_ball, &of))
            narrow_by(p, vec_neg(of.axis), of.hi - in_b.radius + p->error, s);
    }
}

/* ---- coaxial ---- */

/* Farther from one axis than this part of the size, the pair is not worth a look. */
#define COAXIAL 0x1p-10

/* Corners (r, z) and outward unit normals (r, z) of the outline; those on the axis of revolution are left out. */
typedef struct outline {
    int corners, normals;
    double r[3], z[3], nr[3], nz[3];
} outline;

/* `side`: +1, or -1 for a shape that stands on its head; `at`: its height. */
static outline coaxial_outline_of(const shape *s, double side, double at)
{
    double r = s->half.x, h = s->half.z, length = sqrt(r * r + 4 * h * h), top = at + side * h, foot = at - side * h;
    if (s->type == SHAPE_CAPSULE) return (outline){2, 1, {0, 0}, {top, foot}, {1}, {0}};
    if (s->type == SHAPE_CYLINDER) return (outline){2, 3, {r, r}, {top, foot}, {1, 0, 0}, {0, 1, -1}};
    return (outline){2, 2, {0, r}, {top, foot}, {2 * h / length, 0}, {side * r / length, -side}};
}

static double coaxial_separation(const outline *a, const outline *b, double nr, double nz)
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
    double s = coaxial_separation(a, b, nr, nz);
    if (s > best->separation) *best = (plane_axis){s, nr, nz};
}

/* Where B is off the axis, or across where it leans: there the separation is greatest. */
static vec3 coaxial_towards(vec3 off, vec3 lean)
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
    outline a = coaxial_outline_of(&p->a, 1, 0), b = coaxial_outline_of(&p->b, up.z < 0 ? -1 : 1, t.z);
    plane_axis best = {.separation = -INFINITY};
    for (int i = 0; i < a.normals; i++) try_normal(&a, &b, a.nr[i], a.nz[i], &best);
    for (int i = 0; i < b.normals; i++) try_normal(&a, &b, b.nr[i], -b.nz[i], &best);
    vec3 side = coaxial_towards(t, vec_scale(up, p->size)), axis = vec(best.r * side.x, best.r * side.y, best.z);
    double proved = vec_dot(axis, unit_pair_nearest_along(p, axis).w);
    if (proved > s->lo) {
        s->lo = proved;
        s->axis = axis;
    }
    double high = best.separation + off; /* moved onto the axis by `off`, B is where the one formula is the truth */
    s->hi = max_of(s->lo, min_of(s->hi, high));
}
