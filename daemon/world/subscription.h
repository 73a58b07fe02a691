/* subscription: subscriptions: their terms, whom they want, and what was reported under terms that are no more
 * (closing.c).
 */
#ifndef COLLIDED_WORLD_SUBSCRIPTION_H
#define COLLIDED_WORLD_SUBSCRIPTION_H

#include "state.h"

void subscription_settle_changes(world *w);
void subscription_begin_tick(world *w);
void subscription_end_tick(world *w);
void subscription_restored(world *w);
void subscription_wake(world *w, uint32_t id); /* it may have something to report in this tick, or the next */
void subscription_wake_selecting(world *w, uint32_t selector); /* all that select by it */
void subscription_sort_lively(world *w);                       /* so that what they are told comes in their order */
void subscription_pass_began(world *w);
void subscription_pass_ended(world *w);
size_t subscription_unseen(const world *w, const subscription *i); /* bodies that have not been looked at for it */
bool subscription_has(const world *w, uint32_t id, const body *b); /* as A or B */
typedef struct subscription_sides {
    bool straight, turned; /* the first is A, or B, and the other the other */
} subscription_sides;
subscription_sides subscription_sides_of(const world *w, uint32_t id, const body *a, const body *b);
/* A and B are selected by the same pattern: of two bodies that it wants each is A, and B. */
static inline bool subscription_is_mutual(const world *w, uint32_t id)
{
    uint32_t selection = w->subscriptions.at[id].selection;
    const uint32_t *selectors = selection == WORLD_NONE ? NULL : w->match.selections.at[selection].selectors;
    return selectors && selectors[0] == selectors[1];
}
static inline bool subscription_wants(world *w, const body *a, const body *b)
{
    return match_wanted(&w->match, a->match, b->match);
}
/* Who wants an active pair, by rising id. */
static inline match_list subscription_list(const world *w, const pair *p)
{
    return w->match.lists.at[p->wanted];
}
double subscription_tolerance(const subscription *i, double size); /* m, of a pair of that size */

/* closing.c */
void closing_begin(world *w, uint32_t subscription);          /* from here on it is old */
void closing_go_on(world *w);                                 /* ends it, as far as a slice goes */
uint8_t closing_cause(const world *w, uint32_t subscription); /* of ends that are nobody's doing but its subscriber's */
static inline bool watch_is_old(const world *w, const watch *v)
{
    const subscription *i = &w->subscriptions.at[v->subscription];
    int64_t id = v->touch_id ? v->touch_id : v->near_id ? v->near_id : v->predicted_id;
    return i->olds && id && id <= i->old_serial;
}

#endif
