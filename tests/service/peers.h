/* peers: what two daemons of a pair say to each other, in one process: in order, and at once. One thread. */
#ifndef COLLIDED_TESTS_SERVICE_PEERS_H
#define COLLIDED_TESTS_SERVICE_PEERS_H

#include "link/link.h"
#include "link/peer.h"

extern const peer_ops PEERS; /* to be put into a copy of the ops of the memory link, before standby_start */

void peers_forget(void);              /* all of them */
void peers_die(const struct link *l); /* the other one hears that it is gone, and of what it said before */
void peers_part(bool parted);         /* the network between them: each hears that the other one is lost, or back;
                                         what is said meanwhile is lost */

#endif
