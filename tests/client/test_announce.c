/* What is announced arrives: repetition, acknowledgement, restarts of the daemon, refusals, leaving in order. */
#include "announce.h"
#include "cmocka_c.h"
#include "fake.h"

#include <stdio.h>
#include <string.h>

static collided_body make(collided *c, const char *name)
{
    const collided_shape ball = collided_sphere(0.1);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &ball;
    def.shape_count = 1;
    collided_body body = collided_create_body(c, &def);
    assert_int_not_equal(body.id, COLLIDED_NONE);
    return body;
}

static void a_shape_s_deviation_is_announced(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_shape shapes[] = {collided_sphere(0.1), collided_box(1, 1, 1)};
    shapes[1].deviation = 0.02;
    collided_body_def def = collided_body_def_default();
    def.name = "part";
    def.shapes = shapes;
    def.shape_count = 2;
    assert_int_not_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    const wire_body *sent = &fake_message(WIRE_BODY, 0)->body;
    assert_int_equal(sent->shape_deviations.count, 2);
    assert_true(sent->shape_deviations.at[0] == 0 && sent->shape_deviations.at[1] == 0.02);
    collided_close(c);
}

static void connecting_without_a_daemon_fails_and_says_so(void **state)
{
    (void)state;
    fake_begin((fake_options){.deaf = true});
    collided_def def = collided_def_default();
    def.connect_timeout_s = 0.1;
    char why[256] = "";
    assert_null(fake_try(&def, why, sizeof why));
    assert_non_null(strstr(why, "no daemon"));
    def.connect_timeout_s = 0.0;
    collided *c = fake_try(&def, why, sizeof why);
    assert_non_null(c);
    collided_close(c);
}

/* How often it may have been sent since then: at once, and after pauses that double. However slow the machine. */
static size_t at_most(int64_t begin_ns, int64_t first_pause_ns)
{
    size_t count = 1;
    for (int64_t due = begin_ns + first_pause_ns; due <= session_monotonic_ns(); due += first_pause_ns <<= 1) count++;
    return count;
}

static void unacknowledged_announcements_are_repeated_with_growing_pauses(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
    collided *c = fake_connect();
    int64_t begin = session_monotonic_ns();
    make(c, "part");
    const wire_message *first = fake_message(WIRE_BODY, 0), *fourth = fake_message(WIRE_BODY, 3);
    assert_true(first->body.sequence == fourth->body.sequence);
    fake_pause(100); /* 0, 50, 150, 350, 750 ms */
    size_t sent = fake_sent(WIRE_BODY);
    assert_in_range(sent, 4, at_most(begin, ANNOUNCE_FIRST_REPEAT_MS * NS_PER_MS));
    assert_int_equal(collided_sync(c, 0.0), COLLIDED_TIMEOUT);
    fake_ack(first);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    sent = fake_sent(WIRE_BODY);
    fake_pause(1200);
    assert_int_equal(fake_sent(WIRE_BODY), sent);
    fake_set((fake_options){.repeats = true, .epoch = 1});
    collided_close(c);
}

static void a_transport_that_keeps_announcements_repeats_what_is_not_answered(void **state)
{
    (void)state;
    fake_begin((fake_options){.ignored = WIRE_BODY, .epoch = 1});
    collided *c = fake_connect();
    int64_t begin = session_monotonic_ns();
    make(c, "part");
    const wire_message *first = fake_message(WIRE_BODY, 0), *third = fake_message(WIRE_BODY, 2);
    assert_true(first->body.sequence == third->body.sequence);
    fake_pause(200); /* 0, 100, 300, 700 ms */
    size_t sent = fake_sent(WIRE_BODY);
    assert_in_range(sent, 3, at_most(begin, ANNOUNCE_FIRST_DOUBT_MS * NS_PER_MS));
    fake_ack(first);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    sent = fake_sent(WIRE_BODY);
    fake_pause(1200);
    assert_int_equal(fake_sent(WIRE_BODY), sent);
    fake_set((fake_options){.epoch = 1});
    collided_close(c);
}

static void heartbeats_come_three_times_a_lease(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided_def def = collided_def_default();
    def.lease_s = 0.6;
    def.connect_timeout_s = FAKE_PATIENCE_S;
    char why[256] = "";
    int64_t begin = session_monotonic_ns();
    collided *c = fake_try(&def, why, sizeof why);
    assert_non_null(c);
    fake_message(WIRE_CLIENT, 5);
    size_t sent = fake_sent(WIRE_CLIENT);
    assert_true(sent <= 4 + (size_t)((session_monotonic_ns() - begin) / (NS_PER_S / 5)));
    assert_true(fake_message(WIRE_CLIENT, 2)->client.sequence > fake_message(WIRE_CLIENT, 1)->client.sequence);
    collided_close(c);
}

/* The daemon has heard none of them, then, and has lost us; nor would we have heard that. */
static void heartbeats_that_were_not_answered_for_a_lease_have_all_announced_again(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided_def def = collided_def_default();
    def.lease_s = 0.6;
    def.connect_timeout_s = FAKE_PATIENCE_S;
    char why[256] = "";
    collided *c = fake_try(&def, why, sizeof why);
    assert_non_null(c);
    make(c, "table");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    fake_set((fake_options){.repeats = true, .ignored = WIRE_CLIENT, .epoch = 1});
    fake_pause(1000);
    fake_set((fake_options){.repeats = true, .epoch = 1});
    assert_string_equal(fake_message(WIRE_BODY, 1)->body.name, "table");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    collided_close(c);
}

static collided_pose at(double x)
{
    collided_pose pose = collided_pose_identity();
    pose.position[0] = x;
    return pose;
}

static void a_restarted_daemon_is_told_everything_again_in_order(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    collided_body a = make(c, "a"), b = make(c, "b");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_move(c, a, at(3.0)), COLLIDED_OK);
    collided_remove_body(c, b);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    size_t clients = fake_sent(WIRE_CLIENT);
    fake_set((fake_options){.repeats = true, .epoch = A_LATER_EPOCH});
    fake_status(A_LATER_EPOCH);
    const wire_message *body = fake_message(WIRE_BODY, 3), *client = fake_message(WIRE_CLIENT, clients);
    assert_string_equal(body->body.name, "a");
    assert_true(body->body.pose.at[0] == 3.0); /* the newest pose */
    assert_true(body->body.sequence > fake_message(WIRE_POSE_BATCH, 0)->pose_batch.sequence);
    assert_true(fake_position(client) < fake_position(body));
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(fake_sent(WIRE_BODY), 4); /* a, b, b removed, a again: what is gone stays gone */
    collided_close(c);
}

static void a_transport_that_keeps_sends_only_the_newer_pose_to_a_new_daemon(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_body a = make(c, "a");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_move(c, a, at(3.0)), COLLIDED_OK);
    fake_set((fake_options){.epoch = A_LATER_EPOCH});
    fake_ack(fake_message(WIRE_BODY, 0)); /* the new daemon found it in the transport */
    const wire_message *pose = fake_message(WIRE_POSE_BATCH, 1);
    assert_int_equal(pose->pose_batch.teleports.count, 1); /* it knows the pose of old: no way leads from there */
    assert_true(pose->pose_batch.positions.at[0] == 3.0);
    assert_int_equal(fake_sent(WIRE_BODY), 1);
    collided_close(c);
}

static void an_older_daemon_is_not_followed_while_ours_speaks(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 5});
    collided *c = fake_connect();
    make(c, "a");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    fake_status(4);
    fake_settle();
    fake_pause(50);
    assert_int_equal(fake_sent(WIRE_BODY), 1);
    fake_status(5);
    collided_daemon_status status;
    assert_int_equal(collided_get_status(c, FAKE_PATIENCE_S, &status), COLLIDED_OK);
    assert_int_equal(status.epoch, 5);
    assert_string_equal(status.health, "ready");
    int64_t foreign = 0;
    for (size_t i = 0; i < status.counter_count; i++)
        if (!strcmp(status.counters[i].name, "client_foreign_messages")) foreign = status.counters[i].value;
    assert_int_equal(foreign, 1);
    collided_close(c);
}

/* As one of two daemons does that have found each other, when it steps down. */
static void a_daemon_that_ends_is_left_at_once_and_followed_no_more(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = A_LATER_EPOCH});
    collided *c = fake_connect();
    make(c, "a");
    assert_int_equal(collided_sync(c, 1.0), COLLIDED_OK);
    fake_end(A_LATER_EPOCH);
    fake_set((fake_options){.repeats = true, .epoch = 1});
    fake_status(1);
    assert_string_equal(fake_message(WIRE_BODY, 1)->body.name, "a"); /* by one Status, without a silence */
    fake_status(A_LATER_EPOCH);                                      /* late news of the one that ended */
    assert_int_equal(collided_sync(c, 1.0), COLLIDED_OK);
    collided_daemon_status status;
    assert_int_equal(collided_get_status(c, 1.0, &status), COLLIDED_OK);
    assert_int_equal(status.epoch, 1);
    assert_int_equal(fake_sent(WIRE_BODY), 2);
    collided_close(c);
}

/* DDS keeps the last Status of a daemon that has become a standby, and gives it to whoever comes. */
static void a_daemon_that_has_ended_is_not_followed_by_who_comes_later(void **state)
{
    (void)state;
    fake_begin((fake_options){.deaf = true, .epoch = 1});
    collided_def def = collided_def_default();
    def.connect_timeout_s = 0.0;
    char why[256];
    collided *c = fake_try(&def, why, sizeof why);
    assert_non_null(c);
    fake_end(A_LATER_EPOCH);
    fake_status(1);
    collided_daemon_status status;
    assert_int_equal(collided_get_status(c, 1.0, &status), COLLIDED_OK);
    assert_int_equal(status.epoch, 1);
    collided_close(c);
}

typedef struct told {
    int count;
    int32_t object;
    char reason[32], text[64];
} told;

static void note(void *context, const collided_rejection *why)
{
    told *t = context;
    t->count++;
    t->object = why->object;
    (void)snprintf(t->reason, sizeof t->reason, "%s", why->reason);
    (void)snprintf(t->text, sizeof t->text, "%s", why->text);
}

static void refusals_are_told_and_end_the_wait(void **state)
{
    (void)state;
    told t = {0};
    fake_begin((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
    collided *c = fake_connect();
    collided_on_rejected(c, note, &t);
    collided_body body = make(c, "part");
    fake_reject(fake_message(WIRE_BODY, 0), WIRE_NAME_TAKEN, "by another");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_REJECTED);
    assert_non_null(strstr(collided_error(c), "name_taken"));
    assert_int_equal(t.count, 1);
    assert_int_equal(t.object, body.id);
    assert_string_equal(t.reason, "name_taken");
    assert_string_equal(t.text, "by another");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK); /* told once */
    assert_int_equal(collided_move(c, body, at(1.0)), COLLIDED_REJECTED);
    fake_set((fake_options){.repeats = true, .epoch = 1});
    collided_close(c);
}

static void too_many_refusals_are_counted(void **state)
{
    (void)state;
    told t = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_on_rejected(c, note, &t);
    const wire_message pose = {.kind = WIRE_POSE_BATCH, .pose_batch = {.version = 1, .client = collided_client_id(c)}};
    for (int i = 0; i < SESSION_REJECTIONS_MAX + 10; i++) fake_reject(&pose, WIRE_BAD_NUMBER, "x");
    fake_status(1);
    fake_settle();
    assert_int_equal(collided_poll(c, 0.0), COLLIDED_OK);
    assert_int_equal(t.count, SESSION_REJECTIONS_MAX + 1);
    assert_non_null(strstr(t.text, "10 further"));
    collided_close(c);
}

static void a_daemon_that_lost_us_is_told_again(void **state)
{
    (void)state;
    told t = {0};
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_on_rejected(c, note, &t);
    collided_body body = make(c, "part");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_move(c, body, at(1.0)), COLLIDED_OK);
    fake_reject(fake_message(WIRE_POSE_BATCH, 0), WIRE_UNKNOWN_CLIENT, "");
    const wire_message *again = fake_message(WIRE_BODY, 1);
    assert_true(again->body.sequence > fake_message(WIRE_POSE_BATCH, 0)->pose_batch.sequence);
    assert_true(again->body.pose.at[0] == 1.0);
    assert_int_equal(fake_sent(WIRE_CLIENT), 2);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(t.count, 0);
    collided_close(c);
}

/* The second loss within a second is not answered at once, and not forgotten. */
static void a_daemon_that_lost_us_twice_is_told_twice(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    make(c, "part");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    wire_message lost = *fake_message(WIRE_CLIENT, 0);
    lost.client.sequence = 0; /* it refuses no message */
    int64_t begin = session_monotonic_ns();
    fake_reject(&lost, WIRE_UNKNOWN_CLIENT, "");
    fake_message(WIRE_BODY, 1);
    fake_reject(&lost, WIRE_UNKNOWN_CLIENT, "");
    fake_message(WIRE_BODY, 2);
    assert_true(session_monotonic_ns() - begin >= NS_PER_S);
    collided_close(c);
}

/* An earlier process under our id has counted further than we. */
static void an_ack_beyond_our_own_makes_us_count_on_from_there(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    make(c, "part");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    wire_message beyond = *fake_message(WIRE_BODY, 0);
    int64_t newest = beyond.body.sequence += 1000000;
    fake_ack(&beyond);
    assert_int_equal(fake_message(WIRE_CLIENT, 1)->client.sequence, newest + 1);
    assert_int_equal(fake_message(WIRE_BODY, 1)->body.sequence, newest + 2);
    beyond.body.sequence = INT64_MAX; /* nobody counts so far */
    fake_ack(&beyond);
    fake_settle();
    fake_pause(50);
    assert_int_equal(fake_sent(WIRE_BODY), 2);
    collided_close(c);
}

static void what_came_before_what_it_needs_is_announced_again(void **state)
{
    (void)state;
    fake_begin((fake_options){.ignored = WIRE_BODY, .epoch = 1});
    collided *c = fake_connect();
    make(c, "part");
    fake_reject(fake_message(WIRE_BODY, 0), WIRE_UNKNOWN_GEOMETRY, "not yet");
    fake_set((fake_options){.epoch = 1});
    const wire_message *again = fake_message(WIRE_BODY, 1);
    assert_true(again->body.sequence > fake_message(WIRE_BODY, 0)->body.sequence);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    collided_close(c);
}

static void leaving_removes_bodies_before_the_client(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    make(c, "a");
    make(c, "b");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    collided_close(c);
    const wire_message *a = fake_message(WIRE_BODY, 2), *b = fake_message(WIRE_BODY, 3);
    const wire_message *client = fake_message(WIRE_CLIENT, fake_sent(WIRE_CLIENT) - 1);
    assert_true(a->body.removed && a->body.body == 0 && b->body.removed && b->body.body == 1);
    assert_true(client->client.removed && fake_position(client) > fake_position(b));
}

static void leaving_keeps_what_was_to_be_kept(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided_def def = collided_def_default();
    def.on_loss = COLLIDED_KEEP;
    def.id = 77;
    char why[256];
    collided *c = fake_try(&def, why, sizeof why);
    make(c, "a");
    assert_int_equal(collided_adopt_body(c, 9).id, 9);
    assert_int_equal(collided_move(c, (collided_body){9}, at(1.0)), COLLIDED_OK);
    collided_close(c);
    assert_int_equal(fake_sent(WIRE_BODY), 1);
    assert_int_equal(fake_sent(WIRE_POSE_BATCH), 1);
    assert_int_equal(fake_message(WIRE_POSE_BATCH, 0)->pose_batch.client, 77);
}

/* As over a network that lost the removal at first: the new body is heard of before the old one is gone, or the answer
 * to that is. */
static void a_name_that_is_being_left_is_taken_in_the_end(void **state)
{
    (void)state;
    for (int late = 0; late < 2; late++)
        for (int renamed = 0; renamed < 2; renamed++) {
            fake_begin((fake_options){.repeats = true, .epoch = 1});
            collided *c = fake_connect();
            collided_body old = make(c, "a");
            assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
            fake_set((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
            const collided_shape ball = collided_sphere(0.1);
            collided_body_def def = collided_body_def_default();
            def.name = "b";
            def.shapes = &ball;
            def.shape_count = 1;
            assert_int_equal(renamed ? collided_change_body(c, old, &def) : collided_remove_body(c, old), COLLIDED_OK);
            const wire_message *left = fake_message(WIRE_BODY, 1);
            make(c, "a");
            const wire_message *heir = fake_message(WIRE_BODY, 2);
            for (size_t n = 3; strcmp(heir->body.name, "a") != 0; n++) heir = fake_message(WIRE_BODY, n);
            if (late) fake_ack(left);
            fake_reject(heir, WIRE_NAME_TAKEN, "a");
            fake_settle();
            fake_set((fake_options){.repeats = true, .epoch = 1});
            assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
            collided_close(c);
        }
}

static void a_name_that_another_one_has_is_refused(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
    collided *c = fake_connect();
    make(c, "a");
    fake_reject(fake_message(WIRE_BODY, 0), WIRE_NAME_TAKEN, "a");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_REJECTED);
    collided_close(c);
}

static void ignore(void *context, const collided_batch *b)
{
    (void)context;
    (void)b;
}

static collided_subscription subscribe_to(collided *c, const char *stream)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.stream = stream;
    def.callback = ignore;
    collided_subscription subscription = collided_subscribe(c, &def);
    assert_int_not_equal(subscription.id, COLLIDED_NONE);
    return subscription;
}

/* The same of the name of a stream. */
static void a_stream_that_is_being_left_is_taken_in_the_end(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    collided_subscription old = subscribe_to(c, "arm");
    fake_settle();
    fake_set((fake_options){.repeats = true, .ignored = WIRE_SUBSCRIPTION, .epoch = 1});
    assert_int_equal(collided_unsubscribe(c, old), COLLIDED_OK);
    fake_message(WIRE_SUBSCRIPTION, 1);
    (void)subscribe_to(c, "arm");
    const wire_message *heir = fake_message(WIRE_SUBSCRIPTION, 2);
    for (size_t n = 3; heir->subscription.removed; n++) heir = fake_message(WIRE_SUBSCRIPTION, n);
    fake_reject(heir, WIRE_NAME_TAKEN, "arm");
    fake_settle();
    fake_set((fake_options){.repeats = true, .epoch = 1});
    const wire_message begins = {.kind = WIRE_EVENT_BATCH,
        .event_batch = {.version = WIRE_VERSION,
            .client = collided_client_id(c),
            .subscription = heir->subscription.subscription,
            .epoch = 1,
            .batch = 1,
            .snapshot = true,
            .parts = 1,
            .stream = "arm"}};
    fake_give(&begins);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK); /* its announcement, too */
    collided_close(c);
}

/* And of the place among as many as may be. */
static void a_place_that_is_being_left_is_taken_in_the_end(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    collided_body old = make(c, "a");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    fake_set((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
    assert_int_equal(collided_remove_body(c, old), COLLIDED_OK);
    fake_message(WIRE_BODY, 1);
    make(c, "b");
    const wire_message *heir = fake_message(WIRE_BODY, 2);
    for (size_t n = 3; heir->body.removed; n++) heir = fake_message(WIRE_BODY, n);
    fake_reject(heir, WIRE_LIMIT, "max_bodies = 1 is reached");
    fake_settle();
    fake_set((fake_options){.repeats = true, .epoch = 1});
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    collided_close(c);
}

/* It came when too much came: what it takes back is there as before. */
static void a_removal_that_was_too_much_is_repeated(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_body old = make(c, "a");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    fake_set((fake_options){.ignored = WIRE_BODY, .epoch = 1});
    assert_int_equal(collided_remove_body(c, old), COLLIDED_OK);
    const wire_message *removal = fake_message(WIRE_BODY, 1);
    fake_reject(removal, WIRE_LIMIT, "max_client_messages = 10 is reached");
    for (size_t n = 2; removal->body.sequence == fake_message(WIRE_BODY, 1)->body.sequence; n++)
        removal = fake_message(WIRE_BODY, n);
    assert_int_equal(removal->body.removed, 1);
    fake_set((fake_options){.epoch = 1});
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    collided_close(c);
}

/* Of a copy that came before there was room for it, or its name was free; it was overtaken by the answer to the next.
 */
static void a_refusal_of_what_has_been_acknowledged_is_of_before(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    collided_body body = make(c, "a");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    fake_reject(fake_message(WIRE_BODY, 0), WIRE_NAME_TAKEN, "a");
    fake_settle();
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_move(c, body, at(1.0)), COLLIDED_OK);
    collided_close(c);
}

/* What is refused of a body or a subscription that is gone since, or has another word on it, is not refused any more.
 */
static void a_refusal_of_a_word_that_was_replaced_is_of_before(void **state)
{
    (void)state;
    static const wire_reason REASONS[] = {WIRE_NAME_TAKEN, WIRE_LIMIT, WIRE_UNKNOWN_GEOMETRY};
    for (size_t i = 0; i < sizeof REASONS / sizeof *REASONS; i++) {
        fake_begin((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
        collided *c = fake_connect();
        collided_body body = make(c, "a");
        const wire_message *first = fake_message(WIRE_BODY, 0);
        assert_int_equal(collided_remove_body(c, body), COLLIDED_OK);
        fake_reject(first, REASONS[i], "");
        fake_settle();
        fake_set((fake_options){.repeats = true, .epoch = 1});
        assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
        collided_close(c);
    }
}

static void reject_pose(const wire_message *pose, int32_t body)
{
    const wire_message why = {.kind = WIRE_REJECT,
        .reject = {.version = WIRE_VERSION,
            .client = pose->pose_batch.client,
            .sequence = pose->pose_batch.sequence,
            .epoch = 1,
            .kind = WIRE_POSE_BATCH,
            .object = body,
            .reason = WIRE_UNKNOWN_BODY,
            .text = ""}};
    fake_give(&why);
}

/* A body that it had: so it has lost them all, and of those that do not move nobody would ask. */
static void a_daemon_that_has_lost_one_body_is_told_of_all(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    collided_body arm = make(c, "arm");
    make(c, "table");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_move(c, arm, at(1.0)), COLLIDED_OK);
    reject_pose(fake_message(WIRE_POSE_BATCH, 0), arm.id);
    const wire_message *again = fake_message(WIRE_BODY, 2);
    for (size_t n = 3; strcmp(again->body.name, "table") != 0; n++) again = fake_message(WIRE_BODY, n);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    size_t clients = fake_sent(WIRE_CLIENT);
    reject_pose(fake_message(WIRE_POSE_BATCH, 0), arm.id); /* of before it was told */
    fake_settle();
    fake_pause(1200);
    assert_int_equal(fake_sent(WIRE_CLIENT), clients);
    collided_close(c);
}

/* They came when the body was gone, which had been told after them. */
static void poses_of_a_body_that_is_gone_are_not_missed(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    collided_body body = make(c, "a");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_move(c, body, at(1.0)), COLLIDED_OK);
    const wire_message *pose = fake_message(WIRE_POSE_BATCH, 0);
    assert_int_equal(collided_remove_body(c, body), COLLIDED_OK);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    reject_pose(pose, body.id);
    fake_settle();
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    collided_close(c);
}

static void hulls_are_announced_once_and_in_pieces(void **state)
{
    (void)state;
    enum { POINTS = 30000 };
    static double points[3 * POINTS];
    for (size_t i = 0; i < 3 * POINTS; i++) points[i] = (double)(i * 7919 % 10007);
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    collided_geometry hull = collided_create_hull(c, points, POINTS);
    assert_int_not_equal(hull.hash, 0);
    assert_int_equal(collided_create_hull(c, points, POINTS).hash, hull.hash);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(fake_sent(WIRE_GEOMETRY), 2);
    const wire_geometry *second = &fake_message(WIRE_GEOMETRY, 1)->geometry;
    assert_int_equal(second->vertices.count, 3 * POINTS - WIRE_PIECE_MAX);
    assert_true(second->vertices.at[0] == points[WIRE_PIECE_MAX]);
    points[5] = 0.0 / 0.0;
    assert_int_equal(collided_create_hull(c, points, POINTS).hash, 0);
    assert_int_equal(collided_create_hull(c, points, 3).hash, 0);
    collided_close(c);
}

/* The two hulls have one hash (tests/service/test_service_geometry.c): the second is not taken for the first. */
static void other_numbers_with_the_same_hash_are_refused(void **state)
{
    (void)state;
    const double one[12] = {-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0x1.e5ceed43p+0, 0x1.36e7a321p+0};
    const double other[12] = {-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0x1.8e2a310fp+0, 0x1.53a20b52p+0};
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    assert_int_not_equal(collided_create_hull(c, one, 4).hash, 0);
    assert_int_equal(collided_create_hull(c, other, 4).hash, 0);
    assert_non_null(strstr(collided_error(c), "the same hash"));
    collided_close(c);
}

static void height_fields_are_announced_whole(void **state)
{
    (void)state;
    enum { ROWS = 260, COLUMNS = 270 };
    static double heights[ROWS * COLUMNS];
    for (size_t i = 0; i < ROWS * COLUMNS; i++) heights[i] = (double)(i * 7919 % 10007);
    fake_begin((fake_options){.repeats = true, .epoch = 1});
    collided *c = fake_connect();
    collided_geometry ground = collided_create_height_field(c, heights, ROWS, COLUMNS, 0.5, 0.25, 2);
    assert_int_not_equal(ground.hash, 0);
    assert_int_equal(collided_create_height_field(c, heights, ROWS, COLUMNS, 0.5, 0.25, 2).hash, ground.hash);
    assert_int_not_equal(collided_create_height_field(c, heights, COLUMNS, ROWS, 0.5, 0.25, 2).hash, ground.hash);
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(fake_sent(WIRE_GEOMETRY), 4);
    const wire_geometry *first = &fake_message(WIRE_GEOMETRY, 0)->geometry,
                        *second = &fake_message(WIRE_GEOMETRY, 1)->geometry;
    assert_int_equal(first->kind, WIRE_GEOMETRY_HEIGHT_FIELD);
    assert_int_equal(first->vertex_numbers, WIRE_FIELD_HEAD + ROWS * COLUMNS);
    assert_true(first->vertices.at[0] == 0.5 && first->vertices.at[1] == 0.25 && first->vertices.at[2] == 2);
    assert_true(first->vertices.at[WIRE_FIELD_HEAD + 7] == heights[7]);
    assert_true(second->vertices.at[0] == heights[WIRE_PIECE_MAX - WIRE_FIELD_HEAD]);
    assert_true(second->indices.count == 2 && second->indices.at[0] == COLUMNS && second->indices.at[1] == ROWS);
    assert_int_equal(collided_create_height_field(c, heights, 1, COLUMNS, 1, 1, 1).hash, 0);
    assert_int_equal(collided_create_height_field(c, heights, ROWS, 1, 1, 1, 1).hash, 0);
    assert_int_equal(collided_create_height_field(c, heights, SIZE_MAX, SIZE_MAX, 1, 1, 1).hash, 0);
    assert_int_equal(collided_create_height_field(c, NULL, 2, 2, 1, 1, 1).hash, 0);
    assert_int_equal(collided_create_height_field(c, heights, 2, 2, 0, 1, 1).hash, 0);
    assert_non_null(strstr(collided_error(c), "spacing x of a height field"));
    assert_int_equal(collided_create_height_field(c, heights, 2, 2, 1, 1, -1).hash, 0);
    heights[3] = 0.0 / 0.0;
    assert_int_equal(collided_create_height_field(c, heights, 2, 2, 1, 1, 1).hash, 0);
    collided_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(connecting_without_a_daemon_fails_and_says_so),
        cmocka_unit_test(unacknowledged_announcements_are_repeated_with_growing_pauses),
        cmocka_unit_test(a_transport_that_keeps_announcements_repeats_what_is_not_answered),
        cmocka_unit_test(heartbeats_come_three_times_a_lease),
        cmocka_unit_test(heartbeats_that_were_not_answered_for_a_lease_have_all_announced_again),
        cmocka_unit_test(a_restarted_daemon_is_told_everything_again_in_order),
        cmocka_unit_test(a_transport_that_keeps_sends_only_the_newer_pose_to_a_new_daemon),
        cmocka_unit_test(an_older_daemon_is_not_followed_while_ours_speaks),
        cmocka_unit_test(a_daemon_that_ends_is_left_at_once_and_followed_no_more),
        cmocka_unit_test(a_daemon_that_has_ended_is_not_followed_by_who_comes_later),
        cmocka_unit_test(refusals_are_told_and_end_the_wait),
        cmocka_unit_test(too_many_refusals_are_counted),
        cmocka_unit_test(a_daemon_that_lost_us_is_told_again),
        cmocka_unit_test(a_daemon_that_lost_us_twice_is_told_twice),
        cmocka_unit_test(an_ack_beyond_our_own_makes_us_count_on_from_there),
        cmocka_unit_test(what_came_before_what_it_needs_is_announced_again),
        cmocka_unit_test(leaving_removes_bodies_before_the_client),
        cmocka_unit_test(leaving_keeps_what_was_to_be_kept),
        cmocka_unit_test(a_shape_s_deviation_is_announced),
        cmocka_unit_test(a_name_that_is_being_left_is_taken_in_the_end),
        cmocka_unit_test(a_name_that_another_one_has_is_refused),
        cmocka_unit_test(a_stream_that_is_being_left_is_taken_in_the_end),
        cmocka_unit_test(a_place_that_is_being_left_is_taken_in_the_end),
        cmocka_unit_test(a_removal_that_was_too_much_is_repeated),
        cmocka_unit_test(a_refusal_of_what_has_been_acknowledged_is_of_before),
        cmocka_unit_test(a_refusal_of_a_word_that_was_replaced_is_of_before),
        cmocka_unit_test(a_daemon_that_has_lost_one_body_is_told_of_all),
        cmocka_unit_test(poses_of_a_body_that_is_gone_are_not_missed),
        cmocka_unit_test(hulls_are_announced_once_and_in_pieces),
        cmocka_unit_test(other_numbers_with_the_same_hash_are_refused),
        cmocka_unit_test(height_fields_are_announced_whole),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    fake_begin((fake_options){0});
    return failed;
}
