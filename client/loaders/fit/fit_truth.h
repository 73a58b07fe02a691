/* fit_truth: what the shapes of a link are, as points outside and triangles inside of them.
 *
 * A mesh is itself both ways. A curved shape is between two polytopes: whatever holds the outer points' hull holds the
 * shape, and what is within e of the inner triangles' solid is within e of the shape. Both in the link's frame. */
#ifndef COLLIDED_LOADERS_FIT_TRUTH_H
#define COLLIDED_LOADERS_FIT_TRUTH_H

#include "fit_hull.h"
#include "loaders/body.h"

typedef struct fit_truth {
    double *outer; /* triples */
    size_t outer_count;
    mesh_triangles inner;
} fit_truth;

/* False: none can be made of these (a type that a URDF does not have, too many triangles, nothing with an inside). The
 * meshes' triangles are loaded already. */
bool fit_truth_of(pool *p, const load_shape *shapes, size_t count, fit_truth *out);

#endif
