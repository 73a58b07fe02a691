/* Meshes of several bodies: one of them inside of a solid. */
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
    };
    return cmocka_run_group_tests(tests, make_scratch, free_scratch);
}
