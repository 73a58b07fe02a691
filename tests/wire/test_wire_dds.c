/* Messages of every kind through Cyclone itself: encoded, written, taken, decoded, and the same as before. One
 * participant on loopback, without multicast: nothing leaves the process. */
#include "one_participant.h"
#include "sample.h"

#include "wire_dds/wire_dds.h"
#include "wire_dds/wire_dds_qos.h"

#include <dds/dds.h>
#define asm __asm__ /* the next header is in GNU C */
#include <dds/ddsi/ddsi_serdata.h>
#undef asm

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { DOMAIN = 71, ROUNDS = 20, MOST = 20 };

static dds_entity_t participant;

static int start(void **state)
{
    (void)state;
    participant = one_participant(DOMAIN);
    return participant > 0 ? 0 : -1;
}

static int stop(void **state)
{
    (void)state;
    return dds_delete(DDS_CYCLONEDDS_HANDLE) == DDS_RETCODE_OK ? 0 : -1;
}

typedef struct path { /* of one kind: out and in again */
    dds_entity_t topic, writer, reader;
    void *sent;
} path;

static path open_path(wire_kind kind)
{
    char name[WIRE_DDS_TOPIC_MAX];
    const char *stream = kind == WIRE_EVENT_BATCH ? "a:b*c/d" : NULL;
    wire_dds_topic(kind, name);
    path p = {.sent = malloc(wire_dds_sample_size(kind))};
    p.topic = dds_create_topic(participant, wire_dds_descriptor(kind), name, NULL, NULL);
    dds_qos_t *out = wire_dds_qos(kind, WIRE_DDS_WRITER, stream, kind == WIRE_CLIENT ? DDS_SECS(1) : 0);
    dds_qos_t *in = wire_dds_qos(kind, WIRE_DDS_READER, stream, 0);
    p.writer = dds_create_writer(participant, p.topic, out, NULL);
    p.reader = dds_create_reader(participant, p.topic, in, NULL);
    dds_delete_qos(out);
    dds_delete_qos(in);
    assert_true(p.topic > 0 && p.writer > 0 && p.reader > 0);
    return p;
}

static void close_path(path *p)
{
    assert_int_equal(dds_delete(p->reader), 0);
    assert_int_equal(dds_delete(p->writer), 0);
    assert_int_equal(dds_delete(p->topic), 0);
    free(p->sent);
}

/* A reader in the same process has the sample when the write returns. */
static void send_and_take(const path *p, const wire_message *m)
{
    void *taken = NULL;
    dds_sample_info_t info;
    wire_message back;
    wire_refusal why;
    wire_dds_encode(m, p->sent);
    assert_int_equal(dds_write(p->writer, p->sent), 0);
    assert_int_equal(dds_take(p->reader, &taken, &info, 1, 1), 1);
    assert_true(info.valid_data);
    if (wire_dds_decode(m->kind, taken, &back, &why) != WIRE_OK) fail_msg("%s: %s", wire_kind_name(m->kind), why.text);
    const char *differs = sample_difference(m, &back);
    if (differs) fail_msg("%s: %s differs", wire_kind_name(m->kind), differs);
    assert_int_equal(dds_return_loan(p->reader, &taken, 1), 0);
}

static void every_kind_comes_back_as_it_was(void **state)
{
    (void)state;
    sampler s = {.random = 2, .memory = wire_memory_create()};
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        path p = open_path((wire_kind)kind);
        for (int round = 0; round < ROUNDS; round++) {
            wire_message m = sample_message(&s, (wire_kind)kind, MOST);
            send_and_take(&p, &m);
            wire_memory_reset(s.memory);
        }
        close_path(&p);
    }
    wire_memory_destroy(s.memory);
}

/* Where they lie, aligned as Cyclone has them; and cut off anywhere, in memory that ends there. */
static void decode_cut(wire_kind kind, const char *bytes, size_t size, const wire_message *sent)
{
    for (size_t length = 0; length <= size; length += length + 9 < size ? 1 + length / 4 : 1) {
        char *room = malloc(length + 4), *copy = room + 4; /* the header is not aligned, so that what follows is */
        wire_message back;
        wire_reason reason = WIRE_OK;
        wire_refusal why;
        if (length) memcpy(copy, bytes, length);
        bool told = wire_dds_decode_bytes(kind, copy, length, &back, &reason, &why);
        const char *differs = told ? sample_difference(sent, &back) : NULL;
        if (told && (reason != WIRE_OK || differs)) fail_msg("%zu of %zu bytes: %s", length, size, differs);
        if (length + 4 < size) assert_false(told); /* there may be padding at the end */
        if (length == size) assert_true(told);
        if (told) copy[1] ^= 1; /* the other byte order is Cyclone's business, ... */
        if (told) assert_false(wire_dds_decode_bytes(kind, copy, length, &back, &reason, &why));
        free(room);
    }
}

static void bytes_are_decoded_where_they_lie(void **state)
{
    (void)state;
    static const wire_kind kinds[] = {WIRE_POSE_BATCH, WIRE_VERTEX_BATCH, WIRE_BODY};
    sampler s = {.random = 3, .memory = wire_memory_create()};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        path p = open_path(kinds[k]);
        for (int round = 0; round < ROUNDS; round++) {
            wire_message m = sample_message(&s, kinds[k], MOST), back;
            struct ddsi_serdata *data = NULL;
            dds_sample_info_t info;
            ddsrt_iovec_t bytes;
            wire_reason reason;
            wire_refusal why;
            wire_dds_encode(&m, p.sent);
            assert_int_equal(dds_write(p.writer, p.sent), 0);
            assert_int_equal(dds_takecdr(p.reader, &data, 1, &info, DDS_ANY_STATE), 1);
            struct ddsi_serdata *held = ddsi_serdata_to_ser_ref(data, 0, ddsi_serdata_size(data), &bytes);
            if (kinds[k] == WIRE_BODY) /* ... as are texts */
                assert_false(wire_dds_decode_bytes(kinds[k], bytes.iov_base, bytes.iov_len, &back, &reason, &why));
            else
                decode_cut(kinds[k], bytes.iov_base, bytes.iov_len, &m);
            ddsi_serdata_to_ser_unref(held, &bytes);
            ddsi_serdata_unref(data);
            wire_memory_reset(s.memory);
        }
        close_path(&p);
    }
    wire_memory_destroy(s.memory);
}

static void what_is_not_legal_is_refused(void **state)
{
    (void)state;
    wire_message m = {WIRE_CLIENT, .client = {WIRE_VERSION + 1, 1, 1, .name = "n", .lease_ns = 1}}, back;
    wire_refusal why;
    void *sample = malloc(wire_dds_sample_size(WIRE_CLIENT));
    wire_dds_encode(&m, sample);
    assert_int_equal(wire_dds_decode(WIRE_CLIENT, sample, &back, &why), WIRE_WRONG_VERSION);
    assert_int_equal(back.client.client, 1); /* whose it was can be told */
    m.client.version = WIRE_VERSION;
    m.client.name = NULL;
    wire_dds_encode(&m, sample);
    assert_int_equal(wire_dds_decode(WIRE_CLIENT, sample, &back, &why), WIRE_OK);
    assert_string_equal(back.client.name, "");
    free(sample);
}

static void no_kind_has_no_descriptor(void **state)
{
    (void)state;
    assert_null(wire_dds_descriptor(WIRE_NOTHING));
    assert_null(wire_dds_descriptor(WIRE_KIND_COUNT));
    assert_int_equal(wire_dds_sample_size(WIRE_KIND_COUNT), 0);
    assert_null(wire_dds_profile_of(WIRE_NOTHING));
}

/* '*', '?' and ',' mean something in a partition; '%' would let two streams share one. */
static void a_stream_cannot_match_another_ones_partition(void **state)
{
    (void)state;
    char partition[WIRE_DDS_PARTITION_MAX];
    wire_dds_partition("cell/near-1_b.c", partition);
    assert_string_equal(partition, "stream:cell/near-1_b.c");
    wire_dds_partition("a*?,%:", partition);
    assert_string_equal(partition, "stream:a%2A%3F%2C%25%3A");
    char longest[WIRE_NAME_MAX + 1];
    memset(longest, '*', WIRE_NAME_MAX);
    longest[WIRE_NAME_MAX] = '\0';
    wire_dds_partition(longest, partition);
    assert_int_equal(strlen(partition), 7 + 3 * WIRE_NAME_MAX);
}

static void an_interface_is_put_into_the_configuration_or_refused(void **state)
{
    (void)state;
    char config[4096];
    assert_true(wire_dds_config(config, sizeof config, "eth0", WIRE_DDS_DAEMON));
    assert_non_null(strstr(config, "<NetworkInterface name=\"eth0\"/>"));
    assert_non_null(strstr(config, "<WriteBatch>true</WriteBatch>"));
    assert_true(wire_dds_config(config, sizeof config, "10.0.0.1", WIRE_DDS_ANYBODY));
    assert_non_null(strstr(config, "<NetworkInterface address=\"10.0.0.1\"/>"));
    assert_true(wire_dds_config(config, sizeof config, NULL, WIRE_DDS_ANYBODY));
    assert_non_null(strstr(config, "<AllowMulticast>false</AllowMulticast>"));
    assert_non_null(strstr(config, "<ParticipantIndex>auto</ParticipantIndex>"));
    assert_true(wire_dds_config(config, sizeof config, NULL, WIRE_DDS_CLIENT_LIBRARY));
    assert_non_null(strstr(config, "<ParticipantIndex>none</ParticipantIndex>"));
    assert_false(wire_dds_config(config, sizeof config, "\"/><x a=\"", WIRE_DDS_ANYBODY));
    assert_false(wire_dds_config(config, 100, "", WIRE_DDS_ANYBODY));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_comes_back_as_it_was),
        cmocka_unit_test(bytes_are_decoded_where_they_lie),
        cmocka_unit_test(what_is_not_legal_is_refused),
        cmocka_unit_test(no_kind_has_no_descriptor),
        cmocka_unit_test(a_stream_cannot_match_another_ones_partition),
        cmocka_unit_test(an_interface_is_put_into_the_configuration_or_refused),
    };
    return cmocka_run_group_tests_name("wire_dds", tests, start, stop);
}
