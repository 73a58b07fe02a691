/* body: what the oracle's own files share about bodies. */
#ifndef COLLIDED_TESTS_ORACLE_BODY_H
#define COLLIDED_TESTS_ORACLE_BODY_H

#include "oracle.h"

#include <stdlib.h>

qvec body_plane_normal(const oracle_body *halfspace); /* unit, outward, in the world */

/* Memory of a test: there is no sensible way to go on without it. */
static inline void *body_allocate(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) abort();
    return memory;
}

#endif
