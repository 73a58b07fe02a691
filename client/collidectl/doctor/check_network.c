/* check_network: interface, multicast, route and receive buffers: what a host must have before anybody can be heard. */
#include "checks.h"

#include <stdio.h>
#include <string.h>

/* DDS's sockets ask for 1 MiB (Cyclone's default); LCM's for what the URI says, by default 4 MiB. */
#define DDS_RECEIVE_BYTES 1048576L

static void list_interfaces(char *out, size_t size)
{
    facts_interface all[FACTS_INTERFACES_MAX];
    size_t count = facts_interfaces(all), at = 0;
    out[0] = '\0';
    for (size_t i = 0; i < count && at < size; i++)
        if (all[i].up && all[i].address.s_addr)
            at += (size_t)snprintf(out + at, size - at, "%s%s", at ? ", " : "", all[i].name);
}

doctor_finding check_interface(doctor *d)
{
    const facts_interface *i = &d->interface;
    char others[256];
    list_interfaces(others, sizeof others);
    if (!*i->name && !*d->options.interface) return finding_problem("this machine has no loopback interface");
    if (!*i->name)
        return finding_mend(finding_problem("there is no interface %s; up are: %s", d->options.interface, others),
            "collidectl doctor --interface %.*s", (int)strcspn(others, ","), others);
    if (!i->up) return finding_mend(finding_problem("%s is down", i->name), "ip link set %s up", i->name);
    if (!i->running)
        return finding_mend(
            finding_problem("%s is up, but has no carrier: is the cable in, is the other end up?", i->name),
            "ip link show %s   # until it says LOWER_UP: its cable, its other end", i->name);
    if (!i->address.s_addr)
        return finding_mend(finding_problem("%s has no IPv4 address", i->name), "ip address add %s dev %s",
            i->loopback ? "127.0.0.1/8" : "ADDRESS/PREFIX", i->name);
    return finding_ok("%s is up%s", i->name, *d->options.interface ? "" : "; nothing leaves this machine");
}

doctor_finding check_multicast(doctor *d)
{
    const char *name = d->interface.name;
    if (!doctor_uses_lcm(d)) return finding_ok("not needed: the daemon has no LCM link");
    if (!*name) return finding_unknown("there is no such interface");
    if (d->interface.multicast) return finding_ok("%s does multicast", name);
    return finding_mend(finding_problem("%s does no multicast, so that LCM cannot send there", name),
        "ip link set %s multicast on", name);
}

doctor_finding check_route(doctor *d)
{
    const char *name = d->interface.name;
    lcm_group group;
    char to[IF_NAMESIZE];
    if (!doctor_uses_lcm(d)) return finding_ok("not needed: the daemon has no LCM link");
    if (!*name) return finding_unknown("there is no such interface");
    if (!facts_lcm_group(d->address, &group)) return finding_unknown("%s is no LCM address", d->address);
    bool routed = facts_route(group.address, to);
    if (routed && strcmp(to, name) == 0) return finding_ok("LCM's multicast leads to %s", name);
    doctor_finding f = routed ? finding_problem("LCM's multicast leads to %s, and the daemon's LCM is on %s", to, name)
                              : finding_problem("there is no route for LCM's multicast (224.0.0.0/4)");
    return finding_mend(f, "ip route replace 224.0.0.0/4 dev %s", name);
}

doctor_finding check_buffers(doctor *d)
{
    lcm_group group;
    long most = facts_number(d->options.system_root, "/proc/sys/net/core/rmem_max"), wanted = DDS_RECEIVE_BYTES;
    if (doctor_uses_lcm(d) && facts_lcm_group(d->address, &group) && group.receive_bytes > wanted)
        wanted = group.receive_bytes;
    if (most < 0) return finding_unknown("net.core.rmem_max cannot be read");
    if (most >= wanted) return finding_ok("net.core.rmem_max is %ld bytes; %ld are asked for", most, wanted);
    return finding_mend(
        finding_problem("net.core.rmem_max is %ld bytes, and %ld are asked for: bursts are lost", most, wanted),
        "sysctl -w net.core.rmem_max=%ld", wanted);
}
