/* How recordings end that nobody ends, and how one begins in a large world: a limit is named, what is there replays,
 * and no tick waits. */
#include "cell.h"

#include "service/server.h"
#include "service/service.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <time.h>
#include <unistd.h>

enum { ALICE = 11, BOB = 12, MANY = 6000 };

static char folder[] = "/tmp/collided-ends-XXXXXX";
static int64_t sequence;

static wire_answer wish(memory_end *e, wire_memory *memory, int64_t client, const char *name)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++sequence,
            .kind = WIRE_QUERY_RECORD,
            .name_a = name,
            .name_b = ""}};
    memory_send(e, &q);
    return cell_await(e, memory, WIRE_ANSWER).answer;
}

static void announce(memory_end *e, int count)
{
    cell_hello(e, ALICE, ++sequence, 60, WIRE_LOST_REMOVE);
    for (int i = 0; i < count; i++) {
        char name[16];
        snprintf(name, sizeof name, "ball%d", i);
        cell_sphere(e, ALICE, ++sequence, i, name, 1.5 * i);
    }
    cell_touches(e, ALICE, ++sequence, 0);
}

static config recording_config(void)
{
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    c.record_keep_free = 0;
    return c;
}

static int replay_and_remove(const char *name)
{
    char path[sizeof folder + 64];
    snprintf(path, sizeof path, "%s/%s.lcmlog", folder, name);
    int status = cell_replay(path, 1, true);
    assert_int_equal(unlink(path), 0);
    return status;
}

/* A Status whose limits name that option. */
static void await_limit(memory_end *e, wire_memory *memory, const char *option, int64_t failures)
{
    for (int tries = 0; tries < 600; tries++) {
        wire_status s = cell_await(e, memory, WIRE_STATUS).status;
        if (!strstr(s.limits, option)) continue;
        assert_int_equal(s.health, WIRE_HEALTH_DEGRADED);
        assert_int_equal(cell_counter(&s, "record_failures"), failures);
        return;
    }
    fail_msg("Status names no %s", option);
}

static void a_recording_that_is_too_large_ends_behind_a_tick(void **state)
{
    (void)state;
    config c = recording_config();
    c.record_max_size = 1;
    cell *daemon = cell_start(&c);
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    announce(e, 50);
    assert_int_equal(wish(e, memory, ALICE, "large").status, WIRE_ANSWER_OK);
    for (int i = 0; i < 8000; i++) {
        cell_pose(e, ALICE, ++sequence, i % 50, 1.5 * (i % 50) + 0.6 * sin(i));
        if (i % 20 == 0) cell_settle(e, memory, ALICE, ++sequence);
    }
    await_limit(e, memory, "record_max_size", 1);
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(cell_stop(daemon), 0);
    assert_int_equal(replay_and_remove("large"), EX_OK);
}

static void a_recording_that_a_client_began_ends_in_time(void **state)
{
    (void)state;
    config c = recording_config();
    c.record_max_time = 0.3;
    cell *daemon = cell_start(&c);
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    announce(e, 3);
    assert_int_equal(wish(e, memory, ALICE, "long").status, WIRE_ANSWER_OK);
    assert_int_equal(wish(e, memory, BOB, "").status, WIRE_ANSWER_UNSUPPORTED);
    await_limit(e, memory, "record_max_time", 0);
    assert_int_equal(wish(e, memory, BOB, "").status, WIRE_ANSWER_UNSUPPORTED); /* there is none any more */
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(cell_stop(daemon), 0);
    assert_int_equal(replay_and_remove("long"), EX_OK);
}

static void only_so_many_are_begun_and_only_where_there_is_room(void **state)
{
    (void)state;
    config c = recording_config();
    c.record_max_files = 1;
    cell *daemon = cell_start(&c);
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    announce(e, 3);
    assert_int_equal(wish(e, memory, ALICE, "first").status, WIRE_ANSWER_OK);
    cell_settle(e, memory, ALICE, ++sequence);
    assert_int_equal(wish(e, memory, ALICE, "").status, WIRE_ANSWER_OK);
    wire_answer a = wish(e, memory, ALICE, "second");
    assert_int_equal(a.status, WIRE_ANSWER_UNSUPPORTED);
    assert_non_null(strstr(a.text, "record_max_files"));
    assert_int_equal(wish(e, memory, ALICE, "..").status, WIRE_ANSWER_UNSUPPORTED);
    assert_int_equal(wish(e, memory, ALICE, "a/b").status, WIRE_ANSWER_UNSUPPORTED);
    memory_disconnect(e);
    assert_int_equal(cell_stop(daemon), 0);
    assert_int_equal(replay_and_remove("first"), EX_OK);
    c.record_keep_free = 100;
    daemon = cell_start(&c);
    e = cell_client(daemon);
    a = wish(e, memory, ALICE, "third");
    assert_int_equal(a.status, WIRE_ANSWER_UNSUPPORTED);
    assert_non_null(strstr(a.text, "record_keep_free"));
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(cell_stop(daemon), 0);
}

/* Its state is larger than what is written within the tick of the query. */
static void a_large_world_is_recorded_from_its_middle(void **state)
{
    (void)state;
    config c = recording_config();
    c.max_client_messages = 100000000;
    cell *daemon = cell_start(&c);
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    announce(e, MANY);
    cell_settle(e, memory, ALICE, ++sequence);
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < MANY; i += 3) cell_pose(e, ALICE, ++sequence, i, 1.5 * i + 0.7 * (1 - round));
        if (round == 0) assert_int_equal(wish(e, memory, ALICE, "middle").status, WIRE_ANSWER_OK);
        cell_settle(e, memory, ALICE, ++sequence);
    }
    assert_int_equal(wish(e, memory, ALICE, "").status, WIRE_ANSWER_OK);
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(replay_and_remove("middle"), EX_OK); /* whole, although the daemon still runs */
    assert_int_equal(cell_stop(daemon), 0);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_recording_that_is_too_large_ends_behind_a_tick),
        cmocka_unit_test(a_recording_that_a_client_began_ends_in_time),
        cmocka_unit_test(only_so_many_are_begun_and_only_where_there_is_room),
        cmocka_unit_test(a_large_world_is_recorded_from_its_middle),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
