/* Messages as the first release with extensions wrote them, over LCM and over DDS, byte by byte (v1/messages.txt): each
 * later release reads them, and writes those of LCM again as they are. The file is never written anew: test_wire_kept
 * record FILE makes that of a later release. */
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
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { DOMAIN = 73, ROUNDS = 4, MOST = 3, BYTES_MAX = 1 << 16, LINE_MAX_BYTES = 4 * BYTES_MAX };

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

/* What Cyclone makes of a sample, by a writer and a reader of this process. To be unreferenced. */
static struct ddsi_serdata *as_written(wire_kind kind, const void *sample)
{
    static dds_entity_t writers[WIRE_KIND_COUNT], readers[WIRE_KIND_COUNT];
    struct ddsi_serdata *data = NULL;
    dds_sample_info_t info;
    if (!writers[kind]) {
        char name[WIRE_DDS_TOPIC_MAX];
        wire_dds_topic(kind, name);
        dds_entity_t topic = dds_create_topic(participant, wire_dds_descriptor(kind), name, NULL, NULL);
        dds_qos_t *qos = dds_create_qos();
        dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
        writers[kind] = dds_create_writer(participant, topic, qos, NULL);
        readers[kind] = dds_create_reader(participant, topic, qos, NULL);
        dds_delete_qos(qos);
    }
    assert_int_equal(dds_write(writers[kind], sample), 0);
    assert_int_equal(dds_takecdr(readers[kind], &data, 1, &info, DDS_ANY_STATE), 1);
    return data;
}

static const struct ddsi_sertype *type_of(wire_kind kind)
{
    static struct ddsi_serdata *any[WIRE_KIND_COUNT];
    void *sample = calloc(1, wire_dds_sample_size(kind));
    if (!any[kind]) any[kind] = as_written(kind, sample);
    free(sample);
    return any[kind]->type;
}

/* ---- writing such a file ---- */

static void print_hex(FILE *f, const uint8_t *bytes, size_t size)
{
    fputc(' ', f);
    for (size_t i = 0; i < size; i++) fprintf(f, "%02x", bytes[i]);
}

static void record_one(FILE *f, const wire_message *m)
{
    uint8_t lcm[BYTES_MAX];
    void *sample = calloc(1, wire_dds_sample_size(m->kind));
    ddsrt_iovec_t cdr;
    fprintf(f, "%s", wire_kind_name(m->kind));
    print_hex(f, lcm, wire_lcm_encode(m, lcm, sizeof lcm));
    wire_dds_encode(m, sample);
    struct ddsi_serdata *data = as_written(m->kind, sample);
    struct ddsi_serdata *held = ddsi_serdata_to_ser_ref(data, 0, ddsi_serdata_size(data), &cdr);
    print_hex(f, cdr.iov_base, cdr.iov_len);
    fputc('\n', f);
    ddsi_serdata_to_ser_unref(held, &cdr);
    ddsi_serdata_unref(data);
    free(sample);
}

static int record(const char *path)
{
    sampler s = {.random = 4, .memory = wire_memory_create()};
    FILE *f = fopen(path, "wx");
    if (!f || start(NULL) != 0) return 1;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++)
        for (int round = 0; round < ROUNDS; round++) {
            wire_message m = sample_message(&s, (wire_kind)kind, MOST);
            record_one(f, &m);
            wire_memory_reset(s.memory);
        }
    wire_memory_destroy(s.memory);
    return fclose(f) != 0 || stop(NULL) != 0;
}

/* ---- reading it ---- */

static size_t read_hex(const char *text, uint8_t *out)
{
    size_t size = 0;
    unsigned byte;
    for (; sscanf(text + 2 * size, "%2x", &byte) == 1; size++) {
        assert_true(size < BYTES_MAX);
        out[size] = (uint8_t)byte;
    }
    assert_int_equal(strlen(text), 2 * size);
    return size;
}

static void read_lcm(const uint8_t *bytes, size_t size, wire_memory *memory, const char *name, wire_message *out)
{
    static uint8_t again[BYTES_MAX];
    wire_refusal why;
    if (wire_lcm_decode(bytes, size, memory, out, &why) != WIRE_OK) fail_msg("%s over LCM: %s", name, why.text);
    assert_string_equal(wire_kind_name(out->kind), name);
    assert_int_equal(wire_lcm_encode(out, again, sizeof again), size);
    assert_memory_equal(again, bytes, size);
}

/* By Cyclone, which copies. */
static void read_dds(const uint8_t *bytes, size_t size, const wire_message *expected)
{
    const char *name = wire_kind_name(expected->kind);
    ddsrt_iovec_t all = {.iov_base = (void *)(uintptr_t)bytes, .iov_len = (ddsrt_iov_len_t)size};
    struct ddsi_serdata *data = ddsi_serdata_from_ser_iov(type_of(expected->kind), SDK_DATA, 1, &all, size);
    void *sample = dds_alloc(wire_dds_sample_size(expected->kind));
    wire_message m;
    wire_refusal why;
    memset(sample, 0, wire_dds_sample_size(expected->kind));
    if (!data || !ddsi_serdata_to_sample(data, sample, NULL, NULL)) fail_msg("%s over DDS: not of this type", name);
    if (wire_dds_decode(expected->kind, sample, &m, &why) != WIRE_OK) fail_msg("%s over DDS: %s", name, why.text);
    const char *differs = sample_difference(expected, &m);
    if (differs) fail_msg("%s: %s differs between LCM and DDS", name, differs);
    dds_sample_free(sample, wire_dds_descriptor(expected->kind), DDS_FREE_ALL);
    ddsi_serdata_unref(data);
}

static void messages_of_v1_are_read(void **state)
{
    (void)state;
    static char line[LINE_MAX_BYTES];
    static uint8_t by_lcm[BYTES_MAX], by_dds[BYTES_MAX]; /* messages borrow from these */
    int of_kind[WIRE_KIND_COUNT] = {0};
    wire_memory *memory = wire_memory_create();
    FILE *f = fopen(V1 "/messages.txt", "r");
    assert_non_null(f);
    while (fgets(line, sizeof line, f)) {
        wire_message m;
        const char *name = strtok(line, " \n"), *lcm = strtok(NULL, " \n"), *cdr = strtok(NULL, " \n");
        assert_true(name && lcm && cdr);
        read_lcm(by_lcm, read_hex(lcm, by_lcm), memory, name, &m);
        read_dds(by_dds, read_hex(cdr, by_dds), &m);
        of_kind[m.kind]++;
        wire_memory_reset(memory);
    }
    fclose(f);
    wire_memory_destroy(memory);
    for (int kind = WIRE_CLIENT; kind <= WIRE_ACK; kind++) assert_int_equal(of_kind[kind], ROUNDS);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(messages_of_v1_are_read)};
    if (argc == 3 && strcmp(argv[1], "record") == 0) return record(argv[2]);
    return cmocka_run_group_tests_name("wire_kept", tests, start, stop);
}
