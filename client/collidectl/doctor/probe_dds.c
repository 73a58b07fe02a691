/* probe_dds: one RTPS message, written by hand (OMG RTPS 2.3: 8.3.3 header, 9.4.5.3 DATA, 9.6.2.2 parameters), since a
 * participant of Cyclone does not tell from which address another one speaks. */
#include "ear.h"
#include "probe.h"

#include <poll.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

enum { MESSAGE_MAX = 256, INDICES = 10, PREFIX = 12 };

typedef struct message {
    uint8_t bytes[MESSAGE_MAX];
    size_t size;
} message;

static void put_bytes(message *m, const void *bytes, size_t size)
{
    memcpy(m->bytes + m->size, bytes, size);
    m->size += size;
}

static void put_u16(message *m, unsigned value)
{
    put_bytes(m, (const uint8_t[]){(uint8_t)value, (uint8_t)(value >> 8)}, 2);
}

static void put_u32(message *m, uint32_t value)
{
    put_u16(m, value & 0xffff);
    put_u16(m, value >> 16);
}

static void put_locator(message *m, unsigned id, const struct sockaddr_in *here)
{
    put_u16(m, id);
    put_u16(m, 24);
    put_u32(m, 1); /* UDPv4 */
    put_u32(m, ntohs(here->sin_port));
    put_bytes(m, (const uint8_t[12]){0}, 12);
    put_bytes(m, &here->sin_addr, 4);
}

/* Header, then one DATA of the writer of participants, as a parameter list, little-endian. */
static message announcement(const struct sockaddr_in *here)
{
    message m = {.size = 0};
    uint8_t prefix[PREFIX];
    if (getrandom(prefix, sizeof prefix, 0) != sizeof prefix) memset(prefix, 7, sizeof prefix);
    put_bytes(&m, "RTPS\x02\x01\x00\x00", 8); /* version 2.1, vendor unknown */
    put_bytes(&m, prefix, PREFIX);
    put_bytes(&m, "\x15\x05\x00\x00", 4); /* DATA, little-endian with payload, up to the end of the message */
    put_bytes(&m, "\x00\x00\x10\x00", 4); /* no flags; 16 bytes to the payload */
    put_bytes(&m, "\x00\x00\x00\x00\x00\x01\x00\xc2", 8); /* to any reader, from the writer of participants */
    put_u32(&m, 0);
    put_u32(&m, 1);                                       /* sequence number */
    put_bytes(&m, "\x00\x03\x00\x00", 4);                 /* PL_CDR_LE */
    put_bytes(&m, "\x15\x00\x04\x00\x02\x01\x00\x00", 8); /* version */
    put_bytes(&m, "\x16\x00\x04\x00\x00\x00\x00\x00", 8); /* vendor */
    put_bytes(&m, "\x50\x00\x10\x00", 4);                 /* participant */
    put_bytes(&m, prefix, PREFIX);
    put_bytes(&m, "\x00\x00\x01\xc1", 4);
    put_bytes(&m, "\x58\x00\x04\x00\x03\x00\x00\x00", 8); /* it announces and detects participants, nothing else */
    put_bytes(&m, "\x02\x00\x08\x00\x01\x00\x00\x00\x00\x00\x00\x00", 12); /* lease 1 s */
    put_locator(&m, 0x32, here);                                           /* discovery by unicast */
    put_locator(&m, 0x31, here);                                           /* data by unicast */
    put_bytes(&m, "\x01\x00\x00\x00", 4);
    return m;
}

static bool open_at(int fd, struct in_addr from, struct sockaddr_in *here)
{
    socklen_t size = sizeof *here;
    *here = (struct sockaddr_in){.sin_family = AF_INET, .sin_addr = from};
    return bind(fd, (struct sockaddr *)here, sizeof *here) == 0 && getsockname(fd, (struct sockaddr *)here, &size) == 0;
}

static void send_announcement(int fd, const message *m, struct in_addr to, unsigned port, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        const struct sockaddr_in there = {
            .sin_family = AF_INET, .sin_port = htons((uint16_t)(port + 2 * i)), .sin_addr = to};
        sendto(fd, m->bytes, m->size, 0, (const struct sockaddr *)&there, sizeof there); /* silence tells */
    }
}

static bool hears_rtps(int fd, struct in_addr to, double seconds)
{
    struct pollfd p = {.fd = fd, .events = POLLIN};
    bool heard = false;
    for (double end = ear_now_s() + seconds, now; !heard && (now = ear_now_s()) < end;) {
        struct sockaddr_in who = {.sin_family = AF_INET};
        char packet[64];
        socklen_t size = sizeof who;
        if (poll(&p, 1, (int)(1000 * (end - now))) <= 0) break;
        ssize_t n = recvfrom(fd, packet, sizeof packet, MSG_DONTWAIT, (struct sockaddr *)&who, &size);
        heard = n >= 4 && memcmp(packet, "RTPS", 4) == 0 && who.sin_addr.s_addr == to.s_addr;
    }
    return heard;
}

bool probe_dds(struct in_addr from, struct in_addr to, unsigned domain, bool by_index, double seconds)
{
    struct sockaddr_in here;
    unsigned base = 7400 + 250 * domain;
    bool heard = false;
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return false;
    if (open_at(fd, from, &here)) {
        message m = announcement(&here);
        send_announcement(fd, &m, to, by_index ? base + 10 : base, by_index ? INDICES : 1);
        heard = hears_rtps(fd, to, seconds);
    }
    close(fd);
    return heard;
}

static bool is_rtps(int fd)
{
    char packet[64];
    return recv(fd, packet, sizeof packet, MSG_DONTWAIT) >= 4 && memcmp(packet, "RTPS", 4) == 0;
}

/* A socket each: by where an answer comes, one knows to which question. */
void probe_dds_domains(struct in_addr from, bool answers[PROBE_DOMAINS], double seconds)
{
    const struct in_addr group = {htonl(0xefff0001)}; /* 239.255.0.1 */
    struct pollfd p[PROBE_DOMAINS];
    for (unsigned d = 0; d < PROBE_DOMAINS; d++) {
        struct sockaddr_in here;
        answers[d] = false;
        p[d] = (struct pollfd){.fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0), .events = POLLIN};
        if (p[d].fd < 0 || !open_at(p[d].fd, from, &here)) continue;
        setsockopt(p[d].fd, IPPROTO_IP, IP_MULTICAST_IF, &from, sizeof from);
        message m = announcement(&here);
        send_announcement(p[d].fd, &m, group, 7400 + 250 * d, 1);
    }
    for (double end = ear_now_s() + seconds, now; (now = ear_now_s()) < end;) {
        if (poll(p, PROBE_DOMAINS, (int)(1000 * (end - now))) <= 0) break;
        for (unsigned d = 0; d < PROBE_DOMAINS; d++)
            if (p[d].revents) answers[d] |= is_rtps(p[d].fd);
    }
    for (unsigned d = 0; d < PROBE_DOMAINS; d++)
        if (p[d].fd >= 0) close(p[d].fd);
}
