/* prng: splitmix64 (Steele, Lea and Flood 2014), so that every run of a test sees the same numbers. */
#ifndef COLLIDED_TESTS_BASE_PRNG_H
#define COLLIDED_TESTS_BASE_PRNG_H

#include <stdint.h>

typedef struct prng {
    uint64_t state;
} prng;

static inline uint64_t prng_next(prng *r)
{
    uint64_t z = (r->state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static inline uint32_t prng_below(prng *r, uint32_t bound)
{
    return (uint32_t)(prng_next(r) % bound);
}

#endif
