/* Impacts, what is predicted, and teleports through the daemon: what several poses of one tick make of a way, which
 * poses are refused, and that all of it replays with the same hash for any number of workers. */
#include "cell.h"
#include "wire/one_shape.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

enum { ALICE = 11, BODIES = 16, STEPS = 120, SUBSCRIPTION = 4 };
static const int64_t MS = 1000000, START_NS = INT64_C(1700000000000000000);
static const double HORIZON_S = 0.75;

static char folder[] = "/tmp/collided-impacts-XXXXXX";

typedef struct room {
    cell *daemon;
    memory_end *alice;
    wire_memory *memory;
    int64_t sequence;
} room;

/* ---- what alice says ---- */

static void send_body(room *r, int32_t body, double x, const double half[3], double radius, uint8_t ccd)
{
    char name[16];
    snprintf(name, sizeof name, "body%d", (int)body);
    one_shape s = one_shape_at(half[0] > 0 ? WIRE_SHAPE_BOX : WIRE_SHAPE_SPHERE, x);
    memcpy(s.size, half, sizeof s.size);
    s.radius[0] = radius;
    wire_message m = one_shape_body(&s, ALICE, ++r->sequence, body, name);
    m.body.ccd = ccd;
    m.body.acceleration_m_s2 = 0.25 * body;
    m.body.angular_acceleration_rad_s2 = 0.125 * body;
    m.body.stamp_ns = START_NS;
    memory_send(r->alice, &m);
}

static const double BALL[3] = {0, 0, 0}, WALL[3] = {0.05, 5, 5};

static void send_pose(room *r, int32_t body, double x, int64_t stamp_ns, const double *linear, bool teleports)
{
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    const uint8_t yes[1] = {1};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .stamp_ns = stamp_ns,
            .bodies = {1, &body},
            .positions = {3, position},
            .orientations = {4, orientation},
            .linear = {linear ? 3 : 0, linear},
            .teleports = {teleports, yes}}};
    memory_send(r->alice, &m);
}

static void send_subscription(room *r)
{
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .subscription = SUBSCRIPTION,
            .facts = WIRE_FACT_TOUCH | WIRE_FACT_IMPACT | WIRE_FACT_PREDICT,
            .stream = "",
            .select_a = "*",
            .select_b = "*",
            .tolerance_m = 1e-9,
            .horizon_s = HORIZON_S}};
    memory_send(r->alice, &m);
}

static void settle(room *r)
{
    cell_settle(r->alice, r->memory, ALICE, ++r->sequence);
}

static void enter(room *r, const config *c)
{
    r->daemon = cell_start(c);
    r->alice = cell_client(r->daemon);
    r->memory = wire_memory_create();
    r->sequence = 0;
    cell_hello(r->alice, ALICE, ++r->sequence, 60, WIRE_LOST_REMOVE);
}

static void leave(room *r)
{
    memory_disconnect(r->alice);
    wire_memory_destroy(r->memory);
    assert_int_equal(cell_stop(r->daemon), 0);
}

static int64_t counter(room *r, const char *name)
{
    for (int i = 0; i < 2; i++) cell_await(r->alice, r->memory, WIRE_STATUS); /* the first may be of before */
    wire_message m = cell_await(r->alice, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

/* ---- a way of several poses ---- */

/* The next event of that kind; its entry in the impact arrays, which events of that kind have one of. */
static wire_event_batch await_event(room *r, uint8_t kind, uint32_t *event, uint32_t *impact)
{
    for (;;) {
        const wire_event_batch b = cell_await(r->alice, r->memory, WIRE_EVENT_BATCH).event_batch;
        for (*event = *impact = 0; *event < b.kinds.count; ++*event) {
            if (b.kinds.at[*event] == kind) return b;
            *impact += b.kinds.at[*event] == WIRE_EVENT_IMPACT || b.kinds.at[*event] == WIRE_EVENT_PREDICTED;
        }
    }
}

/* At 20 m/s from x = -1, the ball of 0.1 m meets the wall, which begins at -0.05, after 42.5 ms: whichever poses of the
 * burst fall into one tick. Mostly all do, and then the way is that of the whole burst. */
static void poses_of_one_tick_make_one_way(void **state)
{
    (void)state;
    static const double along[] = {-0.6, -0.4, 0.4, 0.6, 1};
    config c = cell_config();
    c.rate = 5;
    room r;
    enter(&r, &c);
    send_body(&r, 0, -1, BALL, 0.1, WIRE_CCD_FULL);
    send_body(&r, 1, 0, WALL, 0, WIRE_CCD_OFF);
    send_subscription(&r);
    settle(&r);
    bool merged = false;
    int64_t shots = 0, begin_ns = START_NS;
    for (; !merged && shots < 10; shots++) {
        begin_ns += 1000 * MS;
        send_pose(&r, 0, -1, begin_ns, NULL, true);
        settle(&r);
        for (int i = 0; i < 5; i++)
            send_pose(&r, 0, along[i], begin_ns + (int64_t)((along[i] + 1) * 50 * (double)MS), NULL, false);
        uint32_t event, k;
        wire_event_batch b = await_event(&r, WIRE_EVENT_IMPACT, &event, &k);
        double since_s = 1e-9 * (double)(b.impact_starts_ns.at[k] - begin_ns);
        assert_true(since_s + b.impact_times.at[2 * k] <= 0.0425 + 1e-9);
        assert_true(since_s + b.impact_times.at[2 * k + 1] >= 0.0425 - 1e-9);
        assert_true(b.impact_times.at[2 * k + 1] - b.impact_times.at[2 * k] < 1e-8);
        merged = b.impact_starts_ns.at[k] == begin_ns;
        settle(&r);
    }
    assert_true(merged);
    assert_int_equal(counter(&r, "impacts"), shots);
    leave(&r);
}

/* ---- poses that are refused ---- */

static void a_pose_from_before_is_refused_and_told(void **state)
{
    (void)state;
    config c = cell_config();
    room r;
    enter(&r, &c);
    send_body(&r, 0, 0, BALL, 0.1, WIRE_CCD_FULL);
    send_body(&r, 1, 2, BALL, 0.1, WIRE_CCD_FULL);
    send_subscription(&r);
    send_pose(&r, 0, 1, START_NS + 20 * MS, NULL, false);
    settle(&r);
    send_pose(&r, 0, 2, START_NS + 10 * MS, NULL, false); /* would touch body1 */
    wire_reject why = cell_await(r.alice, r.memory, WIRE_REJECT).reject;
    assert_int_equal(why.reason, WIRE_OLD_POSE);
    assert_int_equal(why.kind, WIRE_POSE_BATCH);
    assert_int_equal(why.object, 0);
    assert_int_equal(why.sequence, r.sequence);
    assert_int_equal(counter(&r, "reject_old_pose"), 1);
    assert_int_equal(counter(&r, "contacts"), 0);
    send_pose(&r, 0, 2, START_NS + 10 * MS, NULL, true); /* a teleport may */
    uint32_t event, k;
    await_event(&r, WIRE_EVENT_BEGIN, &event, &k);
    assert_int_equal(counter(&r, "reject_old_pose"), 1);
    leave(&r);
}

/* ---- recordings ---- */

/* Balls that swing through each other, with and without stamps and velocities; some are put elsewhere. */
static void play(room *r, bool record_from_the_middle)
{
    for (int32_t i = 0; i < BODIES; i++) send_body(r, i, i, i % 5 ? BALL : WALL, i % 5 ? 0.1 : 0, (uint8_t)(i % 3));
    send_subscription(r);
    for (int step = 1; step <= STEPS; step++) {
        if (record_from_the_middle && step == STEPS / 2) {
            settle(r);
            wire_message q = {.kind = WIRE_QUERY,
                .query = {.version = WIRE_VERSION,
                    .client = ALICE,
                    .sequence = ++r->sequence,
                    .kind = WIRE_QUERY_RECORD,
                    .name_a = "middle",
                    .name_b = ""}};
            memory_send(r->alice, &q);
            assert_int_equal(cell_await(r->alice, r->memory, WIRE_ANSWER).answer.status, WIRE_ANSWER_OK);
        }
        for (int32_t i = 0; i < BODIES; i++) {
            const double phase = 0.7 * step + i, linear[3] = {70 * cos(phase), 0, 0};
            int64_t stamp_ns = i % 4 ? START_NS + 10 * step * MS : 0;
            if ((step + i) % 3) send_pose(r, i, i + sin(phase), stamp_ns, i % 2 ? linear : NULL, (step * i) % 17 == 16);
        }
        if (step % 3 == 0) settle(r); /* so that there are many ticks, of several poses each */
    }
    settle(r);
}

static void a_session_of_impacts_replays_with_the_same_hash(void **state)
{
    (void)state;
    config c = cell_config();
    snprintf(c.record, sizeof c.record, "%s/session.lcmlog", folder);
    room r;
    enter(&r, &c);
    play(&r, false);
    assert_true(counter(&r, "impacts") > 100);
    assert_true(counter(&r, "predicted") > 100);
    assert_int_equal(counter(&r, "undecided_sweeps"), 0);
    leave(&r);
    static const long workers[] = {1, 2, 8};
    for (int i = 0; i < 3; i++) assert_int_equal(cell_replay(c.record, workers[i], true), EX_OK);
    assert_int_equal(cell_replay(c.record, 1, false), EX_OK);
    static const double margins[] = {0, 0.02, 0.5, 3};
    static const char *const broads[] = {"auto", "tree", "sweep1", "sweep3"};
    for (int i = 0; i < 4; i++) {
        config as = cell_config();
        as.margin = margins[i];
        as.workers = 2 * i + 1;
        snprintf(as.broad, sizeof as.broad, "%s", broads[i]);
        if (cell_replay_as(c.record, as) != EX_OK) fail_msg("margin %g, broad %s", margins[i], broads[i]);
    }
}

typedef struct findings {
    int bodies, subscriptions;
} findings;

static void look(void *context, const wire_log_entry *e)
{
    findings *found = context;
    const wire_message *m = &e->message;
    if (e->kind != WIRE_LOG_MESSAGE) return;
    if (m->kind == WIRE_BODY) {
        found->bodies++;
        assert_int_equal(m->body.ccd, m->body.body % 3);
        assert_true(m->body.acceleration_m_s2 == 0.25 * m->body.body);
        assert_true(m->body.angular_acceleration_rad_s2 == 0.125 * m->body.body);
        assert_true(m->body.stamp_ns >= (m->body.body % 4 ? START_NS : 0));
    } else if (m->kind == WIRE_SUBSCRIPTION) {
        found->subscriptions++;
        assert_true(m->subscription.horizon_s == HORIZON_S);
        assert_int_equal(m->subscription.facts, WIRE_FACT_TOUCH | WIRE_FACT_IMPACT | WIRE_FACT_PREDICT);
    }
}

/* Is all told there that impacts and predictions rest on? */
static void expect_motions_in(const char *path)
{
    findings found = {0};
    cell_read(path, look, &found);
    assert_int_equal(found.bodies, BODIES);
    assert_int_equal(found.subscriptions, 1);
}

static void a_recording_from_the_middle_keeps_what_motions_need(void **state)
{
    (void)state;
    char path[sizeof folder + 32];
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    room r;
    enter(&r, &c);
    play(&r, true);
    leave(&r);
    expect_motions_in(path);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int drop_folder(void **state)
{
    (void)state;
    char path[sizeof folder + 32];
    snprintf(path, sizeof path, "%s/session.lcmlog", folder);
    unlink(path);
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    unlink(path);
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_of_one_tick_make_one_way),
        cmocka_unit_test(a_pose_from_before_is_refused_and_told),
        cmocka_unit_test(a_session_of_impacts_replays_with_the_same_hash),
        cmocka_unit_test(a_recording_from_the_middle_keeps_what_motions_need),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
