/* sweep: what both indices that sweep and prune do with their lists. Not thread-safe; queries may run in several
 * threads between updates. */
#ifndef COLLIDED_BROAD_SWEEP_H
#define COLLIDED_BROAD_SWEEP_H

#include "state.h"

/* Of an index: both are only noted. */
void sweep_put(broad *b, const change *c);
void sweep_remove(broad *b, uint32_t proxy);

/* Takes what was removed out of the list, and what is fresh into it: its lower ends, or both ends. */
void sweep_merge(broad *b, int axis, bool both_ends);
void sweep_end_batch(broad *b);

/* Those whose boxes meet the query, by the list of this axis. */
bool sweep_query_box(const broad *b, int axis, const fbox *query, broad_visit *visit, void *context);
void sweep_query_ray(const broad *b, int axis, tree_slabs *slabs, broad_ray_visit *visit, void *context);
void sweep_query_nearest(const broad *b, int axis, near_search *search);

void sweep_note_width(sweep_list *l, const fbox *box, int axis);
uint32_t sweep_position(const broad *b, uint32_t proxy);
const char *sweep_validate(const broad *b, int axis, bool both_ends, size_t *count);
void sweep_give_buffers_back(broad *b);
void sweep_free(broad *b);

#endif
