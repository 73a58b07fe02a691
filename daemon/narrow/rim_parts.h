/* rim_parts: what a feature of one body is, for rim_features.h: a corner, an edge or a face of a box (of a capsule: an
 * end, or its segment), a rim, a flat end, an apex or the side of a body of revolution.
 *
 * A feature is named by its sides, three small numbers: of a box (or a capsule, which is one without width) for each of
 * its axes between, high or low; of a body of revolution that along its axis, whether it is the flat end, and 0.
 * Lengths in a unit_pair's units. Between rim_parts.c, rim_newton.c and rim_features.c. Pure; any thread. */
#ifndef COLLIDED_NARROW_RIM_PARTS_H
#define COLLIDED_NARROW_RIM_PARTS_H

#include "unit_pair.h"

#define RIM_SINE 0x1p-11 /* between n and the axis of a rim: the least */

/* A feature in A's frame: one disc or two, or a face. */
typedef struct rim_part {
    int discs;
    vec3 centre[2];
    double radius[2];
    vec3 x, y;    /* unit, orthogonal: the plane of the discs */
    vec3 axis;    /* of the discs; of a face its outward normal */
    bool has_rim; /* one of the radii is above 0 */
    bool is_face;
} rim_part;

static inline bool rim_is_revolved(const shape *s)
{
    return s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE;
}

/* In the body's own frame. False: it has no such feature, or `side` names what is none. */
bool rim_part_of(const shape *s, const uint16_t side[3], uint8_t count, rim_part *out);

/* From its own frame, where z is the axis of the discs. */
static inline void rim_part_place(const transform *t, rim_part *x)
{
    for (int i = 0; i < x->discs; i++) x->centre[i] = transform_point(t, x->centre[i]);
    x->axis = x->axis.z < 0 ? vec_neg(t->r.z) : t->r.z;
    x->x = t->r.x, x->y = t->r.y;
}

/* `out`: unit, outward, in the body's frame. Does it point out of the body as the feature wants, and away from all that
 * is not of it, by a margin? */
bool rim_part_holds(const shape *s, const uint16_t side[3], vec3 out);

/* Can the direction that a strict feature has be within `off`, an angle, of this one? */
bool rim_part_may_be(const shape *s, const uint16_t side[3], vec3 out, double off);

/* Is a point of a face's plane inside of the face, by more than the margin? */
bool rim_part_contains(const shape *s, const uint16_t side[3], vec3 at, double margin);

/* The feature that a point of the surface is on, to within `near`, and that `out` leaves the body by. */
void rim_part_at(const shape *s, vec3 at, vec3 out, double near, uint16_t side[3]);
bool rim_part_make_round(const shape *s, uint16_t side[3]); /* of a flat end its rim; false: it is none */

/* All features of a body, by number. */
uint32_t rim_part_count(const shape *s);
void rim_part_numbered(const shape *s, uint32_t i, uint16_t side[3]);

#endif
