/* Shapes that stand for finer things: the interval holds the things' distance, and says that it is wide. The things are
 * here a tube of four bars, its shape the box around it, and a box, its shape a larger one. */
#include "cases.h"
#include "geom/compound.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { BARS = 4, ROUNDS = 4000 };

/* Outside 2 x 2 x 4, the hole along z 1 wide: no point of the box is farther than 0.5 from the bars. */
static const double TUBE_DEVIATION = 0.5;
static const struct {
    vec3 half, at;
} bars[BARS] = {
    {{0.25, 1, 2}, {-0.75, 0, 0}},
    {{0.25, 1, 2}, {0.75, 0, 0}},
    {{0.5, 0.25, 2}, {0, -0.75, 0}},
    {{0.5, 0.25, 2}, {0, 0.75, 0}},
};

static const double SHRUNK = 0.05;

static shape box(vec3 half, double deviation)
{
    return (shape){.type = SHAPE_BOX, .half = half, .deviation = deviation};
}

static narrow_result ask(const shape *a, pose at_a, const shape *b, pose at_b, const narrow_request *request)
{
    narrow_result r;
    narrow_query_world(a, at_a, b, at_b, request, case_scratch(), &r);
    return r;
}

static const narrow_request measure = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};

static double between(double least, double most)
{
    return least + (most - least) * drand48();
}

static pose random_pose(double far)
{
    quat q = quat_unit((quat){between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)});
    return (pose){vec(between(-far, far), between(-far, far), between(-far, far)), q};
}

/* Of the tube and a box at a pose: the distance, or 0 if they overlap. */
static double true_distance(const shape *thing, pose at)
{
    double least = INFINITY;
    for (int i = 0; i < BARS; i++) {
        shape bar = box(bars[i].half, 0);
        pose there = {bars[i].at, {1, 0, 0, 0}};
        least = fmin(least, fmax(ask(&bar, there, thing, at, &measure).lo, 0));
    }
    return least;
}

static void the_interval_holds_the_distance_of_the_things(void **state)
{
    (void)state;
    int apart_inside = 0;
    srand48(3);
    shape tube = box(vec(1, 1, 2), TUBE_DEVIATION);
    for (int i = 0; i < ROUNDS; i++) {
        vec3 half = vec(between(0.05, 0.4), between(0.05, 0.4), between(0.05, 3));
        shape thing = box(half, 0);
        shape larger = box(vec_add(half, vec(SHRUNK, SHRUNK, SHRUNK)), SHRUNK * sqrt(3));
        pose at = i % 2 ? random_pose(3) : (pose){vec(between(-0.1, 0.1), between(-0.1, 0.1), 0), {1, 0, 0, 0}};
        double truth = true_distance(&thing, at);
        narrow_result r = ask(&tube, POSE_IDENTITY, &larger, at, &measure);
        double e = tube.deviation + larger.deviation;
        if (!(r.lo <= truth + 1e-12)) fail_msg("lo %g above %g", r.lo, truth);
        if (!(truth <= r.hi)) fail_msg("hi %g below %g", r.hi, truth);
        assert_true(r.hi - fmax(r.lo, 0) <= e + 1e-8);
        assert_int_equal(r.status, NARROW_WIDE);
        apart_inside += truth > 0 && r.lo < 0;
    }
    assert_true(apart_inside > ROUNDS / 10); /* the peg in the tube: model deep, things apart */
}

static void without_deviation_no_bit_changes(void **state)
{
    (void)state;
    srand48(4);
    for (int i = 0; i < ROUNDS; i++) {
        shape a = box(vec(between(0.1, 1), between(0.1, 1), between(0.1, 1)), 0), b = a, c = b;
        c.deviation = 1e-3;
        pose at = random_pose(2);
        narrow_result plain = ask(&a, POSE_IDENTITY, &b, at, &measure), wide = ask(&a, POSE_IDENTITY, &c, at, &measure);
        assert_true(plain.lo == wide.lo);
        assert_true(wide.hi >= fmax(plain.hi, 0) + 1e-3 && wide.hi <= (fmax(plain.hi, 0) + 1e-3) * (1 + 1e-15));
        narrow_result swapped = ask(&c, at, &a, POSE_IDENTITY, &measure);
        assert_true(swapped.lo == wide.lo && swapped.hi == wide.hi);
    }
}

/* The bars of the tube, each in a larger box: the hole stays, and the child that is nearest says what it is off by. */
static void children_of_compounds_deviate_too(void **state)
{
    (void)state;
    const double whole_deviation = 0.01, child = SHRUNK * sqrt(3);
    shape larger[BARS], ball = {.type = SHAPE_SPHERE, .radius = 0.1};
    pose locals[BARS];
    for (int i = 0; i < BARS; i++) {
        larger[i] = box(vec_add(bars[i].half, vec(SHRUNK, SHRUNK, SHRUNK)), child);
        locals[i] = (pose){bars[i].at, {1, 0, 0, 0}};
    }
    compound *tube;
    assert_int_equal(compound_build(larger, locals, BARS, &tube), COMPOUND_OK);
    shape whole = {.type = SHAPE_COMPOUND, .compound = tube, .deviation = whole_deviation};
    int in_the_hole = 0, wedged = 0;
    srand48(5);
    for (int i = 0; i < ROUNDS; i++) {
        pose at = random_pose(i % 2 ? 3 : 0.6);
        double truth = true_distance(&ball, at);
        narrow_result r = ask(&whole, POSE_IDENTITY, &ball, at, &measure);
        narrow_result swapped = ask(&ball, at, &whole, POSE_IDENTITY, &measure);
        assert_true(r.lo <= truth + 1e-12 && truth + whole_deviation <= r.hi);
        assert_true(r.lo < 0 || r.hi - r.lo <= child + whole_deviation + 1e-8);
        assert_true(r.hi >= child + whole_deviation);
        assert_int_equal(r.status, NARROW_WIDE);
        assert_true(swapped.lo == r.lo && swapped.hi == r.hi);
        in_the_hole += i % 2 == 0 && r.lo > 0;
        wedged += r.lo < 0 && truth > 0;
    }
    assert_true(in_the_hole > ROUNDS / 10 && wedged > 0);
    compound_destroy(tube);
}

static narrow_status status_at(double x, double deviation, narrow_request r)
{
    shape a = box(vec(1, 1, 1), deviation), b = box(vec(1, 1, 1), 0);
    return ask(&a, POSE_IDENTITY, &b, (pose){vec(x, 0, 0), {1, 0, 0, 0}}, &r).status;
}

static void the_status_knows_what_the_deviation_leaves_open(void **state)
{
    (void)state;
    narrow_request fine = {.facts = NARROW_DISTANCE, .tolerance = 0.01, .range = INFINITY}, coarse = fine, near = fine;
    coarse.tolerance = 0.2;
    near.range = 0.5;
    assert_int_equal(status_at(3, 0.1, fine), NARROW_WIDE);
    assert_int_equal(status_at(3, 0.1, coarse), NARROW_CERTAIN);
    assert_int_equal(status_at(3, 0.1, near), NARROW_CERTAIN); /* beyond the range */
    assert_int_equal(status_at(3, 0.001, fine), NARROW_CERTAIN);
    narrow_request touch = {.facts = NARROW_VERDICT, .threshold = 0}, padded = touch;
    padded.threshold = 0.2;
    assert_int_equal(status_at(3, 0.1, touch), NARROW_CERTAIN);
    assert_int_equal(status_at(1.5, 0.1, touch), NARROW_WIDE);
    assert_int_equal(status_at(1.5, 0, touch), NARROW_CERTAIN);
    assert_int_equal(status_at(1.5, 0.1, padded), NARROW_CERTAIN);
    assert_int_equal(status_at(2.15, 0.1, padded), NARROW_WIDE);
    assert_int_equal(status_at(2.05, 0.1, padded), NARROW_CERTAIN);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_interval_holds_the_distance_of_the_things),
        cmocka_unit_test(without_deviation_no_bit_changes),
        cmocka_unit_test(children_of_compounds_deviate_too),
        cmocka_unit_test(the_status_knows_what_the_deviation_leaves_open),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
