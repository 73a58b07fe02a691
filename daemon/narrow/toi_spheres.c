/* toi_spheres: the squared distance of two points that move along lines is a parabola in time, so that apart and still
 * approaching at `lo` proves that they were farther apart at all times before. The root only proposes lo and hi; what
 * is told is what the distances at these times prove, their rounding counted. Pure; any thread. */
#include "toi_spheres.h"

#include "scalar.h"
#include "unit_pair.h"

typedef struct balls {
    vec3 from, velocity; /* of B's centre, seen from A's */
    double reach;        /* m: the distance of the centres in contact */
    double error;        /* m: of any distance of the centres within the span */
    vec3 arm_a, arm_b;   /* from the bodies' origins to the centres, world axes */
} balls;

static double size_of(vec3 v)
{
    return fabs(v.x) + fabs(v.y) + fabs(v.z);
}

/* A centre moves straight if its body does not turn, or turns about it. */
static bool goes_straight(const toi_mover *m)
{
    return m->shape->type == SHAPE_SPHERE && !(m->shape->deviation > 0) &&
           (vec_greatest(m->motion.angular) == 0 || vec_greatest(m->local.p) == 0);
}

static bool in_range(double x)
{
    return x > 0x1p-300 && x < 0x1p300;
}

static bool balls_of(const toi_mover *a, const toi_mover *b, const toi_request *r, balls *s)
{
    if (!goes_straight(a) || !goes_straight(b) || r->wander > 0) return false;
    s->arm_a = quat_rotate(a->motion.start.q, a->local.p);
    s->arm_b = quat_rotate(b->motion.start.q, b->local.p);
    vec3 between = vec_sub(b->motion.start.p, a->motion.start.p);
    s->from = vec_add(between, vec_sub(s->arm_b, s->arm_a));
    s->velocity = vec_sub(b->motion.linear, a->motion.linear);
    s->reach = a->shape->radius + b->shape->radius + r->threshold;
    double size = size_of(between) + 2 * (size_of(a->local.p) + size_of(b->local.p)) + a->shape->radius +
                  b->shape->radius + fabs(r->threshold) +
                  r->span * (size_of(a->motion.linear) + size_of(b->motion.linear));
    s->error = 32 * UNIT_ROUNDOFF * size;
    return s->reach > 0 && in_range(size) && in_range(vec_norm2(s->velocity));
}

static vec3 place(const balls *s, double time)
{
    return vec_madd(s->from, time, s->velocity);
}

static void tell(const balls *s, const toi_mover *a, const toi_mover *b, double lo, double hi, toi_result *out)
{
    vec3 there = place(s, lo);
    double apart = vec_norm(there), gap = apart - a->shape->radius - b->shape->radius;
    vec3 centre_a = vec_add(vec_madd(a->motion.start.p, lo, a->motion.linear), s->arm_a);
    vec3 centre_b = vec_add(vec_madd(b->motion.start.p, lo, b->motion.linear), s->arm_b);
    out->status = TOI_HIT;
    out->lo = lo;
    out->hi = hi;
    out->gap_lo = gap - s->error;
    out->gap_hi = gap + s->error;
    out->axis = direction_of(there);
    out->point_a = vec_madd(centre_a, a->shape->radius, out->axis);
    out->point_b = vec_madd(centre_b, -b->shape->radius, out->axis);
    out->closing = -vec_dot(out->axis, s->velocity);
}

/* Never so near as to touch: at the time of the least distance, or at the end of the span. That time errs by some ulp,
 * the distance then by their square. */
static bool passes(const balls *s, double approach, double speed2, double span)
{
    double nearest = vec_norm(place(s, min_of(-approach / speed2, span)));
    return nearest > s->reach + 4 * s->error;
}

bool toi_spheres(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out)
{
    balls s;
    if (!balls_of(a, b, request, &s)) return false;
    double far2 = vec_norm2(s.from), far = sqrt(far2), speed2 = vec_norm2(s.velocity);
    double approach = vec_dot(s.from, s.velocity), rounding = 8 * UNIT_ROUNDOFF * far * sqrt(speed2);
    if (!(far > s.reach + s.error)) return false;
    if (approach > rounding || (approach < -rounding && passes(&s, approach, speed2, request->span))) {
        out->steps = 1;
        return true; /* free, as *out says */
    }
    double spare = (far - s.reach) * (far + s.reach), square = approach * approach - speed2 * spare;
    if (!(approach < 0 && square > 0)) return false;
    double root = sqrt(square), time = spare / (root - approach), aside = 0.25 * request->tolerance * s.reach / root;
    double lo = time - aside, hi = time + aside;
    if (!(lo > 0 && hi <= request->span)) return false;
    vec3 first = place(&s, lo), last = place(&s, hi);
    bool proven = vec_norm(first) > s.reach + s.error && vec_dot(first, s.velocity) < -rounding &&
                  vec_norm(last) <= s.reach - s.error;
    if (!proven) return false;
    tell(&s, a, b, lo, hi, out);
    out->steps = 1;
    return true;
}
