/* verify_scan: one look at all points of a hull: are they numbers, how far they reach, and how high along a direction.
 * With 64-byte or 32-byte registers where the processor has them. Pure; any thread. */
#ifndef COLLIDED_CLIENT_VERIFY_SCAN_H
#define COLLIDED_CLIENT_VERIFY_SCAN_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

typedef double real;

typedef struct vec {
    real x, y, z;
} vec;

enum { SCAN_CHUNKS = 32 };

typedef struct points_scan {
    bool finite;
    vec along;                   /* the direction */
    real top;                    /* greatest along . p */
    real reach2;                 /* greatest p . p; infinite when squares overflow */
    size_t in_chunks, chunk;     /* points that are in chunks, and how many are in each */
    real chunk_top[SCAN_CHUNKS]; /* its greatest along . p */
} points_scan;

/* `points`: count (above 0) triples x, y, z. */
void points_look(const double *points, size_t count, vec along, points_scan *out);

/* The same by one kernel, for tests: only where points_look_has says that the processor can. */
typedef enum points_width { POINTS_PLAIN, POINTS_AVX2, POINTS_AVX512, POINTS_WIDTHS } points_width;
bool points_look_has(points_width width);
void points_look_by(points_width width, const double *points, size_t count, vec along, points_scan *out);

/* The points of which along . p is not less than top - depth, but no more than `most`. How many. */
int points_on_top(const double *points, size_t count, const points_scan *s, real depth, vec *out, int most);

static inline bool all_finite(const double *x, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

#endif
