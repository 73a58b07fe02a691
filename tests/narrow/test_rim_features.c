/* rim_features: gaps of cylinders and cones from boxes, capsules, cylinders and cones. A query with the cache of the
 * frame before answers, to the bit, what a query from nothing answers; with any forged cache, too. */
#include "cases.h"
#include "narrow/convex/near_features.h"
#include "narrow/curved/curved.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "same_answer.h"

enum { TRACKS = 200, FRAMES = 60 };

static const shape_type PAIRS[][2] = {{SHAPE_CAPSULE, SHAPE_CYLINDER}, {SHAPE_CAPSULE, SHAPE_CONE},
    {SHAPE_BOX, SHAPE_CYLINDER}, {SHAPE_BOX, SHAPE_CONE}, {SHAPE_CYLINDER, SHAPE_CYLINDER},
    {SHAPE_CYLINDER, SHAPE_CONE}, {SHAPE_CONE, SHAPE_CONE}};
enum { PAIR_COUNT = sizeof PAIRS / sizeof *PAIRS };

static size_t rounds_of(size_t ci)
{
    return getenv("COLLIDED_NIGHTLY") ? 60 * ci : getenv("COLLIDED_BRIEF") ? ci / 8 : ci;
}

static double length_of(random_state *r)
{
    return random_in(r, 0.3, 1) * (random_unit(r) < 0.1 ? 0.01 : 1);
}

static shape make(random_state *r, shape_type type)
{
    shape s = {.type = type, .half = {length_of(r), length_of(r), length_of(r)}};
    if (type == SHAPE_CAPSULE) s.half = vec(0, 0, s.half.z), s.radius = 0.2;
    if (type == SHAPE_CYLINDER || type == SHAPE_CONE) s.half.y = s.half.x;
    if (random_unit(r) < 0.2) s.radius = 0.1;
    return s;
}

/* Upright, lying, or as it comes; and now and then by a hair off that. */
static quat stance(random_state *r)
{
    static const double TILTS[] = {0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2};
    double s = sqrt(0.5), which = random_unit(r), tilt = TILTS[random_bits(r) % 8];
    vec3 axis = vec_scale(random_direction(r), tilt);
    if (which > 0.3) return random_rotation(r);
    quat q = which < 0.15 ? (quat){1, 0, 0, 0} : (quat){s, s, 0, 0};
    return quat_unit(quat_mul(q, (quat){1, axis.x, axis.y, axis.z}));
}

/* The bounds hold what bounds in double-double hold, and are as close as was asked. */
static void assert_true_to(const shape *a, const shape *b, const pose *at, const narrow_result *r)
{
    static const narrow_request FINEST = {.facts = NARROW_DISTANCE, .range = INFINITY, .engine = NARROW_ENGINE_GJK};
    narrow_result fine;
    narrow_query(a, b, at, &FINEST, NULL, case_scratch(), &fine);
    assert_true(r->lo <= fine.hi && fine.lo <= r->hi);
}

typedef struct tally {
    size_t apart, remembered;
} tally;

static void follow(random_state *r, const shape *a, const shape *b, tally *t)
{
    vec3 towards = random_unit(r) < 0.1 ? vec(0, 0, 1) : random_direction(r), axis = random_direction(r);
    quat q = stance(r);
    double most = shape_reach(a) + shape_reach(b), step = random_in(r, 0, 0.02) * most,
           away = random_in(r, 0.5, 1.3) * most, rate = random_unit(r) < 0.2 ? 0 : random_in(r, 0, 0.02);
    narrow_cache cache = {.lower = 0};
    for (int i = 0; i < FRAMES; i++) {
        const narrow_request *request = &REQUESTS[random_unit(r) < 0.6 ? 0 : (i / 8) % REQUEST_COUNT];
        pose at = {vec_scale(towards, away), q};
        narrow_cache none = {.lower = 0};
        narrow_result warm, cold;
        narrow_query(a, b, &at, request, &cache, case_scratch(), &warm);
        narrow_query(a, b, &at, request, &none, case_scratch(), &cold);
        assert_same(&warm, &cold);
        assert_true(warm.hi - warm.lo <= request->tolerance || request != &REQUESTS[0] || warm.lo <= 0);
        if (i % 8 == 0) assert_true_to(a, b, &at, &warm);
        t->apart += warm.lo > 0 && request == &REQUESTS[0];
        t->remembered += cache.nearest.count_a > 0 && request == &REQUESTS[0];
        away = fabs(away + random_in(r, -step, step));
        q = quat_unit(quat_mul((quat){1, rate * axis.x, rate * axis.y, rate * axis.z}, q));
        towards = vec_unit(vec_madd(towards, rate, random_direction(r)));
    }
}

static void followed_with_their_cache_they_answer_as_from_nothing(void **state)
{
    (void)state;
    random_state r = {81};
    for (size_t k = 0; k < PAIR_COUNT; k++) {
        tally t = {0, 0};
        for (size_t i = 0; i < rounds_of(TRACKS); i++) {
            shape a = make(&r, PAIRS[k][0]), b = make(&r, PAIRS[k][1]);
            if (narrow_ordered(&a, 0, &b, 1))
                follow(&r, &a, &b, &t);
            else
                follow(&r, &b, &a, &t);
        }
        assert_true(3 * t.remembered > 2 * t.apart); /* or else nothing has been tested */
    }
}

/* Whatever is written there, out of range or wrong: no bit changes. */
static void forged_features_change_nothing(void **state)
{
    (void)state;
    random_state r = {82};
    for (size_t i = 0; i < rounds_of(4000); i++) {
        const shape_type *pair = PAIRS[i % PAIR_COUNT];
        shape a = make(&r, pair[0]), b = make(&r, pair[1]);
        pose at = {vec_scale(random_direction(&r), random_in(&r, 0.5, 3)), stance(&r)};
        unsigned most = random_unit(&r) < 0.9 ? 3 : 65536;
        narrow_result x, y;
        narrow_cache none = {.lower = 0};
        if (!narrow_ordered(&a, 0, &b, 1)) {
            shape t = a;
            a = b, b = t;
        }
        narrow_query(&a, &b, &at, &REQUESTS[0], &none, case_scratch(), &y);
        for (int n = 0; n < 20; n++) {
            narrow_cache forged = none;
            forged.axis = n % 4 == 3 ? random_direction(&r) : none.axis;
            if (n == 18) forged.axis = VEC_ZERO;
            if (n == 19) forged.axis = vec(NAN, INFINITY, 0);
            if (n % 4 == 2) forged.axis = vec_unit(vec_madd(forged.axis, 0.1, random_direction(&r)));
            for (int k = 0; k < 3; k++) {
                if (random_unit(&r) < 0.3) forged.nearest.a[k] = (uint16_t)(random_bits(&r) % most);
                if (random_unit(&r) < 0.3) forged.nearest.b[k] = (uint16_t)(random_bits(&r) % most);
            }
            forged.nearest.count_a = (uint8_t)(random_unit(&r) < 0.9 ? 3 : random_bits(&r) % 5);
            forged.nearest.count_b = (uint8_t)(random_unit(&r) < 0.9 ? 3 : random_bits(&r) % 5);
            forged.nearest.deep = random_unit(&r) < 0.1;
            narrow_query(&a, &b, &at, &REQUESTS[0], &forged, case_scratch(), &x);
            assert_same(&x, &y);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(followed_with_their_cache_they_answer_as_from_nothing),
        cmocka_unit_test(forged_features_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
