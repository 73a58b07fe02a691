/* storm_network: two hosts and what lies between them. The second host is a network namespace of its own; both have an
 * interface STORM_NET_INTERFACE, and a process that carries packets from one to the other, and loses some, holds some
 * back so that later ones overtake them, or carries none at all, as told. (`tc netem` would do, where the kernel has
 * it.) */
#ifndef COLLIDED_TESTS_FAULTS_STORM_NETWORK_H
#define COLLIDED_TESTS_FAULTS_STORM_NETWORK_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

#define STORM_NET_INTERFACE "net0"

typedef struct storm_network {                    /* in memory that is shared with that process */
    _Atomic int loss_percent, delay_most_ms, cut; /* both ways */
    _Atomic int ready;                            /* 1: it carries; -1: it cannot be */
    _Atomic int64_t carried, lost;
} storm_network;

/* In a network namespace that is ours (rig_isolate), before any thread. -1 after saying why not. */
pid_t storm_network_start(storm_network **n);
bool storm_network_enter(pid_t network); /* the second host becomes that of this process */

#endif
