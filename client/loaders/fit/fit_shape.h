/* fit_shape: simple shapes around a convex hull.
 *
 * Each holds the hull, proven by its corners; each is a core with corners c rounded by a radius r, and no point of it
 * is farther from the hull than the greatest r + d(c), with d the signed distance of c from the hull: a support
 * function of core and ball against that of the hull, direction by direction. Which shape of a kind is taken is
 * searched for, to make that bound small; it need not be the least. All lengths are rounded outward by the hull's
 * slack, which is more than what the frames' quaternions and the text of a scene can move. Results live in the pool. */
#ifndef COLLIDED_LOADERS_FIT_SHAPE_H
#define COLLIDED_LOADERS_FIT_SHAPE_H

#include "fit_hull.h"
#include "loaders/body.h"

typedef struct fit_shape {
    load_shape shape;
    double excess_m; /* bound of how far its points are from the hull */
    double volume;   /* m^3 */
} fit_shape;

void fit_sphere(const fit_hull *h, fit_shape *out);
void fit_capsule(const fit_hull *h, fit_shape *out);
void fit_box(const fit_hull *h, fit_shape *out);
void fit_rounded_box(const fit_hull *h, const fit_shape *box, fit_shape *out); /* begins with what fit_box found */
/* Of as few of the hull's corners as it finds with a radius of at most `radius_m`. False: it needs them all. */
bool fit_rounded_hull(pool *p, const fit_hull *h, double radius_m, fit_shape *out);
void fit_whole_hull(const fit_hull *h, fit_shape *out); /* the hull itself */

/* "sphere", "capsule", "box", "rounded box", "rounded hull", "hull", "mesh", "cylinder". */
const char *fit_shape_word(const load_shape *s);

#endif
