/* probe: is a host up, and what becomes of datagrams to it? Ordinary sockets, no privileges: a closed UDP port answers
 * by ICMP, a closed TCP port by a reset; a dropped packet by nothing. One thread. */
#ifndef COLLIDED_DOCTOR_PROBE_H
#define COLLIDED_DOCTOR_PROBE_H

#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>

typedef enum probe_result {
    PROBE_ANSWERED, /* TCP: accepted or reset */
    PROBE_REFUSED,  /* UDP: nobody listens on that port */
    PROBE_SILENT,   /* UDP: somebody listens, or it was dropped; TCP: it was dropped */
    PROBE_NO_HOST,  /* a router, or nobody's answer to ARP: the host is not there */
    PROBE_NO_ROUTE,
    PROBE_FORBIDDEN /* this host's own firewall does not let it out */
} probe_result;

probe_result probe_udp(struct in_addr to, uint16_t port, double seconds);
probe_result probe_tcp(struct in_addr to, uint16_t port, double seconds);

/* "Is there a DDS participant?": announces one of ours (RTPS's SPDP), with a lease of one second, to that host, by
 * unicast, from `from`, an address of ours: to the port of the domain that all participants with multicast share; if
 * `by_index`, to the ports of the first ten participant indices instead. Who hears it answers. True: a packet of RTPS
 * came from `to` to us, so both directions are open. */
bool probe_dds(struct in_addr from, struct in_addr to, unsigned domain, bool by_index, double seconds);

/* The same question to everybody on the network of `from`, by the discovery multicast of each domain: marks those in
 * which somebody answers. */
enum { PROBE_DOMAINS = 231 };
void probe_dds_domains(struct in_addr from, bool answers[PROBE_DOMAINS], double seconds);

#endif
