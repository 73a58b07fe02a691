/* toi_boxes: the march of toi.c with the fifteen axes of two boxes in place of distances. Each step takes the axis that
 * keeps them apart longest, as its gap and its rate say, and proves by the chord certificate how far it does. Cores of
 * balls and capsules are boxes, too. Pure; any thread.
 *
 * All is in the course's frame: world axes, the origin of A's body. */
#include "toi_boxes.h"

#include "moving_boxes.h"
#include "scalar.h"

enum { STEPS_MAX = 96, TRIES = 3 };

static const double FOLLOWED = 0.03;  /* of the reaches: with a smaller gap an axis is kept */
static const double DIP_SHARE = 0.75; /* of the gap that a step may use up by its bend */

/* ---- steps ---- */

/* The axis e x r across two edges, which both turn, is as long as the sine of the angle between them. Let f be its
 * product with the difference q of two corners. Then |f"| <= W^2 |q| + 2 W |q'| + |q"|, with W the sum of the angular
 * speeds; and the length, by which what counts as apart is multiplied, exceeds its chord by no more than W^2 h^2 / 8.
 * So a chord of gaps times lengths that stays above the sum proves them apart, however the length changes. */
static double bend_across(const moving_boxes *m, const box_axis *n, double from, double to)
{
    double w = m->c->spin_a.speed + m->c->spin_b.speed, apart = moving_boxes_apart(m, to);
    double far = course_far(m->c, from, to) + m->c->core_a + m->c->core_b;
    return (w * w * (far + apart) + 2 * w * m->c->speed + m->c->bend) / n->length * (1 + 64 * UNIT_ROUNDOFF);
}

static double own_bend(const moving_boxes *m, const box_axis *n, double from, double to)
{
    if (n->index >= EDGES) return bend_across(m, n, from, to);
    return course_bend(m->c, n->index < FACES_B ? COURSE_WITH_A : COURSE_WITH_B, from, to);
}

/* What is left of the gap at `to` along the axis of the same feature; across edges: times the ratio of the lengths. */
static double own_spare(const moving_boxes *m, const box_axis *n, const box_place *to)
{
    vec3 axis;
    double length = 1;
    if (n->index >= EDGES) {
        axis = vec_cross(
            moving_boxes_column(&to->a, (n->index - EDGES) / 3), moving_boxes_column(&to->b, (n->index - EDGES) % 3));
        length = vec_norm(axis);
    } else {
        axis = n->index < FACES_B ? moving_boxes_column(&to->a, n->index)
                                  : moving_boxes_column(&to->b, n->index - FACES_B);
    }
    double gap = moving_boxes_gap(m, to, n->turned ? vec_neg(axis) : axis) - (n->index >= EDGES ? m->error : 0);
    return (gap - moving_boxes_apart(m, to->time) * length) / n->length;
}

static double dip_of(double bend, double step)
{
    return bend * step * step / 8 * (1 + 0x1p-48);
}

/* What is certainly kept of the gap over a step, and at its end: along the axis that turns with its feature, or along
 * the one that stands still. */
static double spare_after(const moving_boxes *m, const box_place *from, box_axis *n, const box_place *to)
{
    double step = to->time - from->time, spare = n->gap - moving_boxes_apart(m, to->time), own = own_spare(m, n, to);
    double kept = min_of(own, spare) - dip_of(own_bend(m, n, from->time, to->time), step);
    n->curve = 2 * (own - spare - n->rate * step) / (step * step);
    if (kept > 0 || m->c->straight) return kept;
    double still =
        min_of(moving_boxes_gap(m, to, n->axis) - moving_boxes_apart(m, to->time), spare) - dip_of(m->c->bend, step);
    return max_of(kept, still);
}

static double proposed_step(
    const moving_boxes *m, const box_place *at, const box_axis *n, double spare, double aim, double left)
{
    double rate = n->rate - m->wander * at->time;
    double step = min_of(course_step_until_used(spare - aim, rate, m->wander), left);
    if (m->c->straight) return step;
    double bend = own_bend(m, n, at->time, at->time + step);
    step =
        min_of(step, course_step_until_used(spare - aim, rate, max_of(m->wander + 0.25 * bend - 1.01 * n->curve, 0)));
    return min_of(step, sqrt(DIP_SHARE * 8 * spare / bend));
}

/* The next place up to which they are apart. */
static bool advance(
    const moving_boxes *m, const box_place *at, box_axis *n, double tolerance, box_place *to, uint32_t *steps)
{
    double spare = n->gap - moving_boxes_apart(m, at->time), left = m->c->span - at->time;
    double aim = spare > tolerance ? 0.5 * tolerance : 0.25 * spare;
    double step = proposed_step(m, at, n, spare, aim, left);
    for (int k = 0; k < TRIES; k++) {
        moving_boxes_place(m, min_of(at->time + step, m->c->span), to);
        ++*steps;
        double after = spare_after(m, at, n, to);
        if (after > 0) return true;
        step *= min_of(max_of((spare - aim) / (spare - after), 0.125), 0.99);
    }
    double fastest = m->c->speed + m->wander * at->time; /* without any axis: no two points approach faster */
    step = course_step_until_used(spare * (1 - 64 * UNIT_ROUNDOFF), -fastest, m->wander);
    moving_boxes_place(m, min_of(at->time + step, m->c->span), to);
    return to->time > at->time;
}

bool toi_boxes_apply(const course *c)
{
    bool in_range = c->slack > 0x1p-350 && c->slack < 0x1p350; /* it is 2^-47 of the lengths: squares are finite */
    return c->a->type <= SHAPE_BOX && c->b->type <= SHAPE_BOX && c->b->type != SHAPE_SPHERE && in_range;
}

/* ---- the end ---- */

static void tell(const moving_boxes *m, const box_place *at, const box_axis *n, facing f, toi_result *out)
{
    double radius_a = m->c->a->radius, radius_b = m->c->b->radius, radius = radius_a + radius_b;
    out->lo = at->time;
    out->gap_lo = n->gap - radius - m->error;
    out->gap_hi = vec_norm(vec_sub(f.b, f.a)) - radius + m->error;
    out->axis = n->axis;
    out->point_a = vec_madd(f.a, radius_a, n->axis);
    out->point_b = vec_madd(f.b, -radius_b, n->axis);
    out->closing = -n->rate;
}

/* When they certainly touch, soon after a gap of `gap` is left; INFINITY: not proven. */
static double time_of_touch(moving_boxes *m, const box_place *at, const box_axis *n, double gap)
{
    double step = gap / max_of(-n->rate, 0x1p-10 * m->c->speed);
    for (int k = 0; k < TRIES && at->time + step <= m->c->span; k++) {
        box_place then;
        moving_boxes_place(m, at->time + step, &then);
        if (moving_boxes_touch(m, &then, n)) return then.time;
        step *= 1.5;
    }
    return INFINITY;
}

/* Within the tolerance of contact at `at`, which m->axes say, and the points that face each other along the axis are
 * the nearest: near, if that is all that is asked, or a hit, if it is proven that they touch a little later. */
static bool settle(
    moving_boxes *m, const box_place *at, const box_axis *n, const toi_request *request, bool rough, toi_result *out)
{
    double tolerance = request->tolerance, left = n->gap - moving_boxes_apart(m, at->time), hi = INFINITY;
    if (!(left <= tolerance) || !(n->rate < 0) || m->c->a->deviation + m->c->b->deviation > 0) return false;
    facing f = moving_boxes_facing(m, at, n);
    double wide = vec_norm(vec_sub(f.b, f.a)) - n->gap;
    if (!(wide <= 0.25 * tolerance) || (rough && !(left + wide <= tolerance))) return false;
    if (!rough) hi = time_of_touch(m, at, n, max_of(n->gap - m->reach, 0) + 0.25 * tolerance);
    if (!rough && (hi == INFINITY || m->wander > 0)) return false;
    tell(m, at, n, f, out);
    out->status = rough ? TOI_NEAR : TOI_HIT;
    out->hi = hi;
    return true;
}

/* Near contact it is not likely that another axis lasts longer; nor at all where neither turns. */
static bool is_worth_following(const moving_boxes *m, const box_axis *n, const box_place *at)
{
    return m->c->straight || n->gap - moving_boxes_apart(m, at->time) < FOLLOWED * (m->c->reach_a + m->c->reach_b);
}

double toi_boxes_march(const course *c, const toi_request *request, double from, bool rough, toi_result *out)
{
    moving_boxes m;
    moving_boxes_init(c, request, &m);
    box_place places[2];
    int now = 0;
    moving_boxes_place(&m, from, &places[now]);
    box_axis n = {.index = -1};
    bool follows = false;
    for (int k = 0; k < STEPS_MAX; k++) {
        const box_place *at = &places[now];
        follows = follows && moving_boxes_follow(&m, at, &n);
        if (follows && settle(&m, at, &n, request, rough, out)) return INFINITY;
        double spare = n.gap - moving_boxes_apart(&m, at->time);
        if (!follows || !(spare > request->tolerance) || c->straight) {
            if (!moving_boxes_best(&m, at, &n)) break;
            if (settle(&m, at, &n, request, rough, out)) return INFINITY;
            if (n.gap - moving_boxes_apart(&m, at->time) <= request->tolerance) break;
        }
        follows = is_worth_following(&m, &n, at);
        if (!advance(&m, at, &n, request->tolerance, &places[!now], &out->steps)) break;
        now = !now;
        if (places[now].time >= c->span) return INFINITY;
    }
    return places[now].time;
}
