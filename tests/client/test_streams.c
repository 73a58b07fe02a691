/* Streams: what a callback is told is always a state that the world was in. */
#include "cmocka_c.h"
#include "fake.h"

#include <stdio.h>
#include <string.h>

typedef struct heard {
    int batches;
    int64_t batch, lost, epoch;
    bool snapshot, closing;
    size_t events;
    char name_a[2][32];
    collided_event last;
    collided_contact_point point;
    collided *client;
    collided_subscription subscription;
    collided_status in_callback;
    int heartbeats, missing;
    int64_t oldest_pose_ns, simulation_ns;
    int notices, behind;
} heard;

static void note(void *context, const collided_batch *b)
{
    heard *h = context;
    h->behind = b->behind;
    h->notices += b->starved;
    if (b->starved) return;
    h->batches++;
    h->batch = b->batch;
    h->lost = b->lost;
    h->epoch = b->epoch;
    h->snapshot = b->snapshot;
    h->closing = b->closing;
    h->heartbeats += b->heartbeat;
    h->oldest_pose_ns = b->oldest_pose_ns;
    h->missing = b->missing;
    h->simulation_ns = b->simulation_ns;
    h->events = b->event_count;
    for (size_t i = 0; i < b->event_count && i < 2; i++)
        (void)snprintf(h->name_a[i], sizeof h->name_a[i], "%s", b->events[i].name_a);
    if (b->event_count) h->last = b->events[b->event_count - 1];
    if (b->event_count && h->last.point_count) h->point = h->last.points[0];
}

static void unsubscribe(void *context, const collided_batch *b)
{
    heard *h = context;
    note(context, b);
    h->in_callback = collided_poll(h->client, 1.0);
    assert_int_equal(collided_unsubscribe(h->client, h->subscription), COLLIDED_OK);
}

static collided_subscription subscribe(collided *c, heard *h, collided_events *callback)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.callback = callback;
    def.context = h;
    collided_subscription subscription = collided_subscribe(c, &def);
    assert_int_not_equal(subscription.id, COLLIDED_NONE);
    fake_settle(); /* acknowledged */
    return subscription;
}

typedef struct batch_options {
    int64_t epoch, batch, tick; /* tick: 0 = 100 more than the batch */
    bool snapshot;
    int32_t part, parts, behind;
    const char *name;
} batch_options;

/* More than 32 bits hold. */
#define FEATURE ((int64_t)70000 << 32 | 0x8005)

/* One event a batch. */
static void give(collided *c, batch_options o)
{
    const uint8_t kind[] = {WIRE_EVENT_BEGIN}, cause[] = {WIRE_CAUSE_SNAPSHOT}, points[] = {1},
                  achieved[] = {WIRE_STOPPED};
    const int64_t contact[] = {11}, age_a[] = {2000000}, age_b[] = {-1};
    const int32_t shape[] = {3};
    const int64_t feature[] = {FEATURE};
    const double lo[] = {-0.25}, hi[] = {-0.125}, axis[] = {0, 0, 1}, point[] = {1, 2, 3};
    const char *a[] = {o.name ? o.name : "a"}, *b[] = {"b"};
    const wire_message m = {.kind = WIRE_EVENT_BATCH,
        .event_batch = {.version = WIRE_VERSION,
            .client = collided_client_id(c),
            .epoch = o.epoch ? o.epoch : 1,
            .batch = o.batch,
            .tick = o.tick ? o.tick : 100 + o.batch,
            .snapshot = o.snapshot,
            .part = o.part,
            .parts = o.parts ? o.parts : 1,
            .behind = o.behind,
            .stream = "s",
            .kinds = {1, kind},
            .causes = {1, cause},
            .contacts = {1, contact},
            .names_a = {1, a},
            .names_b = {1, b},
            .shapes_a = {1, shape},
            .shapes_b = {1, shape},
            .lo = {1, lo},
            .hi = {1, hi},
            .axes = {3, axis},
            .points_a = {3, point},
            .points_b = {3, point},
            .ages_a_ns = {1, age_a},
            .ages_b_ns = {1, age_b},
            .achieved = {1, achieved},
            .undone = 7,
            .manifold_counts = {1, points},
            .manifold_points = {3, point},
            .manifold_distances = {1, lo},
            .manifold_features = {1, feature}}};
    fake_give(&m);
}

/* It has no events, and the number of the last batch. */
static void give_heartbeat_of(collided *c, int64_t epoch, int64_t batch)
{
    const wire_message m = {.kind = WIRE_EVENT_BATCH,
        .event_batch = {.version = WIRE_VERSION,
            .client = collided_client_id(c),
            .epoch = epoch,
            .batch = batch,
            .oldest_pose_ns = 77,
            .missing = 2,
            .simulation_ns = 91,
            .heartbeat = 1,
            .parts = 1,
            .stream = "s"}};
    fake_give(&m);
}

static void give_heartbeat(collided *c, int64_t batch)
{
    give_heartbeat_of(c, 1, batch);
}

static void events_arrive_as_they_were_sent(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    char own[40];
    (void)snprintf(own, sizeof own, "%016llx.0", (unsigned long long)collided_client_id(c));
    assert_string_equal(fake_message(WIRE_SUBSCRIPTION, 0)->subscription.stream, own);
    give(c, (batch_options){.batch = 1, .snapshot = true});
    assert_int_equal(collided_poll(c, 1.0), COLLIDED_OK);
    assert_int_equal(h.batches, 1);
    assert_true(h.snapshot && h.batch == 1 && h.lost == 0 && h.events == 1);
    const collided_event *e = &h.last;
    assert_true(e->kind == COLLIDED_BEGIN && e->contact == 11 && e->shape_b == 3 && e->lo == -0.25 && e->hi == -0.125);
    assert_string_equal(e->cause, "snapshot");
    assert_true(e->age_a_s == 0.002 && e->age_b_s == -1.0 && e->axis[2] == 1.0 && e->point_a[1] == 2.0);
    assert_true(
        e->point_count == 1 && h.point.point[2] == 3.0 && h.point.distance == -0.25 && h.point.feature == FEATURE);
    collided_close(c);
}

static const wire_receipt *last_receipt(void)
{
    assert_true(fake_sent(WIRE_RECEIPT) > 0);
    return &fake_message(WIRE_RECEIPT, fake_sent(WIRE_RECEIPT) - 1)->receipt;
}

static void after_a_gap_nothing_is_told_until_a_snapshot_comes(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 1, .snapshot = true});
    give(c, (batch_options){.batch = 2});
    give(c, (batch_options){.batch = 4});
    (void)collided_poll(c, 0.0);
    assert_true(h.batches == 2 && h.batch == 2);
    const wire_receipt *lacks = last_receipt();
    assert_true(
        lacks->missing && lacks->subscription == 0 && lacks->epoch == 1 && lacks->batch == 2 && lacks->tick == 0);
    size_t sent = fake_sent(WIRE_RECEIPT);
    give(c, (batch_options){.batch = 5});
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 2);
    assert_int_equal(fake_sent(WIRE_RECEIPT), sent); /* it has been said */
    give(c, (batch_options){.batch = 5, .snapshot = true});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 3 && h.snapshot && h.lost == 3); /* 3, 4 and 5 */
    assert_non_null(strstr(collided_error(c), "3 batches were lost"));
    give(c, (batch_options){.batch = 6});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 4 && h.lost == 0 && !h.snapshot);
    give(c, (batch_options){.batch = 6}); /* a duplicate */
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 4);
    collided_close(c);
}

static void a_snapshot_that_was_overtaken_is_not_told(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 5, .snapshot = true});
    give(c, (batch_options){.batch = 6});
    give(c, (batch_options){.batch = 4, .snapshot = true});
    give(c, (batch_options){.batch = 7});
    for (int i = 0; i < 8; i++) collided_poll(c, 0.01);
    assert_true(h.batches == 3 && h.batch == 7 && h.lost == 0);
    give(c, (batch_options){.epoch = A_LATER_EPOCH, .batch = 1, .snapshot = true});
    for (int i = 0; i < 4; i++) collided_poll(c, 0.01);
    assert_true(h.batches == 4 && h.epoch == A_LATER_EPOCH && h.batch == 1);
    collided_close(c);
}

static void a_heartbeat_is_told_and_finds_out_what_was_lost(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give_heartbeat(c, 5); /* before the first snapshot it says nothing */
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 0);
    give(c, (batch_options){.batch = 1, .snapshot = true});
    give_heartbeat(c, 1);
    give_heartbeat(c, 1);
    (void)collided_poll(c, 1.0);
    (void)collided_poll(c, 0.0);
    assert_true(h.batches == 3 && h.heartbeats == 2 && h.batch == 1 && h.oldest_pose_ns == 77 && h.missing == 2);
    assert_int_equal(h.simulation_ns, 91);
    assert_int_equal(fake_sent(WIRE_SUBSCRIPTION), 1);
    give_heartbeat(c, 3); /* 2 and 3 have not come */
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 3);
    assert_int_equal(fake_sent(WIRE_SUBSCRIPTION), 1);
    assert_true(last_receipt()->missing && last_receipt()->batch == 1 && last_receipt()->tick == 101);
    give(c, (batch_options){.batch = 3, .snapshot = true});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 4 && h.snapshot && h.lost == 2);
    collided_close(c);
}

static void a_first_batch_that_is_no_snapshot_is_not_told(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 2});
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 0);
    double waited_s = 0; /* no snapshot comes: it is asked for again after two seconds at most */
    for (; fake_sent(WIRE_SUBSCRIPTION) < 2 && waited_s < FAKE_PATIENCE_S; waited_s += 0.1) (void)collided_poll(c, 0.1);
    assert_int_equal(fake_sent(WIRE_SUBSCRIPTION), 2);
    give(c, (batch_options){.batch = 3, .snapshot = true});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 1 && h.lost == 0); /* what came before is none of ours */
    collided_close(c);
}

/* Whoever polls without ever waiting is as deaf as anybody without a snapshot, and asks for it as well. */
static void who_never_waits_asks_again_too(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    for (int tries = 0; fake_sent(WIRE_SUBSCRIPTION) < 2 && tries < 100 * FAKE_PATIENCE_S; tries++) {
        (void)collided_poll(c, 0.0);
        fake_pause(10);
    }
    assert_int_equal(fake_sent(WIRE_SUBSCRIPTION), 2);
    assert_true(fake_message(WIRE_SUBSCRIPTION, 1)->subscription.sequence >
                fake_message(WIRE_SUBSCRIPTION, 0)->subscription.sequence);
    collided_close(c);
}

/* The daemon is heard, and may have lost the subscription all the same. */
static void a_silent_stream_is_asked_for_again(void **state)
{
    (void)state;
    heard h = {0};
    char why[256] = "";
    collided_def def = collided_def_default(); /* its lease: a longer one would make it more patient */
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_try(&def, why, sizeof why);
    assert_non_null(c);
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 1, .snapshot = true});
    fake_pause(3200);
    fake_status(1);
    (void)collided_poll(c, 0.1); /* nobody had looked: it was not silent */
    assert_int_equal(fake_sent(WIRE_SUBSCRIPTION), 1);
    for (int tries = 0; fake_sent(WIRE_SUBSCRIPTION) < 2 && tries < 100 * FAKE_PATIENCE_S; tries++) {
        fake_status(1);
        (void)collided_poll(c, 0.01);
    }
    assert_int_equal(fake_sent(WIRE_SUBSCRIPTION), 2);
    give(c, (batch_options){.batch = 1, .tick = 200, .snapshot = true});
    (void)collided_poll(c, 0.0);
    assert_true(h.batches == 2 && h.lost == 0);
    collided_close(c);
}

static void parts_are_one_batch(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 0, .parts = 2, .name = "first"});
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 0);
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 1, .parts = 2, .name = "second"});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 1 && h.events == 2 && h.snapshot && h.batch == 1);
    assert_string_equal(h.name_a[0], "first");
    assert_string_equal(h.name_a[1], "second");
    give(c, (batch_options){.batch = 2, .part = 0, .parts = 3});
    give(c, (batch_options){.batch = 4, .part = 2, .parts = 3}); /* the middle is lost: so is the whole */
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 1);
    assert_true(last_receipt()->missing && last_receipt()->batch == 2);
    give(c, (batch_options){.batch = 4, .snapshot = true});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 2 && h.lost == 3);
    give(c, (batch_options){.batch = 5, .part = 0, .parts = 3});
    give(c, (batch_options){.batch = 7, .part = 2, .parts = 3});
    (void)collided_poll(c, 0.0);
    give(c, (batch_options){.batch = 6, .part = 1, .parts = 3}); /* sent again from there: nothing is lost */
    give(c, (batch_options){.batch = 7, .part = 2, .parts = 3});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 3 && h.lost == 0 && h.events == 3 && !h.snapshot);
    collided_close(c);
}

/* What of a snapshot has come is kept: it goes on behind that, and is delivered when it is whole. */
static void a_snapshot_goes_on_where_it_was_cut(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 0, .parts = 4, .behind = 4});
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 1, .parts = 4, .behind = 3});
    (void)collided_poll(c, 0.0);
    assert_true(!last_receipt()->missing && last_receipt()->batch == 1 && last_receipt()->tick == 101);
    assert_int_equal(last_receipt()->part, 1);
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 3, .parts = 4, .behind = 1}); /* without 2 */
    give(c, (batch_options){.batch = 2});
    (void)collided_poll(c, 0.0);
    assert_true(last_receipt()->missing && last_receipt()->tick == 101 && last_receipt()->part == 1);
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 1, .parts = 4, .behind = 3}); /* a copy */
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 2, .parts = 4, .behind = 2});
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 3, .parts = 4, .behind = 1});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 1 && h.snapshot && h.events == 4 && h.lost == 0 && h.behind == 4);
    assert_true(!last_receipt()->missing && last_receipt()->tick == 101 && last_receipt()->part == 3);
    give(c, (batch_options){.batch = 2});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 2 && !h.snapshot && h.lost == 0 && h.behind == 0);
    assert_int_equal(fake_sent(WIRE_SUBSCRIPTION), 1);
    collided_close(c);
}

/* Another one begins before that one is whole: nothing of the first is delivered. */
static void of_two_snapshots_the_newer_one_counts(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 0, .parts = 3});
    give(c, (batch_options){.batch = 1, .tick = 200, .snapshot = true, .part = 0, .parts = 2, .name = "x"});
    give(c, (batch_options){.batch = 1, .snapshot = true, .part = 1, .parts = 3});
    give(c, (batch_options){.batch = 1, .tick = 200, .snapshot = true, .part = 1, .parts = 2, .name = "y"});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 1 && h.events == 2 && h.lost == 0);
    assert_string_equal(h.name_a[0], "x");
    assert_string_equal(h.name_a[1], "y");
    collided_close(c);
}

static void a_callback_hears_that_its_stream_starves(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 1, .snapshot = true});
    give(c, (batch_options){.batch = 3});
    for (int tries = 0; !h.notices && tries < 100 * FAKE_PATIENCE_S; tries++) {
        fake_status(1); /* the daemon is heard */
        (void)collided_poll(c, 0.01);
    }
    assert_true(h.notices == 1 && h.batches == 1);
    assert_non_null(strstr(collided_error(c), "starves"));
    assert_true(fake_sent(WIRE_RECEIPT) > 2); /* it was asked again */
    for (int tries = 0; fake_sent(WIRE_SUBSCRIPTION) < 2 && tries < 100 * FAKE_PATIENCE_S; tries++) {
        fake_status(1); /* in vain: then as for the first time */
        (void)collided_poll(c, 0.01);
    }
    give(c, (batch_options){.batch = 3, .snapshot = true});
    (void)collided_poll(c, 1.0);
    assert_true(h.notices == 1 && h.batches == 2 && h.snapshot && h.lost == 2);
    collided_close(c);
}

static void who_keeps_up_says_so_now_and_then(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 1, .snapshot = true});
    (void)collided_poll(c, 1.0);
    (void)collided_poll(c, 0.0);
    assert_int_equal(fake_sent(WIRE_RECEIPT), 1);
    for (int64_t batch = 2; batch <= 129; batch++) give(c, (batch_options){.batch = batch});
    while (h.batch < 129) (void)collided_poll(c, 1.0);
    assert_int_equal(fake_sent(WIRE_RECEIPT), 3);
    assert_true(last_receipt()->batch == 129 && last_receipt()->tick == 0 && !last_receipt()->missing);
    collided_close(c);
}

static void a_new_epoch_begins_with_a_snapshot(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    give(c, (batch_options){.batch = 1, .snapshot = true});
    fake_set((fake_options){.epoch = A_LATER_EPOCH});
    give(c, (batch_options){.epoch = A_LATER_EPOCH, .batch = 1, .snapshot = true});
    give(c, (batch_options){.epoch = 1, .batch = 2}); /* late news of the old daemon */
    (void)collided_poll(c, 0.0);
    assert_true(h.batches == 2 && h.epoch == A_LATER_EPOCH && h.lost == 0);
    give(c, (batch_options){.epoch = A_LATER_EPOCH, .batch = 2});
    (void)collided_poll(c, 1.0);
    assert_true(h.batches == 3 && h.lost == 0);
    collided_close(c);
}

/* A standby has taken over, and knows less than we were told: what it tells under those numbers is something else. */
static void who_was_told_more_than_a_standby_knew_says_so_and_believes_no_batch(void **state)
{
    bool anew = *state != NULL; /* it begins a new line, as it should; or tells all of its own again */
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    for (int64_t batch = 1; batch <= 3; batch++) give(c, (batch_options){.batch = batch, .snapshot = batch == 1});
    (void)collided_poll(c, 1.0);
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 3);
    fake_set((fake_options){.epoch = 2});
    give_heartbeat_of(c, 2, 2);
    (void)collided_poll(c, 1.0);
    assert_true(last_receipt()->missing && last_receipt()->batch == 3 && last_receipt()->epoch == 1);
    for (int64_t batch = 3; batch <= 5; batch++) give(c, (batch_options){.epoch = 2, .batch = batch});
    (void)collided_poll(c, 0.0);
    assert_int_equal(h.batches, 3);
    int64_t epoch = anew ? A_LATER_EPOCH : 2;
    fake_set((fake_options){.epoch = epoch});
    give(c, (batch_options){.epoch = epoch, .batch = 5, .snapshot = true});
    give(c, (batch_options){.epoch = epoch, .batch = 6});
    while (h.batches < 5) (void)collided_poll(c, 1.0);
    assert_true(h.batch == 6 && h.epoch == epoch);
    collided_close(c);
}

/* What comes once more is no news, and a standby that knows all goes on. */
static void a_standby_that_knew_all_goes_on(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    for (int64_t batch = 1; batch <= 3; batch++) give(c, (batch_options){.batch = batch, .snapshot = batch == 1});
    fake_set((fake_options){.epoch = 2});
    for (int64_t batch = 1; batch <= 3; batch++)
        give(c, (batch_options){.epoch = 2, .batch = batch, .snapshot = batch == 1});
    give_heartbeat_of(c, 2, 3);
    give(c, (batch_options){.epoch = 2, .batch = 4});
    while (h.batch < 4) (void)collided_poll(c, 1.0);
    assert_true(h.batches == 5 && h.heartbeats == 1 && h.lost == 0 && h.epoch == 2);
    collided_close(c);
}

static void a_callback_may_unsubscribe_but_not_wait(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = h.client = fake_connect();
    h.subscription = subscribe(c, &h, unsubscribe);
    give(c, (batch_options){.batch = 1, .snapshot = true});
    give(c, (batch_options){.batch = 2});
    (void)collided_poll(c, 1.0);
    assert_int_equal(h.batches, 1);
    assert_int_equal(h.in_callback, COLLIDED_BAD_ARGUMENT);
    assert_true(fake_message(WIRE_SUBSCRIPTION, 1)->subscription.removed);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_unsubscribe(c, h.subscription), COLLIDED_UNKNOWN_ID);
    collided_close(c);
}

/* What is told before the daemon knows that somebody listens is told to nobody. The same again of one that begins
 * anew, of another daemon. */
static void a_sync_waits_for_the_first_batch_of_each_stream(void **state)
{
    (void)state;
    heard h = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    subscribe(c, &h, note);
    assert_int_equal(collided_sync(c, 0.05), COLLIDED_TIMEOUT);
    if (!strstr(collided_error(c), "has not begun")) fail_msg("%s", collided_error(c));
    give(c, (batch_options){.batch = 3}); /* lost its snapshot: nothing is delivered */
    assert_int_equal(collided_sync(c, 0.05), COLLIDED_TIMEOUT);
    give(c, (batch_options){.batch = 4, .snapshot = true, .parts = 2});
    assert_int_equal(collided_sync(c, 0.05), COLLIDED_TIMEOUT);
    give(c, (batch_options){.batch = 4, .snapshot = true, .part = 1, .parts = 2});
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_sync(c, 0), COLLIDED_OK);
    fake_set((fake_options){.epoch = A_LATER_EPOCH});
    fake_status(A_LATER_EPOCH);
    fake_settle();
    assert_int_equal(collided_sync(c, 0.05), COLLIDED_TIMEOUT);
    for (int64_t n = 1; n <= 2; n++) /* the subscription is announced to it */
        give(c, (batch_options){.epoch = A_LATER_EPOCH, .batch = n, .snapshot = n == 1});
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    collided_close(c);
}

static void bad_subscriptions_are_refused(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_subscription_def def = collided_subscription_def_default();
    assert_int_equal(collided_subscribe(c, &def).id, COLLIDED_NONE);
    assert_non_null(strstr(collided_error(c), "callback"));
    def.callback = note;
    def.tolerance_m = 0.0 / 0.0;
    assert_int_equal(collided_subscribe(c, &def).id, COLLIDED_NONE);
    assert_int_equal(fake_sent(WIRE_SUBSCRIPTION), 0);
    collided_close(c);
}

int main(void)
{
    static int anew = 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(events_arrive_as_they_were_sent),
        cmocka_unit_test(after_a_gap_nothing_is_told_until_a_snapshot_comes),
        cmocka_unit_test(a_snapshot_that_was_overtaken_is_not_told),
        cmocka_unit_test(a_heartbeat_is_told_and_finds_out_what_was_lost),
        cmocka_unit_test(a_first_batch_that_is_no_snapshot_is_not_told),
        cmocka_unit_test(who_never_waits_asks_again_too),
        cmocka_unit_test(a_silent_stream_is_asked_for_again),
        cmocka_unit_test(parts_are_one_batch),
        cmocka_unit_test(a_snapshot_goes_on_where_it_was_cut),
        cmocka_unit_test(of_two_snapshots_the_newer_one_counts),
        cmocka_unit_test(a_callback_hears_that_its_stream_starves),
        cmocka_unit_test(who_keeps_up_says_so_now_and_then),
        cmocka_unit_test(a_new_epoch_begins_with_a_snapshot),
        cmocka_unit_test(who_was_told_more_than_a_standby_knew_says_so_and_believes_no_batch),
        cmocka_unit_test_prestate(who_was_told_more_than_a_standby_knew_says_so_and_believes_no_batch, &anew),
        cmocka_unit_test(a_standby_that_knew_all_goes_on),
        cmocka_unit_test(a_sync_waits_for_the_first_batch_of_each_stream),
        cmocka_unit_test(a_callback_may_unsubscribe_but_not_wait),
        cmocka_unit_test(bad_subscriptions_are_refused),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    fake_begin((fake_options){0});
    return failed;
}
