/* RTPS by hand: a header of 20 bytes, then for whom it is, and one submessage, little-endian (RTPS 2.3, 8.3.7
 * and 9.4.5). It goes to all ports on loopback. */
#include "raw_rtps.h"

#include "rig.h"

#include <arpa/inet.h>
#include <dds/dds.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { DOMAIN = 61, HEARTBEAT = 0x07, GAP = 0x08, INFO_DESTINATION = 0x0e, FAR = 0x40000000 };

static bool is_own(const dds_builtintopic_endpoint_t *e)
{
    dds_entity_t all[16];
    int n = dds_lookup_participant(DOMAIN, all, 16);
    dds_guid_t guid;
    for (int i = 0; i < n && i < 16; i++)
        if (dds_get_guid(all[i], &guid) == DDS_RETCODE_OK && memcmp(&guid, &e->participant_key, sizeof guid) == 0)
            return true;
    return false;
}

static size_t read_endpoints(dds_entity_t reader, const char *topic, bool own, raw_guid out[RAW_GUIDS_MAX])
{
    void *samples[RAW_GUIDS_MAX] = {NULL};
    dds_sample_info_t infos[RAW_GUIDS_MAX];
    size_t count = 0;
    int n = dds_read_mask(reader, samples, infos, RAW_GUIDS_MAX, RAW_GUIDS_MAX, DDS_ALIVE_INSTANCE_STATE);
    for (int i = 0; i < n; i++) {
        const dds_builtintopic_endpoint_t *e = samples[i];
        if (!infos[i].valid_data || strcmp(e->topic_name, topic) != 0 || (!own && is_own(e))) continue;
        memcpy(out[count++].bytes, &e->key, sizeof out->bytes);
    }
    if (n > 0) dds_return_loan(reader, samples, n);
    return count;
}

static size_t find(dds_entity_t discovery, const char *topic, bool own, raw_guid out[RAW_GUIDS_MAX])
{
    dds_entity_t participant = dds_create_participant(DOMAIN, NULL, NULL);
    dds_entity_t reader = dds_create_reader(participant, discovery, NULL, NULL);
    assert_true(reader > 0);
    size_t count = 0;
    for (double end = rig_now_s() + RIG_PATIENCE_S; !count && rig_now_s() < end; usleep(5000))
        count = read_endpoints(reader, topic, own, out);
    dds_delete(participant);
    return count;
}

size_t raw_writers(const char *topic, bool own, raw_guid out[RAW_GUIDS_MAX])
{
    return find(DDS_BUILTIN_TOPIC_DCPSPUBLICATION, topic, own, out);
}

size_t raw_readers(const char *topic, bool own, raw_guid out[RAW_GUIDS_MAX])
{
    return find(DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, topic, own, out);
}

static void put32(uint8_t **at, uint32_t value)
{
    memcpy(*at, &value, sizeof value);
    *at += sizeof value;
}

/* To each port of this network namespace that somebody listens at. */
static void send_to_all(int out, const uint8_t *bytes, size_t size)
{
    char line[512];
    unsigned port;
    FILE *f = fopen("/proc/self/net/udp", "r");
    while (f && fgets(line, sizeof line, f)) {
        if (sscanf(line, " %*d: %*8x:%4x", &port) != 1) continue; /* NOLINT(cert-err34-c): the kernel's own number */
        struct sockaddr_in to = {
            .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
        (void)sendto(out, bytes, size, 0, (const struct sockaddr *)&to, sizeof to);
    }
    if (f) fclose(f);
}

static void forge(const raw_guid *writer, const raw_guid *reader, uint8_t kind)
{
    static uint32_t count = 1000000;
    uint8_t bytes[96] = {'R', 'T', 'P', 'S', 2, 1, 1, 16}, *at = bytes + 20;
    memcpy(bytes + 8, writer->bytes, 12);
    if (reader) { /* whom the rest is for */
        memcpy(at, (const uint8_t[]){INFO_DESTINATION, 1, 12, 0}, 4);
        memcpy(at + 4, reader->bytes, 12);
        at += 16;
    }
    *at++ = kind;
    *at++ = 1; /* little-endian */
    *at++ = kind == GAP ? 32 : 28;
    *at++ = 0;
    memcpy(at, reader ? reader->bytes + 12 : (const uint8_t[4]){0}, 4);
    memcpy(at + 4, writer->bytes + 12, 4);
    at += 8;
    put32(&at, 0);
    put32(&at, kind == GAP ? 1 : FAR); /* the gap's begin; the first number that is to be had */
    put32(&at, 0);
    put32(&at, FAR);                /* its end; the last number */
    if (kind == GAP) put32(&at, 1); /* and perhaps one more: the last word */
    put32(&at, count++);
    int out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    send_to_all(out, bytes, (size_t)(at - bytes));
    close(out);
}

void raw_forge_heartbeat(const raw_guid *writer, const raw_guid *reader)
{
    forge(writer, reader, HEARTBEAT);
}

void raw_forge_gap(const raw_guid *writer, const raw_guid *reader)
{
    forge(writer, reader, GAP);
}
