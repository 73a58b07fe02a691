/* wire_extensions: what messages carry beyond their fields, so that a field can be added without breaking who does not
 * know it. The last field of every message holds records one behind the other: an id and a length, 32 bits each and
 * little-endian, then so many bytes. The ids rise, so that none stands twice. A record whose id is unknown is passed
 * over and counted; one that must not be passed over has the highest bit of its id set, and who does not know it
 * refuses the message. README.md lists the ids. Pure; any thread. */
#ifndef COLLIDED_WIRE_EXTENSIONS_H
#define COLLIDED_WIRE_EXTENSIONS_H

#include "wire.h"

enum { WIRE_EXTENSION_HEAD = 8 }; /* bytes of an id and a length */
#define WIRE_EXTENSION_REQUIRED UINT32_C(0x80000000)

typedef struct wire_extension {
    uint32_t id;
    wire_u8s bytes; /* borrowed from the message */
} wire_extension;

/* True for a record that this release reads in a message of that kind. */
bool wire_extension_is_known(wire_kind kind, uint32_t id);

/* The next record, which is taken from the front of `rest`. False: there is none, or not a whole one; then `rest` stays
 * as it is. */
bool wire_extension_next(wire_u8s *rest, wire_extension *out);

wire_u8s wire_extensions_of(const wire_message *m); /* none for WIRE_NOTHING */

/* The records of `m` that are known, copied to `room` of as many bytes as there are. The number of the others. */
uint32_t wire_extensions_keep_known(const wire_message *m, uint8_t *room, wire_u8s *known);
void wire_extensions_set(wire_message *m, wire_u8s extensions);

#endif
