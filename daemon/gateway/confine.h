/* confine: what the gateway may still do once it runs: little, because one datagram can take it over. */
#ifndef COLLIDED_GATEWAY_CONFINE_H
#define COLLIDED_GATEWAY_CONFINE_H

#include <stdbool.h>
#include <stdint.h>

/* Does the multicast group of "udpm://ADDRESS:PORT..." lead to this interface (name or address; "" = loopback)? If not,
 * standard error says what to do. */
bool confine_route_is(const char *url, const char *interface);

/* False, with a line, if another program holds the port of the group and does not share it. */
bool confine_port_is_free(const char *url);

/* Binds all of this process's datagram sockets to the interface, so that what comes in by another one is not seen, and
 * has the kernel drop what is no datagram of LCM. liblcm has no such options, and listens on all addresses. */
bool confine_sockets(const char *interface);

/* Datagrams that came for these sockets and that they never got: see datagram_drops. */
uint32_t confine_drops(void);

/* Early: dies with the parent, no new privileges, no core files, few descriptors. */
void confine_process(void);
/* When all threads run: no new processes, and so much memory beyond what is in use. */
void confine_growth(void);

#endif
