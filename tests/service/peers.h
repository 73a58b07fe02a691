/* peers: two daemons of a pair in one process: what they say to each other, in order, and at once; and their rounds, by
 * the test's own clock. One thread. */
#ifndef COLLIDED_TESTS_SERVICE_PEERS_H
#define COLLIDED_TESTS_SERVICE_PEERS_H

#include "link/link.h"
#include "link/peer.h"
#include "service/service.h"

/* One of the two from here on: its first link speaks to the other one. `ops` become those of that link and what is
 * needed for it, and outlive it. The clock of `s` is set. */
void peers_pair_up(service *s, link_ops *ops);
void peers_work(service *s);               /* where standby_round leaves a round to it: all that follows, with a tick */
bool peers_have_standby(const service *s); /* the active one says so */

size_t peers_most(void); /* bytes that one has said between two rounds of the other; from here on it is counted anew */

void peers_forget(void);              /* all of them */
void peers_die(const struct link *l); /* the other one hears that it is gone, and of what it said before */
/* The other one hears that it is lost, or back; it hears nothing of that itself. */
void peers_flicker(const struct link *l, bool alive);
void peers_deafen(const struct link *l, bool deaf); /* what is said to it is lost, but for announcements */
/* The network between them: each hears that the other one is lost, or back; what is said meanwhile is lost. */
void peers_part(bool parted);

#endif
