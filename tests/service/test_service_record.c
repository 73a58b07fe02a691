/* What is recorded replays: the same hash for 1, 2 and 4 workers, with caches and without, from the start of a session
 * and from its middle. */
#include "cell.h"

#include "service/server.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

enum { ALICE = 11, BODIES = 20, STEPS = 200 };

static char folder[] = "/tmp/collided-record-XXXXXX";

static void play_session(cell *daemon, bool record_from_the_middle)
{
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    int64_t sequence = 0;
    cell_hello(e, ALICE, ++sequence, 60, WIRE_LOST_REMOVE);
    for (int i = 0; i < BODIES; i++) {
        char name[16];
        snprintf(name, sizeof name, "ball%d", i);
        cell_sphere(e, ALICE, ++sequence, i, name, 2.5 * i);
    }
    cell_touches(e, ALICE, ++sequence, 0);
    for (int step = 0; step < STEPS; step++) {
        if (record_from_the_middle && step == STEPS / 2) {
            wire_message q = {.kind = WIRE_QUERY,
                .query = {.version = WIRE_VERSION,
                    .client = ALICE,
                    .sequence = ++sequence,
                    .kind = WIRE_QUERY_RECORD,
                    .name_a = "middle",
                    .name_b = ""}};
            memory_send(e, &q);
            assert_int_equal(cell_await(e, memory, WIRE_ANSWER).answer.status, WIRE_ANSWER_OK);
        }
        for (int i = 0; i < BODIES; i++) cell_pose(e, ALICE, ++sequence, i, 2.5 * i + sin(0.1 * step + i));
        if (step % 10 == 0) cell_settle(e, memory, ALICE, ++sequence); /* so that there are many ticks */
    }
    cell_settle(e, memory, ALICE, ++sequence);
    memory_disconnect(e);
    wire_memory_destroy(memory);
}

static void take_hash(void *hash, const wire_log_entry *e)
{
    if (e->kind == WIRE_LOG_TICK) *(int64_t *)hash = e->tick.events_hash;
}

static void a_session_replays_with_the_same_hash_for_any_number_of_workers(void **state)
{
    (void)state;
    config c = cell_config();
    snprintf(c.record, sizeof c.record, "%s/session.lcmlog", folder);
    cell *daemon = cell_start(&c);
    play_session(daemon, false);
    assert_int_equal(cell_stop(daemon), 0);
    int64_t hash = 0;
    assert_in_range(cell_read(c.record, take_hash, &hash), 10, 100000);
    assert_true(hash != 0);
    for (long workers = 1; workers <= 4; workers *= 2) assert_int_equal(cell_replay(c.record, workers, true), EX_OK);
    assert_int_equal(cell_replay(c.record, 1, false), EX_OK);
}

static void a_recording_that_begins_in_the_middle_replays_alike_each_time(void **state)
{
    (void)state;
    char path[sizeof folder + 32];
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    cell *daemon = cell_start(&c);
    play_session(daemon, true);
    assert_int_equal(cell_stop(daemon), 0);
    int64_t hash;
    assert_in_range(cell_read(path, take_hash, &hash), 5, 100000);
    assert_int_equal(cell_replay(path, 1, true), EX_SOFTWARE); /* contact ids are counted anew: it says so */
}

static void an_existing_recording_is_not_overwritten(void **state)
{
    (void)state;
    char why[512] = "";
    config c = cell_config();
    snprintf(c.record, sizeof c.record, "%s/session.lcmlog", folder);
    assert_null(server_create(&c, why, sizeof why));
    assert_non_null(strstr(why, "session.lcmlog"));
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
        cmocka_unit_test(a_session_replays_with_the_same_hash_for_any_number_of_workers),
        cmocka_unit_test(a_recording_that_begins_in_the_middle_replays_alike_each_time),
        cmocka_unit_test(an_existing_recording_is_not_overwritten),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
