/* How far a hull reaches beyond a concave solid: the bound holds at drawn points, and is close where the solid is
 * nearly convex; links that are concave come in pieces, or keep their mesh. */
#include "fit_fixture.h"
#include "loaders/decompose/solid_make.h"

#include "loaders/decompose/overhang.h"
#include "loaders/fit/fit_excess.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RINGS = 12, SECTORS = 24 };

typedef struct model { /* a surface of rings about z, closed at both ends */
    pool pool;
    double points[3 * (RINGS * SECTORS + 2)];
    int32_t corners[3 * 2 * RINGS * SECTORS];
    mesh_triangles mesh;
} model;

typedef double profile(double t); /* radius at t from 0 to 1 */

static void make(model *m, profile *radius, double height)
{
    int ends[2] = {RINGS * SECTORS, RINGS * SECTORS + 1}, n = 0;
    for (int i = 0; i < RINGS * SECTORS; i++) {
        double t = (double)(i / SECTORS) / (RINGS - 1), angle = 2 * acos(-1) * (i % SECTORS) / SECTORS;
        m->points[3 * i] = radius(t) * cos(angle), m->points[3 * i + 1] = radius(t) * sin(angle);
        m->points[3 * i + 2] = height * t;
    }
    for (int e = 0; e < 2; e++) {
        m->points[3 * ends[e]] = m->points[3 * ends[e] + 1] = 0;
        m->points[3 * ends[e] + 2] = e ? height : 0;
    }
    for (int s = 0; s < SECTORS; s++) {
        int next = (s + 1) % SECTORS, top = (RINGS - 1) * SECTORS;
        const int caps[6] = {ends[0], next, s, ends[1], top + s, top + next};
        for (int k = 0; k < 6; k++) m->corners[n++] = caps[k];
        for (int ring = 0; ring + 1 < RINGS; ring++) {
            int a = ring * SECTORS + s, b = ring * SECTORS + next;
            const int side[6] = {a, b, b + SECTORS, a, b + SECTORS, a + SECTORS};
            for (int k = 0; k < 6; k++) m->corners[n++] = side[k];
        }
    }
    m->mesh = (mesh_triangles){m->points, RINGS * SECTORS + 2, m->corners, (size_t)n / 3};
}

static double drum(double t)
{
    return 0.2 + 0.1 * sin(acos(-1) * t); /* convex */
}

static double dented(double t)
{
    return 0.2 - 0.004 * sin(acos(-1) * t); /* nearly: the hull is up to 4 mm beyond it */
}

static double waist(double t)
{
    return 0.2 - 0.15 * sin(acos(-1) * t);
}

static double bound_of(model *m, bool by_normals)
{
    pool p = {0};
    solid s;
    fit_hull h;
    solid_make(&p, &m->mesh, &s);
    assert_true(s.closed && fit_hull_make(&p, m->points, m->mesh.point_count, &h));
    double bound = by_normals ? overhang_bound(s.overhang, &s, h.planes, h.plane_count, 1e-6, INFINITY, OVERHANG_WORK)
                              : fit_excess_of_hull(&s, &h, 0.01);
    pool_free(&p);
    return bound;
}

/* The farthest of drawn points of the hull. */
static double farthest_of(const model *m, size_t count)
{
    const load_shape both[2] = {
        {.shape = {.type = COLLIDED_HULL, .pose = {{0}, {1, 0, 0, 0}}}, .points = {m->points, m->mesh.point_count}},
        {.shape = {.type = COLLIDED_MESH, .pose = {{0}, {1, 0, 0, 0}}}, .triangles = m->mesh}};
    solid_set hull, truth;
    prng r = {7};
    double most = 0;
    vec3 last = VEC_ZERO;
    set_make(&hull, &both[0], 1);
    set_make(&truth, &both[1], 1);
    for (size_t n = 0; n < count; n++) {
        vec3 x = set_surface_point(&hull, 0, &r);
        if (n % 2) x = vec_add(x, vec_scale(vec_sub(last, x), drawn(&r, 0, 1)));
        last = x;
        most = fmax(most, set_away_at_least(&truth, x));
    }
    set_free(&hull);
    set_free(&truth);
    return most;
}

static void the_bound_holds_and_is_close(void **state)
{
    (void)state;
    static profile *const profiles[] = {drum, dented, waist};
    for (int i = 0; i < 3; i++)
        for (int by_normals = 0; by_normals < 2; by_normals++) {
            model m = {0};
            make(&m, profiles[i], 0.5);
            double bound = bound_of(&m, by_normals), occurs = farthest_of(&m, fit_count(40000));
            if (!(bound >= occurs - 1e-9)) fail_msg("profile %d: %.9g occurs, the bound is %.9g", i, occurs, bound);
            if (i == 0) assert_true(bound < 1e-5);
            if (i == 1 && by_normals) assert_true(occurs > 0.0035 && bound < 1.1 * 0.004);
            if (i == 2) assert_true(occurs > 0.1);
        }
}

/* Saddles, pits and spikes all over: the bound need not be close, but it holds. */
static void the_bound_holds_on_random_surfaces(void **state)
{
    (void)state;
    static const double bumps[] = {0.001, 0.01, 0.05, 0.2};
    int bounded = 0;
    for (int n = 0; n < 24; n++) {
        model m = {0};
        prng r = {100 + (uint64_t)n};
        make(&m, n % 3 ? drum : waist, 0.5);
        for (int i = 0; i < RINGS * SECTORS; i++) {
            double scale = 1 + drawn(&r, -1, 1) * bumps[n % 4];
            m.points[3 * i] *= scale, m.points[3 * i + 1] *= scale;
        }
        for (int by_normals = 0; by_normals < 2; by_normals++) {
            double bound = bound_of(&m, by_normals), occurs = farthest_of(&m, fit_count(40000));
            if (!(bound >= occurs - 1e-9)) fail_msg("surface %d: %.9g occurs, the bound is %.9g", n, occurs, bound);
            bounded += bound < 0.1;
        }
    }
    assert_true(bounded > 12);
}

/* A floor that cannot be reached makes it split whatever can be: its work ends all the same, and what it had holds. */
static void the_bound_holds_when_its_work_ends(void **state)
{
    (void)state;
    pool p = {0};
    model m = {0};
    solid s;
    fit_hull h;
    make(&m, dented, 0.5);
    double occurs = farthest_of(&m, fit_count(40000)), before = INFINITY;
    solid_make(&p, &m.mesh, &s);
    assert_true(fit_hull_make(&p, m.points, m.mesh.point_count, &h));
    static const size_t work[] = {0, 10000, 1000000, OVERHANG_WORK};
    for (int i = 0; i < 4; i++) {
        double bound = overhang_bound(s.overhang, &s, h.planes, h.plane_count, 0, INFINITY, work[i]);
        assert_true(bound >= occurs - 1e-9 && bound <= before);
        assert_true(i != 3 || bound < 1.1 * 0.004);
        assert_true(i != 0 || bound > 1.1 * 0.004); /* there was something to do */
        before = bound;
    }
    pool_free(&p);
}

static void open_surfaces_have_none(void **state)
{
    (void)state;
    pool p = {0};
    model m = {0};
    solid s;
    fit_hull h;
    make(&m, drum, 0.5);
    m.mesh.count--;
    solid_make(&p, &m.mesh, &s);
    assert_false(s.closed);
    assert_true(fit_hull_make(&p, m.points, m.mesh.point_count, &h));
    assert_null(s.overhang);
    assert_true(isinf(overhang_bound(s.overhang, &s, h.planes, h.plane_count, 1e-6, INFINITY, OVERHANG_WORK)));
    assert_true(fit_excess_of_hull(&s, &h, 0.01) > 0.15); /* what is inside of it counts as outside */
    pool_free(&p);
}

static void fit_model(model *m, pool *p, double excess, fit_link *out)
{
    load_shape *s = pool_alloc(p, 1, sizeof *s);
    load_body *body = pool_alloc(p, 1, sizeof *body);
    *s = (load_shape){.shape = {.type = COLLIDED_MESH, .pose = {{1, 2, 3}, {0.5, 0.5, 0.5, 0.5}}},
        .mesh = "made here",
        .scale = {1, 1, 1},
        .triangles = m->mesh};
    *body = (load_body){.name = "model", .shapes = s, .shape_count = 1};
    fit_link_make(p, body, excess, out);
    solid_set now, truth;
    prng r = {9};
    set_make(&now, out->shapes, out->shape_count);
    set_make(&truth, out->before, 1);
    for (size_t n = 0; n < fit_count(20000); n++) {
        double away = set_away(&truth, set_surface_point(&now, n % now.count, &r));
        if (!(away <= out->excess_m + 1e-9)) fail_msg("%.9g, not %.9g", away, out->excess_m);
        assert_true(set_away_at_least(&now, set_surface_point(&truth, 0, &r)) < 1e-9);
    }
    set_free(&now);
    set_free(&truth);
}

static void concave_links_come_in_pieces_or_stay(void **state)
{
    (void)state;
    pool p = {0};
    fit_link l;
    model m = {0}, open = {0};
    make(&m, dented, 0.5);
    fit_model(&m, &p, 0.005, &l);
    assert_int_equal(l.how, FIT_ONE);
    make(&m, waist, 0.5);
    fit_model(&m, &p, 0.05, &l);
    assert_int_equal(l.how, FIT_PIECES);
    assert_true(l.shape_count > 1 && l.excess_m <= 0.05 && l.ns < l.ns_before);
    make(&open, waist, 0.5);
    open.mesh.count--;
    fit_model(&open, &p, 0.01, &l);
    assert_int_equal(l.how, FIT_MESH);
    assert_true(l.note && l.shapes[0].shape.type == COLLIDED_MESH && l.excess_m == 0);
    pool_free(&p);
}

/* Two boxes that make an L, 1 m wide and tall, 0.2 m thick, with triangles around. */
static mesh_triangles angle_iron(pool *p)
{
    static const double outline[6][2] = {{0, 0}, {1, 0}, {1, 0.2}, {0.2, 0.2}, {0.2, 1}, {0, 1}};
    static const int32_t caps[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
    double *points = pool_alloc(p, 12, 3 * sizeof *points);
    int32_t *corners = pool_alloc(p, 20, 3 * sizeof *corners), *to = corners;
    for (int i = 0; i < 12; i++) memcpy(points + 3 * i, outline[i % 6], sizeof outline[0]), points[3 * i + 2] = i / 6;
    for (int i = 0; i < 4; i++) {
        const int32_t pair[6] = {caps[i][0], caps[i][2], caps[i][1], caps[i][0] + 6, caps[i][1] + 6, caps[i][2] + 6};
        memcpy(to, pair, sizeof pair), to += 6;
    }
    for (int i = 0; i < 6; i++) {
        int next = (i + 1) % 6;
        const int32_t side[6] = {i, next, next + 6, i, next + 6, i + 6};
        memcpy(to, side, sizeof side), to += 6;
    }
    return (mesh_triangles){points, 12, corners, 20};
}

/* As many meshes as give more pieces than a body may have shapes; too far apart for one shape around all. */
static void too_many_pieces_are_told(void **state)
{
    (void)state;
    enum { MANY = 130 };
    pool p = {0};
    fit_link one, l;
    mesh_triangles iron = angle_iron(&p);
    load_shape *s = pool_alloc(&p, MANY, sizeof *s);
    for (int i = 0; i < MANY; i++)
        s[i] = (load_shape){.shape = {.type = COLLIDED_MESH, .pose = {{i, 0, 0}, {1, 0, 0, 0}}},
            .mesh = "made here",
            .scale = {1, 1, 1},
            .triangles = iron};
    fit_link_make(&p, &(load_body){.name = "model", .shapes = s, .shape_count = 1}, 0.01, &one);
    assert_true(one.shape_count * MANY > LOAD_SHAPES_MAX);
    fit_link_make(&p, &(load_body){.name = "model", .shapes = s, .shape_count = MANY}, 0.01, &l);
    assert_int_equal(l.how, FIT_AS_IT_WAS);
    assert_int_equal(l.shape_count, MANY);
    char words[64];
    snprintf(words, sizeof words, "its pieces would be %zu shapes", one.shape_count * MANY);
    assert_non_null(l.note);
    assert_non_null(strstr(l.note, words));
    pool_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bound_holds_and_is_close),
        cmocka_unit_test(the_bound_holds_on_random_surfaces),
        cmocka_unit_test(the_bound_holds_when_its_work_ends),
        cmocka_unit_test(open_surfaces_have_none),
        cmocka_unit_test(concave_links_come_in_pieces_or_stay),
        cmocka_unit_test(too_many_pieces_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
