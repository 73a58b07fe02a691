/* prng: the random numbers of all tests and benchmarks: splitmix64 (Steele, Lea and Flood 2014), so that every run sees
 * the same. A state is a number that the test begins with; each thread has its own. */
#ifndef COLLIDED_TESTS_BASE_PRNG_H
#define COLLIDED_TESTS_BASE_PRNG_H

#include <stdint.h>

static inline uint64_t prng_bits(uint64_t *state)
{
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static inline double prng_in(uint64_t *state, double lo, double hi) /* [lo, hi) */
{
    return lo + (hi - lo) * (double)(prng_bits(state) >> 11) * 0x1p-53;
}

/* The same, for who would rather have a structure. */
typedef struct prng {
    uint64_t state;
} prng;

static inline uint64_t prng_next(prng *r)
{
    return prng_bits(&r->state);
}

static inline uint32_t prng_below(prng *r, uint32_t bound)
{
    return (uint32_t)(prng_next(r) % bound);
}

static inline double prng_between(prng *r, double lo, double hi)
{
    return prng_in(&r->state, lo, hi);
}

#endif
