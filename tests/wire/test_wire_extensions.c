/* Extensions: the records behind the fields of a message. What is not whole, or out of order, is refused; what is not
 * known is passed over, unless it says that it must not be. */
#include "plain.h"

#include "wire/wire_extensions.h"
#include "wire/wire_lcm.h"

#include <string.h>

typedef struct records {
    uint32_t size;
    uint8_t bytes[256];
} records;

static void put_u32(records *r, uint32_t v)
{
    for (int k = 0; k < 4; k++) r->bytes[r->size++] = (uint8_t)(v >> 8 * k);
}

static void put(records *r, uint32_t id, const char *text)
{
    put_u32(r, id);
    put_u32(r, (uint32_t)strlen(text));
    memcpy(r->bytes + r->size, text, strlen(text));
    r->size += (uint32_t)strlen(text);
}

static wire_message with(wire_kind kind, const records *r)
{
    wire_message m = plain_message(kind);
    wire_extensions_set(&m, (wire_u8s){r->size, r->bytes});
    return m;
}

static void every_message_may_have_some(void **state)
{
    (void)state;
    records r = {0};
    put(&r, 1, "");
    put(&r, 2, "two");
    put(&r, 0x7fffffff, "last");
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        wire_message m = with((wire_kind)kind, &r);
        expect_accepted(&m, "three records");
        wire_u8s rest = wire_extensions_of(&m);
        wire_extension e;
        assert_true(wire_extension_next(&rest, &e) && e.id == 1 && e.bytes.count == 0);
        assert_true(wire_extension_next(&rest, &e) && e.id == 2 && e.bytes.count == 3);
        assert_memory_equal(e.bytes.at, "two", 3);
        assert_true(wire_extension_next(&rest, &e) && e.id == 0x7fffffff && e.bytes.count == 4);
        assert_false(wire_extension_next(&rest, &e));
        assert_int_equal(rest.count, 0);
    }
    assert_int_equal(wire_extensions_of(&(wire_message){.kind = WIRE_NOTHING}).count, 0);
}

/* Cut off anywhere but between two records. */
static void a_record_that_is_not_whole_is_refused(void **state)
{
    (void)state;
    records r = {0};
    put(&r, 1, "one");
    uint32_t first = r.size;
    put(&r, 2, "");
    for (uint32_t size = 0; size <= r.size; size++) {
        records cut = {size, {0}};
        memcpy(cut.bytes, r.bytes, size);
        wire_message m = with(WIRE_POSE_BATCH, &cut);
        if (size == 0 || size == first || size == r.size)
            expect_accepted(&m, "whole records");
        else
            expect_refused(&m, "cut", WIRE_MALFORMED, "the record is longer than what is left");
    }
    records endless = {0};
    put_u32(&endless, 1);
    put_u32(&endless, UINT32_MAX);
    wire_message m = with(WIRE_STATUS, &endless);
    expect_refused(&m, "4 GB", WIRE_MALFORMED, "extensions[0]: the record is longer");
}

static void ids_rise_from_1(void **state)
{
    (void)state;
    records none = {0}, twice = {0}, back = {0};
    put(&none, 0, "x");
    put(&twice, 3, "x");
    put(&twice, 3, "x");
    put(&back, 3, "x");
    put(&back, 2, "x");
    wire_message m = with(WIRE_CLIENT, &none);
    expect_refused(&m, "id 0", WIRE_MALFORMED, "ids rise from 1");
    m = with(WIRE_CLIENT, &twice);
    expect_refused(&m, "twice", WIRE_MALFORMED, "id 3 stands behind 3");
    m = with(WIRE_CLIENT, &back);
    expect_refused(&m, "back", WIRE_MALFORMED, "id 2 stands behind 3");
}

static void there_are_256_at_most(void **state)
{
    (void)state;
    static uint8_t bytes[(WIRE_RECORDS_MAX + 1) * WIRE_EXTENSION_HEAD];
    wire_message m = plain_message(WIRE_BODY);
    for (uint32_t i = 0; i <= WIRE_RECORDS_MAX; i++) {
        bytes[i * WIRE_EXTENSION_HEAD] = (uint8_t)(i + 1);
        bytes[i * WIRE_EXTENSION_HEAD + 1] = (uint8_t)((i + 1) >> 8);
    }
    wire_extensions_set(&m, (wire_u8s){WIRE_RECORDS_MAX * WIRE_EXTENSION_HEAD, bytes});
    expect_accepted(&m, "256 records");
    wire_extensions_set(&m, (wire_u8s){sizeof bytes, bytes});
    expect_refused(&m, "257 records", WIRE_TOO_LARGE, "more than the allowed 256 records");
}

static void what_must_not_be_passed_over_is_refused(void **state)
{
    (void)state;
    records r = {0};
    put(&r, 1, "x");
    put(&r, 9 | WIRE_EXTENSION_REQUIRED, "x");
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        wire_message m = with((wire_kind)kind, &r);
        expect_refused(&m, "required", WIRE_UNSUPPORTED, "extensions: 9 must not be passed over");
    }
}

static void what_is_not_known_is_counted_and_left_out(void **state)
{
    (void)state;
    uint8_t room[256];
    wire_u8s known;
    records r = {0};
    put(&r, 1, "one");
    put(&r, 2, "two");
    wire_message m = with(WIRE_BODY, &r);
    assert_false(wire_extension_is_known(WIRE_BODY, 1));
    assert_int_equal(wire_extensions_keep_known(&m, room, &known), 2);
    assert_int_equal(known.count, 0);
    m = plain_message(WIRE_BODY);
    assert_int_equal(wire_extensions_keep_known(&m, room, &known), 0);
}

/* The poses of a batch without them are checked in one pass; one with them is not plain. */
static void extensions_of_poses_are_checked(void **state)
{
    (void)state;
    records r = {0};
    put(&r, 1, "x");
    wire_message m = with(WIRE_POSE_BATCH, &r);
    plain.positions[0] = 2e12;
    expect_refused(&m, "positions[0] = 2e12", WIRE_TOO_LARGE, "positions[0]");
}

static void an_empty_field_takes_four_bytes(void **state)
{
    (void)state;
    records r = {0};
    put(&r, 1, "12345678");
    wire_message m = plain_message(WIRE_POSE_BATCH), more = with(WIRE_POSE_BATCH, &r);
    uint8_t bytes[1024] = {0};
    size_t size = wire_lcm_encode(&m, bytes, sizeof bytes);
    assert_memory_equal(bytes + size - 4, "\0\0\0\0", 4);
    assert_int_equal(wire_lcm_size(&more), size + WIRE_EXTENSION_HEAD + 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_message_may_have_some),
        cmocka_unit_test(a_record_that_is_not_whole_is_refused),
        cmocka_unit_test(ids_rise_from_1),
        cmocka_unit_test(there_are_256_at_most),
        cmocka_unit_test(what_must_not_be_passed_over_is_refused),
        cmocka_unit_test(what_is_not_known_is_counted_and_left_out),
        cmocka_unit_test(extensions_of_poses_are_checked),
        cmocka_unit_test(an_empty_field_takes_four_bytes),
    };
    return cmocka_run_group_tests_name("wire_extensions", tests, NULL, NULL);
}
