/* probe: connected sockets, which learn of ICMP errors. */
#include "probe.h"

#include <errno.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

static probe_result result_of(int error)
{
    switch (error) {
    case ECONNREFUSED:
        return PROBE_REFUSED;
    case EHOSTUNREACH:
    case EHOSTDOWN:
        return PROBE_NO_HOST;
    case ENETUNREACH:
    case ENETDOWN:
        return PROBE_NO_ROUTE;
    case EPERM:
    case EACCES:
        return PROBE_FORBIDDEN;
    default:
        return PROBE_SILENT;
    }
}

/* The socket's own error, if one comes in time. */
static int wait_for_error(int fd, short events, double seconds, bool *answered)
{
    struct pollfd p = {.fd = fd, .events = events};
    int error = 0;
    socklen_t size = sizeof error;
    if (poll(&p, 1, (int)(1000 * seconds)) <= 0) return 0;
    getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
    *answered = true;
    return error;
}

probe_result probe_udp(struct in_addr to, uint16_t port, double seconds)
{
    const struct sockaddr_in there = {.sin_family = AF_INET, .sin_port = htons(port), .sin_addr = to};
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0), error = 0;
    bool answered = false;
    if (fd < 0) return PROBE_SILENT;
    if (connect(fd, (const struct sockaddr *)&there, sizeof there) != 0 || send(fd, "", 1, 0) < 0)
        error = errno;
    else
        error = wait_for_error(fd, POLLIN, seconds, &answered);
    close(fd);
    return result_of(error);
}

probe_result probe_tcp(struct in_addr to, uint16_t port, double seconds)
{
    const struct sockaddr_in there = {.sin_family = AF_INET, .sin_port = htons(port), .sin_addr = to};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), error = 0;
    bool answered = false;
    if (fd < 0) return PROBE_SILENT;
    if (connect(fd, (const struct sockaddr *)&there, sizeof there) == 0)
        answered = true;
    else if (errno != EINPROGRESS)
        error = errno;
    else
        error = wait_for_error(fd, POLLOUT, seconds, &answered);
    close(fd);
    if (error == ECONNREFUSED || (answered && error == 0)) return PROBE_ANSWERED;
    return result_of(error);
}
