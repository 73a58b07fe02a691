/* Pairs of triangles, leaves of four, and a box beside four triangles: what is told to be far is, by 113 bits, however
 * thin, small or near the triangles are; what is proven stands along the direction that is told; most of what is far is
 * told to be. */
#include "brute.h"
#include "narrow/tree/mesh_row.h"
#include "narrow/tree/mesh_walk.h"
#include "solids.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A fifth of them in CI, all with COLLIDED_NIGHTLY=1 in the environment, few with COLLIDED_BRIEF=1. */
static int rounds(void)
{
    const int nightly = 10000;
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / (getenv("COLLIDED_BRIEF") ? 50 : 5);
}

/* Of doubles of about unit size: bounds may be off by so much. */
#define ROUNDING 1e-14

static const pose HERE = {.q = {1, 0, 0, 0}};

typedef struct counts {
    int far, rejected, kept;
} counts;

/* Some are slivers, some have no area, some are points. */
static void random_triangle(dice *d, vec3 p[3])
{
    double size = pow(10, dice_between(d, -3, 0));
    vec3 at = dice_vec(d, -1, 1);
    for (int k = 0; k < 3; k++) p[k] = vec_add(at, vec_scale(dice_vec(d, -1, 1), size));
    double kind = dice_between(d, 0, 1);
    if (kind < 0.05) p[2] = vec_madd(p[0], dice_between(d, 0, 1), vec_sub(p[1], p[0]));
    if (kind < 0.02) p[2] = p[1];
    if (kind < 0.01) p[1] = p[2] = p[0];
}

static mesh_spot spot_of(const vec3 p[3])
{
    mesh_spot s = {.lo = vec_min(vec_min(p[0], p[1]), p[2]), .hi = vec_max(vec_max(p[0], p[1]), p[2])};
    memcpy(s.corner, p, sizeof s.corner);
    s.normal = vec_cross(vec_sub(p[1], p[0]), vec_sub(p[2], p[0]));
    return s;
}

static soup soup_of(const vec3 p[3], double points[9], int32_t corners[3])
{
    for (int k = 0; k < 3; k++) {
        points[3 * k] = p[k].x, points[3 * k + 1] = p[k].y, points[3 * k + 2] = p[k].z;
        corners[k] = k;
    }
    return (soup){.points = points, .point_count = 3, .corners = corners, .triangle_count = 1};
}

static double distance_from(const soup *a, const vec3 p[3])
{
    double points[9];
    int32_t corners[3];
    soup b = soup_of(p, points, corners);
    return (double)brute_distance(a, &b, &HERE);
}

/* How far a point is from a triangle, which may be a point itself. */
static double away_from(vec3 point, const vec3 p[3])
{
    double points[9];
    int32_t corners[3];
    soup of_p = soup_of(p, points, corners);
    return fmin((double)brute_point_distance(&of_p, point), vec_norm(vec_sub(point, p[0])));
}

/* They are as far apart as was told along the lead, or by the boxes around them. */
static void hold_lead(const vec3 *a, int count_a, const vec3 b[3], const mesh_row *row, int i)
{
    vec3 u = vec_unit(vec(row->lead[0][i], row->lead[1][i], row->lead[2][i]));
    double top = -INFINITY, foot = INFINITY;
    for (int k = 0; k < count_a; k++) top = fmax(top, vec_dot(u, a[k]));
    for (int k = 0; k < 3; k++) foot = fmin(foot, vec_dot(u, b[k]));
    double along = foot - top, told = sqrt(row->away2[i]);
    vec3 lo = a[0], hi = a[0], b_lo = vec_min(vec_min(b[0], b[1]), b[2]), b_hi = vec_max(vec_max(b[0], b[1]), b[2]);
    for (int k = 1; k < count_a; k++) lo = vec_min(lo, a[k]), hi = vec_max(hi, a[k]);
    vec3 gap = vec_max(vec_max(vec_sub(b_lo, hi), vec_sub(lo, b_hi)), VEC_ZERO);
    assert_true(told <= fmax(fmax(along, 0), vec_norm(gap)) + ROUNDING);
}

static void hold_row(const soup *a, const vec3 *points_a, int count_a, vec3 b[4][3], double within, unsigned near,
    const mesh_row *row, counts *c)
{
    for (int i = 0; i < 4; i++) {
        double truth = distance_from(a, b[i]);
        bool kept = near >> i & 1;
        if (!kept) assert_true(truth > within - ROUNDING);
        if (kept) hold_lead(points_a, count_a, b[i], row, i);
        c->kept += kept;
        c->far += truth > 1.01 * within;
        c->rejected += truth > 1.01 * within && !kept;
    }
}

static double random_within(dice *d)
{
    return dice_between(d, 0, 1) < 0.2 ? 0 : pow(10, dice_between(d, -3, 0.2));
}

static const transform IDENTITY = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};

/* One of A's beside four of B's. */
static void triangles_that_are_left_out_are_far(void **state)
{
    (void)state;
    dice d = {21};
    counts c = {0};
    for (int n = 0; n < rounds(); n++) {
        vec3 a[3], b[4][3];
        mesh_four four_a, four;
        mesh_row row;
        double points[9], within = random_within(&d);
        int32_t corners[3];
        random_triangle(&d, a);
        for (int i = 0; i < 4; i++) random_triangle(&d, b[i]);
        if (n % 7 == 0) b[1][0] = a[0]; /* they touch */
        mesh_four_set(&four_a, a, 1, 1, NULL);
        mesh_four_set(&four, b[0], 4, 1, &IDENTITY);
        const mesh_picks all = {.a = 0x03020100, .b = 0x03020100, .count = 4};
        soup of_a = soup_of(a, points, corners);
        hold_row(&of_a, a, 3, b, within, mesh_row_near(&four_a, &four, &all, within * within, &row), &row, &c);
    }
    assert_true(c.kept > rounds() / 4 && c.far > rounds());
    assert_true(c.rejected > c.far - c.far / 100); /* that is what it is for */
}

/* What is told of a pair is a matter of its two triangles alone: of the lane, of those beside it and of what is asked
 * nothing depends. The points on edges are points of the triangles. */
static void a_pair_is_told_the_same_in_any_company(void **state)
{
    (void)state;
    dice d = {24};
    for (int n = 0; n < rounds(); n++) {
        vec3 a[4][3], b[4][3];
        mesh_four four_a, four_b;
        mesh_row row, alone;
        for (int i = 0; i < 4; i++) random_triangle(&d, a[i]), random_triangle(&d, b[i]);
        mesh_four_set(&four_a, a[0], 4, 1, NULL);
        mesh_four_set(&four_b, b[0], 4, 1, &IDENTITY);
        mesh_picks picks = {.a = (uint32_t)n * 0x9e3779b1 & 0x03030303, .b = (uint32_t)n * 0x85ebca6b & 0x03030303};
        picks.count = 1 + (uint32_t)n % 4;
        double within = n % 3 ? random_within(&d) : INFINITY;
        unsigned near = mesh_row_near(&four_a, &four_b, &picks, within * within, &row);
        assert_int_equal(near >> picks.count, 0);
        for (uint32_t i = 0; near >> i; i++) {
            mesh_picks one = {mesh_pick(picks.a, i), mesh_pick(picks.b, i), 1};
            if (!(near >> i & 1)) continue;
            assert_int_equal(mesh_row_near(&four_a, &four_b, &one, INFINITY, &alone), 1);
            assert_memory_equal(&row.away2[i], &alone.away2[0], sizeof(double));
            for (int k = 0; k < 3; k++) {
                assert_memory_equal(&row.lead[k][i], &alone.lead[k][0], sizeof(double));
                assert_memory_equal(&row.from[k][i], &alone.from[k][0], sizeof(double));
                assert_memory_equal(&row.edges[k][i], &alone.edges[k][0], sizeof(double));
            }
            vec3 from = {row.from[0][i], row.from[1][i], row.from[2][i]}, to;
            to = vec_add(from, vec(row.edges[0][i], row.edges[1][i], row.edges[2][i]));
            assert_true(away_from(from, a[one.a]) < ROUNDING && away_from(to, b[one.b]) < ROUNDING);
        }
    }
}

static void soup_distances(const vec3 a[4][3], const vec3 b[4][3], double out[16])
{
    for (int i = 0; i < 4; i++) {
        double points[9];
        int32_t corners[3];
        soup of_a = soup_of(a[i], points, corners);
        for (int k = 0; k < 4; k++) out[4 * i + k] = distance_from(&of_a, b[k]);
    }
}

/* Leaves of one to four triangles, some beside each other, with levels along any axis. */
static void pairs_of_two_leaves_that_are_left_out_are_far(void **state)
{
    (void)state;
    dice d = {25};
    int far = 0, rejected = 0;
    for (int n = 0; n < rounds() / 4; n++) {
        vec3 a[4][3], b[4][3], axis = vec_unit(dice_vec(&d, -1, 1));
        mesh_four four_a, four_b;
        double levels_a[4], levels_b[4], apart[16], within = random_within(&d);
        uint32_t count_a = 1 + (uint32_t)n % 4, count_b = 1 + (uint32_t)n / 4 % 4;
        for (int i = 0; i < 4; i++) random_triangle(&d, a[i]), random_triangle(&d, b[i]);
        mesh_four_set(&four_a, a[0], count_a, 1, NULL);
        mesh_four_set(&four_b, b[0], count_b, 1, &IDENTITY);
        for (uint32_t i = 0; i < 4; i++) {
            levels_a[i] = levels_b[i] = 0;
            for (int k = 0; k < 3 && i < count_a; k++)
                levels_a[i] = k ? fmax(levels_a[i], vec_dot(axis, a[i][k])) : vec_dot(axis, a[i][k]);
            for (int k = 0; k < 3 && i < count_b; k++)
                levels_b[i] = k ? fmin(levels_b[i], vec_dot(axis, b[i][k])) : vec_dot(axis, b[i][k]);
        }
        soup_distances(a, b, apart);
        unsigned near = mesh_fours_near(&four_a, &four_b, levels_a, levels_b, within);
        assert_int_equal(near >> 16, 0);
        for (uint32_t i = 0; i < 16; i++) {
            bool there = i / 4 < count_a && i % 4 < count_b, kept = near >> i & 1;
            if (there && !kept) assert_true(apart[i] > within - ROUNDING);
            far += there && apart[i] > 2 * within;
            rejected += there && apart[i] > 2 * within && !kept;
        }
    }
    assert_true(far > rounds() / 4 && rejected > far / 4);
}

static void beside_a_box_what_is_left_out_is_far(void **state)
{
    (void)state;
    dice d = {22};
    counts c = {0};
    for (int n = 0; n < rounds() / 4; n++) {
        vec3 b[4][3], half = dice_vec(&d, 0.01, 0.7), corner[8];
        mesh_four four;
        mesh_row row;
        double within = random_within(&d);
        for (int k = 0; k < 8; k++)
            corner[k] = vec(k & 1 ? half.x : -half.x, k & 2 ? half.y : -half.y, k & 4 ? half.z : -half.z);
        for (int i = 0; i < 4; i++) random_triangle(&d, b[i]);
        mesh_four_set(&four, b[0], 4, 1, &IDENTITY);
        mesh_spot spot = {.lo = vec_neg(half), .hi = half};
        soup box = soup_box(half.x, half.y, half.z, 1);
        unsigned near = mesh_row_near_box(&four, &spot, 15, within * within, &row);
        hold_row(&box, corner, 8, b, within, near, &row, &c);
        assert_int_equal(near & ~mesh_row_near_core(&four, &spot, 15, within * within, &row), 0);
        soup_free(&box);
    }
    assert_true(c.kept > rounds() / 16 && c.far > rounds() / 4);
    assert_true(c.rejected > c.far - c.far / 10);
}

/* Where triangles are, and their levels: lane by lane what one alone has; a leaf of fewer repeats its last. */
static void four_are_placed_as_one_is(void **state)
{
    (void)state;
    dice d = {23};
    for (int n = 0; n < rounds(); n++) {
        vec3 b[4][3], axis = vec_unit(dice_vec(&d, -1, 1));
        mesh_four four;
        double levels[MESH_LEAF_MAX], scale = ldexp(1, n % 9 - 4);
        uint32_t count = 1 + (uint32_t)n % 4;
        pose at = {dice_vec(&d, -2, 2), dice_quat(&d)};
        transform t = pose_transform(at);
        for (int i = 0; i < 4; i++) random_triangle(&d, b[i]);
        mesh_four_set(&four, b[0], count, scale, &t);
        mesh_four_levels(&four, axis, levels);
        for (uint32_t i = 0; i < 4; i++) {
            mesh_spot s, one;
            vec3 p[3];
            double least = INFINITY;
            for (int k = 0; k < 3; k++) {
                p[k] = transform_point(&t, vec_scale(b[i < count ? i : count - 1][k], scale));
                least = fmin(least, vec_dot(axis, p[k]));
            }
            one = spot_of(p);
            mesh_four_spot(&four, i, &s);
            assert_memory_equal(&s, &one, sizeof s);
            assert_true(levels[i] == least);
        }
    }
}

/* How often each pair of triangles is visited. */
typedef struct visits {
    uint8_t *of_pair;
    uint32_t columns;
} visits;

static bool count_visit(mesh_walk *w, void *context)
{
    visits *v = context;
    assert_true(w->triangle_a < w->ma->triangle_count && w->triangle_b < v->columns);
    v->of_pair[w->triangle_a * v->columns + w->triangle_b]++;
    return true;
}

/* Where nothing is known to leave pairs out by, each pair is visited, and once: none that is not there. */
static void each_pair_is_visited_once(void **state)
{
    (void)state;
    soup ball = soup_icosphere(0.7, 1), box = soup_box(0.3, 0.5, 0.4, 1), torus = soup_torus(0.6, 0.2, 9, 5);
    const soup *solids[3] = {&ball, &box, &torus};
    const pose b_in_a = {{0.9, -0.4, 0.3}, {0.8, 0.36, 0.48, 0}};
    for (int i = 0; i < 9; i++) {
        mesh *a = soup_mesh(solids[i / 3]), *b = soup_mesh(solids[i % 3]);
        shape of_a = mesh_shape(a, 0), of_b = mesh_shape(b, 0);
        unit_pair p;
        mesh_walk *w = aligned_alloc(64, (sizeof *w + 63) / 64 * 64);
        visits v = {calloc(a->triangle_count, b->triangle_count), b->triangle_count};
        assert_true(w && v.of_pair);
        unit_pair_init(&p, &of_a, &of_b, &b_in_a);
        mesh_walk_init(w, &p, &of_a, &of_b);
        mesh_walk_run(w, count_visit, &v);
        for (uint32_t k = 0; k < a->triangle_count * b->triangle_count; k++) assert_int_equal(v.of_pair[k], 1);
        free(v.of_pair);
        free(w);
        mesh_destroy(a);
        mesh_destroy(b);
    }
    soup_free(&ball);
    soup_free(&box);
    soup_free(&torus);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_that_are_left_out_are_far),
        cmocka_unit_test(a_pair_is_told_the_same_in_any_company),
        cmocka_unit_test(pairs_of_two_leaves_that_are_left_out_are_far),
        cmocka_unit_test(each_pair_is_visited_once),
        cmocka_unit_test(beside_a_box_what_is_left_out_is_far),
        cmocka_unit_test(four_are_placed_as_one_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
