/* toi_request: what is asked about two shapes that move, and what the answer says. Types alone: everything that
 * searches for times of impact stands above this header. */
#ifndef COLLIDED_TOI_REQUEST_H
#define COLLIDED_TOI_REQUEST_H

#include "geom/motion.h"
#include "geom/shape.h"

typedef struct toi_mover { /* a shape of a body that moves */
    const shape *shape;
    pose local;    /* of the shape in its body */
    motion motion; /* of the body, from time 0 on */
} toi_mover;

typedef struct toi_request {
    double span;      /* s, > 0: from 0 to here */
    double threshold; /* m: contact is a signed distance at or below it */
    double tolerance; /* m, > 0: nearer than threshold + tolerance is reported as a near miss, where neither contact nor
                         its absence is proven with fewer steps than are worth it */
    double wander;    /* m/s^2, >= 0: by how much all points may accelerate besides: what is free then is free for every
                         motion that leaves this one by no more than wander t^2 / 2; contact is then never proven */
    uint32_t spent;   /* of TOI_WORK_MAX: by searches for the legs of the same way that come before */
} toi_request;

typedef enum toi_status {
    TOI_FREE, /* proven: no contact from 0 to span */
    TOI_HIT,  /* proven: apart before lo, touching at hi */
    TOI_NEAR, /* apart before lo, within the tolerance of contact at lo; whether it comes to contact is not proven */
    TOI_UNDECIDED /* apart before lo; what a search may take ended there. Nothing is known of later: to be taken for a
                     hit */
} toi_status;

typedef struct toi_result {
    toi_status status;
    double lo, hi;         /* s; FREE: both INFINITY. NEAR, UNDECIDED: hi is INFINITY */
    double gap_lo, gap_hi; /* m: the signed distance at lo, certified */
    vec3 axis;             /* at lo: unit, world axes, from A to B */
    vec3 point_a, point_b; /* at lo: nearest points, world */
    pose body_a, body_b;   /* at lo */
    double closing;        /* m/s at lo, along the axis, of the nearest points; positive = they approach */
    uint32_t queries;      /* distances and verdicts that were asked */
    uint32_t steps;
    uint32_t work; /* of shapes of parts: what it took, at most about TOI_WORK_MAX */
} toi_result;

/* What a search of shapes of parts may take. Its steps count by what they cost, in units of about 17 ns; where these
 * are not enough the answer is TOI_UNDECIDED, at the same lo on every machine. A search may take 100 ms: 4,000,000 are
 * 70, which leaves 30 for the distances of the whole shapes when it begins and where it ends. */
enum { TOI_WORK_MAX = 4000000 };

/* Are these walked, part by part? A half-space sees nothing but convex hulls. */
bool toi_parts_apply(const shape *a, const shape *b);

#endif
