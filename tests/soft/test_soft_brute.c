/* Small patches on hostile structure (crumpled, folded, knotted, coplanar, on a lattice, loose) against the elementary
 * tests of all pairs of features: the same contacts with the same brackets and proofs; with each layer of culling left
 * out; for 1 to 4 workers; in pieces of any size; for a body with itself, two bodies, a thickness, and every filter.
 * And limits and bad input. COLLIDED_NIGHTLY=1: a hundred times as many frames; COLLIDED_BRIEF=1: a fifth. */
#include "soft_scene.h"

#include "base/prng.h"
#include "soft/elementary.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { TRIANGLES = 200, CONTACTS_MOST = 1000000 };

static unsigned frames(unsigned usual)
{
    if (getenv("COLLIDED_NIGHTLY")) return 100 * usual;
    return getenv("COLLIDED_BRIEF") ? (usual + 4) / 5 : usual;
}

/* ---- all pairs ---- */

typedef struct terms {
    double half_thickness, rest_exclusion, separation;
    unsigned ring;
} terms;

typedef struct found {
    soft_contact *at;
    size_t count;
    double t_lo; /* the least; 1 = none */
} found;

static void ask(found *f, const soft_scene *a, const uint32_t va[3], const soft_scene *b, const uint32_t vb[3],
    soft_kind kind, uint32_t id_a, uint32_t id_b, double separation, bool verdict)
{
    vec3 start[4], end[4];
    int of_first = kind == SOFT_EDGE_EDGE ? 2 : 1;
    bool swap = kind == SOFT_FACE_VERTEX;
    for (int i = 0; i < 4; i++) {
        bool first = i < of_first;
        const soft_scene *s = first != swap ? a : b;
        const uint32_t *v = first != swap ? va : vb;
        start[i] = s->start[v[first ? i : i - of_first]], end[i] = s->end[v[first ? i : i - of_first]];
    }
    elementary_result r;
    elementary_terms t = {separation, 1, verdict};
    (kind == SOFT_EDGE_EDGE ? elementary_edge_edge_on : elementary_vertex_face_on)(start, end, &t, &r);
    if (r.status == ELEMENTARY_FREE) return;
    assert_true(f->count < CONTACTS_MOST);
    float lo = (float)r.t_lo, hi = (float)r.t_hi;
    if ((double)lo > r.t_lo) lo = nextafterf(lo, -1);
    if ((double)hi < r.t_hi) hi = nextafterf(hi, 2);
    f->at[f->count++] = (soft_contact){.a = id_a,
        .b = id_b,
        .t_lo = lo,
        .t_hi = hi,
        .kind = (uint8_t)kind,
        .proof = (uint8_t)(r.proof == ELEMENTARY_CERTAIN  ? SOFT_CERTAIN
                           : r.proof == ELEMENTARY_WITHIN ? SOFT_WITHIN
                                                          : SOFT_UNDECIDED)};
    if (r.t_lo < f->t_lo) f->t_lo = r.t_lo;
}

/* Edges between any two vertices, by Floyd and Warshall: nothing of the mesh's own walk. */
static uint8_t *hops_of(const soft_scene *s)
{
    size_t n = s->vertex_count;
    uint8_t *hops = malloc(n * n);
    if (!hops) abort();
    memset(hops, 100, n * n);
    for (size_t i = 0; i < n; i++) hops[i * n + i] = 0;
    for (size_t i = 0; i < s->triangle_count; i++)
        for (int k = 0; k < 9; k++) {
            uint32_t a = s->triangles[i][k / 3], b = s->triangles[i][k % 3];
            if (a != b) hops[a * n + b] = 1;
        }
    for (size_t k = 0; k < n; k++)
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n && hops[i * n + k] < 100; j++)
                if (hops[i * n + k] + hops[k * n + j] < hops[i * n + j])
                    hops[i * n + j] = (uint8_t)(hops[i * n + k] + hops[k * n + j]);
    return hops;
}

typedef struct filter {
    const soft_scene *scene;
    const uint8_t *hops;
    const terms *terms;
} filter;

static bool lets_through(const filter *f, const uint32_t *a, int of_a, const uint32_t *b, int of_b)
{
    vec3 at[4];
    double lo, hi;
    for (int i = 0; i < of_a; i++)
        for (int k = 0; k < of_b; k++)
            if (f->hops[a[i] * f->scene->vertex_count + b[k]] <= f->terms->ring) return false;
    if (f->terms->rest_exclusion == 0) return true;
    for (int i = 0; i < 4; i++) at[i] = f->scene->start[i < of_a ? a[i] : b[i - of_a]]; /* at rest: the start */
    (of_a == 2 ? elementary_edge_edge_distance : elementary_vertex_face_distance)(at, &lo, &hi);
    assert_true(lo <= hi && hi - lo <= 1e-9 * (1 + hi));
    return lo > f->terms->rest_exclusion;
}

static bool is_face(const uint32_t v[3])
{
    return v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
}

static bool *used_vertices(const soft_scene *s)
{
    bool *used = calloc(s->vertex_count, 1);
    if (!used) abort();
    for (size_t i = 0; i < s->triangle_count; i++)
        for (int k = 0; k < 3; k++) used[s->triangles[i][k]] = true;
    return used;
}

/* Vertices of a with faces of b. */
static void all_vertices(found *f, const soft_scene *a, const soft_scene *b, soft_kind kind, const filter *self,
    double separation, bool verdict)
{
    bool *used = used_vertices(a);
    for (uint32_t v = 0; v < a->vertex_count; v++)
        for (uint32_t t = 0; used[v] && t < b->triangle_count; t++) {
            const uint32_t *face = b->triangles[t], one[3] = {v};
            if (!is_face(face) || (self && !lets_through(self, one, 1, face, 3))) continue;
            if (kind == SOFT_FACE_VERTEX)
                ask(f, b, face, a, one, kind, t, v, separation, verdict);
            else
                ask(f, a, one, b, face, kind, v, t, separation, verdict);
        }
    free(used);
}

static void all_edges(found *f, const soft_scene *a, const soft_mesh *mesh_a, const soft_scene *b,
    const soft_mesh *mesh_b, const filter *self, double separation, bool verdict)
{
    uint32_t x[3] = {0}, y[3] = {0};
    for (uint32_t i = 0; i < soft_mesh_edge_count(mesh_a); i++)
        for (uint32_t k = self ? i + 1 : 0; k < soft_mesh_edge_count(mesh_b); k++) {
            soft_mesh_edge(mesh_a, i, x), soft_mesh_edge(mesh_b, k, y);
            if (self && !lets_through(self, x, 2, y, 2)) continue;
            ask(f, a, x, b, y, SOFT_EDGE_EDGE, i, k, separation, verdict);
        }
}

/* ---- both ways ---- */

typedef struct thing {
    soft_scene scene;
    soft_mesh *mesh;
    soft_body *body;
} thing;

static thing make(soft_scene scene, const terms *t)
{
    soft_status status;
    thing it = {.scene = scene};
    soft_mesh_def def = {.rest = scene.start,
        .vertex_count = scene.vertex_count,
        .triangles = scene.triangles,
        .triangle_count = scene.triangle_count,
        .half_thickness = t->half_thickness,
        .ring = t->ring,
        .rest_exclusion = t->rest_exclusion};
    it.mesh = soft_mesh_create(&def, &status);
    assert_int_equal(status, SOFT_OK);
    it.body = soft_body_create(it.mesh);
    assert_int_equal(soft_body_set(it.body, scene.start, scene.end), SOFT_OK);
    return it;
}

static void unmake(thing *t)
{
    soft_body_destroy(t->body), soft_mesh_destroy(t->mesh), soft_scene_free(&t->scene);
}

static soft_step *run(const thing *things, size_t count, soft_pair pair, soft_want want, unsigned without,
    workers *pool, uint64_t units, double separation)
{
    soft_body *bodies[2];
    for (size_t i = 0; i < count; i++) bodies[i] = things[i].body;
    soft_step *step = soft_step_create(pool);
    soft_step_def def = {.bodies = bodies,
        .body_count = count,
        .pairs = &pair,
        .pair_count = 1,
        .want = want,
        .contacts_max = CONTACTS_MOST,
        .without = without,
        .separation = separation};
    assert_int_equal(soft_step_begin(step, &def), SOFT_OK);
    soft_status status;
    while ((status = soft_step_run(step, units)) == SOFT_MORE) {
        double lo, hi;
        soft_step_safe(step, &lo, &hi);
        assert_true(lo == 0); /* undone is never free */
    }
    assert_int_equal(status, SOFT_OK);
    return step;
}

static bool same_contact(const soft_contact *a, const soft_contact *b)
{
    return a->pair == b->pair && a->a == b->a && a->b == b->b && a->t_lo == b->t_lo && a->t_hi == b->t_hi &&
           a->kind == b->kind && a->proof == b->proof;
}

/* The same contacts, but for those within rounding, which a box or a direction may prove to be none. */
static void compare(const soft_step *step, const found *truth, const char *what)
{
    size_t count, k = 0;
    const soft_contact *c = soft_step_contacts(step, &count);
    const soft_tally *tally = soft_step_tallies(step);
    for (size_t i = 0; i < truth->count; i++) {
        const soft_contact *t = &truth->at[i];
        if (k < count && same_contact(&c[k], t))
            k++;
        else if (t->proof == SOFT_CERTAIN)
            fail_msg("%s: contact %zu, kind %u, %u and %u, is not told", what, i, t->kind, t->a, t->b);
    }
    if (k != count) fail_msg("%s: contact %zu, kind %u, %u and %u, is none", what, k, c[k].kind, c[k].a, c[k].b);
    assert_int_equal(tally->vertex_face + tally->edge_edge, count);
    assert_int_equal(tally->left_out, 0);
}

static void check_safe(const soft_step *step, const found *truth)
{
    double lo, hi;
    bool any_within = false;
    for (size_t i = 0; i < truth->count; i++) any_within |= truth->at[i].proof != SOFT_CERTAIN;
    soft_step_safe(step, &lo, &hi);
    assert_true(lo == truth->t_lo || (any_within && lo > truth->t_lo));
    assert_true(truth->count ? hi >= lo : isinf(hi));
}

/* Nothing that is left out of the culling changes a bit of what is told. */
static void same_as(const soft_step *a, const soft_step *b)
{
    size_t count_a, count_b;
    const soft_contact *x = soft_step_contacts(a, &count_a), *y = soft_step_contacts(b, &count_b);
    assert_int_equal(count_a, count_b);
    assert_memory_equal(x, y, count_a * sizeof *x);
}

static void all_ways(const thing *things, size_t count, soft_pair pair, const terms *t, const found *truth,
    const found *verdicts, uint64_t seed)
{
    soft_step *all = run(things, count, pair, SOFT_BRACKETS, 0, NULL, 0, t->separation);
    for (unsigned without = 0; without < 32; without += without < 16 ? 1 : 15) {
        soft_step *step = run(things, count, pair, SOFT_BRACKETS, without, NULL, 0, t->separation);
        compare(step, truth, "a layer left out");
        same_as(step, all);
        check_safe(step, truth);
        soft_step_destroy(step);
        step = run(things, count, pair, SOFT_SAFE_STEP, without, NULL, 0, t->separation);
        check_safe(step, truth);
        soft_step_destroy(step);
    }
    for (unsigned n = 1; n <= 4; n++) {
        workers *pool = workers_create(n);
        soft_step *step = run(things, count, pair, SOFT_BRACKETS, 0, pool, 1 + prng_bits(&seed) % 20000, t->separation);
        compare(step, truth, "in pieces, by workers");
        same_as(step, all);
        soft_step_destroy(step);
        step = run(things, count, pair, SOFT_VERDICTS, 0, pool, 0, t->separation);
        compare(step, verdicts, "verdicts");
        soft_step_destroy(step);
        step = run(things, count, pair, SOFT_SAFE_STEP, 0, pool, 0, t->separation);
        check_safe(step, truth);
        soft_step_destroy(step), workers_destroy(pool);
    }
    soft_step_destroy(all);
}

static found found_create(void)
{
    found f = {.at = malloc(CONTACTS_MOST * sizeof *f.at), .t_lo = 1};
    if (!f.at) abort();
    return f;
}

static terms draw_terms(uint64_t *seed)
{
    terms t = {0};
    uint64_t r = prng_bits(seed);
    if (r % 4 == 1) t.half_thickness = prng_in(seed, 0, 0.05);
    if (r % 8 == 2) t.separation = prng_in(seed, 0, 0.05);
    if (r / 8 % 4 == 1) t.ring = 1 + (unsigned)(r / 32 % 2);
    if (r / 8 % 4 == 2) t.rest_exclusion = prng_in(seed, 0, 0.5);
    return t;
}

static size_t with_itself(soft_class c, uint64_t seed)
{
    uint64_t draw = seed * 977 + (uint64_t)c;
    terms t = draw_terms(&draw);
    thing it = make(soft_scene_make(c, seed, TRIANGLES), &t);
    uint8_t *hops = hops_of(&it.scene);
    filter self = {&it.scene, hops, &t};
    found truth[2] = {found_create(), found_create()};
    double separation = t.half_thickness + t.half_thickness + t.separation;
    for (int verdict = 0; verdict < 2; verdict++) {
        all_vertices(&truth[verdict], &it.scene, &it.scene, SOFT_VERTEX_FACE, &self, separation, verdict);
        all_edges(&truth[verdict], &it.scene, it.mesh, &it.scene, it.mesh, &self, separation, verdict);
    }
    assert_int_equal(truth[0].count, truth[1].count); /* a verdict is that of the full test */
    all_ways(&it, 1, (soft_pair){0, 0}, &t, &truth[0], &truth[1], seed);
    size_t count = truth[0].count;
    free(hops), free(truth[0].at), free(truth[1].at), unmake(&it);
    return count;
}

static int compare_faces(const void *a, const void *b)
{
    const soft_contact *x = a, *y = b;
    return x->a != y->a ? (x->a > y->a) - (x->a < y->a) : (x->b > y->b) - (x->b < y->b);
}

static size_t with_each_other(soft_class a, soft_class b, uint64_t seed)
{
    terms t = {.half_thickness = seed % 2 ? 0.01 : 0};
    thing things[2] = {
        make(soft_scene_make(a, seed, TRIANGLES), &t), make(soft_scene_make(b, seed + 77, TRIANGLES), &t)};
    const soft_scene *x = &things[0].scene, *y = &things[1].scene;
    found truth[2] = {found_create(), found_create()};
    for (int verdict = 0; verdict < 2; verdict++) {
        found *f = &truth[verdict];
        double separation = 2 * t.half_thickness;
        all_vertices(f, x, y, SOFT_VERTEX_FACE, NULL, separation, verdict);
        size_t first = f->count;
        all_vertices(f, y, x, SOFT_FACE_VERTEX, NULL, separation, verdict);
        qsort(f->at + first, f->count - first, sizeof *f->at, compare_faces);
        all_edges(f, x, things[0].mesh, y, things[1].mesh, NULL, separation, verdict);
    }
    all_ways(things, 2, (soft_pair){0, 1}, &t, &truth[0], &truth[1], seed);
    size_t count = truth[0].count;
    free(truth[0].at), free(truth[1].at), unmake(&things[0]), unmake(&things[1]);
    return count;
}

static void self_contacts(void **state)
{
    (void)state;
    for (int c = 0; c < SOFT_CLASSES; c++) {
        size_t contacts = 0;
        for (uint64_t i = 0; i < frames(3); i++) contacts += with_itself((soft_class)c, i);
        printf("%s: %u frames, %zu contacts\n", soft_class_name((soft_class)c), frames(3), contacts);
        assert_true(contacts > 0);
    }
}

static void contacts_of_two(void **state)
{
    (void)state;
    size_t contacts = 0;
    for (uint64_t i = 0; i < frames(4); i++)
        contacts += with_each_other((soft_class)(i % SOFT_CLASSES), (soft_class)((i / 2 + 1) % SOFT_CLASSES), i);
    assert_true(contacts > 0);
}

/* ---- limits and bad input ---- */

static void left_out_is_counted(void **state)
{
    (void)state;
    terms t = {0};
    thing it = make(soft_scene_make(SOFT_CRUMPLED, 3, TRIANGLES), &t);
    soft_step *all = run(&it, 1, (soft_pair){0, 0}, SOFT_BRACKETS, 0, NULL, 0, 0);
    size_t count, kept;
    const soft_contact *c = soft_step_contacts(all, &count), *k;
    assert_true(count > 10);
    for (size_t most = 0; most <= count + 1; most += most < 3 ? 1 : count - 4) {
        soft_step *step = soft_step_create(NULL);
        soft_step_def def = {.bodies = &it.body,
            .body_count = 1,
            .pairs = &(soft_pair){0, 0},
            .pair_count = 1,
            .want = SOFT_BRACKETS,
            .contacts_max = most};
        assert_int_equal(soft_step_begin(step, &def), SOFT_OK);
        assert_int_equal(soft_step_run(step, 0), SOFT_OK);
        k = soft_step_contacts(step, &kept);
        assert_int_equal(kept, most < count ? most : count);
        assert_memory_equal(k, c, kept * sizeof *k);
        assert_int_equal(soft_step_tallies(step)->left_out, count - kept);
        float *times = calloc(it.scene.vertex_count, sizeof *times);
        if (!times) abort();
        soft_step_vertex_times(step, 0, times);
        for (size_t i = 0; kept < count && i < it.scene.vertex_count; i++) assert_true(times[i] == 0);
        free(times), soft_step_destroy(step);
    }
    soft_step_destroy(all), unmake(&it);
}

static void times_of_vertices(void **state)
{
    (void)state;
    terms t = {0};
    thing it = make(soft_scene_make(SOFT_CRUMPLED, 3, TRIANGLES), &t);
    soft_step *step = run(&it, 1, (soft_pair){0, 0}, SOFT_BRACKETS, 0, NULL, 0, 0);
    size_t count;
    const soft_contact *c = soft_step_contacts(step, &count);
    float *times = calloc(it.scene.vertex_count, sizeof *times), *want = calloc(it.scene.vertex_count, sizeof *want);
    if (!times || !want) abort();
    for (size_t i = 0; i < it.scene.vertex_count; i++) want[i] = 1;
    for (size_t i = 0; i < count; i++) {
        uint32_t v[4] = {c[i].a};
        if (c[i].kind == SOFT_EDGE_EDGE)
            soft_mesh_edge(it.mesh, c[i].a, v), soft_mesh_edge(it.mesh, c[i].b, v + 2);
        else
            soft_mesh_triangle(it.mesh, c[i].b, v + 1);
        for (int k = 0; k < 4; k++) want[v[k]] = fminf(want[v[k]], c[i].t_lo);
    }
    soft_step_vertex_times(step, 0, times);
    assert_true(count > 0);
    assert_memory_equal(times, want, it.scene.vertex_count * sizeof *times);
    free(times), free(want), soft_step_destroy(step), unmake(&it);
}

static void bad_input_is_refused(void **state)
{
    (void)state;
    soft_status status;
    vec3 at[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    uint32_t triangle[1][3] = {{0, 1, 2}}, beyond[1][3] = {{0, 1, 3}};
    soft_mesh_def good = {.rest = at, .vertex_count = 3, .triangles = triangle, .triangle_count = 1}, def = good;
    def.triangle_count = 0;
    assert_true(!soft_mesh_create(&def, &status) && status == SOFT_EMPTY);
    def = good, def.triangles = beyond;
    assert_true(!soft_mesh_create(&def, &status) && status == SOFT_OUT_OF_RANGE);
    def = good, def.half_thickness = NAN;
    assert_true(!soft_mesh_create(&def, &status) && status == SOFT_NO_NUMBER);
    def = good, def.ring = SOFT_RING_MAX + 1;
    assert_true(!soft_mesh_create(&def, &status) && status == SOFT_TOO_MANY);
    def = good, def.memory_max = 10;
    assert_true(!soft_mesh_create(&def, &status) && status == SOFT_OVER_MEMORY);
    soft_mesh *mesh = soft_mesh_create(&good, &status);
    soft_body *body = soft_body_create(mesh), *twice[2] = {body, body};
    assert_int_equal(soft_body_set(body, at, at), SOFT_OK);
    vec3 far[3] = {{0, 0, 0}, {2 * SOFT_FAR_M, 0, 0}, {0, 1, 0}}, none[3] = {{0, 0, 0}, {1, NAN, 0}, {0, 1, 0}};
    vec3 endless[3] = {{0, 0, 0}, {1, 0, -INFINITY}, {0, 1, 0}};
    assert_int_equal(soft_body_set(body, at, far), SOFT_NO_NUMBER);
    assert_int_equal(soft_body_set(body, none, at), SOFT_NO_NUMBER);
    assert_int_equal(soft_body_set(body, at, endless), SOFT_NO_NUMBER);
    soft_step *step = soft_step_create(NULL);
    soft_step_def two = {.bodies = twice, .body_count = 2, .pairs = &(soft_pair){0, 1}, .pair_count = 1};
    assert_int_equal(soft_step_begin(step, &two), SOFT_BODY_TWICE);
    two.body_count = 1;
    assert_int_equal(soft_step_begin(step, &two), SOFT_OUT_OF_RANGE);
    two.pairs = &(soft_pair){0, 0}, two.separation = -1;
    assert_int_equal(soft_step_begin(step, &two), SOFT_NO_NUMBER);
    assert_int_equal(soft_step_run(step, 0), SOFT_OK); /* of nothing */
    soft_step_destroy(step), soft_body_destroy(body), soft_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(self_contacts),
        cmocka_unit_test(contacts_of_two),
        cmocka_unit_test(left_out_is_counted),
        cmocka_unit_test(times_of_vertices),
        cmocka_unit_test(bad_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
