/* What is recorded replays: the same hash for 1, 2 and 4 workers, with caches and without, from the start of a session
 * and from its middle. */
#include "cell.h"

#include "base/array.h"
#include "base/hash.h"
#include "service/server.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <time.h>
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

static char told[8192]; /* by the last replay */

static int replay_and_hear(const char *path)
{
    fflush(stdout);
    int out = dup(STDOUT_FILENO);
    FILE *file = tmpfile();
    dup2(fileno(file), STDOUT_FILENO);
    int status = cell_replay(path, 1, true);
    fflush(stdout);
    dup2(out, STDOUT_FILENO);
    close(out);
    rewind(file);
    told[fread(told, 1, sizeof told - 1, file)] = '\0';
    fclose(file);
    return status;
}

static void says(const char *words)
{
    if (!strstr(told, words)) fail_msg("no %s in: %s", words, told);
}

static void a_recording_that_begins_in_the_middle_replays_equal(void **state)
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
    assert_int_equal(replay_and_hear(path), EX_OK);
    for (long workers = 1; workers <= 4; workers *= 2)
        assert_int_equal(cell_replay(path, workers, workers != 2), EX_OK);
}

/* A copy of that recording with a state of which so many bytes, from `at` on, are `with`; all of it is whole. */
static void rewrite_state(const char *to, size_t at, const char *with)
{
    char why[256] = "", from[sizeof folder + 32];
    ARRAY(uint8_t) state = {0};
    snprintf(from, sizeof from, "%s/middle.lcmlog", folder);
    unlink(to);
    wire_log_reader *r = wire_log_open(from, why, sizeof why);
    wire_log_writer *w = wire_log_create(to, why, sizeof why);
    assert_true(r && w);
    for (wire_log_entry e; wire_log_next(r, &e, NULL, why, sizeof why) == 1;) {
        int written = 0;
        if (e.kind == WIRE_LOG_MESSAGE) written = wire_log_message(w, e.timestamp_us, &e.message);
        if (e.kind == WIRE_LOG_TICK) written = wire_log_tick_end(w, e.timestamp_us, &e.tick);
        if (e.kind == WIRE_LOG_STATE) {
            for (size_t i = 0; i < e.data_size; i++) array_push(&state, e.data[i]);
            if (state.count < e.state.total) continue;
            assert_true(hash_words(HASH_START, state.at, state.count) == e.state.hash);
            memcpy(state.at + at, with, strlen(with));
            uint64_t hash = hash_words(HASH_START, state.at, state.count);
            written = wire_log_whole_state(w, e.timestamp_us, state.at, state.count, hash);
        }
        assert_int_equal(written, 0);
    }
    assert_true(state.count > 0);
    wire_log_end(r);
    assert_int_equal(wire_log_close(w), 0);
    array_free(&state);
}

/* As it lies in memory it means something to this build alone. What was announced is there for all others. */
static void a_state_of_another_release_is_left_out_and_said_to_be(void **state)
{
    (void)state;
    char path[sizeof folder + 32];
    snprintf(path, sizeof path, "%s/changed.lcmlog", folder);
    rewrite_state(path, 0, "0.0.9");
    assert_int_equal(replay_and_hear(path), EX_SOFTWARE);
    says("\"state_left_out\":\"it is of release 0.0.9, and this is ");
    says("{\"field\":\"contacts\",\"recorded\":\""); /* they are counted anew, and nothing else */
    assert_null(strstr(told, "\"field\":\"lo\""));
    unlink(path);
}

/* ---- what differs is told ---- */

typedef bool change(wire_log_entry *entry, int *left); /* changes the entry, or leaves it out (false) */

/* A copy of the session's recording, in which one entry is another one. */
static void rewrite(const char *to, change *alter)
{
    char why[256] = "", from[sizeof folder + 32];
    int left = 1;
    snprintf(from, sizeof from, "%s/session.lcmlog", folder);
    unlink(to);
    wire_log_reader *r = wire_log_open(from, why, sizeof why);
    wire_log_writer *w = wire_log_create(to, why, sizeof why);
    assert_true(r && w);
    for (wire_log_entry e; wire_log_next(r, &e, NULL, why, sizeof why) == 1;) {
        if (!alter(&e, &left)) continue;
        int written = e.kind == WIRE_LOG_MESSAGE ? wire_log_message(w, e.timestamp_us, &e.message)
                      : e.kind == WIRE_LOG_TICK  ? wire_log_tick_end(w, e.timestamp_us, &e.tick)
                                                 : wire_log_lost(w, e.timestamp_us, e.lost_client);
        assert_int_equal(written, 0);
    }
    assert_int_equal(left, 0); /* it was there */
    wire_log_end(r);
    assert_int_equal(wire_log_close(w), 0);
}

static bool is_events(const wire_log_entry *e)
{
    return e->kind == WIRE_LOG_MESSAGE && e->message.kind == WIRE_EVENT_BATCH && e->message.event_batch.kinds.count;
}

static bool nothing(wire_log_entry *e, int *left)
{
    (void)e;
    *left = 0;
    return true;
}

static bool one_bound(wire_log_entry *e, int *left)
{
    if (!*left || !is_events(e)) return true;
    ((double *)(uintptr_t)e->message.event_batch.lo.at)[0] -= 0.5;
    *left = 0;
    return true;
}

static bool one_name(wire_log_entry *e, int *left)
{
    if (!*left || !is_events(e)) return true;
    ((const char **)(uintptr_t)e->message.event_batch.names_b.at)[0] = "\"x\"";
    *left = 0;
    return true;
}

static bool one_event_less(wire_log_entry *e, int *left)
{
    if (!*left || !is_events(e)) return true;
    *left = 0;
    return false;
}

/* As if nothing had been told in one of the later ticks: so its hash was another one. */
static bool all_of_one_tick(wire_log_entry *e, int *left)
{
    static bool here;
    bool news = is_events(e) && !e->message.event_batch.snapshot; /* which tells nothing new, and enters no hash */
    if (*left && news && e->message.event_batch.tick > 8) here = true;
    if (here && e->kind == WIRE_LOG_MESSAGE && e->message.kind == WIRE_EVENT_BATCH) return false;
    if (!here || e->kind != WIRE_LOG_TICK) return true;
    e->tick.events_hash ^= 1;
    here = false;
    *left = 0;
    return true;
}

/* Commands, of which the last in a tick counts: what follows from it differs. */
static bool some_poses(wire_log_entry *e, int *left)
{
    if (e->kind != WIRE_LOG_MESSAGE || e->message.kind != WIRE_POSE_BATCH) return true;
    if (e->message.pose_batch.sequence < 500) return true; /* there are contacts by then */
    ((double *)(uintptr_t)e->message.pose_batch.positions.at)[0] += 1e-9;
    *left = 0;
    return true;
}

static bool one_hash(wire_log_entry *e, int *left)
{
    if (!*left || e->kind != WIRE_LOG_TICK || e->tick.tick < 4) return true;
    e->tick.events_hash ^= 1;
    *left = 0;
    return true;
}

static bool all_events(wire_log_entry *e, int *left)
{
    *left = 0;
    return !(e->kind == WIRE_LOG_MESSAGE && e->message.kind == WIRE_EVENT_BATCH);
}

static bool all_events_and_some_poses(wire_log_entry *e, int *left)
{
    int unused = 0;
    return some_poses(e, left) && all_events(e, &unused);
}

static void the_first_difference_is_told_with_both_values(void **state)
{
    (void)state;
    char path[sizeof folder + 32];
    snprintf(path, sizeof path, "%s/changed.lcmlog", folder);
    rewrite(path, nothing);
    assert_int_equal(replay_and_hear(path), EX_OK);
    says("\"first_different_tick\":0}");
    rewrite(path, one_bound);
    assert_int_equal(replay_and_hear(path), EX_SOFTWARE);
    says("\"event\":0,\"recorded\":\"begin of contact ");
    says("\"fields\":[{\"field\":\"lo\",\"recorded\":\"-0.");
    says("}],\"more\":0}}\n"); /* and nothing else */
    rewrite(path, one_name);
    assert_int_equal(replay_and_hear(path), EX_SOFTWARE);
    says("{\"field\":\"names_b\",\"recorded\":\"\\\"x\\\"\",\"replayed\":\"ball");
    rewrite(path, one_event_less);
    assert_int_equal(replay_and_hear(path), EX_OK); /* of a tick without any, nothing was recorded: the hash is equal */
    rewrite(path, all_of_one_tick);
    assert_int_equal(replay_and_hear(path), EX_SOFTWARE);
    says("\"event\":0,\"recorded\":\"nothing\",\"replayed\":\"");
    rewrite(path, some_poses);
    assert_int_equal(replay_and_hear(path), EX_SOFTWARE);
    says("\"field\":\"points_");
    rewrite(path, one_hash);
    assert_int_equal(replay_and_hear(path), EX_SOFTWARE);
    says("\"first_different_tick\":4}");
    rewrite(path, all_events); /* as with record_events = no */
    assert_int_equal(replay_and_hear(path), EX_OK);
    rewrite(path, all_events_and_some_poses);
    assert_int_equal(replay_and_hear(path), EX_SOFTWARE);
    assert_null(strstr(told, "difference"));
    unlink(path);
}

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Its ticks lie as far apart as they were recorded, divided by the speed; their events are the same. */
static void a_replay_may_take_its_time(void **state)
{
    (void)state;
    char path[sizeof folder + 32], why[512] = "";
    snprintf(path, sizeof path, "%s/slow.lcmlog", folder);
    wire_log_writer *w = wire_log_create(path, why, sizeof why);
    assert_non_null(w);
    for (int tick = 1; tick <= 4; tick++) {
        const wire_log_tick t = {
            tick, 1000000000LL * tick, 200000000LL * tick, INT64_C(-3750763034362895579), 0, 0, 0, 0};
        assert_int_equal(wire_log_tick_end(w, 1, &t), 0);
    }
    assert_int_equal(wire_log_close(w), 0);
    double took[2] = {9, 9}; /* the least: a busy machine may take longer now and then */
    for (int i = 0; i < 20 && (took[0] >= 0.2 || took[1] >= 0.55); i++) {
        config c = cell_config();
        snprintf(c.replay, sizeof c.replay, "%s", path);
        c.json = true;
        c.replay_speed = i % 2 ? 2 : 0;
        server *s = server_create(&c, why, sizeof why);
        assert_non_null(s);
        double began = now_s();
        assert_int_equal(server_run(s), EX_OK);
        took[i % 2] = fmin(took[i % 2], now_s() - began);
        server_destroy(s);
    }
    assert_true(took[0] < 0.2);
    assert_true(took[1] >= 0.3 && took[1] < 0.55); /* 3 times 0.2 s, twice as fast */
    unlink(path);
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
        cmocka_unit_test(a_recording_that_begins_in_the_middle_replays_equal),
        cmocka_unit_test(a_state_of_another_release_is_left_out_and_said_to_be),
        cmocka_unit_test(the_first_difference_is_told_with_both_values),
        cmocka_unit_test(a_replay_may_take_its_time),
        cmocka_unit_test(an_existing_recording_is_not_overwritten),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
