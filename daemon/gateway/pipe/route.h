/* route: does LCM's multicast leave by the interface that it should? The daemon asks before it starts the gateway, and
 * the gateway before it opens a socket: a route can have changed in between. Any thread. */
#ifndef COLLIDED_PIPE_ROUTE_H
#define COLLIDED_PIPE_ROUTE_H

#include <net/if.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stddef.h>

/* The address and port of "udpm://ADDRESS:PORT..."; false if it has none. */
bool route_group(const char *url, struct sockaddr_in *group);

/* The name of an interface given by name or address; "" = loopback. False: there is none. */
bool route_interface(const char *interface, char name[IF_NAMESIZE]);

/* False: `why` says in one line where datagrams to the URL's group go instead, and how to mend it. */
bool route_leads_to(const char *url, const char *interface, char *why, size_t why_size);

#endif
