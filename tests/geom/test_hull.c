/* Properties of built hulls: structure (hull_validate, itself tried on damaged hulls), the input's own coordinates,
 * independence of the input's order and scale, and what is refused. */
#include "geom/hull.h"
#include "geom/shape.h"
#include "random_shapes.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static hull *build(const vec3 *points, size_t count)
{
    hull *h = NULL;
    assert_int_equal(hull_build(&points->x, count, 0, &h), HULL_OK);
    const char *fault = hull_validate(h);
    if (fault) fail_msg("%s", fault);
    return h;
}

/* No input point lies outside of any face by more than rounding. */
static void assert_contains_all(const hull *h, const vec3 *points, size_t count)
{
    for (uint32_t f = 0; f < h->face_count; f++)
        for (size_t i = 0; i < count; i++)
            assert_true(vec_dot(h->faces[f].normal, points[i]) <= h->faces[f].offset + 1e-13 * h->max_abs);
}

static size_t grid_points(vec3 *out, int side)
{
    size_t n = 0;
    for (int x = 0; x < side; x++)
        for (int y = 0; y < side; y++)
            for (int z = 0; z < side; z++) out[n++] = vec(x, y, z);
    return n;
}

static void a_grid_is_a_cube_of_six_quads(void **state)
{
    (void)state;
    vec3 points[343];
    size_t count = grid_points(points, 7);
    hull *h = build(points, count);
    assert_int_equal(h->vertex_count, 8);
    assert_int_equal(h->face_count, 6);
    assert_int_equal(h->edge_count, 12);
    for (uint32_t f = 0; f < 6; f++) assert_int_equal(h->faces[f].count, 4);
    assert_true(h->max_abs == 6);
    assert_contains_all(h, points, count);
    hull_destroy(h);
}

static void turned_grids_are_cubes_too(void **state)
{
    (void)state;
    uint64_t seed = 21;
    vec3 points[64];
    size_t count = grid_points(points, 4);
    for (int i = 0; i < 100; i++) {
        pose at = random_pose(&seed, i % 2 ? 0 : 1000);
        vec3 turned[64];
        for (size_t k = 0; k < count; k++) turned[k] = pose_point(at, points[k]);
        hull *h = build(turned, count);
        assert_contains_all(h, turned, count);
        if (i % 2) assert_int_equal(h->vertex_count, 8);
        hull_destroy(h);
    }
}

static void duplicates_and_inner_points_are_left_out(void **state)
{
    (void)state;
    const vec3 corners[] = {{0.25, 0.25, 0.25}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.1, 0.1}, {0, 0, 1}, {0, 0, 0}};
    vec3 points[60];
    for (int i = 0; i < 60; i++) points[i] = corners[i % 6];
    hull *h = build(points, 60);
    assert_int_equal(h->vertex_count, 4);
    const vec3 expected[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
    for (uint32_t i = 0; i < 4; i++) {
        vec3 v = hull_vertex(h, i);
        assert_memory_equal(&v, &expected[i], sizeof v);
    }
    hull_destroy(h);
}

static void points_on_a_sphere_obey_euler(void **state)
{
    (void)state;
    uint64_t seed = 22;
    vec3 points[1000];
    for (int i = 0; i < 1000; i++) points[i] = random_unit(&seed);
    hull *h = build(points, 1000);
    assert_int_equal(h->vertex_count, 1000);
    assert_int_equal(h->vertex_count + h->face_count, h->edge_count + 2);
    for (uint32_t i = 0; i < 1000; i++) {
        vec3 v = hull_vertex(h, i);
        assert_memory_equal(&v, &points[i], sizeof v);
    }
    assert_contains_all(h, points, 1000);
    hull_destroy(h);
}

static void shuffle(vec3 *points, size_t count, uint64_t *seed)
{
    for (size_t i = count - 1; i > 0; i--) {
        size_t j = prng_bits(seed) % (i + 1);
        vec3 swap = points[i];
        points[i] = points[j];
        points[j] = swap;
    }
}

static bool same_point(vec3 a, vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static uint32_t find_vertex(const hull *h, vec3 v)
{
    for (uint32_t i = 0; i < h->vertex_count; i++)
        if (same_point(v, hull_vertex(h, i))) return i;
    return UINT32_MAX;
}

static bool has_edge(const hull *h, uint32_t a, uint32_t b)
{
    for (uint32_t e = 0; e < h->edge_count; e++)
        if ((h->edges[e].v0 == a && h->edges[e].v1 == b) || (h->edges[e].v0 == b && h->edges[e].v1 == a)) return true;
    return false;
}

static void the_order_of_the_points_does_not_matter(void **state)
{
    (void)state;
    uint64_t seed = 23;
    for (int i = 0; i < 30; i++) {
        vec3 points[64];
        size_t count = 64;
        if (i % 2)
            grid_points(points, 4);
        else
            for (size_t k = 0; k < count; k++) points[k] = random_vec(&seed, 1);
        hull *a = build(points, count);
        shuffle(points, count, &seed);
        hull *b = build(points, count);
        assert_int_equal(a->vertex_count, b->vertex_count);
        assert_int_equal(a->face_count, b->face_count);
        assert_int_equal(a->edge_count, b->edge_count);
        for (uint32_t e = 0; e < a->edge_count; e++) {
            uint32_t v0 = find_vertex(b, hull_vertex(a, a->edges[e].v0)),
                     v1 = find_vertex(b, hull_vertex(a, a->edges[e].v1));
            assert_true(has_edge(b, v0, v1));
        }
        hull_destroy(a);
        hull_destroy(b);
    }
}

static void assert_same_structure(const hull *a, const hull *b)
{
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->face_count, b->face_count);
    assert_int_equal(a->edge_count, b->edge_count);
    assert_memory_equal(a->edges, b->edges, a->edge_count * sizeof *a->edges);
    assert_memory_equal(a->face_vertices, b->face_vertices, 2 * a->edge_count * sizeof *a->face_vertices);
    assert_memory_equal(a->neighbours, b->neighbours, 2 * a->edge_count * sizeof *a->neighbours);
    for (uint32_t f = 0; f < a->face_count; f++)
        assert_memory_equal(&a->faces[f].normal, &b->faces[f].normal, sizeof(vec3));
}

static void scaling_by_a_power_of_two_scales_and_nothing_else(void **state)
{
    (void)state;
    uint64_t seed = 24;
    for (int i = 0; i < 40; i++) {
        vec3 points[50], scaled[50];
        int exponent = (int)(prng_bits(&seed) % 980) - 490;
        for (int k = 0; k < 50; k++) {
            points[k] = random_vec(&seed, 1);
            scaled[k] = vec(ldexp(points[k].x, exponent), ldexp(points[k].y, exponent), ldexp(points[k].z, exponent));
        }
        hull *a = build(points, 50), *b = build(scaled, 50);
        assert_same_structure(a, b);
        assert_true(b->reach == ldexp(a->reach, exponent));
        for (uint32_t f = 0; f < a->face_count; f++)
            assert_true(b->faces[f].offset == ldexp(a->faces[f].offset, exponent));
        hull_destroy(a);
        hull_destroy(b);
    }
}

static void needles_and_plates_are_hulls(void **state)
{
    (void)state;
    uint64_t seed = 25;
    static const double thin[] = {1e-3, 1e-6, 1e-9, 1e-11};
    for (int i = 0; i < 160; i++) {
        vec3 box[8], points[40];
        double a = thin[i % 4], b = i % 2 ? a : 1;
        quat turn = i < 8 ? POSE_IDENTITY.q : random_rotation(&seed);
        for (int k = 0; k < 8; k++) box[k] = quat_rotate(turn, vec(k & 1 ? 1 : -1, k & 2 ? b : -b, k & 4 ? a : -a));
        for (int k = 0; k < 40; k++) {
            vec3 d = random_unit(&seed);
            points[k] = quat_rotate(turn, vec(d.x, d.y * b, d.z * a));
        }
        hull *flat_box = build(box, 8), *ellipsoid = build(points, 40);
        assert_int_equal(flat_box->vertex_count, 8);
        assert_contains_all(flat_box, box, 8);
        assert_contains_all(ellipsoid, points, 40);
        hull_destroy(flat_box);
        hull_destroy(ellipsoid);
    }
}

static void prisms_with_many_sides_keep_their_polygons(void **state)
{
    (void)state;
    vec3 points[400];
    for (int i = 0; i < 200; i++) {
        double angle = 2 * 3.14159265358979323846 * i / 200;
        points[2 * i] = vec(cos(angle), sin(angle), 0);
        points[2 * i + 1] = vec(cos(angle), sin(angle), 3);
    }
    hull *h = build(points, 400);
    assert_int_equal(h->vertex_count, 400);
    assert_int_equal(h->face_count, 202);
    assert_int_equal(h->edge_count, 600);
    hull_destroy(h);
}

static hull_status status_of(const vec3 *points, size_t count, unsigned flags)
{
    hull *h = (hull *)1;
    hull_status status = hull_build(&points->x, count, flags, &h);
    assert_true((status == HULL_OK) == (h != NULL));
    hull_destroy(h);
    return status;
}

static void flat_input_is_refused_at_any_scale(void **state)
{
    (void)state;
    uint64_t seed = 26;
    for (int i = 0; i < 200; i++) {
        vec3 points[30];
        pose at = random_pose(&seed, 1);
        double size = pow(10, (int)(prng_bits(&seed) % 240) - 120);
        int dimension = i % 3;
        for (int k = 0; k < 30; k++) {
            vec3 p = {prng_in(&seed, -1, 1), dimension > 1 ? prng_in(&seed, -1, 1) : 0, 0};
            points[k] = vec_scale(pose_point(at, dimension ? p : vec(1, 2, 3)), size);
        }
        assert_int_equal(status_of(points, 30, 0), HULL_FLAT);
        hull *h = NULL;
        assert_int_equal(hull_build(&points->x, 30, HULL_ALLOW_FLAT, &h), HULL_OK);
        assert_null(hull_validate(h));
        assert_int_equal(h->dimension, dimension);
        assert_int_equal(h->face_count, 0);
        assert_int_equal(h->vertex_count, dimension ? 30 : 1);
        hull_destroy(h);
    }
}

static void bad_input_is_refused(void **state)
{
    (void)state;
    vec3 points[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    assert_int_equal(status_of(points, 0, HULL_ALLOW_FLAT), HULL_EMPTY);
    assert_int_equal(status_of(points, 3, 0), HULL_FLAT);
    assert_int_equal(status_of(points, 1, 0), HULL_FLAT);
    assert_int_equal(status_of(points, 4, 0), HULL_OK);
    points[2].y = NAN;
    assert_int_equal(status_of(points, 4, 0), HULL_NOT_FINITE);
    points[2].y = -INFINITY;
    assert_int_equal(status_of(points, 4, 0), HULL_NOT_FINITE);
    points[2].y = 1.01 * SHAPE_SIZE_MAX;
    assert_int_equal(status_of(points, 4, 0), HULL_NOT_FINITE);
    vec3 *many = calloc(HULL_VERTICES_MAX + 1, sizeof *many);
    assert_int_equal(status_of(many, HULL_VERTICES_MAX + 1, 0), HULL_TOO_MANY);
    assert_int_equal(status_of(many, HULL_VERTICES_MAX, 0), HULL_FLAT);
    free(many);
    for (int s = HULL_OK; s <= HULL_FAILED; s++) assert_string_not_equal(hull_status_text((hull_status)s), "unknown");
}

static void the_limits_of_size_hold(void **state)
{
    (void)state;
    uint64_t seed = 27;
    static const double sizes[] = {1e-150, 1e150};
    for (int i = 0; i < 20; i++) {
        vec3 points[20];
        for (int k = 0; k < 20; k++) points[k] = random_vec(&seed, sizes[i % 2]);
        hull *h = build(points, 20);
        assert_true(isfinite(h->reach));
        hull_destroy(h);
    }
}

static void repeated_points_are_flat_and_say_so(void **state)
{
    (void)state;
    vec3 points[12];
    for (int k = 0; k < 12; k++) points[k] = k % 3 ? vec(1, 2, 3 + k % 3) : vec(1, 2, 3);
    assert_int_equal(status_of(points, 12, 0), HULL_FLAT);
    assert_string_not_equal(hull_status_text(HULL_FLAT), "");
    hull *h = NULL;
    assert_int_equal(hull_build(&points->x, 12, HULL_ALLOW_FLAT, &h), HULL_OK);
    assert_null(hull_validate(h));
    assert_int_equal(h->vertex_count, 3);
    assert_int_equal(h->dimension, 1);
    hull_destroy(h);
}

/* So small that squares lose bits (1e-160) or vanish, and subnormal. */
static void sizes_beyond_squares_are_sizes_like_any_other(void **state)
{
    (void)state;
    uint64_t seed = 31;
    static const double sizes[] = {1e-157, 1e-160, 1e-200, 1e-300, 1e-307, 1e-320, 1e140, 9e149};
    for (int i = 0; i < 160; i++) {
        vec3 points[20];
        for (int k = 0; k < 20; k++) points[k] = random_vec(&seed, sizes[i % 8]);
        hull *h = NULL;
        assert_int_equal(hull_build(&points->x, 20, 0, &h), HULL_OK);
        const char *fault = hull_validate(h);
        if (fault) fail_msg("size %g: %s", sizes[i % 8], fault);
        assert_true(isfinite(h->reach));
        hull_destroy(h);
    }
    const double quantum = 0x1p-1074;
    const vec3 least[] = {{0, 0, 0}, {quantum, 0, 0}, {0, quantum, 0}, {0, 0, quantum}};
    hull *h = build(least, 4);
    assert_int_equal(h->face_count, 4);
    h->faces[1].normal = vec_neg(h->faces[1].normal);
    assert_non_null(hull_validate(h));
    hull_destroy(h);
}

/* As many points as there may be, on a ball, so that nearly all are corners; one more is refused above. */
static void the_largest_hull_is_sound(void **state)
{
    (void)state;
    uint64_t seed = 32;
    vec3 *points = calloc(HULL_VERTICES_MAX, sizeof *points);
    assert_non_null(points);
    for (int k = 0; k < HULL_VERTICES_MAX; k++) {
        vec3 v = random_vec(&seed, 1);
        points[k] = vec_norm(v) > 0.01 ? vec_unit(v) : vec(1, 0, 0);
    }
    hull *h = NULL;
    assert_int_equal(hull_build(&points->x, HULL_VERTICES_MAX, 0, &h), HULL_OK);
    assert_true(h->vertex_count > HULL_VERTICES_MAX / 2);
    assert_true(h->vertex_count + h->face_count == h->edge_count + 2);
    for (uint32_t f = 0; f < h->face_count; f += 997)
        for (int k = 0; k < HULL_VERTICES_MAX; k++)
            assert_true(vec_dot(h->faces[f].normal, points[k]) <= h->faces[f].offset + h->excess + 1e-15);
    hull_destroy(h);
    free(points);
}

/* Messy input: many nearly coplanar points, as float meshes of boxes and cylinders have. */
static void float_meshes_are_hulls(void **state)
{
    (void)state;
    uint64_t seed = 28;
    for (int i = 0; i < 150; i++) {
        vec3 points[300];
        pose at = random_pose(&seed, 0.3);
        double noise = pow(10, -(double)(prng_bits(&seed) % 18));
        for (int k = 0; k < 300; k++) {
            int layer = k / 100;
            double x = (float)(k % 10) / 9.0F, y = (float)(k / 10 % 10) / 9.0F, z = layer / 2.0;
            vec3 p = pose_point(at, vec(x, y, z));
            if (i % 2) p = vec((float)p.x, (float)p.y, (float)p.z);
            points[k] = vec_madd(p, noise, random_vec(&seed, 0.01));
        }
        hull *h = build(points, 300);
        for (uint32_t f = 0; f < h->face_count; f++)
            for (int k = 0; k < 300; k++)
                assert_true(vec_dot(h->faces[f].normal, points[k]) <= h->faces[f].offset + h->excess + 1e-15);
        assert_true(h->excess <= 2 * HULL_PLANE_RATIO);
        for (uint32_t k = 0; k < h->vertex_count; k++) {
            bool found = false;
            for (int p = 0; p < 300 && !found; p++) found = same_point(points[p], hull_vertex(h, k));
            assert_true(found);
        }
        hull_destroy(h);
    }
}

/* A grid that is coplanar to 1e-9 or 1e-10 loses points, and says how far out they are; a clean one loses none. */
static void excess_is_what_noise_leaves_outside(void **state)
{
    (void)state;
    static const double noises[] = {0, 1e-9, 1e-10};
    for (int n = 0; n < 3; n++)
        for (uint64_t seed = 1; seed <= 40; seed++) {
            uint64_t random = seed;
            vec3 points[200];
            for (int k = 0; k < 200; k++) {
                vec3 grid = vec((double)(k % 10) / 8, (double)(k / 10 % 10) / 8, (double)(k / 100));
                points[k] = vec_madd(grid, noises[n], random_vec(&random, 1));
            }
            hull *h = build(points, 200);
            if (n == 0) assert_true(h->excess == 0);
            for (int d = 0; d < 50; d++) {
                vec3 n_d = vec_unit(random_vec(&random, 1));
                if (d < 6) n_d = d % 2 ? vec(0, 0, 1) : vec(0, 0, -1);
                double kept = -INFINITY, given = -INFINITY;
                for (uint32_t k = 0; k < h->vertex_count; k++) kept = fmax(kept, vec_dot(n_d, hull_vertex(h, k)));
                for (int k = 0; k < 200; k++) given = fmax(given, vec_dot(n_d, points[k]));
                assert_true(given <= kept + h->excess + 1e-15);
            }
            hull_destroy(h);
        }
}

static void *build_ten(void *seed)
{
    uint64_t own = *(uint64_t *)seed, sum = 0;
    for (int i = 0; i < 10; i++) {
        hull *h = random_hull(&own, 100, 1, i % 2);
        for (uint32_t e = 0; h && e < h->edge_count; e++) sum = sum * 31 + h->edges[e].v1;
        hull_destroy(h);
    }
    *(uint64_t *)seed = sum;
    return NULL;
}

static void threads_build_hulls_at_once(void **state)
{
    (void)state;
    uint64_t sums[4] = {1, 2, 1, 2};
    pthread_t threads[4];
    for (int i = 0; i < 4; i++) assert_int_equal(pthread_create(&threads[i], NULL, build_ten, &sums[i]), 0);
    for (int i = 0; i < 4; i++) pthread_join(threads[i], NULL);
    assert_true(sums[0] == sums[2] && sums[1] == sums[3] && sums[0] != sums[1]);
}

/* Each kind of damage is named: a validator that passes everything would make the tests above worthless. */
static void the_validator_finds_damage(void **state)
{
    (void)state;
    vec3 points[27];
    grid_points(points, 3);
    for (int damage = 0; damage < 12; damage++) {
        hull *h = build(points, 27);
        switch (damage) {
        case 0:
            h->x[3] = NAN;
            break;
        case 1:
            h->reach *= 0.99;
            break;
        case 2:
            h->max_abs *= 2;
            break;
        case 3:
            h->faces[2].offset += 0.01;
            break;
        case 4:
            h->faces[1].normal = vec_neg(h->faces[1].normal);
            break;
        case 5:
            h->faces[0].normal = vec_scale(h->faces[0].normal, 1.01);
            break;
        case 6:
            h->face_vertices[5] = h->face_vertices[6];
            break;
        case 7:
            h->face_vertices[0] = 8;
            break;
        case 8:
            h->edges[4].f0 = h->edges[4].f1;
            break;
        case 9:
            h->edges[0].v1 = h->edges[1].v1;
            break;
        case 10:
            h->neighbours[0] = h->neighbours[1];
            break;
        case 11:
            h->edge_count--;
            break;
        }
        assert_non_null(hull_validate(h));
        hull_destroy(h);
    }
}

/* Points that lie on few planes or lines, or on curved surfaces; `noise`: share of the size by which they are off. */
static vec3 hostile_point(int kind, size_t i, size_t n, double noise, uint64_t *seed)
{
    double f = 2 * M_PI * (double)i / (double)n, x = prng_in(seed, -1, 1), y = prng_in(seed, -1, 1);
    double side = i & 1 ? 1 : -1, z = 1 - 2 * ((double)i + 0.5) / (double)n, off = 1 + noise * x;
    switch (kind) {
    case 0: /* two rings, the corners of one between those of the other */
        return vec(cos(f), sin(f), side * off);
    case 1: /* two rings that are filled */
        return i < n / 2 ? vec(cos(2 * f), sin(2 * f), side) : vec(0.7 * x, 0.7 * y, side * off);
    case 2: /* a cone */
        return i == 0 ? vec(0, 0, 1) : vec(off * cos(f), off * sin(f), 0);
    case 3: /* rows of a cylinder: most are on its edges */
        return vec(cos(f * 8), sin(f * 8), off * floor(8 * (double)i / (double)n));
    case 4: /* a box's sides and edges */
        return vec(side, off * floor(4 * x), floor(4 * y));
    default: /* a ball */
        return vec(sqrt(1 - z * z) * cos(2.399963 * (double)i), sqrt(1 - z * z) * sin(2.399963 * (double)i), z);
    }
}

enum { KINDS = 6, MERGED_BY_QHULL = 2000 };

/* More points than qhull is asked to merge give the same kind of polytope: sound, around all points, whatever their
 * order. Below that number, at it and beyond it, all even: see kind 0. */
static void many_points_are_hulls_like_few(void **state)
{
    (void)state;
    static const size_t COUNTS[] = {MERGED_BY_QHULL - 2, MERGED_BY_QHULL, MERGED_BY_QHULL + 2, 3 * MERGED_BY_QHULL / 2};
    static const double NOISES[] = {0, 1e-15};
    vec3 *points = malloc(2 * MERGED_BY_QHULL * sizeof *points);
    for (int kind = 0; kind < KINDS; kind++)
        for (int c = 0; c < 4; c++)
            for (int k = 0; k < 2; k++) {
                uint64_t seed = 5;
                for (size_t i = 0; i < COUNTS[c]; i++) points[i] = hostile_point(kind, i, COUNTS[c], NOISES[k], &seed);
                hull *h = build(points, COUNTS[c]);
                double outside = h->excess + 1e-13 * h->max_abs;
                for (uint32_t f = 0; f < h->face_count; f++)
                    for (size_t i = 0; i < COUNTS[c]; i++)
                        assert_true(vec_dot(h->faces[f].normal, points[i]) <= h->faces[f].offset + outside);
                assert_true(h->excess <= HULL_PLANE_RATIO * h->max_abs);
                if (kind == 0 && k == 0) assert_int_equal(h->face_count, COUNTS[c] + 2);
                if (kind == 2 && k == 0) assert_int_equal(h->face_count, COUNTS[c]);
                if (kind == 4 && k == 0) assert_int_equal(h->face_count, 6);
                uint32_t vertices = h->vertex_count, faces = h->face_count;
                hull_destroy(h);
                for (size_t i = 0; i < COUNTS[c] / 2; i++) {
                    vec3 swap = points[i];
                    points[i] = points[COUNTS[c] - 1 - i];
                    points[COUNTS[c] - 1 - i] = swap;
                }
                h = build(points, COUNTS[c]);
                assert_int_equal(h->vertex_count, vertices);
                assert_int_equal(h->face_count, faces);
                hull_destroy(h);
            }
    free(points);
}

/* With qhull's merging 65,534 of them would take minutes, and more than the time of a test. */
/* At random angles some of them are next to each other, and the faces between narrower than anything can tell. */
static void rings_of_points_that_crowd_together_are_hulls(void **state)
{
    (void)state;
    static double points[3 * 10000];
    uint64_t x = UINT64_C(88172645463325252);
    for (size_t i = 0; i < 10000; i++) {
        x ^= x << 13, x ^= x >> 7, x ^= x << 17;
        double angle = 0x1p-53 * (double)(x >> 11) * 6.283185307179586;
        points[3 * i] = cos(angle), points[3 * i + 1] = sin(angle), points[3 * i + 2] = (double)(i % 2);
    }
    hull *h;
    assert_int_equal(hull_build(points, 10000, 0, &h), HULL_OK);
    assert_null(hull_validate(h));
    assert_true(h->excess <= 2.1e-6);
    for (int k = 0; k < 40; k++) {
        double angle = 0.157 * k, all = -INFINITY, own = -INFINITY;
        vec3 u = vec_unit(vec(cos(angle), sin(angle), 0.1 * (k % 7 - 3)));
        for (size_t i = 0; i < 10000; i++)
            all = fmax(all, vec_dot(u, vec(points[3 * i], points[3 * i + 1], points[3 * i + 2])));
        for (uint32_t i = 0; i < h->vertex_count; i++) own = fmax(own, vec_dot(u, hull_vertex(h, i)));
        assert_true(all <= own + h->excess + 1e-15);
    }
    hull_destroy(h);
}

static void two_rings_of_the_most_points_are_a_hull(void **state)
{
    (void)state;
    const size_t count = HULL_VERTICES_MAX - 1;
    uint64_t seed = 5;
    hull *h = NULL;
    vec3 *points = malloc(count * sizeof *points);
    for (size_t i = 0; i < count; i++) points[i] = hostile_point(0, i, count, 0, &seed);
    assert_int_equal(hull_build(&points->x, count, 0, &h), HULL_OK);
    assert_int_equal(h->vertex_count, count);
    assert_int_equal(h->face_count, count + 2);
    hull_destroy(h);
    free(points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_grid_is_a_cube_of_six_quads),
        cmocka_unit_test(turned_grids_are_cubes_too),
        cmocka_unit_test(duplicates_and_inner_points_are_left_out),
        cmocka_unit_test(points_on_a_sphere_obey_euler),
        cmocka_unit_test(the_order_of_the_points_does_not_matter),
        cmocka_unit_test(scaling_by_a_power_of_two_scales_and_nothing_else),
        cmocka_unit_test(needles_and_plates_are_hulls),
        cmocka_unit_test(prisms_with_many_sides_keep_their_polygons),
        cmocka_unit_test(flat_input_is_refused_at_any_scale),
        cmocka_unit_test(bad_input_is_refused),
        cmocka_unit_test(the_limits_of_size_hold),
        cmocka_unit_test(repeated_points_are_flat_and_say_so),
        cmocka_unit_test(sizes_beyond_squares_are_sizes_like_any_other),
        cmocka_unit_test(the_largest_hull_is_sound),
        cmocka_unit_test(many_points_are_hulls_like_few),
        cmocka_unit_test(rings_of_points_that_crowd_together_are_hulls),
        cmocka_unit_test(two_rings_of_the_most_points_are_a_hull),
        cmocka_unit_test(float_meshes_are_hulls),
        cmocka_unit_test(excess_is_what_noise_leaves_outside),
        cmocka_unit_test(threads_build_hulls_at_once),
        cmocka_unit_test(the_validator_finds_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
