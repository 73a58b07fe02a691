/* hull_loops: the combinatorics of a convex hull as qhull sees it: which points make up which facet, in which order.
 *
 * The only door to libqhull_r. Its coordinates, normals and offsets stay behind it. */
#ifndef COLLIDED_GEOM_HULL_LOOPS_H
#define COLLIDED_GEOM_HULL_LOOPS_H

#include "vec.h"

#include <stddef.h>
#include <stdint.h>

typedef struct hull_loops {
    uint32_t face_count, corner_count;
    uint32_t *first;   /* face_count + 1 entries into corners */
    uint32_t *corners; /* point indices; counter-clockwise seen from outside */
} hull_loops;

/* a b - c d to one and a half ulp (Kahan; fma is correctly rounded everywhere). */
static inline double difference_of_products(double a, double b, double c, double d)
{
    double cd = c * d;
    return fma(a, b, -cd) + fma(-c, d, cd);
}

/* Twice the area vector of a triangle. A plain cross product of two long, almost parallel sides would lose the normal
 * of a sliver to rounding. Newell's sum over a fan of triangles gives the normal of a polygon. */
static inline vec3 triangle_area(vec3 a, vec3 b, vec3 c)
{
    vec3 p = vec_sub(b, a), q = vec_sub(c, a);
    return vec(difference_of_products(p.y, q.z, p.z, q.y), difference_of_products(p.z, q.x, p.x, q.z),
        difference_of_products(p.x, q.y, p.y, q.x));
}

/* `options`: of qhull(1), appended to its command. `points` of about unit size, not flat. False when qhull gives up or
 * a facet is not one closed loop. Any thread; qhull's error exits and messages stay inside. */
bool hull_loops_find(const vec3 *points, uint32_t count, const char *options, hull_loops *out);
void hull_loops_free(hull_loops *loops);

#endif
