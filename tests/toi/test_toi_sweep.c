/* Until when sweep.h says that two parts are apart, they are, by dense sampling: boxes, other convex shapes, and
 * triangles and turned boxes of a mesh, straight and turning. And it says so of most that never come near. */
#include "narrow/narrow.h"
#include "solids.h"
#include "toi/sweep.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { SAMPLES = 40, CLOSE = 4, KINDS = 5 };

/* A tenth of them in CI, all with COLLIDED_NIGHTLY=1 in the environment, few with COLLIDED_BRIEF=1. */
static int rounds(void)
{
    const int nightly = 40000;
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / (getenv("COLLIDED_BRIEF") ? 100 : 10);
}

static shape some_shape(dice *d, int kind, const mesh *m)
{
    double x = dice_between(d, 0.1, 0.5), y = dice_between(d, 0.1, 0.5), z = dice_between(d, 0.1, 0.5);
    switch (kind) {
    case 0:
        return (shape){.type = SHAPE_SPHERE, .radius = x};
    case 1:
        return (shape){.type = SHAPE_CAPSULE, .radius = 0.2 * x, .half = {0, 0, z}};
    case 2:
        return (shape){.type = SHAPE_BOX, .half = {x, y, z}, .radius = 0.1 * y};
    case 3:
        return (shape){.type = SHAPE_CYLINDER, .half = {x, x, z}};
    default:
        return mesh_shape(m, 0.01);
    }
}

/* The part itself, or so many levels down. */
static toi_part some_part(dice *d, const shape *whole, int levels)
{
    toi_part part, children[PART_CHILDREN_MAX];
    toi_part_root(whole, &part);
    for (int k = 0; k < levels && !part.is_leaf; k++) {
        int count = toi_part_children(&part, children);
        part = children[(int)dice_between(d, 0, count)];
    }
    return part;
}

/* A turned box is as far away as the part of its mesh in it or nearer: so any of the triangles below it will do. */
static toi_part leaf_below(dice *d, const toi_part *part)
{
    toi_part leaf = *part, children[PART_CHILDREN_MAX];
    while (!leaf.is_leaf) {
        int count = toi_part_children(&leaf, children);
        leaf = children[(int)dice_between(d, 0, count)];
    }
    if (leaf.form == TOI_PART_TRIANGLE) leaf.shape.hull = NULL; /* it is copied: set where it comes to rest */
    return leaf;
}

static toi_mover some_mover(dice *d, const shape *s, double turn, double far)
{
    toi_mover m = {.shape = s, .local = {dice_vec(d, -0.3, 0.3), dice_quat(d)}};
    m.motion.start = (pose){dice_vec(d, -far, far), dice_quat(d)};
    m.motion.linear = dice_vec(d, -2, 2);
    if (turn > 0) m.motion.angular = vec_scale(vec_unit(dice_vec(d, -1, 1)), turn * dice_between(d, 0.2, 1));
    return m;
}

static pose place_of(const toi_mover *m, const toi_part *part, double time)
{
    return pose_mul(pose_mul(motion_pose(&m->motion, time), m->local), part->local);
}

static double gap_at(const toi_mover movers[2], const toi_part parts[2], double time, narrow_scratch *scratch)
{
    narrow_request r = {.facts = NARROW_DISTANCE, .tolerance = 1e-10, .range = INFINITY};
    narrow_result n;
    narrow_query_world(&parts[0].shape, place_of(&movers[0], &parts[0], time), &parts[1].shape,
        place_of(&movers[1], &parts[1], time), &r, scratch, &n);
    return n.hi;
}

/* All over the span, and then just before the end of what is said to be free. */
static double sample(int i, double entry)
{
    if (i <= SAMPLES - CLOSE || entry > 1) return fmin((double)i / (SAMPLES - CLOSE), 1);
    double before = 1e-9;
    for (; i < SAMPLES + CLOSE - 1; i++) before *= 10;
    return fmax(entry - before, 0);
}

static void no_part_is_said_to_be_apart_when_it_is_not(void **state)
{
    (void)state;
    static const double TURNS[] = {0, 0.7, 3};
    static narrow_scratch *scratch;
    static sweep s;
    soup torus = soup_torus(0.8, 0.3, 24, 12);
    mesh *m = soup_mesh(&torus);
    int never_near = 0, told = 0, met = 0;
    scratch = aligned_alloc(64, narrow_scratch_size());
    assert_non_null(scratch);
    for (int k = 0; k < rounds(); k++) {
        dice d = {(uint64_t)k * 613 + 1};
        shape shapes[2] = {some_shape(&d, k % KINDS, m), some_shape(&d, k / KINDS % KINDS, m)};
        double turn = TURNS[k % 3], threshold = k % 4 ? 0 : 0.05;
        toi_mover movers[2] = {some_mover(&d, &shapes[0], turn, 1.5), some_mover(&d, &shapes[1], turn, 1.5)};
        toi_request request = {.span = 1, .threshold = threshold, .tolerance = 1e-6};
        toi_part parts[2] = {some_part(&d, &shapes[0], k % 9), some_part(&d, &shapes[1], k % 7)};
        for (int i = 0; i < 2; i++)
            if (parts[i].form == TOI_PART_TRIANGLE) parts[i].shape.hull = &parts[i].flat;
        vec3 hint = VEC_ZERO;
        assert_true(sweep_init(&s, &movers[0], &movers[1], &request));
        double entry = INFINITY, least = INFINITY;
        for (double from = 0; from < request.span && entry == INFINITY; from = s.end) {
            sweep_begin(&s, from, request.span);
            entry = sweep_entry(&s, &parts[0], &parts[1], from, request.span, &hint);
        }
        toi_part leaves[2] = {leaf_below(&d, &parts[0]), leaf_below(&d, &parts[1])};
        for (int i = 0; i < 2; i++)
            if (leaves[i].form == TOI_PART_TRIANGLE) {
                leaves[i].flat.x = leaves[i].x, leaves[i].flat.y = leaves[i].y, leaves[i].flat.z = leaves[i].z;
                leaves[i].shape.hull = &leaves[i].flat;
            }
        for (int i = 0; i < SAMPLES + CLOSE; i++) {
            double time = sample(i, entry), gap = gap_at(movers, leaves, time, scratch);
            least = fmin(least, gap);
            if (time < entry && gap <= threshold)
                fail_msg("round %d: apart until %g, but at %g the gap is %g", k, entry, time, gap);
        }
        met += least <= threshold;
        if (!(parts[0].is_leaf && parts[1].is_leaf && least > threshold + 0.2)) continue;
        never_near++;
        told += entry == INFINITY;
    }
    mesh_destroy(m);
    soup_free(&torus);
    free(scratch);
    if (!(told > 0.95 * never_near)) fail_msg("%d of %d that never come near are told", told, never_near);
    assert_true(met > rounds() / 100 && never_near > rounds() / 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_part_is_said_to_be_apart_when_it_is_not)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
