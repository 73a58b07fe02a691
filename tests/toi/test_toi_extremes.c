/* Speeds and sizes at the ends of what doubles hold: the search ends after a bounded number of steps, with numbers. */
#include "toi_pairs.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { STEPS_AT_MOST = 6000, QUERIES_AT_MOST = 1200 };

static bool no_nan(const toi_result *t)
{
    if (isnan(t->lo) || isnan(t->hi) || isnan(t->gap_lo) || isnan(t->gap_hi) || isnan(t->closing)) return false;
    const vec3 v[] = {t->axis, t->point_a, t->point_b, t->body_a.p, t->body_b.p};
    for (size_t i = 0; i < sizeof v / sizeof *v; i++)
        if (isnan(v[i].x) || isnan(v[i].y) || isnan(v[i].z)) return false;
    return !isnan(quat_norm2(t->body_a.q)) && !isnan(quat_norm2(t->body_b.q));
}

static void check(const toi_pair *p, const char *what, int type_a, int type_b)
{
    toi_result t = toi_pair_find(p);
    if (!no_nan(&t)) fail_msg("%s, types %d and %d: NaN", what, type_a, type_b);
    if (t.steps > STEPS_AT_MOST || t.queries > QUERIES_AT_MOST)
        fail_msg("%s, types %d and %d: %u steps, %u distances", what, type_a, type_b, t.steps, t.queries);
    if (t.status == TOI_FREE) assert_true(isinf(t.lo) && isinf(t.hi));
    if (t.status == TOI_HIT) assert_true(t.lo >= 0 && t.lo <= t.hi && t.hi <= p->request.span);
    if (t.status == TOI_NEAR || t.status == TOI_UNDECIDED) assert_true(t.lo >= 0 && t.lo <= p->request.span);
}

static void every_speed_ends(void **state)
{
    (void)state;
    static const double LINEAR[] = {0, 0x1p-1074, 1e-320, 1e-39, 1e-12, 1e3, 1e9, 1e12};
    static const double ANGULAR[] = {0, 0x1p-1074, 1e-320, 1e-160, 1e-9, 1e3, 0.99 * MOTION_ANGLE_MAX};
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++)
            for (size_t i = 0; i < sizeof LINEAR / sizeof *LINEAR; i++)
                for (size_t k = 0; k < sizeof ANGULAR / sizeof *ANGULAR; k++) {
                    toi_pair p;
                    uint64_t seed = 1000 * i + 100 * k;
                    if (!toi_pair_make(seed, &toi_manners[TOI_TURNING], (shape_type)ta, (shape_type)tb, &p)) continue;
                    random_state r = {seed};
                    p.a.motion.linear = vec_scale(random_direction(&r), LINEAR[i]);
                    p.b.motion.linear = vec_scale(vec_sub(p.a.motion.start.p, p.b.motion.start.p), LINEAR[i]);
                    p.a.motion.angular = vec_scale(random_direction(&r), ANGULAR[k]);
                    p.b.motion.angular = vec_scale(random_direction(&r), ANGULAR[k]);
                    check(&p, "speeds", ta, tb);
                }
}

/* In contact at the beginning, for every speed and every manner: a hit at 0. */
static void contact_at_the_beginning_is_at_zero(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 400; i++) {
        toi_pair p;
        toi_pair_any(0xc0 + i, &toi_manners[i % TOI_MANNERS], &p);
        p.a.local = p.b.local = POSE_IDENTITY;
        p.b.motion.start.p = p.a.motion.start.p;
        if (i % 3 == 0) p.b.motion.linear = p.a.motion.linear, p.a.motion.angular = p.b.motion.angular = VEC_ZERO;
        bool flat = p.shapes[0].type == SHAPE_HULL || p.shapes[1].type == SHAPE_HULL; /* may lie beside its origin */
        toi_result t = toi_pair_find(&p);
        if (!flat) assert_int_equal(t.status, TOI_HIT);
        if (!flat) assert_true(t.lo == 0 && t.hi == 0);
    }
}

static void two_planes_that_turn_are_not_decided(void **state)
{
    (void)state;
    shape plane = {.type = SHAPE_HALFSPACE};
    toi_mover a = {&plane, POSE_IDENTITY, {POSE_IDENTITY, VEC_ZERO, {0, 0, 1}}}, b = a;
    toi_request r = {.span = 1, .tolerance = 1e-6};
    toi_result t;
    toi_find(&a, &b, &r, VEC_ZERO, case_scratch(), &t);
    assert_int_equal(t.status, TOI_UNDECIDED);
    assert_true(t.lo == 0 && isinf(t.hi));
}

/* A rod of a kilometre turns about its own axis, which is almost -z, and a ball touches its far end all along: what the
 * rod sweeps is the rod, and must not be tilted by what is left of the axis' z + 1. */
static void a_rod_that_spins_about_nearly_minus_z_is_touched(void **state)
{
    (void)state;
    const double length = 1000, deep = 4e-6;
    for (double e = 1e-9; e < 2e-7; e *= 1.7)
        for (int side = -1; side <= 1; side += 2) {
            shape rod = {.type = SHAPE_CYLINDER, .half = {1, 1, length}}, ball = {.type = SHAPE_SPHERE, .radius = 1};
            quat q = quat_unit((quat){0.5 * e, 0, 1, 0}); /* takes +z to -z, but for e */
            vec3 axis = quat_rotate(q, vec(0, 0, 1));
            toi_mover a = {&ball, POSE_IDENTITY, {.start = POSE_IDENTITY}};
            toi_mover b = {&rod, POSE_IDENTITY, {.start = {VEC_ZERO, q}, .angular = vec_scale(axis, 20)}};
            a.motion.start.p = vec_add(vec_scale(axis, 0.999 * length), vec(side * (2 - deep), 0, 0));
            toi_request r = {.span = 1, .tolerance = 1e-7};
            toi_result t;
            toi_find(&a, &b, &r, VEC_ZERO, case_scratch(), &t);
            if (t.status != TOI_HIT || t.lo != 0)
                fail_msg("%g rad from -z, side %d: %s from %g s", e, side, toi_status_name(t.status), t.lo);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_speed_ends),
        cmocka_unit_test(contact_at_the_beginning_is_at_zero),
        cmocka_unit_test(two_planes_that_turn_are_not_decided),
        cmocka_unit_test(a_rod_that_spins_about_nearly_minus_z_is_touched),
    };
    cases_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    cases_destroy();
    return failed;
}
