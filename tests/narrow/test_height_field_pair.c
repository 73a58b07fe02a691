/* Pairs with a height field: against all triangles in 113 bits, over inner edges of flat and of tilted ground, and
 * under powers of two. */
#include "brute.h"
#include "fields.h"
#include "narrow/narrow.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static narrow_scratch *scratch;
static field ground;

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

static int rounds(int nightly)
{
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / 5;
}

static narrow_result ask(const shape *a, const shape *b, pose b_in_a)
{
    const narrow_request request = {
        .facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 0, .range = INFINITY, .threshold = 0.01};
    narrow_result r;
    memset(&r, 0, sizeof r);
    narrow_query(a, b, &b_in_a, &request, NULL, scratch, &r);
    return r;
}

/* Something that moves: its core as triangles, by a rounding radius. A point or a segment is a triangle without area.
 */
typedef struct mover {
    shape shape;
    soup core;
} mover;

static soup segment(vec3 from, vec3 to)
{
    vec3 middle = vec_scale(vec_add(from, to), 0.5);
    soup s = {calloc(9, sizeof(double)), 3, calloc(3, sizeof(int32_t)), 1};
    const vec3 points[3] = {from, middle, to};
    memcpy(s.points, points, sizeof points);
    for (int k = 0; k < 3; k++) s.corners[k] = k;
    return s;
}

/* An octahedron; its hull is built by hull_build. */
static soup octahedron(hull **h)
{
    static const double POINTS[18] = {0.3, 0, 0, -0.3, 0, 0, 0, 0.2, 0, 0, -0.2, 0, 0, 0, 0.25, 0, 0, -0.25};
    soup s = {malloc(sizeof POINTS), 6, calloc(24, sizeof(int32_t)), 0};
    memcpy(s.points, POINTS, sizeof POINTS);
    for (int i = 0; i < 8; i++) {
        int32_t *to = s.corners + 3 * s.triangle_count++;
        to[0] = i & 1, to[1] = 2 + (i >> 1 & 1), to[2] = 4 + (i >> 2);
    }
    assert_int_equal(hull_build(POINTS, 6, 0, h), HULL_OK);
    return s;
}

static double as_double(quad x)
{
    return (double)x;
}

/* What is apart is as far as brute force says; what touches or is held is not called free, and no deeper than lo. */
static void hold_against(const narrow_result *r, quad gap, bool held, double radius)
{
    quad truth = held ? -gap : gap - radius;
    if (truth > 1e-12) {
        if (!((quad)r->lo <= truth && truth <= (quad)r->hi && r->hi - r->lo < 1e-9))
            fail_msg("%.17g is not in [%.17g, %.17g]", as_double(truth), r->lo, r->hi);
    } else {
        assert_true(r->lo <= r->hi && r->lo <= 1e-12);
        if (held && !((quad)r->hi <= truth + 1e-12)) fail_msg("held by %g, hi is %g", as_double(gap), r->hi);
    }
}

static void every_mover_is_as_far_from_the_ground_as_brute_force_says(void **state)
{
    (void)state;
    dice d = {31};
    hull *h;
    soup oct = octahedron(&h), ball = soup_icosphere(0.25, 0);
    mesh *other = soup_mesh(&ball);
    mover movers[] = {
        {{.type = SHAPE_CAPSULE, .radius = 0.1, .half = {0, 0, 0.3}}, segment(vec(0, 0, -0.3), vec(0, 0, 0.3))},
        {{.type = SHAPE_BOX, .half = {0.3, 0.2, 0.1}}, soup_box(0.3, 0.2, 0.1, 1)},
        {{.type = SHAPE_HULL, .hull = h, .radius = 0.05}, oct}, {mesh_shape(other, 0), ball}};
    int apart = 0, held_count = 0;
    for (int k = 0; k < rounds(160); k++) {
        mover *a = &movers[k % 4];
        field_random(&ground, &d, 5, 7, -0.5, k % 3 ? 0.5 : -0.45);
        mesh *m = field_mesh(&ground);
        soup truth = field_soup(&ground);
        shape b = mesh_shape(m, 0);
        pose at = {dice_vec(&d, -1.2, 1.2), dice_quat(&d)}; /* of the ground, seen from the mover */
        quad gap = brute_distance(&a->core, &truth, &at);
        vec3 first = vec(a->core.points[0], a->core.points[1], a->core.points[2]);
        bool held = gap > 0 && brute_winding(&truth, quat_rotate(quat_conj(at.q), vec_sub(first, at.p))) != 0;
        narrow_result r = ask(&a->shape, &b, at);
        hold_against(&r, gap, held, a->shape.radius);
        apart += gap > 0 && !held;
        held_count += held;
        mesh_destroy(m);
        soup_free(&truth);
    }
    assert_true(apart >= rounds(40) && held_count > 0);
    hull_destroy(h);
    mesh_destroy(other);
    for (size_t i = 0; i < sizeof movers / sizeof *movers; i++) soup_free(&movers[i].core);
}

/* A point's signed distance is exact on either side of the surface. */
static void points_are_as_deep_as_the_surface_is_far(void **state)
{
    (void)state;
    dice d = {32};
    shape point = {.type = SHAPE_SPHERE}, ball = {.type = SHAPE_SPHERE, .radius = 0.05};
    for (int k = 0; k < rounds(50); k++) {
        field_random(&ground, &d, 6, 6, -0.5, 0.5);
        mesh *m = field_mesh(&ground);
        soup s = field_soup(&ground);
        shape b = mesh_shape(m, 0);
        for (int i = 0; i < 20; i++) {
            vec3 p = dice_vec(&d, -1, 1);
            quad away = brute_point_distance(&s, p), truth = brute_winding(&s, p) ? -away : away;
            pose at = {vec_neg(p), {1, 0, 0, 0}};
            narrow_result r = ask(&point, &b, at), q = ask(&ball, &b, at);
            if (!((quad)r.lo <= truth && truth <= (quad)r.hi))
                fail_msg("%.17g is not in [%.17g, %.17g]", as_double(truth), r.lo, r.hi);
            if (truth > 0.05) assert_true((quad)q.lo <= truth - 0.05 && truth - 0.05 <= (quad)q.hi + 1e-16);
            assert_true((quad)q.hi <= truth - 0.05 + 1e-12);
        }
        mesh_destroy(m);
        soup_free(&s);
    }
}

/* ---- inner edges ---- */

/* Rests 2 mm deep in a plane of this slope and slides over cells, diagonals and vertices: the axis is always the
 * plane's normal, the depth always the same. */
static void slide(shape mover, vec3 normal, double support, uint32_t points)
{
    mesh *m = field_mesh(&ground);
    shape b = mesh_shape(m, 0);
    quat upright = {1, 0, 0, 0};
    for (int k = 0; k <= 400; k++) {
        double x = -1.5 + 0.0075 * k, y = 0.003 * k - 0.6;
        vec3 foot = vec(x, y, field_height(&ground, x, y));
        vec3 at = vec_madd(foot, support - 0.002, normal);
        narrow_result r = ask(&mover, &b, (pose){vec_neg(at), upright});
        if (!(vec_norm(vec_add(r.axis, normal)) < 1e-9))
            fail_msg("%s at %d: axis %g %g %g", shape_type_name(mover.type), k, r.axis.x, r.axis.y, r.axis.z);
        assert_true(r.lo <= -0.002 + 1e-12 && r.hi >= -0.002 - 1e-12 && r.hi - r.lo < 1e-9);
        assert_int_equal(r.manifold.count, points);
        for (uint32_t i = 0; i < points; i++) assert_true(fabs(r.manifold.points[i].distance + 0.002) < 1e-9);
    }
    mesh_destroy(m);
}

static void inner_edges_of_flat_ground_are_not_felt(void **state)
{
    (void)state;
    field_plane(&ground, 17, 17, 0.25, 0.125, 0, 0);
    vec3 up = vec(0, 0, 1);
    slide((shape){.type = SHAPE_BOX, .half = {0.1, 0.15, 0.2}}, up, 0.2, 4);
    slide((shape){.type = SHAPE_SPHERE, .radius = 0.2}, up, 0.2, 1);
    slide((shape){.type = SHAPE_CAPSULE, .radius = 0.1, .half = {0, 0, 0.2}}, up, 0.3, 1);
    slide((shape){.type = SHAPE_CYLINDER, .half = {0.1, 0.1, 0.2}}, up, 0.2, 4);
}

/* A ball on a slope; its heights are exact, so that the slope is one plane. */
static void inner_edges_of_a_slope_are_not_felt(void **state)
{
    (void)state;
    field_plane(&ground, 17, 17, 0.25, 0, 0.25, -0.5);
    slide((shape){.type = SHAPE_SPHERE, .radius = 0.2}, vec_unit(vec(-0.25, 0.5, 1)), 0.2, 1);
}

/* ---- relations ---- */

static void scaling_by_a_power_of_two_scales_every_bit(void **state)
{
    (void)state;
    dice d = {33};
    static field large;
    for (int k = 0; k < rounds(100); k++) {
        const double scales[3] = {0x1p-40, 0x1p10, 0x1p50}, by = scales[k % 3];
        field_random(&ground, &d, 5, 5, -0.3, 0.3);
        large.it = ground.it;
        large.it.heights = large.heights;
        large.it.dx *= by, large.it.dy *= by, large.it.base *= by;
        for (int i = 0; i < 25; i++) large.heights[i] = ground.heights[i] * by;
        mesh *m = field_mesh(&ground), *n = field_mesh(&large);
        shape a = {.type = SHAPE_BOX, .half = {0.2, 0.1, 0.15}}, c = a, b = mesh_shape(m, 0), e = mesh_shape(n, 0);
        c.half = vec_scale(c.half, by);
        pose at = {dice_vec(&d, -0.8, 0.8), dice_quat(&d)}, far = {vec_scale(at.p, by), at.q};
        narrow_result r = ask(&a, &b, at), q = ask(&c, &e, far);
        assert_true(q.lo == r.lo * by && q.hi == r.hi * by);
        assert_memory_equal(&q.axis, &r.axis, sizeof q.axis);
        mesh_destroy(m);
        mesh_destroy(n);
    }
}

/* Ground that is higher by a number without rounding, with the mover as much higher, is the same pair. */
static void shifting_both_up_changes_no_distance(void **state)
{
    (void)state;
    dice d = {34};
    static field higher;
    for (int k = 0; k < rounds(100); k++) {
        field_random(&ground, &d, 5, 5, -0.3, 0.3);
        for (int i = 0; i < 25; i++) ground.heights[i] = round(ground.heights[i] * 0x1p20) * 0x1p-20;
        ground.it.base = 0.25;
        higher.it = ground.it;
        higher.it.heights = higher.heights;
        for (int i = 0; i < 25; i++) higher.heights[i] = ground.heights[i] + 8;
        mesh *m = field_mesh(&ground), *n = field_mesh(&higher);
        shape a = {.type = SHAPE_BOX, .half = {0.2, 0.1, 0.15}}, b = mesh_shape(m, 0), c = mesh_shape(n, 0);
        vec3 p = dice_vec(&d, -0.8, 0.8);
        p.z = round(p.z * 0x1p20) * 0x1p-20;
        narrow_result r = ask(&a, &b, (pose){p, {1, 0, 0, 0}}),
                      q = ask(&a, &c, (pose){{p.x, p.y, p.z - 8}, {1, 0, 0, 0}});
        assert_true(q.lo <= r.hi && r.lo <= q.hi);
        if (r.lo > 0) assert_true(fabs(q.lo - r.lo) < 1e-12 && fabs(q.hi - r.hi) < 1e-12);
        mesh_destroy(m);
        mesh_destroy(n);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_mover_is_as_far_from_the_ground_as_brute_force_says),
        cmocka_unit_test(points_are_as_deep_as_the_surface_is_far),
        cmocka_unit_test(inner_edges_of_flat_ground_are_not_felt),
        cmocka_unit_test(inner_edges_of_a_slope_are_not_felt),
        cmocka_unit_test(scaling_by_a_power_of_two_scales_every_bit),
        cmocka_unit_test(shifting_both_up_changes_no_distance),
    };
    return cmocka_run_group_tests(tests, make_scratch, free_scratch);
}
