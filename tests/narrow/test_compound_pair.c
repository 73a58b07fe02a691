/* Distances and verdicts of pairs with a compound: against all pairs of children in 113 bits, and between each other.
 */
#include "unions.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A fifth of them in CI, all with COLLIDED_NIGHTLY=1 in the environment. */
static int rounds(int nightly)
{
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / 5;
}

static void make_other(union_body *u, dice *d, int k)
{
    if (k % 3 == 0)
        union_random(u, d, 2 + (size_t)k % 4, 0);
    else if (k % 3 == 1)
        union_single(u, random_part(d, 0.1, 0.5));
    else
        union_single(u, (shape){.type = SHAPE_HALFSPACE, .radius = k % 2 ? 0.05 : 0});
}

static void gaps_and_touching_are_as_brute_force_says(void **state)
{
    (void)state;
    dice d = {21};
    int apart = 0, together = 0;
    for (int k = 0; k < rounds(600); k++) {
        union_body a, b;
        make_other(&a, &d, k);
        union_random(&b, &d, 1 + (size_t)k % 7, k % 4 ? 0 : 0.07);
        pose at = {dice_vec(&d, -2.2, 2.2), dice_quat(&d)};
        union_place(&a, POSE_IDENTITY, qv(0, 0, 0));
        union_place(&b, at, qv(0, 0, 0));
        oracle_truth truth = union_nearest(&a, &b);
        narrow_result r = union_ask(&a.shape, &b.shape, at, 0);
        if (!((quad)r.lo <= truth.hi && r.lo <= r.hi))
            fail_msg("%d: [%.17g, %.17g], truth %.17g", k, r.lo, r.hi, (double)truth.hi);
        /* overlapping, the union is no less deep than its deepest pair: only that far brute force goes */
        if (!(truth.lo <= (quad)r.hi) || (truth.lo > 0 && !((quad)r.lo <= truth.hi)))
            fail_msg("%d: [%.17g, %.17g], truth %.17g", k, r.lo, r.hi, (double)truth.lo);
        if (truth.lo > 1e-9) {
            if (!(r.lo > 0 && r.hi - r.lo < 1e-9)) fail_msg("%d: [%.17g, %.17g]", k, r.lo, r.hi);
            apart++;
        }
        if (truth.hi < -1e-9) {
            if (!((quad)r.hi <= truth.hi + 1e-9)) fail_msg("%d: hi %.17g, truth %.17g", k, r.hi, (double)truth.hi);
            together++;
        }
        union_free(&a);
        union_free(&b);
    }
    assert_true(apart >= rounds(100) && together >= rounds(100));
}

/* One on either side, within the parts that are named; and as far apart as hi says. */
static void witnesses_lie_on_the_surfaces(void **state)
{
    (void)state;
    dice d = {22};
    for (int k = 0; k < rounds(300); k++) {
        union_body a, b;
        union_random(&a, &d, 4, k % 2 ? 0.05 : 0);
        union_random(&b, &d, 5, 0);
        pose at = {dice_vec(&d, -2, 2), dice_quat(&d)};
        union_place(&a, POSE_IDENTITY, qv(0, 0, 0));
        union_place(&b, at, qv(0, 0, 0));
        narrow_result r = union_ask(&a.shape, &b.shape, at, 1e-9);
        qvec on_a = qv(r.point_a.x, r.point_a.y, r.point_a.z), on_b = qv(r.point_b.x, r.point_b.y, r.point_b.z);
        quad off_a = INFINITY, off_b = INFINITY;
        for (size_t i = 0; i < a.count; i++) off_a = q_min(off_a, oracle_outside(&a.parts[i].exact, on_a));
        for (size_t i = 0; i < b.count; i++) off_b = q_min(off_b, oracle_outside(&b.parts[i].exact, on_b));
        if (off_a > 1e-6 || off_b > 1e-6) fail_msg("%d: outside by %g and %g", k, (double)off_a, (double)off_b);
        if (r.lo > 0) assert_true(fabs(vec_norm(vec_sub(r.point_b, r.point_a)) - r.hi) < 1e-6);
        assert_true(fabs(vec_norm(r.axis) - 1) < 1e-12);
        union_free(&a);
        union_free(&b);
    }
}

static void assert_same(const narrow_result *r, const narrow_result *q)
{
    assert_true(r->lo == q->lo && r->hi == q->hi && r->status == q->status);
    assert_true(vec_norm(vec_sub(r->axis, q->axis)) == 0);
    assert_true(vec_norm(vec_sub(r->point_a, q->point_a)) == 0 && vec_norm(vec_sub(r->point_b, q->point_b)) == 0);
    assert_int_equal(r->manifold.count, q->manifold.count);
    for (uint32_t i = 0; i < r->manifold.count; i++) {
        assert_true(vec_norm(vec_sub(r->manifold.points[i].point, q->manifold.points[i].point)) == 0);
        assert_true(r->manifold.points[i].distance == q->manifold.points[i].distance);
        assert_int_equal(r->manifold.points[i].feature, q->manifold.points[i].feature);
    }
}

static void an_only_child_answers_for_itself(void **state)
{
    (void)state;
    dice d = {23};
    static const narrow_request REQUESTS[] = {{NARROW_DISTANCE | NARROW_MANIFOLD, 0, INFINITY, 0.01, 0, false},
        {NARROW_VERDICT, 0, 0, 0.02, 0, false}, {NARROW_DISTANCE, 1e-3, 0.5, 0, 0, false}};
    for (int k = 0; k < rounds(2000); k++) {
        union_body only;
        shape a = random_part(&d, 0.1, 0.5), b = random_part(&d, 0.1, 0.5);
        if (k % 7 == 0) a = (shape){.type = SHAPE_HALFSPACE};
        if (!narrow_ordered(&a, 1, &b, 2)) b.type = SHAPE_BOX, b.half = vec(0.3, 0.2, 0.4), b.radius = 0;
        if (!narrow_ordered(&a, 1, &b, 2)) a = (shape){.type = SHAPE_SPHERE, .radius = 0.3};
        pose at = {dice_vec(&d, -1, 1), dice_quat(&d)};
        union_make(&only, &b, &POSE_IDENTITY, 1, 0);
        narrow_result r, truth;
        narrow_query(&a, &b, &at, &REQUESTS[k % 3], NULL, union_scratch(), &truth);
        narrow_query(&a, &only.shape, &at, &REQUESTS[k % 3], NULL, union_scratch(), &r);
        assert_same(&r, &truth);
        union_free(&only);
    }
}

/* At a pose of its own, the answer is that of the child there, but for rounding. */
static void an_only_child_elsewhere_answers_as_if_it_were_there(void **state)
{
    (void)state;
    dice d = {24};
    for (int k = 0; k < rounds(1000); k++) {
        union_body only;
        shape a = random_part(&d, 0.1, 0.5), b = random_part(&d, 0.1, 0.5);
        pose at = {dice_vec(&d, -1, 1), dice_quat(&d)}, local = {dice_vec(&d, -1, 1), dice_quat(&d)};
        union_make(&only, &b, &local, 1, 0);
        const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
        narrow_result truth, r = union_ask(&a, &only.shape, at, 1e-9);
        narrow_query_world(&a, POSE_IDENTITY, &b, pose_mul(at, local), &request, union_scratch(), &truth);
        assert_true(r.lo <= truth.hi + 1e-14 && truth.lo <= r.hi + 1e-14);
        assert_true(fabs(r.lo - truth.lo) < 1e-8 && fabs(r.hi - truth.hi) < 1e-8);
        union_free(&only);
    }
}

static void swapping_negates_and_asking_again_repeats(void **state)
{
    (void)state;
    dice d = {25};
    const narrow_request request = {
        .facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 1e-9, .range = INFINITY, .threshold = 0.05};
    for (int k = 0; k < rounds(600); k++) {
        union_body a, b;
        make_other(&a, &d, k);
        union_random(&b, &d, 4, 0);
        pose pa = {dice_vec(&d, -0.8, 0.8), dice_quat(&d)}, pb = {dice_vec(&d, -0.8, 0.8), dice_quat(&d)};
        narrow_result r, again, swapped;
        narrow_query_world(&a.shape, pa, &b.shape, pb, &request, union_scratch(), &r);
        narrow_query_world(&a.shape, pa, &b.shape, pb, &request, union_scratch(), &again);
        narrow_query_world(&b.shape, pb, &a.shape, pa, &request, union_scratch(), &swapped);
        assert_same(&r, &again);
        assert_true(r.lo == swapped.lo && r.hi == swapped.hi && r.manifold.count == swapped.manifold.count);
        assert_true(r.axis.x == -swapped.axis.x && r.axis.y == -swapped.axis.y && r.axis.z == -swapped.axis.z);
        for (uint32_t i = 0; i < r.manifold.count; i++) {
            uint64_t f = swapped.manifold.points[i].feature;
            assert_int_equal(r.manifold.points[i].feature, f << 32 | f >> 32);
        }
        union_free(&a);
        union_free(&b);
    }
}

static void scale(shape *s, pose *at, double by)
{
    s->half = vec_scale(s->half, by);
    s->radius *= by;
    at->p = vec_scale(at->p, by);
}

static void scaling_by_a_power_of_two_scales_the_answer(void **state)
{
    (void)state;
    dice d = {26};
    const double scales[] = {0x1p-30, 0x1p20, 0x1p60, 0x1p-300, 0x1p300};
    for (int k = 0; k < rounds(500); k++) {
        union_body a, b, big;
        shape parts[5];
        pose locals[5], at = {dice_vec(&d, -1.5, 1.5), dice_quat(&d)};
        double by = scales[k % 5];
        for (int i = 0; i < 5; i++) parts[i] = random_part(&d, 0.1, 0.4);
        for (int i = 0; i < 5; i++) locals[i] = (pose){dice_vec(&d, -0.8, 0.8), dice_quat(&d)};
        union_make(&b, parts, locals, 5, 0);
        for (int i = 0; i < 5; i++) scale(&parts[i], &locals[i], by);
        union_make(&big, parts, locals, 5, 0);
        union_single(&a, random_part(&d, 0.1, 0.5));
        shape huge = a.shape;
        pose far = at;
        scale(&huge, &far, by);
        narrow_result r = union_ask(&a.shape, &b.shape, at, 0), q = union_ask(&huge, &big.shape, far, 0);
        if (!(q.lo == r.lo * by && q.hi == r.hi * by))
            fail_msg("%d: [%.17g, %.17g], scaled [%.17g, %.17g]", k, r.lo, r.hi, q.lo / by, q.hi / by);
        union_free(&a);
        union_free(&b);
        union_free(&big);
    }
}

static void shifting_both_changes_no_bit(void **state)
{
    (void)state;
    dice d = {27};
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 0, .range = INFINITY};
    const vec3 shift = {0x1p20, -0x1p21, 0x1p19};
    for (int k = 0; k < rounds(300); k++) {
        union_body a, b;
        union_random(&a, &d, 3, 0);
        union_random(&b, &d, 4, 0);
        pose pa = {{0, 0, 0}, dice_quat(&d)}, pb = {{0, 0, 0}, dice_quat(&d)};
        pb.p = vec(round(dice_between(&d, -2, 2) * 0x1p20) * 0x1p-20, 0.5, -0.25);
        pose qa = {shift, pa.q}, qb = {vec_add(pb.p, shift), pb.q};
        narrow_result r, q;
        narrow_query_world(&a.shape, pa, &b.shape, pb, &request, union_scratch(), &r);
        narrow_query_world(&a.shape, qa, &b.shape, qb, &request, union_scratch(), &q);
        assert_same(&r, &q);
        union_free(&a);
        union_free(&b);
    }
}

static void a_verdict_agrees_with_the_distance(void **state)
{
    (void)state;
    dice d = {28};
    for (int k = 0; k < rounds(1000); k++) {
        union_body a, b;
        make_other(&a, &d, k);
        union_random(&b, &d, 5, 0);
        pose at = {dice_vec(&d, -2, 2), dice_quat(&d)};
        narrow_result full = union_ask(&a.shape, &b.shape, at, 1e-9), r, ranged;
        const narrow_request request = {.facts = NARROW_VERDICT, .threshold = dice_between(&d, -0.1, 0.2)};
        const narrow_request within = {.facts = NARROW_DISTANCE, .range = 0.3, .tolerance = 1e-6};
        narrow_query(&a.shape, &b.shape, &at, &request, NULL, union_scratch(), &r);
        narrow_query(&a.shape, &b.shape, &at, &within, NULL, union_scratch(), &ranged);
        assert_true(r.lo <= full.hi && full.lo <= r.hi);
        assert_true(ranged.lo <= full.hi && full.lo <= ranged.hi);
        if (full.lo > request.threshold + 1e-9 && !(r.lo > request.threshold))
            fail_msg("full [%g, %g], verdict [%g, %g], threshold %g", full.lo, full.hi, r.lo, r.hi, request.threshold);
        if (full.hi <= request.threshold - 1e-9) assert_true(r.hi <= request.threshold);
        if (full.lo > 0.3 + 1e-9) assert_true(ranged.lo > 0.3 && ranged.status == NARROW_CERTAIN);
        union_free(&a);
        union_free(&b);
    }
}

/* The convex hulls' separation, which the cascade asks along any axis, is a lower bound of the union's. */
static void no_axis_promises_more_than_the_distance(void **state)
{
    (void)state;
    dice d = {29};
    for (int k = 0; k < rounds(1000); k++) {
        union_body a, b;
        make_other(&a, &d, k);
        union_random(&b, &d, 5, k % 2 ? 0 : 0.05);
        pose at = {dice_vec(&d, -2, 2), dice_quat(&d)};
        narrow_result r = union_ask(&a.shape, &b.shape, at, 1e-9);
        vec3 axis = k % 2 ? r.axis : vec_unit(dice_vec(&d, -1, 1));
        assert_true(narrow_separation(&a.shape, &b.shape, &at, axis, NULL, NULL) <= r.hi);
        union_free(&a);
        union_free(&b);
    }
}

/* A mesh that is a box, and the box, are the same to a compound. */
static void meshes_meet_compounds_as_their_solids_do(void **state)
{
    (void)state;
    dice d = {30};
    soup s = soup_box(0.6, 0.4, 0.5, 4);
    mesh *m = soup_mesh(&s);
    shape as_mesh = mesh_shape(m, 0), as_box = {.type = SHAPE_BOX, .half = {0.6, 0.4, 0.5}};
    for (int k = 0; k < rounds(300); k++) {
        union_body b;
        union_random(&b, &d, 4, 0);
        pose at = {dice_vec(&d, -2, 2), dice_quat(&d)};
        narrow_result r = union_ask(&as_mesh, &b.shape, at, 1e-9), truth = union_ask(&as_box, &b.shape, at, 1e-9);
        if (!(r.lo <= truth.hi && truth.lo <= r.hi))
            fail_msg("[%.17g, %.17g], the box's is [%.17g, %.17g]", r.lo, r.hi, truth.lo, truth.hi);
        if (truth.lo > 1e-9) assert_true(r.lo > 0 && r.hi - r.lo < 1e-8);
        union_free(&b);
    }
    mesh_destroy(m);
    soup_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gaps_and_touching_are_as_brute_force_says),
        cmocka_unit_test(witnesses_lie_on_the_surfaces),
        cmocka_unit_test(an_only_child_answers_for_itself),
        cmocka_unit_test(an_only_child_elsewhere_answers_as_if_it_were_there),
        cmocka_unit_test(swapping_negates_and_asking_again_repeats),
        cmocka_unit_test(scaling_by_a_power_of_two_scales_the_answer),
        cmocka_unit_test(shifting_both_changes_no_bit),
        cmocka_unit_test(a_verdict_agrees_with_the_distance),
        cmocka_unit_test(no_axis_promises_more_than_the_distance),
        cmocka_unit_test(meshes_meet_compounds_as_their_solids_do),
    };
    return cmocka_run_group_tests(tests, union_make_scratch, union_free_scratch);
}
