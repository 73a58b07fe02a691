/* poly: polynomials of small degree with integer coefficients, and the signs of one at the roots of another, exactly
 * (GMP). Points are dyadic: number / 2^shift. */
#ifndef COLLIDED_TESTS_ELEMENTARY_POLY_H
#define COLLIDED_TESTS_ELEMENTARY_POLY_H

#include <gmp.h>
#include <stdbool.h>

enum { POLY_COEFFICIENTS = 8 };

typedef struct poly {
    int degree; /* -1 = zero */
    mpz_t at[POLY_COEFFICIENTS];
} poly;

typedef struct dyadic { /* number / 2^shift */
    mpz_t number;
    unsigned long shift;
} dyadic;

void poly_init(poly *p); /* zero */
void poly_clear(poly *p);
void poly_linear(poly *p, const mpz_t constant, const mpz_t slope);
void poly_copy(poly *out, const poly *p);
/* out += sign a b; out is neither a nor b. */
void poly_add_product(poly *out, const poly *a, const poly *b, int sign);

int poly_sign_at(const poly *p, const dyadic *x);

/* Divides by the greatest power of (x - point). */
void poly_remove_root(poly *p, const dyadic *point);

/* The sum of sign(q) over the distinct real roots of p between a and b, where p must not vanish (Tarski; for q = 1
 * Sturm's count). For an interval that isolates one root: the sign of q there. q NULL = 1. */
int poly_tarski(const poly *p, const poly *q, const dyadic *a, const dyadic *b);

#endif
