/* facts: what this system says of its network and its processes, read from the kernel and from proc/. Reads only; any
 * thread. */
#ifndef COLLIDED_DOCTOR_FACTS_H
#define COLLIDED_DOCTOR_FACTS_H

#include <net/if.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/* ---- interfaces ---- */

typedef struct facts_interface {
    char name[IF_NAMESIZE];
    struct in_addr address; /* its first IPv4 address; 0 = none */
    bool up, running, multicast, loopback;
} facts_interface;

enum { FACTS_INTERFACES_MAX = 32 };
size_t facts_interfaces(facts_interface out[FACTS_INTERFACES_MAX]);
/* By name or IPv4 address; "" = loopback. False: there is none. */
bool facts_find_interface(const char *text, facts_interface *out);
/* The interface by which datagrams to that address leave; false: there is no route. */
bool facts_route(struct in_addr to, char name[IF_NAMESIZE]);

/* ---- LCM ---- */

typedef struct lcm_group {
    struct in_addr address;
    uint16_t port;
    int ttl;
    long receive_bytes; /* that its sockets ask for */
} lcm_group;
/* "udpm://ADDRESS:PORT?OPTIONS" or "" for the default; false: it is not of that form. */
bool facts_lcm_group(const char *address, lcm_group *out);

/* ---- sockets and processes; `root`: where proc/ lies, "" = / ---- */

/* Marks the local ports of all UDP sockets of this network namespace; false: proc/net/udp cannot be read. */
typedef struct facts_ports {
    uint8_t used[65536 / 8];
} facts_ports;
bool facts_udp_ports(const char *root, facts_ports *out);
bool facts_port_used(const facts_ports *ports, unsigned port);

/* Of the processes that may be looked into, the one that holds most UDP sockets with a local port from..to; their
 * number, 0 = none. */
size_t facts_most_sockets(const char *root, unsigned from, unsigned to, pid_t *pid, char *name, size_t name_size);

/* A process of that name in our network namespace, other than `except`; 0 = none that we may look into. */
pid_t facts_process(const char *root, const char *name, pid_t except);

long facts_number(const char *root, const char *path); /* -1: it cannot be read */

#endif
