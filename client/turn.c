/* Only he is believed who could as well run the daemon for us: root, this user, or an account of the system. Anybody
 * else who listens there could let us wait for ever. */
#include "turn.h"

#include "session.h"
#include "wire_dds/wire_dds_turn.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <unistd.h>

/* Hundreds that ask again ten times a second take half a processor. */
enum { SYSTEM_USER_LAST = 999, AGAIN_FIRST_MS = 100, AGAIN_LAST_MS = 1600 };

static bool is_believed(int fd)
{
    struct ucred who;
    socklen_t size = sizeof who;
    if (getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &size) != 0) return false;
    return who.uid <= SYSTEM_USER_LAST || who.uid == geteuid();
}

static int ask_for_turn(uint32_t domain)
{
    struct sockaddr_un address;
    socklen_t length = wire_dds_turn_address(domain, &address);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    if (connect(fd, (struct sockaddr *)&address, length) == 0) {
        if (is_believed(fd)) return fd;
        errno = ECONNREFUSED;
    }
    int error = errno;
    (void)close(fd);
    return error == EAGAIN ? TURN_FULL : TURN_NOBODY;
}

static int left_ms(int64_t until_ns, int most)
{
    int64_t left = (until_ns - session_monotonic_ns()) / NS_PER_MS;
    return left < 0 ? 0 : left < most ? (int)left + 1 : most;
}

static bool speaks(int fd, int64_t until_ns)
{
    struct pollfd p = {.fd = fd, .events = POLLIN};
    int ready;
    do ready = poll(&p, 1, left_ms(until_ns, INT32_MAX - 1));
    while (ready < 0 && errno == EINTR);
    return ready > 0;
}

/* The next word; 0: none any more; -1: the time is over. */
static int hear(int fd, int64_t until_ns)
{
    char word;
    if (!speaks(fd, until_ns)) return -1;
    return read(fd, &word, 1) == 1 ? word : 0;
}

int turn_ask(uint32_t domain, int64_t until_ns, bool *crowd)
{
    char words[2] = {0};
    int fd = ask_for_turn(domain);
    ssize_t count = fd >= 0 && speaks(fd, until_ns) ? recv(fd, words, sizeof words, MSG_PEEK) : 0;
    bool twice = count == 2 && words[0] == WIRE_DDS_TURN_WAIT && words[1] == WIRE_DDS_TURN_WAIT;
    *crowd = fd == TURN_FULL || twice || (count > 0 && words[0] == WIRE_DDS_TURN_FULL);
    return fd;
}

int turn_wait(uint32_t domain, int asked, int64_t until_ns, char *why, size_t why_size)
{
    int fd = asked;
    for (int again_ms = AGAIN_FIRST_MS;;) {
        int word = WIRE_DDS_TURN_FULL;
        if (fd == TURN_NOBODY) return TURN_NOBODY;
        if (fd >= 0) do
                word = hear(fd, until_ns);
            while (word == WIRE_DDS_TURN_WAIT);
        if (word == WIRE_DDS_TURN_COME) return fd;
        if (fd >= 0) (void)close(fd);
        if (word == 0) return TURN_NOBODY; /* the daemon ended */
        if (word == WIRE_DDS_TURN_FULL) (void)poll(NULL, 0, left_ms(until_ns, again_ms));
        if (again_ms < AGAIN_LAST_MS) again_ms *= 2;
        if (session_monotonic_ns() >= until_ns) break;
        fd = ask_for_turn(domain);
    }
    (void)snprintf(why, why_size,
        "too many clients join at once: the daemon lets them in by turns, and ours did not come "
        "in time (connect_timeout_s)");
    return TURN_NONE;
}
