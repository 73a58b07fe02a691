/* compound_pair: what narrow.c asks of pairs with a compound. Pure; any thread.
 *
 * The signed distance of a union: apart, that of its nearest pair of parts, found by branch and bound; overlapping, no
 * less than that of the deepest pair, and no more than a translation that is proven to part all pairs; between them a
 * search over the differences of all pairs. */
#ifndef COLLIDED_NARROW_COMPOUND_PAIR_H
#define COLLIDED_NARROW_COMPOUND_PAIR_H

#include "compound_walk.h"
#include "epa.h"
#include "union_depth.h"

/* A compound is always the second, or both are. */
static inline bool compound_pair_applies(const shape *b)
{
    return b->type == SHAPE_COMPOUND;
}

/* `ask` answers about two parts; `epa` and `parts` are part of `scratch`. */
void compound_pair_query(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    const narrow_request *request, narrow_ask *ask, narrow_scratch *scratch, epa_scratch *epa, union_scratch *parts,
    narrow_result *out);

/* How far B must go to be apart for certain, in units of the pair: a translation, or one of infinite length where none
 * was found. `deepest`: what is known of the deepest pair of parts, of those numbers, in metres. */
typedef struct compound_way {
    vec3 axis; /* unit */
    double length;
} compound_way;
compound_way compound_way_out(
    compound_walk *w, const narrow_result *deepest, const uint32_t parts[2], narrow_scratch *scratch);

/* Narrows both bounds of an overlap by a search over the differences of the parts (union_depth.h), if these are
 * polytopes; `asked`: m. */
void compound_search_depth(const unit_pair *p, compound_walk *w, const shape *a, const shape *b, double asked,
    narrow_scratch *scratch, union_scratch *parts, narrow_result *out);

/* As manifold_build, over all pairs of parts, along the axis of the answer. */
void compound_manifold(
    compound_walk *w, const narrow_result *answer, double threshold, narrow_scratch *scratch, manifold *out);

#endif
