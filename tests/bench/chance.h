/* chance: what the scenes of the benchmarks draw. */
#ifndef COLLIDED_BENCH_CHANCE_H
#define COLLIDED_BENCH_CHANCE_H

#include "base/prng.h"
#include "geom/vec.h"

typedef struct chance {
    uint64_t x;
} chance;

static inline double chance_in(chance *c, double lo, double hi)
{
    return prng_in(&c->x, lo, hi);
}

static inline vec3 chance_direction(chance *c)
{
    for (;;) {
        vec3 v = vec(chance_in(c, -1, 1), chance_in(c, -1, 1), chance_in(c, -1, 1));
        double n = vec_norm2(v);
        if (n > 0.01 && n < 1) return vec_unit(v);
    }
}

static inline quat chance_rotation(chance *c)
{
    for (;;) {
        quat q = {chance_in(c, -1, 1), chance_in(c, -1, 1), chance_in(c, -1, 1), chance_in(c, -1, 1)};
        double n = quat_norm2(q);
        if (n > 0.01 && n < 1) return quat_unit(q);
    }
}

#endif
