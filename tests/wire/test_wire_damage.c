/* What a network can do to an encoding: cut it, change it, lengthen it, invent it. Each time it is refused, or is
 * another message that keeps every rule; under the sanitizers, without a step beyond the bytes. */
#include "sample.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST = 3, ROUNDS = 1, INVENTED = 20000 };

static uint8_t *block(size_t size)
{
    return malloc(size ? size : 1);
}

/* Decodes from a block of exactly `size` bytes, so that the sanitizer sees every step beyond it. */
static wire_reason decode(wire_memory *memory, const uint8_t *bytes, size_t size)
{
    uint8_t *exact = block(size);
    wire_message m;
    wire_refusal why;
    if (size) memcpy(exact, bytes, size);
    wire_memory_reset(memory);
    wire_reason reason = wire_lcm_decode(exact, size, memory, &m, &why);
    assert_int_equal(reason, why.reason);
    assert_int_equal(reason == WIRE_OK, why.text[0] == '\0');
    if (reason == WIRE_OK) {
        assert_int_equal(wire_lcm_size(&m), size);
        uint8_t *again = block(size);
        assert_int_equal(wire_lcm_encode(&m, again, size), size);
        assert_memory_equal(again, exact, size);
        free(again);
    }
    free(exact);
    return reason;
}

static uint8_t *encode(const wire_message *m, size_t *size)
{
    *size = wire_lcm_size(m);
    uint8_t *bytes = malloc(*size + 1);
    assert_int_equal(wire_lcm_encode(m, bytes, *size), *size);
    bytes[*size] = 0;
    return bytes;
}

/* Hands every kind's encoding to `damage`. */
static void for_each_encoding(
    uint64_t seed, void (*damage)(wire_memory *memory, wire_kind kind, uint8_t *bytes, size_t size))
{
    sampler s = {.random = seed, .memory = wire_memory_create()};
    wire_memory *memory = wire_memory_create();
    for (int round = 0; round < ROUNDS; round++)
        for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
            wire_message m = sample_message(&s, (wire_kind)kind, MOST);
            size_t size;
            uint8_t *bytes = encode(&m, &size);
            assert_int_equal(decode(memory, bytes, size), WIRE_OK);
            damage(memory, (wire_kind)kind, bytes, size);
            free(bytes);
            wire_memory_reset(s.memory);
        }
    wire_memory_destroy(memory);
    wire_memory_destroy(s.memory);
}

static void cut_everywhere(wire_memory *memory, wire_kind kind, uint8_t *bytes, size_t size)
{
    (void)kind;
    for (size_t cut = 0; cut < size; cut++) {
        wire_reason reason = decode(memory, bytes, cut);
        assert_true(reason == WIRE_MALFORMED || reason == WIRE_TOO_LARGE);
    }
    assert_int_equal(decode(memory, bytes, size + 1), WIRE_MALFORMED);
}

static void a_cut_or_lengthened_message_is_malformed(void **state)
{
    (void)state;
    for_each_encoding(5, cut_everywhere);
}

/* The byte becomes 0, 255, one more, and each of its bits is turned. */
static void change_everywhere(wire_memory *memory, wire_kind kind, uint8_t *bytes, size_t size)
{
    (void)kind;
    for (size_t at = 0; at < size; at++) {
        uint8_t was = bytes[at];
        const uint8_t changed[] = {
            0, 255, (uint8_t)(was + 1), was ^ 1, was ^ 2, was ^ 4, was ^ 8, was ^ 16, was ^ 32, was ^ 64, was ^ 128};
        for (size_t k = 0; k < sizeof changed; k++) {
            bytes[at] = changed[k];
            wire_reason reason = decode(memory, bytes, size);
            if (at < 8 && changed[k] != was) assert_int_equal(reason, WIRE_WRONG_VERSION);
        }
        bytes[at] = was;
    }
}

static void a_changed_byte_is_refused_or_another_legal_message(void **state)
{
    (void)state;
    for_each_encoding(6, change_everywhere);
}

/* Every aligned or unaligned word becomes a count that no message could have. */
static void claim_everywhere(wire_memory *memory, wire_kind kind, uint8_t *bytes, size_t size)
{
    static const uint8_t claims[][4] = {{0x7f, 0xff, 0xff, 0xff}, {0xff, 0xff, 0xff, 0xff}, {0x80, 0, 0, 0}};
    (void)kind;
    for (size_t at = 8; at + 4 <= size; at++)
        for (size_t k = 0; k < 3; k++) {
            uint8_t was[4];
            memcpy(was, bytes + at, 4);
            memcpy(bytes + at, claims[k], 4);
            decode(memory, bytes, size);
            memcpy(bytes + at, was, 4);
        }
}

static void a_huge_or_negative_count_takes_no_memory(void **state)
{
    (void)state;
    for_each_encoding(7, claim_everywhere);
}

static void invented_bytes_behind_a_fingerprint_are_safe(void **state)
{
    (void)state;
    sampler s = {.random = 8, .memory = wire_memory_create()};
    uint8_t bytes[200];
    for (int i = 0; i < INVENTED; i++) {
        size_t size = 8 + sample_below(&s, sizeof bytes - 8);
        for (size_t k = 0; k < size; k++) bytes[k] = sample_below(&s, 4) ? 0 : (uint8_t)sample_next(&s);
        wire_kind kind = (wire_kind)(1 + sample_below(&s, WIRE_KIND_COUNT - 1));
        uint64_t fingerprint = __builtin_bswap64((uint64_t)wire_lcm_fingerprint(kind));
        memcpy(bytes, &fingerprint, 8);
        bytes[11] = WIRE_VERSION;
        decode(s.memory, bytes, size);
    }
    wire_memory_destroy(s.memory);
}

/* Whose it was can be told from a message that was refused behind its keys. */
static void a_refused_message_tells_its_origin(void **state)
{
    (void)state;
    sampler s = {.random = 9, .memory = wire_memory_create()};
    wire_message m = sample_message(&s, WIRE_BODY, MOST), out;
    m.body.client = 0x1234;
    m.body.sequence = 77;
    m.body.body = 5;
    size_t size;
    uint8_t *bytes = encode(&m, &size);
    wire_refusal why;
    assert_int_equal(wire_lcm_decode(bytes, size - 1, s.memory, &out, &why), WIRE_MALFORMED);
    int64_t client, sequence;
    int32_t object;
    wire_origin(&out, &client, &sequence, &object);
    assert_int_equal(out.kind, WIRE_BODY);
    assert_int_equal(client, 0x1234);
    assert_int_equal(sequence, 77);
    assert_int_equal(object, 5);
    free(bytes);
    wire_memory_destroy(s.memory);
}

/* ---- the memory that messages are decoded into ---- */

static void memory_is_aligned_and_apart(void **state)
{
    (void)state;
    wire_memory *m = wire_memory_create();
    uint8_t *last = NULL;
    for (size_t size = 1; size < 400000; size = size * 3 / 2 + 1) {
        uint8_t *at = wire_memory_take(m, size);
        assert_int_equal((uintptr_t)at % 16, 0);
        memset(at, 0x5a, size);
        if (last) assert_int_equal(*last, 0x5a);
        *at = 0x5a;
        last = at;
    }
    wire_memory_destroy(m);
    wire_memory_destroy(NULL);
}

/* The same demand after a reset is met from the same blocks, whatever it is: nothing grows from message to message. */
static void after_a_reset_the_same_memory_is_handed_out(void **state)
{
    (void)state;
    static const size_t demand[] = {100, 70000, 8, 5 << 20, 65536, 1, 300000};
    enum { COUNT = sizeof demand / sizeof *demand };
    void *first[COUNT];
    wire_memory *m = wire_memory_create();
    for (int k = 0; k < COUNT; k++) first[k] = wire_memory_take(m, demand[k]);
    for (int round = 0; round < 1000; round++) {
        wire_memory_reset(m);
        for (int k = 0; k < COUNT; k++) assert_ptr_equal(wire_memory_take(m, demand[k]), first[k]);
    }
    wire_memory_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cut_or_lengthened_message_is_malformed),
        cmocka_unit_test(a_changed_byte_is_refused_or_another_legal_message),
        cmocka_unit_test(a_huge_or_negative_count_takes_no_memory),
        cmocka_unit_test(invented_bytes_behind_a_fingerprint_are_safe),
        cmocka_unit_test(a_refused_message_tells_its_origin),
        cmocka_unit_test(memory_is_aligned_and_apart),
        cmocka_unit_test(after_a_reset_the_same_memory_is_handed_out),
    };
    return cmocka_run_group_tests_name("wire_damage", tests, NULL, NULL);
}
