/* Building meshes: what is a solid and what a surface, what is mended and what is said about it. */
#include "solids.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void check_mesh(const soup *s, bool solid, const char *says)
{
    mesh *m = soup_mesh(s);
    char text[512];
    mesh_describe(m, text, sizeof text);
    const char *fault = mesh_validate(m);
    if (fault) fail_msg("%s", fault);
    if (m->solid != solid || !strstr(text, says)) fail_msg("\"%s\" does not say \"%s\"", text, says);
    mesh_destroy(m);
}

static void closed_meshes_are_solids(void **state)
{
    (void)state;
    soup all[] = {soup_icosphere(1, 3), soup_box(1, 2, 3, 4), soup_torus(2, 0.5, 24, 12), soup_trough()};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        check_mesh(&all[i], true, "a solid");
        soup_free(&all[i]);
    }
}

/* A triangle's sides have one number if they have the same ends, and only then. */
static void check_edges(const mesh *m)
{
    for (uint32_t i = 0; i < 3 * m->triangle_count; i++)
        for (uint32_t j = 0; j < i; j++) {
            const mesh_triangle *s = &m->triangles[i / 3], *t = &m->triangles[j / 3];
            uint32_t a = s->v[i % 3], b = s->v[(i + 1) % 3], c = t->v[j % 3], d = t->v[(j + 1) % 3];
            bool same = (a == c && b == d) || (a == d && b == c);
            assert_int_equal(s->edge[i % 3] == t->edge[j % 3], same);
        }
}

static void edges_have_numbers_of_their_own(void **state)
{
    (void)state;
    soup turned = soup_icosphere(1, 1), inside_out = soup_torus(2, 0.5, 12, 8), open = soup_plane(1, 5);
    soup_turn(&turned, 5);
    for (size_t t = 0; t < inside_out.triangle_count; t++) soup_turn(&inside_out, t);
    soup *all[] = {&turned, &inside_out, &open};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        mesh *m = soup_mesh(all[i]);
        check_edges(m);
        mesh_destroy(m);
        soup_free(all[i]);
    }
}

static void a_hole_makes_a_surface_and_its_edges_are_counted(void **state)
{
    (void)state;
    soup s = soup_icosphere(1, 2), plane = soup_plane(1, 3);
    soup_drop(&s, 17);
    check_mesh(&s, false, "without an inside: 3 edges are open");
    check_mesh(&plane, false, "12 edges are open");
    soup_free(&s);
    soup_free(&plane);
}

static void triangles_turned_the_wrong_way_are_turned_back(void **state)
{
    (void)state;
    soup s = soup_icosphere(1, 2);
    soup_turn(&s, 5);
    soup_turn(&s, 100);
    check_mesh(&s, true, "turned to agree with their neighbours: 2 triangles");
    for (size_t t = 0; t < s.triangle_count; t++) soup_turn(&s, t);
    check_mesh(&s, true, "turned to agree with their neighbours: 318 triangles");
    soup_free(&s);
}

static void a_mesh_that_is_inside_out_is_turned(void **state)
{
    (void)state;
    soup s = soup_box(1, 1, 1, 2);
    for (size_t t = 0; t < s.triangle_count; t++) soup_turn(&s, t);
    check_mesh(&s, true, "normals pointed inward and were turned: 48 triangles");
    mesh *m = soup_mesh(&s);
    assert_true(mesh_inside(m, vec(0.1, 0.2, 0.3)));
    mesh_destroy(m);
    soup_free(&s);
}

static void what_has_no_area_or_comes_twice_is_left_out(void **state)
{
    (void)state;
    soup s = soup_box(1, 1, 1, 1);
    int32_t *end = s.corners + 3 * s.triangle_count;
    const int32_t more[9] = {
        0, 0, 1, s.corners[0], s.corners[1], s.corners[2], s.corners[1], s.corners[2], s.corners[0]};
    memcpy(end, more, sizeof more);
    s.triangle_count += 3;
    check_mesh(&s, true, "left out: 1 triangle without area; left out: 2 repeated triangles");
    soup_free(&s);
}

/* A square cut at the middle of one side on one half only, and the sliver that closes the cut. */
static void a_sliver_of_no_area_still_closes_a_seam(void **state)
{
    (void)state;
    static const double POINTS[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5, 0, 0};
    static const int32_t CLOSED[] = {0, 2, 1, 0, 3, 2, 1, 2, 3, 0, 4, 3, 4, 1, 3, 0, 1, 4};
    mesh *m;
    assert_int_equal(mesh_build(POINTS, 5, CLOSED, 6, &m), MESH_OK);
    assert_true(m->solid);
    assert_int_equal(m->triangle_count, 5);
    assert_int_equal(m->found.zero_area, 1);
    mesh_destroy(m);
    assert_int_equal(mesh_build(POINTS, 5, CLOSED, 5, &m), MESH_OK);
    assert_false(m->solid);
    mesh_destroy(m);
}

/* Beside a cube: a needle and a point; and segments and points that these or the cube's own edges have already. */
static void what_has_no_area_is_kept_where_nothing_else_is(void **state)
{
    (void)state;
    static const double MORE[] = {2, 0, 0, 3, 0, 0, 2.25, 0, 0, 5, 5, 5};
    soup s = soup_box(1, 1, 1, 1);
    int32_t first = (int32_t)s.point_count, *to = s.corners + 3 * s.triangle_count;
    const int32_t more[18] = {first, first + 2, first + 1, first, first + 1, first + 1, first + 2, first + 2, first + 2,
        first + 3, first + 3, first + 3, 0, 1, 1, 2, 2, 2};
    memcpy(s.points + 3 * s.point_count, MORE, sizeof MORE);
    memcpy(to, more, sizeof more);
    s.point_count += 4;
    s.triangle_count += 1;
    check_mesh(&s, true, "kept as segments or points: 1 triangle without area");
    s.triangle_count += 5;
    check_mesh(&s, true, "left out: 4 triangles without area; kept as segments or points: 2 triangles without area");
    mesh *m = soup_mesh(&s);
    assert_int_equal(m->triangle_count, 14);
    assert_int_equal(m->component_count, 3);
    check_edges(m);
    uint32_t needles = 0, points = 0;
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        needles += m->triangles[t].form == MESH_NEEDLE;
        points += m->triangles[t].form == MESH_FOLDED;
    }
    assert_true(needles == 1 && points == 1);
    mesh_destroy(m);
    soup_free(&s);
}

/* The seam again, cut 1e-17 beside the line: a ray that goes through the sliver counts. */
static void a_sliver_that_is_not_quite_a_line_still_closes_for_rays(void **state)
{
    (void)state;
    static const double POINTS[] = {0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, -1, 0.5, 1e-17, 0};
    static const int32_t CLOSED[] = {0, 2, 1, 0, 3, 2, 1, 2, 3, 0, 4, 3, 4, 1, 3, 0, 1, 4};
    mesh *m;
    assert_int_equal(mesh_build(POINTS, 5, CLOSED, 6, &m), MESH_OK);
    assert_true(m->solid && m->found.needles == 1 && m->triangle_count == 6);
    for (int i = 1; i < 8; i++) {
        double x = 0.125 * i, y = 0.5 * fmin(x, 1 - x) * 1e-17; /* in the sliver, seen along z */
        assert_true(mesh_inside(m, vec(x, y, 0.25 * (1 - x))) == mesh_inside(m, vec(x, 1e-6, 0.25 * (1 - x))));
        assert_true(mesh_inside(m, vec(x, y, -1e-3)) == mesh_inside(m, vec(x, -1e-6, -1e-3)));
    }
    mesh_destroy(m);
}

static void edges_of_four_triangles_are_said_and_a_cycle_stays_a_solid(void **state)
{
    (void)state;
    soup s = soup_box(1, 1, 1, 1), other = soup_box(1, 1, 1, 1);
    soup_add(&s, &other, vec(2, 2, 0)); /* they share one edge */
    check_mesh(&s, true, "a solid, 1 edge has more than two triangles");
    soup_free(&s);
    soup_free(&other);
}

static void a_fin_or_a_moebius_band_is_a_surface(void **state)
{
    (void)state;
    soup s = soup_box(1, 1, 1, 1);
    s.corners[3 * s.triangle_count] = 0;
    s.corners[3 * s.triangle_count + 1] = 1;
    double *fin = s.points + 3 * s.point_count++;
    fin[0] = fin[1] = fin[2] = 5;
    s.corners[3 * s.triangle_count + 2] = (int32_t)s.point_count - 1;
    s.triangle_count++;
    check_mesh(&s, false, "more than two triangles");
    soup_free(&s);
    enum { ROUND = 12 };
    double points[6 * ROUND];
    int32_t corners[6 * ROUND];
    for (int i = 0; i < ROUND; i++) {
        double a = 2 * M_PI * i / ROUND, h = a / 2;
        for (int side = 0; side < 2; side++) {
            double r = 2 + (side ? 0.5 : -0.5) * cos(h), z = (side ? 0.5 : -0.5) * sin(h);
            double *p = points + 6 * i + 3 * side;
            p[0] = r * cos(a), p[1] = r * sin(a), p[2] = z;
        }
        int j = (i + 1) % ROUND, twist = j == 0;
        int32_t quad[4] = {2 * i, 2 * j + twist, 2 * j + 1 - twist, 2 * i + 1};
        const int32_t two[6] = {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]};
        memcpy(corners + 6 * i, two, sizeof two);
    }
    mesh *m;
    assert_int_equal(mesh_build(points, 2 * ROUND, corners, 2 * ROUND, &m), MESH_OK);
    assert_false(m->solid);
    assert_true(m->found.torn_edges > 0);
    mesh_destroy(m);
}

static void bad_input_is_refused_by_name(void **state)
{
    (void)state;
    double points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    int32_t corners[3] = {0, 1, 2}, outside[3] = {0, 1, 3}, negative[3] = {0, -1, 2}, flat[3] = {0, 1, 1};
    mesh *m;
    assert_int_equal(mesh_build(points, 3, corners, 0, &m), MESH_NO_TRIANGLES);
    assert_int_equal(mesh_build(points, 3, outside, 1, &m), MESH_BAD_INDEX);
    assert_int_equal(mesh_build(points, 3, negative, 1, &m), MESH_BAD_INDEX);
    assert_int_equal(mesh_build(points, 3, flat, 1, &m), MESH_NO_TRIANGLES);
    points[4] = NAN;
    assert_int_equal(mesh_build(points, 3, corners, 1, &m), MESH_NOT_FINITE);
    points[4] = 1e200;
    assert_int_equal(mesh_build(points, 3, corners, 1, &m), MESH_NOT_FINITE);
    assert_null(m);
}

static void the_same_input_gives_the_same_mesh(void **state)
{
    (void)state;
    soup s = soup_torus(2, 0.7, 30, 20);
    mesh *a = soup_mesh(&s), *b = soup_mesh(&s);
    assert_int_equal(a->node_count, b->node_count);
    assert_memory_equal(a->nodes, b->nodes, a->node_count * sizeof *a->nodes);
    assert_memory_equal(a->triangles, b->triangles, a->triangle_count * sizeof *a->triangles);
    mesh_destroy(a);
    mesh_destroy(b);
    soup_free(&s);
}

static void any_number_of_triangles_makes_a_sound_tree(void **state)
{
    (void)state;
    soup s = soup_torus(2, 0.7, 12, 10);
    for (size_t n = 1; n <= s.triangle_count; n++) {
        mesh *m;
        assert_int_equal(mesh_build(s.points, s.point_count, s.corners, n, &m), MESH_OK);
        const char *fault = mesh_validate(m);
        if (fault) fail_msg("%zu triangles: %s", n, fault);
        mesh_destroy(m);
    }
    soup_free(&s);
}

/* Down to the least numbers there are, where coordinates have few bits and triangles may lose their area. */
static void meshes_of_any_size_are_sound_or_refused(void **state)
{
    (void)state;
    for (int exponent = -1073; exponent < 30; exponent += exponent < -1000 ? 3 : 60) {
        soup s = soup_torus(ldexp(3, exponent), ldexp(1, exponent), 12, 8);
        mesh *m = NULL;
        mesh_status status = mesh_build(s.points, s.point_count, s.corners, s.triangle_count, &m);
        if (exponent > -1000) assert_int_equal(status, MESH_OK);
        const char *fault = status == MESH_OK ? mesh_validate(m) : NULL;
        if (fault) fail_msg("2^%d: %s", exponent, fault);
        if (status == MESH_OK) mesh_destroy(m);
        soup_free(&s);
    }
}

static void one_triangle_is_a_surface(void **state)
{
    (void)state;
    soup s = soup_plane(1, 1);
    s.triangle_count = 1;
    check_mesh(&s, false, "a surface, without an inside: 3 edges are open");
    check_mesh(&s, false, "left out: 1 vertex that is repeated or unused");
    soup_free(&s);
}

/* Of sizes whose squares vanish, and of subnormal numbers: the unit of the boxes has an inverse. */
static void a_mesh_may_be_of_any_size(void **state)
{
    (void)state;
    static const int POWERS[] = {480, -300, -530, -600, -1000, -1020, -1024, -1060, -1074};
    for (size_t i = 0; i < sizeof POWERS / sizeof *POWERS; i++) {
        soup s = soup_box(1, 2, 3, 4);
        for (size_t k = 0; k < 3 * s.point_count; k++) s.points[k] = ldexp(4 * s.points[k], POWERS[i]);
        check_mesh(&s, true, "a solid");
        mesh *m = soup_mesh(&s);
        const char *fault = hull_validate(m->hull);
        if (fault) fail_msg("times 2^%d: %s", POWERS[i], fault);
        vec3 in = vec(ldexp(3, POWERS[i]), ldexp(-7, POWERS[i]), ldexp(11, POWERS[i]));
        assert_true(mesh_inside(m, in) && mesh_inside(m, VEC_ZERO));
        assert_false(mesh_inside(m, vec(in.x, in.y, ldexp(13, POWERS[i]))) || mesh_inside(m, vec(1e150, 0, 0)));
        mesh_destroy(m);
        soup_free(&s);
    }
}

/* Two boxes that overlap: no triangle is cut, but each point has a winding number, and where it is not 0 is inside. */
static void a_solid_may_pass_through_itself(void **state)
{
    (void)state;
    soup s = soup_box(1, 1, 1, 2), other = soup_box(1, 1, 1, 3);
    soup_add(&s, &other, vec(0.9, 0.8, 0.7));
    check_mesh(&s, true, "a solid");
    mesh *m = soup_mesh(&s);
    assert_true(mesh_inside(m, vec(-0.9, 0.1, 0.2)) && mesh_inside(m, vec(0.5, 0.55, 0.6)));
    assert_true(mesh_inside(m, vec(1.8, 1.1, 1.2)));
    assert_false(mesh_inside(m, vec(-0.5, 1.3, 0.1)));
    mesh_destroy(m);
    soup_free(&s);
    soup_free(&other);
}

/* A rough sheet, a flat one below it, and four walls between them; with COLLIDED_BRIEF a sixth of a million. */
static void a_million_triangles_make_a_sound_solid(void **state)
{
    (void)state;
    const int32_t n = getenv("COLLIDED_BRIEF") ? 200 : 500;
    const uint32_t point_count = (uint32_t)(2 * (n + 1) * (n + 1)), triangles = (uint32_t)(4 * n * n + 8 * n);
    double *points = calloc(point_count, 3 * sizeof *points), *at = points;
    int32_t *corners = calloc(triangles, 3 * sizeof *corners), *to = corners;
    assert_true(points && corners);
    for (int below = 0; below < 2; below++)
        for (int i = 0; i <= n; i++)
            for (int k = 0; k <= n; k++) *at++ = i, *at++ = k, *at++ = below ? -100 : (i * 7 + k * 3) % 11;
    for (int below = 0; below < 2; below++)
        for (int i = 0; i < n; i++)
            for (int k = 0; k < n; k++) {
                int32_t a = (below * (n + 1) + i) * (n + 1) + k, b = a + n + 1, c = b + 1, d = a + 1;
                const int32_t up[6] = {a, b, c, a, c, d}, down[6] = {a, c, b, a, d, c};
                memcpy(to, below ? down : up, sizeof up);
                to += 6;
            }
    for (int side = 0; side < 4; side++)
        for (int i = 0; i < n; i++) {
            int32_t step = side % 2 ? n + 1 : 1, first = side < 2 ? 0 : side == 2 ? n * (n + 1) : n;
            int32_t a = first + i * step, b = a + step, below = (n + 1) * (n + 1), c = b + below, d = a + below;
            bool turned = side == 1 || side == 2; /* all four look outward */
            const int32_t two[6] = {a, turned ? d : b, c, a, c, turned ? b : d};
            memcpy(to, two, sizeof two);
            to += 6;
        }
    mesh *m;
    assert_int_equal(mesh_build(points, point_count, corners, triangles, &m), MESH_OK);
    assert_null(mesh_validate(m));
    assert_true(m->solid && m->triangle_count == triangles);
    assert_true(mesh_inside(m, vec(n / 2 + 0.3, 17.2, -50)) && !mesh_inside(m, vec(n / 2 + 0.3, 17.2, 50)));
    mesh_destroy(m);
    free(points);
    free(corners);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_meshes_are_solids),
        cmocka_unit_test(edges_have_numbers_of_their_own),
        cmocka_unit_test(a_hole_makes_a_surface_and_its_edges_are_counted),
        cmocka_unit_test(triangles_turned_the_wrong_way_are_turned_back),
        cmocka_unit_test(a_mesh_that_is_inside_out_is_turned),
        cmocka_unit_test(what_has_no_area_or_comes_twice_is_left_out),
        cmocka_unit_test(a_sliver_of_no_area_still_closes_a_seam),
        cmocka_unit_test(what_has_no_area_is_kept_where_nothing_else_is),
        cmocka_unit_test(a_sliver_that_is_not_quite_a_line_still_closes_for_rays),
        cmocka_unit_test(edges_of_four_triangles_are_said_and_a_cycle_stays_a_solid),
        cmocka_unit_test(a_fin_or_a_moebius_band_is_a_surface),
        cmocka_unit_test(meshes_of_any_size_are_sound_or_refused),
        cmocka_unit_test(one_triangle_is_a_surface),
        cmocka_unit_test(a_mesh_may_be_of_any_size),
        cmocka_unit_test(a_solid_may_pass_through_itself),
        cmocka_unit_test(a_million_triangles_make_a_sound_solid),
        cmocka_unit_test(bad_input_is_refused_by_name),
        cmocka_unit_test(the_same_input_gives_the_same_mesh),
        cmocka_unit_test(any_number_of_triangles_makes_a_sound_tree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
