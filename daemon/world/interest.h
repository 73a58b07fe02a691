/* interest: interests: their terms, whom they want, and what was told under terms that are no more (closing.c). */
#ifndef COLLIDED_WORLD_INTEREST_H
#define COLLIDED_WORLD_INTEREST_H

#include "state.h"

void interest_settle_changes(world *w);
void interest_begin_tick(world *w);
void interest_end_tick(world *w);
void interest_restored(world *w);
void interest_wake(world *w, uint32_t id); /* it may have something to be told in this tick, or the next */
void interest_wake_selecting(world *w, uint32_t selector); /* all that select by it */
void interest_sort_lively(world *w);                       /* so that what they are told comes in their order */
void interest_pass_began(world *w);
void interest_pass_ended(world *w);
size_t interest_unseen(const world *w, const interest *i);     /* bodies that have not been looked at for it */
bool interest_has(const world *w, uint32_t id, const body *b); /* as A or B */
typedef struct interest_sides {
    bool straight, turned; /* the first is A, or B, and the other the other */
} interest_sides;
interest_sides interest_sides_of(const world *w, uint32_t id, const body *a, const body *b);
/* A and B are selected by the same pattern: of two bodies that it wants each is A, and B. */
static inline bool interest_is_mutual(const world *w, uint32_t id)
{
    uint32_t selection = w->interests.at[id].selection;
    const uint32_t *selectors = selection == WORLD_NONE ? NULL : w->match.selections.at[selection].selectors;
    return selectors && selectors[0] == selectors[1];
}
static inline bool interest_wants(world *w, const body *a, const body *b)
{
    return match_wanted(&w->match, a->match, b->match);
}
/* Who wants an active pair, by rising id. */
static inline match_list interest_list(const world *w, const pair *p)
{
    return w->match.lists.at[p->wanted];
}
double interest_tolerance(const interest *i, double size); /* m, of a pair of that size */

/* closing.c */
void closing_begin(world *w, uint32_t interest);          /* from here on it is old */
void closing_go_on(world *w);                             /* ends it, as far as a slice goes */
uint8_t closing_cause(const world *w, uint32_t interest); /* of ends that are nobody's doing but its subscriber's */
static inline bool watch_is_old(const world *w, const watch *v)
{
    const interest *i = &w->interests.at[v->interest];
    int64_t id = v->touch_id ? v->touch_id : v->near_id ? v->near_id : v->foretold_id;
    return i->olds && id && id <= i->old_serial;
}

#endif
