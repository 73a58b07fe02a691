/* events: how events are made and to whom they are reported, for the files that report them. Tick thread. */
#ifndef COLLIDED_WORLD_EVENTS_H
#define COLLIDED_WORLD_EVENTS_H

#include "state.h"

/* What an event holds beyond its points, and an impact where it is of none, nobody reads: it is not copied. */
static inline void event_copy(world_event *to, const world_event *from, bool has_impact)
{
    size_t head = offsetof(world_event, manifold.points) + from->manifold.count * sizeof(manifold_point);
    memcpy(to, from, has_impact ? sizeof *to : head);
}

/* One of no points and no impact: what nobody reads of it is not written. */
static inline void event_clear(world_event *e)
{
    memset(e, 0, offsetof(world_event, manifold.points));
}

/* Into the subscription's list of this tick, and into the hash unless it is a snapshot's. */
void events_emit(world *w, uint32_t subscription, const world_event *e, uint8_t kind, uint8_t cause, int64_t contact);

/* A body as a whole is unknown, or known again. */
void events_emit_body(world *w, uint32_t body, uint32_t subscription, uint8_t kind, uint8_t cause);

/* The same as reported to nobody yet. */
world_event events_of_body(const world *w, uint32_t body);
/* What it says is as old as the poses are now. */
void events_refresh_ages(const world *w, const watch *v, world_event *e);

/* What the narrow phase found out about a pair, as it is reported to the subscription: in its order of A and B. */
void events_fill(
    const world *w, const pair *p, const narrow_result *r, uint32_t subscription, int looks, world_event *e);

/* What the interval is, beside what was asked; `limit`: the threshold or the range that it is reported for. */
uint8_t events_achieved(const narrow_result *r, const outcome *o, double limit);

/* Is this pair A and B to the subscription the other way round? Where it may be both, A is the one that looks. */
bool events_is_turned(const world *w, const body *a, const body *b, uint32_t subscription, int looks);
void events_turn_round(world_event *e);

/* Does the subscription's rate allow an update in this tick? */
bool events_may_update(const world *w, const subscription *i);

/* Watches: what was reported of one pair to one subscription. */
int64_t watch_id(const watch *v);                    /* of what was reported first; 0: nothing stands */
world_event watch_last(const world *w, uint32_t id); /* what was last reported of that */
void watch_reserve(world *w, size_t count);
/* The last event of contact or nearness: kept, and as it was. */
void watch_keep_contact(world *w, uint32_t id, const world_event *e);
world_event watch_contact(const world *w, uint32_t id);
/* Has that event been reported already, but for the ages? As news_same_facts. */
bool watch_has_said(const world *w, uint32_t id, const world_event *e);
void watch_fetch_last(const world *w, uint32_t id); /* asks for the memory of the last event of contact or nearness */
void watch_keep_predicted(world *w, uint32_t id, const world_event *e);
/* WORLD_NONE: there is none. An old one ends here. */
uint32_t watch_find(world *w, const pair *p, uint32_t subscription);
uint32_t watch_add(world *w, uint32_t pair, uint32_t subscription);
void watch_drop(world *w, uint32_t id);
/* With the ends of what stands. */
void watch_end(world *w, uint32_t id, uint8_t cause);
void watch_hold_back(world *w, uint32_t id); /* it has an update that the rate does not allow yet */
/* Has it one still? Its id may be another's by now. */
bool watch_is_held_back(const world *w, uint32_t id, uint32_t subscription);

#endif
