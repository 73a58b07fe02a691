/* toi_primitives: the roots of an equation propose when two meet, distances at these times prove it. Pure; any thread.
 */
#include "course.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/unit_pair.h"

/* ---- two balls ---- */

/* The squared distance of two points that move along lines is a parabola in time, so that apart and still
 * approaching at `lo` proves that they were farther apart at all times before. The root only proposes lo and hi; the
 * answer is what the distances at these times prove, with their rounding. */

typedef struct balls {
    vec3 from, velocity; /* of B's centre, seen from A's */
    double reach;        /* m: the distance of the centres in contact */
    double error;        /* m: of any distance of the centres within the span */
    vec3 arm_a, arm_b;   /* from the bodies' origins to the centres, world axes */
} balls;

/* A centre moves straight if its body does not turn, or turns about it. */
static bool goes_straight(const toi_mover *m)
{
    return m->shape->type == SHAPE_SPHERE && !(m->shape->deviation > 0) &&
           (vec_greatest(m->motion.angular) == 0 || vec_greatest(m->local.p) == 0);
}

static bool moving_balls_in_range(double x)
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
    double size = vec_sum_magnitudes(between) + 2 * (vec_sum_magnitudes(a->local.p) + vec_sum_magnitudes(b->local.p)) +
                  a->shape->radius + b->shape->radius + fabs(r->threshold) +
                  r->span * (vec_sum_magnitudes(a->motion.linear) + vec_sum_magnitudes(b->motion.linear));
    s->error = 32 * UNIT_ROUNDOFF * size;
    return s->reach > 0 && moving_balls_in_range(size) && moving_balls_in_range(vec_norm2(s->velocity));
}

static vec3 moving_balls_place(const balls *s, double time)
{
    return vec_madd(s->from, time, s->velocity);
}

static void report_balls(const balls *s, const toi_mover *a, const toi_mover *b, double lo, double hi, toi_result *out)
{
    vec3 there = moving_balls_place(s, lo);
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
    double nearest = vec_norm(moving_balls_place(s, min_of(-approach / speed2, span)));
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
    vec3 first = moving_balls_place(&s, lo), last = moving_balls_place(&s, hi);
    bool proven = vec_norm(first) > s.reach + s.error && vec_dot(first, s.velocity) < -rounding &&
                  vec_norm(last) <= s.reach - s.error;
    if (!proven) return false;
    report_balls(&s, a, b, lo, hi, out);
    out->steps = 1;
    return true;
}

/* ---- a ball and a box ---- */

/* In the box's frame the ball's centre goes along a line, and contact is a distance of the centre from
 * the box. The square of that distance is a parabola between the times at which the centre crosses a plane of a face,
 * and convex all along. The roots only propose lo and hi; the answer is what the distances at these times prove,
 * with their rounding: a convex function that is positive and still falling at lo is positive at all times before. */

enum { PIECES_MAX = 7 }; /* a line crosses the planes of three pairs of faces */

typedef struct flight {
    mat3 axes;           /* of the box, in the world's */
    vec3 from, velocity; /* of the ball's centre, in the box's frame */
    vec3 half;
    double reach; /* m: the centre's distance from the box in contact */
    double error; /* m: of any such distance within the span */
    double speed; /* m/s, rounded up */
    vec3 arm_a;   /* from the body's origin to the ball's centre, world axes */
    double span;
} flight;

static bool turns(const toi_mover *m)
{
    return vec_greatest(m->motion.angular) > 0;
}

/* A ball may turn about its centre. */
static bool applies(const toi_mover *a, const toi_mover *b, const toi_request *r)
{
    bool kinds = a->shape->type == SHAPE_SPHERE && b->shape->type == SHAPE_BOX;
    return kinds && !turns(b) && !(turns(a) && vec_greatest(a->local.p) > 0) && !(r->wander > 0) &&
           !(a->shape->deviation > 0) && !(b->shape->deviation > 0);
}

/* What moves it by less than rounding within the span does not move it. */
static double speed_or_zero(double speed, const flight *f)
{
    return fabs(speed) * f->span > UNIT_ROUNDOFF * f->error ? speed : 0;
}

static bool flight_of(const toi_mover *a, const toi_mover *b, const toi_request *r, flight *f)
{
    if (!applies(a, b, r)) return false;
    vec3 between = vec_sub(a->motion.start.p, b->motion.start.p), line = vec_sub(a->motion.linear, b->motion.linear);
    f->axes = quat_matrix(quat_unit(quat_mul(b->motion.start.q, b->local.q)));
    f->arm_a = quat_rotate(a->motion.start.q, a->local.p);
    vec3 arms = vec_sub(f->arm_a, quat_rotate(b->motion.start.q, b->local.p));
    f->from = mat_tmul(f->axes, vec_add(between, arms));
    f->velocity = mat_tmul(f->axes, line);
    f->half = b->shape->half;
    f->span = r->span;
    f->reach = a->shape->radius + b->shape->radius + r->threshold;
    f->speed = vec_sum_magnitudes(f->velocity);
    double size = vec_sum_magnitudes(between) + 2 * (vec_sum_magnitudes(a->local.p) + vec_sum_magnitudes(b->local.p)) +
                  a->shape->radius + b->shape->radius + vec_sum_magnitudes(f->half) + fabs(r->threshold) +
                  2 * r->span * (vec_sum_magnitudes(a->motion.linear) + vec_sum_magnitudes(b->motion.linear));
    f->error = 64 * UNIT_ROUNDOFF * size;
    f->velocity =
        vec(speed_or_zero(f->velocity.x, f), speed_or_zero(f->velocity.y, f), speed_or_zero(f->velocity.z, f));
    return f->reach > 0 && moving_balls_in_range(size) && moving_balls_in_range(f->speed * f->speed) &&
           moving_balls_in_range(f->reach);
}

/* ---- what holds at a time ---- */

typedef struct moment {
    vec3 centre, off; /* `off`: from the nearest point of the box to the centre */
    double distance;
} moment;

static moment at_time(const flight *f, double time)
{
    vec3 c = vec_madd(f->from, time, f->velocity), h = f->half;
    vec3 off = vec(c.x - clamp_to(c.x, h.x), c.y - clamp_to(c.y, h.y), c.z - clamp_to(c.z, h.z));
    return (moment){c, off, vec_norm(off)};
}

/* m/s: how fast the distance grows. */
static double growth(const flight *f, const moment *m)
{
    return vec_dot(m->off, f->velocity) / m->distance;
}

/* ---- proposals ---- */

typedef struct slab {
    double enter, leave;
} slab;

/* While |from + time velocity| <= half. */
static slab slab_of(double from, double velocity, double half)
{
    if (velocity == 0) return fabs(from) <= half ? (slab){-INFINITY, INFINITY} : (slab){INFINITY, -INFINITY};
    double middle = -from / velocity, width = half / fabs(velocity);
    return (slab){middle - width, middle + width};
}

static slab slabs_of(const flight *f, double more)
{
    slab x = slab_of(f->from.x, f->velocity.x, f->half.x + more);
    slab y = slab_of(f->from.y, f->velocity.y, f->half.y + more);
    slab z = slab_of(f->from.z, f->velocity.z, f->half.z + more);
    return (slab){max_of(x.enter, max_of(y.enter, z.enter)), min_of(x.leave, min_of(y.leave, z.leave))};
}

static bool later(double time, double now, double next)
{
    return time > now && time < next;
}

/* The next time at which the centre crosses a plane of a face; INFINITY: never again. */
static double next_crossing(const flight *f, double now)
{
    const double from[3] = {f->from.x, f->from.y, f->from.z}, h[3] = {f->half.x, f->half.y, f->half.z};
    const double v[3] = {f->velocity.x, f->velocity.y, f->velocity.z};
    double next = INFINITY;
    for (int i = 0; i < 3; i++) {
        slab s = slab_of(from[i], v[i], h[i]);
        if (later(s.enter, now, next)) next = s.enter;
        if (later(s.leave, now, next)) next = s.leave;
    }
    return next;
}

/* A time of contact, or of the least distance where there is none: the pieces, one after the other, from `time` on. */
static double moving_balls_propose(const flight *f, double time, bool *touches)
{
    for (int k = 0; k < PIECES_MAX; k++) {
        double next = next_crossing(f, time), inside = next < INFINITY ? 0.5 * (time + next) : time + 1;
        moment now = at_time(f, time), within = at_time(f, inside);
        vec3 moving = vec(within.off.x != 0 ? f->velocity.x : 0, within.off.y != 0 ? f->velocity.y : 0,
            within.off.z != 0 ? f->velocity.z : 0);
        vec3 off = vec(
            within.off.x != 0 ? now.off.x : 0, within.off.y != 0 ? now.off.y : 0, within.off.z != 0 ? now.off.z : 0);
        double speed2 = vec_norm2(moving), approach = vec_dot(off, moving), far = vec_norm(off);
        double square = approach * approach - speed2 * (far - f->reach) * (far + f->reach);
        *touches = approach < 0 && square > 0;
        double step = *touches ? (far - f->reach) * (far + f->reach) / (sqrt(square) - approach)
                               : (speed2 > 0 ? max_of(-approach / speed2, 0) : 0);
        if (time + step <= next) return time + step;
        time = next;
    }
    *touches = false;
    return time;
}

/* ---- proofs ---- */

static void report_ball_and_box(
    const flight *f, const toi_mover *a, const toi_mover *b, double lo, double hi, const moment *m, toi_result *out)
{
    double radius_a = a->shape->radius, gap = m->distance - radius_a - b->shape->radius;
    vec3 centre = vec_add(vec_madd(a->motion.start.p, lo, a->motion.linear), f->arm_a);
    out->status = TOI_HIT;
    out->lo = lo;
    out->hi = hi;
    out->gap_lo = gap - f->error;
    out->gap_hi = gap + f->error;
    out->axis = direction_again(mat_mul(f->axes, vec_scale(m->off, -1 / m->distance)));
    out->point_a = vec_madd(centre, radius_a, out->axis);
    out->point_b = vec_madd(centre, m->distance - b->shape->radius, out->axis);
    out->closing = -growth(f, m);
}

/* The plane through the nearest point at `time` keeps them apart from 0 to the span: heights over it are linear. */
static bool apart_all_along(const flight *f, double time)
{
    moment m = at_time(f, time);
    double slope = growth(f, &m), less = slope > 0 ? slope * time : -slope * (f->span - time);
    return m.distance - less > f->reach + 4 * f->error;
}

bool toi_ball_box(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out)
{
    flight f;
    if (!flight_of(a, b, request, &f)) return false;
    moment first = at_time(&f, 0);
    if (!(first.distance > f.reach + f.error)) return false;
    slab near =
        slabs_of(&f, f.reach + 4 * f.error); /* farther than that along a face's normal, but within these times */
    bool touches = false, miss = near.enter > near.leave || near.leave < 0 || near.enter > f.span;
    double time = miss ? 0 : moving_balls_propose(&f, max_of(near.enter, 0), &touches);
    if (!touches || time > f.span) {
        if (!miss && !apart_all_along(&f, min_of(time, f.span))) return false;
        out->steps = 1;
        return true; /* free, as *out says */
    }
    moment contact = at_time(&f, time);
    double aside = 0.25 * request->tolerance / -growth(&f, &contact), lo = time - aside, hi = time + aside;
    if (!(aside > 0 && lo > 0 && hi <= f.span)) return false;
    moment before = at_time(&f, lo), after = at_time(&f, hi);
    bool proven = before.distance > f.reach + f.error && growth(&f, &before) < -64 * UNIT_ROUNDOFF * f.speed &&
                  after.distance <= f.reach - f.error;
    if (!proven) return false;
    report_ball_and_box(&f, a, b, lo, hi, &before, out);
    out->steps = 1;
    return true;
}
