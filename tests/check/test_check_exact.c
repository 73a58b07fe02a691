/* None is accepted that is false: what the kernel proves of hostile and corrupted certificates is held against MPFR,
 * whose 300 bits leave nothing to doubt here. lo is compared with the gap along the axis; hi with the points' distance
 * and how far they are from the shapes, found in another way than the kernel does: as the greatest of what planes say
 * (hulls, ellipsoids) or by formulas. At night 10^8 cases, of which each 100th is aimed. */
#include "base/prng.h"
#include "cases.h"
#include "check_cases.h"
#include "client/cmocka_c.h"

#include <math.h>
#include <mpfr.h>
#include <stdlib.h>
#include <string.h>

enum { BITS = 300 };

typedef mpfr_t vec_m[3];
enum { POOL = 64 };
static mpfr_t pool[POOL]; /* for expressions: reset() gives all of them back */
static int used;

static mpfr_ptr fresh(void)
{
    assert_true(used < POOL);
    return pool[used++];
}
static void reset(void)
{
    used = 0;
}

static void vec_set(vec_m v, const double from[3])
{
    for (int i = 0; i < 3; i++) mpfr_set_d(v[i], from[i], MPFR_RNDN);
}

static mpfr_ptr dot_m(vec_m a, vec_m b)
{
    mpfr_ptr sum = fresh(), t = fresh();
    mpfr_set_zero(sum, 1);
    for (int i = 0; i < 3; i++) {
        mpfr_mul(t, a[i], b[i], MPFR_RNDN);
        mpfr_add(sum, sum, t, MPFR_RNDN);
    }
    used--;
    return sum;
}

/* By the rotation's matrix: another formula than the kernel's. `back`: by its transpose. */
static void turn_m(const double q[4], bool back, vec_m v)
{
    mpfr_t m[3][3], e[4], t, n;
    mpfr_inits2(BITS, t, n, (mpfr_ptr)0);
    for (int i = 0; i < 4; i++) mpfr_init2(e[i], BITS), mpfr_set_d(e[i], q[i], MPFR_RNDN);
    mpfr_set_zero(n, 1);
    for (int i = 0; i < 4; i++) mpfr_sqr(t, e[i], MPFR_RNDN), mpfr_add(n, n, t, MPFR_RNDN);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) { /* 2 (x_i x_k + w eps x_l) / n, and 1 - 2 (sum of the other squares) / n */
            mpfr_init2(m[i][k], BITS);
            mpfr_mul(m[i][k], e[1 + i], e[1 + k], MPFR_RNDN);
            if (i == k) {
                mpfr_sqr(t, e[0], MPFR_RNDN);
            } else {
                mpfr_mul(t, e[0], e[1 + 3 - i - k], MPFR_RNDN);
                if ((k - i + 3) % 3 == 1) mpfr_neg(t, t, MPFR_RNDN);
            }
            mpfr_add(m[i][k], m[i][k], t, MPFR_RNDN);
            mpfr_mul_ui(m[i][k], m[i][k], 2, MPFR_RNDN);
            mpfr_div(m[i][k], m[i][k], n, MPFR_RNDN);
            if (i == k) mpfr_sub_ui(m[i][k], m[i][k], 1, MPFR_RNDN);
        }
    vec_m out;
    for (int i = 0; i < 3; i++) {
        mpfr_init2(out[i], BITS);
        mpfr_set_zero(out[i], 1);
        for (int k = 0; k < 3; k++) {
            mpfr_mul(t, back ? m[k][i] : m[i][k], v[k], MPFR_RNDN);
            mpfr_add(out[i], out[i], t, MPFR_RNDN);
        }
    }
    for (int i = 0; i < 3; i++) mpfr_set(v[i], out[i], MPFR_RNDN), mpfr_clear(out[i]);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) mpfr_clear(m[i][k]);
    for (int i = 0; i < 4; i++) mpfr_clear(e[i]);
    mpfr_clears(t, n, (mpfr_ptr)0);
}

/* out = max(out, x) */
static void grow(mpfr_ptr out, mpfr_ptr x)
{
    mpfr_max(out, out, x, MPFR_RNDN);
}

static void core_support_m(const collided_check_shape *s, vec_m d, mpfr_ptr out)
{
    int before = used;
    mpfr_ptr across = fresh(), t = fresh(), z = fresh();
    mpfr_hypot(across, d[0], d[1], MPFR_RNDN);
    mpfr_mul_d(across, across, s->half[0], MPFR_RNDN);
    mpfr_mul_d(z, d[2], s->half[2], MPFR_RNDN);
    mpfr_abs(t, z, MPFR_RNDN);
    mpfr_set_zero(out, 1);
    switch (s->kind) {
    case COLLIDED_CHECK_CAPSULE:
        mpfr_set(out, t, MPFR_RNDN);
        break;
    case COLLIDED_CHECK_BOX:
        for (int i = 0; i < 3; i++) {
            mpfr_abs(t, d[i], MPFR_RNDN);
            mpfr_mul_d(t, t, s->half[i], MPFR_RNDN);
            mpfr_add(out, out, t, MPFR_RNDN);
        }
        break;
    case COLLIDED_CHECK_CYLINDER:
        mpfr_add(out, across, t, MPFR_RNDN);
        break;
    case COLLIDED_CHECK_CONE:
        mpfr_sub(t, across, z, MPFR_RNDN);
        mpfr_max(out, t, z, MPFR_RNDN);
        break;
    case COLLIDED_CHECK_ELLIPSOID:
        for (int i = 0; i < 3; i++) {
            mpfr_mul_d(t, d[i], s->half[i], MPFR_RNDN);
            mpfr_hypot(out, out, t, MPFR_RNDN);
        }
        break;
    case COLLIDED_CHECK_HULL:
        mpfr_set_inf(out, -1);
        for (size_t i = 0; i < s->point_count; i++) {
            mpfr_set_zero(t, 1);
            for (size_t k = 0; k < 3; k++) {
                mpfr_mul_d(z, d[k], s->points[3 * i + k], MPFR_RNDN);
                mpfr_add(t, t, z, MPFR_RNDN);
            }
            grow(out, t);
        }
        break;
    default:
        break;
    }
    used = before;
}

static size_t parts(const collided_check_shape *s)
{
    return s->child_count ? s->child_count : 1;
}

static const collided_check_shape *part(const collided_check_shape *s, size_t i)
{
    return s->child_count ? &s->children[i] : s;
}

/* Greatest n . x in the world; n is unit. */
static void support_m(const check_subject *s, vec_m n, mpfr_ptr out)
{
    vec_m d;
    mpfr_t sum, t;
    mpfr_inits2(BITS, sum, t, d[0], d[1], d[2], (mpfr_ptr)0);
    mpfr_set_inf(out, -1);
    for (size_t i = 0; i < parts(&s->shape); i++) {
        const collided_check_shape *core = part(&s->shape, i);
        const double *frames[3] = {s->pose, s->shape.pose, core->pose};
        for (int k = 0; k < 3; k++) mpfr_set(d[k], n[k], MPFR_RNDN);
        mpfr_set_d(sum, core->radius, MPFR_RNDN);
        if (core != &s->shape) mpfr_add_d(sum, sum, s->shape.radius, MPFR_RNDN);
        for (int k = 0; k < (s->shape.child_count ? 3 : 2); k++) {
            for (int j = 0; j < 3; j++) mpfr_mul_d(t, d[j], frames[k][j], MPFR_RNDN), mpfr_add(sum, sum, t, MPFR_RNDN);
            turn_m(frames[k] + 3, true, d);
        }
        core_support_m(core, d, t);
        mpfr_add(sum, sum, t, MPFR_RNDN);
        grow(out, sum);
    }
    mpfr_clears(sum, t, d[0], d[1], d[2], (mpfr_ptr)0);
}

static void unit_m(vec_m n)
{
    mpfr_ptr norm = dot_m(n, n);
    mpfr_sqrt(norm, norm, MPFR_RNDN);
    for (int i = 0; i < 3; i++) mpfr_div(n[i], n[i], norm, MPFR_RNDN);
    reset();
}

/* The gap along the axis; infinitely little between half-spaces. */
static void gap_m(const check_case *c, mpfr_ptr out)
{
    vec_m n;
    mpfr_t far;
    mpfr_inits2(BITS, far, n[0], n[1], n[2], (mpfr_ptr)0);
    bool plane_a = c->a.shape.kind == COLLIDED_CHECK_HALFSPACE, plane_b = c->b.shape.kind == COLLIDED_CHECK_HALFSPACE;
    vec_set(n, c->claim.axis);
    if (plane_a || plane_b) {
        const check_subject *s = plane_a ? &c->a : &c->b;
        vec_set(n, (double[]){0, 0, plane_a ? 1 : -1});
        turn_m(s->shape.pose + 3, false, n);
        turn_m(s->pose + 3, false, n);
    }
    unit_m(n);
    support_m(&c->a, n, out);
    for (int i = 0; i < 3; i++) mpfr_neg(n[i], n[i], MPFR_RNDN);
    support_m(&c->b, n, far);
    mpfr_add(out, out, far, MPFR_RNDN);
    mpfr_neg(out, out, MPFR_RNDN);
    if (plane_a && plane_b) mpfr_set_inf(out, -1);
    mpfr_clears(far, n[0], n[1], n[2], (mpfr_ptr)0);
}

/* From below: no point of the part is nearer to q than (d . q - support(d)) / |d|, for any d: the axes, the axes'
 * planes, and the way from the point that a search proposes. For boxes, balls and half-spaces the true distance. */
static void part_distance_m(const check_subject *s, size_t index, const double point[3], mpfr_ptr out)
{
    const collided_check_shape *core = part(&s->shape, index);
    const double *frames[3] = {s->pose, s->shape.pose, core->pose};
    vec_m q, d, clamped;
    mpfr_t t, h;
    mpfr_inits2(BITS, t, h, q[0], q[1], q[2], d[0], d[1], d[2], clamped[0], clamped[1], clamped[2], (mpfr_ptr)0);
    vec_set(q, point);
    for (int k = 0; k < (s->shape.child_count ? 3 : 2); k++) {
        for (int j = 0; j < 3; j++) mpfr_sub_d(q[j], q[j], frames[k][j], MPFR_RNDN);
        turn_m(frames[k] + 3, true, q);
    }
    double near[3];
    check_nearest(s, index, point, near);
    mpfr_set_zero(out, 1);
    for (int way = 0; way < 6; way++) {
        for (int i = 0; i < 3; i++) {
            if (way < 3) mpfr_set(d[i], q[i], MPFR_RNDN); /* the whole way, without z, or z alone */
            if ((way == 1 && i == 2) || (way == 2 && i < 2)) mpfr_set_zero(d[i], 1);
            if (way == 3) mpfr_sub_d(d[i], q[i], near[i], MPFR_RNDN);
            if (way == 4) { /* from the box of the half extents */
                double half = core->kind == COLLIDED_CHECK_CAPSULE && i < 2 ? 0 : core->half[i];
                mpfr_abs(t, q[i], MPFR_RNDN);
                mpfr_sub_d(t, t, half, MPFR_RNDN);
                if (mpfr_sgn(t) < 0) mpfr_set_zero(t, 1);
                mpfr_mul_si(d[i], t, mpfr_sgn(q[i]) < 0 ? -1 : 1, MPFR_RNDN);
            }
            if (way == 5) { /* across a cone's slant, or from a cylinder's rim */
                mpfr_hypot(h, q[0], q[1], MPFR_RNDN);
                if (mpfr_zero_p(h)) mpfr_set_ui(h, 1, MPFR_RNDN);
                if (i < 2) {
                    mpfr_div(d[i], q[i], h, MPFR_RNDN);
                    if (core->kind == COLLIDED_CHECK_CYLINDER) {
                        mpfr_sub_d(t, h, core->half[0], MPFR_RNDN);
                        if (mpfr_sgn(t) < 0) mpfr_set_zero(t, 1);
                        mpfr_mul(d[i], d[i], t, MPFR_RNDN);
                    } else {
                        mpfr_mul_d(d[i], d[i], 2 * core->half[2], MPFR_RNDN);
                    }
                } else if (core->kind == COLLIDED_CHECK_CONE) {
                    mpfr_set_d(d[i], core->half[0], MPFR_RNDN);
                } else {
                    mpfr_abs(t, q[i], MPFR_RNDN);
                    mpfr_sub_d(t, t, core->half[2], MPFR_RNDN);
                    if (mpfr_sgn(t) < 0) mpfr_set_zero(t, 1);
                    mpfr_mul_si(d[i], t, mpfr_sgn(q[i]) < 0 ? -1 : 1, MPFR_RNDN);
                }
            }
        }
        if (core->kind == COLLIDED_CHECK_HALFSPACE) vec_set(d, (double[]){0, 0, 1});
        mpfr_ptr norm = dot_m(d, d);
        if (!mpfr_zero_p(norm)) {
            mpfr_sqrt(norm, norm, MPFR_RNDN);
            mpfr_ptr along = dot_m(d, q);
            core_support_m(core, d, h);
            mpfr_sub(along, along, h, MPFR_RNDN);
            mpfr_div(along, along, norm, MPFR_RNDN);
            grow(out, along);
        }
        reset();
    }
    mpfr_sub_d(out, out, core->radius, MPFR_RNDN);
    if (core != &s->shape) mpfr_sub_d(out, out, s->shape.radius, MPFR_RNDN);
    if (mpfr_sgn(out) < 0) mpfr_set_zero(out, 1);
    mpfr_add_d(out, out, core->deviation, MPFR_RNDN);
    if (core != &s->shape) mpfr_add_d(out, out, s->shape.deviation, MPFR_RNDN);
    mpfr_clears(t, h, q[0], q[1], q[2], d[0], d[1], d[2], clamped[0], clamped[1], clamped[2], (mpfr_ptr)0);
}

static void hi_m(const check_case *c, mpfr_ptr out)
{
    const check_subject *both[2] = {&c->a, &c->b};
    const double *points[2] = {c->claim.point_a, c->claim.point_b};
    mpfr_t t, least;
    mpfr_inits2(BITS, t, least, (mpfr_ptr)0);
    mpfr_set_zero(out, 1);
    for (int i = 0; i < 3; i++) {
        mpfr_set_d(t, points[1][i], MPFR_RNDN);
        mpfr_sub_d(t, t, points[0][i], MPFR_RNDN);
        mpfr_hypot(out, out, t, MPFR_RNDN);
    }
    for (int i = 0; i < 2; i++) {
        mpfr_set_inf(least, 1);
        for (size_t k = 0; k < parts(&both[i]->shape); k++) {
            part_distance_m(both[i], k, points[i], t);
            mpfr_min(least, least, t, MPFR_RNDN);
        }
        mpfr_add(out, out, least, MPFR_RNDN);
    }
    mpfr_clears(t, least, (mpfr_ptr)0);
}

static struct {
    long cases, lo_far, hi_far;
} tally;

static void check(const check_case *c, uint64_t seed)
{
    static mpfr_t exact, share;
    if (!tally.cases++) mpfr_inits2(BITS, exact, share, (mpfr_ptr)0);
    collided_check_claim open = c->claim;
    open.lo = -1e300, open.hi = 1e300;
    collided_check_proven p;
    collided_check_status status =
        collided_check_distance(&c->a.shape, c->a.pose, &c->b.shape, c->b.pose, &open, 0, &p);
    if (status != COLLIDED_CHECK_PROVEN && status != COLLIDED_CHECK_LO_UNPROVEN)
        fail_msg("seed %llu: %s", (unsigned long long)seed, collided_check_status_text(status));
    double size = fmax(check_size(c), 0x1p-400);
    gap_m(c, exact);
    if (mpfr_cmp_d(exact, p.lo) < 0)
        fail_msg("seed %llu: lo %a is more than %.17g", (unsigned long long)seed, p.lo, mpfr_get_d(exact, MPFR_RNDN));
    mpfr_sub_d(share, exact, p.lo, MPFR_RNDN);
    tally.lo_far += isfinite(p.lo) && mpfr_get_d(share, MPFR_RNDU) > 0x1p-39 * size;
    hi_m(c, exact);
    if (mpfr_cmp_d(exact, p.hi) > 0)
        fail_msg("seed %llu: hi %a is less than %.17g", (unsigned long long)seed, p.hi, mpfr_get_d(exact, MPFR_RNDN));
    mpfr_sub_d(share, exact, p.hi, MPFR_RNDN);
    tally.hi_far += -mpfr_get_d(share, MPFR_RNDD) > 0x1p-39 * size;
}

static long rounds(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 1000000 : getenv("COLLIDED_BRIEF") ? 300 : 3000;
}

static void hostile_certificates(void **state)
{
    (void)state;
    static check_case c;
    uint64_t s = 99;
    for (long i = 0; i < rounds(); i++) {
        uint64_t seed = prng_bits(&s);
        check_hostile_case(seed, &c);
        check(&c, seed);
    }
    printf("%ld cases; of %ld lo and %ld hi more than the slack is missing, or not known to be there\n", tally.cases,
        tally.lo_far, tally.hi_far);
    assert_true(tally.lo_far == 0);
    assert_true(tally.hi_far * 5 < tally.cases);
}

/* The engine's certificates, with one number changed. At night 10^8 of these: what is claimed then is compared with the
 * true distance, which the engine's own interval tells, and with MPFR where the kernel accepts it. */
static void corrupted_certificates(void **state)
{
    (void)state;
    static check_case c, changed;
    static const double BY[] = {0x1p-52, 0x1p-50, 1e-12, 1e-9, 1e-6, 1e-3, 1};
    long accepted = 0, asked = 0;
    uint64_t s = 5;
    cases_create();
    for (long i = 0; i < rounds() / 3; i++) {
        if (!check_engine_case((int)(i % CASE_KINDS), (int)(i / CASE_KINDS % CASE_KINDS), (unsigned)(i / 81), &c))
            continue;
        for (int k = 0; k < 300; k++) {
            memcpy(&changed.claim, &c.claim, sizeof c.claim);
            double *numbers[] = {
                &changed.claim.lo, &changed.claim.hi, changed.claim.axis, changed.claim.point_a, changed.claim.point_b};
            size_t which = prng_bits(&s) % 5;
            double *at = numbers[which] + (which > 1 ? prng_bits(&s) % 3 : 0), change = BY[prng_bits(&s) % 7];
            *at += prng_in(&s, -1, 1) * change;
            collided_check_proven p;
            asked++;
            collided_check_status status =
                collided_check_distance(&c.a.shape, c.a.pose, &c.b.shape, c.b.pose, &changed.claim, 0, &p);
            if (status != COLLIDED_CHECK_PROVEN && status != COLLIDED_CHECK_DEPTH_UNPROVEN) continue;
            accepted++;
            if (changed.claim.lo > c.claim.hi || (status == COLLIDED_CHECK_PROVEN && changed.claim.hi < c.claim.lo))
                fail_msg("[%a, %a] is accepted, true is [%a, %a]", changed.claim.lo, changed.claim.hi, c.claim.lo,
                    c.claim.hi);
        }
    }
    cases_destroy();
    printf("%ld asked, %ld accepted, none of them false\n", asked, accepted);
}

int main(void)
{
    for (int i = 0; i < POOL; i++) mpfr_init2(pool[i], BITS);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hostile_certificates), cmocka_unit_test(corrupted_certificates)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
