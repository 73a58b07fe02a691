/* fbox: boxes of floats, as the trees keep them. Plain values. Rounding is exact and outward, whatever the distance
 * from the origin: far away a box grows to its neighbouring floats, but it never loses a point. */
#ifndef COLLIDED_BROAD_FBOX_H
#define COLLIDED_BROAD_FBOX_H

#include "geom/bounds.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct fbox {
    float lo[3], hi[3];
} fbox;

/* nextafterf(f, -INFINITY) of one that is above: no NAN, and not -INFINITY itself. libm's is a call. */
static inline float float_below(float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    bits = f > 0 ? bits - 1 : f < 0 ? bits + 1 : UINT32_C(0x80000001);
    memcpy(&f, &bits, sizeof f);
    return f;
}

/* The greatest float <= x and the least float >= x. A conversion rounds to nearest; step back where it overshot. */
static inline float float_down(double x)
{
    float f = (float)x;
    return (double)f > x ? float_below(f) : f;
}
static inline float float_up(double x)
{
    float f = (float)x;
    return (double)f < x ? -float_below(-f) : f;
}

static inline fbox fbox_outward(aabb b)
{
    return (fbox){{float_down(b.lo.x), float_down(b.lo.y), float_down(b.lo.z)},
        {float_up(b.hi.x), float_up(b.hi.y), float_up(b.hi.z)}};
}

/* The box that meets exactly the float boxes which `b` meets: for a float f, f <= x is f <= float_down(x), and x <= f
 * is float_up(x) <= f. Its lo may lie above its hi; fbox_overlap does not mind. */
static inline fbox fbox_inward(aabb b)
{
    return (fbox){{float_up(b.lo.x), float_up(b.lo.y), float_up(b.lo.z)},
        {float_down(b.hi.x), float_down(b.hi.y), float_down(b.hi.z)}};
}

static inline aabb fbox_aabb(const fbox *b)
{
    return (aabb){{b->lo[0], b->lo[1], b->lo[2]}, {b->hi[0], b->hi[1], b->hi[2]}};
}

/* With & instead of &&: six comparisons cost less than one branch that is guessed wrong. */
static inline bool fbox_overlap(const fbox *a, const fbox *b)
{
    return (a->lo[0] <= b->hi[0]) & (b->lo[0] <= a->hi[0]) & (a->lo[1] <= b->hi[1]) & (b->lo[1] <= a->hi[1]) &
           (a->lo[2] <= b->hi[2]) & (b->lo[2] <= a->hi[2]);
}

static inline fbox fbox_union(const fbox *a, const fbox *b)
{
    fbox u;
    for (int k = 0; k < 3; k++) {
        u.lo[k] = a->lo[k] < b->lo[k] ? a->lo[k] : b->lo[k];
        u.hi[k] = a->hi[k] > b->hi[k] ? a->hi[k] : b->hi[k];
    }
    return u;
}

static inline bool fbox_equal(const fbox *a, const fbox *b)
{
    bool equal = true;
    for (int k = 0; k < 3; k++) equal &= a->lo[k] == b->lo[k] && a->hi[k] == b->hi[k];
    return equal;
}

static inline bool fbox_contains_aabb(const fbox *outer, const aabb *inner)
{
    return aabb_contains(fbox_aabb(outer), *inner);
}

/* Half the surface: the chance that a random box or ray meets this one is proportional to it. */
static inline float fbox_area(const fbox *b)
{
    float x = b->hi[0] - b->lo[0], y = b->hi[1] - b->lo[1], z = b->hi[2] - b->lo[2];
    return x * y + y * z + z * x;
}

#endif
