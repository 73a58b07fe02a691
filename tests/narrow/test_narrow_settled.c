/* Quaternions whose squared norms are off by as much as quat_settled lets pass: the bounds hold the distance of the
 * rotations that they stand for, by 113-bit support functions along the axis that is told. */
#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { PAIRS_EACH = 1500 };

/* Half turns, of which a matrix is off the most, among them. */
static quat turned(random_state *r, bool longer)
{
    for (;;) {
        quat q = random_rotation(r);
        if (random_bits(r) % 2) {
            q.w *= 1e-3 * random_unit(r);
            q = quat_unit(q);
        }
        double k = 1 + (longer ? 1 : -1) * random_in(r, 3.4, 5.2) * 0x1p-53;
        q = (quat){q.w * k, q.x * k, q.y * k, q.z * k};
        if (fabs(quat_norm2(q) - 1) <= 0x1p-50) return quat_settled(q);
    }
}

static void vary(random_state *r, shape *s)
{
    if (random_bits(r) % 2) return;
    double k = exp2(random_in(r, -10, 0));
    s->radius *= k;
    s->half = vec_scale(s->half, k);
}

static void check(const shape *a, pose pa, const shape *b, pose pb, uint64_t seed)
{
    double ra = shape_reach(a), rb = shape_reach(b);
    double size = (isfinite(ra) ? ra : 0) + (isfinite(rb) ? rb : 0) + vec_norm(vec_sub(pb.p, pa.p));
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9 * size, .range = INFINITY};
    narrow_result r;
    narrow_query_world(a, pa, b, pb, &request, case_scratch(), &r);
    placed at_a = oracle_place(a, pa, pa.p), at_b = oracle_place(b, pb, pa.p);
    real apart = oracle_separation(&at_a, &at_b, real3_of(r.axis));
    if (apart < (real)r.lo || apart > (real)r.hi)
        fail_msg("%s-%s, seed %llu: [%.17g, %.17g] by %s, off by %g", shape_type_name(a->type),
            shape_type_name(b->type), (unsigned long long)seed, r.lo, r.hi, narrow_method_name(r.method),
            (double)(apart < (real)r.lo ? (real)r.lo - apart : apart - (real)r.hi));
}

static void bounds_hold_for_norms_within_what_is_settled(void **state)
{
    (void)state;
    uint64_t count = getenv("COLLIDED_NIGHTLY") ? 60 * PAIRS_EACH : getenv("COLLIDED_BRIEF") ? 100 : PAIRS_EACH;
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++) {
        for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++) {
            if (ta == SHAPE_HALFSPACE && tb == SHAPE_HALFSPACE) continue;
            for (uint64_t i = 1; i <= count; i++) {
                random_state r = {i * 77 + (uint64_t)(ta * 100 + tb)};
                shape a = random_shape(&r, (shape_type)ta), b = random_shape(&r, (shape_type)tb);
                pose pa, pb;
                vary(&r, &a);
                random_poses(&r, &a, &b, (enum regime)(random_bits(&r) % REGIME_COUNT), &pa, &pb);
                bool longer = random_bits(&r) % 2;
                pa.q = random_bits(&r) % 2 ? POSE_IDENTITY.q : turned(&r, longer);
                pb.q = turned(&r, longer);
                if (random_bits(&r) % 2) pb.p = vec_madd(pa.p, exp2(random_in(&r, 0, 12)), random_direction(&r));
                check(&a, pa, &b, pb, i);
            }
        }
    }
}

static int setup(void **state)
{
    (void)state;
    cases_create();
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    cases_destroy();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_hold_for_norms_within_what_is_settled),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
