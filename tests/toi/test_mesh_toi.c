/* The time of impact of meshes against dense sampling: with convex shapes of every kind and with meshes, straight and
 * turning; what is inside of a solid at the beginning touches it. */
#include "geom/compound.h"
#include "solids.h"
#include "toi/toi.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <stdio.h>

enum { PAIRS = 60, SAMPLES = 60 }; /* COLLIDED_NIGHTLY: 20 times as many pairs */

static narrow_scratch *scratch;

static narrow_result measure(const toi_mover *a, const toi_mover *b, double time, double tolerance)
{
    narrow_request r = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    pose pa = pose_mul(motion_pose(&a->motion, time), a->local), pb = pose_mul(motion_pose(&b->motion, time), b->local);
    narrow_result n;
    narrow_query_world(a->shape, pa, b->shape, pb, &r, scratch, &n);
    return n;
}

static shape convex(dice *d, int kind)
{
    double x = dice_between(d, 0.1, 0.4), y = dice_between(d, 0.1, 0.4), z = dice_between(d, 0.1, 0.4);
    switch (kind % 5) {
    case 0:
        return (shape){.type = SHAPE_SPHERE, .radius = x};
    case 1:
        return (shape){.type = SHAPE_CAPSULE, .radius = x, .half = {0, 0, z}};
    case 2:
        return (shape){.type = SHAPE_BOX, .half = {x, y, z}};
    case 3:
        return (shape){.type = SHAPE_CYLINDER, .half = {x, x, z}};
    default:
        return (shape){.type = SHAPE_ELLIPSOID, .half = {x, y, z}, .radius = 0.02};
    }
}

typedef struct tally {
    int free, hit, near;
    uint32_t queries;
} tally;

static void check(const toi_mover *a, const toi_mover *b, double turn, int seed, tally *count)
{
    toi_request request = {.span = 1, .tolerance = 1e-6};
    toi_result t;
    toi_find(a, b, &request, VEC_ZERO, scratch, &t);
    double end = fmin(t.lo, 1);
    assert_int_not_equal(t.status, TOI_UNDECIDED);
    for (int k = 0; k < SAMPLES && end > 0; k++) {
        double time = end * k / SAMPLES;
        narrow_result n = measure(a, b, time, 1e-7);
        if (n.hi <= -1e-12)
            fail_msg("seed %d, turn %g: %s at [%g, %g], but it touches at %g by %g", seed, turn,
                toi_status_name(t.status), t.lo, t.hi, time, n.hi);
    }
    if (t.status == TOI_HIT) {
        assert_true(t.lo <= t.hi && t.hi <= 1);
        narrow_result n = measure(a, b, t.hi, 1e-7);
        if (n.lo > 1e-12) fail_msg("seed %d, turn %g: apart by %g at hi %g", seed, turn, n.lo, t.hi);
    }
    count->free += t.status == TOI_FREE;
    count->hit += t.status == TOI_HIT;
    count->near += t.status == TOI_NEAR;
    count->queries += t.queries;
}

static void fly(const shape *whole, bool both, double turn)
{
    int pairs = getenv("COLLIDED_NIGHTLY") ? 20 * PAIRS : PAIRS;
    tally t = {.free = 0};
    for (int i = 0; i < pairs; i++) {
        dice d = {(uint64_t)i * 7919 + (uint64_t)(turn * 100) + both};
        shape other = both ? *whole : convex(&d, i);
        vec3 from = vec_scale(vec_unit(dice_vec(&d, -1, 1)), 4), aim = dice_vec(&d, -1.2, 1.2);
        motion ma = {{from, dice_quat(&d)}, vec_scale(vec_sub(aim, from), dice_between(&d, 0.7, 1.8)),
            dice_vec(&d, -turn, turn)};
        motion mb = {{VEC_ZERO, dice_quat(&d)}, VEC_ZERO, dice_vec(&d, -turn, turn)};
        toi_mover a = {&other, POSE_IDENTITY, ma}, b = {whole, POSE_IDENTITY, mb};
        check(&a, &b, turn, i, &t);
    }
    print_message("turning by up to %g rad: %d free, %d hit, %d near; %.1f distances a pair\n", turn * 1.7, t.free,
        t.hit, t.near, (double)t.queries / pairs);
    assert_true(t.hit > pairs / 5);
}

static void meshes_are_not_missed(void **state)
{
    (void)state;
    soup torus = soup_torus(1, 0.3, 24, 12), trough = soup_trough();
    mesh *ring = soup_mesh(&torus), *box = soup_mesh(&trough);
    const shape shapes[] = {mesh_shape(ring, 0), mesh_shape(box, 0.05)};
    for (int k = 0; k < 2; k++) {
        fly(&shapes[k], false, 0);
        fly(&shapes[k], false, 1);
        fly(&shapes[k], true, 0);
        fly(&shapes[k], true, 1);
    }
    mesh_destroy(ring);
    mesh_destroy(box);
    soup_free(&torus);
    soup_free(&trough);
}

/* A ball flies through the hole of a ring, and one through the ring itself. */
static void the_hole_of_a_ring_is_free(void **state)
{
    (void)state;
    soup torus = soup_torus(1, 0.3, 48, 24);
    mesh *ring = soup_mesh(&torus);
    shape whole = mesh_shape(ring, 0), ball = {.type = SHAPE_SPHERE, .radius = 0.5};
    toi_mover b = {&whole, POSE_IDENTITY, {POSE_IDENTITY, VEC_ZERO, {0, 0, 3}}};
    toi_mover through = {&ball, POSE_IDENTITY, {{{0, 0, -5}, {1, 0, 0, 0}}, {0, 0, 10}, VEC_ZERO}};
    toi_mover across = {&ball, POSE_IDENTITY, {{{1, 0, -5}, {1, 0, 0, 0}}, {0, 0, 10}, VEC_ZERO}};
    toi_request request = {.span = 1, .tolerance = 1e-6};
    toi_result t;
    toi_find(&through, &b, &request, VEC_ZERO, scratch, &t);
    assert_int_equal(t.status, TOI_FREE);
    toi_find(&across, &b, &request, VEC_ZERO, scratch, &t);
    assert_int_equal(t.status, TOI_HIT);
    assert_true(t.lo > 0.419 && t.hi < 0.425); /* 0.42 on a true torus, a bit later on its facets */
    mesh_destroy(ring);
    soup_free(&torus);
}

static void what_begins_inside_of_a_solid_touches_it(void **state)
{
    (void)state;
    soup s = soup_icosphere(2, 3);
    mesh *m = soup_mesh(&s);
    shape whole = mesh_shape(m, 0), ball = {.type = SHAPE_SPHERE, .radius = 0.1};
    toi_mover b = {&whole, POSE_IDENTITY, {POSE_IDENTITY, VEC_ZERO, VEC_ZERO}};
    toi_mover a = {&ball, POSE_IDENTITY, {POSE_IDENTITY, {0.1, 0, 0}, VEC_ZERO}};
    toi_request request = {.span = 1, .tolerance = 1e-6};
    toi_result t;
    toi_find(&a, &b, &request, VEC_ZERO, scratch, &t);
    assert_true(t.status == TOI_HIT && t.hi == 0);
    mesh_destroy(m);
    soup_free(&s);
}

/* With a threshold below zero, contact is a depth of the whole, which no part comes to: B goes into A, by 3 m in a
 * second, and turns. What is told must agree with the depth at samples of the way, of boxes where these are wholes that
 * look like one. */
static void goes_deep(const shape *a, const shape *b, double threshold, double turn, int *hits)
{
    static const shape BOX = {.type = SHAPE_BOX, .half = {1, 1, 1}};
    bool turned = a->type > b->type;
    toi_mover still = {a, POSE_IDENTITY, {.start = POSE_IDENTITY}};
    toi_mover goes = {b, POSE_IDENTITY, {{{2.9, 0.1, 0.05}, {1, 0, 0, 0}}, {-3, 0, 0}, {turn, 0.5 * turn, 0}}};
    const toi_mover *x = turned ? &goes : &still, *y = turned ? &still : &goes;
    toi_request request = {.span = 1, .threshold = threshold, .tolerance = 1e-6};
    toi_result t;
    toi_find(x, y, &request, VEC_ZERO, scratch, &t);
    toi_mover u = *x, v = *y; /* whose depth is known */
    if (u.shape->type >= SHAPE_MESH) u.shape = &BOX;
    if (v.shape->type >= SHAPE_MESH) v.shape = &BOX;
    for (int k = 0; k <= SAMPLES; k++) {
        double time = (double)k / SAMPLES;
        narrow_result n = measure(&u, &v, time, 1e-7);
        if (time < t.lo && n.hi <= threshold - 1e-9)
            fail_msg("types %d and %d, threshold %g, turn %g: %s from %g s, but %g m at %g s", x->shape->type,
                y->shape->type, threshold, turn, toi_status_name(t.status), t.lo, n.hi, time);
    }
    if (t.status == TOI_HIT) assert_true(t.lo <= t.hi && measure(&u, &v, t.hi, 1e-7).lo <= threshold + 1e-9);
    *hits += t.status == TOI_HIT;
}

static void wholes_are_deeper_than_their_parts(void **state)
{
    (void)state;
    soup s = soup_box(1, 1, 1, 1);
    mesh *m = soup_mesh(&s);
    shape slices[4], ball = {.type = SHAPE_SPHERE, .radius = 0.5}, box = {.type = SHAPE_BOX, .half = {1, 1, 1}};
    pose at[4];
    for (int i = 0; i < 4; i++) {
        slices[i] = (shape){.type = SHAPE_BOX, .half = {0.25, 1, 1}};
        at[i] = (pose){{-0.75 + 0.5 * i, 0, 0}, {1, 0, 0, 0}};
    }
    compound *sliced;
    assert_int_equal(compound_build(slices, at, 4, &sliced), COMPOUND_OK);
    shape cube = mesh_shape(m, 0), loaf = {.type = SHAPE_COMPOUND, .compound = sliced};
    const shape *pairs[][2] = {{&cube, &cube}, {&cube, &ball}, {&box, &cube}, {&loaf, &loaf}, {&box, &loaf}};
    static const double THRESHOLDS[] = {0, -0.01, -0.1, -0.3, -0.6, -3};
    int hits = 0;
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++)
        for (size_t k = 0; k < sizeof THRESHOLDS / sizeof *THRESHOLDS; k++)
            for (double turn = 0; turn < 1; turn += 0.4)
                goes_deep(pairs[i][0], pairs[i][1], THRESHOLDS[k], turn, &hits);
    assert_in_range(hits, 50, 5 * 5 * 3); /* none is 3 m deep */
    compound_destroy(sliced);
    mesh_destroy(m);
    soup_free(&s);
}

/* Two that overlap by less than they may, and rest: that is proven, not left open. */
static void what_rests_shallow_is_free(void **state)
{
    (void)state;
    soup s = soup_box(1, 1, 1, 1);
    mesh *m = soup_mesh(&s);
    shape cube = mesh_shape(m, 0);
    toi_mover a = {&cube, POSE_IDENTITY, {.start = POSE_IDENTITY}};
    toi_mover b = {&cube, POSE_IDENTITY, {.start = {{1.95, 0.1, 0}, {1, 0, 0, 0}}, .linear = {0, 0.5, 0}}};
    toi_request request = {.span = 1, .threshold = -0.1, .tolerance = 1e-6};
    toi_result t;
    toi_find(&a, &b, &request, VEC_ZERO, scratch, &t);
    assert_int_equal(t.status, TOI_FREE);
    mesh_destroy(m);
    soup_free(&s);
}

/* A square of n x n spikes, open, of one height. */
static mesh *spikes(int n, double height)
{
    int across = 2 * n + 1;
    size_t count = (size_t)across * (size_t)across, triangles = 8 * (size_t)n * (size_t)n;
    soup s = {malloc(3 * count * sizeof(double)), count, malloc(3 * triangles * sizeof(int32_t)), triangles};
    double *point = s.points;
    int32_t *corner = s.corners;
    for (int i = 0; i < across; i++)
        for (int j = 0; j < across; j++) {
            *point++ = i, *point++ = j, *point++ = i & j & 1 ? height : 0;
            if (i + 1 == across || j + 1 == across) continue;
            int32_t a = i * across + j, b = a + 1, c = a + across, d = c + 1;
            bool even = (i & 1) == (j & 1); /* the diagonal goes to the top */
            const int32_t both[6] = {a, c, even ? d : b, even ? a : c, d, b};
            memcpy(corner, both, sizeof both), corner += 6;
        }
    mesh *m = soup_mesh(&s);
    soup_free(&s);
    return m;
}

/* Two such surfaces lie so close all over that there is more to look at than is looked at: what is told of the time
 * that it came to is what holds then. */
static void what_is_too_much_is_told_with_its_gap(void **state)
{
    (void)state;
    mesh *m = spikes(120, 5);
    shape s = mesh_shape(m, 0);
    toi_mover a = {&s, POSE_IDENTITY, {.start = POSE_IDENTITY}};
    toi_mover b = {&s, POSE_IDENTITY, {.start = {{0, 0, 0.05}, {1, 0, 0, 0}}, .linear = {0.005, 0.003, 0}}};
    toi_request request = {.span = 1, .tolerance = 1e-6};
    toi_result t;
    toi_find(&a, &b, &request, VEC_ZERO, scratch, &t);
    assert_int_equal(t.status, TOI_UNDECIDED);
    narrow_result n = measure(&a, &b, t.lo, 1e-6);
    assert_true(t.gap_lo <= n.hi && n.lo <= t.gap_hi); /* one query has not the effort to tell them apart, either */
    assert_true(fabs(vec_norm(t.axis) - 1) < 1e-12);
    assert_true(fabs(vec_norm(vec_sub(t.point_b, t.point_a)) - n.hi) < 1e-5);
    mesh_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(meshes_are_not_missed),
        cmocka_unit_test(the_hole_of_a_ring_is_free), cmocka_unit_test(what_begins_inside_of_a_solid_touches_it),
        cmocka_unit_test(wholes_are_deeper_than_their_parts), cmocka_unit_test(what_rests_shallow_is_free),
        cmocka_unit_test(what_is_too_much_is_told_with_its_gap)};
    scratch = aligned_alloc(64, narrow_scratch_size());
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    free(scratch);
    return failed;
}
