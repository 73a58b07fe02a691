/* toi: marches along the motion of two convex shapes from one proof to the next. Pure; any thread. */
#include "toi.h"

#include "course.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/unit_pair.h"
#include "sweep.h"

enum {
    STEPS_MAX = 512,   /* distances of one search: beyond it TOI_UNDECIDED */
    GUESS_STEPS = 400, /* steps that a search may take for which a guess is believed */
    GRAZES_MAX = 48,   /* of these, inside of the tolerance: beyond it TOI_NEAR */
    PROOFS_MAX = 24,   /* verdicts behind a place that is within the tolerance */
    SHRINKS_MAX = 3    /* tries of a step before the one that needs no proof */
};

static const double DIP_SHARE = 0.75; /* of the gap that a step may use up by its bend */

typedef struct march {
    const course *c;
    const toi_request *request;
    narrow_scratch *scratch;
    double target; /* m: the threshold, and above it what rounding may take away */
    toi_result *out;
    double time;
    bool rough;         /* within the tolerance is near enough: no proof of contact is looked for */
    course_place at;    /* that time */
    course_place ahead; /* where the last step that was tried ends */
    double ahead_time;  /* when it ends; 0: none was tried */
    narrow_result near; /* then, in A's frame */
    vec3 axis;          /* near.axis in the world's axes */
    double rate;        /* m/s: how fast the gap at the nearest points grows along the axis */
} march;

/* ---- one look ---- */

static vec3 in_frame(const march *m, vec3 point_in_a)
{
    return vec_add(m->at.arm, mat_mul(m->at.world_of_a, point_in_a));
}

static void march_look(march *m, double time, double tolerance)
{
    narrow_request r = {
        .facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY, .threshold = m->request->threshold};
    m->time = time;
    m->at = time > 0 && time == m->ahead_time ? m->ahead : course_at(m->c, time);
    narrow_query(m->c->a, m->c->b, &m->at.b_in_a, &r, NULL, m->scratch, &m->near);
    m->out->queries++;
    m->axis = direction_again(mat_mul(m->at.world_of_a, m->near.axis));
    vec3 velocity = m->c->body_b.linear;
    if (!m->c->straight)
        velocity = course_velocity(m->c, time, in_frame(m, m->near.point_a), in_frame(m, m->near.point_b));
    m->rate = vec_dot(m->axis, velocity);
}

/* m: the least gap that counts as apart at a time. */
static double march_floor_at(const march *m, double time)
{
    return m->target + 0.5 * m->request->wander * time * time * (1 + 4 * UNIT_ROUNDOFF);
}

/* What is left of the gap beyond that, proven. */
static double spare(const march *m)
{
    return m->near.lo - march_floor_at(m, m->time);
}

/* m/s: how fast it grows. */
static double spare_rate(const march *m)
{
    return m->rate - m->request->wander * m->time;
}

static bool touches(march *m, double time)
{
    course_place at = course_at(m->c, time);
    double threshold = m->request->threshold - m->c->slack; /* a verdict stops as soon as it says */
    narrow_request r = {.facts = NARROW_VERDICT, .tolerance = m->request->tolerance, .threshold = threshold};
    narrow_result n;
    narrow_query(m->c->a, m->c->b, &at.b_in_a, &r, NULL, m->scratch, &n);
    m->out->queries++;
    return n.hi <= threshold;
}

/* ---- steps ---- */

/* m: how far beyond the floor the gap along a direction certainly stays all along. Gaps stay above their chord less the
 * dip, and the floor rises along a parabola, which is below its own chord: so what holds at both ends holds between. */
static double kept_along(const march *m, vec3 axis)
{
    double end = m->c->span;
    course_place at = course_at(m->c, 0);
    double first = course_separation(m->c, &at, axis) - march_floor_at(m, 0);
    at = course_at(m->c, end);
    double last = course_separation(m->c, &at, axis) - march_floor_at(m, end);
    return min_of(first, last) - course_dip(m->c, end);
}

/* Does a direction prove it free? It may change the time but not the answer, so it must be certain that the march would
 * come to the same end, within STEPS_MAX. Where a gap of `kept` is always left, no look finds less than `kept` less the
 * width that it was asked for: 0.25 of the tolerance, which is less than kept / 8, or 0.05 of what the last look found.
 * After one that found less than 2.5 kept that leaves 0.875 kept, and one that found more has gone as much farther: on
 * the average of the looks no step is shorter than 0.87 kept / speed. */
static bool proves_free(const march *m, vec3 axis)
{
    double kept = kept_along(m, axis), speed = m->c->speed + m->request->wander * m->c->span;
    return kept > 2 * m->request->tolerance && speed * m->c->span < GUESS_STEPS * kept;
}

static double proven_spare(const march *m)
{
    return spare(m) * (1 - 64 * UNIT_ROUNDOFF);
}

/* Without any direction: no two points approach faster than the course's speed. */
static double sure_step(const march *m)
{
    return course_step_until_used(proven_spare(m), -(m->c->speed + m->request->wander * m->time), m->request->wander);
}

/* Straight: until the plane that separates them closes; for good if it does not. */
static double straight_step(const march *m)
{
    double rounding = 16 * UNIT_ROUNDOFF * (m->c->speed + m->request->wander * m->time);
    return course_step_until_used(proven_spare(m), spare_rate(m) - rounding, m->request->wander);
}

/* A plane's normal is its own, and always turns with it. */
static int frames_of(const course *c)
{
    return c->a->type == SHAPE_HALFSPACE || c->b->type == SHAPE_HALFSPACE ? COURSE_WITH_A : COURSE_FRAMES;
}

/* What the gap certainly keeps at the end of a step and on the way there, in the best of the frames. */
static double march_spare_after(march *m, double step)
{
    double best = -INFINITY, end = m->time + step;
    const course_place *to = &m->ahead;
    m->ahead = course_at(m->c, end);
    m->ahead_time = end;
    unit_pair p;
    unit_pair_init(&p, m->c->a, m->c->b, &to->b_in_a);
    for (int frame = COURSE_STILL; frame < frames_of(m->c); frame++) {
        double dip = course_bend(m->c, (course_frame)frame, m->time, end) * step * step / 8 * (1 + 0x1p-48);
        if (spare(m) - dip <= best) continue;
        vec3 axis = course_carry((course_frame)frame, &m->at, m->near.axis, to);
        double gap = unit_pair_separation(&p, axis, NULL, NULL) - march_floor_at(m, end);
        best = max_of(best, min_of(gap, spare(m)) - dip);
        if (best > 0) break;
    }
    return best;
}

/* The least bend up to the end of a step, of all frames. */
static double march_least_bend(const march *m, double step)
{
    double bend = INFINITY;
    for (int frame = COURSE_STILL; frame < frames_of(m->c); frame++)
        bend = min_of(bend, course_bend(m->c, (course_frame)frame, m->time, m->time + step));
    return bend;
}

/* By Newton's method, to where the gap is used up but for `aim` when the dip is taken off it; and no step is proven
 * over which the chord may dip by more than the gap that there is. */
static double march_proposed_step(const march *m, double gap, double aim, double left)
{
    double rate = spare_rate(m), wander = m->request->wander;
    double step = min_of(course_step_until_used(gap - aim, rate, wander), left), bend = march_least_bend(m, step);
    if (!(bend > 0)) return step;
    step = min_of(step, course_step_until_used(gap - aim, rate, wander + 0.25 * bend));
    return min_of(step, sqrt(DIP_SHARE * 8 * gap / bend));
}

/* The longest step, of those tried, that the chord proves free: the one proposed; then by the secant, which of a gap
 * that closes ever faster never takes too much. */
static double turning_step(march *m, double left)
{
    double gap = spare(m), aim = gap > m->request->tolerance ? 0.5 * m->request->tolerance : 0.25 * gap;
    double step = march_proposed_step(m, gap, aim, left), sure = sure_step(m);
    for (int k = 0; k < SHRINKS_MAX && step > sure; k++) {
        double after = march_spare_after(m, step);
        m->out->steps++;
        if (after > 0) return step;
        step *= min_of(max_of((gap - aim) / (gap - after), 0.125), 0.99);
    }
    return min_of(sure, left);
}

static double next_step(march *m)
{
    double left = m->request->span - m->time;
    return m->c->straight ? straight_step(m) : turning_step(m, left);
}

/* ---- the end ---- */

static void march_report(const march *m, toi_status status, double hi)
{
    toi_result *out = m->out;
    out->status = status;
    out->lo = m->time;
    out->hi = hi;
    out->gap_lo = m->near.lo - m->c->slack;
    out->gap_hi = m->near.hi + m->c->slack;
    out->axis = m->axis;
    out->point_a = in_frame(m, m->near.point_a);
    out->point_b = in_frame(m, m->near.point_b);
    out->closing = -m->rate;
}

/* Within the tolerance at m->time: goes on, ever farther, until contact is proven. False: it goes away again. */
static bool march_prove_contact(march *m)
{
    double span = m->request->span, threshold = m->request->threshold - m->c->slack;
    if (m->near.hi <= threshold || (m->near.lo <= threshold && touches(m, m->time))) {
        march_report(m, TOI_HIT, m->time);
        return true;
    }
    double gap = max_of(m->near.hi - threshold, 0) + 0.25 * m->request->tolerance; /* where it just touches, doubles
                                                                                      cannot tell */
    double step = gap / max_of(-m->rate, 0x1p-10 * m->c->speed);
    for (int k = 0; k < PROOFS_MAX; k++) {
        double time = min_of(m->time + step, span);
        if (touches(m, time)) {
            march_report(m, TOI_HIT, time);
            return true;
        }
        if (time >= span || m->rate * step > m->request->tolerance) return false;
        step *= k < 4 ? 1.5 : 4;
    }
    return false;
}

/* From `from` on. */
static void march_convex(march *m, double from)
{
    double span = m->request->span, tolerance = m->request->tolerance, coarse = INFINITY, time = from;
    int grazes = 0;
    for (int k = 0; k < STEPS_MAX; k++) {
        m->out->steps++;
        march_look(m, time, max_of(0.25 * tolerance, 0.05 * coarse));
        if (spare(m) <= tolerance && m->near.hi - m->near.lo > 0.25 * tolerance) march_look(m, time, 0.25 * tolerance);
        if (spare(m) <= tolerance) {
            if (!m->rough && march_prove_contact(m)) return;
            if (spare(m) <= 0.5 * tolerance) march_look(m, time, 0);
            bool stuck = spare(m) <= 0; /* what goes away for good is free, however near it was */
            if (!stuck && (m->rough || ++grazes > GRAZES_MAX)) stuck = next_step(m) < span - time;
            if (stuck) {
                march_report(m, TOI_NEAR, INFINITY);
                return;
            }
        }
        double step = next_step(m);
        if (step >= span - time) return; /* out->status is TOI_FREE */
        if (!(time + step > time)) break;
        coarse = spare(m);
        time += step;
    }
    march_report(m, spare(m) <= tolerance ? TOI_NEAR : TOI_UNDECIDED, INFINITY);
}

/* ---- two shapes ---- */

static const double WHOLE_TURNS = 6; /* rad: a shape that turns by more is first tried as what it sweeps */
static const double ROUGHLY = 0.01;  /* of its reach: how closely that is looked at */
static const double MANY_TURNS = 40; /* rad: the same for boxes, whose march is quick */

/* A time up to which what they sweep is apart; INFINITY: always. */
static double march_free_while_spun(const march *m, double from)
{
    shape spun[2];
    course spinning;
    toi_mover a = {m->c->a, m->c->local_a, m->c->body_a}, b = {m->c->b, m->c->local_b, m->c->body_b};
    if (a.shape->type == SHAPE_HALFSPACE) return 0; /* the cylinder would have to go first */
    toi_mover spun_a, spun_b;
    if (!course_spin(&a, &spun[0], &spun_a) || !course_spin(&b, &spun[1], &spun_b)) return 0;
    if (!course_init(&spinning, &spun_a, &spun_b, m->c->span)) return 0;
    toi_request request = *m->request;
    request.tolerance = max_of(request.tolerance, ROUGHLY * (spinning.reach_a + spinning.reach_b));
    toi_result r = {.status = TOI_FREE, .lo = INFINITY};
    march spin = {.c = &spinning, .request = &request, .scratch = m->scratch, .out = &r, .rough = true};
    spin.target = m->request->threshold + spinning.slack;
    march_convex(&spin, from);
    m->out->queries += r.queries;
    m->out->steps += r.steps;
    return r.status == TOI_FREE ? INFINITY : r.lo;
}

/* Along the line between what is nearest of their extents at first; a hull's extents are not known. */
static vec3 guess_axis(const course *c)
{
    course_place at = course_at(c, 0);
    return mat_mul(at.world_of_a, narrow_guess_axis(c->a, c->b, &at.b_in_a));
}

/* motion_pose, with the spin made ready. */
static pose pose_of(const motion *m, motion_spin spin, double time)
{
    return (pose){vec_madd(m->start.p, time, m->linear), motion_spun(spin, m->start.q, time)};
}

void toi_convex(const toi_mover *a, const toi_mover *b, const toi_request *request, vec3 guess, double from, bool rough,
    narrow_scratch *scratch, toi_result *out)
{
    course c;
    if (!course_bounds(&c, a, b, request->span)) {
        *out = (toi_result){.status = TOI_UNDECIDED,
            .hi = INFINITY,
            .gap_lo = -INFINITY,
            .gap_hi = INFINITY,
            .body_a = a->motion.start,
            .body_b = b->motion.start};
        return;
    }
    march m = {.c = &c, .request = request, .scratch = scratch, .out = out, .rough = rough};
    bool whole = from == 0;
    m.target = request->threshold + c.slack;
    from = max_of(from, course_balls_meet(&c, m.target, request->wander));
    if (from == INFINITY) return;
    bool boxes = toi_boxes_apply(&c) && m.target >= 0;
    if (!boxes) {
        course_make_places(&c);
        if (vec_greatest(guess) == 0 && whole) guess = guess_axis(&c);
        if (vec_greatest(guess) > 0 && proves_free(&m, guess)) return;
    }
    double turned = (c.spin_a.speed + c.spin_b.speed) * (request->span - from);
    if (turned > (boxes ? MANY_TURNS : WHOLE_TURNS)) from = max_of(march_free_while_spun(&m, from), from);
    if (boxes && from < request->span) {
        from = toi_boxes_march(&c, request, from, rough, out);
        if (from < request->span) course_make_places(&c);
    }
    if (from < request->span) march_convex(&m, from);
    if (out->status == TOI_FREE) return;
    out->body_a = pose_of(&a->motion, c.spin_a, out->lo);
    out->body_b = pose_of(&b->motion, c.spin_b, out->lo);
    out->point_a = vec_add(out->point_a, out->body_a.p);
    out->point_b = vec_add(out->point_b, out->body_a.p);
}

void toi_find(const toi_mover *a, const toi_mover *b, const toi_request *request, vec3 guess, narrow_scratch *scratch,
    toi_result *out)
{
    *out = (toi_result){.status = TOI_FREE, .lo = INFINITY, .hi = INFINITY};
    bool settled = toi_spheres(a, b, request, out) || toi_ball_box(a, b, request, out);
    if (!settled && !toi_parts_apply(a->shape, b->shape)) {
        toi_convex(a, b, request, guess, 0, request->wander > 0, scratch, out);
        return;
    }
    if (!settled) toi_walk(a, b, request, scratch, out);
    if (out->status == TOI_FREE) return;
    out->body_a = motion_pose(&a->motion, out->lo);
    out->body_b = motion_pose(&b->motion, out->lo);
}

const char *toi_status_name(toi_status status)
{
    static const char *const NAMES[] = {"free", "hit", "near", "undecided"};
    return (unsigned)status < sizeof NAMES / sizeof *NAMES ? NAMES[status] : "unknown";
}
