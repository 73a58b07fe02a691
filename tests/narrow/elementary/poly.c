#include "poly.h"

#include <stdlib.h>

void poly_init(poly *p)
{
    p->degree = -1;
    for (int i = 0; i < POLY_COEFFICIENTS; i++) mpz_init(p->at[i]);
}

void poly_clear(poly *p)
{
    for (int i = 0; i < POLY_COEFFICIENTS; i++) mpz_clear(p->at[i]);
}

static void trim(poly *p)
{
    p->degree = POLY_COEFFICIENTS - 1;
    while (p->degree >= 0 && mpz_sgn(p->at[p->degree]) == 0) p->degree--;
}

void poly_linear(poly *p, const mpz_t constant, const mpz_t slope)
{
    for (int i = 2; i < POLY_COEFFICIENTS; i++) mpz_set_ui(p->at[i], 0);
    mpz_set(p->at[0], constant);
    mpz_set(p->at[1], slope);
    trim(p);
}

void poly_copy(poly *out, const poly *p)
{
    for (int i = 0; i < POLY_COEFFICIENTS; i++) mpz_set(out->at[i], p->at[i]);
    out->degree = p->degree;
}

void poly_add_product(poly *out, const poly *a, const poly *b, int sign)
{
    if (a->degree + b->degree >= POLY_COEFFICIENTS) abort();
    for (int i = 0; i <= a->degree; i++)
        for (int k = 0; k <= b->degree; k++)
            if (sign > 0)
                mpz_addmul(out->at[i + k], a->at[i], b->at[k]);
            else
                mpz_submul(out->at[i + k], a->at[i], b->at[k]);
    trim(out);
}

int poly_sign_at(const poly *p, const dyadic *x)
{
    mpz_t sum, term;
    if (p->degree < 0) return 0;
    mpz_inits(sum, term, NULL);
    mpz_set(sum, p->at[p->degree]);
    for (int i = p->degree - 1; i >= 0; i--) { /* Horner, times 2^shift a degree */
        mpz_mul(sum, sum, x->number);
        mpz_mul_2exp(term, p->at[i], x->shift * (unsigned long)(p->degree - i));
        mpz_add(sum, sum, term);
    }
    int sign = mpz_sgn(sum);
    mpz_clears(sum, term, NULL);
    return sign;
}

void poly_remove_root(poly *p, const dyadic *point)
{
    mpz_t carry, power;
    mpz_inits(carry, power, NULL);
    while (p->degree > 0 && poly_sign_at(p, point) == 0) {
        /* p * 2^(shift * degree), divided by (x - point) from the top: all stays whole. */
        mpz_set_ui(power, 1);
        mpz_mul_2exp(power, power, point->shift * (unsigned long)p->degree);
        for (int i = 0; i <= p->degree; i++) mpz_mul(p->at[i], p->at[i], power);
        mpz_set_ui(carry, 0);
        for (int i = p->degree; i >= 0; i--) {
            mpz_mul(carry, carry, point->number);
            mpz_fdiv_q_2exp(carry, carry, point->shift);
            mpz_add(carry, carry, p->at[i]);
            mpz_set(p->at[i], carry);
        }
        for (int i = 0; i < p->degree; i++) mpz_set(p->at[i], p->at[i + 1]);
        mpz_set_ui(p->at[p->degree--], 0);
    }
    mpz_clears(carry, power, NULL);
}

/* Without the common factor of its coefficients. */
static void make_primitive(poly *p)
{
    mpz_t common;
    mpz_init(common);
    for (int i = 0; i <= p->degree; i++) mpz_gcd(common, common, p->at[i]);
    if (mpz_cmp_ui(common, 1) > 0)
        for (int i = 0; i <= p->degree; i++) mpz_divexact(p->at[i], p->at[i], common);
    mpz_clear(common);
}

/* a becomes minus the remainder of a by b, times something positive. */
static void negated_remainder(poly *a, const poly *b)
{
    mpz_t lead, factor;
    mpz_inits(lead, factor, NULL);
    mpz_abs(factor, b->at[b->degree]);
    while (a->degree >= b->degree) {
        int shift = a->degree - b->degree;
        mpz_set(lead, a->at[a->degree]);
        if (mpz_sgn(b->at[b->degree]) < 0) mpz_neg(lead, lead);
        for (int i = 0; i <= a->degree; i++) mpz_mul(a->at[i], a->at[i], factor);
        for (int i = 0; i <= b->degree; i++) mpz_submul(a->at[i + shift], lead, b->at[i]);
        trim(a);
    }
    for (int i = 0; i <= a->degree; i++) mpz_neg(a->at[i], a->at[i]);
    make_primitive(a);
    mpz_clears(lead, factor, NULL);
}

static int changes(int sign, int *last)
{
    if (sign == 0) return 0;
    int change = *last != 0 && sign != *last;
    *last = sign;
    return change;
}

int poly_tarski(const poly *p, const poly *q, const dyadic *a, const dyadic *b)
{
    poly s[2], slope;
    int sum = 0, last_a = 0, last_b = 0;
    poly_init(&s[0]), poly_init(&s[1]), poly_init(&slope);
    poly_copy(&s[0], p);
    for (int i = 1; i <= p->degree; i++) mpz_mul_ui(slope.at[i - 1], p->at[i], (unsigned long)i);
    trim(&slope);
    if (q)
        poly_add_product(&s[1], &slope, q, 1);
    else
        poly_copy(&s[1], &slope);
    make_primitive(&s[0]), make_primitive(&s[1]);
    for (int now = 0; s[now].degree >= 0; now = !now) { /* the signed remainders */
        sum += changes(poly_sign_at(&s[now], a), &last_a) - changes(poly_sign_at(&s[now], b), &last_b);
        if (s[!now].degree < 0) break;
        poly *next = &s[now];
        negated_remainder(next, &s[!now]);
    }
    poly_clear(&s[0]), poly_clear(&s[1]), poly_clear(&slope);
    return sum;
}
