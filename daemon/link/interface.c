/* interface: getifaddrs. Any thread. */
#include "interface.h"

#include <arpa/inet.h>
#include <errno.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>

static bool address_of(const struct ifaddrs *i, char text[INET6_ADDRSTRLEN])
{
    const struct sockaddr *a = i->ifa_addr;
    if (!a || (a->sa_family != AF_INET && a->sa_family != AF_INET6)) return false;
    const void *bytes = a->sa_family == AF_INET
                            ? (const void *)&((const struct sockaddr_in *)(const void *)a)->sin_addr
                            : (const void *)&((const struct sockaddr_in6 *)(const void *)a)->sin6_addr;
    return inet_ntop(a->sa_family, bytes, text, INET6_ADDRSTRLEN) != NULL;
}

/* "lo (127.0.0.1), eth0 (10.0.0.5)": those with an address; what does not fit ends in "...". */
static void list(const struct ifaddrs *all, char *text, size_t size)
{
    char address[INET6_ADDRSTRLEN];
    size_t used = 0;
    text[0] = '\0';
    for (const struct ifaddrs *i = all; i; i = i->ifa_next) {
        if (!address_of(i, address)) continue;
        int n = snprintf(text + used, size - used, "%s%s (%s)", used ? ", " : "", i->ifa_name, address);
        if (n < 0 || (size_t)n >= size - used) {
            snprintf(text + used, size - used, "%s", "...");
            return;
        }
        used += (size_t)n;
    }
    if (!used) snprintf(text, size, "none with an address");
}

static bool has_address(const struct ifaddrs *all, const char *address)
{
    char text[INET6_ADDRSTRLEN];
    for (const struct ifaddrs *i = all; i; i = i->ifa_next)
        if (address_of(i, text) && strcmp(text, address) == 0) return true;
    return false;
}

bool interface_is_there(const char *interface, char *why, size_t why_size)
{
    char there[400];
    struct ifaddrs *all;
    if (!*interface || if_nametoindex(interface) != 0) return true;
    if (getifaddrs(&all) != 0) {
        snprintf(
            why, why_size, "interface = \"%.60s\": the interfaces cannot be listed: %s", interface, strerror(errno));
        return false;
    }
    bool found = has_address(all, interface);
    list(all, there, sizeof there);
    freeifaddrs(all);
    if (!found) snprintf(why, why_size, "interface = \"%.60s\": not on this machine: choose of %s", interface, there);
    return found;
}
