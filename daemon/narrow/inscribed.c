/* inscribed: balls in cores, and how deep the other core is in them. */
#include "inscribed.h"

#include "dispatch.h"
#include "scalar.h"

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

static bool has_formula(const shape *s)
{
    return dispatch_closed_form(SHAPE_SPHERE, s->type) != NULL && s->type != SHAPE_HALFSPACE;
}

/* Where they may be apart, hi is told by points. */
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
    return dispatch_closed_form(SHAPE_SPHERE, core->type)(&x, goal, s);
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
    if (has_formula(&p->b) && p->a.type != SHAPE_HULL) {
        ball in_a = ball_towards(&p->a, p->shaved_a, at->t);
        transform b_from_ball = {at->r, vec_sub(at->t, in_a.centre)};
        if (measure_point(p, goal, &p->b, &b_from_ball, &of)) narrow_by(p, of.axis, of.hi - in_a.radius + p->error, s);
    }
    if (has_formula(&p->a) && p->b.type != SHAPE_HULL) {
        static const mat3 STRAIGHT = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        ball in_b = ball_towards(&p->b, p->shaved_b, vec_neg(mat_tmul(at->r, at->t)));
        transform a_from_ball = {STRAIGHT, vec_neg(vec_add(mat_mul(at->r, in_b.centre), at->t))};
        if (measure_point(p, goal, &p->a, &a_from_ball, &of))
            narrow_by(p, vec_neg(of.axis), of.hi - in_b.radius + p->error, s);
    }
}
