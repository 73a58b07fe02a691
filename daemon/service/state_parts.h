/* state_parts: the bytes of a whole state, in which the numbers of geometries are borrowed and not copied: a world may
 * have gigabytes of them, and a copy would hold the tick for seconds. They are read one after the other, in portions,
 * by whoever sends or writes them. The tick thread makes it; one thread at a time reads it. */
#ifndef COLLIDED_SERVICE_STATE_PARTS_H
#define COLLIDED_SERVICE_STATE_PARTS_H

#include "base/bytes.h"
#include "builds.h"

typedef struct borrowed_numbers {
    size_t at;                 /* in `own`: they come before this byte of it */
    geometry_numbers *numbers; /* kept */
    uint8_t *has;              /* which pieces had come: what comes later is not read. NULL: all */
} borrowed_numbers;

typedef struct state_parts {
    bytes_out own; /* all but the borrowed ones */
    ARRAY(borrowed_numbers) borrowed;
    size_t size;                    /* of the whole, when all has been put */
    size_t read, next, read_of_own; /* how far the reader is: in the whole, in `borrowed`, in `own` */
    size_t read_of_next;            /* bytes of the numbers that are next */
} state_parts;

/* The numbers, vertices first, at the end of what has been put. `has`: copied, `pieces` of them; NULL: all have come.
 */
void state_parts_borrow(state_parts *to, geometry_numbers *n, const uint8_t *has, size_t pieces);
void state_parts_end(state_parts *to); /* all has been put */
/* The next bytes; what had not come is zeros. How many: fewer than `size` only at the end. */
size_t state_parts_read(state_parts *from, uint8_t *to, size_t size);
void state_parts_rewind(state_parts *from);
/* From its first byte to its last; ends at the first one. */
uint64_t state_parts_hash(state_parts *from);
void state_parts_free(
    state_parts *p, builds *b); /* empty after it; large numbers go by the threads of `b`, or NULL: here */

#endif
