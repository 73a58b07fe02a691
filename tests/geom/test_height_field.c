/* Height fields: closed by construction, heights bit for bit, and what is refused. */
#include "brute.h"
#include "fields.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static field ground;

static double volume_of(const double *points, const int32_t *corners, size_t count)
{
    double sum = 0;
    for (size_t t = 0; t < count; t++) {
        vec3 p[3];
        for (size_t k = 0; k < 3; k++) memcpy(&p[k], points + 3 * (size_t)corners[3 * t + k], sizeof p[k]);
        sum += vec_dot(p[0], vec_cross(p[1], p[2])) / 6;
    }
    return sum;
}

static double volume_of_mesh(const mesh *m)
{
    int32_t *corners = malloc(3 * m->triangle_count * sizeof *corners);
    for (uint32_t t = 0; t < m->triangle_count; t++)
        for (uint32_t k = 0; k < 3; k++) corners[3 * t + k] = (int32_t)m->triangles[t].v[k];
    double volume = volume_of(&m->vertices->x, corners, m->triangle_count);
    free(corners);
    return volume;
}

/* Nothing had to be mended: closed and outward as it was made. */
static void every_size_is_a_solid_as_it_was_made(void **state)
{
    (void)state;
    dice d = {21};
    const mesh_findings nothing = {0};
    for (uint32_t rows = 2; rows <= 9; rows++)
        for (uint32_t columns = 2; columns <= 9; columns++) {
            field_random(&ground, &d, rows, columns, -1, 1);
            mesh *m = field_mesh(&ground);
            soup s = field_soup(&ground);
            const char *fault = mesh_validate(m);
            if (fault) fail_msg("%u x %u: %s", rows, columns, fault);
            assert_true(m->solid);
            assert_memory_equal(&m->found, &nothing, sizeof nothing);
            assert_int_equal(m->triangle_count, height_field_triangles(rows, columns));
            assert_true(m->rows == rows && m->columns == columns);
            double truth = volume_of(s.points, s.corners, s.triangle_count);
            assert_true(truth > 0 && fabs(volume_of_mesh(m) - truth) < 1e-12);
            mesh_destroy(m);
            soup_free(&s);
        }
}

static void heights_are_kept_bit_for_bit_where_they_belong(void **state)
{
    (void)state;
    dice d = {22};
    field_random(&ground, &d, 7, 12, -3, 5);
    mesh *m = field_mesh(&ground);
    for (uint32_t row = 0; row < 7; row++)
        for (uint32_t column = 0; column < 12; column++) {
            double x = (column - 5.5) * ground.it.dx, y = (row - 3.0) * ground.it.dy;
            double z = ground.heights[row * 12 + column];
            bool here = false;
            for (uint32_t i = 0; i < m->vertex_count; i++)
                here |= m->vertices[i].x == x && m->vertices[i].y == y && m->vertices[i].z == z;
            assert_true(here);
        }
    mesh_destroy(m);
}

static void the_inside_is_what_lies_between_surface_and_base(void **state)
{
    (void)state;
    dice d = {23};
    for (int k = 0; k < 40; k++) {
        field_random(&ground, &d, 6, 5, -1, 1);
        mesh *m = field_mesh(&ground);
        double x = 2 * ground.it.dx, y = 2.5 * ground.it.dy, lowest = INFINITY;
        for (int i = 0; i < 30; i++) lowest = fmin(lowest, ground.heights[i]);
        for (int i = 0; i < 100; i++) {
            vec3 p = vec(dice_between(&d, -x, x), dice_between(&d, -y, y), 0);
            double h = field_height(&ground, p.x, p.y);
            const double heights[4] = {
                h + 1e-9, h - 1e-9, lowest - ground.it.base + 1e-9, lowest - ground.it.base - 1e-9};
            for (int j = 0; j < 4; j++) {
                p.z = heights[j];
                assert_true(mesh_inside(m, p) == (j == 1 || j == 2));
            }
            assert_false(mesh_inside(m, vec(x + 1e-9, p.y, h - 1e-9)));
            assert_false(mesh_inside(m, vec(p.x, -y - 1e-9, h - 1e-9)));
        }
        /* above the very lines of the grid, where rays graze walls and edges */
        for (int i = 0; i < 30; i++) {
            vec3 p = vec((i % 5 - 2) * ground.it.dx, (i / 5 - 2.5) * ground.it.dy, ground.heights[i] + 1e-9);
            assert_false(mesh_inside(m, p));
            bool rim = i % 5 == 0 || i % 5 == 4 || i / 5 == 0 || i / 5 == 5;
            p.z = ground.heights[i] - 1e-9;
            if (!rim) assert_true(mesh_inside(m, p));
        }
        mesh_destroy(m);
    }
}

/* What is bent everywhere has an outline that is coarser than its points: none is farther outside than is said. */
static void the_hull_of_large_ground_holds_all_of_it(void **state)
{
    (void)state;
    static const uint32_t SIZES[4][2] = {{65, 64}, {60, 70}, {2, 2200}, {2200, 2}};
    double *heights = malloc(70 * 70 * sizeof *heights);
    dice d = {24};
    for (int k = 0; k < 12; k++) {
        uint32_t rows = SIZES[k % 4][0], columns = SIZES[k % 4][1];
        for (uint32_t i = 0; i < rows * columns; i++) {
            double x = (double)(i % columns) / columns - 0.5, y = (double)(i / columns) / rows - 0.5;
            heights[i] = k < 4 ? -x * x - y * y : k < 8 ? 0.25 : dice_between(&d, -1, 1);
        }
        const height_field f = {rows, columns, 0.01, 0.02, 0.5, heights};
        mesh *m;
        assert_int_equal(height_field_build(&f, &m), HEIGHT_FIELD_OK);
        double out = -INFINITY;
        for (uint32_t face = 0; face < m->hull->face_count; face += 1 + m->hull->face_count / 64)
            for (uint32_t i = 0; i < m->vertex_count; i++)
                out = fmax(out, vec_dot(m->hull->faces[face].normal, m->vertices[i]) - m->hull->faces[face].offset);
        if (!(out <= m->hull->excess + 1e-9)) fail_msg("%g outside, it says %g", out, m->hull->excess);
        assert_true(m->hull->excess < 1e-3);
        mesh_destroy(m);
    }
    free(heights);
}

static void expect(height_field_status status, height_field f, const char *words)
{
    mesh *m;
    height_field_status got = height_field_build(&f, &m);
    if (got != status) fail_msg("%s, not %s", height_field_status_text(got), height_field_status_text(status));
    assert_non_null(strstr(height_field_status_text(got), words));
    assert_null(m);
}

static void bad_fields_are_refused_by_name(void **state)
{
    (void)state;
    double h[4] = {1, 2, 3, 4}, hole[4] = {1, NAN, 3, 4}, endless[4] = {1, 2, 3, -INFINITY}, far[4] = {1, 1e200, 3, 4};
    double high[4] = {1e20, 1e20, 1e20, 1e20};
    const height_field good = {.rows = 2, .columns = 2, .dx = 1, .dy = 1, .base = 1, .heights = h};
    height_field f = good;
    f.rows = 1, expect(HEIGHT_FIELD_NO_CELL, f, "at least 2 rows"), f = good;
    f.columns = 1, expect(HEIGHT_FIELD_NO_CELL, f, "2 columns"), f = good;
    f.rows = 0, expect(HEIGHT_FIELD_NO_CELL, f, "2 rows"), f = good;
    f.rows = f.columns = UINT32_MAX, expect(HEIGHT_FIELD_TOO_MANY, f, "too many triangles"), f = good;
    assert_true(height_field_triangles(1446, 1446) <= MESH_TRIANGLES_MAX);
    f.rows = 1447, f.columns = 1446; /* one beyond: refused before a height is read */
    expect(HEIGHT_FIELD_TOO_MANY, f, "too many"), f = good;
    f.dx = 0, expect(HEIGHT_FIELD_BAD_SPACING, f, "spacing"), f = good;
    f.dy = -1, expect(HEIGHT_FIELD_BAD_SPACING, f, "above 0"), f = good;
    f.dx = NAN, expect(HEIGHT_FIELD_BAD_SPACING, f, "spacing"), f = good;
    f.dy = INFINITY, expect(HEIGHT_FIELD_BAD_SPACING, f, "spacing"), f = good;
    f.dy = 5e-324, expect(HEIGHT_FIELD_BAD_SPACING, f, "spacing"), f = good;
    f.base = 0, expect(HEIGHT_FIELD_BAD_BASE, f, "base"), f = good;
    f.base = -1, expect(HEIGHT_FIELD_BAD_BASE, f, "above 0"), f = good;
    f.base = NAN, expect(HEIGHT_FIELD_BAD_BASE, f, "base"), f = good;
    f.base = INFINITY, expect(HEIGHT_FIELD_BAD_BASE, f, "base"), f = good;
    f.heights = high, expect(HEIGHT_FIELD_BAD_BASE, f, "lost below"), f = good;
    f.heights = hole, expect(HEIGHT_FIELD_BAD_HEIGHT, f, "no holes"), f = good;
    f.heights = endless, expect(HEIGHT_FIELD_BAD_HEIGHT, f, "not finite"), f = good;
    f.heights = far, expect(HEIGHT_FIELD_BAD_HEIGHT, f, "beyond the limit");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_size_is_a_solid_as_it_was_made),
        cmocka_unit_test(heights_are_kept_bit_for_bit_where_they_belong),
        cmocka_unit_test(the_inside_is_what_lies_between_surface_and_base),
        cmocka_unit_test(the_hull_of_large_ground_holds_all_of_it),
        cmocka_unit_test(bad_fields_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
