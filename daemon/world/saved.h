/* saved: a whole world between two ticks as bytes, and the same world again from them, in another process of the same
 * program: ids, what has been reported, fat boxes, pairs, everything on which an event to come may depend. Ticks from
 * then on bring the same events, bit for bit. Of caches only that is in it with which bounds begin (cascade.c): the
 * rest begins empty, and changes no answer. Tick thread. */
#ifndef COLLIDED_WORLD_SAVED_H
#define COLLIDED_WORLD_SAVED_H

#include "base/bytes.h"
#include "world.h"

/* Hulls, meshes and height fields are the caller's: they travel under a number of his. */
typedef struct world_lender {
    const void *context;
    int64_t (*name_of)(const void *context, const shape *s);      /* 0: unknown */
    bool (*lend)(const void *context, int64_t number, shape *to); /* sets its hull and mesh; false: unknown */
} world_lender;

/* Of the structs that are written as they lie: another number is another build's. */
uint64_t world_saved_layout(void);
/* About as many bytes as it takes, compounds and rules apart. */
size_t world_saved_size(const world *w);
void world_save(const world *w, const world_lender *lender, bytes_out *to);
/* Into a world that was just created. NULL, or what is wrong; the world is then of no use but to be destroyed. */
const char *world_restore(world *w, const world_lender *lender, bytes_in *from);

#endif
