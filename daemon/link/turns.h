/* turns: messages that wait in a link, because more came than one round takes. Each source has a queue of its own, and
 * the queues take turns with equal shares of bytes (deficit round robin): who floods waits for himself, and who says
 * little is heard in the next round. Within a source the order of coming stands. No threads of its own. */
#ifndef COLLIDED_LINK_TURNS_H
#define COLLIDED_LINK_TURNS_H

#include "base/array.h"
#include "base/pair_map.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct turns_queue {
    uint64_t source;
    int64_t credit;      /* bytes that it may yet have in this turn */
    ARRAY(void *) waits; /* in the order of their coming, from `first` on */
    ARRAY(size_t) sizes; /* of the same */
    size_t first, bytes;
} turns_queue;

typedef struct turns {
    ARRAY(turns_queue) queues; /* none of them is empty */
    pair_map queue_of;         /* source -> place */
    size_t turn;               /* whose it is */
    size_t count, bytes;       /* of all */
} turns;

void turns_init(turns *t);
void turns_free(turns *t); /* what waits is the caller's: taken before */

/* `source`: not 0. The message, of so many bytes, comes behind those of that source. */
void turns_put(turns *t, uint64_t source, void *message, size_t bytes);
size_t turns_bytes_of(const turns *t, uint64_t source);
size_t turns_count_of(const turns *t, uint64_t source);

/* The next one, by turns; NULL: none waits. */
void *turns_next(turns *t);
/* The same one, which stays, for who looks at it before: then it is taken by turns_take, or a part of it by turns_part.
 * Both charge `more` bytes to its source, for what takes longer than its bytes say. */
void *turns_first(turns *t);
void turns_take(turns *t, size_t more);
void turns_part(turns *t, size_t bytes, size_t more); /* so many bytes of it are done with; one, at least, is left */
/* The oldest of that source, out of turn; NULL: none waits. */
void *turns_oldest_of(turns *t, uint64_t source);
/* Each that waits. */
void turns_each(const turns *t, void (*visit)(void *context, void *message), void *context);
uint64_t turns_longest(const turns *t); /* the source of the most bytes; 0: nothing waits */

#endif
