/* facts_net: interfaces by getifaddrs, routes by netlink. */
#include "facts.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static facts_interface *entry(facts_interface *list, size_t *count, const char *name)
{
    for (size_t i = 0; i < *count; i++)
        if (strcmp(list[i].name, name) == 0) return &list[i];
    if (*count == FACTS_INTERFACES_MAX) return NULL;
    facts_interface *made = &list[(*count)++];
    *made = (facts_interface){.name = ""};
    snprintf(made->name, sizeof made->name, "%s", name);
    return made;
}

size_t facts_interfaces(facts_interface out[FACTS_INTERFACES_MAX])
{
    struct ifaddrs *all;
    size_t count = 0;
    if (getifaddrs(&all) != 0) return 0;
    for (struct ifaddrs *i = all; i; i = i->ifa_next) {
        facts_interface *f = entry(out, &count, i->ifa_name);
        if (!f) continue;
        f->up = i->ifa_flags & IFF_UP;
        f->running = i->ifa_flags & IFF_RUNNING;
        f->multicast = i->ifa_flags & IFF_MULTICAST;
        f->loopback = i->ifa_flags & IFF_LOOPBACK;
        if (!i->ifa_addr || i->ifa_addr->sa_family != AF_INET || f->address.s_addr) continue;
        struct sockaddr_in its;
        memcpy(&its, i->ifa_addr, sizeof its);
        f->address = its.sin_addr;
    }
    freeifaddrs(all);
    return count;
}

bool facts_find_interface(const char *text, facts_interface *out)
{
    facts_interface all[FACTS_INTERFACES_MAX];
    struct in_addr address;
    bool by_address = inet_pton(AF_INET, text, &address) == 1;
    size_t count = facts_interfaces(all);
    for (size_t i = 0; i < count; i++) {
        bool same = by_address ? all[i].address.s_addr == address.s_addr
                    : *text    ? strcmp(all[i].name, text) == 0
                               : all[i].loopback;
        if (!same) continue;
        *out = all[i];
        return true;
    }
    return false;
}

/* Asks the kernel for the route (rtnetlink(7)) and takes the interface out of its answer. */
bool facts_route(struct in_addr to, char name[IF_NAMESIZE])
{
    struct {
        struct nlmsghdr head;
        struct rtmsg route;
        struct rtattr attribute;
        struct in_addr to;
    } ask = {.head = {.nlmsg_len = sizeof ask, .nlmsg_type = RTM_GETROUTE, .nlmsg_flags = NLM_F_REQUEST},
        .route = {.rtm_family = AF_INET, .rtm_dst_len = 32},
        .attribute = {.rta_len = RTA_LENGTH(sizeof to), .rta_type = RTA_DST},
        .to = to};
    char answer[4096] __attribute__((aligned(NLMSG_ALIGNTO)));
    int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    ssize_t size =
        fd >= 0 && send(fd, &ask, sizeof ask, 0) == (ssize_t)sizeof ask ? recv(fd, answer, sizeof answer, 0) : -1;
    if (fd >= 0) close(fd);
    struct nlmsghdr *head = (struct nlmsghdr *)answer;
    if (size < 0 || !NLMSG_OK(head, (size_t)size) || head->nlmsg_type != RTM_NEWROUTE) return false;
    struct rtattr *a = RTM_RTA(NLMSG_DATA(head));
    for (size_t left = RTM_PAYLOAD(head); RTA_OK(a, left); a = RTA_NEXT(a, left)) {
        unsigned index;
        if (a->rta_type != RTA_OIF) continue;
        memcpy(&index, RTA_DATA(a), sizeof index);
        return if_indextoname(index, name) != NULL;
    }
    return false;
}

static long option(const char *address, const char *name, long otherwise)
{
    const char *at = strstr(address, name);
    return at ? strtol(at + strlen(name), NULL, 10) : otherwise;
}

bool facts_lcm_group(const char *address, lcm_group *out)
{
    const char *base = *address ? address : "udpm://239.255.76.67:7667";
    unsigned a, b, c, d, port;
    if (sscanf(base, "udpm://%3u.%3u.%3u.%3u:%5u", &a, &b, &c, &d, &port) != 5) return false; /* NOLINT(cert-err34-c) */
    if (a > 255 || b > 255 || c > 255 || d > 255 || port == 0 || port > 65535) return false;
    *out = (lcm_group){.address.s_addr = htonl(a << 24 | b << 16 | c << 8 | d),
        .port = (uint16_t)port,
        .ttl = (int)option(base, "ttl=", 0),
        .receive_bytes = option(base, "recv_buf_size=", 4194304)}; /* as the daemon and the client library ask */
    return a >= 224 && a < 240 && out->ttl >= 0 && out->ttl < 256;
}
