/* A recording as a link: its ticks come one by one, whole, and a damaged one says so. */
#include "harness.h"
#include "link/link_open.h"

#include "base/hash.h"
#include "link/link_replay.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[] = "/tmp/collided-replay-XXXXXX";
static char path[64], uri[80];

static void record(int ticks, bool unfinished)
{
    char why[256] = "";
    unlink(path);
    wire_log_writer *w = wire_log_create(path, why, sizeof why);
    if (!w) fail_msg("%s", why);
    for (int tick = 1; tick <= ticks; tick++) {
        for (int i = 0; i < tick; i++) {
            wire_message m = sample_poses(3, 10 * tick + i);
            assert_int_equal(wire_log_message(w, tick, &m), 0);
        }
        if (tick == 2) assert_int_equal(wire_log_lost(w, tick, CLIENT_ID), 0);
        wire_log_tick end = {.tick = tick, .now_ns = 100 * tick, .monotonic_ns = 10 * tick, .events_hash = 7 * tick};
        assert_int_equal(wire_log_tick_end(w, tick, &end), 0);
    }
    wire_message rest = sample_message(WIRE_CLIENT);
    if (unfinished) assert_int_equal(wire_log_message(w, ticks, &rest), 0);
    assert_int_equal(wire_log_close(w), 0);
}

static void each_receive_gives_one_tick(void **state)
{
    (void)state;
    record(3, true);
    rig r;
    wire_log_tick tick;
    char why[256];
    rig_open(&r, uri, NULL);
    for (int64_t expected = 1; expected <= 3; expected++) {
        memset(&r.heard, 0, sizeof r.heard);
        assert_true(rig_is_woken(&r, 0));
        rig_receive(&r);
        rig_receive(&r); /* nothing more until the tick has been taken */
        assert_int_equal(r.heard.messages[WIRE_POSE_BATCH], expected);
        assert_int_equal(r.heard.lost, expected == 2);
        assert_true(link_replay_tick(r.link, &tick, why, sizeof why));
        assert_int_equal(tick.tick, expected);
        assert_int_equal(tick.now_ns, 100 * expected);
        assert_int_equal(tick.events_hash, 7 * expected);
    }
    rig_receive(&r);
    assert_false(link_replay_tick(r.link, &tick, why, sizeof why));
    assert_string_equal(why, "");
    assert_int_equal(rig_counter(&r, "replay_unfinished"), 1);
    wire_message m = sample_message(WIRE_STATUS);
    rig_publish(&r, &m); /* goes nowhere */
    rig_close(&r);
}

static void a_damaged_recording_says_so(void **state)
{
    (void)state;
    record(2, false);
    FILE *f = fopen(path, "r+");
    fseek(f, 0, SEEK_END);
    assert_int_equal(ftruncate(fileno(f), ftell(f) - 9), 0);
    fclose(f);
    rig r;
    wire_log_tick tick;
    char why[256];
    rig_open(&r, uri, NULL);
    rig_receive(&r);
    assert_true(link_replay_tick(r.link, &tick, why, sizeof why));
    rig_receive(&r);
    assert_false(link_replay_tick(r.link, &tick, why, sizeof why));
    assert_true(why[0] != '\0');
    rig_close(&r);
}

/* ---- a state ---- */

typedef struct heard_state {
    size_t calls, size;
    uint8_t bytes[64];
} heard_state;

static heard_state whole;

static void on_state(void *context, const uint8_t *bytes, size_t size)
{
    (void)context;
    whole.calls++;
    whole.size = size;
    memcpy(whole.bytes, bytes, size < sizeof whole.bytes ? size : sizeof whole.bytes);
}

/* Of `size` bytes, in pieces, of which that one is left out; -1: none. */
static bool hear_state(size_t size, uint64_t hash, int left_out, bool listens, char why[256])
{
    uint8_t *bytes = calloc(size, 1);
    bytes[0] = 's';
    unlink(path);
    wire_log_writer *w = wire_log_create(path, why, 256);
    assert_non_null(w);
    assert_int_equal(wire_log_whole_state(w, 1, bytes, size, hash), 0);
    assert_int_equal(wire_log_tick_end(w, 1, &(wire_log_tick){.tick = 1, .now_ns = 1, .monotonic_ns = 1}), 0);
    assert_int_equal(wire_log_close(w), 0);
    if (left_out >= 0) { /* its record and its channel become another's */
        FILE *f = fopen(path, "r+");
        fseek(f, left_out * (28 + 14 + 24 + WIRE_LOG_PIECE_BYTES) + 28, SEEK_SET);
        assert_int_equal(fputc('x', f), 'x');
        assert_int_equal(fclose(f), 0);
    }
    rig r;
    wire_log_tick tick;
    whole = (heard_state){.calls = 0};
    rig_open(&r, uri, NULL);
    if (listens) r.sink.state = on_state;
    rig_receive(&r);
    bool got = link_replay_tick(r.link, &tick, why, 256);
    rig_close(&r);
    free(bytes);
    return got;
}

static void a_state_is_handed_over_whole_or_not_at_all(void **state)
{
    (void)state;
    enum { SIZE = 2 * WIRE_LOG_PIECE_BYTES + 9 };
    char why[256] = "";
    uint8_t *bytes = calloc(SIZE, 1);
    bytes[0] = 's';
    uint64_t hash = hash_words(HASH_START, bytes, SIZE);
    free(bytes);
    assert_true(hear_state(SIZE, hash, -1, true, why));
    assert_true(whole.calls == 1 && whole.size == SIZE && whole.bytes[0] == 's');
    assert_true(hear_state(SIZE, hash, -1, false, why)); /* nobody wants to know */
    for (int piece = 0; piece < 3; piece++) {
        assert_false(hear_state(SIZE, hash, piece, true, why));
        assert_string_equal(why, "damaged: a piece of the state that it begins with is missing");
    }
    assert_false(hear_state(SIZE, hash ^ 1, -1, true, why));
    assert_string_equal(why, "damaged: the state that it begins with is not what was written");
    assert_int_equal(whole.calls, 0);
}

static void a_recording_that_is_not_there_is_refused(void **state)
{
    (void)state;
    char why[256] = "";
    link_options options = {.counters = NULL, .interface = ""};
    assert_null(link_open("replay:///nowhere/at.all", &options, why, sizeof why));
    assert_true(why[0] != '\0');
}

int main(void)
{
    if (!mkdtemp(folder)) return EXIT_FAILURE;
    snprintf(path, sizeof path, "%s/log", folder);
    snprintf(uri, sizeof uri, "replay://%s", path);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_receive_gives_one_tick),
        cmocka_unit_test(a_damaged_recording_says_so),
        cmocka_unit_test(a_state_is_handed_over_whole_or_not_at_all),
        cmocka_unit_test(a_recording_that_is_not_there_is_refused),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(path);
    rmdir(folder);
    return failed;
}
