/* fit_hull: the convex hull of points with its facets, checked to be whole, and how far a point is from it.
 *
 * The facets come from qhull; what is relied on is checked here: every edge of a facet is walked once either way, and
 * no point is above a facet's plane. A closed surface on the boundary of a convex set is all of that boundary, so that
 * the half-spaces of the facets meet in the hull and nowhere else (but for `slack`). Lengths in m, in the points'
 * frame. Made in a pool and lives there; immutable afterwards. */
#ifndef COLLIDED_LOADERS_FIT_HULL_H
#define COLLIDED_LOADERS_FIT_HULL_H

#include "fit_gap.h"
#include "loaders/decompose/piece.h"
#include "loaders/decompose/vec3.h"

typedef struct fit_hull {
    double *points; /* the vertices: triples, sorted */
    size_t count;
    piece_plane *planes;   /* one a triangle; a facet of more corners repeats its plane */
    int32_t (*corners)[3]; /* counter-clockwise seen from outside */
    size_t plane_count;
    double lo[3], hi[3], centre[3]; /* box of the points, and its centre */
    double axes[3][3];              /* of the surface: rows, unit, longest first */
    double volume, most;            /* most: no |coordinate| is greater */
    double slack; /* more than what rounding does to any length here: 2^-36 of the greatest coordinate */
} fit_hull;

/* False: the points are flat, or qhull's facets do not close. */
bool fit_hull_make(pool *p, const double *points, size_t count, fit_hull *out);

static inline fit_cloud fit_hull_cloud(const fit_hull *h)
{
    return (fit_cloud){h->points, h->count, h->most};
}

static inline double fit_hull_diagonal(const fit_hull *h)
{
    return distance3(h->lo, h->hi);
}

/* Signed distance of x from the hull, negative inside; not below the true one. */
double fit_hull_away(const fit_hull *h, const double x[3]);

#endif
