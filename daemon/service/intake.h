/* intake: all that a message passes between a link and the world, in order, in two tables of one file. Whatever brings
 * messages, a link, a recording or a bridge, hands them in here. Tick thread. */
#ifndef COLLIDED_SERVICE_INTAKE_H
#define COLLIDED_SERVICE_INTAKE_H

#include "service.h"

/* A message that is well-formed, as a link hands it over: it is carried out or put into the queue of this tick, waits
 * for its participant's share of work, is left to the active one of a pair, or is refused, which its sender is told. */
void intake_offer(service *s, struct link *from, const wire_message *m);

/* service_take (service.h) is the rest of the way: of a message that is admitted, whether it has waited, comes from the
 * journal of the active one, or was offered just now. */

#endif
