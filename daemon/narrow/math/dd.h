/* dd: numbers of about 106 bits, each the unevaluated sum of two doubles: for the last word on a pair, not for search.
 *
 * Dekker, "A floating-point technique for extending the available precision", 1971; Knuth's two-sum. Only + - * / and
 * sqrt of doubles, so every compiler gets the same bits (-ffp-contract=off). Each operation errs by less than 2^-100 of
 * its terms, for numbers within 2^+-400; what enters here is of about unit size. Plain values. */
#ifndef COLLIDED_NARROW_MATH_DD_H
#define COLLIDED_NARROW_MATH_DD_H

#include "geom/round.h"

typedef struct dd {
    double hi, lo;
} dd;

typedef struct dd3 {
    dd x, y, z;
} dd3;

typedef struct dd_mat { /* columns */
    dd3 x, y, z;
} dd_mat;

static inline dd dd_of(double a)
{
    return (dd){a, 0};
}
static inline dd dd_neg(dd a)
{
    return (dd){-a.hi, -a.lo};
}

static inline dd dd_two_sum(double a, double b)
{
    double s = a + b, b_part = s - a;
    return (dd){s, (a - (s - b_part)) + (b - b_part)};
}

static inline dd dd_quick_sum(double a, double b) /* |a| >= |b| */
{
    double s = a + b;
    return (dd){s, b - (s - a)};
}

static inline dd dd_two_product(double a, double b)
{
    double p = a * b, ca = 0x1.0000002p27 * a, cb = 0x1.0000002p27 * b;
    double a_hi = ca - (ca - a), a_lo = a - a_hi, b_hi = cb - (cb - b), b_lo = b - b_hi;
    return (dd){p, ((a_hi * b_hi - p) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo};
}

static inline dd dd_add(dd a, dd b)
{
    dd s = dd_two_sum(a.hi, b.hi);
    return dd_quick_sum(s.hi, s.lo + (a.lo + b.lo));
}

static inline dd dd_sub(dd a, dd b)
{
    return dd_add(a, dd_neg(b));
}

static inline dd dd_mul(dd a, dd b)
{
    dd p = dd_two_product(a.hi, b.hi);
    return dd_quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline dd dd_mul_double(dd a, double b)
{
    dd p = dd_two_product(a.hi, b);
    return dd_quick_sum(p.hi, p.lo + a.lo * b);
}

/* a (1 - part), for a part of less than 2^-48. */
static inline dd dd_less_part(dd a, double part)
{
    return dd_quick_sum(a.hi, a.lo - a.hi * part);
}

static inline dd dd_div(dd a, dd b)
{
    double q = a.hi / b.hi;
    dd rest = dd_sub(a, dd_mul(dd_of(q), b));
    double next = rest.hi / b.hi;
    rest = dd_sub(rest, dd_mul(dd_of(next), b));
    return dd_add(dd_quick_sum(q, next), dd_of(rest.hi / b.hi));
}

static inline dd dd_sqrt(dd a) /* one step of Newton doubles the bits of the root */
{
    if (!(a.hi > 0)) return dd_of(0);
    double root = sqrt(a.hi);
    dd rest = dd_sub(a, dd_two_product(root, root));
    return dd_quick_sum(root, rest.hi / (2 * root));
}

static inline dd dd_scale(dd a, double power_of_two)
{
    return (dd){a.hi * power_of_two, a.lo * power_of_two};
}
static inline bool dd_less(dd a, dd b)
{
    return a.hi < b.hi || (a.hi == b.hi && a.lo < b.lo);
}
static inline dd dd_max(dd a, dd b)
{
    return dd_less(a, b) ? b : a;
}
static inline dd dd_min(dd a, dd b)
{
    return dd_less(b, a) ? b : a;
}
static inline dd dd_abs(dd a)
{
    return a.hi < 0 ? dd_neg(a) : a;
}

/* Doubles not above and not below. */
static inline double dd_down(dd a)
{
    return a.lo < 0 ? -next_above(-a.hi) : a.hi;
}
static inline double dd_up(dd a)
{
    return a.lo > 0 ? next_above(a.hi) : a.hi;
}

static inline dd3 dd3_of(vec3 a)
{
    return (dd3){dd_of(a.x), dd_of(a.y), dd_of(a.z)};
}
static inline vec3 dd3_round(dd3 a)
{
    return (vec3){a.x.hi, a.y.hi, a.z.hi};
}
static inline dd3 dd3_neg(dd3 a)
{
    return (dd3){dd_neg(a.x), dd_neg(a.y), dd_neg(a.z)};
}
static inline dd3 dd3_add(dd3 a, dd3 b)
{
    return (dd3){dd_add(a.x, b.x), dd_add(a.y, b.y), dd_add(a.z, b.z)};
}
static inline dd3 dd3_sub(dd3 a, dd3 b)
{
    return dd3_add(a, dd3_neg(b));
}
static inline dd3 dd3_scale(dd3 a, dd s)
{
    return (dd3){dd_mul(a.x, s), dd_mul(a.y, s), dd_mul(a.z, s)};
}

static inline dd dd3_dot(dd3 a, dd3 b)
{
    return dd_add(dd_add(dd_mul(a.x, b.x), dd_mul(a.y, b.y)), dd_mul(a.z, b.z));
}

static inline dd dd3_dot_vec(dd3 a, vec3 b)
{
    return dd_add(dd_add(dd_mul_double(a.x, b.x), dd_mul_double(a.y, b.y)), dd_mul_double(a.z, b.z));
}

static inline dd dd3_norm(dd3 a)
{
    return dd_sqrt(dd3_dot(a, a));
}

static inline dd3 dd3_cross(dd3 a, dd3 b)
{
    return (dd3){dd_sub(dd_mul(a.y, b.z), dd_mul(a.z, b.y)), dd_sub(dd_mul(a.z, b.x), dd_mul(a.x, b.z)),
        dd_sub(dd_mul(a.x, b.y), dd_mul(a.y, b.x))};
}

static inline dd3 dd_mat_mul(const dd_mat *m, dd3 v)
{
    return dd3_add(dd3_add(dd3_scale(m->x, v.x), dd3_scale(m->y, v.y)), dd3_scale(m->z, v.z));
}

static inline dd3 dd_mat_tmul(const dd_mat *m, dd3 v)
{
    return (dd3){dd3_dot(m->x, v), dd3_dot(m->y, v), dd3_dot(m->z, v)};
}

#endif
