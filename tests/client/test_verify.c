/* Certificates: true ones are accepted for every pair of shapes, forged ones are refused.
 *
 * The truth is made by construction: shapes are placed on both sides of a random plane by their support function, which
 * is found here by sampling-free closed forms in double, written for the test alone; the distance is then known. */
#include "base/prng.h"
#include "cmocka_c.h"

#include <collided.h>
#include <math.h>
#include <string.h>

static uint64_t seed = 20;
static double uniform(double from, double to)
{
    return prng_in(&seed, from, to);
}

enum { HULL_POINTS = 24, TYPES = COLLIDED_HULL + 1, ROUNDS = 40 };

typedef struct solid {
    collided_shape shape;
    collided_pose body;
    double hull[3 * HULL_POINTS];
} solid;

static void random_rotation(double q[4])
{
    double norm = 0;
    for (int i = 0; i < 4; i++) q[i] = uniform(-1, 1);
    for (int i = 0; i < 4; i++) norm += q[i] * q[i];
    for (int i = 0; i < 4; i++) q[i] /= sqrt(norm);
}

static collided_shape random_shape(int type)
{
    double r = uniform(0.1, 1), h = uniform(0.1, 2);
    switch (type) {
    case COLLIDED_SPHERE:
        return collided_sphere(r);
    case COLLIDED_CAPSULE:
        return collided_capsule(r, h);
    case COLLIDED_BOX:
        return collided_box(uniform(0.1, 2), uniform(0.1, 2), h);
    case COLLIDED_CYLINDER:
        return collided_cylinder(r, h);
    case COLLIDED_CONE:
        return collided_cone(r, h);
    case COLLIDED_ELLIPSOID:
        return collided_ellipsoid(uniform(0.1, 1), uniform(0.1, 1), uniform(0.1, 1));
    case COLLIDED_HALFSPACE:
        return collided_halfspace();
    default:
        return collided_hull((collided_geometry){1});
    }
}

static solid random_solid(int type, bool rounded)
{
    solid s = {.shape = random_shape(type), .body = collided_pose_identity()};
    if (rounded) s.shape.radius += uniform(0.01, 0.3);
    random_rotation(s.body.orientation);
    random_rotation(s.shape.pose.orientation);
    for (int i = 0; i < 3; i++) {
        s.body.position[i] = uniform(-5, 5);
        s.shape.pose.position[i] = uniform(-1, 1);
    }
    for (int i = 0; i < 3 * HULL_POINTS; i++) s.hull[i] = uniform(-1, 1);
    return s;
}

static void rotate(const double q[4], const double v[3], bool back, double out[3])
{
    double w = q[0], x = back ? -q[1] : q[1], y = back ? -q[2] : q[2], z = back ? -q[3] : q[3];
    double m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
        {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
        {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; i++) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

/* The point of the core that is farthest along d, in the shape's frame. */
static void core_point(const solid *s, const double d[3], double p[3])
{
    const double *h = s->shape.half;
    double rho = hypot(d[0], d[1]), norm = sqrt(pow(h[0] * d[0], 2) + pow(h[1] * d[1], 2) + pow(h[2] * d[2], 2));
    double ux = rho > 0 ? d[0] / rho : 1, uy = rho > 0 ? d[1] / rho : 0;
    for (int i = 0; i < 3; i++) p[i] = copysign(h[i], d[i]);
    if (s->shape.type == COLLIDED_CAPSULE) p[0] = p[1] = 0;
    if (s->shape.type == COLLIDED_SPHERE || s->shape.type == COLLIDED_HALFSPACE) p[0] = p[1] = p[2] = 0;
    if (s->shape.type == COLLIDED_CYLINDER || s->shape.type == COLLIDED_CONE) {
        bool apex = s->shape.type == COLLIDED_CONE && 2 * h[2] * d[2] > h[0] * rho;
        p[0] = apex ? 0 : h[0] * ux;
        p[1] = apex ? 0 : h[0] * uy;
        if (s->shape.type == COLLIDED_CONE) p[2] = apex ? h[2] : -h[2];
    }
    if (s->shape.type == COLLIDED_ELLIPSOID)
        for (int i = 0; i < 3; i++) p[i] = h[i] * h[i] * d[i] / norm;
    if (s->shape.type != COLLIDED_HULL) return;
    double best = -INFINITY;
    for (size_t i = 0; i < HULL_POINTS; i++) {
        const double *v = s->hull + 3 * i;
        double along = d[0] * v[0] + d[1] * v[1] + d[2] * v[2];
        if (along > best) memcpy(p, v, 3 * sizeof *p);
        best = fmax(best, along);
    }
}

/* The farthest point along the world direction n, in the world. */
static void farthest(const solid *s, const double n[3], double out[3])
{
    double in_body[3], d[3], p[3];
    rotate(s->body.orientation, n, true, in_body);
    rotate(s->shape.pose.orientation, in_body, true, d);
    core_point(s, d, p);
    for (int i = 0; i < 3; i++) p[i] += s->shape.radius * d[i];
    rotate(s->shape.pose.orientation, p, false, in_body);
    for (int i = 0; i < 3; i++) in_body[i] += s->shape.pose.position[i];
    rotate(s->body.orientation, in_body, false, out);
    for (int i = 0; i < 3; i++) out[i] += s->body.position[i];
}

static void normal_of(const solid *halfspace, double n[3])
{
    const double z[] = {0, 0, 1};
    double in_body[3];
    rotate(halfspace->shape.pose.orientation, z, false, in_body);
    rotate(halfspace->body.orientation, in_body, false, n);
}

/* Puts B so that its point nearest along n lies `gap` beyond A's: these points are then the closest ones. */
static collided_certificate place(const solid *a, solid *b, double gap)
{
    collided_certificate claim = {.lo = gap, .hi = gap};
    double *n = claim.axis, norm = 0, back[3];
    if (a->shape.type == COLLIDED_HALFSPACE) {
        normal_of(a, n);
    } else if (b->shape.type == COLLIDED_HALFSPACE) {
        normal_of(b, n);
        for (int i = 0; i < 3; i++) n[i] = -n[i];
    } else {
        for (int i = 0; i < 3; i++) n[i] = uniform(-1, 1);
    }
    for (int i = 0; i < 3; i++) norm += n[i] * n[i];
    for (int i = 0; i < 3; i++) n[i] /= sqrt(norm);
    for (int i = 0; i < 3; i++) back[i] = -n[i];
    farthest(a, n, claim.point_a);
    farthest(b, back, claim.point_b);
    for (int i = 0; i < 3; i++) b->body.position[i] += claim.point_a[i] + gap * n[i] - claim.point_b[i];
    farthest(b, back, claim.point_b);
    double d = 0;
    for (int i = 0; i < 3; i++) d += pow(claim.point_b[i] - claim.point_a[i], 2);
    if (gap > 0) claim.hi = fmax(gap, sqrt(d)); /* the points are rounded */
    return claim;
}

static collided_status verify(const solid *a, const solid *b, const collided_certificate *claim)
{
    collided_prepared_hull *hull_a = collided_prepare_hull(a->hull, HULL_POINTS);
    collided_prepared_hull *hull_b = collided_prepare_hull(b->hull, HULL_POINTS);
    collided_status said =
        collided_verify(&a->shape, &a->body, a->hull, HULL_POINTS, &b->shape, &b->body, b->hull, HULL_POINTS, claim);
    assert_int_equal(collided_verify_prepared(&a->shape, &a->body, hull_a, &b->shape, &b->body, hull_b, claim), said);
    collided_free_prepared_hull(hull_a);
    collided_free_prepared_hull(hull_b);
    return said;
}

typedef void case_of(const solid *a, const solid *b, collided_certificate claim);

static void for_all_pairs(double gap, case_of *check)
{
    for (int i = 0; i < TYPES; i++)
        for (int k = 0; k < TYPES; k++)
            for (int round = 0; round < ROUNDS; round++) {
                if (i == COLLIDED_HALFSPACE && k == COLLIDED_HALFSPACE) continue;
                solid a = random_solid(i, round % 2), b = random_solid(k, round % 4 > 1);
                collided_certificate claim = place(&a, &b, gap);
                check(&a, &b, claim);
            }
}

static void is_accepted(const solid *a, const solid *b, collided_certificate claim)
{
    if (verify(a, b, &claim) != COLLIDED_OK)
        fail_msg("types %d and %d: a true certificate was refused", a->shape.type, b->shape.type);
}

static void true_certificates_are_accepted(void **state)
{
    (void)state;
    const double gaps[] = {1e-6, 0.01, 1.0, 30.0};
    for (size_t i = 0; i < sizeof gaps / sizeof gaps[0]; i++) for_all_pairs(gaps[i], is_accepted);
}

static void wider_is_accepted(const solid *a, const solid *b, collided_certificate claim)
{
    claim.lo -= 0.1;
    claim.hi += 0.1;
    is_accepted(a, b, claim);
    claim.lo = -INFINITY;
    claim.hi = INFINITY;
    is_accepted(a, b, claim); /* claims nothing */
}

static void wider_intervals_are_true_too(void **state)
{
    (void)state;
    for_all_pairs(0.5, wider_is_accepted);
}

static void refuse(const solid *a, const solid *b, const collided_certificate *claim, const char *forgery)
{
    if (verify(a, b, claim) == COLLIDED_OK)
        fail_msg("types %d and %d: %s was accepted", a->shape.type, b->shape.type, forgery);
}

/* All that takes part is within 100 m, of which 64 * 2^-53 are allowed: 7e-13 m. */
static const double FORGED = 1e-12;

/* Turned by 1e-3 towards a direction across it. */
static void turn_axis(double n[3])
{
    double aside[3] = {n[1], n[2], n[0]}, along = 0, norm = 0;
    for (int i = 0; i < 3; i++) along += aside[i] * n[i];
    for (int i = 0; i < 3; i++) aside[i] -= along * n[i];
    for (int i = 0; i < 3; i++) norm += aside[i] * aside[i];
    for (int i = 0; i < 3; i++) n[i] = cos(1e-3) * n[i] + sin(1e-3) * aside[i] / sqrt(norm);
}

static void forged_bounds_are_refused(const solid *a, const solid *b, collided_certificate claim)
{
    collided_certificate f = claim;
    f.lo += FORGED;
    f.hi += FORGED;
    refuse(a, b, &f, "a lo that is too high");
    f = claim;
    f.hi -= FORGED;
    f.lo -= 1.0;
    refuse(a, b, &f, claim.hi > 0 ? "a hi below the points' distance" : "a hi below what the axis shows");
    f = claim;
    f.lo = -INFINITY;
    f.hi -= FORGED;
    refuse(a, b, &f, "a hi alone that is too low");
    f = claim;
    f.lo += FORGED;
    f.hi = INFINITY;
    refuse(a, b, &f, "a lo alone that is too high");
    f = claim;
    f.lo = f.hi + 1e-3;
    refuse(a, b, &f, "an empty interval");
}

static void forged_axes_are_refused(const solid *a, const solid *b, collided_certificate claim)
{
    collided_certificate f = claim;
    for (int i = 0; i < 3; i++) f.axis[i] *= 1.0001;
    refuse(a, b, &f, "an axis that is not unit");
    f = claim;
    for (int i = 0; i < 3; i++) f.axis[i] = -f.axis[i];
    refuse(a, b, &f, "an axis the wrong way");
    f = claim;
    turn_axis(f.axis);
    if (claim.lo > 0) refuse(a, b, &f, "an axis that was turned");
}

static void forged_points_are_refused(const solid *a, const solid *b, collided_certificate claim)
{
    collided_certificate f = claim;
    for (int i = 0; i < 3; i++) f.point_a[i] += FORGED * f.axis[i]; /* out of A, towards B: shortens the distance */
    refuse(a, b, &f, "a witness outside A");
    f = claim;
    for (int i = 0; i < 3; i++) f.point_b[i] -= FORGED * f.axis[i];
    refuse(a, b, &f, "a witness outside B");
    f = claim;
    for (int i = 0; i < 3; i++) {
        f.point_a[i] += 20 * (claim.axis[(i + 1) % 3] - claim.axis[(i + 2) % 3]); /* across the axis: as far apart */
        f.point_b[i] += 20 * (claim.axis[(i + 1) % 3] - claim.axis[(i + 2) % 3]);
    }
    refuse(a, b, &f, "witnesses far aside");
    f.lo = -INFINITY;
    for (int i = 0; i < 3; i++) f.axis[i] *= 1e3; /* not looked at, and no help */
    refuse(a, b, &f, "witnesses far aside, with an axis that proves nothing");
}

static void forgeries_are_refused(const solid *a, const solid *b, collided_certificate claim)
{
    forged_bounds_are_refused(a, b, claim);
    forged_axes_are_refused(a, b, claim);
    forged_points_are_refused(a, b, claim);
}

static void forged_certificates_are_refused(void **state)
{
    (void)state;
    for_all_pairs(0.7, forgeries_are_refused);
    for_all_pairs(-0.05, is_accepted);
    for_all_pairs(-0.05, forgeries_are_refused);
}

static void nan_is_refused(const solid *a, const solid *b, collided_certificate claim)
{
    double *const fields[] = {&claim.lo, &claim.hi, &claim.axis[1], &claim.point_a[0], &claim.point_b[2]};
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        double kept = *fields[i];
        *fields[i] = NAN;
        refuse(a, b, &claim, "NaN");
        *fields[i] = kept;
    }
}

static void not_a_number_proves_nothing(void **state)
{
    (void)state;
    for_all_pairs(0.7, nan_is_refused);
    for_all_pairs(-0.05, nan_is_refused);
}

/* Two balls whose centres are 1 apart, radii 1 and 0.5: depth 0.5. */
static void overlapping_balls_are_judged(void **state)
{
    (void)state;
    collided_shape a = collided_sphere(1.0), b = collided_sphere(0.5);
    collided_pose pa = collided_pose_identity(), pb = collided_pose_identity();
    pb.position[0] = 1.0;
    collided_certificate claim = {-0.5, -0.5, {1, 0, 0}, {1, 0, 0}, {0.5, 0, 0}};
    assert_int_equal(collided_verify(&a, &pa, NULL, 0, &b, &pb, NULL, 0, &claim), COLLIDED_OK);
    collided_certificate shallow = claim;
    shallow.lo = -0.4;
    shallow.hi = -0.3;
    assert_int_equal(collided_verify(&a, &pa, NULL, 0, &b, &pb, NULL, 0, &shallow), COLLIDED_REJECTED);
    collided_certificate deep = claim;
    deep.lo = -0.8;
    deep.hi = -0.7; /* the axis itself shows 0.5 */
    assert_int_equal(collided_verify(&a, &pa, NULL, 0, &b, &pb, NULL, 0, &deep), COLLIDED_REJECTED);
    collided_certificate apart = claim;
    apart.lo = -1.0;
    apart.hi = 0.1;
    assert_int_equal(collided_verify(&a, &pa, NULL, 0, &b, &pb, NULL, 0, &apart), COLLIDED_REJECTED);
}

static void opposite_halfspaces_are_judged(void **state)
{
    (void)state;
    collided_shape a = collided_halfspace(), b = collided_halfspace();
    collided_pose pa = collided_pose_identity(), pb = {{0, 0, 2}, {0, 1, 0, 0}}; /* turned over */
    collided_certificate claim = {2, 2, {0, 0, 1}, {3, 0, 0}, {3, 0, 2}};
    assert_int_equal(collided_verify(&a, &pa, NULL, 0, &b, &pb, NULL, 0, &claim), COLLIDED_OK);
    pb.orientation[0] = 1e-6; /* no longer parallel: somewhere they meet */
    assert_int_equal(collided_verify(&a, &pa, NULL, 0, &b, &pb, NULL, 0, &claim), COLLIDED_REJECTED);
}

static void unusable_shapes_are_told_apart(void **state)
{
    (void)state;
    collided_shape good = collided_sphere(1.0), bad = collided_sphere(NAN),
                   hull = collided_hull((collided_geometry){1});
    collided_pose pose = collided_pose_identity(), zero = {{0}, {0}};
    collided_certificate claim = {0, 0, {1, 0, 0}, {0}, {0}};
    assert_int_equal(collided_verify(&good, &pose, NULL, 0, &bad, &pose, NULL, 0, &claim), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_verify(&good, &zero, NULL, 0, &good, &pose, NULL, 0, &claim), COLLIDED_BAD_ARGUMENT);
    collided_shape ground = collided_height_field((collided_geometry){1}); /* not convex: no axis proves anything */
    assert_int_equal(collided_verify(&ground, &pose, NULL, 0, &good, &pose, NULL, 0, &claim), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_verify(&hull, &pose, NULL, 0, &good, &pose, NULL, 0, &claim), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_verify_prepared(&hull, &pose, NULL, &good, &pose, NULL, &claim), COLLIDED_BAD_ARGUMENT);
}

static void points_that_make_no_hull_are_not_prepared(void **state)
{
    (void)state;
    const double infinite[] = {0, 0, 0, 1, INFINITY, 0};
    assert_null(collided_prepare_hull(NULL, 3));
    assert_null(collided_prepare_hull(infinite, 0));
    assert_null(collided_prepare_hull(infinite, 2));
    collided_free_prepared_hull(NULL);
}

/* A box around a smaller thing: both upper bounds, apart and overlapping, must leave room for the deviation. */
static void deviations_widen_what_the_points_prove(void **state)
{
    (void)state;
    collided_shape a = collided_box(2, 2, 2), b = collided_box(2, 2, 2);
    collided_pose at_a = collided_pose_identity(), at_b = at_a;
    a.deviation = 0.25;
    at_b.position[0] = 3;
    collided_certificate apart = {.lo = 1, .hi = 1.25, .axis = {1, 0, 0}, .point_a = {1, 0, 0}, .point_b = {2, 0, 0}};
    assert_int_equal(collided_verify(&a, &at_a, NULL, 0, &b, &at_b, NULL, 0, &apart), COLLIDED_OK);
    apart.hi = 1.2;
    assert_int_equal(collided_verify(&a, &at_a, NULL, 0, &b, &at_b, NULL, 0, &apart), COLLIDED_REJECTED);
    at_b.position[0] = 1.5;
    collided_certificate deep = {
        .lo = -0.5, .hi = 0.25, .axis = {1, 0, 0}, .point_a = {1, 0, 0}, .point_b = {0.5, 0, 0}};
    assert_int_equal(collided_verify(&a, &at_a, NULL, 0, &b, &at_b, NULL, 0, &deep), COLLIDED_OK);
    deep.hi = -0.25; /* the model is so deep; the thing need not be */
    assert_int_equal(collided_verify(&a, &at_a, NULL, 0, &b, &at_b, NULL, 0, &deep), COLLIDED_REJECTED);
    /* Apart, and an axis that is turned round: it must not make the points those of an overlap. */
    const collided_pose here = collided_pose_identity(), there = {{3, 0, 0}, {1, 0, 0, 0}};
    collided_shape ball = collided_sphere(0.5);
    ball.deviation = 0.25;
    collided_certificate turned = {.lo = -INFINITY, .hi = 0.5, .axis = {-1, 0, 0}, .point_a = {0.5}, .point_b = {2.5}};
    assert_int_equal(collided_verify(&ball, &here, NULL, 0, &ball, &there, NULL, 0, &turned), COLLIDED_REJECTED);
    turned.hi = 2.5;
    assert_int_equal(collided_verify(&ball, &here, NULL, 0, &ball, &there, NULL, 0, &turned), COLLIDED_OK);
    a.deviation = -1;
    assert_int_equal(collided_verify(&a, &at_a, NULL, 0, &b, &at_b, NULL, 0, &apart), COLLIDED_BAD_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(true_certificates_are_accepted),
        cmocka_unit_test(wider_intervals_are_true_too),
        cmocka_unit_test(forged_certificates_are_refused),
        cmocka_unit_test(not_a_number_proves_nothing),
        cmocka_unit_test(overlapping_balls_are_judged),
        cmocka_unit_test(opposite_halfspaces_are_judged),
        cmocka_unit_test(deviations_widen_what_the_points_prove),
        cmocka_unit_test(unusable_shapes_are_told_apart),
        cmocka_unit_test(points_that_make_no_hull_are_not_prepared),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
