/* take: numbers made of a fuzzer's bytes. What is likely to matter (0, infinity, very large and small, equal to one
 * that was taken before) is a byte away. When the bytes have ended, everything is 0. */
#ifndef COLLIDED_TESTS_FUZZ_TAKE_H
#define COLLIDED_TESTS_FUZZ_TAKE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct taking {
    const uint8_t *at;
    size_t left;
    double last;
} taking;

static inline uint8_t take_byte(taking *t)
{
    if (!t->left) return 0;
    t->left--;
    return *t->at++;
}

static inline double take_raw(taking *t)
{
    uint8_t bytes[8];
    double number;
    for (size_t i = 0; i < sizeof bytes; i++) bytes[i] = take_byte(t);
    memcpy(&number, bytes, sizeof number);
    return number;
}

/* Three in four are multiples of 1/16 between -4 and 4. */
static inline double take_number(taking *t)
{
    static const double ODD[] = {0, -0.0, 1e-300, 5e-324, 1e-12, 1e-6, 1e3, 1e6, 1e9, 1e12, 1e13, 1e300, INFINITY,
        -INFINITY, NAN, -1e9, -1e-9, 0x1p-40, 1 + 0x1p-52};
    enum { ODDS = sizeof ODD / sizeof *ODD };
    uint8_t kind = take_byte(t), value = take_byte(t);
    if (kind < 192)
        t->last = (value - 64) / 16.0 * (kind % 2 ? 1 : -1);
    else if (kind < 224)
        t->last = ODD[value % ODDS];
    else if (kind < 240)
        t->last = nextafter(t->last, value % 2 ? 1e300 : -1e300);
    else if (kind < 248)
        t->last = take_raw(t);
    return t->last;
}

#endif
