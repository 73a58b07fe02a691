/* The link within a process: what goes in comes out unchanged, or is refused with a reason. */
#include "harness.h"
#include "link/link_open.h"

#include "link/link_memory.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

static void each_kind_passes_unchanged(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, "memory://cell", NULL);
    memory_end *e = memory_connect("cell");
    for (wire_kind k = WIRE_CLIENT; k <= WIRE_QUERY; k++) {
        wire_message m = sample_message(k);
        memory_send(e, &m);
    }
    rig_receive(&r);
    for (wire_kind k = WIRE_CLIENT; k <= WIRE_QUERY; k++) assert_int_equal(r.heard.messages[k], 1);
    assert_int_equal(r.heard.differing, 0);
    assert_int_equal(r.heard.refused, 0);

    wire_memory *memory = wire_memory_create();
    for (wire_kind k = WIRE_ANSWER; k < WIRE_KIND_COUNT; k++) {
        wire_message m = sample_message(k), back;
        rig_publish(&r, &m);
        assert_true(memory_receive(e, memory, &back));
        assert_true(same_message(&m, &back));
    }
    wire_memory_destroy(memory);
    memory_disconnect(e);
    rig_close(&r);
}

static void each_end_gets_what_is_published(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, "memory://cell", NULL);
    memory_end *a = memory_connect("cell"), *b = memory_connect("cell"), *gone = memory_connect("cell");
    memory_disconnect(gone);
    wire_message m = sample_message(WIRE_STATUS), back;
    wire_memory *memory = wire_memory_create();
    rig_publish(&r, &m);
    assert_true(memory_receive(a, memory, &back));
    assert_true(memory_receive(b, memory, &back));
    assert_false(memory_receive(b, memory, &back));
    rig_close(&r);
    memory_send(a, &m); /* to nobody: the link is closed */
    assert_false(memory_receive(a, memory, &back));
    memory_disconnect(a);
    memory_disconnect(b);
    wire_memory_destroy(memory);
}

static void bad_bytes_are_refused_with_a_reason(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, "memory://cell", NULL);
    memory_end *e = memory_connect("cell");

    memory_send_bytes(e, "nonsense", 8);
    rig_receive(&r);
    assert_int_equal(r.heard.refused, 1);
    assert_int_equal(r.heard.refused_kind, WIRE_NOTHING);

    wire_message bad = sample_poses(1, 3);
    double positions[3] = {0, NAN, 0};
    bad.pose_batch.positions.at = positions;
    memory_send(e, &bad);
    rig_receive(&r);
    assert_int_equal(r.heard.refused, 2);
    assert_int_equal(r.heard.refused_kind, WIRE_POSE_BATCH);
    assert_int_equal(r.heard.why.reason, WIRE_BAD_NUMBER);
    assert_int_equal(r.heard.refused_client, CLIENT_ID);
    assert_int_equal(r.heard.refused_sequence, 3);
    assert_true(r.heard.why.text[0] != '\0');

    assert_int_equal(rig_counter(&r, "memory_refused"), 2);
    memory_disconnect(e);
    rig_close(&r);
}

static void what_only_the_daemon_says_is_refused(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, "memory://cell", NULL);
    memory_end *e = memory_connect("cell");
    for (wire_kind k = WIRE_ANSWER; k < WIRE_KIND_COUNT; k++) {
        wire_message m = sample_message(k);
        memory_send(e, &m);
    }
    rig_receive(&r);
    assert_int_equal(r.heard.refused, WIRE_KIND_COUNT - WIRE_ANSWER);
    assert_int_equal(r.heard.why.reason, WIRE_MALFORMED);
    memory_disconnect(e);
    rig_close(&r);
}

/* Oracle: an unharmed message equals the one sent; a harmed one may be refused or differ, but nothing else happens. */
static void harmed_bytes_never_do_more_than_be_refused(void **state)
{
    (void)state;
    enum { ROUNDS = 3000 };
    rig r;
    rig_open(&r, "memory://cell", NULL);
    memory_end *e = memory_connect("cell");
    uint64_t seed = 42;
    for (int round = 0; round < ROUNDS; round++) {
        wire_message m = sample_message((wire_kind)(WIRE_CLIENT + round % WIRE_QUERY));
        size_t size = wire_lcm_size(&m);
        uint8_t *bytes = malloc(size);
        wire_lcm_encode(&m, bytes, size);
        for (int harm = 0; harm < 3; harm++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            bytes[(seed >> 33) % size] = (uint8_t)(seed >> 56);
        }
        memory_send_bytes(e, bytes, size - (seed >> 40) % 2);
        free(bytes);
        rig_receive(&r);
    }
    size_t messages = 0;
    for (wire_kind k = WIRE_CLIENT; k < WIRE_KIND_COUNT; k++) messages += r.heard.messages[k];
    assert_int_equal(messages + r.heard.refused, ROUNDS);
    assert_true(r.heard.refused > ROUNDS / 2);
    memory_disconnect(e);
    rig_close(&r);
}

static void the_tick_thread_is_woken_once_until_it_receives(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, "memory://cell", NULL);
    memory_end *e = memory_connect("cell");
    wire_message m = sample_message(WIRE_CLIENT);
    assert_false(rig_is_woken(&r, 0));
    memory_send(e, &m);
    assert_true(rig_is_woken(&r, 0));
    memory_send(e, &m);
    assert_false(rig_is_woken(&r, 0));
    rig_receive(&r);
    assert_int_equal(r.heard.messages[WIRE_CLIENT], 2);
    memory_send(e, &m);
    assert_true(rig_is_woken(&r, 0));
    memory_disconnect(e);
    rig_close(&r);
}

static void an_opened_stream_is_told_of_once(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, "memory://cell", NULL);
    r.link->ops->stream_open(r.link, "cell", 1);
    assert_true(rig_is_woken(&r, 0));
    rig_receive(&r);
    rig_receive(&r);
    assert_int_equal(r.heard.readers, 1);
    assert_string_equal(r.heard.reader, "cell");
    r.link->ops->stream_close(r.link, "cell");
    rig_close(&r);
}

static void full_queues_drop_and_count(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, "memory://cell", NULL);
    memory_end *e = memory_connect("cell");
    wire_message poses = sample_poses(1000, 1), events = sample_events("cell", 1);
    size_t fit = (32u << 20) / (wire_lcm_size(&poses) + 6);
    for (size_t i = 0; i < fit + 3; i++) memory_send(e, &poses);
    assert_int_equal(rig_counter(&r, "memory_queue_full"), 3);
    rig_receive(&r);
    assert_int_equal(r.heard.messages[WIRE_POSE_BATCH], fit);
    fit = (32u << 20) / (wire_lcm_size(&events) + 6);
    for (size_t i = 0; i < fit + 5; i++) rig_publish(&r, &events);
    assert_int_equal(rig_counter(&r, "memory_out_dropped"), 5);
    memory_disconnect(e);
    rig_close(&r);
}

static void *send_many(void *context)
{
    memory_end *e = memory_connect(context);
    for (int64_t i = 1; i <= 1000; i++) {
        wire_message m = sample_message(WIRE_CLIENT);
        m.client.sequence = i;
        memory_send(e, &m);
    }
    memory_disconnect(e);
    return NULL;
}

static void ends_may_be_used_by_other_threads(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, "memory://cell", NULL);
    pthread_t threads[2];
    for (int i = 0; i < 2; i++) pthread_create(&threads[i], NULL, send_many, "cell");
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.messages[WIRE_CLIENT] == 2000);
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    rig_close(&r);
}

static void an_address_that_cannot_be_is_refused_with_the_reason(void **state)
{
    (void)state;
    char why[256];
    rig r;
    rig_open(&r, "memory://cell", NULL);
    assert_null(link_open("memory://cell", &r.link->options, why, sizeof why));
    assert_non_null(strstr(why, "open already"));
    assert_null(link_open("carrier-pigeon://cell", &r.link->options, why, sizeof why));
    assert_non_null(strstr(why, "unknown transport"));
    assert_null(memory_connect("elsewhere"));
    rig_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_kind_passes_unchanged),
        cmocka_unit_test(each_end_gets_what_is_published),
        cmocka_unit_test(bad_bytes_are_refused_with_a_reason),
        cmocka_unit_test(what_only_the_daemon_says_is_refused),
        cmocka_unit_test(harmed_bytes_never_do_more_than_be_refused),
        cmocka_unit_test(the_tick_thread_is_woken_once_until_it_receives),
        cmocka_unit_test(an_opened_stream_is_told_of_once),
        cmocka_unit_test(full_queues_drop_and_count),
        cmocka_unit_test(ends_may_be_used_by_other_threads),
        cmocka_unit_test(an_address_that_cannot_be_is_refused_with_the_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
