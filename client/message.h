/* message: what the library does with wire messages of any kind: copy them, and read or set their sequence. */
#ifndef COLLIDED_CLIENT_MESSAGE_H
#define COLLIDED_CLIENT_MESSAGE_H

#include "wire/wire.h"

/* A deep copy in one block, by the wire's schema; free() gives it back. */
wire_message *message_copy(const wire_message *m);

int64_t message_sequence(const wire_message *m);
void message_set_sequence(wire_message *m, int64_t sequence); /* of the kinds that clients send */

#endif
