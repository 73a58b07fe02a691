/* What a step tells, by the client library, over both links: all of the first one, whatever is told of it once only; in
 * simulated time from its beginning; of poses that were refused; and ended now, ended twice, and waited for later, by
 * one client and by two. */
#include "rig.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SUBSCRIPTIONS = 4, MS = 1000000 };

typedef struct room {
    collided *c;
    size_t kinds[HEARD_KINDS];
    size_t rejections, batches;
    int32_t refused;
    char reason[32], refusal[32];
    int64_t step;
} room;

static void on_events(void *context, const collided_batch *b)
{
    room *r = context;
    for (size_t i = 0; i < b->event_count; i++)
        if (strcmp(b->events[i].cause, "snapshot") != 0) r->kinds[b->events[i].kind]++;
    r->batches++;
    r->step = b->step;
    r->refused = b->refused;
    snprintf(r->refusal, sizeof r->refusal, "%s", b->refusal);
}

static void on_rejected(void *context, const collided_rejection *why)
{
    room *r = context;
    r->rejections++;
    snprintf(r->reason, sizeof r->reason, "%s", why->reason);
}

static void subscribe(room *r, unsigned facts, const char *a)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.facts = facts;
    def.select_a = a;
    def.range_m = 0.5;
    def.horizon_s = 1;
    def.callback = on_events;
    def.context = r;
    assert_true(collided_subscribe(r->c, &def).id != COLLIDED_NONE);
}

static collided_body ball(room *r, const char *name, double x, double y)
{
    const collided_shape shape = collided_sphere(0.1);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.ccd = COLLIDED_CCD_FULL;
    def.pose.position[0] = x;
    def.pose.position[1] = y;
    def.shapes = &shape;
    def.shape_count = 1;
    return collided_create_body(r->c, &def);
}

static void enter(room *r, const char *uri, int32_t lock_step)
{
    collided_def def = collided_def_default();
    def.lease_s = RIG_PATIENCE_S;
    def.connect_timeout_s = RIG_PATIENCE_S;
    def.lock_step = lock_step;
    *r = (room){.c = collided_connect(uri, &def)};
    if (!r->c) fail_msg("%s", collided_connect_error());
    collided_on_rejected(r->c, on_rejected, r);
}

static void must(room *r, collided_status status)
{
    if (status != COLLIDED_OK) fail_msg("%s: %s", collided_status_text(status), collided_error(r->c));
}

static void sync_all(room *r)
{
    must(r, collided_sync(r->c, RIG_PATIENCE_S));
}

static void put_at(room *r, collided_body body, double x, double y, int64_t stamp_ns, int64_t step)
{
    const double position[3] = {x, y, 0}, turn[4] = {1, 0, 0, 0};
    must(r, collided_publish(r->c, 1, &body, position, turn, NULL, NULL, stamp_ns, step));
}

static void put(room *r, collided_body body, double x, int64_t stamp_ns, int64_t step)
{
    put_at(r, body, x, 0, stamp_ns, step);
}

/* What it has published has arrived: two clients overtake each other on the network. */
static void settle(room *r)
{
    collided_result result = {0};
    must(r, collided_query_bodies(r->c, "none", RIG_PATIENCE_S, &result));
    collided_result_free(&result);
}

/* ---- the first step ---- */

static void meet_in_the_first_step(const char *uri)
{
    room r;
    enter(&r, uri, 1);
    const char *const movers[SUBSCRIPTIONS] = {"bullet", "toucher", "comer", "runner"};
    const char *const posts[SUBSCRIPTIONS] = {"wall", "rock", "stone", "goal"};
    static const unsigned facts[SUBSCRIPTIONS] = {COLLIDED_IMPACT, COLLIDED_TOUCH, COLLIDED_DISTANCE, COLLIDED_PREDICT};
    static const double to[SUBSCRIPTIONS] = {1, -0.15, -0.4, -1};
    static const collided_event_kind expected[SUBSCRIPTIONS] = {
        COLLIDED_EVENT_IMPACT, COLLIDED_BEGIN, COLLIDED_NEAR, COLLIDED_EVENT_PREDICTED};
    collided_body moving[SUBSCRIPTIONS];
    for (int i = 0; i < SUBSCRIPTIONS; i++) {
        ball(&r, posts[i], 0, 10 * i);
        moving[i] = ball(&r, movers[i], -3, 10 * i);
        subscribe(&r, facts[i], movers[i]);
    }
    sync_all(&r);
    for (int i = 0; i < SUBSCRIPTIONS; i++) {
        const double position[3] = {to[i], 10 * i, 0}, turn[4] = {1, 0, 0, 0}, v[3] = {i == 3 ? 2 : 0, 0, 0};
        must(&r, collided_publish(r.c, 1, &moving[i], position, turn, v, NULL, 0, 1));
    }
    must(&r, collided_step(r.c, 1, RIG_PATIENCE_S));
    for (int i = 0; i < SUBSCRIPTIONS; i++)
        if (r.kinds[expected[i]] != 1) fail_msg("%s: %zu events", movers[i], r.kinds[expected[i]]);
    assert_int_equal(r.rejections, 0);
    rig_close(r.c);
}

/* Stateless events too, which no snapshot tells later. Discovery takes its time anew for each client and stream. */
static void the_first_step_tells_all_there_is(void **state)
{
    rig_daemon(NULL, NULL);
    int times = getenv("COLLIDED_NIGHTLY") ? 200 : 20;
    for (int i = 0; i < times; i++) meet_in_the_first_step(*state);
}

/* ---- time ---- */

/* Two in simulated time: one from zero on, one from an hour before it was announced. */
static void a_simulation_steps_in_its_own_time_from_the_beginning(void **state)
{
    rig_daemon(NULL, NULL);
    static const int64_t begins[] = {0, INT64_C(1600000000000000000)};
    for (int k = 0; k < 2; k++) {
        room r;
        enter(&r, *state, 1);
        ball(&r, "post", 0, 0);
        collided_body body = ball(&r, "body", -1, 0);
        subscribe(&r, COLLIDED_TOUCH | COLLIDED_IMPACT, "*");
        sync_all(&r);
        for (int n = 1; n <= 5; n++) {
            put(&r, body, n % 2 ? 1 : -1, begins[k] + n * MS, n);
            must(&r, collided_step(r.c, n, RIG_PATIENCE_S));
            assert_int_equal(r.kinds[COLLIDED_EVENT_IMPACT], n);
            assert_int_equal(r.refused, 0);
        }
        /* Changed, it is announced anew; the next pose is not older than that either. */
        const collided_shape bigger = collided_sphere(0.2);
        collided_body_def def = collided_body_def_default();
        def.name = "body", def.ccd = COLLIDED_CCD_FULL, def.pose.position[0] = 1;
        def.shapes = &bigger, def.shape_count = 1;
        must(&r, collided_change_body(r.c, body, &def));
        sync_all(&r);
        put(&r, body, -1, begins[k] + 6 * MS, 6);
        must(&r, collided_step(r.c, 6, RIG_PATIENCE_S));
        assert_int_equal(r.kinds[COLLIDED_EVENT_IMPACT], 6);
        assert_int_equal(r.rejections, 0);
        /* From its first pose on stamps order them. */
        put(&r, body, 1, begins[k] + 5 * MS, 7);
        assert_int_equal(collided_step(r.c, 7, RIG_PATIENCE_S), COLLIDED_REJECTED);
        rig_close(r.c);
    }
}

/* ---- what was refused ---- */

static void a_step_says_which_of_its_poses_were_refused(void **state)
{
    room r;
    rig_daemon(NULL, NULL);
    enter(&r, *state, 1);
    collided_body a = ball(&r, "a", 0, 0), b = ball(&r, "b", 5, 0);
    subscribe(&r, COLLIDED_TOUCH, "*");
    sync_all(&r);
    put(&r, a, 0, 10 * MS, 1);
    put(&r, b, 5, 10 * MS, 1);
    must(&r, collided_step(r.c, 1, RIG_PATIENCE_S));
    put(&r, a, 1, 9 * MS, 2); /* all of them */
    assert_int_equal(collided_step(r.c, 2, RIG_PATIENCE_S), COLLIDED_REJECTED);
    if (!strstr(collided_error(r.c), "step 2 is done, but 1 of this client's poses were refused: old_pose"))
        fail_msg("%s", collided_error(r.c));
    assert_int_equal(r.refused, 1);
    assert_string_equal(r.refusal, "old_pose");
    put(&r, a, 1, 9 * MS, 3); /* some of them */
    put(&r, b, 0.1, 20 * MS, 3);
    assert_int_equal(collided_step(r.c, 3, RIG_PATIENCE_S), COLLIDED_REJECTED);
    assert_int_equal(r.refused, 1);
    assert_int_equal(r.kinds[COLLIDED_BEGIN], 1); /* the other one was applied */
    put(&r, a, 0, 30 * MS, 4);
    must(&r, collided_step(r.c, 4, RIG_PATIENCE_S));
    must(&r, collided_step(r.c, 5, RIG_PATIENCE_S)); /* without any */
    assert_int_equal(r.refused, 0);
    assert_string_equal(r.refusal, "");
    UNTIL(r.c, RIG_PATIENCE_S, r.rejections == 2);
    rig_close(r.c);
}

/* A client that counts steps without lock-step reads it in the same place. */
static void so_does_the_answer_without_lock_step(void **state)
{
    room r;
    rig_daemon(NULL, NULL);
    enter(&r, *state, 0);
    collided_body a = ball(&r, "a", 0, 0);
    subscribe(&r, COLLIDED_TOUCH, "*");
    sync_all(&r);
    for (int64_t n = 1; n <= 3; n++) {
        put(&r, a, 0, n == 2 ? 5 * MS : 10 * n * MS, n);
        UNTIL(r.c, RIG_PATIENCE_S, r.step == n);
        assert_int_equal(r.refused, n == 2);
    }
    rig_close(r.c);
}

/* ---- now, and later ---- */

static void a_step_is_ended_now_and_waited_for_later(void **state)
{
    room r;
    rig_daemon(NULL, NULL);
    enter(&r, *state, 1);
    ball(&r, "post", 0, 0);
    collided_body body = ball(&r, "body", -1, 0);
    subscribe(&r, COLLIDED_TOUCH, "*");
    sync_all(&r);
    for (int64_t n = 1; n <= 40; n++) {
        put(&r, body, n % 2 ? -0.15 : -1, 0, n);
        for (int k = 0; k < n % 4; k++) {
            collided_status now = collided_step(r.c, n, 0);
            assert_true(now == COLLIDED_TIMEOUT || now == COLLIDED_OK);
        }
        must(&r, collided_step(r.c, n, RIG_PATIENCE_S));
        must(&r, collided_step(r.c, n, RIG_PATIENCE_S)); /* and whoever asks again hears the same */
        must(&r, collided_step(r.c, n, 0));
        assert_int_equal(r.kinds[COLLIDED_BEGIN], (n + 1) / 2);
        assert_int_equal(r.kinds[COLLIDED_END], n / 2);
    }
    assert_int_equal(r.rejections, 0);
    rig_close(r.c);
}

typedef struct two {
    room a, b;
    collided_body body_a[2], body_b;
} two;

static void enter_two(two *t, const char *uri)
{
    rig_daemon("--step_timeout", "20");
    enter(&t->a, uri, 2);
    enter(&t->b, uri, 2);
    t->body_a[0] = ball(&t->a, "a0", -1, 0);
    t->body_a[1] = ball(&t->a, "a1", -1, 5);
    t->body_b = ball(&t->b, "b", 0, 0);
    subscribe(&t->a, COLLIDED_TOUCH, "a*");
    subscribe(&t->b, COLLIDED_TOUCH, "a*");
    sync_all(&t->a);
    sync_all(&t->b);
}

static void close_two(two *t)
{
    rig_close(t->a.c);
    rig_close(t->b.c);
}

/* Who ends first, how often, and who waits first makes no difference. */
static void so_do_two(void **state)
{
    two t;
    enter_two(&t, *state);
    for (int64_t n = 1; n <= 30; n++) {
        put(&t.a, t.body_a[0], n % 2 ? -0.15 : -1, 0, n);
        for (int k = 0; k <= n % 3; k++) assert_int_equal(collided_step(t.a.c, n, 0), COLLIDED_TIMEOUT);
        if (n % 5) put(&t.b, t.body_b, 0, 0, n);
        (void)collided_step(t.b.c, n, 0);
        room *first = n % 2 ? &t.a : &t.b, *second = n % 2 ? &t.b : &t.a;
        must(first, collided_step(first->c, n, RIG_PATIENCE_S));
        must(second, collided_step(second->c, n, RIG_PATIENCE_S));
        assert_int_equal(t.a.kinds[COLLIDED_BEGIN], (n + 1) / 2);
        assert_int_equal(t.b.kinds[COLLIDED_BEGIN], (n + 1) / 2);
    }
    assert_int_equal(t.a.rejections + t.b.rejections, 0);
    close_two(&t);
}

/* Poses behind an end begin the step anew: with all of it, or that is refused; none vanishes. */
static void poses_behind_the_end_of_their_step_are_in_it_or_refused(void **state)
{
    two t;
    enter_two(&t, *state);
    put(&t.a, t.body_a[0], -0.15, 0, 1);
    assert_int_equal(collided_step(t.a.c, 1, 0), COLLIDED_TIMEOUT);
    put_at(&t.a, t.body_a[1], 0, 5, 0, 1); /* the other body alone */
    assert_int_equal(collided_step(t.a.c, 1, RIG_PATIENCE_S), COLLIDED_REJECTED);
    if (!strstr(collided_error(t.a.c), "send all of it again")) fail_msg("%s", collided_error(t.a.c));
    put(&t.a, t.body_a[0], -0.15, 0, 1);
    put_at(&t.a, t.body_a[1], 0, 5, 0, 1);
    assert_int_equal(collided_step(t.a.c, 1, 0), COLLIDED_TIMEOUT);
    put(&t.a, t.body_a[0], -0.18, 0, 1); /* all of it, otherwise */
    put_at(&t.a, t.body_a[1], 0, 6, 0, 1);
    assert_int_equal(collided_step(t.a.c, 1, 0), COLLIDED_TIMEOUT);
    settle(&t.a);
    must(&t.b, collided_step(t.b.c, 1, RIG_PATIENCE_S));
    must(&t.a, collided_step(t.a.c, 1, RIG_PATIENCE_S));
    assert_int_equal(t.a.kinds[COLLIDED_BEGIN], 1);
    put(&t.a, t.body_a[0], -0.18, 0, 1); /* a copy */
    must(&t.a, collided_step(t.a.c, 1, RIG_PATIENCE_S));
    put(&t.a, t.body_a[0], -0.3, 0, 1); /* too late */
    assert_int_equal(collided_step(t.a.c, 1, RIG_PATIENCE_S), COLLIDED_REJECTED);
    if (!strstr(collided_error(t.a.c), "step 1 is done, ")) fail_msg("%s", collided_error(t.a.c)); /* which way first */
    close_two(&t);
}

/* They belong to no step: that is said before the next one is ended without them. */
static void poses_of_the_next_step_too_early_are_refused(void **state)
{
    two t;
    enter_two(&t, *state);
    put(&t.a, t.body_a[0], -0.9, 0, 1);
    assert_int_equal(collided_step(t.a.c, 1, 0), COLLIDED_TIMEOUT);
    put(&t.a, t.body_a[0], -0.15, 0, 2);
    UNTIL(t.a.c, RIG_PATIENCE_S, t.a.rejections == 1);
    assert_string_equal(t.a.reason, "bad_step");
    must(&t.b, collided_step(t.b.c, 1, RIG_PATIENCE_S));
    must(&t.a, collided_step(t.a.c, 1, RIG_PATIENCE_S));
    assert_int_equal(collided_step(t.a.c, 2, RIG_PATIENCE_S), COLLIDED_REJECTED);
    put(&t.a, t.body_a[0], -0.15, 0, 2);
    assert_int_equal(collided_step(t.a.c, 2, 0), COLLIDED_TIMEOUT);
    must(&t.b, collided_step(t.b.c, 2, RIG_PATIENCE_S));
    must(&t.a, collided_step(t.a.c, 2, RIG_PATIENCE_S));
    assert_int_equal(t.a.kinds[COLLIDED_BEGIN], 1);
    close_two(&t);
}

int main(void)
{
    rig_isolate();
    const struct CMUnitTest tests[] = {
        OVER_BOTH(the_first_step_tells_all_there_is),
        OVER_BOTH(a_simulation_steps_in_its_own_time_from_the_beginning),
        OVER_BOTH(a_step_says_which_of_its_poses_were_refused),
        OVER_BOTH(so_does_the_answer_without_lock_step),
        OVER_BOTH(a_step_is_ended_now_and_waited_for_later),
        OVER_BOTH(so_do_two),
        OVER_BOTH(poses_behind_the_end_of_their_step_are_in_it_or_refused),
        OVER_BOTH(poses_of_the_next_step_too_early_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
