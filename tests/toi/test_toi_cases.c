/* The moving cases that broke other engines, written out: they hold without the shared case files. Above each: where it
 * was reported, and what broke. Box sizes are half sizes; nothing is turned at the beginning. */
#include "toi_pairs.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static const double CORNERS[] = {0.5, -0.5, 0, -0.5, -0.5, 0, -0.5, 0.5, 0}; /* of parry-123's triangle */

typedef struct moving_case {
    const char *id;
    shape a, b; /* a hull without vertices: the triangle */
    vec3 at_a, at_b, linear_a, linear_b, angular_a;
    pose local_a;     /* all zero: the identity */
    double span, toi; /* s; toi INFINITY: they never touch */
} moving_case;

#define BOX(x, y, z)                                                                                                   \
    {                                                                                                                  \
        .type = SHAPE_BOX, .half = { x, y, z }                                                                         \
    }
#define BALL(r)                                                                                                        \
    {                                                                                                                  \
        .type = SHAPE_SPHERE, .radius = r                                                                              \
    }

static const moving_case CASES[] = {
    /* https://github.com/flexible-collision-library/fcl/issues/555, 120: sampling skips fast movers; meshes never hit
     */
    {.id = "fcl-ccd-box-6",
        .a = BOX(1, 1, 1),
        .at_a = {6, 0, 0},
        .linear_a = {-12, 0, 0},
        .b = BOX(1, 1, 1),
        .span = 1,
        .toi = 1.0 / 3},
    {.id = "fcl-ccd-box-100",
        .a = BOX(1, 1, 1),
        .at_a = {100, 0, 0},
        .linear_a = {-200, 0, 0},
        .b = BOX(1, 1, 1),
        .span = 1,
        .toi = 0.49},
    {.id = "fcl-ccd-box-1000",
        .a = BOX(1, 1, 1),
        .at_a = {1000, 0, 0},
        .linear_a = {-2000, 0, 0},
        .b = BOX(1, 1, 1),
        .span = 1,
        .toi = 0.499},
    /* https://github.com/moveit/moveit/issues/2889: the hull of the two poses of a half turn sweeps almost nothing */
    {.id = "moveit-2889",
        .a = {.type = SHAPE_CAPSULE, .radius = 0.02, .half = {0, 0, 0.5}},
        .angular_a = {0, -M_PI, 0},
        .local_a = {{0.5, 0, 0}, {0.70710678118654757, 0, 0.70710678118654757, 0}},
        .b = BALL(0.05),
        .at_b = {0, 0, 0.9},
        .span = 1,
        .toi = 0.4752175350118112},
    /* https://github.com/ros-navigation/navigation2/issues/4355: what is inside at time 0 was skipped */
    {.id = "nav2-4355",
        .a = BOX(0.3, 0.3, 0.5),
        .linear_a = {1, 0, 0},
        .b = BALL(0),
        .at_b = {0.25, 0, 0},
        .span = 2,
        .toi = 0},
    /* nav2_collision_monitor, getCollisionTime: steps of 0.1 s cover x in [.2, .4] and [.5, .7] */
    {.id = "nav2-step-tunnel",
        .a = BOX(0.1, 0.3, 0.5),
        .linear_a = {3, 0, 0},
        .b = BALL(0),
        .at_b = {0.45, 0, 0},
        .span = 2,
        .toi = 0.11666666666666665},
    /* Extremes: a hundred turns, of which two poses show none, in reach of a wall by 1e-4, and out of it */
    {.id = "rod-100-turns-hit",
        .a = {.type = SHAPE_CAPSULE, .half = {0, 0, 0.5}},
        .angular_a = {0, 628.3185307179587, 0},
        .b = BOX(0.5, 5, 5),
        .at_b = {0.9999, 0, 0},
        .span = 1,
        .toi = 0.0024681684808412711},
    {.id = "rod-100-turns-miss",
        .a = {.type = SHAPE_CAPSULE, .half = {0, 0, 0.5}},
        .angular_a = {0, 628.3185307179587, 0},
        .b = BOX(0.5, 5, 5),
        .at_b = {1.0001, 0, 0},
        .span = 1,
        .toi = INFINITY},
    /* Extremes: both at a million m/s, 2 m/s apart; the spin of a sphere moves nothing */
    {.id = "common-motion",
        .a = BALL(1),
        .linear_a = {1000000, 0, 0},
        .b = BALL(1),
        .at_b = {3, 0, 0},
        .linear_b = {999998, 0, 0},
        .span = 1,
        .toi = 0.5},
    {.id = "sphere-spin",
        .a = BALL(1),
        .angular_a = {1000000, 0, 0},
        .b = BALL(1),
        .at_b = {2.5, 0, 0},
        .span = 1,
        .toi = INFINITY},
    /* https://github.com/dimforge/parry/issues/123: did not end with a denormal velocity */
    {.id = "parry-123",
        .a = BALL(0.375),
        .linear_a = {0, 6.925e-39, 0},
        .b = {.type = SHAPE_HULL},
        .at_b = {11.5, 5.5, 0},
        .span = 1e9,
        .toi = INFINITY},
    /* https://github.com/dimforge/parry/issues/141: no relative motion, or motion apart, gave a hit */
    {.id = "parry-141-v0",
        .a = BOX(0.5, 0.5, 0.5),
        .at_a = {0, 1.1, 0},
        .b = BOX(0.5, 0.5, 0.5),
        .span = 1e9,
        .toi = INFINITY},
    {.id = "parry-141-v1",
        .a = BOX(0.5, 0.5, 0.5),
        .at_a = {0, 1.1, 0},
        .linear_a = {0, 1, 0},
        .b = BOX(0.5, 0.5, 0.5),
        .span = 1e9,
        .toi = INFINITY},
    /* tesseract collision_sphere_sphere_cast_unit.hpp: two times, one a body, neither the time of impact */
    {.id = "tesseract-cast-spheres-0",
        .a = BALL(0.25),
        .at_a = {-0.2, -1, 0.25},
        .linear_a = {0, 2, 0},
        .b = BALL(0.25),
        .at_b = {0.2, 0, -0.75},
        .linear_b = {0, 0, 2},
        .span = 1,
        .toi = 0.39393398282201786},
    {.id = "tesseract-cast-spheres-1",
        .a = BALL(0.25),
        .at_a = {-0.2, -0.5, 0.25},
        .linear_a = {0, 1.5, 0},
        .b = BALL(0.25),
        .at_b = {0.2, 0, -0.75},
        .linear_b = {0, 0, 2},
        .span = 1,
        .toi = 0.35055728090000843},
};

static hull *triangle;

static shape shape_of(const shape *from)
{
    shape s = *from;
    if (s.type == SHAPE_HULL) s.hull = triangle;
    return s;
}

static void cases_that_broke_other_engines_hold(void **state)
{
    (void)state;
    assert_int_equal(hull_build(CORNERS, 3, HULL_ALLOW_FLAT, &triangle), HULL_OK);
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        const moving_case *c = &CASES[i];
        shape sa = shape_of(&c->a), sb = shape_of(&c->b);
        pose local = quat_norm2(c->local_a.q) > 0 ? c->local_a : POSE_IDENTITY;
        toi_mover a = {&sa, local, {{c->at_a, POSE_IDENTITY.q}, c->linear_a, c->angular_a}};
        toi_mover b = {&sb, POSE_IDENTITY, {{c->at_b, POSE_IDENTITY.q}, c->linear_b, VEC_ZERO}};
        bool ordered = narrow_ordered(a.shape, 0, b.shape, 1);
        toi_request r = {.span = c->span, .tolerance = 1e-9};
        toi_result t;
        toi_find(ordered ? &a : &b, ordered ? &b : &a, &r, VEC_ZERO, case_scratch(), &t);
        bool right = isinf(c->toi) ? t.status == TOI_FREE
                                   : t.status == TOI_HIT && t.lo <= c->toi + 1e-12 && t.hi >= c->toi - 1e-12 &&
                                         t.hi - t.lo < 1e-7;
        if (!right)
            fail_msg("%s: %.17g expected, %s [%.17g, %.17g]", c->id, c->toi, toi_status_name(t.status), t.lo, t.hi);
        assert_true(t.steps < 64);
    }
    hull_destroy(triangle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(cases_that_broke_other_engines_hold)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
