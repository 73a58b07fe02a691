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

/* A world point in the frame of a core. */
static void into_core_m(const check_subject *s, size_t index, const double point[3], vec_m q)
{
    const double *frames[3] = {s->pose, s->shape.pose, part(&s->shape, index)->pose};
    vec_set(q, point);
    for (int k = 0; k < (s->shape.child_count ? 3 : 2); k++) {
        for (int j = 0; j < 3; j++) mpfr_sub_d(q[j], q[j], frames[k][j], MPFR_RNDN);
        turn_m(frames[k] + 3, true, q);
    }
}

/* From the distance of a core to that of what it stands for: the radii less, the deviations more. */
static void round_m(const check_subject *s, const collided_check_shape *core, mpfr_ptr out)
{
    mpfr_sub_d(out, out, core->radius, MPFR_RNDN);
    if (core != &s->shape) mpfr_sub_d(out, out, s->shape.radius, MPFR_RNDN);
    if (mpfr_sgn(out) < 0) mpfr_set_zero(out, 1);
    mpfr_add_d(out, out, core->deviation, MPFR_RNDN);
    if (core != &s->shape) mpfr_add_d(out, out, s->shape.deviation, MPFR_RNDN);
}

/* From below: no point of the part is nearer to q than (d . q - support(d)) / |d|, for any d: the axes, the axes'
 * planes, and the way from the point that a search proposes. For boxes, balls and half-spaces the true distance. */
static void part_distance_m(const check_subject *s, size_t index, const double point[3], mpfr_ptr out)
{
    const collided_check_shape *core = part(&s->shape, index);
    vec_m q, d;
    mpfr_t t, h;
    mpfr_inits2(BITS, t, h, q[0], q[1], q[2], d[0], d[1], d[2], (mpfr_ptr)0);
    into_core_m(s, index, point, q);
    check_near near;
    check_nearest(s, index, point, &near);
    mpfr_set_zero(out, 1);
    for (int way = 0; way < 6; way++) {
        for (int i = 0; i < 3; i++) {
            if (way < 3) mpfr_set(d[i], q[i], MPFR_RNDN); /* the whole way, without z, or z alone */
            if ((way == 1 && i == 2) || (way == 2 && i < 2)) mpfr_set_zero(d[i], 1);
            if (way == 3) mpfr_sub_d(d[i], q[i], near.at[i], MPFR_RNDN);
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
    round_m(s, core, out);
    mpfr_clears(t, h, q[0], q[1], q[2], d[0], d[1], d[2], (mpfr_ptr)0);
}

/* v is drawn to [-half, half]. */
static void clamp_m(mpfr_ptr v, double half)
{
    if (mpfr_cmp_d(v, half) > 0) mpfr_set_d(v, half, MPFR_RNDN);
    if (mpfr_cmp_d(v, -half) < 0) mpfr_set_d(v, -half, MPFR_RNDN);
}

/* The first two coordinates are drawn into the disc of radius r. */
static void into_disc_m(vec_m v, mpfr_ptr r)
{
    mpfr_ptr rho = fresh();
    mpfr_hypot(rho, v[0], v[1], MPFR_RNDN);
    if (mpfr_cmp(rho, r) <= 0) return;
    for (int i = 0; i < 2; i++) mpfr_mul(v[i], v[i], r, MPFR_RNDN), mpfr_div(v[i], v[i], rho, MPFR_RNDN);
}

/* A point of a cone's disc; `share` of the way from the apex to the base. */
static void on_disc_m(const collided_check_shape *core, double share, vec_m v)
{
    mpfr_ptr r = fresh();
    mpfr_set_d(r, core->half[0], MPFR_RNDN);
    mpfr_mul_d(r, r, share, MPFR_RNDN);
    into_disc_m(v, r);
    mpfr_set_d(v[2], -2 * share, MPFR_RNDN);
    mpfr_add_ui(v[2], v[2], 1, MPFR_RNDN);
    mpfr_mul_d(v[2], v[2], core->half[2], MPFR_RNDN);
}

/* Of a cone one of 4: at the apex, the base, the point's height, and where the slant is nearest. */
static double share_of(const collided_check_shape *core, vec_m q, int way)
{
    double x = mpfr_get_d(q[0], MPFR_RNDN), y = mpfr_get_d(q[1], MPFR_RNDN), z = mpfr_get_d(q[2], MPFR_RNDN);
    double r = core->half[0], h = core->half[2];
    double share = way < 2    ? way
                   : way == 2 ? (h - z) / (2 * h)
                              : (r * hypot(x, y) + 2 * h * (h - z)) / (r * r + 4 * h * h);
    return share > 0 ? fmin(share, 1) : 0;
}

/* v, which is q, becomes a point of the core, as near as a simple way leads. */
static void onto_core_m(const collided_check_shape *core, const check_near *near, int way, vec_m v)
{
    static const double NONE[3];
    mpfr_ptr t = fresh(), sum = fresh();
    bool disc = core->kind == COLLIDED_CHECK_CYLINDER;
    switch (core->kind) {
    case COLLIDED_CHECK_CYLINDER:
    case COLLIDED_CHECK_CAPSULE:
        mpfr_set_d(t, disc ? core->half[0] : 0, MPFR_RNDN);
        into_disc_m(v, t);
        clamp_m(v[2], core->half[2]);
        return;
    case COLLIDED_CHECK_BOX:
        for (int i = 0; i < 3; i++) clamp_m(v[i], core->half[i]);
        return;
    case COLLIDED_CHECK_CONE:
        on_disc_m(core, share_of(core, v, way), v);
        return;
    case COLLIDED_CHECK_ELLIPSOID:
        mpfr_set_zero(sum, 1);
        for (int i = 0; i < 3; i++) {
            mpfr_set_d(t, core->half[i] > 0 ? near->at[i] : 0, MPFR_RNDN);
            mpfr_set(v[i], t, MPFR_RNDN);
            if (core->half[i] > 0) mpfr_div_d(t, t, core->half[i], MPFR_RNDN);
            mpfr_hypot(sum, sum, t, MPFR_RNDN);
        }
        for (int i = 0; i < 3 && mpfr_cmp_ui(sum, 1) > 0; i++) mpfr_div(v[i], v[i], sum, MPFR_RNDN);
        return;
    case COLLIDED_CHECK_HALFSPACE:
        if (mpfr_sgn(v[2]) > 0) mpfr_set_zero(v[2], 1);
        return;
    case COLLIDED_CHECK_HULL:
        mpfr_set_zero(sum, 1);
        vec_set(v, NONE);
        for (size_t k = 0; k < 4; k++) {
            mpfr_add_d(sum, sum, near->weights[k], MPFR_RNDN);
            for (size_t i = 0; i < 3; i++) {
                mpfr_set_d(t, core->points[3 * near->corners[k] + i], MPFR_RNDN);
                mpfr_mul_d(t, t, near->weights[k], MPFR_RNDN);
                mpfr_add(v[i], v[i], t, MPFR_RNDN);
            }
        }
        for (int i = 0; i < 3; i++) mpfr_div(v[i], v[i], sum, MPFR_RNDN);
        return;
    default:
        vec_set(v, NONE);
    }
}

/* From above: how far a point of the part is from q, which is no more than its distance. */
static void part_above_m(const check_subject *s, size_t index, const double point[3], mpfr_ptr out)
{
    const collided_check_shape *core = part(&s->shape, index);
    vec_m q, v;
    mpfr_inits2(BITS, q[0], q[1], q[2], v[0], v[1], v[2], (mpfr_ptr)0);
    into_core_m(s, index, point, q);
    check_near near;
    check_nearest(s, index, point, &near);
    mpfr_set_inf(out, 1);
    for (int way = 0; way < (core->kind == COLLIDED_CHECK_CONE ? 4 : 1); way++) {
        for (int i = 0; i < 3; i++) mpfr_set(v[i], q[i], MPFR_RNDN);
        onto_core_m(core, &near, way, v);
        mpfr_ptr far = fresh();
        mpfr_set_zero(far, 1);
        for (int i = 0; i < 3; i++) mpfr_sub(v[i], v[i], q[i], MPFR_RNDN), mpfr_hypot(far, far, v[i], MPFR_RNDN);
        mpfr_min(out, out, far, MPFR_RNDN);
        reset();
    }
    round_m(s, core, out);
    mpfr_clears(q[0], q[1], q[2], v[0], v[1], v[2], (mpfr_ptr)0);
}

/* The points' distance from each other, and theirs from the shapes: from below, or from above. */
static void hi_m(const check_case *c, bool above, mpfr_ptr out)
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
            (above ? part_above_m : part_distance_m)(both[i], k, points[i], t);
            mpfr_min(least, least, t, MPFR_RNDN);
        }
        mpfr_add(out, out, least, MPFR_RNDN);
    }
    mpfr_clears(t, least, (mpfr_ptr)0);
}

static struct {
    long cases, lo_far, hi_far, hi_unsure;
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
    hi_m(c, true, exact);
    tally.hi_unsure += mpfr_cmp_d(exact, p.hi) > 0;
    hi_m(c, false, exact);
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
    printf("%ld cases: all lo, and all but %ld hi, are true by exact numbers, and those are not false; of %ld lo and "
           "%ld hi "
           "more than the slack is missing, or not known to be there\n",
        tally.cases, tally.hi_unsure, tally.lo_far, tally.hi_far);
    assert_true(tally.lo_far == 0);
    assert_true(tally.hi_unsure * 200 <= tally.cases);
    assert_true(tally.hi_far * 5 < tally.cases);
}

/* ---- corrupted ---- */

/* Between which doubles the signed distance is for sure, by what a certificate proves in exact numbers. */
typedef struct exact_bounds {
    double lo, hi;
} exact_bounds;

static exact_bounds bounds_of(const check_case *c)
{
    static mpfr_t exact;
    static bool ready;
    if (!ready) mpfr_init2(exact, BITS), ready = true;
    exact_bounds b;
    gap_m(c, exact);
    b.lo = mpfr_get_d(exact, MPFR_RNDD);
    hi_m(c, true, exact);
    b.hi = mpfr_get_d(exact, MPFR_RNDU);
    return b;
}

/* One number, or two, of a certificate: a little more or less, another bit, another number's, or any. */
static void corrupt(collided_check_claim *claim, uint64_t *s)
{
    static const double BY[] = {0x1p-52, 0x1p-50, 1e-12, 1e-9, 1e-6, 1e-3, 1};
    double numbers[11];
    memcpy(numbers, claim, sizeof numbers);
    for (size_t more = 1 + prng_bits(s) % 4 / 3; more; more--) {
        double *at = &numbers[prng_bits(s) % 11], change = BY[prng_bits(s) % 7];
        uint64_t bits, way = prng_bits(s) % 16;
        if (way < 12) {
            *at += prng_in(s, -1, 1) * change * (way % 2 ? 1 : fabs(*at));
        } else if (way < 15) {
            memcpy(&bits, at, sizeof bits);
            bits ^= UINT64_C(1) << prng_bits(s) % 64;
            memcpy(at, &bits, sizeof bits);
        } else {
            *at = numbers[prng_bits(s) % 11];
        }
    }
    memcpy(claim, numbers, sizeof numbers);
}

/* What is accepted is true: by the exact bounds that are known of the case, or else by the claim's own axis and points.
 */
static void is_true(check_case *c, const collided_check_claim *claim, exact_bounds *b, long *looked)
{
    if (claim->lo <= b->lo && claim->hi >= b->hi) return;
    collided_check_claim kept = c->claim;
    c->claim = *claim;
    exact_bounds own = bounds_of(c);
    c->claim = kept;
    ++*looked;
    b->lo = fmax(b->lo, own.lo), b->hi = fmin(b->hi, own.hi);
    if (claim->lo > b->lo || claim->hi < b->hi)
        fail_msg("[%a, %a] is accepted, proven is [%a, %a]", claim->lo, claim->hi, b->lo, b->hi);
}

/* The engine's certificates, and the strongest that the kernel accepts, corrupted; at night 10^8. */
static void corrupted_certificates(void **state)
{
    (void)state;
    static check_case c;
    enum { EACH = 300 };
    long accepted = 0, asked = 0, looked = 0;
    uint64_t s = 5;
    cases_create();
    for (long i = 0; i < rounds() / 3; i++) {
        if (!check_engine_case((int)(i % CASE_KINDS), (int)(i / CASE_KINDS % CASE_KINDS), (unsigned)(i / 81), &c))
            continue;
        exact_bounds b = bounds_of(&c);
        collided_check_proven p;
        collided_check_claim strongest = c.claim;
        strongest.lo = -1e300, strongest.hi = 1e300;
        (void)collided_check_distance(&c.a.shape, c.a.pose, &c.b.shape, c.b.pose, &strongest, 0, &p);
        for (int k = 0; k < EACH; k++, asked++) {
            collided_check_claim changed = c.claim;
            if (k % 4) changed.lo = fmin(p.lo, p.hi), changed.hi = p.hi;
            corrupt(&changed, &s);
            collided_check_proven now;
            if (collided_check_distance(&c.a.shape, c.a.pose, &c.b.shape, c.b.pose, &changed, 0, &now) !=
                COLLIDED_CHECK_PROVEN)
                continue;
            accepted++;
            is_true(&c, &changed, &b, &looked);
        }
    }
    cases_destroy();
    printf("%ld corrupted, %ld accepted, none of them false; %ld of these by their own exact numbers\n", asked,
        accepted, looked);
    assert_true(accepted > asked / 50 && looked > 0);
}

int main(void)
{
    for (int i = 0; i < POOL; i++) mpfr_init2(pool[i], BITS);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hostile_certificates), cmocka_unit_test(corrupted_certificates)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
