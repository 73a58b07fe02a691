/* loop: one descriptor that is readable when collided_poll has something to do. The caller's thread, without the lock.
 */
#ifndef COLLIDED_CLIENT_LOOP_H
#define COLLIDED_CLIENT_LOOP_H

#include "session.h"

void loop_begin(collided *c); /* of a new client: there is no descriptor until collided_fd is called */
void loop_end(collided *c);
void loop_take_wakes(collided *c); /* before looking for what has come: what wakes later keeps it readable */
void loop_set_timer(collided *c);  /* after looking: readable again when something is due */

#endif
