/* The inside of solids, against solid angles, and on the lines where a careless ray goes wrong. */
#include "brute.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static void random_points_agree_with_the_sum_of_solid_angles(void **state)
{
    (void)state;
    dice d = {7};
    soup all[] = {soup_icosphere(1, 2), soup_torus(0.8, 0.3, 16, 9), soup_trough(), soup_box(1, 0.5, 0.7, 3)};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        mesh *m = soup_mesh(&all[i]);
        int inside = 0;
        for (int k = 0; k < 3000; k++) {
            vec3 p = dice_vec(&d, -1.2, 1.2);
            bool truth = brute_winding(&all[i], p) != 0;
            inside += truth;
            if (mesh_inside(m, p) != truth) fail_msg("solid %zu, point %g %g %g", i, p.x, p.y, p.z);
        }
        assert_true(inside > 100);
        mesh_destroy(m);
        soup_free(&all[i]);
    }
}

/* The grid's lines run through corners, along edges and in the planes of faces. */
static void points_straight_below_corners_and_edges_are_decided(void **state)
{
    (void)state;
    soup box = soup_box(1, 1, 1, 4), trough = soup_trough();
    mesh *m = soup_mesh(&box), *u = soup_mesh(&trough);
    for (int i = -6; i <= 6; i++)
        for (int k = -6; k <= 6; k++)
            for (int l = -6; l <= 6; l++) {
                double x = 0.25 * i, y = 0.25 * k, z = 0.25 * l, most = fmax(fabs(x), fmax(fabs(y), fabs(z)));
                if (most == 1) continue; /* on the surface */
                assert_int_equal(mesh_inside(m, vec(x, y, z)), most < 1);
                bool in_trough = fabs(x) <= 0.75 && z >= -0.75, on = in_trough && (fabs(x) == 0.75 || z == -0.75);
                if (most < 1 && !on) assert_int_equal(mesh_inside(u, vec(x, y, z)), !in_trough);
                if (most > 1) assert_false(mesh_inside(u, vec(x, y, z)));
            }
    mesh_destroy(m);
    mesh_destroy(u);
    soup_free(&box);
    soup_free(&trough);
}

static void a_point_one_ulp_off_a_slanted_face_is_on_its_side(void **state)
{
    (void)state;
    /* the face x + y + z = 1 of a corner */
    static const double POINTS[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const int32_t CORNERS[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    mesh *m;
    assert_int_equal(mesh_build(POINTS, 4, CORNERS, 4, &m), MESH_OK);
    dice d = {3};
    for (int i = 0; i < 10000; i++) {
        double x = floor(dice_between(&d, 1, 0x1p20)) * 0x1p-22, y = floor(dice_between(&d, 1, 0x1p20)) * 0x1p-22;
        double z = 1 - x - y; /* exact */
        assert_true(mesh_inside(m, vec(x, y, nextafter(z, 0))));
        assert_false(mesh_inside(m, vec(x, y, nextafter(z, 2))));
    }
    mesh_destroy(m);
}

static void a_hollow_is_outside_and_what_floats_in_it_is_inside(void **state)
{
    (void)state;
    soup s = soup_icosphere(3, 1), hollow = soup_icosphere(2, 1), core = soup_icosphere(1, 1);
    for (size_t t = 0; t < hollow.triangle_count; t++) soup_turn(&hollow, t);
    soup_add(&s, &hollow, VEC_ZERO);
    soup_add(&s, &core, VEC_ZERO);
    mesh *m = soup_mesh(&s);
    assert_true(m->solid);
    assert_true(mesh_inside(m, vec(0.1, 0.2, 0.1)));
    assert_false(mesh_inside(m, vec(1.3, 0.2, 0.1)));
    assert_true(mesh_inside(m, vec(2.2, 0.2, 0.1)));
    assert_false(mesh_inside(m, vec(3.2, 0.2, 0.1)));
    mesh_destroy(m);
    soup_free(&s);
    soup_free(&hollow);
    soup_free(&core);
}

static void surfaces_have_no_inside(void **state)
{
    (void)state;
    soup s = soup_icosphere(1, 1);
    soup_drop(&s, 0);
    mesh *m = soup_mesh(&s);
    assert_false(mesh_inside(m, VEC_ZERO));
    mesh_destroy(m);
    soup_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_points_agree_with_the_sum_of_solid_angles),
        cmocka_unit_test(points_straight_below_corners_and_edges_are_decided),
        cmocka_unit_test(a_point_one_ulp_off_a_slanted_face_is_on_its_side),
        cmocka_unit_test(a_hollow_is_outside_and_what_floats_in_it_is_inside),
        cmocka_unit_test(surfaces_have_no_inside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
