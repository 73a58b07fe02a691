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

/* A socket, TURN_NOBODY, or TURN_NONE: more ask than the daemon has time to hear. */
static int connect_to_daemon(uint32_t domain)
{
    struct sockaddr_un address;
    socklen_t length = wire_dds_turn_address(domain, &address);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) return TURN_NOBODY;
    if (connect(fd, (struct sockaddr *)&address, length) == 0) {
        if (is_believed(fd)) return fd;
        errno = ECONNREFUSED;
    }
    int error = errno;
    (void)close(fd);
    return error == EAGAIN ? TURN_NONE : TURN_NOBODY;
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

/* So many bytes; fewer: the other end hung up; below 0: the time is over. */
static int hear(int fd, int64_t until_ns, char *words, int count)
{
    int heard = 0;
    while (heard < count) {
        if (!speaks(fd, until_ns)) return -1;
        ssize_t n = read(fd, words + heard, (size_t)(count - heard));
        if (n <= 0) break;
        heard += (int)n;
    }
    return heard;
}

static int fail_in_time(char *why, size_t why_size)
{
    (void)snprintf(why, why_size,
        "too many clients join at once: the daemon lets them in by turns, and ours did not come "
        "in time (connect_timeout_s)");
    return TURN_NONE;
}

int turn_ask(uint32_t domain, int64_t until_ns, turn_greeting *greeting, char *why, size_t why_size)
{
    *greeting = (turn_greeting){.room = 0};
    for (int again_ms = AGAIN_FIRST_MS; session_monotonic_ns() < until_ns;) {
        unsigned char words[WIRE_DDS_TURN_GREETING] = {0};
        int fd = connect_to_daemon(domain);
        if (fd == TURN_NOBODY) return TURN_NOBODY;
        int heard = fd < 0 ? 0 : hear(fd, until_ns, (char *)words, sizeof words);
        if (heard == sizeof words && words[0] == WIRE_DDS_TURN_WAIT) {
            *greeting = (turn_greeting){.crowd = words[1], .room = words[2]};
            return fd;
        }
        if (fd >= 0) (void)close(fd);
        if (fd >= 0 && heard >= 0 && heard < (int)sizeof words) return TURN_NOBODY; /* the daemon ended */
        (void)poll(NULL, 0, left_ms(until_ns, again_ms));
        if (again_ms < AGAIN_LAST_MS) again_ms *= 2;
    }
    return fail_in_time(why, why_size);
}

int turn_wait(int asked, int64_t until_ns, char *why, size_t why_size)
{
    char word;
    if (asked < 0) return asked;
    int heard = hear(asked, until_ns, &word, 1);
    if (heard == 1 && word == WIRE_DDS_TURN_COME) return asked;
    (void)close(asked);
    return heard < 0 ? fail_in_time(why, why_size) : TURN_NOBODY; /* the daemon ended */
}

void turn_knock(uint32_t domain, unsigned room)
{
    const char words[] = {WIRE_DDS_TURN_KNOCK, (char)room};
    int fd = connect_to_daemon(domain);
    if (fd < 0) return;
    ssize_t sent = send(fd, words, sizeof words, MSG_NOSIGNAL | MSG_DONTWAIT);
    (void)sent; /* it is said again */
    (void)close(fd);
}
