/* A network of this process's own: nothing that a test sends can leave it. */
#include "harness.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <net/if.h>
#include <net/route.h>
#include <netinet/in.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

static bool write_file(const char *path, const char *text)
{
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (fd < 0) return false;
    bool ok = write(fd, text, strlen(text)) == (ssize_t)strlen(text);
    close(fd);
    return ok;
}

static bool loopback_up(void)
{
    struct ifreq request = {.ifr_flags = IFF_UP | IFF_LOOPBACK | IFF_RUNNING | IFF_MULTICAST};
    strcpy(request.ifr_name, "lo");
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool ok = ioctl(fd, SIOCSIFFLAGS, &request) == 0;
    close(fd);
    return ok;
}

bool netns_enter(void)
{
    char map[64];
    snprintf(map, sizeof map, "0 %u 1", (unsigned)getuid());
    bool ok = unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0 && write_file("/proc/self/uid_map", map) && loopback_up();
    if (!ok) printf("skipped: this system does not permit a network namespace (%m)\n");
    return ok;
}

static struct sockaddr address(const char *text)
{
    struct sockaddr_in in = {.sin_family = AF_INET};
    struct sockaddr generic;
    inet_pton(AF_INET, text, &in.sin_addr);
    memcpy(&generic, &in, sizeof generic);
    return generic;
}

bool netns_multicast_route(bool on)
{
    char device[] = "lo";
    struct rtentry route = {.rt_flags = RTF_UP,
        .rt_dev = device,
        .rt_dst = address("224.0.0.0"),
        .rt_genmask = address("240.0.0.0"),
        .rt_gateway = address("0.0.0.0")};
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool ok = ioctl(fd, on ? SIOCADDRT : SIOCDELRT, &route) == 0;
    close(fd);
    return ok;
}
