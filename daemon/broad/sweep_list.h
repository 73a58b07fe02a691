/* sweep_list: proxies sorted along axes, for sweep and prune (Baraff 1992): from one batch to the next the order hardly
 * changes, so what moved is brought to its new place by a few exchanges with its neighbours.
 *
 * A list holds for each proxy its lower end, or both ends, by (value, lower before upper): two boxes meet on an axis
 * exactly if the lower end of each comes before the upper end of the other. What is put and removed waits for the end
 * of the batch, and is then merged in at once, O(n). */
#ifndef COLLIDED_BROAD_SWEEP_LIST_H
#define COLLIDED_BROAD_SWEEP_LIST_H

#include "base/array.h"
#include "fbox.h"

#define SWEEP_NOWHERE UINT32_MAX /* a place, and an entry whose proxy was removed */

typedef struct sweep_end {
    float at;
    uint32_t what; /* proxy << 1 | upper */
} sweep_end;

typedef struct sweep_list {
    ARRAY(sweep_end) ends;
    ARRAY(uint32_t) place; /* by `what` */
    double widest;         /* no box reaches further along this axis */
} sweep_list;

typedef struct sweep {
    sweep_list lists[3];           /* by axis */
    ARRAY(uint32_t) fresh, moved;  /* in this batch */
    ARRAY(uint64_t) keys, scratch; /* to sort what is fresh */
    uint32_t count, gone;          /* proxies in the lists; of them those that were removed in this batch */
    int axis;                      /* the one list of sweep1 */
    size_t changes;                /* since the axis was chosen */
} sweep;

static inline bool sweep_before(sweep_end a, sweep_end b)
{
    return a.at < b.at || (a.at == b.at && (a.what & 1) < (b.what & 1));
}

/* -0 and 0 are the same place. */
static inline sweep_end sweep_end_of(const fbox *box, int axis, uint32_t what)
{
    return (sweep_end){(what & 1 ? box->hi[axis] : box->lo[axis]) + 0.0F, what};
}

#endif
