/* expansion: numbers as exact sums of doubles, for signs that must be right.
 *
 * Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", 1997: components do
 * not overlap and grow, so the last one that is not 0 has the sign of the whole. Exact as long as no product leaves the
 * range of a double. Plain values; room is the caller's. */
#ifndef COLLIDED_GEOM_EXPANSION_H
#define COLLIDED_GEOM_EXPANSION_H

#include "vec.h"

static inline void expansion_two_sum(double a, double b, double *sum, double *error)
{
    double s = a + b, b_part = s - a;
    *error = (a - (s - b_part)) + (b - b_part);
    *sum = s;
}

static inline void expansion_two_product(double a, double b, double *product, double *error)
{
    double p = a * b, ca = 0x1.0000002p27 * a, cb = 0x1.0000002p27 * b;
    double a_hi = ca - (ca - a), a_lo = a - a_hi, b_hi = cb - (cb - b), b_lo = b - b_hi;
    *error = ((a_hi * b_hi - p) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo;
    *product = p;
}

/* e += b, in place; e has room for one more. Returns the new count. */
static inline int expansion_grow(int n, double *e, double b)
{
    double carry = b;
    for (int i = 0; i < n; i++) expansion_two_sum(carry, e[i], &carry, &e[i]);
    e[n] = carry;
    return n + 1;
}

/* e += f, in place. */
static inline int expansion_add(int n, double *e, int m, const double *f)
{
    for (int i = 0; i < m; i++) n = expansion_grow(n, e, f[i]);
    return n;
}

/* e += f * b, in place: two components a component of f. */
static inline int expansion_add_scaled(int n, double *e, int m, const double *f, double b)
{
    for (int i = 0; i < m; i++) {
        double product, error;
        expansion_two_product(f[i], b, &product, &error);
        n = expansion_grow(n, e, error);
        n = expansion_grow(n, e, product);
    }
    return n;
}

static inline int expansion_sign(int n, const double *e)
{
    while (n > 0 && e[n - 1] == 0) n--;
    return n == 0 ? 0 : e[n - 1] > 0 ? 1 : -1;
}

#endif
