/* RTPS by hand: a header of 20 bytes, then submessages, little-endian. Submessage kinds and layouts: the RTPS 2.3
 * specification, 8.3.7 and 9.4.5. */
#include "rig.h"
#include "strangers.h"

#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { SEEN_MAX = 64, NAMES_MAX = 8, PACKET_MAX = 2048, ENTITIES = 48, SENT_LEAST = 1000 };
enum {
    ACKNACK = 0x06,
    HEARTBEAT = 0x07,
    GAP = 0x08,
    DATA = 0x15,
    LITTLE_ENDIAN_FLAG = 1,
    INLINE_FLAG = 2,
    DATA_FLAG = 4,
    KEY_FLAG = 8
};

typedef struct packet {
    uint16_t port;
    size_t size;
    uint8_t bytes[PACKET_MAX];
} packet;

static packet seen[SEEN_MAX];
static uint8_t names[NAMES_MAX][20]; /* headers: protocol, version, vendor, name of the participant */
static uint16_t ports[NAMES_MAX];
static size_t seen_count, name_count, port_count, sent_count;
static int out;

/* ---- listening ---- */

static void keep(const uint8_t *payload, size_t size, uint16_t port)
{
    size_t i = 0, p = 0;
    if (size < 20 || memcmp(payload, "RTPS", 4) != 0) return;
    while (i < name_count && memcmp(names[i] + 8, payload + 8, 12) != 0) i++;
    if (i == name_count && i < NAMES_MAX) memcpy(names[name_count++], payload, 20);
    while (p < port_count && ports[p] != port) p++;
    if (p == port_count && p < NAMES_MAX) ports[port_count++] = port;
    if (size > PACKET_MAX || seen_count == SEEN_MAX) return;
    packet *kept = &seen[seen_count++];
    kept->port = port;
    kept->size = size;
    memcpy(kept->bytes, payload, size);
}

/* For that time, and on until it has seen enough of both sides. */
static void listen_for(double seconds)
{
    static uint8_t bytes[65536];
    int in = socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, htons(ETH_P_IP));
    for (double end = rig_now_s() + seconds;
         rig_now_s() < end || (name_count < 2 && rig_now_s() < end + RIG_PATIENCE_S);) {
        ssize_t n = recv(in, bytes, sizeof bytes, 0);
        if (n < 0) usleep(500);
        size_t head = 4 * (size_t)(bytes[0] & 15);
        if (n < (ssize_t)head + 8 || bytes[9] != IPPROTO_UDP) continue;
        keep(bytes + head + 8, (size_t)n - head - 8, (uint16_t)(bytes[head + 2] << 8 | bytes[head + 3]));
    }
    close(in);
}

/* ---- sending ---- */

static void send_to(uint16_t port, const void *bytes, size_t size)
{
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    sent_count += sendto(out, bytes, size, 0, (const struct sockaddr *)&to, sizeof to) == (ssize_t)size;
}

static void put32(uint8_t **at, uint32_t value)
{
    memcpy(*at, &value, sizeof value);
    *at += sizeof value;
}

/* To all readers (0) or writers of one entity of the participant whose name is taken. */
static void forge(const uint8_t *name, uint8_t kind, uint32_t reader, uint32_t writer, uint32_t count)
{
    uint8_t bytes[128], *at = bytes + 20, *length;
    memcpy(bytes, name, 20);
    *at++ = kind;
    *at++ = LITTLE_ENDIAN_FLAG | (kind == DATA ? DATA_FLAG : 0);
    length = at;
    at += 2;
    if (kind == DATA) put32(&at, 16u << 16);
    put32(&at, htonl(reader));
    put32(&at, htonl(writer));
    put32(&at, 0); /* high half of: first number here, start of the gap, base of what was received, number */
    put32(&at, kind == GAP ? 1 : 0x40000000);
    if (kind != DATA) put32(&at, 0);
    if (kind == HEARTBEAT) put32(&at, 0x40000001);
    if (kind == GAP) put32(&at, 0x40000000);
    if (kind == GAP || kind == DATA) put32(&at, 0);
    if (kind == DATA) put32(&at, 0x01000000);
    put32(&at, count);
    uint16_t size = (uint16_t)(at - length - 2);
    memcpy(length, &size, sizeof size);
    for (size_t p = 0; p < port_count; p++) send_to(ports[p], bytes, (size_t)(at - bytes));
}

/* "I have left": a participant's announcement of itself (entity 0x0100c2, never protected) as disposed of. */
static void forge_farewell(const uint8_t *name, uint32_t number)
{
    static const uint8_t status[8] = {0x71, 0, 4, 0, 0, 0, 0, 3}, end[4] = {1, 0, 0, 0};
    uint8_t bytes[128], *at = bytes + 20, *length;
    memcpy(bytes, name, 20);
    *at++ = DATA;
    *at++ = LITTLE_ENDIAN_FLAG | INLINE_FLAG | KEY_FLAG;
    length = at;
    at += 2;
    put32(&at, 16u << 16);
    put32(&at, htonl(0x000100c7));
    put32(&at, htonl(0x000100c2));
    put32(&at, 0);
    put32(&at, number);
    put32(&at, 0x00100070); /* the key's hash: who has left */
    memcpy(at, name + 8, 12);
    memcpy(at + 12, (const uint8_t[]){0, 0, 1, 0xc1}, 4);
    memcpy(at + 16, status, 8);
    memcpy(at + 24, end, 4);
    at += 28;
    memcpy(at, (const uint8_t[]){0, 3, 0, 0, 0x50, 0, 16, 0}, 8); /* and its key as a parameter list */
    memcpy(at + 8, name + 8, 12);
    memcpy(at + 20, (const uint8_t[]){0, 0, 1, 0xc1}, 4);
    memcpy(at + 24, end, 4);
    at += 28;
    uint16_t size = (uint16_t)(at - length - 2);
    memcpy(length, &size, sizeof size);
    for (size_t p = 0; p < port_count; p++) send_to(ports[p], bytes, (size_t)(at - bytes));
}

static void forge_all(uint32_t count)
{
    for (size_t n = 0; n < name_count; n++) {
        forge_farewell(names[n], count);
        for (uint32_t e = 1; e <= ENTITIES; e++) {
            uint32_t keyed = e << 8 | 0x02, plain = e << 8 | 0x03, reader = e << 8 | 0x04;
            forge(names[n], HEARTBEAT, 0, plain, count);
            forge(names[n], HEARTBEAT, 0, keyed, count);
            forge(names[n], GAP, 0, plain, count);
            forge(names[n], DATA, 0, plain, count);
            forge(names[n], ACKNACK, reader, plain, count);
        }
        usleep(1000);
    }
}

static void send_copies(uint32_t turn)
{
    for (size_t i = 0; i < seen_count; i++) {
        packet p = seen[i];
        send_to(p.port, p.bytes, p.size);
        p.bytes[20 + (turn * 37 + i) % (p.size - 20)] ^= (uint8_t)(1u << turn % 8);
        send_to(p.port, p.bytes, p.size);
    }
}

int forger_runs(double seconds)
{
    out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    listen_for(0.5);
    uint32_t count = 1000000;
    double end = rig_now_s() + seconds;
    for (; rig_now_s() < end || (sent_count < SENT_LEAST && rig_now_s() < end + RIG_PATIENCE_S); count++) {
        forge_all(count);
        send_copies(count);
    }
    close(out);
    printf("forged %zu packets under %zu names to %zu ports\n", sent_count, name_count, port_count);
    return name_count >= 2 && sent_count >= SENT_LEAST ? 0 : 1;
}
