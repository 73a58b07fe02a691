/* calm: bodies that stay within their fat boxes, of which a tick takes no notice. */
#ifndef COLLIDED_WORLD_CALM_H
#define COLLIDED_WORLD_CALM_H

#include "state.h"

/* Finds the free-motion region of a body whose shapes have just been put into the broad phase. */
void calm_find(const world *w, body *b);
/* Where calm_holds has become false: is the body still within its fat box at that pose? Then its region is there. */
bool calm_find_again(body *b, const pose *at);
/* Is it within, at that position (what the fourth number is does not matter) and quaternion? Then its boxes stay where
 * they are. A NAN is not. In floats, whose rounding the region allows for. */
static inline __attribute__((always_inline)) bool calm_holds_at(
    const calm_region *r, const calm_wide *p, const calm_wide *q)
{
    static const calm_bits magnitude = {INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX};
    static const int64_t fourth = INT64_MIN >> 31;
    calm_four half = r->half, turn = __builtin_convertvector(*q, calm_four) - r->q, squares = turn * turn;
    calm_four off = __builtin_convertvector(*p - __builtin_convertvector(r->middle, calm_wide), calm_four);
    float turned = sqrtf(squares[0] + squares[1] + (squares[2] + squares[3])) * half[3];
    calm_masks within = (calm_masks)((calm_four)((calm_bits)off & magnitude) + turned <= half);
    return (within[0] & (within[1] | fourth)) == -1;
}
static inline bool calm_holds(const body *b, const pose *at)
{
    const calm_wide p = {at->p.x, at->p.y, at->p.z, 0}, q = {at->q.w, at->q.x, at->q.y, at->q.z};
    return calm_holds_at(&b->region, &p, &q);
}

#endif
