#include "elementary_oracle.h"

#include "poly.h"

#include <math.h>
#include <stdlib.h>

typedef struct family { /* the corners of the polygon, each coordinate a linear function of t, in whole numbers */
    int corners;
    poly w[4][3];
    poly volume;
} family;

/* ---- construction ---- */

static const int AROUND[4][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}}; /* end of the first edge, end of the second */

static int corner_count(const elementary_query *q)
{
    return q->kind == ELEMENTARY_VF ? 3 : 4;
}

static void corner_points(const elementary_query *q, int i, int *from, int *to)
{
    *from = q->kind == ELEMENTARY_VF ? 0 : AROUND[i][0];
    *to = q->kind == ELEMENTARY_VF ? 1 + i : 2 + AROUND[i][1];
}

static double coordinate(const vec3 *v, int axis)
{
    return axis == 0 ? v->x : axis == 1 ? v->y : v->z;
}

/* x 2^-exponent, which is whole. */
static void to_whole(mpz_t out, double x, int exponent)
{
    int own;
    double mantissa = frexp(x, &own);
    mpz_set_d(out, ldexp(mantissa, 53));
    if (x != 0) mpz_mul_2exp(out, out, (unsigned long)(own - 53 - exponent));
}

static int least_exponent(const elementary_query *q)
{
    int least = 2000, own;
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++) {
            double x = coordinate(i < 4 ? &q->start[i] : &q->end[i - 4], k);
            (void)frexp(x, &own);
            if (x != 0 && own - 53 < least) least = own - 53;
        }
    return least;
}

static void add_cross(poly *out, const family *f, int i, int j, int axis) /* (w_i x w_j) */
{
    int y = (axis + 1) % 3, z = (axis + 2) % 3;
    poly_add_product(out, &f->w[i][y], &f->w[j][z], 1);
    poly_add_product(out, &f->w[i][z], &f->w[j][y], -1);
}

static void family_init(family *f, const elementary_query *q)
{
    mpz_t from0, to0, from1, to1;
    int exponent = least_exponent(q);
    mpz_inits(from0, to0, from1, to1, NULL);
    f->corners = corner_count(q);
    for (int i = 0; i < f->corners; i++)
        for (int k = 0; k < 3; k++) {
            int from, to;
            corner_points(q, i, &from, &to);
            to_whole(from0, coordinate(&q->start[from], k), exponent);
            to_whole(to0, coordinate(&q->start[to], k), exponent);
            to_whole(from1, coordinate(&q->end[from], k), exponent);
            to_whole(to1, coordinate(&q->end[to], k), exponent);
            mpz_sub(to0, to0, from0);
            mpz_sub(to1, to1, from1);
            mpz_sub(to1, to1, to0);
            poly_init(&f->w[i][k]);
            poly_linear(&f->w[i][k], to0, to1);
        }
    mpz_clears(from0, to0, from1, to1, NULL);
    poly_init(&f->volume);
    for (int k = 0; k < 3; k++) {
        poly c;
        poly_init(&c);
        add_cross(&c, f, 1, 2, k);
        poly_add_product(&f->volume, &f->w[0][k], &c, 1);
        poly_clear(&c);
    }
}

static void family_clear(family *f)
{
    for (int i = 0; i < f->corners; i++)
        for (int k = 0; k < 3; k++) poly_clear(&f->w[i][k]);
    poly_clear(&f->volume);
}

/* ---- inside or outside, at a time that may be algebraic ---- */

typedef struct moment { /* the only root of p between a and b; p NULL: the time a */
    const poly *p;
    const dyadic *a, *b;
} moment;

static int sign_then(const moment *m, const poly *q)
{
    if (q->degree < 0) return 0;
    return m->p ? poly_tarski(m->p, q, m->a, m->b) : poly_sign_at(q, m->a);
}

static int cross_sign(const family *f, const moment *m, int i, int j, int axis)
{
    poly c;
    poly_init(&c);
    add_cross(&c, f, i, j, axis);
    int sign = sign_then(m, &c);
    poly_clear(&c);
    return sign;
}

static int dot_sign(const family *f, const moment *m, int i, int j)
{
    poly c;
    poly_init(&c);
    for (int k = 0; k < 3; k++) poly_add_product(&c, &f->w[i][k], &f->w[j][k], 1);
    int sign = sign_then(m, &c);
    poly_clear(&c);
    return sign;
}

/* (w1 - w0) x (w2 - w1) = w0 x w1 + w1 x w2 - w0 x w2 */
static void normal(const family *f, int axis, poly *out)
{
    add_cross(out, f, 0, 1, axis);
    add_cross(out, f, 1, 2, axis);
    add_cross(out, f, 2, 0, axis);
}

/* All corners on one line: the origin is among them if it is on the line, and not on one side of all. */
static bool in_line(const family *f, const moment *m)
{
    bool around = false;
    for (int i = 0; i < f->corners; i++)
        for (int j = 0; j < i; j++)
            for (int k = 0; k < 3; k++)
                if (cross_sign(f, m, i, j, k) != 0) return false;
    for (int i = 0; i < f->corners && !around; i++)
        for (int j = 0; j <= i && !around; j++) around = dot_sign(f, m, i, j) <= 0;
    return around;
}

/* The volume is zero then. Where the normal is not, seen along an axis that is not in the plane, the origin must be on
 * the same side of each of the polygon's lines. */
static bool inside(const family *f, const moment *m)
{
    for (int k = 0; k < 3; k++) {
        poly n;
        poly_init(&n);
        normal(f, k, &n);
        int side = sign_then(m, &n);
        poly_clear(&n);
        if (side == 0) continue;
        for (int i = 0; i < f->corners; i++)
            if (side * cross_sign(f, m, i, (i + 1) % f->corners, k) < 0) return false;
        return true;
    }
    return in_line(f, m);
}

/* ---- the first root that is a contact ---- */

static void dyadic_set(dyadic *d, const mpz_t number, unsigned long add, unsigned long shift)
{
    mpz_init_set(d->number, number);
    mpz_add_ui(d->number, d->number, add);
    d->shift = shift;
}

static double rounded(const dyadic *d, bool up)
{
    double x = mpz_get_d(d->number); /* towards zero */
    mpz_t back;
    mpz_init_set_d(back, x);
    if (up && mpz_cmp(back, d->number) < 0) x = nextafter(x, INFINITY);
    mpz_clear(back);
    return ldexp(x, -(int)d->shift);
}

static void tell(elementary_truth *out, const dyadic *a, const dyadic *b)
{
    double lo = rounded(a, false), hi = rounded(b, true);
    out->lo = out->touches ? fmin(out->lo, lo) : lo;
    out->hi = out->touches ? fmin(out->hi, hi) : hi;
    out->touches = true;
}

enum { BRACKET_SHIFT = 62 };

static bool first_root(const family *f, const poly *p, const mpz_t number, unsigned long shift, elementary_truth *out);

/* The left half, the middle, the right half of (number, number + 1) / 2^shift, until one holds a contact. */
static bool first_root_in_halves(
    const family *f, const poly *p, const mpz_t number, unsigned long shift, elementary_truth *out)
{
    poly rest;
    dyadic middle;
    mpz_t twice;
    mpz_init(twice);
    mpz_mul_2exp(twice, number, 1);
    dyadic_set(&middle, twice, 1, shift + 1);
    poly_init(&rest);
    poly_copy(&rest, p);
    bool exact = poly_sign_at(p, &middle) == 0;
    if (exact) poly_remove_root(&rest, &middle);
    bool found = first_root(f, &rest, twice, shift + 1, out);
    if (!found && exact && poly_sign_at(&f->volume, &middle) == 0 && inside(f, &(moment){.a = &middle})) {
        tell(out, &middle, &middle);
        found = true;
    }
    mpz_add_ui(twice, twice, 1);
    found = found || first_root(f, &rest, twice, shift + 1, out);
    poly_clear(&rest);
    mpz_clears(twice, middle.number, NULL);
    return found;
}

/* The only root in (number, number + 1) / 2^shift, told to 2^-62: by signs where it changes them, else by counting. */
static void tell_refined(const poly *p, const mpz_t number, unsigned long shift, elementary_truth *out)
{
    dyadic a, b;
    dyadic_set(&a, number, 0, shift);
    dyadic_set(&b, number, 1, shift);
    int left = poly_sign_at(p, &a);
    bool plain = left * poly_sign_at(p, &b) < 0;
    while (a.shift < BRACKET_SHIFT) { /* b is always one step of a's grid further on */
        mpz_mul_2exp(a.number, a.number, 1);
        mpz_add_ui(b.number, a.number, 1); /* the middle */
        b.shift = ++a.shift;
        int middle = poly_sign_at(p, &b);
        if (middle == 0) {
            mpz_set(a.number, b.number);
            break;
        }
        bool in_left = plain ? middle != left : poly_tarski(p, NULL, &a, &b) == 1;
        if (!in_left) mpz_add_ui(a.number, a.number, 1), mpz_add_ui(b.number, b.number, 1);
    }
    tell(out, &a, &b);
    mpz_clears(a.number, b.number, NULL);
}

static bool first_root(const family *f, const poly *p, const mpz_t number, unsigned long shift, elementary_truth *out)
{
    dyadic a, b;
    dyadic_set(&a, number, 0, shift);
    dyadic_set(&b, number, 1, shift);
    int count = p->degree > 0 ? poly_tarski(p, NULL, &a, &b) : 0;
    bool found = false;
    if (count == 1) {
        moment m = {p, &a, &b};
        found = sign_then(&m, &f->volume) == 0 && inside(f, &m);
        if (found) tell_refined(p, number, shift, out);
    } else if (count > 1) {
        found = first_root_in_halves(f, p, number, shift, out);
    }
    mpz_clears(a.number, b.number, NULL);
    return found;
}

static bool try_end(const family *f, unsigned long t, elementary_truth *out)
{
    dyadic end;
    mpz_init_set_ui(end.number, t);
    end.shift = 0;
    bool found = poly_sign_at(&f->volume, &end) == 0 && inside(f, &(moment){.a = &end});
    if (found) tell(out, &end, &end);
    mpz_clear(end.number);
    return found;
}

static void try_roots(const family *f, const poly *p, elementary_truth *out)
{
    poly rest;
    mpz_t zero;
    if (p->degree <= 0) return;
    mpz_init(zero);
    poly_init(&rest);
    poly_copy(&rest, p);
    for (unsigned long t = 0; t < 2; t++) {
        dyadic end;
        mpz_init_set_ui(end.number, t);
        end.shift = 0;
        poly_remove_root(&rest, &end);
        mpz_clear(end.number);
    }
    first_root(f, &rest, zero, 0, out);
    poly_clear(&rest);
    mpz_clear(zero);
}

/* The volume is zero throughout: every quadratic that `inside` looks at may bring the change. */
static void try_all(const family *f, elementary_truth *out)
{
    poly p;
    poly_init(&p);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < f->corners; i++)
            for (int j = 0; j < i; j++) {
                poly_clear(&p), poly_init(&p);
                add_cross(&p, f, i, j, k);
                try_roots(f, &p, out);
            }
        poly_clear(&p), poly_init(&p);
        normal(f, k, &p);
        try_roots(f, &p, out);
    }
    for (int i = 0; i < f->corners; i++)
        for (int j = 0; j <= i; j++) {
            poly_clear(&p), poly_init(&p);
            for (int k = 0; k < 3; k++) poly_add_product(&p, &f->w[i][k], &f->w[j][k], 1);
            try_roots(f, &p, out);
        }
    poly_clear(&p);
}

/* Its Bernstein coefficients on [0, 1] have one sign: no root. Spares most queries the rest. */
static bool never_zero(const poly *cubic)
{
    static const unsigned long SHARE[4][4] = {{1, 0, 0, 0}, {3, 1, 0, 0}, {3, 2, 1, 0}, {1, 1, 1, 1}};
    mpz_t sum;
    int signs = 0;
    mpz_init(sum);
    for (int i = 0; i < 4; i++) {
        mpz_set_ui(sum, 0);
        for (int k = 0; k < 4; k++) mpz_addmul_ui(sum, cubic->at[k], SHARE[i][k]);
        signs += mpz_sgn(sum);
    }
    mpz_clear(sum);
    return abs(signs) == 4;
}

elementary_truth elementary_oracle(const elementary_query *q)
{
    elementary_truth truth = {.lo = 2, .hi = 2};
    family f;
    family_init(&f, q);
    if (!never_zero(&f.volume) && !try_end(&f, 0, &truth)) {
        if (f.volume.degree < 0)
            try_all(&f, &truth);
        else
            try_roots(&f, &f.volume, &truth);
        if (!truth.touches) try_end(&f, 1, &truth);
    }
    family_clear(&f);
    return truth;
}
