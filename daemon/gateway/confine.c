/* confine: limits that the kernel holds the gateway to. One thread; called while the process starts. */
#include "confine.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/rtnetlink.h>
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

static bool group_of(const char *url, struct sockaddr_in *group)
{
    char address[64];
    unsigned port;
    *group = (struct sockaddr_in){.sin_family = AF_INET};
    if (sscanf(url, "udpm://%63[0-9.]:%u", address, &port) != 2 || port > 65535) return false;
    group->sin_port = htons((uint16_t)port);
    return inet_pton(AF_INET, address, &group->sin_addr) == 1;
}

/* Asks the kernel (rtnetlink) by which interface datagrams to that address leave. A connected socket's own address
 * would not tell: for multicast over loopback it stays 0.0.0.0. */
static bool ask_route(int fd, struct in_addr to, uint8_t *reply, size_t size, ssize_t *length)
{
    struct {
        struct nlmsghdr head;
        struct rtmsg route;
        struct rtattr attribute;
        struct in_addr to;
    } question = {
        .head = {.nlmsg_len = sizeof question, .nlmsg_type = RTM_GETROUTE, .nlmsg_flags = NLM_F_REQUEST},
        .route = {.rtm_family = AF_INET, .rtm_dst_len = 32},
        .attribute = {.rta_len = RTA_LENGTH(sizeof to), .rta_type = RTA_DST},
        .to = to,
    };
    if (send(fd, &question, sizeof question, 0) != (ssize_t)sizeof question) return false;
    *length = recv(fd, reply, size, 0);
    return *length > 0;
}

static void outgoing_interface(struct in_addr to, char name[IF_NAMESIZE])
{
    _Alignas(struct nlmsghdr) uint8_t reply[4096];
    ssize_t length = 0;
    int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    bool asked = fd >= 0 && ask_route(fd, to, reply, sizeof reply, &length);
    if (fd >= 0) close(fd);
    const struct nlmsghdr *head = (const struct nlmsghdr *)reply;
    if (!asked || !NLMSG_OK(head, (size_t)length) || head->nlmsg_type != RTM_NEWROUTE) return;
    struct rtattr *a = RTM_RTA(NLMSG_DATA(head));
    for (size_t left = RTM_PAYLOAD(head); RTA_OK(a, left); a = RTA_NEXT(a, left)) {
        int index;
        if (a->rta_type != RTA_OIF) continue;
        memcpy(&index, RTA_DATA(a), sizeof index);
        if_indextoname((unsigned)index, name);
    }
}

/* The interface that has this address. */
static bool interface_with(struct in_addr address, char name[IF_NAMESIZE])
{
    struct ifaddrs *all;
    if (getifaddrs(&all) != 0) return false;
    bool found = false;
    for (struct ifaddrs *i = all; i && !found; i = i->ifa_next) {
        if (!i->ifa_addr || i->ifa_addr->sa_family != AF_INET) continue;
        struct sockaddr_in its;
        memcpy(&its, i->ifa_addr, sizeof its);
        found = its.sin_addr.s_addr == address.s_addr;
        if (found) snprintf(name, IF_NAMESIZE, "%s", i->ifa_name);
    }
    freeifaddrs(all);
    return found;
}

/* The name of an interface given by name or address; "" = loopback. */
static bool interface_name(const char *interface, char name[IF_NAMESIZE])
{
    struct in_addr address;
    if (inet_pton(AF_INET, interface, &address) == 1) return interface_with(address, name);
    snprintf(name, IF_NAMESIZE, "%s", interface[0] ? interface : "lo");
    return if_nametoindex(name) != 0;
}

bool confine_route_is(const char *url, const char *interface)
{
    struct sockaddr_in group;
    char wanted[IF_NAMESIZE] = "", found[IF_NAMESIZE] = "none";
    if (!group_of(url, &group)) {
        fprintf(stderr, "collided-lcm: %s: expected udpm://ADDRESS:PORT\n", url);
        return false;
    }
    if (!interface_name(interface, wanted)) {
        fprintf(stderr, "collided-lcm: %s: no such network interface\n", interface);
        return false;
    }
    outgoing_interface(group.sin_addr, found);
    if (strcmp(found, wanted) == 0) return true;
    fprintf(stderr,
        "collided-lcm: multicast to %s leads to interface %s, not to %s; do: ip link set %s multicast on; "
        "ip route add 224.0.0.0/4 dev %s\n",
        inet_ntoa(group.sin_addr), found, wanted, wanted, wanted);
    return false;
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
    if (!interface_name(interface, name)) return false;
    for (int fd = 0; fd < DESCRIPTORS_MAX; fd++) {
        if (!is_datagram_socket(fd)) continue;
        if (setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, name, (socklen_t)strlen(name)) != 0) {
            fprintf(stderr, "collided-lcm: cannot bind to interface %s: %m\n", name);
            return false;
        }
    }
    return true;
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
    if (fscanf(f, "%lu", &pages) != 1) pages = 0;
    fclose(f);
    return (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE);
}

void confine_growth(void)
{
    limit(RLIMIT_NPROC, 0);
    rlim_t in_use = memory_in_use();
    if (in_use) limit(RLIMIT_AS, in_use + growth_bytes);
}
