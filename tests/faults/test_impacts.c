/* Impacts, predictions and teleports over both real links, by the client library: exact times, proven from both sides;
 * what is absurd is refused, told and counted. */
#include "rig.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const int64_t MS = 1000000;
enum { TOLD_MAX = 64 };

typedef struct told { /* copies: an event lives as long as its callback */
    collided_event event;
    collided_impact impact;
    char a[16], b[16], cause[16];
} told;

typedef struct room {
    collided *c;
    told at[TOLD_MAX];
    size_t count;
    size_t snapshots;
    char reason[32], message[16]; /* of the last refusal */
    int32_t object;
    size_t refused;
} room;

static void on_batch(void *context, const collided_batch *batch)
{
    room *r = context;
    r->snapshots += batch->snapshot;
    for (size_t i = 0; i < batch->event_count && r->count < TOLD_MAX; i++) {
        const collided_event *e = &batch->events[i];
        told *t = &r->at[r->count++];
        *t = (told){.event = *e};
        if (e->impact) t->impact = *e->impact;
        snprintf(t->a, sizeof t->a, "%s", e->name_a);
        snprintf(t->b, sizeof t->b, "%s", e->name_b);
        snprintf(t->cause, sizeof t->cause, "%s", e->cause);
    }
}

static void on_rejected(void *context, const collided_rejection *why)
{
    room *r = context;
    r->refused++;
    r->object = why->object;
    snprintf(r->reason, sizeof r->reason, "%s", why->reason);
    snprintf(r->message, sizeof r->message, "%s", why->message);
}

static collided_body create(room *r, const char *name, double x, collided_shape shape, collided_ccd ccd)
{
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &shape;
    def.shape_count = 1;
    def.ccd = ccd;
    def.stamp_ns = MS;
    def.pose.position[0] = x;
    collided_body body = collided_create_body(r->c, &def);
    if (body.id == COLLIDED_NONE) fail_msg("%s: %s", name, collided_error(r->c));
    return body;
}

static void enter(room *r, const char *uri, unsigned facts, double horizon_s)
{
    *r = (room){0};
    rig_daemon(NULL, NULL);
    r->c = rig_connect(uri, 5, COLLIDED_REMOVE);
    collided_on_rejected(r->c, on_rejected, r);
    collided_subscription_def def = collided_subscription_def_default();
    def.facts = facts;
    def.tolerance_m = 1e-9;
    def.horizon_s = horizon_s;
    def.callback = on_batch;
    def.context = r;
    assert_int_not_equal(collided_subscribe(r->c, &def).id, COLLIDED_NONE);
    UNTIL(r->c, RIG_PATIENCE_S, r->snapshots > 0);
}

static void settle(room *r)
{
    collided_result bodies = {0};
    assert_int_equal(collided_sync(r->c, RIG_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_query_bodies(r->c, "*", RIG_PATIENCE_S, &bodies), COLLIDED_OK);
    collided_result_free(&bodies);
}

static void put(room *r, collided_body body, double x, int64_t stamp_ns, const double *linear)
{
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    assert_int_equal(collided_publish(r->c, 1, &body, position, orientation, linear, NULL, stamp_ns, 0), COLLIDED_OK);
    collided_flush(r->c);
}

/* The next event of that kind from `*from` on. */
static const told *await(room *r, collided_event_kind kind, size_t *from)
{
    for (double end = rig_now_s() + RIG_PATIENCE_S;; collided_poll(r->c, 0.005)) {
        while (*from < r->count)
            if (r->at[(*from)++].event.kind == kind) return &r->at[*from - 1];
        if (rig_now_s() > end) fail_msg("no event of kind %d in time", (int)kind);
    }
}

static size_t count_of(const room *r, collided_event_kind kind)
{
    size_t n = 0;
    for (size_t i = 0; i < r->count; i++) n += r->at[i].event.kind == kind;
    return n;
}

static void expect_bracket(double lo, double hi, double truth)
{
    if (!(lo <= truth && truth <= hi && hi - lo < 1e-8)) fail_msg("%.12f is not in [%.12f, %.12f]", truth, lo, hi);
}

/* 2 m in 0.1 s through a wall of 0.1 m: a ball of 0.1 m at x = -1 touches it at x = -0.15, after 42.5 ms. */
static void a_fast_body_meets_the_thin_wall_that_it_flies_through(void **state)
{
    room r;
    enter(&r, *state, COLLIDED_IMPACT | COLLIDED_TOUCH, 0);
    collided_body bullet = create(&r, "bullet", -1, collided_sphere(0.1), COLLIDED_CCD_FULL);
    create(&r, "wall", 0, collided_box(0.1, 10, 10), COLLIDED_CCD_OFF);
    settle(&r);
    put(&r, bullet, 1, 101 * MS, NULL);
    size_t from = 0;
    const told *t = await(&r, COLLIDED_EVENT_IMPACT, &from);
    assert_string_equal(t->a, "bullet");
    assert_string_equal(t->b, "wall");
    expect_bracket(t->impact.lo_s, t->impact.hi_s, 0.0425);
    assert_true(t->impact.start_ns == MS && !t->impact.estimated);
    assert_true(fabs(t->impact.pose_a.position[0] + 0.15) < 1e-6 && t->impact.pose_b.position[0] == 0);
    assert_true(fabs(t->event.closing_m_s - 20) < 1e-6 && t->event.axis[0] > 0.999999);
    assert_true(fabs(t->event.point_a[0] + 0.05) < 1e-6);
    settle(&r);
    assert_int_equal(count_of(&r, COLLIDED_EVENT_IMPACT), 1);
    assert_int_equal(count_of(&r, COLLIDED_BEGIN), 0); /* at neither end does it touch */
    UNTIL(r.c, RIG_PATIENCE_S, rig_counter(r.c, "impacts") == 1);
    rig_close(r.c);
}

static void what_will_meet_is_predicted_and_averted(void **state)
{
    static const double fast[3] = {4, 0, 0}, slow[3] = {0.1, 0, 0};
    room r;
    enter(&r, *state, COLLIDED_PREDICT, 2);
    collided_body a = create(&r, "a", -3, collided_sphere(0.5), COLLIDED_CCD_OFF);
    create(&r, "b", 3, collided_sphere(0.5), COLLIDED_CCD_OFF);
    settle(&r);
    size_t from = 0;
    put(&r, a, -3, 1000 * MS, fast);
    const told *first = await(&r, COLLIDED_EVENT_PREDICTED, &from);
    expect_bracket(first->impact.lo_s, first->impact.hi_s, 1.25);
    assert_true(first->impact.start_ns == 1000 * MS && !first->impact.estimated);
    assert_true(fabs(first->event.closing_m_s - 4) < 1e-9 && first->event.age_a_s > 0);
    put(&r, a, -1, 1500 * MS, NULL); /* 2 m in half a second */
    const told *next = await(&r, COLLIDED_EVENT_PREDICTED, &from);
    expect_bracket(next->impact.lo_s, next->impact.hi_s, 0.75);
    assert_true(next->impact.estimated && next->event.contact == first->event.contact);
    put(&r, a, -1, 2000 * MS, slow);
    const told *last = await(&r, COLLIDED_EVENT_AVERTED, &from);
    assert_true(last->event.contact == first->event.contact && last->event.impact == NULL);
    assert_string_equal(last->cause, "motion");
    assert_int_equal(rig_counter(r.c, "undecided_sweeps"), 0);
    rig_close(r.c);
}

static void a_teleport_ends_what_touched_and_meets_nothing_on_its_way(void **state)
{
    static const double there[3] = {5, 0, 0}, orientation[4] = {1, 0, 0, 0};
    room r;
    enter(&r, *state, COLLIDED_IMPACT | COLLIDED_TOUCH, 0);
    collided_body a = create(&r, "a", -0.1, collided_sphere(0.1), COLLIDED_CCD_FULL);
    create(&r, "near", 0, collided_sphere(0.1), COLLIDED_CCD_OFF);
    create(&r, "wall", 2, collided_box(0.1, 10, 10), COLLIDED_CCD_OFF);
    create(&r, "far", 5.1, collided_sphere(0.1), COLLIDED_CCD_OFF);
    size_t from = 0;
    await(&r, COLLIDED_BEGIN, &from);
    settle(&r);
    assert_int_equal(collided_teleport(r.c, 1, &a, there, orientation, NULL, NULL, 0, 0), COLLIDED_OK);
    collided_flush(r.c);
    assert_string_equal(await(&r, COLLIDED_END, &from)->cause, "teleport");
    const told *t = await(&r, COLLIDED_BEGIN, &from);
    assert_true(strcmp(t->a, "far") == 0 || strcmp(t->b, "far") == 0);
    settle(&r);
    assert_int_equal(count_of(&r, COLLIDED_EVENT_IMPACT), 0);
    assert_int_equal(rig_counter(r.c, "impacts"), 0);
    rig_close(r.c);
}

static void a_pose_from_before_is_refused_and_changes_nothing(void **state)
{
    room r;
    enter(&r, *state, COLLIDED_TOUCH, 0);
    collided_body a = create(&r, "a", 0, collided_sphere(0.1), COLLIDED_CCD_FULL);
    settle(&r);
    put(&r, a, 1, 200 * MS, NULL);
    put(&r, a, 2, 100 * MS, NULL);
    UNTIL(r.c, RIG_PATIENCE_S, r.refused == 1);
    assert_string_equal(r.reason, "old_pose");
    assert_string_equal(r.message, "PoseBatch");
    assert_int_equal(r.object, a.id);
    UNTIL(r.c, RIG_PATIENCE_S, rig_counter(r.c, "reject_old_pose") == 1);
    collided_result bodies = {0};
    assert_int_equal(collided_query_bodies(r.c, "a", RIG_PATIENCE_S, &bodies), COLLIDED_OK);
    assert_true(bodies.count == 1 && bodies.hits[0].point_a[0] == 1);
    collided_result_free(&bodies);
    rig_close(r.c);
}

static void a_sweep_query_tells_what_would_be_met_and_when(void **state)
{
    static const double there[3] = {2, 0, 0}, back[3] = {-2, 0, 0}, spin[3] = {0, 0, 9e4}, nan[3] = {0, NAN, 0};
    room r;
    enter(&r, *state, COLLIDED_TOUCH, 0);
    create(&r, "a", -3, collided_sphere(0.5), COLLIDED_CCD_OFF);
    create(&r, "wall", 0, collided_box(0.1, 10, 10), COLLIDED_CCD_OFF);
    create(&r, "behind", 2, collided_sphere(0.5), COLLIDED_CCD_OFF);
    settle(&r);
    collided_result met = {0};
    assert_int_equal(collided_query_sweep(r.c, "a", there, NULL, 10, 1e-9, RIG_PATIENCE_S, &met), COLLIDED_OK);
    assert_int_equal(met.count, 1);
    assert_string_equal(met.hits[0].name_a, "wall");
    expect_bracket(met.hits[0].lo, met.hits[0].hi, 1.225);
    collided_result_free(&met);
    assert_int_equal(collided_query_sweep(r.c, "a", back, NULL, 10, 1e-9, RIG_PATIENCE_S, &met), COLLIDED_OK);
    assert_int_equal(met.count, 0);
    collided_result_free(&met);
    assert_int_equal(
        collided_query_sweep(r.c, "nobody", there, NULL, 10, 1e-9, RIG_PATIENCE_S, &met), COLLIDED_UNKNOWN_ID);
    assert_int_equal(
        collided_query_sweep(r.c, "a", NULL, spin, 86400, 1e-9, RIG_PATIENCE_S, &met), COLLIDED_UNSUPPORTED);
    assert_non_null(strstr(collided_error(r.c), "it would turn by more than"));
    assert_int_equal(collided_query_sweep(r.c, "a", nan, NULL, 10, 1e-9, RIG_PATIENCE_S, &met), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_query_sweep(r.c, "a", there, NULL, 0, 1e-9, RIG_PATIENCE_S, &met), COLLIDED_BAD_ARGUMENT);
    rig_close(r.c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER_BOTH(a_fast_body_meets_the_thin_wall_that_it_flies_through),
        OVER_BOTH(what_will_meet_is_predicted_and_averted),
        OVER_BOTH(a_teleport_ends_what_touched_and_meets_nothing_on_its_way),
        OVER_BOTH(a_pose_from_before_is_refused_and_changes_nothing),
        OVER_BOTH(a_sweep_query_tells_what_would_be_met_and_when)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
