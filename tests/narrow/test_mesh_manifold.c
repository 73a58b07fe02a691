/* Contact points over triangles: where a box on a flat face has them, whatever the face is cut into, and with one axis.
 */
#include "brute.h"
#include "cad.h"
#include "geom/compound.h"
#include "narrow/contact/manifold.h"
#include "narrow/narrow.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

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

static narrow_result ask(const shape *a, const shape *b, pose b_in_a)
{
    const narrow_request request = {
        .facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 1e-9, .range = INFINITY, .threshold = 0.01};
    narrow_result r;
    narrow_query(a, b, &b_in_a, &request, NULL, scratch, &r);
    return r;
}

/* The box's lower corners, each once, at this depth. */
static void expect_corners(const narrow_result *r, const shape *box, double distance)
{
    if (r->manifold.count != 4) fail_msg("%u points", r->manifold.count);
    for (int sx = -1; sx <= 1; sx += 2)
        for (int sy = -1; sy <= 1; sy += 2) {
            int here = 0;
            for (uint32_t i = 0; i < 4; i++) {
                const manifold_point *p = &r->manifold.points[i];
                here += fabs(p->point.x - sx * box->half.x) < 1e-9 && fabs(p->point.y - sy * box->half.y) < 1e-9;
                assert_true(fabs(p->distance - distance) < 1e-9);
            }
            assert_int_equal(here, 1);
        }
    if (!(fabs(r->axis.z + 1) < 1e-9)) fail_msg("axis %g %g %g", r->axis.x, r->axis.y, r->axis.z);
}

static void a_box_on_a_cut_face_has_its_four_corners(void **state)
{
    (void)state;
    dice d = {5};
    shape box = {.type = SHAPE_BOX, .half = {0.4, 0.3, 0.2}};
    for (int solid = 0; solid < 2; solid++) {
        soup s = solid ? soup_box(3, 3, 1, 7) : soup_plane(3, 7);
        mesh *m = soup_mesh(&s);
        shape ground = mesh_shape(m, 0);
        for (int k = 0; k < 200; k++) {
            double depth = k % 2 ? 0.003 : -0.004, top = solid ? 1 : 0;
            vec3 at = {dice_between(&d, -2, 2), dice_between(&d, -2, 2), top + 0.2 - depth};
            narrow_result r = ask(&box, &ground, (pose){vec_neg(at), {1, 0, 0, 0}});
            expect_corners(&r, &box, -depth);
            assert_true(r.lo <= -depth + 1e-12 && -depth <= r.hi + 1e-12 && r.hi - r.lo < 1e-9);
        }
        mesh_destroy(m);
        soup_free(&s);
    }
}

/* Over every inner edge on the way: same axis, same depth. */
static void what_slides_over_inner_edges_does_not_feel_them(void **state)
{
    (void)state;
    soup s = soup_box(3, 3, 1, 9);
    mesh *m = soup_mesh(&s);
    shape ground = mesh_shape(m, 0), movers[] = {{.type = SHAPE_SPHERE, .radius = 0.2},
                                         {.type = SHAPE_CAPSULE, .radius = 0.2, .half = {0, 0, 0.3}},
                                         {.type = SHAPE_BOX, .half = {0.1, 0.1, 0.2}}};
    for (int i = 0; i < 3; i++) {
        double lowest = i == 1 ? 0.5 : 0.2;
        for (int k = 0; k <= 400; k++) {
            vec3 at = {-2 + 0.01 * k, 0.003 * k - 0.6, 1 + lowest - 0.002};
            narrow_result r = ask(&movers[i], &ground, (pose){vec_neg(at), {1, 0, 0, 0}});
            if (!(fabs(r.axis.z + 1) < 1e-9)) fail_msg("%d at %d: axis %g %g %g", i, k, r.axis.x, r.axis.y, r.axis.z);
            assert_true(r.lo <= -0.002 + 1e-12 && r.hi >= -0.002 - 1e-12 && r.hi - r.lo < 1e-9);
            assert_int_equal(r.manifold.count, i == 2 ? 4 : 1);
        }
    }
    mesh_destroy(m);
    soup_free(&s);
}

/* On its side: the line of contact stays one of two points, straight below the axis. */
static void a_cylinder_that_rolls_over_inner_edges_does_not_feel_them(void **state)
{
    (void)state;
    soup s = soup_box(3, 3, 1, 9);
    mesh *m = soup_mesh(&s);
    shape ground = mesh_shape(m, 0), roller = {.type = SHAPE_CYLINDER, .half = {0.2, 0.2, 0.3}};
    const double depth = 0.001, h = 0.70710678118654752; /* its z lies along the ground's x */
    for (int k = 0; k <= 200; k++) {
        double angle = 0.02 * k;
        vec3 at = {0.123, -2 + 0.2 * angle * 5, 1.2 - depth};
        quat rolled = quat_unit((quat){cos(angle / 2), 0, 0, -sin(angle / 2)});
        pose in_world = {at, quat_mul((quat){h, 0, h, 0}, rolled)};
        pose ground_in_roller = pose_relative(in_world, POSE_IDENTITY);
        narrow_result r = ask(&roller, &ground, ground_in_roller);
        vec3 axis = quat_rotate(in_world.q, r.axis);
        if (!(fabs(axis.z + 1) < 1e-6))
            fail_msg("at %d: axis %g %g %g of [%.12g, %.12g]", k, axis.x, axis.y, axis.z, r.lo, r.hi);
        if (!(r.lo <= -depth + 1e-9 && -depth - 1e-9 <= r.hi)) fail_msg("at %d: [%.12g, %.12g]", k, r.lo, r.hi);
        assert_true(r.hi - r.lo < 1e-7 && r.manifold.count >= 1);
        for (uint32_t i = 0; i < r.manifold.count; i++) {
            vec3 point = pose_point(in_world, r.manifold.points[i].point);
            if (!(fabs(point.y - at.y) < 0.03 && fabs(point.x - at.x) < 0.301)) fail_msg("at %d: a ghost", k);
        }
    }
    mesh_destroy(m);
    soup_free(&s);
}

/* Pressed into one side, whichever way up: the bracket of a curved solid is as narrow as that of a box. */
static void how_deep_a_curved_solid_is_in_one_side_is_known(void **state)
{
    (void)state;
    dice d = {7};
    soup s = soup_box(3, 3, 1, 7);
    mesh *m = soup_mesh(&s);
    shape ground = mesh_shape(m, 0), box = {.type = SHAPE_BOX, .half = {3, 3, 1}};
    shape all[] = {{.type = SHAPE_CAPSULE, .radius = 0.2, .half = {0, 0, 0.3}},
        {.type = SHAPE_CYLINDER, .half = {0.2, 0.2, 0.3}}, {.type = SHAPE_CONE, .half = {0.2, 0.2, 0.3}},
        {.type = SHAPE_ELLIPSOID, .half = {0.2, 0.3, 0.25}}};
    for (int k = 0; k < 200; k++) {
        const shape *solid = &all[k % 4];
        const narrow_request gap = {.facts = NARROW_DISTANCE, .tolerance = 1e-12, .range = INFINITY};
        pose at = {{dice_between(&d, -2, 2), dice_between(&d, -2, 2), 2}, dice_quat(&d)};
        narrow_result above;
        narrow_query_world(solid, at, &box, POSE_IDENTITY, &gap, scratch, &above);
        double depth = dice_between(&d, 0.001, 0.02);
        at.p.z -= above.hi + depth; /* straight down to the face below */
        narrow_result r = ask(solid, &ground, pose_relative(at, POSE_IDENTITY));
        if (!(r.lo <= -depth + 1e-9 && -depth - 1e-9 <= r.hi)) fail_msg("%d: [%g, %g], %g deep", k, r.lo, r.hi, depth);
        if (!(r.hi - r.lo < 1e-6)) fail_msg("%d: [%.12g, %.12g], %.12g deep", k, r.lo, r.hi, depth);
    }
    mesh_destroy(m);
    soup_free(&s);
}

static void ids_stay_while_the_pose_hardly_moves(void **state)
{
    (void)state;
    dice d = {6};
    soup s = soup_box(3, 3, 1, 4);
    mesh *m = soup_mesh(&s);
    shape ground = mesh_shape(m, 0), box = {.type = SHAPE_BOX, .half = {0.4, 0.3, 0.2}};
    vec3 at = {0.123, -0.456, 1.199};
    narrow_result first = ask(&box, &ground, (pose){vec_neg(at), {1, 0, 0, 0}});
    for (int k = 0; k < 100; k++) {
        quat tilt = quat_unit((quat){1, dice_between(&d, -1e-9, 1e-9), dice_between(&d, -1e-9, 1e-9), 0});
        vec3 near = vec_add(at, vec_scale(dice_vec(&d, -1, 1), 1e-9));
        narrow_result r = ask(&box, &ground, (pose){vec_neg(near), tilt});
        assert_int_equal(r.manifold.count, first.manifold.count);
        for (uint32_t i = 0; i < r.manifold.count; i++)
            assert_int_equal(r.manifold.points[i].feature, first.manifold.points[i].feature);
    }
    mesh_destroy(m);
    soup_free(&s);
}

static int by_value(const void *x, const void *y)
{
    uint32_t a = *(const uint32_t *)x, b = *(const uint32_t *)y;
    return (a > b) - (a < b);
}

/* A small box on each of 20,000 triangles in turn: more than 14 bits can tell apart. */
static void no_two_triangles_share_an_id(void **state)
{
    (void)state;
    soup s = soup_plane(1, 100);
    mesh *m = soup_mesh(&s);
    shape ground = mesh_shape(m, 0), box = {.type = SHAPE_BOX, .half = {0.001, 0.001, 0.002}};
    uint32_t *codes = malloc(m->triangle_count * sizeof *codes);
    assert_non_null(codes);
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        vec3 sum = vec_add(vec_add(mesh_corner(m, t, 0), mesh_corner(m, t, 1)), mesh_corner(m, t, 2));
        vec3 at = vec_add(vec_scale(sum, 1.0 / 3), vec(0, 0, 0.0019));
        narrow_result r = ask(&box, &ground, (pose){vec_neg(at), {1, 0, 0, 0}});
        assert_int_equal(r.manifold.count, 4);
        codes[t] = feature_code_b(r.manifold.points[0].feature);
        assert_int_equal(feature_kind(codes[t]), FEATURE_FACE);
        assert_int_equal(feature_index(codes[t]), m->triangles[t].source);
        for (uint32_t i = 1; i < 4; i++) assert_int_equal(feature_code_b(r.manifold.points[i].feature), codes[t]);
    }
    qsort(codes, m->triangle_count, sizeof *codes, by_value);
    for (uint32_t t = 1; t < m->triangle_count; t++) assert_true(codes[t - 1] < codes[t]);
    free(codes);
    mesh_destroy(m);
    soup_free(&s);
}

/* How far a point is from the line of an edge that is known by its number alone. */
static double from_edge(const mesh *m, uint32_t edge, vec3 point)
{
    for (uint32_t t = 0; t < m->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            vec3 from = mesh_corner(m, t, k), along = vec_unit(vec_sub(mesh_corner(m, t, (k + 1) % 3), from));
            if (m->triangles[t].edge[k] == edge) return vec_norm(vec_cross(along, vec_sub(point, from)));
        }
    return INFINITY;
}

/* Boxes above and below the rim of a ground of many triangles, where their edges meet its edges: each id names an edge
 * that is there. */
static void no_two_points_share_an_id(void **state)
{
    (void)state;
    dice d = {8};
    soup s = soup_plane(1, 100);
    mesh *m = soup_mesh(&s);
    shape ground = mesh_shape(m, 0);
    int edges = 0;
    for (int k = 0; k < 400; k++) {
        double turn = dice_between(&d, 0, 1.5);
        shape box = {.type = SHAPE_BOX, .half = {dice_between(&d, 0.01, 0.3), dice_between(&d, 0.01, 0.3), 0.2}};
        pose at = {{dice_between(&d, -1, 1), 1, k % 2 ? 0.199 : -0.199}, {cos(turn), 0, 0, sin(turn)}};
        narrow_result r = ask(&box, &ground, pose_relative(at, POSE_IDENTITY));
        for (uint32_t i = 0; i < r.manifold.count; i++) {
            uint32_t code = feature_code_b(r.manifold.points[i].feature);
            if (i) assert_true(r.manifold.points[i - 1].feature < r.manifold.points[i].feature);
            if (feature_kind(code) != FEATURE_EDGE) continue;
            vec3 point = pose_point(at, r.manifold.points[i].point);
            assert_true(from_edge(m, feature_index(code), point) < 0.002);
            edges++;
        }
    }
    assert_true(edges > 100);
    mesh_destroy(m);
    soup_free(&s);
}

/* What fits 14 bits makes the codes of 16 that others build on; what does not is kept whole. */
static void codes_hold_any_index(void **state)
{
    (void)state;
    const uint32_t kinds[] = {FEATURE_VERTEX, FEATURE_EDGE, FEATURE_FACE}, most = (1u << 30) - 1;
    const uint32_t indices[] = {0, 1, 0x3fff, 0x4000, 0xffff, 0x10000, MESH_TRIANGLES_MAX - 1, most};
    for (size_t k = 0; k < 3; k++)
        for (size_t i = 0; i < sizeof indices / sizeof *indices; i++) {
            uint32_t code = feature_code(kinds[k], indices[i]);
            assert_int_equal(feature_kind(code), kinds[k]);
            assert_int_equal(feature_index(code), indices[i]);
            if (indices[i] < 0x4000) assert_int_equal(code, kinds[k] | indices[i]);
            uint64_t id = feature_id(code, FEATURE_EDGE), turned = feature_turned(id);
            assert_int_equal(feature_code_a(turned), FEATURE_EDGE);
            assert_int_equal(feature_code_b(turned), code);
        }
}

/* Bodies of many parts leave each other along no part's own axis: whatever point is told of them, moving by -lo parts
 * them there, too, and it is no farther off than what counts as contact. */
static void expect_depths_within(const shape *a, const shape *b, pose at, int round)
{
    narrow_result r = ask(a, b, at);
    if (r.hi > 0) return;
    assert_true(r.manifold.count > 0);
    for (uint32_t i = 0; i < r.manifold.count; i++) {
        double d = r.manifold.points[i].distance;
        if (!(d >= r.lo - 1e-6 && d <= 0.01))
            fail_msg("round %d: a point at %.17g of [%.17g, %.17g]", round, d, r.lo, r.hi);
    }
}

static void no_point_is_deeper_than_the_whole_nor_beyond_the_threshold(void **state)
{
    (void)state;
    for (int round = 0; round < 150; round++) {
        dice d = {7919 * (uint64_t)round + 3};
        soup s[2];
        mesh *m[2];
        compound *c[2];
        for (int k = 0; k < 2; k++) {
            shape boxes[5];
            pose at[5];
            for (int i = 0; i < 5; i++) {
                boxes[i] = (shape){.type = SHAPE_BOX, .half = dice_vec(&d, 0.1, 0.7)};
                at[i] = (pose){dice_vec(&d, -0.7, 0.7), dice_quat(&d)};
            }
            assert_int_equal(compound_build(boxes, at, 5, &c[k]), COMPOUND_OK);
            s[k] = cad_solid((cad_kind)dice_between(&d, 0, CAD_KIND_COUNT - 1e-9), &d);
            m[k] = soup_mesh(&s[k]);
        }
        const shape meshes[2] = {mesh_shape(m[0], 0), mesh_shape(m[1], round % 2 * 0x1p-4)};
        const shape unions[2] = {
            {.type = SHAPE_COMPOUND, .compound = c[0]}, {.type = SHAPE_COMPOUND, .compound = c[1]}};
        pose at = {dice_vec(&d, -0.6, 0.6), dice_quat(&d)};
        expect_depths_within(&meshes[0], &meshes[1], at, round);
        expect_depths_within(&unions[0], &unions[1], at, round);
        expect_depths_within(&meshes[0], &unions[0], at, round);
        for (int k = 0; k < 2; k++) {
            compound_destroy(c[k]);
            mesh_destroy(m[k]);
            soup_free(&s[k]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_on_a_cut_face_has_its_four_corners),
        cmocka_unit_test(what_slides_over_inner_edges_does_not_feel_them),
        cmocka_unit_test(a_cylinder_that_rolls_over_inner_edges_does_not_feel_them),
        cmocka_unit_test(how_deep_a_curved_solid_is_in_one_side_is_known),
        cmocka_unit_test(ids_stay_while_the_pose_hardly_moves),
        cmocka_unit_test(no_point_is_deeper_than_the_whole_nor_beyond_the_threshold),
        cmocka_unit_test(no_two_triangles_share_an_id),
        cmocka_unit_test(no_two_points_share_an_id),
        cmocka_unit_test(codes_hold_any_index),
    };
    return cmocka_run_group_tests(tests, make_scratch, free_scratch);
}
