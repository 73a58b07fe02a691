/* Whole frames of published simulations against exact truth (COLLIDED_SHARED; absent: skipped, and said so): every true
 * contact is found, vertex by vertex and edge by edge; what is found beyond them is within rounding, and says so; and
 * each layer of culling, left out, gives the same contacts. */
#include "soft_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static soft_body *body_of(const soft_scene *s, soft_mesh **mesh)
{
    soft_status status;
    soft_mesh_def def = {.rest = s->start, .vertex_count = s->vertex_count, .triangles = s->triangles};
    def.triangle_count = s->triangle_count;
    *mesh = soft_mesh_create(&def, &status);
    assert_int_equal(status, SOFT_OK);
    soft_body *b = soft_body_create(*mesh);
    assert_int_equal(soft_body_set(b, s->start, s->end), SOFT_OK);
    return b;
}

static soft_step *run(soft_body *body, workers *pool, soft_want want, unsigned without)
{
    soft_step *step = soft_step_create(pool);
    soft_step_def def = {.bodies = &body,
        .body_count = 1,
        .pairs = &(soft_pair){0, 0},
        .pair_count = 1,
        .want = want,
        .contacts_max = 10000000,
        .without = without};
    assert_int_equal(soft_step_begin(step, &def), SOFT_OK);
    assert_int_equal(soft_step_run(step, 0), SOFT_OK);
    return step;
}

typedef struct sets { /* by kind: keys of contacts, sorted, and which of them are certain */
    uint64_t *all, *certain;
    size_t count, certain_count;
} sets;

static int compare_keys(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static sets sets_of(const soft_step *step, soft_kind kind)
{
    size_t count;
    const soft_contact *c = soft_step_contacts(step, &count);
    sets s = {.all = calloc(count + 1, sizeof *s.all), .certain = calloc(count + 1, sizeof *s.certain)};
    if (!s.all || !s.certain) abort();
    for (size_t i = 0; i < count; i++) {
        if (c[i].kind != kind) continue;
        uint64_t key = (uint64_t)c[i].a << 32 | c[i].b;
        s.all[s.count++] = key;
        if (c[i].proof == SOFT_CERTAIN) s.certain[s.certain_count++] = key;
    }
    return s; /* in canonical order: sorted */
}

static bool has(const uint64_t *keys, size_t count, uint64_t key)
{
    return bsearch(&key, keys, count, sizeof key, compare_keys) != NULL;
}

/* Nothing is missed, and nothing that is called certain is none. */
static void check_sets(const char *name, const char *kind, uint64_t *truth, size_t count, const sets *found)
{
    size_t missed = 0, invented = 0;
    for (size_t i = 0; i < count; i++) missed += !has(found->all, found->count, truth[i]);
    for (size_t i = 0; i < found->certain_count; i++) invented += !has(truth, count, found->certain[i]);
    printf("%s, %s: true %zu, found %zu, of these certain %zu; missed %zu, extra and called certain %zu\n", name, kind,
        count, found->count, found->certain_count, missed, invented);
    assert_int_equal(missed, 0);
    assert_int_equal(invented, 0);
    free(truth);
}

static void same_contacts(const soft_step *a, const soft_step *b)
{
    size_t count_a, count_b;
    const soft_contact *x = soft_step_contacts(a, &count_a), *y = soft_step_contacts(b, &count_b);
    assert_int_equal(count_a, count_b);
    assert_memory_equal(x, y, count_a * sizeof *x);
}

static void check_frame(const soft_truth *t, const soft_scene *scene)
{
    soft_mesh *mesh;
    soft_body *body = body_of(scene, &mesh);
    workers *pool = workers_create(2);
    soft_step *step = run(body, pool, SOFT_BRACKETS, 0);
    size_t faces, edges;
    uint64_t *true_faces = soft_truth_read(t, mesh, SOFT_VERTEX_FACE, &faces);
    uint64_t *true_edges = soft_truth_read(t, mesh, SOFT_EDGE_EDGE, &edges);
    assert_int_equal(faces, t->vertex_face);
    assert_int_equal(edges, t->edge_edge);
    sets vf = sets_of(step, SOFT_VERTEX_FACE), ee = sets_of(step, SOFT_EDGE_EDGE);
    check_sets(t->name, "vertex-face", true_faces, faces, &vf);
    check_sets(t->name, "edge-edge", true_edges, edges, &ee);
    const soft_tally *tally = soft_step_tallies(step);
    assert_int_equal(tally->left_out, 0);
    assert_int_equal(tally->vertex_face + tally->edge_edge, vf.count + ee.count);
    assert_int_equal(tally->within + tally->undecided, vf.count + ee.count - vf.certain_count - ee.certain_count);
    static const unsigned WITHOUT[] = {SOFT_WITHOUT_STARS, SOFT_WITHOUT_DIRECTIONS};
    for (size_t i = 0; i < sizeof WITHOUT / sizeof *WITHOUT; i++) {
        soft_step *bare = run(body, NULL, SOFT_BRACKETS, WITHOUT[i]);
        same_contacts(step, bare);
        soft_step_destroy(bare);
    }
    free(vf.all), free(vf.certain), free(ee.all), free(ee.certain);
    soft_step_destroy(step), soft_body_destroy(body), soft_mesh_destroy(mesh), workers_destroy(pool);
}

static void frame(size_t i)
{
    soft_scene scene;
    if (!soft_scene_read(&SOFT_TRUTH[i], &scene)) {
        printf("skipped: cases/soft/%s is not there (COLLIDED_SHARED)\n", SOFT_TRUTH[i].name);
        skip();
    }
    check_frame(&SOFT_TRUTH[i], &scene);
    soft_scene_free(&scene);
}

static void cloth_funnel(void **state)
{
    (void)state;
    frame(0);
}

static void rod_twist(void **state)
{
    (void)state;
    frame(1);
}

static void cloth_ball(void **state)
{
    (void)state;
    frame(2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cloth_funnel),
        cmocka_unit_test(rod_twist),
        cmocka_unit_test(cloth_ball),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
