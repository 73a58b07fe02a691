/* confine: limits that the kernel holds the gateway to. One thread; called while the process starts. */
#include "confine.h"

#include "datagram_filter.h"
#include "pipe/route.h"

#include <errno.h>
#include <net/if.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

enum { DESCRIPTORS_MAX = 64 };
static const rlim_t growth_bytes = 1 << 30; /* liblcm queues whole messages without a limit in bytes */

bool confine_route_is(const char *url, const char *interface)
{
    char why[512];
    if (route_leads_to(url, interface, why, sizeof why)) return true;
    fprintf(stderr, "collided-lcm: %s\n", why);
    return false;
}

/* liblcm shares its port, as all programs of LCM do, and would only say "bind: Address already in use". */
bool confine_port_is_free(const char *url)
{
    struct sockaddr_in group;
    int fd = route_group(url, &group) ? socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0) : -1, yes = 1;
    if (fd < 0) return true; /* liblcm meets the same, and says so */
    group.sin_addr.s_addr = htonl(INADDR_ANY);
    bool free = setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
                bind(fd, (const struct sockaddr *)&group, sizeof group) == 0 || errno != EADDRINUSE;
    close(fd);
    if (!free)
        fprintf(stderr,
            "collided-lcm: UDP port %u is taken by a program that does not share it: end that program "
            "(ss -ulnp 'sport = :%u' names it), or use another port on all sides\n",
            ntohs(group.sin_port), ntohs(group.sin_port));
    return free;
}

static bool is_datagram_socket(int fd)
{
    int domain, type;
    socklen_t size = sizeof domain;
    return getsockopt(fd, SOL_SOCKET, SO_DOMAIN, &domain, &size) == 0 && domain == AF_INET &&
           getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_DGRAM;
}

bool confine_sockets(const char *interface)
{
    char name[IF_NAMESIZE];
    if (!route_interface(interface, name)) return false;
    for (int fd = 0; fd < DESCRIPTORS_MAX; fd++) {
        if (!is_datagram_socket(fd)) continue;
        if (setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, name, (socklen_t)strlen(name)) != 0) {
            fprintf(stderr, "collided-lcm: cannot bind to interface %s: %m\n", name);
            return false;
        }
        if (!datagram_filter_attach(fd)) {
            fprintf(stderr, "collided-lcm: the kernel takes no filter for datagrams: %m\n");
            return false;
        }
    }
    return true;
}

uint32_t confine_drops(void)
{
    uint32_t drops = 0;
    for (int fd = 0; fd < DESCRIPTORS_MAX; fd++)
        if (is_datagram_socket(fd)) drops += datagram_drops(fd);
    return drops;
}

static void limit(int resource, rlim_t value)
{
    struct rlimit now;
    if (getrlimit(resource, &now) != 0) return;
    rlim_t most = now.rlim_max == RLIM_INFINITY || value < now.rlim_max ? value : now.rlim_max;
    if (setrlimit(resource, &(struct rlimit){most, most}) != 0)
        fprintf(stderr, "collided-lcm: limit %d is not set: %m\n", resource);
}

void confine_process(void)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_NOFILE, DESCRIPTORS_MAX);
}

/* Address space in use, in bytes: the limit counts from there, because sanitizers reserve terabytes. */
static rlim_t memory_in_use(void)
{
    unsigned long pages = 0;
    FILE *f = fopen("/proc/self/statm", "re");
    if (!f) return 0;
    if (fscanf(f, "%lu", &pages) != 1) pages = 0; /* NOLINT(cert-err34-c): the kernel's own number */
    fclose(f);
    return (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE);
}

void confine_growth(void)
{
    limit(RLIMIT_NPROC, 0);
    rlim_t in_use = memory_in_use();
    if (in_use) limit(RLIMIT_AS, in_use + growth_bytes);
}
