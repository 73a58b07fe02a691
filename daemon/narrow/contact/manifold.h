/* manifold: up to four contact points of a pair whose axis and depth are already known.
 *
 * The features of both shapes that face each other along the axis (face, cap, side line, edge) are clipped against each
 * other. Depends on the shapes, the pose and the axis alone: no history. Discs are clipped as octagons
 * (geom/feature.h); where such a rim passes above the true deepest point, that point joins. Curved spots, crossing
 * edges and corners give one point, and so do flat hulls, which have no faces. */
#ifndef COLLIDED_NARROW_CONTACT_MANIFOLD_H
#define COLLIDED_NARROW_CONTACT_MANIFOLD_H

#include "narrow/pair/request.h"

#include <stdint.h>

/* ---- manifold choice ---- */

/* Up to four of any number of contact points, by the rule of manifold.c: the deepest, the one farthest from it, the
 * farthest from their line on either side. Where `seamed`, of several that are equally deep, as on a flat floor, one at
 * a corner is taken and not one at a seam. One pass over all points for each, so that none is stored and there is no
 * cap on how many there are. */

typedef enum manifold_pass {
    PASS_DEEPEST,
    PASS_FARTHEST,
    PASS_CORNER,
    PASS_LEFT,
    PASS_RIGHT,
    PASS_COUNT
} manifold_pass;

typedef struct manifold_choice {
    manifold chosen;
    manifold_pass pass; /* what is looked for */
    bool found;
    double best;
    manifold_point point; /* the best of this pass */
    double same;          /* points nearer to each other than this, across the axis, are one; and equally deep */
    bool seamed;
    vec3 u, v; /* across the axis */
} manifold_choice;

void manifold_choice_begin(manifold_choice *c, vec3 axis, double same, bool seamed);
void manifold_choice_offer(manifold_choice *c, const manifold_point *p);
bool manifold_choice_next(manifold_choice *c); /* after a pass; returns false if there is none left */

/* In the order of their features. */
void manifold_choice_write(const manifold_choice *c, manifold *out);

/* Puts manifold_build's own witness so far off that it comes only where there is no other point. */
#define MANIFOLD_NO_WITNESS 0x1p500

/* Of the pair's size: points nearer to each other are one, for neighbours meet at an edge or a seam. */
#define MANIFOLD_SAME_POINT 1e-9

/* ---- manifold ---- */

/* `axis` is unit, in A's frame, from A towards B; `point_a`, `point_b` are the deepest (or nearest) points of the
 * answer, used when the features meet in one point only. Points farther apart than `threshold` along the axis are left
 * out, but there is always at least one point; of more than four the deepest and the widest spread are kept, in the
 * order of their features. Ids stay while the pose moves by less than 1e-6 of the smaller feature. Everything in A's
 * frame. */
void manifold_build(const shape *a, const shape *b, const transform *b_in_a, vec3 axis, vec3 point_a, vec3 point_b,
    double threshold, manifold *out);

/* The one point of an answer whose parts bring none: midway between its points. The axis need not be that of the parts
 * whose points these are, so the distance along it is taken into the interval. */
manifold_point manifold_witness(const narrow_result *answer);

/* ==== ids of features ==== */

/* The stable id of a contact point: what it is made of on either shape. Plain values; any thread.
 *
 * 32 bits a shape, A's in the high half of the id, B's in the low. Bits 14 and 15 are the kind; the index (of a vertex,
 * edge or face of the shape, less than 2^30) has its low 14 bits below them and the rest above: so an index that fits
 * 14 bits makes a code of 16. No two features of a shape share a code. */

enum { FEATURE_VERTEX = 0x0000, FEATURE_EDGE = 0x4000, FEATURE_FACE = 0x8000, FEATURE_WITNESS = 0xc000 };
enum { FEATURE_KIND = 0xc000, FEATURE_LOW = 0x3fff, FEATURE_LOW_BITS = 14, FEATURE_HIGH_AT = 16 };

static inline uint32_t feature_code(uint32_t kind, uint32_t index)
{
    return (index >> FEATURE_LOW_BITS) << FEATURE_HIGH_AT | kind | (index & FEATURE_LOW);
}

static inline uint32_t feature_kind(uint32_t code)
{
    return code & FEATURE_KIND;
}
static inline uint32_t feature_index(uint32_t code)
{
    return code >> FEATURE_HIGH_AT << FEATURE_LOW_BITS | (code & FEATURE_LOW);
}

static inline uint64_t feature_id(uint32_t code_a, uint32_t code_b)
{
    return (uint64_t)code_a << 32 | code_b;
}
static inline uint32_t feature_code_a(uint64_t id)
{
    return (uint32_t)(id >> 32);
}
static inline uint32_t feature_code_b(uint64_t id)
{
    return (uint32_t)id;
}

/* With A and B exchanged. */
static inline uint64_t feature_turned(uint64_t id)
{
    return id << 32 | id >> 32;
}

/* Of a point that is no corner of any feature: the witness of the distance. */
static inline uint64_t feature_witness(void)
{
    return feature_id(FEATURE_WITNESS, FEATURE_WITNESS);
}

#endif
