/* replay_served: a recording that somebody looks at: a replay with one more client, who observes and asks like any
 * other, and which goes on, stands still and ends when it is told to.
 *
 * The client is at the other end of a pipe (link/link_pipe.h; the client library calls it pipe://). Nothing that it
 * subscribes to changes what the recorded clients were told, but contacts that only it is told of count, so that the
 * numbers of contacts may be others; hashes are not compared.
 *
 * Standard input has the commands, a line each; its end ends the replay:
 *   play SPEED      at so many times the recorded time; 0: as fast as the client reads
 *   pause
 *   step            one tick; then pauses
 *   to NS           as fast as possible, up to the last tick that is not later than that stamp; then pauses
 * Standard output has what became of them, a line each, words and numbers separated by spaces:
 *   recording BEGIN_NS END_NS TICKS    first of all: stamps of the first and last tick, and how many there are
 *   damaged WHY                        behind the last of these
 *   done N                             N commands are carried out, and "at" has told what became of the last
 *   at NS TICK STATE SPEED             at each change of STATE: paused, playing, seeking, ended; and ten times a second
 * The first tick is run at once; then it pauses. While it stands still, commands of the client (not of the recording)
 * are carried out in ticks between the recorded ones, with the clock of the last one. */
#ifndef COLLIDED_SERVICE_REPLAY_SERVED_H
#define COLLIDED_SERVICE_REPLAY_SERVED_H

#include "service.h"

/* links[0] is the replay, links[1] the pipe. EX_OK, EX_DATAERR if not even the first tick can be read. */
int replay_serve(service *s, const link_sink *sink, const _Atomic bool *stop);

#endif
