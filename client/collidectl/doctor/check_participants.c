/* check_participants: on loopback DDS has no multicast, so that participants find each other on fixed ports, two for
 * each participant index: 7410 + 250 * domain + 2 * index (RTPS 2.3, 9.6.1.1). */
#include "checks.h"

enum { PORT_BASE = 7400, PORT_DOMAIN = 250, PORT_UNICAST = 10, NEAR = DDS_PARTICIPANTS * 9 / 10 };

doctor_finding check_participants(doctor *d)
{
    facts_ports ports;
    unsigned first = PORT_BASE + PORT_DOMAIN * d->domain + PORT_UNICAST, taken = 0;
    if (d->over_lcm) return finding_ok("not needed: LCM has none");
    if (*d->options.interface) return finding_ok("no limit: on %s they are found by multicast", d->options.interface);
    if (!facts_udp_ports(d->options.system_root, &ports)) return finding_unknown("/proc/net/udp cannot be read");
    for (unsigned i = 0; i < DDS_PARTICIPANTS; i++) taken += facts_port_used(&ports, first + 2 * i);
    if (d->ear && taken) taken--; /* our own */
    if (taken < NEAR)
        return finding_ok("%u of %d participants of domain %u on this host", taken, DDS_PARTICIPANTS, d->domain);
    doctor_finding f = finding_problem("%u of the %d participants that domain %u has room for on this host are taken",
        taken, DDS_PARTICIPANTS, d->domain);
    pid_t pid;
    char name[32];
    size_t held =
        facts_most_sockets(d->options.system_root, first, first + 2 * DDS_PARTICIPANTS - 1, &pid, name, sizeof name);
    if (!held) return finding_mend(f, "sudo collidectl doctor   # may see who holds them");
    return finding_mend(f, "kill %d   # %s, which holds %zu of their ports", (int)pid, name, held);
}
