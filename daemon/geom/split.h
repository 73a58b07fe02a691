/* split: how the hierarchies of a mesh and of a compound divide their items. An item begins with its centre, three
 * doubles; it is divided along the axis on which the centres lie furthest apart. Pure; any thread. */
#ifndef COLLIDED_GEOM_SPLIT_H
#define COLLIDED_GEOM_SPLIT_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

/* Of so many items, each of `size` bytes. The first of equal axes. */
static inline int split_axis(const void *items, uint32_t count, size_t size)
{
    int longest = 0;
    double length = -1;
    for (int k = 0; k < 3; k++) {
        double lo = INFINITY, hi = -INFINITY;
        for (uint32_t i = 0; i < count; i++) {
            const double *centre = (const double *)((const char *)items + i * size);
            lo = fmin(lo, centre[k]);
            hi = fmax(hi, centre[k]);
        }
        if (hi - lo > length) length = hi - lo, longest = k;
    }
    return longest;
}

/* The order along an axis, as qsort wants it; of equal centres by the items' numbers, so that there is only one. */
static inline int split_compare(const double a[3], const double b[3], int axis, uint32_t number_a, uint32_t number_b)
{
    if (a[axis] != b[axis]) return a[axis] < b[axis] ? -1 : 1;
    return (number_a > number_b) - (number_a < number_b);
}

#endif
