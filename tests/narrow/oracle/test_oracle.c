/* The oracle against truths in closed form, and its two methods against each other. */
#include "base/prng.h"
#include "oracle/oracle.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <setjmp.h>

#include <cmocka.h>

#define NEAR ((quad)1e-19)

static const qvec origin = {0, 0, 0};

static oracle_body sphere(double r, double x, double y, double z)
{
    return (oracle_body){
        .radius = r, .points = &origin, .count = 1, .rotation = oracle_rotation(1, 0, 0, 0), .position = qv(x, y, z)};
}

/* The corners of a box of the given half sizes, into `points`. */
static oracle_body box(qvec points[8], double x, double y, double z)
{
    for (int i = 0; i < 8; i++) points[i] = qv(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
    return (oracle_body){.points = points, .count = 8, .rotation = oracle_rotation(1, 0, 0, 0)};
}

static oracle_body placed(oracle_body body, quad x, quad y, quad z)
{
    body.position = qv(x, y, z);
    return body;
}

static void assert_near(quad found, quad expected, quad tolerance)
{
    if (!(q_abs(found - expected) <= tolerance)) fail_msg("%.20g, not %.20g", (double)found, (double)expected);
}

static double uniform(uint64_t *state)
{
    return (double)(prng_bits(state) >> 11) * 0x1p-52 - 1;
}

static void random_pose(uint64_t *state, oracle_body *body, double reach)
{
    body->rotation = oracle_rotation(uniform(state), uniform(state), uniform(state), uniform(state));
    body->position = qv(reach * uniform(state), reach * uniform(state), reach * uniform(state));
}

static void root_is_exact_to_113_bits(void **state)
{
    (void)state;
    quad two = q_sqrt(2);
    assert_near(two * two, 2, (quad)1e-33);
    assert_near(q_sqrt((quad)1e200 * 1e200 * 1e200 * 1e200), (quad)1e200 * 1e200, (quad)1e200 * 1e170);
    assert_true(q_sqrt(0) == 0);
}

static void spheres_are_apart_by_centres_less_radii(void **state)
{
    (void)state;
    oracle_body a = sphere(1, 0, 0, 0), b = sphere(2, 3, 4, 0);
    assert_near(oracle_distance(&a, &b).lo, 2, NEAR);
    assert_near(oracle_distance_bounds(&a, &b).lo, 2, NEAR);
    b = sphere(6, 3, 4, 0);
    assert_near(oracle_distance(&a, &b).lo, -2, NEAR);
    b = sphere(6, 0, 0, 0);
    assert_near(oracle_distance(&a, &b).lo, -7, NEAR);
}

static void boxes_are_apart_by_faces_edges_and_corners(void **state)
{
    (void)state;
    qvec pa[8], pb[8];
    oracle_body a = box(pa, 1, 1, 1), b = box(pb, 1, 1, 1);
    const struct {
        quad x, y, z, expected;
    } cases[] = {{2.5, 0.3, 0.2, 0.5}, {3, 3, 0.25, q_sqrt(2)}, {3, 3, 3, q_sqrt(3)}, {1.5, 0, 0, -0.5}, {0, 0, 0, -2},
        {2, 0, 0, 0}, {2, 2, 2, 0}, {-0.25, 0.125, 1.875, -0.125}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        oracle_body at = placed(b, cases[i].x, cases[i].y, cases[i].z);
        assert_near(oracle_distance_features(&a, &at).lo, cases[i].expected, NEAR);
        assert_near(oracle_distance_bounds(&a, &at).lo, cases[i].expected, NEAR);
    }
}

static void rotated_cube_stands_on_its_edge_and_its_corner(void **state)
{
    (void)state;
    qvec pa[8], pb[8];
    oracle_body a = box(pa, 1, 1, 1), b = box(pb, 1, 1, 1);
    quad c = q_sqrt(2 + q_sqrt(2)) / 2, s = q_sqrt(2 - q_sqrt(2)) / 2; /* of pi/8 */
    b.rotation = oracle_rotation(c, s, 0, 0);
    b = placed(b, 0.1, 0, 4);
    assert_near(oracle_distance_features(&a, &b).lo, 3 - q_sqrt(2), NEAR);
    b = placed(b, 0.1, 0, 2);
    assert_near(oracle_distance_features(&a, &b).lo, 1 - q_sqrt(2), NEAR);
    /* a diagonal upright: turned about (1, -1, 0) by acos(1/sqrt 3) */
    quad cosine = 1 / q_sqrt(3), half_c = q_sqrt((1 + cosine) / 2), half_s = q_sqrt((1 - cosine) / 2);
    b.rotation = oracle_rotation(half_c, half_s / q_sqrt(2), -half_s / q_sqrt(2), 0);
    b = placed(b, 0, 0, 4);
    assert_near(oracle_distance_features(&a, &b).lo, 3 - q_sqrt(3), NEAR);
    assert_near(oracle_distance_bounds(&a, &b).lo, 3 - q_sqrt(3), NEAR);
}

static void crossed_edges_are_apart_by_their_common_perpendicular(void **state)
{
    (void)state;
    const qvec a_ends[2] = {{-1, 0, 0}, {1, 0, 0}}, b_ends[2] = {{0, -1, 0}, {0, 1, 0}};
    oracle_body a = sphere(0.25, 0, 0, 0), b = sphere(0.5, 0.5, 0, 1);
    a.points = a_ends, b.points = b_ends, a.count = b.count = 2;
    assert_near(oracle_distance(&a, &b).lo, 0.25, NEAR);
    b = placed(b, 0.5, 0, 0.5);
    assert_near(oracle_distance(&a, &b).lo, -0.25, NEAR);
    b = placed(b, 0.5, 0, 0);
    assert_near(oracle_distance(&a, &b).lo, -0.75, NEAR);
}

static void flat_and_thin_polytopes_have_no_depth(void **state)
{
    (void)state;
    const qvec square[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    oracle_body a = {.points = square, .count = 4, .rotation = oracle_rotation(1, 0, 0, 0)}, b = a;
    const double shift[4][2] = {{2, 1}, {1, 0}, {0.5, 0}, {0, 0}};
    for (int i = 0; i < 4; i++) {
        b = placed(b, shift[i][0], 0, 0);
        assert_near(oracle_distance_features(&a, &b).lo, shift[i][1], NEAR);
        assert_near(oracle_distance_bounds(&a, &b).lo, shift[i][1], NEAR);
    }
    b.count = 2; /* an edge, in line with the square's */
    b = placed(b, 1.5, 0, 0);
    assert_near(oracle_distance_features(&a, &b).lo, 0.5, NEAR);
}

static void curved_bodies_agree_with_closed_forms(void **state)
{
    (void)state;
    oracle_body ball = sphere(0.5, 0, 0, 0);
    oracle_body can = {.core = ORACLE_CYLINDER, .half = qv(1, 1, 2), .rotation = oracle_rotation(1, 0, 0, 0)};
    oracle_body cone = can, egg = can, ground = can;
    cone.core = ORACLE_CONE;
    egg.core = ORACLE_ELLIPSOID;
    ground.core = ORACLE_HALFSPACE;
    const struct {
        const oracle_body *body;
        quad x, y, z, expected;
    } cases[] = {{&can, 3, 0, 1, 1.5}, {&can, 4, 0, 6, 4.5}, {&can, 0.75, 0, 0, -0.75}, {&can, 0, 0, 1.75, -0.75},
        {&cone, 0, 0, 3, 0.5}, {&cone, 0, 0, -3, 0.5}, {&cone, 4, 0, 2.75, (quad)16.75 / q_sqrt(17) - (quad)0.5},
        {&egg, 0, 0, 4, 1.5}, {&egg, 0, 3, 0, 1.5}, {&egg, 0, 0, 0, -1.5}, {&ground, 7, 8, 1, 0.5},
        {&ground, 7, 8, -1, -1.5}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        oracle_body at = placed(ball, cases[i].x, cases[i].y, cases[i].z);
        oracle_truth truth = oracle_distance(cases[i].body, &at);
        assert_near(truth.lo, cases[i].expected, (quad)1e-18);
        assert_true(cases[i].expected <= truth.hi + NEAR);
    }
}

static void methods_agree_on_random_polytopes(void **state)
{
    (void)state;
    uint64_t seed = 2;
    for (int round = 0; round < 60; round++) {
        qvec pa[10], pb[10];
        for (int i = 0; i < 10; i++) {
            pa[i] = qv(uniform(&seed), uniform(&seed), uniform(&seed));
            pb[i] = qv(uniform(&seed), uniform(&seed), uniform(&seed));
        }
        oracle_body a = {.points = pa, .count = 10, .rotation = oracle_rotation(1, 0, 0, 0)}, b = a;
        b.points = pb;
        random_pose(&seed, &b, 2);
        oracle_truth features = oracle_distance_features(&a, &b), bounds = oracle_distance_bounds(&a, &b);
        assert_near(features.lo, bounds.lo, (quad)1e-19);
        assert_true(bounds.hi - bounds.lo < (quad)1e-19);
        assert_near(oracle_separation(&a, &b, bounds.axis), bounds.lo, (quad)1e-19);
    }
}

/* No direction may separate further than the answer: tried with many, on all kinds of curved bodies. */
static void no_direction_separates_further(void **state)
{
    (void)state;
    uint64_t seed = 3;
    for (int round = 0; round < 60; round++) {
        oracle_body a = {.core = (oracle_core)(1 + round % 3), .half = qv(1, 1, 0.5)}, b = a;
        b.core = (oracle_core)(1 + round / 3 % 3);
        b.radius = 0.125;
        random_pose(&seed, &a, 0);
        random_pose(&seed, &b, 1.5);
        oracle_truth truth = oracle_distance(&a, &b);
        assert_true(truth.hi - truth.lo < (quad)1e-18);
        assert_near(oracle_separation(&a, &b, truth.axis), truth.lo, NEAR);
        for (int i = 0; i < 400; i++) {
            qvec n = qv(uniform(&seed), uniform(&seed), uniform(&seed));
            if (i % 2) n = q_add(truth.axis, q_scale(n, 0x1p-6));
            assert_true(oracle_separation(&a, &b, n) <= truth.lo + (quad)1e-18);
        }
    }
}

static void false_claims_are_refused(void **state)
{
    (void)state;
    oracle_body a = sphere(1, 0, 0, 0), b = sphere(1, 4, 0, 0);
    const oracle_claim truth = {2, 2, {1, 0, 0}, {1, 0, 0}, {3, 0, 0}, {0, 0, 0}};
    assert_null(oracle_check(&a, &b, &truth, 0));
    oracle_claim claim = truth;
    claim.lo = nextafter(2, 3), claim.hi = 3;
    assert_non_null(oracle_check(&a, &b, &claim, 0));
    claim = truth, claim.axis[1] = 0.01;
    assert_non_null(oracle_check(&a, &b, &claim, 0));
    claim = truth, claim.axis[0] = -1;
    assert_non_null(oracle_check(&a, &b, &claim, 0));
    claim = truth, claim.point_a[0] = 1.5;
    assert_non_null(oracle_check(&a, &b, &claim, 1e-9));
    claim = truth, claim.point_b[0] = 3.5;
    assert_non_null(oracle_check(&a, &b, &claim, 1e-9));
    claim = truth, claim.hi = NAN;
    assert_non_null(oracle_check(&a, &b, &claim, 0));
    b = sphere(1, 1.5, 0, 0);
    const oracle_claim deep = {-0.5, -0.5, {1, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0, 0, 0}};
    assert_null(oracle_check(&a, &b, &deep, 0));
    claim = deep, claim.point_a[0] = 0.75;
    assert_non_null(oracle_check(&a, &b, &claim, 1e-9));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(root_is_exact_to_113_bits),
        cmocka_unit_test(spheres_are_apart_by_centres_less_radii),
        cmocka_unit_test(boxes_are_apart_by_faces_edges_and_corners),
        cmocka_unit_test(rotated_cube_stands_on_its_edge_and_its_corner),
        cmocka_unit_test(crossed_edges_are_apart_by_their_common_perpendicular),
        cmocka_unit_test(flat_and_thin_polytopes_have_no_depth),
        cmocka_unit_test(curved_bodies_agree_with_closed_forms),
        cmocka_unit_test(methods_agree_on_random_polytopes),
        cmocka_unit_test(no_direction_separates_further),
        cmocka_unit_test(false_claims_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
