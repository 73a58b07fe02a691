/* check_peer: firewalls. Between "the host is down", "nobody listens" and "it is dropped" one can tell as far as the
 * host answers at all: a closed port answers, an open one and a dropped packet do not. */
#include "commands.h"
#include "probe.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>

enum { PORT_CLOSED = 9 /* discard: hardly anybody listens there */, PORT_DDS = 7400, PORT_DOMAIN = 250 };
#define HOST_S 3.5 /* the kernel asks for an address by ARP three times, a second apart */
#define PORT_S 0.5
#define DDS_S 0.8

doctor_finding check_silence(doctor *d)
{
    if (d->over_lcm) return finding_ok("not needed: LCM announces nothing");
    if (!d->ear) return finding_unknown("%s", d->deaf);
    const ear *e = d->ear;
    if (d->daemon || !e->mute_participants)
        return finding_ok(
            "%zu other participant(s), of which %zu have no endpoints", e->participants, e->mute_participants);
    return finding_mend(
        finding_problem("%zu of %zu other participants announce themselves, and none of their endpoints is heard: a "
                        "firewall drops unicast UDP, here or there",
            e->mute_participants, e->participants),
        "iptables -I INPUT -i %s -p udp -j ACCEPT", d->interface.name);
}

/* ---- one host ---- */

static void address_text(struct in_addr address, char out[INET_ADDRSTRLEN])
{
    if (!inet_ntop(AF_INET, &address, out, INET_ADDRSTRLEN)) out[0] = '\0';
}

static doctor_finding nobody_listens(const doctor *d, const char *peer, unsigned port)
{
    char start[COMMAND_MAX];
    command_start(d, start);
    char *own = strstr(start, " --interface "); /* there it is another one */
    if (own) *own = '\0';
    return finding_mend(finding_problem("%s is up, and nobody listens on its UDP port %u: no daemon runs there, or not "
                                        "on that interface",
                            peer, port),
        "ssh %s %s --interface %s", peer, start, peer);
}

static doctor_finding refused_by_us(const char *peer)
{
    return finding_mend(finding_problem("this host's own firewall lets no UDP out to %s", peer),
        "iptables -I OUTPUT -d %s -p udp -j ACCEPT", peer);
}

static doctor_finding no_route(const doctor *d, const char *peer)
{
    return finding_mend(
        finding_problem("there is no route to %s", peer), "ip route add %s dev %s", peer, d->interface.name);
}

/* What a closed port answers, and what the daemon's. A host tells of few closed ports a second (icmp(7)), so the
 * question is put to as few as will do. */
static doctor_finding judge_ports(const doctor *d, const char *peer, struct in_addr to, unsigned port)
{
    char us[INET_ADDRSTRLEN];
    address_text(d->interface.address, us);
    bool up = probe_tcp(to, PORT_CLOSED, PORT_S) == PROBE_ANSWERED;
    probe_result closed = probe_udp(to, PORT_CLOSED, PORT_S), ours = probe_udp(to, (uint16_t)port, PORT_S);
    if (ours == PROBE_REFUSED && !d->over_lcm && probe_dds(d->interface.address, to, d->domain, true, DDS_S))
        return finding_ok("%s is heard, by unicast alone", peer);
    if (ours == PROBE_REFUSED) return nobody_listens(d, peer, port);
    if (closed == PROBE_REFUSED)
        return finding_mend(
            finding_problem("%s is up, and its UDP port %u, unlike a closed one, is silent: somebody listens whose "
                            "answers are dropped here, or that port is dropped there (then the same command there, "
                            "with -s %s)",
                peer, port, us),
            "iptables -I INPUT -s %s -p udp -j ACCEPT", peer);
    return finding_mend(
        finding_problem("%s %s: its firewall drops our UDP", peer,
            up ? "answers TCP, and not even a closed UDP port answers" : "is there, but answers neither TCP nor UDP"),
        "ssh %s iptables -I INPUT -s %s -p udp -j ACCEPT", peer, us);
}

/* It is heard. Is the rest of it? Discovery needs multicast as well. */
static doctor_finding judge_heard(const doctor *d, const char *peer)
{
    if (d->daemon || d->over_lcm || d->stranger) return finding_ok("%s is heard, and hears us", peer);
    if (d->ear && d->ear->participants) return finding_ok("%s has DDS participants and hears us", peer);
    return finding_mend(finding_problem("%s answers by unicast, but announcements by multicast do not get through: a "
                                        "firewall there or here, or a switch that does not pass them",
                            peer),
        "ssh %s iptables -I INPUT -d 224.0.0.0/4 -j ACCEPT", peer);
}

static bool is_heard(doctor *d, struct in_addr to)
{
    if (d->over_lcm) return d->ear && d->ear->peer_heard;
    doctor_progress(d, "asking %s for DDS participants", d->options.peer);
    return probe_dds(d->interface.address, to, d->domain, false, DDS_S);
}

doctor_finding check_peer(doctor *d)
{
    const char *peer = d->options.peer;
    struct in_addr to;
    lcm_group group = {.port = PORT_CLOSED};
    if (!*peer) return finding_ok("none was named by --peer");
    if (inet_pton(AF_INET, peer, &to) != 1) return finding_unknown("%s is no IPv4 address", peer);
    if (d->over_lcm && facts_lcm_group(d->address, &group) && group.ttl == 0)
        return finding_mend(finding_problem("LCM with ttl=0 does not leave this machine"),
            "collidectl doctor --peer %s --interface %s --connect 'lcm://udpm://%s:%u?ttl=1'", peer, d->interface.name,
            inet_ntoa(group.address), group.port);
    probe_result out = probe_udp(to, PORT_CLOSED, 0); /* what this host says at once */
    if (out == PROBE_NO_ROUTE) return no_route(d, peer);
    if (out == PROBE_FORBIDDEN) return refused_by_us(peer);
    if (is_heard(d, to)) return judge_heard(d, peer);
    doctor_progress(d, "%s is not heard; looking whether it is up", peer);
    if (probe_tcp(to, PORT_CLOSED, HOST_S) == PROBE_NO_HOST)
        return finding_mend(finding_problem("%s is down, or not on this network: it does not answer ARP", peer),
            "ping -c 3 %s   # until it answers: its power, cable and address", peer);
    return judge_ports(d, peer, to, d->over_lcm ? group.port : PORT_DDS + PORT_DOMAIN * d->domain);
}
