/* Distances and verdicts of pairs with a mesh: against all pairs of triangles in 113 bits, and between each other. */
#include "brute.h"
#include "narrow/narrow.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A fifth of them in CI, all with COLLIDED_NIGHTLY=1 in the environment, few with COLLIDED_BRIEF=1. */
static int rounds(int nightly)
{
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / (getenv("COLLIDED_BRIEF") ? 25 : 5);
}

static narrow_scratch *scratch;

static int make_scratch(void **state)
{
    (void)state;
    scratch = aligned_alloc(64, narrow_scratch_size());
    return scratch ? 0 : 1;
}

static int free_scratch(void **state)
{
    (void)state;
    free(scratch);
    return 0;
}

static narrow_result ask(const shape *a, const shape *b, pose b_in_a, double tolerance)
{
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_result r;
    memset(&r, 0xa5, sizeof r);
    narrow_query(a, b, &b_in_a, &request, NULL, scratch, &r);
    return r;
}

static vec3 somewhere(dice *d, double far)
{
    return dice_vec(d, -far, far);
}

/* A gap must be in the interval, which is narrow; what touches must not be called free, nor the other way round. */
static void hold_against(const narrow_result *r, quad truth, bool held, double size)
{
    if (truth > 0 && !held) {
        if (!((quad)r->lo <= truth && truth <= (quad)r->hi))
            fail_msg("%.17g is not in [%.17g, %.17g]", (double)truth, r->lo, r->hi);
        assert_true(r->hi - r->lo <= 1e-9 * size);
    } else {
        assert_true(r->lo <= 0);
        if (!(r->lo <= r->hi)) fail_msg("[%.17g, %.17g]", r->lo, r->hi);
        if (held && !((quad)r->hi <= -truth + 1e-12)) fail_msg("held by %g, hi is %g", (double)truth, r->hi);
    }
}

static void boxes_and_meshes_are_as_far_apart_as_brute_force_says(void **state)
{
    (void)state;
    dice d = {11};
    soup all[] = {soup_icosphere(1, 1), soup_torus(0.8, 0.3, 12, 8), soup_trough(), soup_box(0.9, 0.5, 0.7, 3)};
    int inside = 0;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        mesh *m = soup_mesh(&all[i]);
        shape b = mesh_shape(m, 0);
        int apart = 0, held_count = 0;
        for (int k = 0; k < rounds(150); k++) {
            shape a = {.type = SHAPE_BOX, .half = dice_vec(&d, 0.05, 0.3)};
            soup box = soup_box(a.half.x, a.half.y, a.half.z, 1);
            pose at = {somewhere(&d, k % 5 == 4 ? 0.2 : k % 3 ? 1.2 : 2.5), dice_quat(&d)}; /* some inside */
            vec3 centre = quat_rotate(quat_conj(at.q), vec_neg(at.p));
            quad truth = brute_distance(&box, &all[i], &at);
            bool held = truth > 0 && brute_winding(&all[i], centre) != 0;
            narrow_result r = ask(&a, &b, at, 0);
            hold_against(&r, truth, held, 4);
            apart += truth > 0 && !held;
            held_count += held;
            soup_free(&box);
        }
        assert_true(apart >= rounds(20));
        inside += held_count;
        mesh_destroy(m);
        soup_free(&all[i]);
    }
    assert_true(inside > 0);
}

static void meshes_are_as_far_apart_as_brute_force_says(void **state)
{
    (void)state;
    dice d = {12};
    soup all[] = {soup_icosphere(1, 1), soup_torus(0.8, 0.3, 12, 8), soup_trough(), soup_icosphere(0.2, 0)};
    for (int k = 0; k < rounds(60); k++) {
        const soup *sa = &all[k % 4], *sb = &all[k / 4 % 4];
        mesh *ma = soup_mesh(sa), *mb = soup_mesh(sb);
        shape a = mesh_shape(ma, 0), b = mesh_shape(mb, 0);
        pose at = {somewhere(&d, 1.5), dice_quat(&d)};
        quad truth = brute_distance(sa, sb, &at);
        const double *first = sb->points;
        vec3 b0 = pose_point(at, vec(first[0], first[1], first[2]));
        vec3 a0 = quat_rotate(quat_conj(at.q), vec_sub(vec(sa->points[0], sa->points[1], sa->points[2]), at.p));
        bool held = truth > 0 && (brute_winding(sa, b0) != 0 || brute_winding(sb, a0) != 0);
        narrow_result r = ask(&a, &b, at, 0);
        hold_against(&r, truth, held, 4);
        mesh_destroy(ma);
        mesh_destroy(mb);
    }
    for (int i = 0; i < 4; i++) soup_free(&all[i]);
}

/* The signed distance of a point, in and out, is exact; with a radius it still bounds from above. */
static void points_are_as_deep_as_the_surface_is_far(void **state)
{
    (void)state;
    dice d = {13};
    soup s = soup_torus(0.8, 0.3, 20, 12);
    mesh *m = soup_mesh(&s);
    shape b = mesh_shape(m, 0), point = {.type = SHAPE_SPHERE}, ball = {.type = SHAPE_SPHERE, .radius = 0.05};
    for (int k = 0; k < rounds(1000); k++) {
        vec3 p = somewhere(&d, 1);
        pose at = {vec_neg(p), {1, 0, 0, 0}};
        quad away = brute_point_distance(&s, p), truth = brute_winding(&s, p) ? -away : away;
        narrow_result r = ask(&point, &b, at, 0), q = ask(&ball, &b, at, 0);
        if (!((quad)r.lo <= truth && truth <= (quad)r.hi))
            fail_msg("%.17g is not in [%.17g, %.17g]", (double)truth, r.lo, r.hi);
        assert_true((quad)q.hi <= truth - 0.05 + 1e-12);
        if (truth > 0.05) assert_true((quad)q.lo <= truth - 0.05 && q.hi - q.lo < 1e-12);
    }
    mesh_destroy(m);
    soup_free(&s);
}

/* A mesh of a box is a box. */
/* Its core is outside, and touches nothing: however fine the mesh, however narrow the interval that is asked for. */
static void balls_are_as_deep_as_their_centre_is_near(void **state)
{
    (void)state;
    soup s = soup_box(3, 3, 0.25, 24);
    mesh *m = soup_mesh(&s);
    shape b = mesh_shape(m, 0);
    dice d = {77};
    for (int i = 0; i < rounds(400); i++) {
        double height = dice_between(&d, 1e-3, 1.2), radius = height + dice_between(&d, 0, 0.2);
        shape a = {.type = SHAPE_SPHERE, .radius = radius};
        vec3 at = vec(dice_between(&d, -1.5, 1.5), dice_between(&d, -1.5, 1.5), -0.25 - height);
        double truth = -0.25 - at.z - radius;
        narrow_result r = ask(&a, &b, (pose){at, {1, 0, 0, 0}}, i % 2 ? 0 : 1e-6);
        if (!(r.lo <= truth + 1e-12 && truth <= r.hi + 1e-12))
            fail_msg("round %d: %.17g is not in [%.17g, %.17g]", i, truth, r.lo, r.hi);
    }
    mesh_destroy(m);
    soup_free(&s);
}

static void every_convex_type_meets_a_boxed_mesh_as_it_meets_the_box(void **state)
{
    (void)state;
    dice d = {14};
    soup s = soup_box(0.6, 0.4, 0.5, 5);
    mesh *m = soup_mesh(&s);
    double points[24];
    for (int i = 0; i < 24; i++) points[i] = dice_between(&d, -0.4, 0.4);
    hull *h;
    assert_int_equal(hull_build(points, 8, 0, &h), HULL_OK);
    for (int k = 0; k < rounds(800); k++) {
        shape_type type = (shape_type)(k % SHAPE_CONVEX_COUNT);
        double x = dice_between(&d, 0.1, 0.4), z = dice_between(&d, 0.1, 0.4);
        bool round = type == SHAPE_CYLINDER || type == SHAPE_CONE;
        bool sized = type != SHAPE_SPHERE && type != SHAPE_HALFSPACE && type != SHAPE_HULL;
        shape a = {.type = type, .radius = k % 3 ? 0 : 0.05};
        if (sized) a.half = vec(x, round ? x : 0.2, z);
        if (type == SHAPE_HULL) a.hull = h;
        shape b = mesh_shape(m, k % 5 ? 0 : 0.1),
              box = {.type = SHAPE_BOX, .radius = b.radius, .half = {0.6, 0.4, 0.5}};
        pose pa = {VEC_ZERO, dice_quat(&d)}, pb = {somewhere(&d, 1), dice_quat(&d)};
        const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
        narrow_result r, truth;
        narrow_query_world(&a, pa, &b, pb, &request, scratch, &r);
        narrow_query_world(&a, pa, &box, pb, &request, scratch, &truth);
        if (!(r.lo <= truth.hi && truth.lo <= r.hi))
            fail_msg("%s: [%.17g, %.17g], the box's is [%.17g, %.17g]", shape_type_name(type), r.lo, r.hi, truth.lo,
                truth.hi);
        if (truth.lo > 1e-9) assert_true(r.hi - r.lo < 1e-8);
        assert_true((r.lo > 0) == (truth.lo > 0) || fabs(truth.lo) < 1e-9);
    }
    hull_destroy(h);
    mesh_destroy(m);
    soup_free(&s);
}

static void the_axis_separates_what_is_moved_along_it(void **state)
{
    (void)state;
    dice d = {15};
    soup all[] = {soup_icosphere(1, 1), soup_torus(0.8, 0.3, 12, 8), soup_trough()};
    for (int k = 0; k < rounds(120); k++) {
        soup *s = &all[k % 3];
        mesh *m = soup_mesh(s);
        shape b = mesh_shape(m, 0), a = {.type = SHAPE_BOX, .half = {0.3, 0.2, 0.25}};
        soup box = soup_box(0.3, 0.2, 0.25, 1);
        pose at = {somewhere(&d, 1), dice_quat(&d)};
        narrow_result r = ask(&a, &b, at, 1e-6);
        assert_true(fabs(vec_norm(r.axis) - 1) < 1e-12);
        if (r.hi <= 0) {
            pose moved = {vec_madd(at.p, -r.lo + 1e-12, r.axis), at.q};
            quad left = brute_distance(&box, s, &moved);
            if (!(left > 0)) fail_msg("still together after %g along (%g %g %g)", -r.lo, r.axis.x, r.axis.y, r.axis.z);
            assert_int_equal(brute_winding(s, quat_rotate(quat_conj(moved.q), vec_neg(moved.p))), 0);
        }
        mesh_destroy(m);
        soup_free(&box);
    }
    for (int i = 0; i < 3; i++) soup_free(&all[i]);
}

static void assert_same(const narrow_result *r, const narrow_result *q)
{
    assert_true(r->lo == q->lo && r->hi == q->hi && r->status == q->status && r->iterations == q->iterations);
    assert_memory_equal(&r->axis, &q->axis, 3 * sizeof r->axis); /* and the two points behind it */
    assert_int_equal(r->manifold.count, q->manifold.count);
    for (uint32_t i = 0; i < r->manifold.count; i++) {
        assert_memory_equal(&r->manifold.points[i].point, &q->manifold.points[i].point, sizeof(vec3));
        assert_int_equal(r->manifold.points[i].feature, q->manifold.points[i].feature);
    }
}

static void swapping_negates_and_asking_again_repeats(void **state)
{
    (void)state;
    dice d = {16};
    soup s = soup_torus(0.8, 0.3, 16, 10);
    mesh *m = soup_mesh(&s);
    shape mesh_a = mesh_shape(m, 0.01), others[] = {{.type = SHAPE_BOX, .half = {0.3, 0.2, 0.1}},
                                            {.type = SHAPE_CAPSULE, .radius = 0.1, .half = {0, 0, 0.3}}, mesh_a};
    const narrow_request request = {.facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 1e-9, .range = INFINITY};
    for (int k = 0; k < rounds(150); k++) {
        shape *o = &others[k % 3];
        pose pa = {somewhere(&d, 0.6), dice_quat(&d)}, pb = {somewhere(&d, 0.6), dice_quat(&d)};
        narrow_result r, again, swapped;
        memset(&r, 0, sizeof r), memset(&again, 0, sizeof again), memset(&swapped, 0, sizeof swapped);
        narrow_query_world(&mesh_a, pa, o, pb, &request, scratch, &r);
        narrow_query_world(&mesh_a, pa, o, pb, &request, scratch, &again);
        narrow_query_world(o, pb, &mesh_a, pa, &request, scratch, &swapped);
        assert_same(&r, &again);
        assert_true(r.lo == swapped.lo && r.hi == swapped.hi && r.manifold.count == swapped.manifold.count);
        assert_true(r.axis.x == -swapped.axis.x && r.axis.y == -swapped.axis.y && r.axis.z == -swapped.axis.z);
    }
    mesh_destroy(m);
    soup_free(&s);
}

static void scaling_by_a_power_of_two_scales_the_answer(void **state)
{
    (void)state;
    dice d = {17};
    const double scales[] = {0x1p-300, 0x1p-30, 0x1p20, 0x1p300};
    for (int k = 0; k < rounds(90); k++) {
        soup s = soup_torus(0.8, 0.3, 16, 10), big = soup_torus(0.8, 0.3, 16, 10);
        double by = scales[k % 4];
        for (size_t i = 0; i < 3 * big.point_count; i++) big.points[i] *= by;
        mesh *m = soup_mesh(&s), *n = soup_mesh(&big);
        shape a = {.type = SHAPE_BOX, .half = {0.3, 0.2, 0.1}}, c = a, b = mesh_shape(m, 0), e = mesh_shape(n, 0);
        c.half = vec_scale(c.half, by);
        pose at = {somewhere(&d, 1.2), dice_quat(&d)}, far = {vec_scale(at.p, by), at.q};
        narrow_result r = ask(&a, &b, at, 0), q = ask(&c, &e, far, 0);
        assert_true(q.lo == r.lo * by && q.hi == r.hi * by);
        mesh_destroy(m);
        mesh_destroy(n);
        soup_free(&s);
        soup_free(&big);
    }
}

/* Positions on a grid of 2^-20, so that the sums are exact. */
static void a_representable_shift_changes_nothing(void **state)
{
    (void)state;
    dice d = {21};
    soup s = soup_torus(0.8, 0.3, 16, 10);
    mesh *m = soup_mesh(&s);
    shape b = mesh_shape(m, 0.01), others[] = {{.type = SHAPE_BOX, .half = {0.3, 0.2, 0.1}},
                                       {.type = SHAPE_CONE, .half = {0.2, 0.2, 0.3}}, {.type = SHAPE_HALFSPACE}, b};
    const narrow_request request = {.facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 1e-9, .range = INFINITY};
    const vec3 by = vec(0x1p30 + 0.25, -0x1p25, 3 * 0x1p-20);
    for (int k = 0; k < rounds(200); k++) {
        pose at[2] = {{somewhere(&d, 0.6), dice_quat(&d)}, {somewhere(&d, 0.6), dice_quat(&d)}};
        narrow_result r, q;
        memset(&r, 0, sizeof r), memset(&q, 0, sizeof q);
        for (int i = 0; i < 2; i++)
            at[i].p = vec(ldexp(floor(ldexp(at[i].p.x, 20)), -20), ldexp(floor(ldexp(at[i].p.y, 20)), -20),
                ldexp(floor(ldexp(at[i].p.z, 20)), -20));
        narrow_query_world(&others[k % 4], at[0], &b, at[1], &request, scratch, &r);
        for (int i = 0; i < 2; i++) at[i].p = vec_add(at[i].p, by);
        narrow_query_world(&others[k % 4], at[0], &b, at[1], &request, scratch, &q);
        assert_same(&r, &q);
    }
    mesh_destroy(m);
    soup_free(&s);
}

/* Of what is wrong with a mesh nothing is left that a query could feel: the points of its triangles are what counts. */
static void damaged_meshes_are_as_far_apart_as_brute_force_says(void **state)
{
    (void)state;
    dice d = {19};
    soup box = soup_box(0.2, 0.3, 0.25, 1), one = soup_plane(1, 1), crossed = soup_box(0.4, 0.4, 0.4, 2),
         other = soup_box(0.5, 0.3, 0.4, 3), open = soup_icosphere(1, 1), plane = soup_plane(1, 4);
    one.triangle_count = 1;
    soup_add(&crossed, &other, vec(0.3, 0.2, 0.1));
    soup_drop(&open, 7);
    soup_turn(&open, 20);
    soup *all[] = {&one, &crossed, &open, &plane};
    int apart = 0;
    for (int k = 0; k < rounds(400); k++) {
        soup *s = all[k % 4];
        mesh *m = soup_mesh(s);
        shape a = {.type = SHAPE_BOX, .half = {0.2, 0.3, 0.25}}, b = mesh_shape(m, 0);
        pose at = {somewhere(&d, 1.5), dice_quat(&d)};
        quad truth = brute_distance(&box, s, &at);
        vec3 centre = quat_rotate(quat_conj(at.q), vec_neg(at.p));
        bool held = truth > 0 && s == &crossed && brute_winding(s, centre) != 0;
        narrow_result r = ask(&a, &b, at, 0);
        hold_against(&r, truth, held, 4);
        apart += truth > 0 && !held;
        mesh_destroy(m);
    }
    assert_true(apart > rounds(100));
    soup *made[] = {&box, &one, &crossed, &other, &open, &plane};
    for (int i = 0; i < 6; i++) soup_free(made[i]);
}

/* libccd knows convex shapes only: it is not asked about a mesh, and no answer carries its name. */
static void no_answer_about_a_mesh_carries_the_name_of_libccd(void **state)
{
    (void)state;
    dice d = {20};
    soup s = soup_torus(0.8, 0.3, 12, 8);
    mesh *m = soup_mesh(&s);
    shape b = mesh_shape(m, 0), others[] = {{.type = SHAPE_BOX, .half = {0.3, 0.2, 0.1}}, b};
    for (int k = 0; k < rounds(200); k++) {
        pose at = {somewhere(&d, 1.5), dice_quat(&d)};
        narrow_result by[3];
        for (int i = 0; i < 3; i++) {
            static const narrow_engine ENGINES[3] = {NARROW_ENGINE_AUTO, NARROW_ENGINE_CCD, NARROW_ENGINE_MPR};
            const narrow_request request = {.facts = NARROW_VERDICT, .engine = ENGINES[i]};
            memset(&by[i], 0xa5, sizeof by[i]);
            narrow_query(&others[k % 2], &b, &at, &request, NULL, scratch, &by[i]);
            assert_true(by[i].method != NARROW_BY_CCD && by[i].method != NARROW_BY_MPR);
            assert_int_equal(by[i].peer_failures, 0);
            assert_true(by[i].method == by[0].method && by[i].lo == by[0].lo && by[i].hi == by[0].hi);
        }
    }
    mesh_destroy(m);
    soup_free(&s);
}

static void a_verdict_agrees_with_the_distance(void **state)
{
    (void)state;
    dice d = {18};
    soup s = soup_trough();
    mesh *m = soup_mesh(&s);
    shape a = {.type = SHAPE_CYLINDER, .half = {0.2, 0.2, 0.3}}, b = mesh_shape(m, 0);
    for (int k = 0; k < rounds(1000); k++) {
        pose at = {somewhere(&d, 1.5), dice_quat(&d)};
        narrow_result full = ask(&a, &b, at, 1e-9), r;
        const narrow_request request = {.facts = NARROW_VERDICT, .threshold = dice_between(&d, -0.1, 0.2)};
        narrow_query(&a, &b, &at, &request, NULL, scratch, &r);
        assert_true(r.lo <= full.hi && full.lo <= r.hi);
        if (full.lo > request.threshold + 1e-9 && !(r.lo > request.threshold))
            fail_msg("full [%g, %g], verdict [%g, %g], threshold %g", full.lo, full.hi, r.lo, r.hi, request.threshold);
        if (full.hi <= request.threshold && full.hi > 0) assert_true(r.hi <= request.threshold);
    }
    mesh_destroy(m);
    soup_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_and_meshes_are_as_far_apart_as_brute_force_says),
        cmocka_unit_test(meshes_are_as_far_apart_as_brute_force_says),
        cmocka_unit_test(points_are_as_deep_as_the_surface_is_far),
        cmocka_unit_test(balls_are_as_deep_as_their_centre_is_near),
        cmocka_unit_test(every_convex_type_meets_a_boxed_mesh_as_it_meets_the_box),
        cmocka_unit_test(the_axis_separates_what_is_moved_along_it),
        cmocka_unit_test(swapping_negates_and_asking_again_repeats),
        cmocka_unit_test(scaling_by_a_power_of_two_scales_the_answer),
        cmocka_unit_test(a_representable_shift_changes_nothing),
        cmocka_unit_test(damaged_meshes_are_as_far_apart_as_brute_force_says),
        cmocka_unit_test(no_answer_about_a_mesh_carries_the_name_of_libccd),
        cmocka_unit_test(a_verdict_agrees_with_the_distance),
    };
    return cmocka_run_group_tests(tests, make_scratch, free_scratch);
}
