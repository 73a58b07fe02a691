/* Contact points over children: where one box on a floor has them, whatever the floor is laid of, along one axis, and
 * under ids that name the child. */
#include "unions.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

static narrow_result ask(const shape *a, const shape *b, pose b_in_a)
{
    const narrow_request request = {
        .facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 1e-9, .range = INFINITY, .threshold = 0.01};
    narrow_result r;
    narrow_query(a, b, &b_in_a, &request, NULL, union_scratch(), &r);
    return r;
}

/* Its lower corners, each once, at this distance; `at` is where the box is. */
static void expect_corners(const narrow_result *r, vec3 half, double distance)
{
    if (r->manifold.count != 4) fail_msg("%u points", r->manifold.count);
    for (int sx = -1; sx <= 1; sx += 2)
        for (int sy = -1; sy <= 1; sy += 2) {
            int here = 0;
            for (uint32_t i = 0; i < 4; i++) {
                const manifold_point *p = &r->manifold.points[i];
                here += fabs(p->point.x - sx * half.x) < 1e-9 && fabs(p->point.y - sy * half.y) < 1e-9;
                assert_true(fabs(p->distance - distance) < 1e-9);
            }
            assert_int_equal(here, 1);
        }
    assert_true(fabs(r->axis.z + 1) < 1e-9);
}

/* 4 x 4 tiles of 1 m, their tops at z = 0. */
static union_body tiles(void)
{
    shape parts[16];
    pose at[16];
    union_body u;
    for (int i = 0; i < 16; i++) {
        parts[i] = (shape){.type = SHAPE_BOX, .half = {0.5, 0.5, 0.25}};
        at[i] = (pose){{i % 4 - 1.5, i / 4 - 1.5, -0.25}, {1, 0, 0, 0}};
    }
    union_make(&u, parts, at, 16, 0);
    return u;
}

static void a_box_on_tiles_has_its_four_corners(void **state)
{
    (void)state;
    dice d = {51};
    union_body ground = tiles();
    shape box = {.type = SHAPE_BOX, .half = {0.4, 0.3, 0.2}};
    for (int k = 0; k < 300; k++) {
        double depth = k % 2 ? 0.003 : -0.004;
        vec3 at = {dice_between(&d, -1.5, 1.5), dice_between(&d, -1.5, 1.5), 0.2 - depth};
        narrow_result r = ask(&box, &ground.shape, (pose){vec_neg(at), {1, 0, 0, 0}});
        expect_corners(&r, box.half, -depth);
    }
    union_free(&ground);
}

/* The child of a compound of 16 is in the four highest bits. */
static uint32_t child_of(uint64_t id)
{
    return (uint32_t)id >> 28;
}

static void ids_name_the_child_and_stay(void **state)
{
    (void)state;
    union_body ground = tiles();
    shape box = {.type = SHAPE_BOX, .half = {0.4, 0.3, 0.2}};
    narrow_result before = ask(&box, &ground.shape, (pose){vec_neg(vec(0.1, 0.2, 0.197)), {1, 0, 0, 0}});
    narrow_result after = ask(&box, &ground.shape, (pose){vec_neg(vec(0.1001, 0.2001, 0.198)), {1, 0, 0, 0}});
    assert_int_equal(before.manifold.count, 4);
    for (uint32_t i = 0; i < 4; i++) {
        vec3 p = vec_add(before.manifold.points[i].point, vec(0.1, 0.2, 0.197));
        uint32_t tile = (uint32_t)(floor(p.x + 2) + 4 * floor(p.y + 2));
        assert_int_equal(child_of(before.manifold.points[i].feature), tile);
        assert_int_equal(before.manifold.points[i].feature, after.manifold.points[i].feature);
        for (uint32_t k = 0; k < i; k++)
            assert_true(before.manifold.points[i].feature != before.manifold.points[k].feature);
    }
    union_free(&ground);
}

/* A wall beside the floor is overlapped, too, but from another side: no point of it is deeper than the answer. */
static void a_wall_beside_the_floor_brings_no_deep_points(void **state)
{
    (void)state;
    const shape slabs[2] = {{.type = SHAPE_BOX, .half = {2, 2, 0.5}}, {.type = SHAPE_BOX, .half = {0.5, 2, 2}}};
    const pose at[2] = {{{0, 0, -0.5}, {1, 0, 0, 0}}, {{-0.5, 0, 0}, {1, 0, 0, 0}}};
    union_body corner;
    union_make(&corner, slabs, at, 2, 0);
    shape box = {.type = SHAPE_BOX, .half = {0.3, 0.3, 0.3}};
    narrow_result r = ask(&box, &corner.shape, (pose){vec_neg(vec(0.299, 0, 0.295)), {1, 0, 0, 0}});
    assert_true(r.manifold.count >= 1);
    for (uint32_t i = 0; i < r.manifold.count; i++) assert_true(r.manifold.points[i].distance >= r.lo - 1e-12);
    union_free(&corner);
}

/* Three balls stand on three points. */
static void feet_that_are_round_have_a_point_each(void **state)
{
    (void)state;
    const shape ball = {.type = SHAPE_SPHERE, .radius = 0.1}, balls[3] = {ball, ball, ball};
    const pose at[3] = {{{1, 0, 0}, {1, 0, 0, 0}}, {{-1, 1, 0}, {1, 0, 0, 0}}, {{-1, -1, 0}, {1, 0, 0, 0}}};
    const shape grounds[2] = {{.type = SHAPE_HALFSPACE}, {.type = SHAPE_BOX, .half = {3, 3, 1}}};
    union_body stool;
    union_make(&stool, balls, at, 3, 0);
    for (int g = 0; g < 2; g++) {
        pose above = {{0, 0, (g ? 1 : 0) + 0.098}, {1, 0, 0, 0}};
        narrow_result r = ask(&grounds[g], &stool.shape, above);
        assert_int_equal(r.manifold.count, 3);
        for (uint32_t i = 0; i < 3; i++) assert_true(fabs(r.manifold.points[i].distance + 0.002) < 1e-12);
        if (g == 0) assert_true(fabs(r.lo + 0.002) < 1e-12);
    }
    union_free(&stool);
}

static void a_mesh_holds_up_a_compound_by_its_corners(void **state)
{
    (void)state;
    soup s = soup_plane(3, 5);
    mesh *m = soup_mesh(&s);
    shape ground = mesh_shape(m, 0);
    const shape halves[2] = {
        {.type = SHAPE_BOX, .half = {0.2, 0.3, 0.2}}, {.type = SHAPE_BOX, .half = {0.2, 0.3, 0.2}}};
    const pose at[2] = {{{-0.2, 0, 0}, {1, 0, 0, 0}}, {{0.2, 0, 0}, {1, 0, 0, 0}}};
    union_body box;
    union_make(&box, halves, at, 2, 0);
    narrow_result r = ask(&ground, &box.shape, (pose){{0.13, 0.21, 0.204}, {1, 0, 0, 0}});
    r.axis.z = -r.axis.z;
    for (uint32_t i = 0; i < r.manifold.count; i++)
        r.manifold.points[i].point = vec_sub(r.manifold.points[i].point, vec(0.13, 0.21, 0));
    expect_corners(&r, vec(0.4, 0.3, 0.2), 0.004);
    mesh_destroy(m);
    soup_free(&s);
    union_free(&box);
}

static bool has_feature(const narrow_result *r, uint64_t feature)
{
    for (uint32_t i = 0; i < r->manifold.count; i++)
        if (r->manifold.points[i].feature == feature) return true;
    return false;
}

/* Of one child nothing needs to be said but what it says itself, whichever of the two is asked first. */
static void one_child_has_the_ids_of_its_shape(void **state)
{
    (void)state;
    const shape ground = {.type = SHAPE_BOX, .half = {1, 1, 1}};
    const shape children[] = {{.type = SHAPE_BOX, .half = {0.5, 0.5, 0.5}},
        {.type = SHAPE_CAPSULE, .half = {0, 0, 0.5}, .radius = 0.5}, {.type = SHAPE_CYLINDER, .half = {0.5, 0.5, 0.5}}};
    const pose beside = {{0.3, 0, 0}, {0.70710678118654757, 0, 0.70710678118654757, 0}};
    const pose at = {{0.1, 0.2, 1.48}, {1, 0, 0, 0}};
    for (size_t k = 0; k < 3; k++) {
        union_body one;
        union_make(&one, &children[k], &beside, 1, 0);
        const narrow_request request = {
            .facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 1e-6, .range = INFINITY, .threshold = 0.1};
        narrow_result r, plain;
        narrow_query(&ground, &one.shape, &at, &request, NULL, union_scratch(), &r);
        narrow_query_world(
            &ground, POSE_IDENTITY, &children[k], pose_mul(at, beside), &request, union_scratch(), &plain);
        assert_int_equal(r.manifold.count, plain.manifold.count);
        assert_true(plain.manifold.count > 1);
        for (uint32_t i = 0; i < plain.manifold.count; i++)
            assert_true(has_feature(&r, plain.manifold.points[i].feature));
        union_free(&one);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_on_tiles_has_its_four_corners),
        cmocka_unit_test(ids_name_the_child_and_stay),
        cmocka_unit_test(a_wall_beside_the_floor_brings_no_deep_points),
        cmocka_unit_test(feet_that_are_round_have_a_point_each),
        cmocka_unit_test(one_child_has_the_ids_of_its_shape),
        cmocka_unit_test(a_mesh_holds_up_a_compound_by_its_corners),
    };
    return cmocka_run_group_tests(tests, union_make_scratch, union_free_scratch);
}
