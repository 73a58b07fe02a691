/* epa: the depth of two overlapping convex cores, bracketed, in memory that the caller owns.
 *
 * van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", 2001. Every direction tried
 * gives an upper bound on the depth (the overlap of the support intervals: the proof of `lo`). The surface built so far
 * lies inside B - A and encloses the origin, so the least distance to its triangles is a lower bound (`hi`): that holds
 * for slivers too, because a distance to a triangle, unlike its plane, is well conditioned. Where rims of cylinders and
 * cones would take thousands of triangles, domes (curved.h) prove that nothing behind a triangle is nearer. */
#ifndef COLLIDED_NARROW_CONVEX_EPA_H
#define COLLIDED_NARROW_CONVEX_EPA_H

#include "gjk.h"

enum { EPA_VERTICES_MAX = 1024, EPA_FACETS_MAX = 2 * EPA_VERTICES_MAX, EPA_LANES = 4 };

typedef struct epa_facet {
    uint16_t vertex[3];    /* counter-clockwise seen from outside */
    uint16_t neighbour[3]; /* neighbour[i] shares the edge vertex[i], vertex[i + 1] */
    uint32_t visit;        /* the round in which the facet was last found visible */
    bool measured;         /* distance, axis and weight are those of the nearest point, not only of the plane */
    bool final;            /* the support point along its normal is no farther out */
    vec3 normal;           /* unit, outward */
    vec3 axis;             /* unit, from the origin to its nearest point; the normal when that is inside it */
    double weight[3];      /* of the nearest point */
} epa_facet;

typedef struct epa_scratch {
    minkowski vertex[EPA_VERTICES_MAX];
    epa_facet facet[EPA_FACETS_MAX];
    uint16_t free[EPA_FACETS_MAX];
    uint16_t horizon[EPA_VERTICES_MAX]; /* the new facet on each edge of the horizon, by the first vertex of the edge */
    uint16_t visible[EPA_FACETS_MAX];
    uint32_t horizon_round[EPA_VERTICES_MAX];
    /* of the triangle from the origin; INFINITY where no facet lives, and for EPA_LANES - 1 places behind the last */
    double distance[EPA_FACETS_MAX + EPA_LANES];
    uint32_t vertex_count, facet_count, free_count, round;
} epa_scratch;

/* Searches the depth from the simplex with which gjk_distance ended in GJK_TOUCH or GJK_INSIDE. */
void epa_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, epa_scratch *scratch, span *out);

#endif
