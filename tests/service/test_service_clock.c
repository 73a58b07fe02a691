/* Clocks that jump: the wall clock is set back and forth under a running service, which is driven tick by tick with a
 * clock of the test's own. Poses go on to be taken, deadlines run out when they should, rates hold nothing back for
 * longer than they say, leases follow the monotonic clock, and a recording across jumps replays to the same hash. */
#include "cell.h"
#include "service/clients.h"
#include "service/recordings.h"
#include "service/server.h"
#include "service/service.h"
#include "wire/one_shape.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static const int64_t TICK_NS = 10000000, WALL_NS = INT64_C(1700000000000000000), HOUR_NS = INT64_C(3600000000000);
enum { OWNER = 1, WATCHER, MOVED = 0, FIXED = 1, DEADLINE_TICKS = 20 };

typedef struct rig {
    server *server;
    service *service;
    link_sink sink;
    memory_end *end;
    wire_memory *memory;
    int64_t monotonic_ns, ahead_ns, sequence;
    size_t kinds[WIRE_EVENT_AVERTED + 1]; /* events that came */
    size_t rejects;
    bool grows_old; /* on purpose */
    double x;
} rig;

static void send_body(rig *r, int32_t number, const char *name, double x, int64_t deadline_ns)
{
    one_shape s = one_shape_at(WIRE_SHAPE_SPHERE, x);
    s.radius[0] = 1;
    wire_message m = one_shape_body(&s, OWNER, ++r->sequence, number, name);
    m.body.motion = number == FIXED ? WIRE_MOTION_FIXED : WIRE_MOTION_MOVING;
    m.body.deadline_ns = deadline_ns;
    m.body.stamp_ns = r->monotonic_ns + r->ahead_ns;
    memory_send(r->end, &m);
}

static void send_pose(rig *r)
{
    const int32_t body[1] = {MOVED};
    const double position[3] = {r->x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = OWNER,
            .sequence = ++r->sequence,
            .stamp_ns = r->monotonic_ns + r->ahead_ns,
            .bodies = {1, body},
            .positions = {3, position},
            .orientations = {4, orientation}}};
    memory_send(r->end, &m);
}

static void subscribe(rig *r, double rate_hz)
{
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = WATCHER,
            .sequence = ++r->sequence,
            .facts = WIRE_FACT_TOUCH,
            .stream = "",
            .select_a = "*",
            .select_b = "*",
            .tolerance_m = 1e-9,
            .rate_hz = rate_hz}};
    memory_send(r->end, &m);
}

static void listen(rig *r)
{
    wire_message m;
    for (wire_memory_reset(r->memory); memory_receive(r->end, r->memory, &m); wire_memory_reset(r->memory)) {
        r->rejects += m.kind == WIRE_REJECT;
        for (uint32_t i = 0; m.kind == WIRE_EVENT_BATCH && i < m.event_batch.kinds.count; i++) {
            r->kinds[m.event_batch.kinds.at[i]]++;
            int64_t a = m.event_batch.ages_a_ns.at[i], b = m.event_batch.ages_b_ns.at[i];
            assert_true(r->grows_old || (a > b ? a : b) < (DEADLINE_TICKS + 2) * TICK_NS); /* no jump makes it old */
        }
    }
}

static void tick_once(rig *r)
{
    r->service->tick++;
    service_tick(r->service);
    listen(r);
}

/* A round as the server makes it. */
static void turn(rig *r)
{
    service *s = r->service;
    r->monotonic_ns += TICK_NS;
    s->monotonic_ns = r->monotonic_ns;
    s->now_ns = r->monotonic_ns + r->ahead_ns;
    if (service_clock_back(s)) tick_once(r);
    s->links[0]->ops->receive(s->links[0], &r->sink);
    session_check_leases(s);
    tick_once(r);
}

static void rig_open(rig *r, double rate_hz, const char *record)
{
    char why[256];
    config c = cell_config();
    if (record) snprintf(c.record, sizeof c.record, "%s", record);
    *r = (rig){.memory = wire_memory_create(), .monotonic_ns = HOUR_NS, .ahead_ns = WALL_NS, .x = 1};
    r->server = server_create(&c, why, sizeof why);
    if (!r->server) fail_msg("%s", why);
    r->service = server_service(r->server);
    r->sink = server_sink(r->server);
    r->end = memory_connect("cell");
    cell_hello(r->end, OWNER, ++r->sequence, 0.5, WIRE_LOST_REMOVE);
    cell_hello(r->end, WATCHER, ++r->sequence, 3600, WIRE_LOST_REMOVE);
    send_body(r, FIXED, "fixed", 0, 0);
    send_body(r, MOVED, "moved", r->x, DEADLINE_TICKS * TICK_NS);
    subscribe(r, rate_hz);
    turn(r);
    turn(r);
    assert_int_equal(r->kinds[WIRE_EVENT_BEGIN], 1);
}

static void rig_close(rig *r)
{
    record_stop_now(r->service);
    memory_disconnect(r->end);
    server_destroy(r->server);
    wire_memory_destroy(r->memory);
}

/* So many rounds, in each of which the body moves a little; it touches all along. */
static void move_on(rig *r, int rounds)
{
    for (int i = 0; i < rounds; i++) {
        r->x = i % 2 ? 1 : 1.01;
        send_pose(r);
        turn(r);
    }
}

static void poses_go_on_to_be_taken(rig *r)
{
    size_t updates = r->kinds[WIRE_EVENT_UPDATE];
    move_on(r, 50);
    assert_in_range(r->kinds[WIRE_EVENT_UPDATE] - updates, 49, 50);
    assert_int_equal(r->rejects, 0);
    assert_int_equal(r->kinds[WIRE_EVENT_END], 0);
}

static void an_hour_back_refuses_no_pose_and_an_hour_on_neither(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, 0, NULL);
    poses_go_on_to_be_taken(&r);
    r.ahead_ns -= HOUR_NS;
    poses_go_on_to_be_taken(&r);
    assert_int_equal(metric_get(r.service->count.clock_steps), 1);
    r.ahead_ns -= 48 * HOUR_NS;
    poses_go_on_to_be_taken(&r);
    assert_true(session_find(r.service, OWNER)->latest_pose_ns <= r.service->now_ns); /* its age in Status */
    assert_int_equal(r.kinds[WIRE_EVENT_UNKNOWN], 0);
    r.ahead_ns -= TICK_NS / 10; /* slewed: no step */
    poses_go_on_to_be_taken(&r);
    assert_int_equal(metric_get(r.service->count.clock_steps), 2);
    rig_close(&r);
}

/* It was on its way when the clock was set back. */
static void a_stamp_of_the_clock_before_holds_nothing_up(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, 0, NULL);
    move_on(&r, 10);
    r.ahead_ns -= HOUR_NS;
    turn(&r);
    r.ahead_ns += HOUR_NS;
    send_body(&r, MOVED, "moved", 1, DEADLINE_TICKS * TICK_NS);
    r.ahead_ns -= HOUR_NS;
    turn(&r);
    poses_go_on_to_be_taken(&r);
    rig_close(&r);
}

static void a_deadline_runs_out_in_its_time_though_the_clock_was_set_back(void **state)
{
    (void)state;
    for (int goes_on = 0; goes_on < 2; goes_on++) { /* poses come after the jump, or not */
        rig r;
        rig_open(&r, 0, NULL);
        move_on(&r, 30);
        r.ahead_ns -= HOUR_NS;
        if (goes_on) move_on(&r, 10);
        cell_hello(r.end, OWNER, ++r.sequence, 3600, WIRE_LOST_REMOVE);
        for (int i = 0; i < DEADLINE_TICKS - 2; i++) turn(&r);
        assert_int_equal(r.kinds[WIRE_EVENT_UNKNOWN], 0);
        for (int i = 0; i < 4; i++) turn(&r);
        assert_true(r.kinds[WIRE_EVENT_UNKNOWN] > 0);
        rig_close(&r);
    }
}

static void a_rate_holds_nothing_back_for_an_hour(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, 20, NULL);
    move_on(&r, 50);
    r.ahead_ns -= HOUR_NS;
    size_t updates = r.kinds[WIRE_EVENT_UPDATE];
    move_on(&r, 51);
    assert_in_range(r.kinds[WIRE_EVENT_UPDATE] - updates, 9, 12);
    rig_close(&r);
}

static void leases_follow_the_other_clock(void **state)
{
    (void)state;
    for (int back = 0; back < 2; back++) {
        rig r;
        rig_open(&r, 0, NULL);
        r.grows_old = true;
        r.ahead_ns += back ? -HOUR_NS : HOUR_NS;
        for (int i = 0; i < 10; i++) { /* a heartbeat in good time */
            cell_hello(r.end, OWNER, ++r.sequence, 0.5, WIRE_LOST_REMOVE);
            for (int k = 0; k < 40; k++) turn(&r);
        }
        assert_int_equal(metric_get(r.service->count.clients_lost), 0);
        for (int i = 0; i < 12; i++) turn(&r);
        assert_int_equal(metric_get(r.service->count.clients_lost), 1);
        rig_close(&r);
    }
}

static void a_recording_across_jumps_replays_to_the_same_hash(void **state)
{
    (void)state;
    char path[] = "/tmp/clock_XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    unlink(path);
    rig r;
    rig_open(&r, 20, path);
    r.grows_old = true;
    for (int i = 0; i < 6; i++) {
        move_on(&r, 30);
        r.ahead_ns += i % 3 ? -HOUR_NS : 2 * HOUR_NS;
    }
    for (int i = 0; i < 2 * DEADLINE_TICKS; i++) turn(&r);
    rig_close(&r);
    assert_int_equal(cell_replay(path, 1, true), 0);
    assert_int_equal(cell_replay(path, 2, false), 0);
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(an_hour_back_refuses_no_pose_and_an_hour_on_neither),
        cmocka_unit_test(a_stamp_of_the_clock_before_holds_nothing_up),
        cmocka_unit_test(a_deadline_runs_out_in_its_time_though_the_clock_was_set_back),
        cmocka_unit_test(a_rate_holds_nothing_back_for_an_hour), cmocka_unit_test(leases_follow_the_other_clock),
        cmocka_unit_test(a_recording_across_jumps_replays_to_the_same_hash)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
