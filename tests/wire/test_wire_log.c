/* Recordings: what is written is read back; a damaged or cut file gives an error with its offset; nothing is
 * overwritten. */
#include "sample.h"

#include "wire/wire_log.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { ROUNDS = 5, MOST = 8, HEADER = 28 };

static char folder[] = "/tmp/collided-wire-log-XXXXXX";
static char path[64];

static int make_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder)) return -1;
    snprintf(path, sizeof path, "%s/log", folder);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(folder);
}

static int remove_file(void **state)
{
    (void)state;
    unlink(path);
    return 0;
}

static wire_log_writer *create(void)
{
    char why[256] = "";
    wire_log_writer *w = wire_log_create(path, why, sizeof why);
    if (!w) fail_msg("%s", why);
    return w;
}

static wire_log_reader *open_log(void)
{
    char why[256] = "";
    wire_log_reader *r = wire_log_open(path, why, sizeof why);
    if (!r) fail_msg("%s", why);
    return r;
}

static size_t read_bytes(uint8_t *out, size_t capacity)
{
    FILE *f = fopen(path, "rb");
    size_t size = fread(out, 1, capacity, f);
    fclose(f);
    return size;
}

static void write_bytes(const uint8_t *bytes, size_t size)
{
    FILE *f = fopen(path, "wb");
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

/* ---- what is written is read back ---- */

/* With and without a budget, a slice, and a limit of pairs. */
static wire_log_tick tick_of(int round)
{
    return (wire_log_tick){round, 2, 3, INT64_MIN, round % 2, round % 2 * INT64_C(77), round % 3 * INT64_C(20000000),
        round % 4 / 2 * (INT64_MAX - round)};
}

static void write_all_kinds(sampler *s)
{
    wire_log_writer *w = create();
    for (int round = 0; round < ROUNDS; round++) {
        for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
            wire_message m = sample_message(s, (wire_kind)kind, MOST);
            assert_int_equal(wire_log_message(w, 1000 * round + kind, &m), 0);
        }
        wire_log_tick tick = tick_of(round);
        assert_int_equal(wire_log_tick_end(w, round, &tick), 0);
        assert_int_equal(wire_log_lost(w, -1, INT64_MIN + round), 0);
        assert_int_equal(wire_log_steps(w, -2, INT64_MAX - round), 0);
    }
    assert_int_equal(wire_log_close(w), 0);
}

static void expect_entry(wire_log_reader *r, wire_log_entry *e)
{
    char why[256] = "";
    uint64_t skipped = 0;
    if (wire_log_next(r, e, &skipped, why, sizeof why) != 1) fail_msg("%s", why);
    assert_int_equal(skipped, 0);
}

static void everything_written_is_read_back_in_order(void **state)
{
    (void)state;
    sampler written = {.random = 3, .memory = wire_memory_create()}, expected = {3, wire_memory_create()};
    write_all_kinds(&written);
    wire_log_reader *r = open_log();
    wire_log_entry e;
    for (int round = 0; round < ROUNDS; round++) {
        for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
            wire_message m = sample_message(&expected, (wire_kind)kind, MOST);
            expect_entry(r, &e);
            assert_int_equal(e.kind, WIRE_LOG_MESSAGE);
            assert_int_equal(e.timestamp_us, 1000 * round + kind);
            assert_null(sample_difference(&m, &e.message));
        }
        expect_entry(r, &e);
        assert_int_equal(e.kind, WIRE_LOG_TICK);
        assert_int_equal(e.timestamp_us, round);
        wire_log_tick tick = tick_of(round);
        assert_memory_equal(&e.tick, &tick, sizeof e.tick);
        expect_entry(r, &e);
        assert_int_equal(e.kind, WIRE_LOG_LOST);
        assert_int_equal(e.lost_client, INT64_MIN + round);
        expect_entry(r, &e);
        assert_int_equal(e.kind, WIRE_LOG_STEPS);
        assert_int_equal(e.steps_done, INT64_MAX - round);
    }
    assert_int_equal(wire_log_next(r, &e, NULL, (char[8]){0}, 8), 0);
    assert_int_equal(wire_log_next(r, &e, NULL, (char[8]){0}, 8), 0);
    wire_log_end(r);
    wire_memory_destroy(written.memory);
    wire_memory_destroy(expected.memory);
}

static void a_state_comes_back_in_pieces(void **state)
{
    (void)state;
    enum { SIZE = 2 * WIRE_LOG_PIECE_BYTES + 7 };
    uint8_t *bytes = malloc(SIZE);
    char why[256] = "";
    for (size_t i = 0; i < SIZE; i++) bytes[i] = (uint8_t)(i * 7 + i / 251);
    wire_log_writer *w = create();
    assert_int_equal(wire_log_whole_state(w, 5, bytes, SIZE, UINT64_C(0xfedcba9876543210)), 0);
    assert_int_equal(wire_log_close(w), 0);
    wire_log_reader *r = open_log();
    wire_log_entry e;
    for (size_t at = 0; at < SIZE; at += e.data_size) {
        expect_entry(r, &e);
        assert_true(e.kind == WIRE_LOG_STATE && e.timestamp_us == 5 && e.data_size <= WIRE_LOG_PIECE_BYTES);
        assert_true(e.state.offset == at && e.state.total == SIZE && e.state.hash == UINT64_C(0xfedcba9876543210));
        assert_memory_equal(e.data, bytes + at, e.data_size);
    }
    assert_int_equal(wire_log_next(r, &e, NULL, why, sizeof why), 0);
    wire_log_end(r);
    free(bytes);
}

/* LCM's own layout, by hand: sync word, number, time, sizes, channel, data. */
static void records_have_the_layout_of_lcm_logger(void **state)
{
    (void)state;
    static const uint8_t expected[] = "\xED\xA1\xDA\x01"
                                      "\0\0\0\0\0\0\0\1"
                                      "\0\0\0\0\0\0\1\2"
                                      "\0\0\0\15"
                                      "\0\0\0\10"
                                      "collided.lost"
                                      "\1\2\3\4\5\6\7\10";
    uint8_t bytes[256];
    wire_log_writer *w = create();
    assert_int_equal(wire_log_lost(w, 0, 0), 0);
    assert_int_equal(wire_log_lost(w, 0x102, INT64_C(0x0102030405060708)), 0);
    assert_int_equal(wire_log_close(w), 0);
    size_t record = sizeof expected - 1;
    assert_int_equal(read_bytes(bytes, sizeof bytes), 2 * record);
    assert_memory_equal(bytes + record, expected, record);
}

static void channels_of_others_are_passed_over_and_counted(void **state)
{
    (void)state;
    uint8_t bytes[512];
    wire_log_writer *w = create();
    assert_int_equal(wire_log_lost(w, 0, 1), 0);
    assert_int_equal(wire_log_lost(w, 0, 2), 0);
    assert_int_equal(wire_log_close(w), 0);
    size_t size = read_bytes(bytes, sizeof bytes);
    bytes[HEADER] = 'C'; /* "Collided.lost" is not ours */
    write_bytes(bytes, size);
    wire_log_reader *r = open_log();
    wire_log_entry e;
    uint64_t skipped = 0;
    assert_int_equal(wire_log_next(r, &e, &skipped, (char[8]){0}, 8), 1);
    assert_int_equal(e.lost_client, 2);
    assert_int_equal(skipped, 1);
    wire_log_end(r);
}

static void an_empty_record_of_others_is_passed_over(void **state)
{
    (void)state;
    static const uint8_t empty[HEADER] = {0xED, 0xA1, 0xDA, 0x01};
    write_bytes(empty, sizeof empty);
    wire_log_reader *r = open_log();
    wire_log_entry e;
    uint64_t skipped = 0;
    assert_int_equal(wire_log_next(r, &e, &skipped, (char[8]){0}, 8), 0);
    assert_int_equal(skipped, 1);
    wire_log_end(r);
}

/* ---- damage ---- */

/* Entries until the end or the damage; `why` tells of the latter. */
static int read_until_end(int *entries, char *why, size_t why_size)
{
    wire_log_reader *r = open_log();
    wire_log_entry e;
    int got;
    for (*entries = 0; (got = wire_log_next(r, &e, NULL, why, why_size)) == 1;) ++*entries;
    wire_log_end(r);
    return got;
}

/* Nobody is to take memory for it. */
static void a_state_longer_than_the_file_is_told(void **state)
{
    (void)state;
    static const size_t TOTAL_AT = HEADER + sizeof "collided.state" - 1 + 8;
    uint8_t bytes[256];
    char why[256] = "";
    int entries;
    wire_log_writer *w = create();
    assert_int_equal(wire_log_whole_state(w, 0, (const uint8_t *)"state", 5, 1), 0);
    assert_int_equal(wire_log_close(w), 0);
    size_t size = read_bytes(bytes, sizeof bytes);
    bytes[TOTAL_AT] = 1;
    write_bytes(bytes, size);
    assert_int_equal(read_until_end(&entries, why, sizeof why), -1);
    assert_string_equal(why, "damaged at byte 0: a state is longer than the file");
    bytes[TOTAL_AT] = 0;
    bytes[TOTAL_AT + 7] = 4;
    write_bytes(bytes, size);
    assert_int_equal(read_until_end(&entries, why, sizeof why), -1);
    assert_string_equal(why, "damaged at byte 0: a piece is longer than its state");
}

/* A tick, then a message: the size of the whole, and where the message's record begins. */
static size_t tick_and_message(uint8_t *bytes, size_t capacity, size_t *last)
{
    sampler s = {.random = 4, .memory = wire_memory_create()};
    wire_message m = sample_message(&s, WIRE_BODY, 3);
    wire_log_writer *w = create();
    assert_int_equal(wire_log_tick_end(w, 0, &(wire_log_tick){.tick = 1}), 0);
    assert_int_equal(wire_log_message(w, 0, &m), 0);
    assert_int_equal(wire_log_close(w), 0);
    *last = HEADER + strlen("collided.tick") + 32;
    wire_memory_destroy(s.memory);
    return read_bytes(bytes, capacity);
}

static void a_cut_at_any_byte_is_told_with_its_offset(void **state)
{
    (void)state;
    uint8_t bytes[8192];
    size_t last, size = tick_and_message(bytes, sizeof bytes, &last);
    char why[256], offset[64];
    snprintf(offset, sizeof offset, "byte %zu:", last);
    int entries;
    for (size_t cut = last + 1; cut < size; cut++) {
        write_bytes(bytes, cut);
        assert_int_equal(read_until_end(&entries, why, sizeof why), -1);
        assert_int_equal(entries, 1);
        assert_non_null(strstr(why, offset));
    }
    write_bytes(bytes, last);
    assert_int_equal(read_until_end(&entries, why, sizeof why), 0);
    write_bytes(bytes, size);
    assert_int_equal(read_until_end(&entries, why, sizeof why), 0);
    assert_int_equal(entries, 2);
}

static void a_damaged_sync_word_is_told_with_its_offset(void **state)
{
    (void)state;
    uint8_t bytes[8192];
    size_t last, size = tick_and_message(bytes, sizeof bytes, &last);
    char why[256], told[64];
    int entries;
    snprintf(told, sizeof told, "byte %zu: no sync word", last);
    for (int k = 0; k < 4; k++) {
        bytes[last + (size_t)k] ^= 0x10;
        write_bytes(bytes, size);
        assert_int_equal(read_until_end(&entries, why, sizeof why), -1);
        assert_int_equal(entries, 1);
        assert_non_null(strstr(why, told));
        bytes[last + (size_t)k] ^= 0x10;
    }
}

/* Clocks whose differences are no numbers of 64 bits any more. */
static void an_absurd_tick_is_told(void **state)
{
    (void)state;
    static const int64_t WRONG[] = {-1, INT64_MIN, INT64_C(1) << 62, INT64_MAX};
    for (size_t i = 0; i < sizeof WRONG / sizeof *WRONG; i++) {
        for (int field = 0; field < 3; field++) {
            wire_log_tick tick = {1, 2, 3, 4, 0, 0, 0, 0};
            *(field == 0 ? &tick.tick : field == 1 ? &tick.now_ns : &tick.monotonic_ns) = WRONG[i];
            wire_log_writer *w = create();
            assert_int_equal(wire_log_tick_end(w, 0, &tick), 0);
            assert_int_equal(wire_log_close(w), 0);
            char why[256] = "";
            int entries;
            assert_int_equal(read_until_end(&entries, why, sizeof why), -1);
            assert_string_equal(why,
                field ? "damaged at byte 0: a tick's clock is absurd" : "damaged at byte 0: a tick's number is absurd");
            unlink(path);
        }
    }
}

/* Under the sanitizers: whatever one byte says, reading ends, and takes no more memory than the file is long. */
static void one_wrong_byte_anywhere_is_an_error_or_another_legal_file(void **state)
{
    (void)state;
    uint8_t bytes[8192];
    size_t last, size = tick_and_message(bytes, sizeof bytes, &last);
    char why[256];
    int entries;
    for (size_t at = 0; at < size; at++) {
        bytes[at] ^= 0xff;
        write_bytes(bytes, size);
        int got = read_until_end(&entries, why, sizeof why);
        assert_true(got == 0 || got == -1);
        assert_true(entries <= 2);
        bytes[at] ^= 0xff;
    }
}

/* ---- files ---- */

static void an_existing_file_is_not_overwritten(void **state)
{
    (void)state;
    char why[256] = "";
    write_bytes((const uint8_t *)"precious", 8);
    assert_null(wire_log_create(path, why, sizeof why));
    assert_non_null(strstr(why, path));
    assert_non_null(strstr(why, strerror(EEXIST)));
    uint8_t bytes[16];
    assert_int_equal(read_bytes(bytes, sizeof bytes), 8);
    assert_memory_equal(bytes, "precious", 8);
}

static void a_file_that_is_not_there_is_told(void **state)
{
    (void)state;
    char why[256] = "";
    assert_null(wire_log_open("/nowhere/log", why, sizeof why));
    assert_non_null(strstr(why, strerror(ENOENT)));
    assert_null(wire_log_create("/nowhere/log", why, sizeof why));
}

/* Once a record could not be written, none is: a log with a hole would be read as whole. */
static void after_one_refusal_all_that_follows_is_refused(void **state)
{
    (void)state;
    wire_log_writer *w = create();
    assert_int_equal(wire_log_message(w, 0, &(wire_message){.kind = WIRE_NOTHING}), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(wire_log_lost(w, 0, 1), -1);
    assert_int_equal(wire_log_close(w), -1);
    assert_int_equal(errno, EINVAL);
}

#define WITH_FILE(test) cmocka_unit_test_teardown(test, remove_file)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FILE(everything_written_is_read_back_in_order),
        WITH_FILE(a_state_comes_back_in_pieces),
        WITH_FILE(a_state_longer_than_the_file_is_told),
        WITH_FILE(records_have_the_layout_of_lcm_logger),
        WITH_FILE(channels_of_others_are_passed_over_and_counted),
        WITH_FILE(an_empty_record_of_others_is_passed_over),
        WITH_FILE(a_cut_at_any_byte_is_told_with_its_offset),
        WITH_FILE(a_damaged_sync_word_is_told_with_its_offset),
        WITH_FILE(an_absurd_tick_is_told),
        WITH_FILE(one_wrong_byte_anywhere_is_an_error_or_another_legal_file),
        WITH_FILE(an_existing_file_is_not_overwritten),
        WITH_FILE(a_file_that_is_not_there_is_told),
        WITH_FILE(after_one_refusal_all_that_follows_is_refused),
    };
    return cmocka_run_group_tests_name("wire_log", tests, make_folder, remove_folder);
}
