/* Meshes: the points of a file, each once. */
#include "fixture.h"

#include <string.h>

static const double one[3] = {1, 1, 1};

static void a_mesh_gives_each_point_once_and_sorted(void **state)
{
    (void)state;
    fixture f;
    mesh_points m;
    fixture_begin(&f);
    if (!mesh_load(&f.pool, LOADERS_DATA "/tetrahedron.stl", one, &m, &f.report)) fail_msg("%s", f.report.error);
    static const double points[] = {0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0};
    assert_int_equal(m.count, 4);
    assert_memory_equal(m.at, points, sizeof points);
    fixture_end(&f);
}

static void scale_is_applied_along_each_axis(void **state)
{
    (void)state;
    fixture f;
    mesh_points m;
    fixture_begin(&f);
    assert_true(mesh_load(&f.pool, LOADERS_DATA "/tetrahedron.stl", (double[]){2, -3, 0.001}, &m, &f.report));
    static const double points[] = {0, -3, 0, 0, 0, 0, 0, 0, 0.001, 2, 0, 0};
    assert_memory_equal(m.at, points, sizeof points);
    fixture_end(&f);
}

static void transforms_of_nodes_are_applied(void **state)
{
    (void)state;
    fixture f;
    mesh_points m;
    fixture_begin(&f);
    if (!mesh_load(&f.pool, LOADERS_DATA "/shifted.dae", one, &m, &f.report)) fail_msg("%s", f.report.error);
    static const double points[] = {10, 20, 30, 10, 21, 30, 11, 20, 30};
    assert_int_equal(m.count, 3);
    for (int i = 0; i < 9; i++) assert_true(m.at[i] == points[i]);
    fixture_end(&f);
}

static void unreadable_files_are_refused_by_name(void **state)
{
    (void)state;
    static const struct {
        const char *path, *words;
    } cases[] = {{LOADERS_DATA "/missing.stl", "missing.stl: No such file"}, {LOADERS_DATA, "is not a file"},
        {LOADERS_DATA "/cell.yaml", "cell.yaml: cannot be read as a mesh"},
        {LOADERS_DATA "/empty.stl", "empty.stl: cannot be read as a mesh: the file is empty"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        fixture f;
        mesh_points m;
        fixture_begin(&f);
        assert_false(mesh_load(&f.pool, cases[i].path, one, &m, &f.report));
        if (!strstr(f.report.error, cases[i].words)) fail_msg("'%s' lacks: %s", f.report.error, cases[i].words);
        fixture_end(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_gives_each_point_once_and_sorted),
        cmocka_unit_test(scale_is_applied_along_each_axis),
        cmocka_unit_test(transforms_of_nodes_are_applied),
        cmocka_unit_test(unreadable_files_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
