/* suspect: what a daemon was carrying out when it died. The thread that ticks writes it into a small file that is
 * mapped into memory, before each command and each tick, and so do the threads that build geometry, before each build:
 * a few stores, no system call. An end in order says so in the file; so who finds it without knows that the daemon
 * before was killed (by its watchdog, a fault, the kernel), and over what. That command, of that client, with that
 * content, is refused for a minute, and for twice as long each time that a daemon dies over it again, up to an hour;
 * for a build these are the pieces of its geometry. Whatever else its client says is let in.
 *
 * A fault in a thread that builds is held against what it built, whatever the thread that ticks did meanwhile.
 *
 * Where no signal that ends with a core was seen (SIGKILL, a power cut), or the daemon died in a tick and not in a
 * command, it may have been chance: it is told, and held against a command, or against what makes a tick long of the
 * client that most of that tick came from, only when it happens again. So is all that was under way, builds too, when
 * memory ended elsewhere: who took it is not known.
 *
 * A command is refused before it is recorded, so that a replay needs to know of none of this. Tick thread, but for the
 * handler of fatal signals and for what builds.c calls. */
#ifndef COLLIDED_SERVICE_SUSPECT_H
#define COLLIDED_SERVICE_SUSPECT_H

#include "wire/wire.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct service;

/* In the folder of the option runtime_dir, or of RUNTIME_DIRECTORY; without either nothing is kept. Tells in the log
 * what the daemon before died over. Before anything is heard. */
void suspect_open(struct service *s);
void suspect_close(struct service *s); /* in order */

void suspect_begin(struct service *s, const wire_message *m); /* it is carried out from here ... */
void suspect_end(struct service *s);                          /* ... to here */
void suspect_begin_tick(struct service *s);                   /* what comes until suspect_end is no one command's */

/* True: it is refused, and why. Not of a replay. */
bool suspect_refuses(struct service *s, const wire_message *m, wire_refusal *why);
size_t suspect_count(const struct service *s);                           /* commands that are refused now */
void suspect_describe(const struct service *s, char *text, size_t size); /* the first of them, for people; "": none */

#endif
