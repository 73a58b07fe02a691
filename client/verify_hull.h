/* verify_hull: the points of a hull, made ready to be looked at many times: looked at once for what no direction
 * changes (are they numbers, how far they reach), and sorted into balls of eight, most of which a direction rules out.
 * Pure; any thread. */
#ifndef COLLIDED_CLIENT_VERIFY_HULL_H
#define COLLIDED_CLIENT_VERIFY_HULL_H

#include "collided.h"
#include "verify_scan.h"

#include <stdint.h>

struct collided_prepared_hull {
    size_t count;
    const double *points; /* count triples x, y, z: the caller's, in another order */
    real reach2;          /* as in points_scan */
    size_t balls;         /* a multiple of four: the last one is repeated */
    const double *ball;   /* of each four balls: four x, y, z of the middles of their points, and four radii */
    const double *eight;  /* of each ball: eight x, y, z; the last point is repeated */
};

enum { PREPARED_BALLS = 128 };

/* The balls that may hold the top, or points that are not deeper below it than was asked. */
typedef struct prepared_scan {
    vec along;
    real top;    /* greatest along . p */
    bool forgot; /* there was no room for all of them */
    int count;
    uint32_t ball[PREPARED_BALLS + 1]; /* the last is written, and never counted */
    real ball_top[PREPARED_BALLS];
} prepared_scan;

void prepared_look(const collided_prepared_hull *h, vec along, real depth, prepared_scan *out);

/* As points_on_top, in an order of its own; no deeper than what was looked for. */
int prepared_on_top(const collided_prepared_hull *h, const prepared_scan *s, real depth, vec *out, int most);

#endif
