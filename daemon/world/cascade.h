/* cascade: what is asked of a pair, and how it is answered: by bounds that stand (bounds.c), or by the narrow phase in
 * stages; and at what price (work.c). */
#ifndef COLLIDED_WORLD_CASCADE_H
#define COLLIDED_WORLD_CASCADE_H

#include "state.h"

/* cascade.c */
typedef struct demand { /* what all subscriptions in a pair ask together */
    narrow_request request;
    double limit;      /* m: beyond it nothing is reported */
    bool reported;     /* something of the pair has been reported */
    bool coarse;       /* bounds will do for all */
    bool touch;        /* somebody asks whether they touch ... */
    bool hysteresis;   /* ... and somebody of these with hysteresis */
    bool verdict_only; /* a verdict will, of one threshold */
} demand;
/* For a pair of which something has been reported, hysteresis is part of what is asked. */
demand cascade_demand(const world *w, const pair *p);
/* Stages 4 and on, from nothing: the number of narrow queries. */
uint32_t cascade_ask(
    const world *w, const pair *p, const demand *d, narrow_cache *cache, void *scratch, narrow_result *r);
/* Widens an answer by the rounding of the relative pose; one that is no longer within the tolerance says so. */
void cascade_allow_for_pose(
    const world *w, const collider *a, const collider *b, const pose *b_in_a, double tolerance, narrow_result *r);
void cascade_decide(world *w);
double pair_size(const collider *a, const collider *b); /* m: the finite reaches */

/* bounds.c */
bool bounds_stand(const world *w, const pair *p); /* does what was reported by bounds still hold? */
void bounds_travel(const world *w, body *b);      /* a body has moved, or its shapes are others */
/* Bounds that hold for a while: they are written to p->standing, too. `remembers`: what earlier ticks found may help.
 */
void bounds_find(
    const world *w, pair *p, const pose *b_in_a, double limit, bool remembers, void *scratch, narrow_result *r);
/* The same for measurements: nothing is remembered, and the pair may be a copy. */
void bounds_ask(const world *w, const pair *p, const pose *b_in_a, double limit, void *scratch, narrow_result *r);
void bounds_floor(const world *w, pair *p, const pose *b_in_a, narrow_result *r); /* the same by balls and boxes */

/* work.c */
enum { WORK_A_MOTION_BOUND = 30, WORK_AN_AXIS = 120 }; /* units */
uint32_t work_of_bounds(const collider *a, const collider *b);
void work_price(collider *s);                                                       /* fills apart, overlapping */
uint32_t work_of(const collider *a, const collider *b, const demand *d, double lo); /* units of a refinement */
/* Fills world.needs; returns how many of the first ones are to be refined, the others are set aside. */
size_t work_order(world *w);
void work_learn(world *w, size_t todo, size_t refined, uint64_t done); /* what came of it */
void work_charge(world *w); /* what subscriptions cost, and what of theirs is left undone */

#endif
