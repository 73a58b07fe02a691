/* route: rtnetlink's word on where multicast goes. Any thread. */
#include "route.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/rtnetlink.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

bool route_group(const char *url, struct sockaddr_in *group)
{
    char address[64];
    unsigned port;
    int end = 0;
    *group = (struct sockaddr_in){.sin_family = AF_INET};
    /* NOLINTNEXTLINE(cert-err34-c): five digits are no overflow */
    if (sscanf(url, "udpm://%63[0-9.]:%5u%n", address, &port, &end) != 2 || port > 65535) return false;
    if (url[end] && url[end] != '?') return false; /* what follows a '?' is liblcm's */
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
bool route_interface(const char *interface, char name[IF_NAMESIZE])
{
    struct in_addr address;
    if (inet_pton(AF_INET, interface, &address) == 1) return interface_with(address, name);
    snprintf(name, IF_NAMESIZE, "%s", interface[0] ? interface : "lo");
    return if_nametoindex(name) != 0;
}

bool route_leads_to(const char *url, const char *interface, char *why, size_t why_size)
{
    struct sockaddr_in group;
    char wanted[IF_NAMESIZE] = "", found[IF_NAMESIZE] = "none", address[INET_ADDRSTRLEN];
    if (!route_group(url, &group)) {
        snprintf(why, why_size, "%s: expected udpm://ADDRESS:PORT", url);
        return false;
    }
    if (!route_interface(interface, wanted)) {
        snprintf(why, why_size, "%s: no such network interface", interface);
        return false;
    }
    outgoing_interface(group.sin_addr, found);
    if (strcmp(found, wanted) == 0) return true;
    snprintf(why, why_size,
        "multicast to %s leads to interface %s, not to %s: do: ip link set %s multicast on; "
        "ip route add 224.0.0.0/4 dev %s",
        inet_ntop(AF_INET, &group.sin_addr, address, sizeof address), found, wanted, wanted, wanted);
    return false;
}
