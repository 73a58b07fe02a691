/* The bracket of an overlap: the move that it names separates, and no shorter one does. */
#include "unions.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static int rounds(int nightly)
{
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / 5;
}

static qvec exact(vec3 v)
{
    return qv(v.x, v.y, v.z);
}

static void the_move_that_is_named_separates(void **state)
{
    (void)state;
    dice d = {41};
    int overlaps = 0, narrow = 0;
    for (int k = 0; k < rounds(500); k++) {
        union_body a, b;
        if (k % 2)
            union_boxes(&a, &d, 3);
        else
            union_single(&a, (shape){.type = SHAPE_BOX, .half = {0.3, 0.2, 0.25}});
        union_boxes(&b, &d, 1 + (size_t)k % 6);
        pose at = {dice_vec(&d, -0.9, 0.9), dice_quat(&d)};
        narrow_result r = union_ask(&a.shape, &b.shape, at, 0);
        union_place(&a, POSE_IDENTITY, qv(0, 0, 0));
        if (r.hi < 0) {
            union_place(&b, at, q_scale(exact(r.axis), -(quad)r.lo + 1e-12));
            quad left = union_apart_by(&a, &b);
            if (!(left > -1e-12)) fail_msg("%d: [%g, %g] still overlap by %g", k, r.lo, r.hi, (double)-left);
            assert_true((r.status == NARROW_CERTAIN) == (r.hi - r.lo < 1e-11 && r.status == NARROW_CERTAIN));
            overlaps++;
            narrow += r.hi - r.lo < 1e-9;
        }
        union_free(&a);
        union_free(&b);
    }
    assert_true(overlaps >= rounds(200));
    if (narrow * 3 < overlaps) fail_msg("only %d of %d brackets closed", narrow, overlaps);
}

/* Directions all around: the shortest of the sampled moves that separates is no shorter than -hi. */
static void no_sampled_move_is_shorter(void **state)
{
    (void)state;
    dice d = {42};
    for (int k = 0; k < rounds(40); k++) {
        union_body a, b;
        union_boxes(&a, &d, 2);
        union_boxes(&b, &d, 3);
        pose at = {dice_vec(&d, -0.5, 0.5), dice_quat(&d)};
        narrow_result r = union_ask(&a.shape, &b.shape, at, 0);
        union_place(&a, POSE_IDENTITY, qv(0, 0, 0));
        for (int i = 0; i < 40 && r.hi < 0; i++) {
            vec3 way = vec_scale(vec_unit(dice_vec(&d, -1, 1)), -r.hi * (1 - 1e-9));
            union_place(&b, at, exact(way));
            assert_true(union_nearest(&a, &b).lo < 0);
        }
        union_free(&a);
        union_free(&b);
    }
}

static union_body corner_of_slabs(void)
{
    const shape slabs[2] = {{.type = SHAPE_BOX, .half = {2, 2, 0.5}}, {.type = SHAPE_BOX, .half = {0.5, 2, 2}}};
    const pose at[2] = {{{0, 0, -0.5}, {1, 0, 0, 0}}, {{-0.5, 0, 0}, {1, 0, 0, 0}}};
    union_body u;
    union_make(&u, slabs, at, 2, 0);
    return u;
}

/* Floor and wall: it must leave both, along neither one's normal. */
static void what_is_wedged_finds_its_way_out(void **state)
{
    (void)state;
    union_body corner = corner_of_slabs();
    shape ball = {.type = SHAPE_SPHERE, .radius = 0.5};
    double down = 0.03, aside = 0.04;
    pose ball_at = {{0.5 - aside, 0, 0.5 - down}, {1, 0, 0, 0}}, corner_in_ball = {vec_neg(ball_at.p), {1, 0, 0, 0}};
    narrow_result r = union_ask(&ball, &corner.shape, corner_in_ball, 0);
    assert_true(r.lo <= -0.05 && r.lo > -0.05 - 1e-9);
    assert_true(r.hi >= -0.05 && r.hi <= -0.04 + 1e-12);
    assert_true(r.status == NARROW_WIDE); /* pairs of parts cannot tell that both must be left at once */
    assert_true(fabs(r.axis.x + 0.8) < 1e-9 && fabs(r.axis.z + 0.6) < 1e-9); /* from the ball to the corner */
    union_free(&corner);
}

/* Where one part is all that is met, the depth is that part's. */
static void one_side_is_as_deep_as_its_part(void **state)
{
    (void)state;
    dice d = {43};
    union_body corner = corner_of_slabs();
    for (int k = 0; k < 200; k++) {
        shape box = {.type = SHAPE_BOX, .half = dice_vec(&d, 0.1, 0.3)};
        double depth = dice_between(&d, 0.001, 0.05);
        vec3 at = {dice_between(&d, 0.5, 1.2), dice_between(&d, -1, 1), box.half.z - depth};
        narrow_result r = union_ask(&box, &corner.shape, (pose){vec_neg(at), {1, 0, 0, 0}}, 0);
        if (!(r.lo <= -depth + 1e-15 && -depth - 1e-15 <= r.hi && r.hi - r.lo < 1e-12))
            fail_msg("%d: [%.17g, %.17g], depth %.17g", k, r.lo, r.hi, depth);
        assert_int_equal(r.status, NARROW_CERTAIN);
        assert_true(r.axis.z < -1 + 1e-12);
    }
    union_free(&corner);
}

enum { BOXES = 4 };

typedef struct box_union {
    size_t count;
    double lo[BOXES][3], hi[BOXES][3];
} box_union;

/* Multiples of 1/64: all sums are exact. */
static box_union random_box_union(dice *d, size_t count, union_body *u)
{
    box_union b = {.count = count};
    shape parts[BOXES];
    pose at[BOXES];
    for (size_t i = 0; i < count; i++) {
        double c[3], h[3];
        for (int x = 0; x < 3; x++) {
            h[x] = (int)dice_between(d, 4, 48) / 64.0;
            c[x] = (int)dice_between(d, -32, 32) / 64.0;
            b.lo[i][x] = c[x] - h[x];
            b.hi[i][x] = c[x] + h[x];
        }
        parts[i] = (shape){.type = SHAPE_BOX, .half = {h[0], h[1], h[2]}};
        at[i] = (pose){{c[0], c[1], c[2]}, {1, 0, 0, 0}};
    }
    union_make(u, parts, at, count, 0);
    return b;
}

static bool box_unions_overlap(const box_union *a, const box_union *b, const double move[3])
{
    for (size_t i = 0; i < a->count; i++)
        for (size_t k = 0; k < b->count; k++) {
            bool meet = true;
            for (int x = 0; x < 3; x++)
                meet &= a->lo[i][x] < b->hi[k][x] + move[x] && b->lo[k][x] + move[x] < a->hi[i][x];
            if (meet) return true;
        }
    return false;
}

/* The nearest point outside of a union of boxes has coordinates that are 0 or those of faces. */
static double box_unions_depth(const box_union *a, const box_union *b)
{
    double at[3][1 + 2 * BOXES * BOXES], best = INFINITY;
    size_t count = 0;
    for (int x = 0; x < 3; x++) {
        count = 0;
        at[x][count++] = 0;
        for (size_t i = 0; i < a->count; i++)
            for (size_t k = 0; k < b->count; k++) {
                at[x][count++] = a->hi[i][x] - b->lo[k][x];
                at[x][count++] = a->lo[i][x] - b->hi[k][x];
            }
    }
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < count; k++)
            for (size_t l = 0; l < count; l++) {
                const double move[3] = {at[0][i], at[1][k], at[2][l]};
                double length2 = move[0] * move[0] + move[1] * move[1] + move[2] * move[2];
                if (length2 < best && !box_unions_overlap(a, b, move)) best = length2;
            }
    return sqrt(best);
}

static void unions_of_boxes_are_as_deep_as_brute_force_finds(void **state)
{
    (void)state;
    dice d = {45};
    int overlaps = 0, narrow = 0;
    for (int k = 0; k < rounds(1000); k++) {
        union_body u, v;
        const double still[3] = {0, 0, 0};
        box_union x = random_box_union(&d, 1 + (size_t)k % BOXES, &u);
        box_union y = random_box_union(&d, 2 + (size_t)k / 4 % (BOXES - 1), &v);
        narrow_result r = union_ask(&u.shape, &v.shape, POSE_IDENTITY, 1e-6);
        if (box_unions_overlap(&x, &y, still)) {
            double depth = box_unions_depth(&x, &y);
            if (!(r.lo <= -depth + 1e-12 && -depth - 1e-12 <= r.hi))
                fail_msg("%d: [%.12g, %.12g], depth %.12g", k, r.lo, r.hi, depth);
            assert_true((r.status == NARROW_CERTAIN) == (r.hi - r.lo <= 1e-6));
            overlaps++;
            narrow += r.hi - r.lo <= 1e-6;
        }
        union_free(&u);
        union_free(&v);
    }
    if (overlaps < rounds(700) || narrow < 0.95 * overlaps) fail_msg("%d of %d are narrow", narrow, overlaps);
}

/* Above a half-space nothing is hidden: as deep as the deepest child, to the last digits. */
static void a_half_space_is_left_along_its_normal(void **state)
{
    (void)state;
    dice d = {44};
    shape plane = {.type = SHAPE_HALFSPACE};
    for (int k = 0; k < rounds(500); k++) {
        union_body b;
        union_random(&b, &d, 6, 0);
        pose at = {dice_vec(&d, -1, 1), dice_quat(&d)};
        union_place(&b, at, qv(0, 0, 0));
        quad foot = INFINITY;
        for (size_t i = 0; i < b.count; i++) {
            const oracle_body *o = &b.parts[i].exact;
            foot = q_min(foot, oracle_support(o, qv(0, 0, -1)).z - o->radius);
        }
        narrow_result r = union_ask(&plane, &b.shape, at, 0);
        if (!((quad)r.lo <= foot && foot <= (quad)r.hi && r.hi - r.lo < 1e-12))
            fail_msg("[%.17g, %.17g], foot %.17g", r.lo, r.hi, (double)foot);
        assert_int_equal(r.status, NARROW_CERTAIN);
        union_free(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_move_that_is_named_separates),
        cmocka_unit_test(no_sampled_move_is_shorter),
        cmocka_unit_test(what_is_wedged_finds_its_way_out),
        cmocka_unit_test(one_side_is_as_deep_as_its_part),
        cmocka_unit_test(unions_of_boxes_are_as_deep_as_brute_force_finds),
        cmocka_unit_test(a_half_space_is_left_along_its_normal),
    };
    return cmocka_run_group_tests(tests, union_make_scratch, union_free_scratch);
}
