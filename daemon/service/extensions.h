/* extensions: records in messages that this release does not know (wire/wire_extensions.h). They are left out before
 * anything else is done with the message, so that recordings and the journal of a standby hold what was carried out: a
 * later release, which knows them, then replays what was done. Tick thread. */
#ifndef COLLIDED_SERVICE_EXTENSIONS_H
#define COLLIDED_SERVICE_EXTENSIONS_H

#include "service.h"

/* A copy of the message without them, to be freed; it borrows all but its extensions. NULL: there is nothing to leave
 * out. */
wire_message *extensions_leave_out(service *s, const struct link *from, const wire_message *m);

#endif
