/* Lock-step of several simulators: a step is done when all have published it, as a whole; who misses it is told to all,
 * by policy; who is lost is not waited for; and a recording of it replays. */
#include "cell.h"

#include "service/service.h"

#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

enum { MEMBERS = 3, FIRST = 101 };

typedef struct hall {
    cell *cell;
    memory_end *end; /* hears all that the link sends */
    wire_memory *memory;
    int64_t sequences[MEMBERS + 1];
} hall;

static int64_t id_of(int k)
{
    return FIRST + k;
}

static void hello(hall *h, int k, int32_t lock_step, double lease_s)
{
    char name[16];
    snprintf(name, sizeof name, "sim%d", k);
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = id_of(k),
            .sequence = ++h->sequences[k],
            .on_loss = WIRE_LOST_REMOVE,
            .lease_ns = (int64_t)(lease_s * 1e9),
            .lock_step = lock_step,
            .name = name}};
    memory_send(h->end, &m);
}

/* A member, with a ball at 10 k and a subscription in all. */
static void join(hall *h, int k, int32_t lock_step, double lease_s)
{
    char name[16];
    snprintf(name, sizeof name, "ball%d", k);
    hello(h, k, lock_step, lease_s);
    cell_sphere(h->end, id_of(k), ++h->sequences[k], 0, name, 10 * k);
    cell_touches(h->end, id_of(k), ++h->sequences[k], 0);
    cell_settle(h->end, h->memory, id_of(k), ++h->sequences[k]);
}

static hall enter(double timeout_s, const char *policy, const char *record)
{
    config c = cell_config();
    c.step_timeout = timeout_s;
    snprintf(c.step_policy, sizeof c.step_policy, "%s", policy);
    snprintf(c.record, sizeof c.record, "%s", record);
    hall h = {.cell = cell_start(&c), .memory = wire_memory_create()};
    h.end = cell_client(h.cell);
    return h;
}

static void leave(hall *h)
{
    memory_disconnect(h->end);
    assert_int_equal(cell_stop(h->cell), 0);
    wire_memory_destroy(h->memory);
}

static void publish(hall *h, int k, int64_t step, uint32_t count, double x)
{
    const int32_t body = 0;
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = id_of(k),
            .sequence = ++h->sequences[k],
            .step = step,
            .bodies = {count, &body},
            .positions = {3 * count, position},
            .orientations = {4 * count, orientation}}};
    memory_send(h->end, &m);
}

static void step(hall *h, int k, int64_t number, double x)
{
    publish(h, k, number, 1, x);
    publish(h, k, number, 0, 0);
}

/* Each of the first `members` has a batch with that step; returns how many events there were in them. Who
 * missed it, the last one, reads so. */
static size_t await_answers(hall *h, int members, int64_t number, int32_t missing)
{
    bool answered[MEMBERS] = {false};
    size_t events = 0;
    for (int left = members; left;) {
        wire_event_batch b = cell_await(h->end, h->memory, WIRE_EVENT_BATCH).event_batch;
        int k = (int)(b.client - FIRST);
        if (k >= members || b.step < number) continue;
        assert_int_equal(b.step, number);
        assert_int_equal(b.missing, k == MEMBERS - 1 ? -missing : missing);
        assert_false(answered[k]);
        answered[k] = true;
        events += b.kinds.count;
        left--;
    }
    return events;
}

static void await_late_answer(hall *h, int k)
{
    wire_event_batch b;
    do {
        b = cell_await(h->end, h->memory, WIRE_EVENT_BATCH).event_batch;
    } while (b.client != id_of(k));
    assert_int_equal(b.missing, -1);
}

static bool is_silent(hall *h, int ms)
{
    wire_message m;
    bool heard; /* but for snapshots of nothing, which come in their own time */
    while ((heard = cell_next(h->end, h->memory, WIRE_EVENT_BATCH, ms, &m)))
        if (!m.event_batch.snapshot || m.event_batch.kinds.count) break;
    return !heard;
}

static void a_step_is_done_when_all_have_published_it(void **state)
{
    (void)state;
    hall h = enter(0, "go_on", "");
    for (int k = 0; k < MEMBERS; k++) join(&h, k, MEMBERS, 60);
    for (int64_t n = 1; n <= 20; n++) {
        for (int i = 0; i < MEMBERS; i++)
            step(&h, (int)((n + i) % MEMBERS), n, 10 * (double)((n + i) % MEMBERS) + 0.1 * (double)n);
        await_answers(&h, MEMBERS, n, 0);
    }
    leave(&h);
}

/* All go one way together: who looked at a step that is half there would see them meet. */
static void nothing_is_seen_of_a_step_that_is_not_complete(void **state)
{
    (void)state;
    hall h = enter(0, "go_on", "");
    for (int k = 0; k < MEMBERS; k++) join(&h, k, 1, 60);
    for (int64_t n = 1; n <= 5; n++) {
        step(&h, 0, n, 10.0 * (double)n); /* where the second one stands still */
        step(&h, 1, n, 10 + 10.0 * (double)n);
        assert_true(is_silent(&h, 50));
        step(&h, 2, n, 20 + 10.0 * (double)n);
        assert_int_equal(await_answers(&h, MEMBERS, n, 0), 0);
    }
    leave(&h);
}

static void the_first_step_waits_until_all_are_there(void **state)
{
    (void)state;
    hall h = enter(1, "go_on", "");
    join(&h, 0, 2, 60);
    step(&h, 0, 1, 0);
    wire_reject late = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(late.reason, WIRE_STEP_MISSED);
    assert_non_null(strstr(late.text, "1 of 2 clients are there"));
    join(&h, 1, 2, 60);
    step(&h, 1, 1, 10);
    await_answers(&h, 2, 1, 0);
    leave(&h);
}

static void who_misses_a_step_is_told_to_all_and_the_others_go_on(void **state)
{
    (void)state;
    hall h = enter(1.5, "go_on", "");
    for (int k = 0; k < MEMBERS; k++) join(&h, k, MEMBERS, 60);
    for (int k = 0; k < MEMBERS; k++) step(&h, k, 1, 10 * k);
    await_answers(&h, MEMBERS, 1, 0);
    step(&h, 0, 2, 0);
    step(&h, 1, 2, 10);
    publish(&h, 2, 2, 1, 5); /* half of it: it does not count */
    bool told[MEMBERS] = {false};
    for (int left = MEMBERS; left; left--) {
        wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
        assert_int_equal(r.reason, WIRE_STEP_MISSED);
        if (!strstr(r.text, "step 2: client 0000000000000067 \"sim2\" did not publish it within 1.5 s: it is done"))
            fail_msg("%s", r.text);
        told[r.client - FIRST] = true;
    }
    for (int k = 0; k < MEMBERS; k++) assert_true(told[k]);
    await_answers(&h, MEMBERS, 2, 1);
    for (int64_t n = 3; n <= 10; n++) { /* it is not waited for any more */
        step(&h, 0, n, 0);
        step(&h, 1, n, 10);
        await_answers(&h, MEMBERS, n, 1);
    }
    step(&h, 2, 10,
        5); /* it is back, late: it hears how far they are, that this is in vain, and publishes the next one */
    for (int k = 0; k < 2; k++) {
        wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
        assert_int_equal(r.client, id_of(2));
        assert_int_equal(r.reason, WIRE_BAD_STEP);
        assert_string_equal(r.text, "step 10 is done, without this client");
    }
    await_late_answer(&h, 2);
    step(&h, 0, 11, 0);
    step(&h, 1, 11, 10);
    assert_true(is_silent(&h, 20));
    step(&h, 2, 11, 20);
    await_answers(&h, MEMBERS, 11, 0);
    cell_await(h.end, h.memory, WIRE_STATUS);
    wire_message s = cell_await(h.end, h.memory, WIRE_STATUS);
    assert_int_equal(cell_counter(&s.status, "steps"), 11);
    assert_int_equal(cell_counter(&s.status, "steps_missed"), 1);
    assert_int_equal(cell_counter(&s.status, "lock_step_clients"), MEMBERS);
    leave(&h);
}

static void by_policy_all_wait_on(void **state)
{
    (void)state;
    hall h = enter(0.05, "hold", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    step(&h, 0, 1, 0);
    wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_STEP_MISSED);
    assert_non_null(strstr(r.text, "all wait on"));
    while (cell_hears(h.end, h.memory, WIRE_EVENT_BATCH, 100)) { /* snapshots */
    }
    step(&h, 1, 1, 10);
    await_answers(&h, 2, 1, 0);
    leave(&h);
}

static void who_is_lost_is_not_waited_for(void **state)
{
    (void)state;
    hall h = enter(0, "hold", "");
    join(&h, 0, 2, 60);
    join(&h, 1, 2, 1);
    step(&h, 0, 1, 0);
    step(&h, 1, 1, 10);
    await_answers(&h, 2, 1, 0);
    step(&h, 0, 2, 0); /* and silence of the other one */
    await_answers(&h, 1, 2, 0);
    leave(&h);
}

static void steps_that_are_done_or_too_far_are_refused(void **state)
{
    (void)state;
    hall h = enter(0, "hold", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    step(&h, 0, 5, 0);
    step(&h, 0, 6, 0);
    wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_BAD_STEP);
    assert_string_equal(r.text, "step 6: 5 is not done");
    step(&h, 1, 5, 10);
    await_answers(&h, 2, 5, 0);
    step(&h, 1, 4, 10);
    r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    while (strstr(r.text, "step 6")) r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_BAD_STEP);
    assert_string_equal(r.text, "step 4: 5 is done");
    step(&h, 1, 5, 10); /* its answer was lost: it is told again */
    wire_event_batch b = cell_await(h.end, h.memory, WIRE_EVENT_BATCH).event_batch;
    assert_true(b.client == id_of(1) && b.step == 5);
    leave(&h);
}

static void what_is_sent_again_stands_for_what_was_sent(void **state)
{
    (void)state;
    hall h = enter(0, "hold", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    for (int i = 0; i < 10; i++) step(&h, 0, 1, 10); /* no answer, so again; on the other one */
    step(&h, 0, 1, -10);
    step(&h, 1, 1, 10);
    assert_int_equal(await_answers(&h, 2, 1, 0), 0);
    leave(&h);
}

static void a_limit_bounds_what_waits(void **state)
{
    (void)state;
    config c = cell_config();
    c.max_step_poses = 3;
    hall h = {.cell = cell_start(&c), .memory = wire_memory_create()};
    h.end = cell_client(h.cell);
    join(&h, 0, 2, 60);
    for (int i = 0; i < 4; i++) publish(&h, 0, 1, 1, i);
    wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_LIMIT);
    assert_non_null(strstr(r.text, "max_step_poses = 3"));
    leave(&h);
}

/* Of all members together; but each may have its part. */
static void it_is_one_limit_for_all_members(void **state)
{
    (void)state;
    config c = cell_config();
    c.max_step_poses = 4;
    c.step_timeout = 0;
    hall h = {.cell = cell_start(&c), .memory = wire_memory_create()};
    h.end = cell_client(h.cell);
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    for (int i = 0; i < 3; i++) publish(&h, 0, 1, 1, i);
    for (int i = 0; i < 2; i++) publish(&h, 1, 1, 1, i);
    publish(&h, 0, 1, 1, 3);
    wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_LIMIT);
    assert_true(r.client == id_of(0) && r.sequence == h.sequences[0]);
    leave(&h);
}

/* What came of it can be told to nobody, but what is there is not taken for the whole. */
static void a_step_is_not_done_from_a_refused_batch(void **state)
{
    (void)state;
    config c = cell_config();
    c.max_step_poses = 3;
    c.step_timeout = 0;
    hall h = {.cell = cell_start(&c), .memory = wire_memory_create()};
    h.end = cell_client(h.cell);
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    for (int i = 0; i < 4; i++) publish(&h, 0, 1, 1, i);
    publish(&h, 0, 1, 0, 0);
    step(&h, 1, 1, 10);
    assert_int_equal(cell_await(h.end, h.memory, WIRE_REJECT).reject.reason, WIRE_LIMIT);
    wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_BAD_STEP);
    assert_true(r.client == id_of(0) && r.sequence == h.sequences[0]);
    assert_string_equal(r.text, "step 1: some of its poses were refused: send all of it again");
    for (int i = 0; i < 5; i++) cell_hears(h.end, h.memory, WIRE_EVENT_BATCH, 20);
    step(&h, 0, 1, 0);
    await_answers(&h, 2, 1, 0);
    leave(&h);
}

/* Refused before it is recorded: the recording tells of it all the same. */
static void nor_from_one_refused_for_its_rate(void **state)
{
    (void)state;
    char folder[] = "/tmp/collided-steps-XXXXXX", path[sizeof folder + 16];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/steps.lcmlog", folder);
    config c = cell_config();
    c.max_client_poses = 4;
    c.step_timeout = 0;
    snprintf(c.record, sizeof c.record, "%s", path);
    hall h = {.cell = cell_start(&c), .memory = wire_memory_create()};
    h.end = cell_client(h.cell);
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    for (int i = 0; i < 24; i++)
        publish(&h, 0, 1, 1, 10); /* where the other one is; the fifth in a second is too many */
    publish(&h, 0, 1, 0, 0);
    memory_end *first = h.end, *second = cell_client(h.cell); /* another participant, with a rate of its own */
    h.end = second;
    step(&h, 1, 1, 10);
    h.end = first;
    wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_LIMIT);
    while (r.reason == WIRE_LIMIT) r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_BAD_STEP);
    publish(&h, 0, 1, 0, 0); /* nothing moved after all */
    assert_int_equal(await_answers(&h, 2, 1, 0), 0);
    for (int k = 0; k < 2; k++) publish(&h, k, 2, 0, 0);
    await_answers(&h, 2, 2, 0);
    memory_disconnect(second);
    leave(&h);
    assert_int_equal(cell_replay(path, 1, true), EX_OK);
    assert_int_equal(unlink(path) | rmdir(folder), 0);
}

/* Over another link than its own, what is said in its name breaks nothing. */
static void a_stranger_cannot_break_a_step(void **state)
{
    (void)state;
    config c = cell_config();
    c.step_timeout = 0;
    strcpy(c.links, "memory://cell memory://other");
    hall h = {.cell = cell_start(&c), .memory = wire_memory_create()};
    h.end = cell_client(h.cell);
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    publish(&h, 0, 1, 1, 10);
    cell_settle(h.end, h.memory, id_of(0), ++h.sequences[0]);
    memory_end *hers = h.end, *other = memory_connect("other");
    h.end = other;
    publish(&h, 0, 1, 1, 20);
    assert_int_equal(cell_await(other, h.memory, WIRE_REJECT).reject.reason, WIRE_NOT_YOURS);
    h.end = hers;
    publish(&h, 0, 1, 0, 0);
    publish(&h, 1, 1, 0, 0);
    assert_int_equal(await_answers(&h, 2, 1, 0), 2);
    memory_disconnect(other);
    leave(&h);
}

/* The daemon ends steps under a sequence of its own: no client speaks under that. */
static void a_client_cannot_use_the_sequence_of_the_daemon(void **state)
{
    (void)state;
    hall h = enter(0, "hold", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    publish(&h, 0, 1, 1, 10);
    int64_t kept = h.sequences[0];
    h.sequences[0] = INT64_MAX - 1;
    publish(&h, 0, 1, 0, 0);
    wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_MALFORMED);
    assert_true(r.client == id_of(0) && r.sequence == INT64_MAX);
    if (!strstr(r.text, "sequence is 9223372036854775807")) fail_msg("%s", r.text);
    h.sequences[0] = kept;
    publish(&h, 0, 1, 0, 0);
    publish(&h, 1, 1, 0, 0);
    assert_int_equal(await_answers(&h, 2, 1, 0), 2); /* what it had sent was kept: both streams tell of the contact */
    leave(&h);
}

/* Each of them changes who is waited for, and not for how long. */
static void who_comes_and_goes_does_not_postpone_the_timeout(void **state)
{
    (void)state;
    hall h = enter(1, "go_on", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    for (int k = 0; k < 2; k++) step(&h, k, 1, 10 * k);
    await_answers(&h, 2, 1, 0);
    step(&h, 0, 2, 0);
    bool told = false;
    for (int i = 0; i < 200 && !told; i++) {
        hello(&h, 2, i % 2 ? 0 : 2, 60);
        told = cell_hears(h.end, h.memory, WIRE_REJECT, 40);
    }
    assert_true(told);
    leave(&h);
}

/* ---- a network that brings things twice, or in another order ---- */

static void publish_as(hall *h, int k, int64_t sequence, int64_t step, uint32_t count, double x)
{
    int64_t newest = h->sequences[k];
    h->sequences[k] = sequence - 1;
    publish(h, k, step, count, x);
    h->sequences[k] = newest > sequence ? newest : sequence;
    cell_settle(h->end, h->memory, id_of(k), h->sequences[k] + 100);
}

/* The first of two says of step 1, in that order: P its pose, in which it touches the other one's ball, E its end, each
 * once or twice under the same sequence; e its end under a sequence of its own, each time. Then the other one ends the
 * step, also once more than needed. */
static void step_of_two(const char *said)
{
    hall h = enter(0, "go_on", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    int64_t pose = h.sequences[0] + 10, end = pose + 1, other = end;
    for (; *said; said++) publish_as(&h, 0, *said == 'P' ? pose : *said == 'E' ? end : ++other, 1, *said == 'P', 8.5);
    publish(&h, 1, 1, 0, 0);
    assert_int_equal(await_answers(&h, 2, 1, 0), 2);
    assert_false(cell_hears(h.end, h.memory, WIRE_REJECT, 0));
    leave(&h);
}

/* Who ends a step now, and once more to wait for it, has ended it once. */
static void a_step_that_is_ended_again_keeps_its_poses(void **state)
{
    (void)state;
    static const char *const said[] = {
        "Pee", "Peee", "PEe", "PeE", "PeeEe", "PeP", "PePe", "ePe", "eeP", "EeP", "ePeP"};
    for (size_t i = 0; i < sizeof said / sizeof *said; i++) step_of_two(said[i]);
}

static void copies_of_a_step_change_nothing_in_it(void **state)
{
    (void)state;
    step_of_two("PE");
    step_of_two("PPE");
    step_of_two("PEE");
    step_of_two("PEP");
    step_of_two("PEPE");
}

static void what_the_end_of_a_step_has_overtaken_is_in_it(void **state)
{
    (void)state;
    step_of_two("EP");
    step_of_two("EPE");
    step_of_two("EPP");
}

static void sent_again_it_stands_for_what_was_sent(void **state)
{
    (void)state;
    hall h = enter(0, "go_on", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    int64_t first = h.sequences[0] + 10;
    publish_as(&h, 0, first, 1, 1, 8.5);
    publish_as(&h, 0, first + 1, 1, 0, 0);
    publish_as(&h, 0, first + 2, 1, 1, 0);
    publish_as(&h, 0, first + 1, 1, 0, 0); /* a copy of the end of before */
    publish(&h, 1, 1, 0, 0);
    assert_true(is_silent(&h, 50));
    publish(&h, 0, 1, 0, 0);
    assert_int_equal(await_answers(&h, 2, 1, 0), 0);
    leave(&h);
}

static void publish_body(hall *h, int k, int64_t step, int32_t body, double x)
{
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = id_of(k),
            .sequence = ++h->sequences[k],
            .step = step,
            .bodies = {1, &body},
            .positions = {3, position},
            .orientations = {4, orientation}}};
    memory_send(h->end, &m);
}

static wire_reject await_refusal(hall *h, int64_t sequence)
{
    wire_reject r;
    do {
        r = cell_await(h->end, h->memory, WIRE_REJECT).reject;
    } while (r.sequence < sequence);
    assert_int_equal(r.sequence, sequence);
    assert_int_equal(r.reason, WIRE_BAD_STEP);
    return r;
}

static void join_with_two_bodies(hall *h)
{
    for (int k = 0; k < 2; k++) join(h, k, 2, 60);
    cell_sphere(h->end, id_of(0), ++h->sequences[0], 1, "second", 50);
    cell_settle(h->end, h->memory, id_of(0), ++h->sequences[0]);
}

/* What is sent again lacks one of the bodies that the step was ended with: which of both poses is meant? */
static void what_is_sent_again_has_to_be_all_of_it(void **state)
{
    (void)state;
    hall h = enter(0, "go_on", "");
    join_with_two_bodies(&h);
    publish_body(&h, 0, 1, 0, 8.5);
    publish(&h, 0, 1, 0, 0);
    publish_body(&h, 0, 1, 1, 51);
    publish(&h, 0, 1, 0, 0);
    wire_reject r = await_refusal(&h, h.sequences[0]);
    if (!strstr(r.text, "poses of 1 bodies were refused or replaced, and did not come again, the first is 0"))
        fail_msg("%s", r.text);
    publish(&h, 1, 1, 0, 0);
    assert_true(is_silent(&h, 30));
    publish_body(&h, 0, 1, 0, 8.5);
    publish_body(&h, 0, 1, 1, 51);
    publish(&h, 0, 1, 0, 0);
    assert_int_equal(await_answers(&h, 2, 1, 0), 2);
    leave(&h);
}

/* Refused, because the step before is not done: the next one is not done without them. */
static void poses_that_came_too_early_have_to_come_again(void **state)
{
    (void)state;
    hall h = enter(0, "go_on", "");
    join_with_two_bodies(&h);
    publish(&h, 0, 1, 0, 0);
    publish_body(&h, 0, 2, 0, 8.5);
    await_refusal(&h, h.sequences[0]);
    publish(&h, 1, 1, 0, 0);
    await_answers(&h, 2, 1, 0);
    publish_body(&h, 0, 2, 1, 51);
    publish(&h, 0, 2, 0, 0);
    await_refusal(&h, h.sequences[0]);
    publish_body(&h, 0, 2, 0, 8.5);
    publish_body(&h, 0, 2, 1, 51);
    publish(&h, 0, 2, 0, 0);
    publish(&h, 1, 2, 0, 0);
    assert_int_equal(await_answers(&h, 2, 2, 0), 2);
    leave(&h);
}

/* Neither a copy of what was in the step nor in time: refused, and the answer that comes again counts it. */
static void other_poses_for_a_step_that_is_done_are_refused(void **state)
{
    (void)state;
    hall h = enter(0, "go_on", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    step(&h, 0, 1, 0.25);
    publish(&h, 1, 1, 0, 0);
    await_answers(&h, 2, 1, 0);
    step(&h, 0, 1, 0.25);
    wire_event_batch again = cell_await(h.end, h.memory, WIRE_EVENT_BATCH).event_batch;
    assert_true(again.step == 1 && again.refused == 0);
    publish(&h, 0, 1, 1, 8.5);
    await_refusal(&h, h.sequences[0]);
    publish(&h, 0, 1, 0, 0);
    again = cell_await(h.end, h.memory, WIRE_EVENT_BATCH).event_batch;
    assert_true(again.client == id_of(0) && again.step == 1 && again.refused == 1 && again.refusal == WIRE_BAD_STEP);
    for (int k = 0; k < 2; k++) publish(&h, k, 2, 0, 0);
    for (int k = 0; k < 2; k++) assert_int_equal(cell_await(h.end, h.memory, WIRE_EVENT_BATCH).event_batch.refused, 0);
    leave(&h);
}

/* The step is done without them, and that is said; copies of what was in it are none of that. */
static void poses_that_come_after_their_step_are_refused(void **state)
{
    (void)state;
    hall h = enter(0, "go_on", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    publish(&h, 1, 1, 0, 0);
    int64_t pose = h.sequences[0] + 10;
    publish_as(&h, 0, pose + 1, 1, 0, 0);
    h.sequences[0] = pose - 1;
    publish(&h, 0, 1, 1, 8.5);
    wire_reject r = cell_await(h.end, h.memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_BAD_STEP);
    assert_int_equal(r.sequence, pose);
    h.sequences[0] = pose + 10;
    step(&h, 0, 2, 0.5);
    h.sequences[0] = pose + 10;
    publish(&h, 1, 2, 0, 0);
    await_answers(&h, 2, 2, 0);
    publish(&h, 0, 2, 1, 0.5); /* a copy */
    assert_false(cell_hears(h.end, h.memory, WIRE_REJECT, 50));
    leave(&h);
}

static void ask_to_record(hall *h, const char *name)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = id_of(0),
            .sequence = ++h->sequences[0],
            .kind = WIRE_QUERY_RECORD,
            .name_a = name,
            .name_b = ""}};
    memory_send(h->end, &q);
    assert_int_equal(cell_await(h->end, h->memory, WIRE_ANSWER).answer.status, WIRE_ANSWER_OK);
}

/* Nothing has touched before: so the hashes are those of the live session. */
static void replays_from_the_middle(int32_t joined_first, void (*before)(hall *h), void (*after)(hall *h))
{
    char folder[] = "/tmp/collided-steps-XXXXXX", path[sizeof folder + 16];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    c.step_timeout = 0;
    hall h = {.cell = cell_start(&c), .memory = wire_memory_create()};
    h.end = cell_client(h.cell);
    for (int k = 0; k < joined_first; k++) join(&h, k, 2, 60);
    before(&h);
    ask_to_record(&h, "middle");
    after(&h);
    leave(&h);
    for (long workers = 1; workers <= 2; workers++) assert_int_equal(cell_replay(path, workers, true), EX_OK);
    assert_int_equal(unlink(path) | rmdir(folder), 0);
}

static void some_steps(hall *h)
{
    for (int64_t n = 1; n <= 3; n++) {
        for (int k = 0; k < 2; k++) step(h, k, n, 10 * k);
        await_answers(h, 2, n, 0);
    }
    step(h, 0, 4, 9); /* one is ahead */
    cell_settle(h->end, h->memory, id_of(0), ++h->sequences[0]);
}

static void more_steps(hall *h)
{
    publish(h, 1, 3, 0, 0); /* its answer was lost; and this is too late: */
    publish(h, 1, 2, 1, 20);
    cell_settle(h->end, h->memory, id_of(1), ++h->sequences[1]);
    step(h, 1, 4, 10);
    await_answers(h, 2, 4, 0);
    for (int64_t n = 5; n <= 10; n++) {
        for (int k = 0; k < 2; k++) step(h, k, n, k ? 10 : 9 - 2 * (double)(n % 2));
        await_answers(h, 2, n, 0);
    }
}

static void a_recording_that_begins_between_steps_replays(void **state)
{
    (void)state;
    replays_from_the_middle(2, some_steps, more_steps);
}

static void one_waits(hall *h)
{
    cell_sphere(h->end, id_of(2), ++h->sequences[2], 0, "post", -10);
    cell_touches(h->end, id_of(2), ++h->sequences[2], 0);
    cell_settle(h->end, h->memory, id_of(2), ++h->sequences[2]);
    step(h, 0, 1, -9);
    cell_settle(h->end, h->memory, id_of(0), ++h->sequences[0]);
}

static void the_other_comes(hall *h)
{
    for (int i = 0; i < 3; i++) {
        cell_pose(h->end, id_of(2), ++h->sequences[2], 0, -10 - 0.1 * i);
        cell_settle(h->end, h->memory, id_of(2), ++h->sequences[2]);
    }
    join(h, 1, 2, 60);
    step(h, 1, 1, 10);
    await_answers(h, 2, 1, 0);
}

static void one_begins_its_step_anew(hall *h)
{
    cell_sphere(h->end, id_of(0), ++h->sequences[0], 1, "second", 50);
    cell_settle(h->end, h->memory, id_of(0), ++h->sequences[0]);
    for (int k = 0; k < 2; k++) step(h, k, 1, 10 * k);
    await_answers(h, 2, 1, 0);
    publish_body(h, 0, 2, 0, 1);
    publish_body(h, 0, 2, 1, 51);
    publish(h, 0, 2, 0, 0);
    publish_body(h, 0, 2, 0, 8.5);
    publish_body(h, 0, 3, 1, 52); /* too early */
    cell_settle(h->end, h->memory, id_of(0), ++h->sequences[0]);
}

static void and_the_rest_of_it_comes(hall *h)
{
    publish(h, 0, 2, 0, 0); /* without the second: refused */
    cell_settle(h->end, h->memory, id_of(0), ++h->sequences[0]);
    publish_body(h, 0, 2, 0, 8.5);
    publish_body(h, 0, 2, 1, 53);
    publish(h, 0, 2, 0, 0);
    publish(h, 0, 2, 0, 0);
    publish(h, 1, 2, 0, 0);
    await_answers(h, 2, 2, 0);
    publish(h, 0, 3, 0, 0); /* refused */
    publish(h, 0, 3, 0, 0);
    publish(h, 1, 3, 0, 0);
    await_answers(h, 2, 3, 0);
}

static void so_does_one_that_begins_in_a_step_that_is_sent_again(void **state)
{
    (void)state;
    replays_from_the_middle(2, one_begins_its_step_anew, and_the_rest_of_it_comes);
}

static void so_does_one_that_begins_before_the_first_step(void **state)
{
    (void)state;
    replays_from_the_middle(1, one_waits, the_other_comes);
}

/* From the stamps of a step to what came of it, not of the step before. */
static void the_latency_is_that_of_the_step(void **state)
{
    (void)state;
    hall h = enter(0, "hold", "");
    join(&h, 0, 1, 60);
    cell_sphere(h.end, id_of(0), ++h.sequences[0], 1, "other", 30);
    cell_settle(h.end, h.memory, id_of(0), ++h.sequences[0]);
    const int32_t body = 0;
    const double position[3] = {29, 0, 0}, orientation[4] = {1, 0, 0, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = id_of(0),
            .sequence = ++h.sequences[0],
            .step = 1,
            .stamp_ns = 1000000000, /* long ago */
            .bodies = {1, &body},
            .positions = {3, position},
            .orientations = {4, orientation}}};
    memory_send(h.end, &m);
    publish(&h, 0, 1, 0, 0);
    assert_int_equal(await_answers(&h, 1, 1, 0), 1);
    cell_settle(h.end, h.memory, id_of(0), ++h.sequences[0]);
    const histogram *latency = &cell_measures(h.cell)->latency;
    assert_int_equal(histogram_total(latency), 1);
    assert_int_equal(latency->below[latency->count], 1);
    leave(&h);
}

/* The end of a step says what time it is there; what one member says, the answers of all carry, and who is ahead does
 * not move the time of the step that is done. */
static void end_at(hall *h, int k, int64_t step, int64_t simulation_ns)
{
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = id_of(k),
            .sequence = ++h->sequences[k],
            .step = step,
            .simulation_ns = simulation_ns}};
    memory_send(h->end, &m);
}

static void await_time(hall *h, int members, int64_t step, int64_t simulation_ns)
{
    for (int left = members; left;) {
        wire_event_batch b = cell_await(h->end, h->memory, WIRE_EVENT_BATCH).event_batch;
        if (b.step < step) continue;
        assert_int_equal(b.step, step);
        assert_int_equal(b.simulation_ns, simulation_ns);
        left--;
    }
}

static void answers_carry_the_time_of_the_simulation(void **state)
{
    (void)state;
    hall h = enter(0, "hold", "");
    for (int k = 0; k < 2; k++) join(&h, k, 2, 60);
    end_at(&h, 0, 1, 4000000);
    end_at(&h, 1, 1, 0); /* does not tell it */
    await_time(&h, 2, 1, 4000000);
    publish(&h, 0, 2, 1, 0.5);
    end_at(&h, 0, 2, 8000000);
    assert_true(is_silent(&h, 30));
    end_at(&h, 1, 2, 8000001); /* the latest counts */
    await_time(&h, 2, 2, 8000001);
    end_at(&h, 0, 3, 0); /* nobody says: what was told last stands */
    end_at(&h, 1, 3, 0);
    await_time(&h, 2, 3, 8000001);
    end_at(&h, 0, 4, 1000); /* it begins anew */
    end_at(&h, 1, 4, 1000);
    await_time(&h, 2, 4, 1000);
    leave(&h);
}

static void lock_step_replays(void **state)
{
    (void)state;
    char folder[] = "/tmp/collided-steps-XXXXXX", path[sizeof folder + 16];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/steps.lcmlog", folder);
    hall h = enter(1.5, "go_on", path);
    for (int k = 0; k < MEMBERS; k++) join(&h, k, MEMBERS, 60);
    for (int64_t n = 1; n <= 30; n++) {
        for (int k = MEMBERS; k-- > 0;) /* the one that comes back first: the others would not wait for it */
            if (k != 2 || n < 10 || n >= 20) step(&h, k, n, 1.5 * k + 0.01 * (double)(n * (k + 1)));
        if (n == 10) publish(&h, 2, n, 1, 7);
        await_answers(&h, MEMBERS, n, n >= 10 && n < 20);
    }
    leave(&h);
    for (long workers = 1; workers <= 4; workers *= 2) assert_int_equal(cell_replay(path, workers, true), EX_OK);
    assert_int_equal(unlink(path) | rmdir(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_step_is_done_when_all_have_published_it),
        cmocka_unit_test(nothing_is_seen_of_a_step_that_is_not_complete),
        cmocka_unit_test(the_first_step_waits_until_all_are_there),
        cmocka_unit_test(who_misses_a_step_is_told_to_all_and_the_others_go_on),
        cmocka_unit_test(by_policy_all_wait_on),
        cmocka_unit_test(who_is_lost_is_not_waited_for),
        cmocka_unit_test(steps_that_are_done_or_too_far_are_refused),
        cmocka_unit_test(what_is_sent_again_stands_for_what_was_sent),
        cmocka_unit_test(a_limit_bounds_what_waits),
        cmocka_unit_test(it_is_one_limit_for_all_members),
        cmocka_unit_test(a_step_is_not_done_from_a_refused_batch),
        cmocka_unit_test(nor_from_one_refused_for_its_rate),
        cmocka_unit_test(a_stranger_cannot_break_a_step),
        cmocka_unit_test(a_client_cannot_use_the_sequence_of_the_daemon),
        cmocka_unit_test(who_comes_and_goes_does_not_postpone_the_timeout),
        cmocka_unit_test(the_latency_is_that_of_the_step),
        cmocka_unit_test(answers_carry_the_time_of_the_simulation),
        cmocka_unit_test(lock_step_replays),
        cmocka_unit_test(copies_of_a_step_change_nothing_in_it),
        cmocka_unit_test(what_the_end_of_a_step_has_overtaken_is_in_it),
        cmocka_unit_test(a_step_that_is_ended_again_keeps_its_poses),
        cmocka_unit_test(what_is_sent_again_has_to_be_all_of_it),
        cmocka_unit_test(poses_that_came_too_early_have_to_come_again),
        cmocka_unit_test(other_poses_for_a_step_that_is_done_are_refused),
        cmocka_unit_test(so_does_one_that_begins_in_a_step_that_is_sent_again),
        cmocka_unit_test(sent_again_it_stands_for_what_was_sent),
        cmocka_unit_test(poses_that_come_after_their_step_are_refused),
        cmocka_unit_test(a_recording_that_begins_between_steps_replays),
        cmocka_unit_test(so_does_one_that_begins_before_the_first_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
