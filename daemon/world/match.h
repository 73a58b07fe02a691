/* match: bodies and subscriptions enter and leave the tables of match_table.h. Tick thread, but for reading what a
 * pair's list says. */
#ifndef COLLIDED_WORLD_MATCH_H
#define COLLIDED_WORLD_MATCH_H

#include "base/bytes.h"
#include "state.h"

void match_init(match *m);
void match_free(match *m);

/* The subscription wants two bodies if one matches A and the other B. */
void match_attach(world *w, uint32_t subscription); /* by its select_a and select_b */
void match_detach(world *w, uint32_t subscription);
/* Brings lists and reaches up to date with what was attached and detached. */
void match_refresh(world *w);

/* Which selectors a name matches, as a class. `tried` grows by the patterns that were tried. */
uint32_t match_find_class(match *m, const char *name, const char *group, size_t *tried);
void match_change_class(match *m, uint32_t *of_body, uint32_t to);
/* The same class, with what the pending selectors say of the name, and without those that live no more. */
uint32_t match_renew_class(
    match *m, uint32_t id, const char *name, const char *group, size_t *tried); /* NULL: no name */
bool match_class_has(const match *m, uint32_t id, uint32_t selector);
const match_reach *match_class_reach(match *m, uint32_t id);
const match_class *match_concern(match *m, uint32_t id); /* with `concerned` and `marked` as of this pass */
/* Subscriptions in bodies of this class, by rising id: valid until the next call. */
match_list match_of_class(match *m, uint32_t id);

/* match_pass.c */
/* The name is held against all patterns, now or, where many have been tried in this tick, in one of the next. */
void match_put_body(world *w, uint32_t body);
void match_hold_body(world *w, uint32_t body);                  /* it is in no subscription, until ... */
void match_free_body(world *w, uint32_t body);                  /* ... it waits for its turn like what was put */
void match_next_pass(match *m, uint32_t selector, bool marked); /* the next one is about it */
void match_run(world *w);                                       /* as far as this tick's steps go */
bool match_is_unsettled(const match *m);
void match_save(const world *w, bytes_out *to);
const char *match_restore(world *w, bytes_in *from); /* once the subscriptions are there; NULL, or what is wrong */
void match_save_class(const match *m, uint32_t id, bytes_out *to);
void match_restore_class(match *m, uint32_t *id, bytes_in *from);

/* match.c, for these */
void match_place_selector(match *m, uint32_t id, const char *text); /* a live one, by its pattern */
bool match_reattach(world *w, uint32_t subscription);               /* to selectors that are there */
uint32_t match_class_of_found(match *m);                            /* of the selectors in `found`, in any order */

#endif
