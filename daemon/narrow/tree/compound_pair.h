/* compound_pair: pairs with a compound: the walk over its parts, and what is made of their answers. Pure; any thread.
 */
#ifndef COLLIDED_NARROW_TREE_COMPOUND_PAIR_H
#define COLLIDED_NARROW_TREE_COMPOUND_PAIR_H

#include "geom/compound.h"
#include "narrow/convex/epa.h"
#include "narrow/pair/unit_pair.h"
#include "union_depth.h"

/* ==== the walk ==== */

/* All pairs of parts of two shapes of which one or both are compounds, the nearest boxes first.
 *
 * The parts of a compound are its children; any other shape (a mesh, a half-space, too) is its own only part. What is
 * proven by boxes to be farther apart than `within` is left out, and how far that is at least is kept. The stack is on
 * the stack: its depth follows from COMPOUND_DEPTH_MAX. */

typedef struct compound_box { /* centre and half extents, in units of the pair */
    vec3 centre, half;
} compound_box;

typedef struct compound_side {
    const shape *whole;
    const compound *compound; /* NULL: it is its own only part */
    compound_box only;        /* of such a part, but of a half-space */
    double rounding;          /* of the whole compound, in units of the pair: its boxes do not have it */
} compound_side;

typedef struct compound_walk {
    compound_side a, b;
    bool plane;       /* A is a half-space */
    pose b_in_a;      /* m */
    transform placed; /* the same in units of the pair */
    mat3 spread;      /* |elements| of its rotation: how far a turned box reaches */
    double scale, unit, error, size;
    double within;   /* signed, in units of the pair; a visitor may lower it */
    double left_out; /* the least bound of what was left out */
    uint32_t visits;
    effort *effort;  /* of the query */
    narrow_ask *ask; /* who answers about two parts */
    bool cut;        /* it ended before all that is near had been visited; left_out has the bound of the rest */
} compound_walk;

/* `p`: the whole pair; `a`, `b`: the shapes that it was made of. */
void compound_walk_init(
    compound_walk *w, const unit_pair *p, const shape *a, const shape *b, pose b_in_a, narrow_ask *ask);

/* As if B were elsewhere: the position is in units of the pair. */
void compound_walk_move(compound_walk *w, vec3 position);

/* false: enough. */
typedef bool compound_visit(compound_walk *w, uint32_t part_a, uint32_t part_b, void *context);
void compound_walk_run(compound_walk *w, double within, compound_visit *visit, void *context);

uint32_t compound_part_count(const compound_side *s);

/* A part as a shape of its own, with the rounding and the deviation of the whole added to its own, and its pose in the
 * frame of the whole. */
shape compound_part(const compound_side *s, uint32_t part, pose *local);

/* What w->ask says of two parts, in A's frame, and as sure as the poses of the whole pair and of the parts are.
 * The types of the parts may be in any order. */
void compound_parts_query(const compound_walk *w, uint32_t part_a, uint32_t part_b, const narrow_request *request,
    narrow_scratch *scratch, narrow_result *out);

/* Of two parts, as far as they are hulls: what a query of them, and their contact, costs grows with it. */
int64_t compound_vertices(const shape *a, const shape *b);

/* B's part in the frame of A's part. *composed: it is not simply the pose of B in A. */
pose compound_parts_pose(const compound_walk *w, uint32_t part_a, uint32_t part_b, bool *composed);

/* ==== whole answers ==== */

/* What narrow.c asks of pairs with a compound.
 *
 * The signed distance of a union: apart, that of its nearest pair of parts, found by branch and bound; overlapping, no
 * less than that of the deepest pair, and no more than a translation that is proven to part all pairs; between them a
 * search over the differences of all pairs. */

/* A compound is always the second, or both are. */
static inline bool compound_pair_applies(const shape *b)
{
    return b->type == SHAPE_COMPOUND;
}

/* `ask` answers about two parts; `epa` and `parts` are part of `scratch`. */
void compound_pair_query(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    const narrow_request *request, narrow_ask *ask, narrow_scratch *scratch, epa_scratch *epa, union_scratch *parts,
    narrow_result *out);

#endif
