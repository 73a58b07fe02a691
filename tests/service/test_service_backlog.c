/* What is large waits for its reader: receipts pace it, a loss goes on from where it was, who sends none gets it
 * slowly, and who does not read is named in Status. The clients here speak the protocol themselves. */
#include "cell.h"

#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

enum { ALICE = 21, BALLS = 90, PAIRS = BALLS * (BALLS - 1) / 2, A_PART = 128, PARTS = (PAIRS + A_PART - 1) / A_PART };
enum { WINDOW = 16, QUIET_MS = 150 };

typedef struct subscriber {
    cell *cell;
    memory_end *alice;
    wire_memory *memory;
    int64_t sequence, epoch;
    int64_t batch, tick; /* of the last message of the stream */
    int32_t part;
    bool snapshot;
    size_t events;
} subscriber;

static char recording[64]; /* "" = none is made */
static double slice_us;    /* 0: no slices, whose number of parts would be the clock's business */

static subscriber enter(void)
{
    config c = cell_config();
    snprintf(c.record, sizeof c.record, "%s", recording);
    c.slice_us = slice_us;
    subscriber r = {.cell = cell_start(&c), .memory = wire_memory_create()};
    r.alice = cell_client(r.cell);
    cell_hello(r.alice, ALICE, ++r.sequence, 60, WIRE_LOST_REMOVE);
    return r;
}

static void leave(subscriber *r)
{
    memory_disconnect(r->alice);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

/* All at one place: each touches each. */
static void make_balls(subscriber *r)
{
    for (int i = 0; i < BALLS; i++) {
        char name[16];
        snprintf(name, sizeof name, "ball %d", i);
        cell_sphere(r->alice, ALICE, ++r->sequence, i, name, 1e-3 * i);
    }
}

static bool hears(subscriber *r, int ms, wire_event_batch *out)
{
    wire_message m;
    if (!cell_next(r->alice, r->memory, WIRE_EVENT_BATCH, ms, &m)) return false;
    *out = m.event_batch;
    r->epoch = out->epoch;
    r->batch = out->batch;
    r->tick = out->tick;
    r->part = out->part;
    r->snapshot = out->snapshot;
    r->events += out->kinds.count;
    return true;
}

static wire_event_batch await(subscriber *r)
{
    wire_event_batch b;
    if (!hears(r, 30000, &b)) fail_msg("no batch came");
    return b;
}

static void await_parts(subscriber *r, int32_t from, int32_t to, int32_t parts)
{
    for (int32_t part = from; part < to; part++) {
        int64_t tick = r->tick, batch = r->batch;
        wire_event_batch b = await(r);
        assert_true(b.snapshot && !b.heartbeat);
        assert_int_equal(b.part, part);
        assert_int_equal(b.parts, parts);
        assert_in_range(b.behind, parts - part, parts - part + 1); /* and a batch behind it, in some tests */
        if (part > from) assert_true(b.tick == tick && b.batch == batch);
    }
}

static void receipt(subscriber *r, int64_t batch, int64_t tick, int32_t part, bool missing)
{
    wire_message m = {.kind = WIRE_RECEIPT,
        .receipt = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .epoch = r->epoch,
            .batch = batch,
            .tick = tick,
            .part = part,
            .missing = missing}};
    memory_send(r->alice, &m);
}

static void nothing_comes(subscriber *r)
{
    wire_event_batch b;
    if (hears(r, QUIET_MS, &b)) fail_msg("batch %lld, part %d", (long long)b.batch, b.part);
}

static wire_status await_health(subscriber *r, uint8_t health)
{
    wire_status s = cell_await(r->alice, r->memory, WIRE_STATUS).status;
    while (s.health != health) s = cell_await(r->alice, r->memory, WIRE_STATUS).status;
    return s;
}

/* A snapshot that is too large to go out as a whole, to somebody who has said that he sends receipts. */
static subscriber enter_and_ask(void)
{
    subscriber r = enter();
    cell_touches(r.alice, ALICE, ++r.sequence, 0);
    assert_true(await(&r).snapshot);
    receipt(&r, r.batch, r.tick, 0, false);
    make_balls(&r);
    while (r.events < PAIRS) {
        await(&r);
        receipt(&r, r.batch, 0, 0, false);
    }
    r.events = 0;
    receipt(&r, 0, 0, 0, true); /* nothing of it has come */
    return r;
}

static void who_sends_no_receipts_gets_all_slowly(void **state)
{
    (void)state;
    subscriber r = enter();
    make_balls(&r);
    cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    cell_touches(r.alice, ALICE, ++r.sequence, 0);
    await_parts(&r, 0, PARTS / 2, PARTS);
    cell_pose(r.alice, ALICE, ++r.sequence, 0, 1e4); /* what happens meanwhile comes behind it */
    await_parts(&r, PARTS / 2, PARTS, PARTS);
    assert_int_equal(r.events, PAIRS);
    int64_t batch = r.batch;
    wire_event_batch b = await(&r);
    assert_true(!b.snapshot && b.batch == batch + 1 && b.kinds.count == BALLS - 1);
    cell_pose(r.alice, ALICE, ++r.sequence, 1, 2e4);
    b = await(&r);
    assert_true(!b.snapshot && b.batch == batch + 2 && b.kinds.count == BALLS - 2 && b.behind == 0);
    await_health(&r, WIRE_HEALTH_READY);
    leave(&r);
}

static void receipts_pace_a_snapshot(void **state)
{
    (void)state;
    subscriber r = enter_and_ask();
    wire_event_batch b;
    int32_t had = 0;
    while (hears(&r, QUIET_MS, &b)) had++;
    assert_int_equal(had, WINDOW);
    receipt(&r, r.batch, r.tick, 7, false); /* eight have come: eight more may, and as many as it grows by */
    await_parts(&r, WINDOW, PARTS < 2 * WINDOW ? PARTS : 2 * WINDOW, PARTS);
    receipt(&r, r.batch, r.tick, PARTS - 1, false);
    nothing_comes(&r);
    assert_int_equal(r.events, PAIRS);
    cell_pose(r.alice, ALICE, ++r.sequence, 0, 1e4);
    int64_t batch = r.batch;
    b = await(&r);
    assert_true(!b.snapshot && b.batch == batch + 1 && b.behind == 0 && b.kinds.count == BALLS - 1);
    leave(&r);
}

static void a_loss_goes_on_from_where_it_was(void **state)
{
    (void)state;
    subscriber r = enter_and_ask();
    wire_event_batch b;
    await_parts(&r, 0, WINDOW, PARTS);
    cell_pose(r.alice, ALICE, ++r.sequence, 0, 1e4); /* it waits */
    cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    int64_t batch = r.batch, tick = r.tick;
    receipt(&r, batch, tick, 4, true); /* 5 has not come */
    for (int32_t part = 5; part < PARTS;) {
        b = await(&r);
        assert_true(b.snapshot && b.batch == batch && b.tick == tick);
        if (b.part != part) fail_msg("part %d, not %d", b.part, part);
        receipt(&r, batch, tick, part++, false);
    }
    b = await(&r);
    assert_true(!b.snapshot && b.batch == batch + 1 && b.kinds.count == BALLS - 1);
    receipt(&r, batch, tick, PARTS - 1, true); /* and this one once more */
    b = await(&r);
    assert_true(!b.snapshot && b.batch == batch + 1 && b.kinds.count == BALLS - 1);
    receipt(&r, batch + 1, 0, 0, false);
    nothing_comes(&r);
    receipt(&r, batch, tick, PARTS - 1, true); /* it was acknowledged, and is not kept any more: a snapshot comes */
    b = await(&r);
    assert_true(b.snapshot && b.batch == batch + 1 && b.tick > tick && b.part == 0);
    leave(&r);
}

static void a_receipt_of_another_epoch_or_an_older_one_is_none(void **state)
{
    (void)state;
    subscriber r = enter_and_ask();
    await_parts(&r, 0, WINDOW, PARTS);
    int64_t batch = r.batch, tick = r.tick, epoch = r.epoch;
    r.epoch++;
    receipt(&r, batch, tick, 7, false);
    r.epoch = epoch;
    int64_t newest = r.sequence;
    r.sequence = 1;
    receipt(&r, batch, tick, 7, false);
    r.sequence = newest;
    receipt(&r, batch, tick + 1, 7, false); /* of another snapshot */
    nothing_comes(&r);
    receipt(&r, batch, tick, 7, false);
    await_parts(&r, WINDOW, WINDOW + 8, PARTS);
    leave(&r);
}

static void who_does_not_read_is_named(void **state)
{
    (void)state;
    subscriber r = enter_and_ask();
    await_parts(&r, 0, WINDOW, PARTS);
    int64_t batch = r.batch, tick = r.tick;
    wire_status s = await_health(&r, WIRE_HEALTH_DEGRADED);
    assert_non_null(strstr(s.limits, "stream 0000000000000015.0 of client test starves"));
    assert_int_equal(cell_counter(&s, "streams_starving"), 1);
    assert_int_equal(cell_counter(&s, "streams_behind"), 1);
    assert_int_equal(cell_counter(&s, "behind_of_0000000000000015.0"), PARTS);
    receipt(&r, batch, tick, WINDOW - 1, false);
    await_parts(&r, WINDOW, PARTS, PARTS);
    receipt(&r, batch, tick, PARTS - 1, false);
    s = await_health(&r, WIRE_HEALTH_READY);
    assert_string_equal(s.limits, "");
    assert_int_equal(cell_counter(&s, "streams_starving"), 0);
    leave(&r);
}

/* Who asks again and again by his subscription, because what comes is too fast for him, is named as well. */
static void who_asks_again_and_again_is_named(void **state)
{
    (void)state;
    subscriber r = enter();
    make_balls(&r);
    cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    for (int i = 0; i < 5; i++) {
        cell_touches(r.alice, ALICE, ++r.sequence, 0);
        while (!await(&r).snapshot || r.part != 0) continue;
    }
    wire_status s = await_health(&r, WIRE_HEALTH_DEGRADED);
    assert_non_null(strstr(s.limits, "starves"));
    leave(&r);
}

/* ---- what takes several ticks ---- */

enum { IDS = 100000 };

/* What stands by what was told: the snapshot's, and what came behind it. */
typedef struct known {
    bool stands[IDS];
    size_t count;
} known;

static void learn(known *k, const wire_event_batch *b)
{
    for (uint32_t i = 0; i < b->kinds.count; i++) {
        int64_t id = b->contacts.at[i];
        if (b->kinds.at[i] != WIRE_EVENT_BEGIN && b->kinds.at[i] != WIRE_EVENT_END) continue;
        assert_in_range(id, 1, IDS - 1);
        bool begins = b->kinds.at[i] == WIRE_EVENT_BEGIN;
        assert_int_equal(k->stands[id], !begins);
        k->stands[id] = begins;
        k->count += begins ? 1 : (size_t)-1;
    }
}

/* All its parts are of one tick and one batch, and what happened meanwhile comes behind them, without a gap. */
static void a_snapshot_in_portions_is_one_state(void **state)
{
    (void)state;
    slice_us = 1; /* as few as may be: some hundred events of a snapshot a tick */
    subscriber r = enter_and_ask();
    known *k = calloc(1, sizeof *k);
    int64_t tick = 0, batch = 0;
    int32_t parts = 0, next = 0;
    for (int i = 0; i < BALLS / 2; i++) cell_pose(r.alice, ALICE, ++r.sequence, i, 1e4 + 100 * i);
    do {
        wire_event_batch b = await(&r);
        if (!b.snapshot) { /* of before it */
            assert_int_equal(next, 0);
            continue;
        }
        if (b.part == 0) *k = (known){.count = 0};
        if (b.part == 0) tick = b.tick, batch = b.batch, parts = b.parts, next = 0;
        assert_int_equal(b.part, next++);
        assert_true(b.tick == tick && b.batch == batch && b.parts == parts);
        learn(k, &b);
        receipt(&r, b.batch, b.tick, b.part, false);
    } while (!next || next < parts);
    size_t stay = BALLS - BALLS / 2;
    while (k->count != stay * (stay - 1) / 2) {
        wire_event_batch b = await(&r);
        if (b.heartbeat) continue;
        assert_false(b.snapshot);
        assert_int_equal(b.batch, ++batch);
        learn(k, &b);
        receipt(&r, b.batch, 0, 0, false);
    }
    slice_us = 0;
    free(k);
    leave(&r);
}

/* A subscription that closes, bodies that leave, and a client that is lost, over many ticks: a replay does the same. */
static void a_recording_of_what_ends_in_slices_is_replayed(void **state)
{
    (void)state;
    char folder[] = "/tmp/collided-backlog-XXXXXX";
    assert_non_null(mkdtemp(folder));
    snprintf(recording, sizeof recording, "%s/session.lcmlog", folder);
    slice_us = 1;
    subscriber r = enter_and_ask();
    cell_touches(r.alice, ALICE, ++r.sequence, 1);
    wire_message end = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r.sequence,
            .subscription = 0,
            .removed = 1,
            .stream = "",
            .select_a = "",
            .select_b = ""}};
    memory_send(r.alice, &end);
    bool closes = false;
    while (!closes) closes = await(&r).closing;
    for (int i = 0; i < BALLS; i++) {
        wire_message gone = {.kind = WIRE_BODY,
            .body = {.version = WIRE_VERSION, .client = ALICE, .sequence = ++r.sequence, .body = i, .removed = 1}};
        gone.body.name = gone.body.group = "";
        memory_send(r.alice, &gone);
    }
    cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    leave(&r);
    slice_us = 0;
    for (long workers = 1; workers <= 2; workers++) assert_int_equal(cell_replay(recording, workers, true), EX_OK);
    assert_int_equal(unlink(recording), 0);
    assert_int_equal(rmdir(folder), 0);
    recording[0] = '\0';
}

/* Receipts, and what they bring about, are no commands: a replay without them comes to the same events. */
static void a_recording_does_not_depend_on_who_reads(void **state)
{
    char folder[] = "/tmp/collided-backlog-XXXXXX";
    assert_non_null(mkdtemp(folder));
    snprintf(recording, sizeof recording, "%s/session.lcmlog", folder);
    a_loss_goes_on_from_where_it_was(state);
    for (long workers = 1; workers <= 2; workers++) assert_int_equal(cell_replay(recording, workers, true), EX_OK);
    assert_int_equal(cell_replay(recording, 1, false), EX_OK);
    assert_int_equal(unlink(recording), 0);
    assert_int_equal(rmdir(folder), 0);
    recording[0] = '\0';
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_sends_no_receipts_gets_all_slowly),
        cmocka_unit_test(receipts_pace_a_snapshot),
        cmocka_unit_test(a_loss_goes_on_from_where_it_was),
        cmocka_unit_test(a_receipt_of_another_epoch_or_an_older_one_is_none),
        cmocka_unit_test(a_recording_does_not_depend_on_who_reads),
        cmocka_unit_test(a_snapshot_in_portions_is_one_state),
        cmocka_unit_test(a_recording_of_what_ends_in_slices_is_replayed),
        cmocka_unit_test(who_does_not_read_is_named),
        cmocka_unit_test(who_asks_again_and_again_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
