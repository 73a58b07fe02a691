/* quickhull: a run of qhull (Barber et al., "The Quickhull algorithm for convex hulls", 1996) over a few points. Any
 * thread. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_QUICKHULL_H
#define COLLIDED_LOADERS_DECOMPOSE_QUICKHULL_H

#include "loaders/pool.h"

#include <stdbool.h>
#include <stddef.h>

/* Sorts triples by their coordinates, and keeps of equal ones the first. How many are left. */
size_t quickhull_sort(double *points, size_t count);

/* `command`: qhull's options, as "qhull Pp". `take` is called with its answer (a qhT) while it is there. False if qhull
 * finds no hull with an inside. The points stay as they are. */
bool quickhull_run(pool *p, const double *points, size_t count, const char *command,
    void (*take)(void *context, void *qhull), void *context);

#endif
