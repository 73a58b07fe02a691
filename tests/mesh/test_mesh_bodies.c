/* Meshes of several bodies and of needles: what is inside of what, in both orders, closed and open, one in another's
 * hollow; and triangles without area, which are segments and points. Against all pairs of triangles in 113 bits, and
 * winding numbers body by body; of convex bodies against the same as hulls. */
#include "brute.h"
#include "narrow/narrow.h"
#include "narrow/toi.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static narrow_scratch *scratch;

static narrow_result ask(const shape *a, const shape *b, pose b_in_a, unsigned facts)
{
    const narrow_request request = {.facts = facts, .tolerance = 1e-9, .range = INFINITY};
    pose at_a = POSE_IDENTITY;
    narrow_result r;
    memset(&r, 0xa5, sizeof r);
    narrow_query_world(a, at_a, b, b_in_a, &request, scratch, &r);
    return r;
}

static void expect(const shape *a, const shape *b, pose b_in_a, double truth)
{
    narrow_result r = ask(a, b, b_in_a, NARROW_DISTANCE | NARROW_MANIFOLD);
    pose a_in_b = pose_relative(b_in_a, POSE_IDENTITY);
    narrow_result back = ask(b, a, a_in_b, NARROW_DISTANCE);
    if (!(r.lo <= truth + 1e-12 && truth - 1e-12 <= r.hi)) fail_msg("%g is not in [%.17g, %.17g]", truth, r.lo, r.hi);
    if (!(back.lo <= truth + 1e-12 && truth - 1e-12 <= back.hi))
        fail_msg("turned: %g is not in [%.17g, %.17g]", truth, back.lo, back.hi);
    assert_true(fabs(vec_norm(r.axis) - 1) < 1e-14);
    assert_true(truth > 0 || (r.hi < 0 && r.manifold.count > 0));
    if (truth < 0) { /* CCD sees it, too */
        toi_mover ma = {a, POSE_IDENTITY, {.start = POSE_IDENTITY}};
        toi_mover mb = {b, POSE_IDENTITY, {.start = b_in_a, .linear = {0.01, 0, 0}}};
        const toi_request request = {.span = 1, .tolerance = 1e-6};
        toi_result t;
        bool in_order = narrow_ordered(a, 0, b, 1);
        toi_find(in_order ? &ma : &mb, in_order ? &mb : &ma, &request, VEC_ZERO, scratch, &t);
        if (t.status != TOI_HIT || t.hi != 0) fail_msg("CCD: %s at %g", toi_status_name(t.status), t.hi);
    }
}

static void one_of_two_bodies_of_a_mesh_is_inside_of_a_solid(void **state)
{
    (void)state;
    soup pair = soup_box(0.1, 0.1, 0.1, 1), small = soup_box(0.1, 0.1, 0.1, 1), cube = soup_box(1, 1, 1, 1);
    for (size_t i = 0; i < pair.point_count; i++) pair.points[3 * i] += 5;
    soup_add(&pair, &small, VEC_ZERO);
    soup open = pair;
    mesh *mb = soup_mesh(&cube);
    for (int is_open = 0; is_open < 2; is_open++) {
        if (is_open) soup_drop(&open, 0);
        mesh *ma = soup_mesh(&open);
        shape a = mesh_shape(ma, 0), b = mesh_shape(mb, 0);
        expect(&a, &b, POSE_IDENTITY, -1.1);
        assert_int_equal(ma->solid, !is_open);
        mesh_destroy(ma);
    }
    mesh_destroy(mb);
    soup_free(&pair);
    soup_free(&small);
    soup_free(&cube);
}

/* A triangle whose corners lie on a line, and one far away; the needle is in the cube. */
static void a_needle_in_a_cube_touches_it(void **state)
{
    (void)state;
    static const double POINTS[] = {0, 0, 0, 0.5, 0, 0, 0.25, 0, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0};
    static const int32_t CORNERS[] = {0, 1, 2, 3, 4, 5}, FOLDED[] = {0, 1, 1, 3, 4, 5}, POINT[] = {0, 0, 0, 3, 4, 5};
    const int32_t *const all[] = {CORNERS, FOLDED, POINT};
    const double truths[] = {-1, -1, -1};
    soup cube = soup_box(1, 1, 1, 1);
    mesh *solid = soup_mesh(&cube);
    const shape box = {.type = SHAPE_BOX, .half = {1, 1, 1}}, b = mesh_shape(solid, 0);
    for (int k = 0; k < 3; k++) {
        mesh *m;
        assert_int_equal(mesh_build(POINTS, 6, all[k], 2, &m), MESH_OK);
        shape a = mesh_shape(m, 0);
        expect(&a, &box, POSE_IDENTITY, truths[k]);
        expect(&a, &b, POSE_IDENTITY, truths[k]);
        mesh_destroy(m);
    }
    mesh_destroy(solid);
    soup_free(&cube);
}

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_of_two_bodies_of_a_mesh_is_inside_of_a_solid),
        cmocka_unit_test(a_needle_in_a_cube_touches_it),
    };
    return cmocka_run_group_tests(tests, make_scratch, free_scratch);
}
