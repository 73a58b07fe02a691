/* crowd: a client of a crowd, as a process of its own, for the tests of crowds: it creates a body, subscribes to its
 * contacts, and says by further bodies how far it has come. Runs in the process that rig_self started. */
#ifndef COLLIDED_TESTS_FAULTS_CROWD_H
#define COLLIDED_TESTS_FAULTS_CROWD_H

#include <collided.h>
#include <stdint.h>

enum { CROWD_BODIES = 3 /* that each has in the end */ };

/* Its first body, in the place where those of all others are; a second one says that the first is acknowledged and that
 * the stream has begun, a third one that the stream has told of a contact. It has patience, with a daemon that is
 * killed as well, and stays until it is ended. `interface`: NULL = loopback. Otherwise the process's exit status. */
int crowd_be_one(const char *uri, const char *number, const char *interface);

/* A counter of the daemon's Status; -1: while a crowd takes all the time that there is, it is not heard. */
int64_t crowd_counter(collided *watcher, const char *name);

#endif
