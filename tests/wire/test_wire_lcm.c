/* Our LCM encoding against lcm-gen's: the same fingerprints, the same bytes, the same values, in both directions. The
 * oracle is the C code that lcm-gen makes of collided.lcm. */
#include "sample.h"

#include "wire/wire_fields.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "collided_Ack.h"
#include "collided_Answer.h"
#include "collided_Body.h"
#include "collided_Client.h"
#include "collided_EventBatch.h"
#include "collided_Geometry.h"
#include "collided_PoseBatch.h"
#include "collided_Query.h"
#include "collided_Receipt.h"
#include "collided_Reject.h"
#include "collided_Status.h"
#include "collided_Subscription.h"
#include "collided_VertexBatch.h"

enum { ROUNDS = 300, MOST = 20 };

/* Where a field stands in lcm-gen's struct; its count, if it is an array. */
typedef struct place {
    size_t at, count;
} place;

#define SINGLE(S, field) {offsetof(S, field), SIZE_MAX},
#define ARRAY(S, field) {offsetof(S, field), offsetof(S, field##_n)},
#define PLACE_U8 SINGLE
#define PLACE_I32 SINGLE
#define PLACE_I64 SINGLE
#define PLACE_F64 SINGLE
#define PLACE_STRING SINGLE
#define PLACE_U8S ARRAY
#define PLACE_I32S ARRAY
#define PLACE_I64S ARRAY
#define PLACE_F64S ARRAY
#define PLACE_STRINGS ARRAY
#define PLACE(S, member, name, type, most, rule) PLACE_##type(S, name)
#define PLACES_OF(kind, member, name)                                                                                  \
    static const place member##_places[] = {WIRE_FIELDS_##member(PLACE, collided_##name)};
WIRE_MESSAGES(PLACES_OF)

typedef struct oracle {
    int64_t (*fingerprint)(void);
    int (*decode)(const void *buffer, int offset, int size, void *out);
    int (*encode)(void *buffer, int offset, int size, const void *in);
    int (*cleanup)(void *out);
    const place *places;
} oracle;

/* lcm-gen's functions, with their message as void pointers. */
#define CALLS_OF(kind, member, name)                                                                                   \
    static int decode_##member(const void *buffer, int offset, int size, void *out)                                    \
    {                                                                                                                  \
        return collided_##name##_decode(buffer, offset, size, out);                                                    \
    }                                                                                                                  \
    static int encode_##member(void *buffer, int offset, int size, const void *in)                                     \
    {                                                                                                                  \
        return collided_##name##_encode(buffer, offset, size, in);                                                     \
    }                                                                                                                  \
    static int cleanup_##member(void *out)                                                                             \
    {                                                                                                                  \
        return collided_##name##_decode_cleanup(out);                                                                  \
    }
WIRE_MESSAGES(CALLS_OF)

#define ORACLE_OF(kind, member, name)                                                                                  \
    [kind] = {__collided_##name##_get_hash, decode_##member, encode_##member, cleanup_##member, member##_places},
static const oracle oracles[WIRE_KIND_COUNT] = {WIRE_MESSAGES(ORACLE_OF)};

typedef union foreign { /* any of lcm-gen's structs */
#define MEMBER_OF(kind, member, name) collided_##name member;
    WIRE_MESSAGES(MEMBER_OF)
} foreign;

/* lcm-gen's struct as a plain message that borrows from it. */
static wire_message as_plain(wire_kind kind, const foreign *from)
{
    static const size_t bytes[] = {
        [WIRE_U8] = 1, [WIRE_I32] = 4, [WIRE_I64] = 8, [WIRE_F64] = 8, [WIRE_STRING] = sizeof(char *)};
    wire_message out = {.kind = kind};
    const wire_schema *s = wire_schema_of(kind);
    for (uint32_t i = 0; i < s->field_count; i++) {
        const place *p = &oracles[kind].places[i];
        char *to = (char *)&out.version + s->fields[i].offset;
        const char *at = (const char *)from + p->at;
        if (p->count == SIZE_MAX) {
            memcpy(to, at, bytes[s->fields[i].type]);
        } else {
            memcpy(to + offsetof(wire_f64s, count), (const char *)from + p->count, sizeof(uint32_t));
            memcpy(to + offsetof(wire_f64s, at), at, sizeof(void *));
        }
    }
    return out;
}

static void fingerprints_are_those_of_lcm_gen(void **state)
{
    (void)state;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++)
        assert_int_equal(wire_lcm_fingerprint((wire_kind)kind), oracles[kind].fingerprint());
}

static void kinds_are_told_by_their_fingerprint(void **state)
{
    (void)state;
    uint8_t bytes[8];
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        uint64_t big_endian = __builtin_bswap64((uint64_t)wire_lcm_fingerprint((wire_kind)kind));
        memcpy(bytes, &big_endian, sizeof bytes);
        assert_int_equal(wire_lcm_kind(bytes, sizeof bytes), kind);
        assert_int_equal(wire_lcm_kind(bytes, 7), WIRE_NOTHING);
        bytes[3] ^= 1;
        assert_int_equal(wire_lcm_kind(bytes, sizeof bytes), WIRE_NOTHING);
    }
}

static void check_both_ways(sampler *s, wire_kind kind)
{
    const oracle *o = &oracles[kind];
    wire_message m = sample_message(s, kind, MOST);
    size_t size = wire_lcm_size(&m);
    uint8_t *ours = malloc(size), *theirs = malloc(size);
    foreign f;
    assert_int_equal(wire_lcm_encode(&m, ours, size - 1), 0);
    assert_int_equal(wire_lcm_encode(&m, ours, size), size);
    assert_int_equal(o->decode(ours, 0, (int)size, &f), size);
    wire_message same = as_plain(kind, &f);
    assert_null(sample_difference(&m, &same));

    assert_int_equal(o->encode(theirs, 0, (int)size, &f), size);
    assert_memory_equal(ours, theirs, size);
    wire_message back;
    wire_refusal why;
    if (wire_lcm_decode(theirs, size, s->memory, &back, &why) != WIRE_OK)
        fail_msg("%s: %s", wire_kind_name(kind), why.text);
    assert_null(sample_difference(&m, &back));
    o->cleanup(&f);
    free(ours);
    free(theirs);
}

static void lcm_gen_reads_what_we_write_and_the_reverse(void **state)
{
    (void)state;
    sampler s = {.random = 1, .memory = wire_memory_create()};
    for (int round = 0; round < ROUNDS; round++)
        for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
            check_both_ways(&s, (wire_kind)kind);
            wire_memory_reset(s.memory);
        }
    wire_memory_destroy(s.memory);
}

/* A removed object needs no texts; a missing one is written as an empty one. */
static void missing_texts_are_empty_ones(void **state)
{
    (void)state;
    wire_message m = {WIRE_SUBSCRIPTION, .subscription = {WIRE_VERSION, 1, 2, 3, .removed = 1}}, back;
    wire_memory *memory = wire_memory_create();
    uint8_t bytes[256];
    wire_refusal why;
    size_t size = wire_lcm_encode(&m, bytes, sizeof bytes);
    assert_int_equal(size, wire_lcm_size(&m));
    assert_int_equal(wire_lcm_decode(bytes, size, memory, &back, &why), WIRE_OK);
    assert_string_equal(back.subscription.select_a, "");
    wire_memory_destroy(memory);
}

static void channels_are_named_by_kind_stream_and_client(void **state)
{
    (void)state;
    char channel[WIRE_CHANNEL_MAX];
    wire_lcm_channel(&(wire_message){WIRE_POSE_BATCH, .pose_batch = {.client = 7}}, channel);
    assert_string_equal(channel, "collided.in.PoseBatch");
    wire_lcm_channel(&(wire_message){WIRE_STATUS, .status = {.epoch = 7}}, channel);
    assert_string_equal(channel, "collided.out.Status");
    wire_lcm_channel(&(wire_message){WIRE_ANSWER, .answer = {.client = -2}}, channel);
    assert_string_equal(channel, "collided.out.Answer.fffffffffffffffe");
    wire_lcm_channel(&(wire_message){WIRE_ACK, .ack = {.client = 0x1f}}, channel);
    assert_string_equal(channel, "collided.out.Ack.000000000000001f");
    wire_lcm_channel(&(wire_message){WIRE_EVENT_BATCH, .event_batch = {.stream = "cell/near"}}, channel);
    assert_string_equal(channel, "collided.out.EventBatch.cell/near");
}

/* LCM carries 63 bytes: 39 of a stream's name fit, and the hash of a longer one. */
static void a_long_stream_has_the_channel_of_its_hash(void **state)
{
    (void)state;
    char longest[40], longer[41], channel[WIRE_CHANNEL_MAX], other[WIRE_CHANNEL_MAX];
    memset(longest, 's', 39);
    longest[39] = '\0';
    memset(longer, 's', 40);
    longer[40] = '\0';
    wire_lcm_stream_channel(longest, channel);
    assert_int_equal(strlen(channel), 63);
    assert_string_equal(channel + 24, longest);
    wire_lcm_stream_channel(longer, channel);
    longer[39] = 't';
    wire_lcm_stream_channel(longer, other);
    assert_int_equal(channel[24], '#');
    assert_int_equal(strlen(channel), 24 + 17);
    assert_string_not_equal(channel, other);
}

/* The hexdump of idl/README.md, as bytes. */
static size_t read_example(uint8_t *out, size_t capacity)
{
    char line[512];
    size_t size = 0;
    FILE *f = fopen(IDL_FOLDER "/README.md", "r");
    assert_non_null(f);
    while (fgets(line, sizeof line, f)) {
        unsigned offset, byte;
        int at, step;
        if (sscanf(line, "%8x %n", &offset, &at) != 1 || strncmp(line + 8, "  ", 2) != 0) continue;
        assert_int_equal(offset, size);
        for (; sscanf(line + at, "%2x %n", &byte, &step) == 1; at += step) {
            assert_true(size < capacity);
            out[size++] = (uint8_t)byte;
        }
    }
    fclose(f);
    return size;
}

static void the_example_of_the_protocol_page_is_real(void **state)
{
    (void)state;
    uint8_t told[256], real[256];
    wire_message m = {WIRE_POSE_BATCH,
        .pose_batch = {WIRE_VERSION, 0xc0111ded, 42, INT64_C(1700000000000000000), .bodies = {1, (const int32_t[]){3}},
            .positions = {3, (const double[]){0.5, 0, 1.25}}, .orientations = {4, (const double[]){1, 0, 0, 0}}}};
    size_t size = wire_lcm_encode(&m, real, sizeof real);
    assert_int_equal(read_example(told, sizeof told), size);
    assert_memory_equal(told, real, size);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fingerprints_are_those_of_lcm_gen),
        cmocka_unit_test(kinds_are_told_by_their_fingerprint),
        cmocka_unit_test(lcm_gen_reads_what_we_write_and_the_reverse),
        cmocka_unit_test(missing_texts_are_empty_ones),
        cmocka_unit_test(channels_are_named_by_kind_stream_and_client),
        cmocka_unit_test(a_long_stream_has_the_channel_of_its_hash),
        cmocka_unit_test(the_example_of_the_protocol_page_is_real),
    };
    return cmocka_run_group_tests_name("wire_lcm", tests, NULL, NULL);
}
