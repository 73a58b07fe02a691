/* ear_lcm: LCM's packets read from a socket of our own: liblcm 1.3.1 can be ended by a crafted datagram, and a doctor
 * should not catch what it looks for. Short messages only, as Status and small answers are; fragments are passed over.
 *
 * A packet: magic "LC02", sequence number (u32), the channel with its NUL, the data. */
#include "ear.h"
#include "facts.h"
#include "wire/wire_lcm.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { PACKET_MAX = 65536, HEADER = 8 };
static const uint32_t MAGIC_SHORT = 0x4c433032;

typedef struct ear_lcm {
    ear head;
    int socket;
    struct sockaddr_in group;
    struct in_addr peer; /* 0 = none */
    uint32_t packets;    /* sent */
    wire_memory *memory;
    uint8_t packet[PACKET_MAX];
} ear_lcm;

static void take_payload(ear_lcm *e, const char *channel, const uint8_t *data, size_t size, const char *from)
{
    wire_message m;
    wire_refusal why;
    wire_memory_reset(e->memory);
    wire_reason reason = wire_lcm_decode(data, size, e->memory, &m, &why);
    if (reason == WIRE_OK) {
        ear_message(&e->head, &m);
        return;
    }
    if (strcmp(channel, "collided.out.Status") != 0) return;
    if (wire_lcm_kind(data, size) != WIRE_STATUS)
        ear_strange(&e->head, "a daemon on %s sends Status under another fingerprint than ours", from);
    else if (reason == WIRE_WRONG_VERSION)
        ear_strange(
            &e->head, "a daemon on %s speaks version %d of the wire, not our %d", from, m.version, WIRE_VERSION);
    else
        ear_strange(&e->head, "a Status from %s is not well-formed: %.100s", from, why.text);
}

static void lcm_ear_poll(ear *head)
{
    ear_lcm *e = (ear_lcm *)head;
    struct sockaddr_in from = {.sin_family = AF_INET};
    socklen_t from_size = sizeof from;
    ssize_t n;
    while ((n = recvfrom(e->socket, e->packet, sizeof e->packet, MSG_DONTWAIT, (struct sockaddr *)&from, &from_size)) >=
           0) {
        uint32_t magic;
        const uint8_t *channel = e->packet + HEADER;
        if (n <= HEADER || (memcpy(&magic, e->packet, sizeof magic), ntohl(magic) != MAGIC_SHORT)) continue;
        const uint8_t *end = memchr(channel, '\0', (size_t)n - HEADER);
        if (!end) continue;
        char address[INET_ADDRSTRLEN];
        inet_ntop(AF_INET, &from.sin_addr, address, sizeof address);
        bool local = from.sin_addr.s_addr == htonl(INADDR_ANY); /* multicast on loopback has no source */
        e->head.peer_heard |= e->peer.s_addr != 0 && from.sin_addr.s_addr == e->peer.s_addr;
        take_payload(
            e, (const char *)channel, end + 1, (size_t)(e->packet + n - (end + 1)), local ? "this machine" : address);
        from_size = sizeof from;
    }
}

static bool lcm_ear_send(ear *head, const wire_message *query)
{
    ear_lcm *e = (ear_lcm *)head;
    uint8_t packet[4096];
    char channel[WIRE_CHANNEL_MAX];
    const uint32_t header[2] = {htonl(MAGIC_SHORT), htonl(e->packets++)};
    wire_lcm_channel(query, channel);
    size_t at = HEADER + strlen(channel) + 1;
    memcpy(packet, header, HEADER);
    memcpy(packet + HEADER, channel, at - HEADER);
    size_t size = wire_lcm_encode(query, packet + at, sizeof packet - at);
    return size && sendto(e->socket, packet, at + size, 0, (struct sockaddr *)&e->group, sizeof e->group) > 0;
}

static bool lcm_ear_ready(ear *head)
{
    (void)head; /* there is nothing to match */
    return true;
}

static bool lcm_ear_close(ear *head)
{
    ear_lcm *e = (ear_lcm *)head;
    if (e->socket >= 0) close(e->socket);
    if (e->memory) wire_memory_destroy(e->memory);
    free(e);
    return true;
}

static const ear_ops lcm_ear_ops = {
    .poll = lcm_ear_poll, .send = lcm_ear_send, .ready = lcm_ear_ready, .close = lcm_ear_close};

/* As liblcm does: the group's port is shared with all other programs, and the route chooses the interface. */
static bool open_socket(ear_lcm *e, const lcm_group *g)
{
    int one = 1;
    unsigned char ttl = (unsigned char)g->ttl;
    struct ip_mreq join = {.imr_multiaddr = g->address, .imr_interface.s_addr = htonl(INADDR_ANY)};
    struct sockaddr_in any = {.sin_family = AF_INET, .sin_port = htons(g->port)};
    e->group = any;
    e->group.sin_addr = g->address;
    e->socket = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    return e->socket >= 0 && setsockopt(e->socket, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one) == 0 &&
           setsockopt(e->socket, SOL_SOCKET, SO_REUSEPORT, &one, sizeof one) == 0 &&
           setsockopt(e->socket, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) == 0 &&
           bind(e->socket, (struct sockaddr *)&any, sizeof any) == 0 &&
           setsockopt(e->socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &join, sizeof join) == 0;
}

ear *ear_open_lcm(const ear_options *options, char *why, size_t why_size)
{
    lcm_group group;
    ear_lcm *e = calloc(1, sizeof *e);
    if (!e || !(e->memory = wire_memory_create())) {
        snprintf(why, why_size, "out of memory");
        free(e);
        return NULL;
    }
    e->head.ops = &lcm_ear_ops;
    e->socket = -1;
    if (inet_pton(AF_INET, options->peer, &e->peer) != 1) e->peer.s_addr = 0;
    if (facts_lcm_group(options->address, &group) && open_socket(e, &group)) return &e->head;
    snprintf(why, why_size, "LCM's group %s cannot be joined: %m", *options->address ? options->address : "of default");
    lcm_ear_close(&e->head);
    return NULL;
}
