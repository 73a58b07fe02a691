/* link_memory: both ends in one process, for tests and for programs that embed the daemon. A message put in at one end
 * is encoded as for LCM and decoded at the other, through the same checks as any datagram. Both ends may be used by
 * different threads. */
#ifndef COLLIDED_LINK_MEMORY_H
#define COLLIDED_LINK_MEMORY_H

#include "link.h"
#include "wire/wire_lcm.h"

extern const link_ops link_memory_ops;

/* The client's end of "memory://NAME"; the link of that name must be open in this process. */
typedef struct memory_end memory_end;
memory_end *memory_connect(const char *name);
void memory_disconnect(memory_end *e);
void memory_send(memory_end *e, const wire_message *m);
void memory_send_bytes(memory_end *e, const void *data, size_t size); /* as they are: for tests of bad input */
/* The next message for this end, or false if there is none. It lives in `memory`. */
bool memory_receive(memory_end *e, wire_memory *memory, wire_message *out);

#endif
