/* What comes of messages that a network lost, delayed, brought twice or in another order. */
#include "cell.h"

#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

enum { ALICE = 11, BOB = 22, CAROL = 33 };

typedef struct room {
    cell *cell;
    memory_end *end; /* hears all that the link sends, and speaks for all clients */
    wire_memory *memory;
    int64_t sequence;
} room;

static room here; /* of the test that runs */

static room *enter(const config *c)
{
    here = (room){.cell = cell_start(c), .memory = wire_memory_create(), .sequence = 100};
    here.end = cell_client(here.cell);
    return &here;
}

static int leave(void **state)
{
    (void)state;
    memory_disconnect(here.end);
    int status = cell_stop(here.cell);
    wire_memory_destroy(here.memory);
    return status;
}

static void settle(room *r)
{
    cell_settle(r->end, r->memory, BOB, ++r->sequence);
}

static int64_t counter(room *r, const char *name)
{
    settle(r);
    cell_await(r->end, r->memory, WIRE_STATUS);
    wire_message m = cell_await(r->end, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

static void say_goodbye(room *r, int64_t client, int64_t sequence)
{
    memory_send(r->end, &(wire_message){.kind = WIRE_CLIENT,
                            .client = {.version = WIRE_VERSION,
                                .client = client,
                                .sequence = sequence,
                                .removed = 1,
                                .lease_ns = 1000000000,
                                .name = ""}});
}

static void unsubscribe(room *r, int64_t client, int64_t sequence, int32_t subscription)
{
    memory_send(r->end, &(wire_message){.kind = WIRE_SUBSCRIPTION,
                            .subscription = {.version = WIRE_VERSION,
                                .client = client,
                                .sequence = sequence,
                                .subscription = subscription,
                                .removed = 1,
                                .stream = "",
                                .select_a = "",
                                .select_b = ""}});
}

static void remove_body(room *r, int64_t client, int64_t sequence, int32_t body)
{
    memory_send(r->end, &(wire_message){.kind = WIRE_BODY,
                            .body = {.version = WIRE_VERSION,
                                .client = client,
                                .sequence = sequence,
                                .body = body,
                                .removed = 1,
                                .name = "",
                                .group = ""}});
}

/* ---- what is over stays over ---- */

static void an_subscription_that_its_removal_has_overtaken_does_not_begin(void **state)
{
    (void)state;
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
    unsubscribe(r, ALICE, 3, 0);
    settle(r);
    cell_touches(r->end, ALICE, 2, 0);
    assert_int_equal(counter(r, "subscriptions"), 0);
    cell_touches(r->end, ALICE, 4, 0); /* a newer word is one */
    assert_int_equal(counter(r, "subscriptions"), 1);
    unsubscribe(r, ALICE, 6, 0);
    settle(r);
    unsubscribe(r, ALICE, 8, 0); /* once more */
    settle(r);
    cell_touches(r->end, ALICE, 7, 0);
    assert_int_equal(counter(r, "subscriptions"), 0);
}

/* Its bodies stay, and so would that subscription, with nobody who could end it. */
static void late_words_on_subscriptions_begin_nothing(bool leaves)
{
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, leaves ? 60 : 0.1, WIRE_LOST_KEEP);
    cell_sphere(r->end, ALICE, 2, 0, "a", 0);
    cell_touches(r->end, ALICE, 3, 0);
    if (leaves) assert_int_equal(counter(r, "subscriptions"), 1);
    if (leaves) say_goodbye(r, ALICE, 9);
    while (counter(r, "subscriptions") != 0 || counter(r, "lost_clients") == (leaves != 0)) continue;
    cell_touches(r->end, ALICE, 3, 0);
    if (leaves) cell_touches(r->end, ALICE, 4, 1); /* which has been long on its way */
    assert_int_equal(counter(r, "subscriptions"), 0);
    cell_hello(r->end, ALICE, 11, 60, WIRE_LOST_KEEP);
    cell_touches(r->end, ALICE, 12, 0);
    assert_int_equal(counter(r, "subscriptions"), 1);
}

static void subscriptions_of_a_client_that_left_bodies_behind_do_not_come_back(void **state)
{
    (void)state;
    late_words_on_subscriptions_begin_nothing(true);
}

static void subscriptions_of_a_lost_client_do_not_come_back(void **state)
{
    (void)state;
    late_words_on_subscriptions_begin_nothing(false);
}

/* It comes when the next process under that id has said something already, and not yet who it is. */
static void a_goodbye_does_not_end_what_the_next_process_has_begun(void **state)
{
    (void)state;
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
    cell_sphere(r->end, ALICE, 2, 0, "a", 0);
    settle(r);
    cell_sphere(r->end, ALICE, 51, 0, "a", 5); /* of the next one */
    settle(r);
    say_goodbye(r, ALICE, 9);
    settle(r);
    cell_hello(r->end, ALICE, 50, 60, WIRE_LOST_REMOVE);
    assert_int_equal(counter(r, "bodies"), 1);
    say_goodbye(r, ALICE, 60);
    assert_int_equal(counter(r, "bodies"), 0);
}

/* Nor does it leave behind what the process that says it had, when the next one has come first. */
static void a_late_goodbye_ends_what_was_before_it(void **state)
{
    (void)state;
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
    cell_sphere(r->end, ALICE, 2, 0, "a", 0);
    cell_sphere(r->end, ALICE, 3, 1, "b", 5);
    cell_sphere(r->end, ALICE, 4, 2, "c", 10);
    cell_touches(r->end, ALICE, 5, 0);
    cell_touches(r->end, ALICE, 6, 1);
    settle(r);
    cell_hello(r->end, ALICE, 50, 60, WIRE_LOST_REMOVE);
    cell_sphere(r->end, ALICE, 51, 0, "a", 0);
    cell_touches(r->end, ALICE, 52, 0);
    cell_pose(r->end, ALICE, 53, 2, 11); /* which it has adopted */
    settle(r);
    say_goodbye(r, ALICE, 9);
    assert_int_equal(counter(r, "bodies"), 2);
    assert_int_equal(counter(r, "subscriptions"), 1);
}

/* The next process under that id would keep alive what they begin. */
static void copies_of_a_process_that_left_begin_nothing(void **state)
{
    (void)state;
    for (int back = 0; back < 2; back++) {
        config c = cell_config();
        room *r = enter(&c);
        cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
        cell_sphere(r->end, ALICE, 2, 0, "a", 0);
        cell_touches(r->end, ALICE, 3, 0);
        settle(r);
        say_goodbye(r, ALICE, 9);
        if (back) cell_hello(r->end, ALICE, 50, 60, WIRE_LOST_REMOVE);
        settle(r);
        cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
        cell_sphere(r->end, ALICE, 2, 0, "a", 0);
        cell_touches(r->end, ALICE, 3, 0);
        settle(r);
        if (!back) cell_hello(r->end, ALICE, 50, 60, WIRE_LOST_REMOVE);
        assert_int_equal(counter(r, "bodies"), 0);
        assert_int_equal(counter(r, "subscriptions"), 0);
        assert_int_equal(counter(r, "clients"), 1);
        if (!back) assert_int_equal(leave(NULL), 0);
    }
}

/* The acknowledgements of what came with the goodbye went with the session: who asks again is told that it is done. */
static void removals_of_a_process_that_left_are_done(void **state)
{
    (void)state;
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
    cell_sphere(r->end, ALICE, 2, 0, "a", 0);
    cell_touches(r->end, ALICE, 3, 0);
    settle(r);
    say_goodbye(r, ALICE, 9);
    settle(r);
    remove_body(r, ALICE, 7, 0);
    wire_message m = cell_await(r->end, r->memory, WIRE_ACK);
    assert_int_equal(m.ack.sequences.at[0], 7);
    unsubscribe(r, ALICE, 8, 0);
    m = cell_await(r->end, r->memory, WIRE_ACK);
    assert_int_equal(m.ack.sequences.at[0], 8);
    assert_int_equal(counter(r, "clients"), 0);
}

/* Its clock was set back: it is told how far the one before has counted, and goes on from there. */
static void a_process_that_begins_below_a_goodbye_is_told_so(void **state)
{
    (void)state;
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1000, 60, WIRE_LOST_REMOVE);
    say_goodbye(r, ALICE, 1001);
    settle(r);
    cell_hello(r->end, ALICE, 5, 60, WIRE_LOST_REMOVE);
    wire_message m = cell_await(r->end, r->memory, WIRE_ACK);
    assert_int_equal(m.ack.client, ALICE);
    assert_int_equal(m.ack.sequences.at[0], 1001);
    cell_hello(r->end, ALICE, 1002, 60, WIRE_LOST_REMOVE);
    assert_int_equal(counter(r, "clients"), 1);
}

/* Over DDS who knows a client by its keys alone numbers its end by the time. */
static void a_goodbye_by_the_time_is_not_held_against_who_comes_back(void **state)
{
    (void)state;
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
    say_goodbye(r, ALICE, INT64_C(1700000000000000));
    settle(r);
    cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
    assert_int_equal(counter(r, "clients"), 1);
}

static void a_lost_client_that_leaves_is_gone(void **state)
{
    (void)state;
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, 0.1, WIRE_LOST_HOLD);
    cell_sphere(r->end, ALICE, 2, 0, "a", 0);
    while (counter(r, "lost_clients") == 0) continue;
    say_goodbye(r, ALICE, 9);
    assert_int_equal(counter(r, "bodies"), 0);
    assert_int_equal(counter(r, "clients"), 0);
}

/* It was not told of its loss, the network was down: what it says of one body, whose pose was refused, does not show
 * that it knows. */
static void who_was_lost_is_told_although_it_says_something(void **state)
{
    (void)state;
    config c = cell_config();
    room *r = enter(&c);
    wire_message m;
    cell_hello(r->end, ALICE, 1, 0.1, WIRE_LOST_REMOVE);
    cell_sphere(r->end, ALICE, 2, 0, "arm", 0);
    cell_sphere(r->end, ALICE, 3, 1, "table", 5);
    int64_t sequence = 10;
    for (int times = 0; times < 2; times++) { /* is lost, and comes back with an arm */
        assert_true(cell_next(r->end, r->memory, WIRE_REJECT, 30000, &m));
        cell_hello(r->end, ALICE, ++sequence, times ? 60 : 0.1, WIRE_LOST_REMOVE);
        settle(r);
        cell_sphere(r->end, ALICE, ++sequence, 0, "arm", 0);
        settle(r);
    }
    cell_hello(r->end, ALICE, ++sequence, 60, WIRE_LOST_REMOVE);
    assert_true(cell_next(r->end, r->memory, WIRE_REJECT, 3000, &m));
    assert_int_equal(m.reject.reason, WIRE_UNKNOWN_CLIENT);
    cell_sphere(r->end, ALICE, ++sequence, 0, "arm", 0); /* now it knows */
    cell_sphere(r->end, ALICE, ++sequence, 1, "table", 5);
    for (int k = 0; k < 3; k++) cell_hello(r->end, ALICE, ++sequence, 60, WIRE_LOST_REMOVE);
    assert_false(cell_hears(r->end, r->memory, WIRE_REJECT, 100));
}

/* ---- what is refused is not done ---- */

static void a_refusal_that_is_not_told_is_not_acknowledged_either(void **state)
{
    (void)state;
    enum { MANY = 150 };
    config c = cell_config();
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_REMOVE);
    cell_sphere(r->end, ALICE, 2, 0, "a", 0);
    settle(r);
    bool refused[MANY] = {false}, acknowledged[MANY] = {false};
    for (int32_t i = 0; i < MANY; i++) cell_sphere(r->end, ALICE, 1000 + i, 1 + i, "a", 0);
    memory_send(r->end, &(wire_message){.kind = WIRE_QUERY,
                            .query = {.version = WIRE_VERSION,
                                .client = BOB,
                                .sequence = ++r->sequence,
                                .kind = WIRE_QUERY_BODIES,
                                .name_a = "*",
                                .name_b = ""}});
    wire_message m = {.kind = WIRE_NOTHING};
    while (m.kind != WIRE_ANSWER) {
        wire_memory_reset(r->memory);
        if (!memory_receive(r->end, r->memory, &m)) continue;
        if (m.kind == WIRE_REJECT && m.reject.sequence >= 1000) refused[m.reject.sequence - 1000] = true;
        for (uint32_t i = 0; m.kind == WIRE_ACK && i < m.ack.sequences.count; i++)
            if (m.ack.sequences.at[i] >= 1000) acknowledged[m.ack.sequences.at[i] - 1000] = true;
    }
    int told = 0;
    for (int i = 0; i < MANY; i++) {
        told += refused[i];
        if (acknowledged[i] && !refused[i]) fail_msg("number %d was refused, and heard that it is done", i);
    }
    assert_true(told >= 100);
}

/* ---- the same in a recording that begins in the middle ---- */

static uint8_t ask_to_record(room *r, const char *name, int64_t sequence)
{
    memory_send(r->end, &(wire_message){.kind = WIRE_QUERY,
                            .query = {.version = WIRE_VERSION,
                                .client = BOB,
                                .sequence = sequence,
                                .kind = WIRE_QUERY_RECORD,
                                .name_a = name,
                                .name_b = ""}});
    wire_message m;
    do {
        m = cell_await(r->end, r->memory, WIRE_ANSWER);
    } while (m.answer.sequence != sequence);
    return m.answer.status;
}

/* Nothing has touched before: so the hashes are those of the live session. */
static void late_words_change_nothing_in_a_replay(void **state)
{
    (void)state;
    char folder[] = "/tmp/collided-order-XXXXXX", path[sizeof folder + 16];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    room *r = enter(&c);
    cell_hello(r->end, ALICE, 1, 60, WIRE_LOST_KEEP);
    cell_sphere(r->end, ALICE, 2, 0, "a", 0);
    cell_sphere(r->end, ALICE, 3, 1, "b", 5);
    cell_touches(r->end, ALICE, 4, 0);
    settle(r);
    remove_body(r, ALICE, 5, 1);
    unsubscribe(r, ALICE, 6, 0);
    settle(r);
    say_goodbye(r, ALICE, 9);
    cell_hello(r->end, CAROL, 1, 60, WIRE_LOST_REMOVE);
    cell_sphere(r->end, CAROL, 2, 0, "d", 0.2);
    settle(r);
    say_goodbye(r, CAROL, 3);
    cell_hello(r->end, BOB, ++r->sequence, 60, WIRE_LOST_REMOVE);
    cell_sphere(r->end, BOB, ++r->sequence, 0, "c", 5.5);
    int64_t late = ++r->sequence;
    cell_pose(r->end, BOB, ++r->sequence, 0, 6);
    settle(r);
    assert_int_equal(ask_to_record(r, "middle", ++r->sequence), WIRE_ANSWER_OK);
    cell_sphere(r->end, ALICE, 3, 1, "b", 5);
    cell_touches(r->end, ALICE, 4, 0);
    cell_touches(r->end, ALICE, 7, 1);
    cell_sphere(r->end, CAROL, 2, 0, "d", 0.2);
    cell_touches(r->end, BOB, ++r->sequence, 0);
    cell_pose(r->end, BOB, late, 0, 0.1);
    settle(r);
    cell_pose(r->end, BOB, ++r->sequence, 0, 0.3);
    assert_int_equal(counter(r, "bodies"), 2);
    assert_int_equal(counter(r, "subscriptions"), 1);
    assert_int_equal(ask_to_record(r, "", ++r->sequence), WIRE_ANSWER_OK);
    assert_int_equal(leave(NULL), 0);
    assert_int_equal(cell_replay(path, 1, true), EX_OK);
    assert_int_equal(unlink(path) | rmdir(folder), 0);
}

/* Its answer may be lost: the client asks again, under the same sequence. */
static void a_recording_begins_and_ends_once(void **state)
{
    (void)state;
    char folder[] = "/tmp/collided-order-XXXXXX", first[sizeof folder + 16], second[sizeof folder + 16];
    assert_non_null(mkdtemp(folder));
    snprintf(first, sizeof first, "%s/first.lcmlog", folder);
    snprintf(second, sizeof second, "%s/second.lcmlog", folder);
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    room *r = enter(&c);
    for (int copy = 0; copy < 2; copy++) assert_int_equal(ask_to_record(r, "first", 1000), WIRE_ANSWER_OK);
    assert_int_equal(ask_to_record(r, "second", 1001), WIRE_ANSWER_UNSUPPORTED);
    for (int copy = 0; copy < 2; copy++) assert_int_equal(ask_to_record(r, "", 1002), WIRE_ANSWER_OK);
    assert_int_equal(ask_to_record(r, "second", 1003), WIRE_ANSWER_OK);
    assert_int_equal(ask_to_record(r, "", 1002), WIRE_ANSWER_UNSUPPORTED); /* late */
    assert_int_equal(ask_to_record(r, "", 1004), WIRE_ANSWER_OK);
    assert_int_equal(ask_to_record(r, "", 1005), WIRE_ANSWER_UNSUPPORTED);
    assert_int_equal(unlink(first) | unlink(second) | rmdir(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(an_subscription_that_its_removal_has_overtaken_does_not_begin, leave),
        cmocka_unit_test_teardown(subscriptions_of_a_client_that_left_bodies_behind_do_not_come_back, leave),
        cmocka_unit_test_teardown(subscriptions_of_a_lost_client_do_not_come_back, leave),
        cmocka_unit_test_teardown(a_goodbye_does_not_end_what_the_next_process_has_begun, leave),
        cmocka_unit_test_teardown(a_late_goodbye_ends_what_was_before_it, leave),
        cmocka_unit_test_teardown(copies_of_a_process_that_left_begin_nothing, leave),
        cmocka_unit_test_teardown(removals_of_a_process_that_left_are_done, leave),
        cmocka_unit_test_teardown(a_process_that_begins_below_a_goodbye_is_told_so, leave),
        cmocka_unit_test_teardown(a_goodbye_by_the_time_is_not_held_against_who_comes_back, leave),
        cmocka_unit_test_teardown(a_lost_client_that_leaves_is_gone, leave),
        cmocka_unit_test_teardown(who_was_lost_is_told_although_it_says_something, leave),
        cmocka_unit_test_teardown(a_refusal_that_is_not_told_is_not_acknowledged_either, leave),
        cmocka_unit_test(late_words_change_nothing_in_a_replay),
        cmocka_unit_test_teardown(a_recording_begins_and_ends_once, leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
