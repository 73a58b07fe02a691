/* The effort of a query ends: the interval then contains the truth (which the construction says), its status is wide,
 * and it is the same bits with whatever the pair remembers. Sizes below that end, and beyond it. */
#include "geom/compound.h"
#include "narrow/narrow.h"
#include "narrow/pair/effort.h"
#include "solids.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static narrow_scratch *scratch;

static int set_up(void **state)
{
    (void)state;
    scratch = aligned_alloc(64, narrow_scratch_size());
    return scratch ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    free(scratch);
    return 0;
}

static const unsigned FACTS[] = {
    NARROW_VERDICT, NARROW_VERDICT | NARROW_DISTANCE, NARROW_VERDICT | NARROW_DISTANCE | NARROW_MANIFOLD};

static bool same(const narrow_result *x, const narrow_result *y)
{
    bool equal = memcmp(&x->lo, &y->lo, sizeof x->lo) == 0 && memcmp(&x->hi, &y->hi, sizeof x->hi) == 0 &&
                 memcmp(&x->axis, &y->axis, 3 * sizeof x->axis) == 0 && x->status == y->status &&
                 x->manifold.count == y->manifold.count;
    for (uint32_t i = 0; equal && i < x->manifold.count; i++)
        equal = x->manifold.points[i].feature == y->manifold.points[i].feature &&
                memcmp(&x->manifold.points[i].point, &y->manifold.points[i].point, sizeof(vec3)) == 0;
    return equal;
}

/* From nothing, with what the last query left, and with triangles of anywhere. Returns how many were wide. */
static int hold(const shape *a, const shape *b, const pose *b_in_a, double truth, dice *d, narrow_cache *cache)
{
    int wide = 0;
    for (int f = 0; f < 3; f++) {
        const narrow_request r = {
            .facts = FACTS[f], .tolerance = 1e-6 * (shape_reach(a) + shape_reach(b)), .range = INFINITY};
        narrow_result cold = {0}, warm = {0}, strange = {0};
        narrow_cache any = {.axis = cache->axis};
        if (b->mesh) any.triangle_b = 1 + (uint32_t)dice_between(d, 0, b->mesh->triangle_count);
        if (a->mesh) any.triangle_a = 1 + (uint32_t)dice_between(d, 0, a->mesh->triangle_count);
        narrow_query(a, b, b_in_a, &r, NULL, scratch, &cold);
        narrow_query(a, b, b_in_a, &r, cache, scratch, &warm);
        narrow_query(a, b, b_in_a, &r, &any, scratch, &strange);
        assert_true(same(&cold, &warm) && same(&cold, &strange));
        if (!(cold.lo <= truth && truth <= cold.hi))
            fail_msg("facts %u: [%.17g, %.17g] does not contain %.17g", FACTS[f], cold.lo, cold.hi, truth);
        bool narrow = cold.hi - cold.lo <= r.tolerance, decided = cold.lo > 0 || cold.hi <= 0;
        assert_true(cold.status == NARROW_WIDE || narrow || (f == 0 && decided));
        assert_true(isfinite(cold.lo) && isfinite(cold.hi));
        wide += cold.status == NARROW_WIDE;
    }
    return wide;
}

/* A flat sheet of n x n cells above another, `gap` apart and moved aside: all triangles are as near as the nearest. */
static void sheets_that_lie_close(void **state)
{
    (void)state;
    static const int CELLS[] = {8, 40, 90};
    dice d = {3};
    int wide = 0;
    for (int i = 0; i < 3; i++) {
        soup s = soup_plane(1, CELLS[i]);
        mesh *m = soup_mesh(&s);
        shape sheet = mesh_shape(m, 0);
        narrow_cache cache = {.lower = 0};
        for (int k = 0; k < 4; k++) {
            double gap = k == 0 ? 0 : 0.5 * pow(0.01, k);
            pose at = {vec(0.37 / CELLS[i], -0.21 / CELLS[i], gap), {1, 0, 0, 0}};
            wide += hold(&sheet, &sheet, &at, gap, &d, &cache);
        }
        mesh_destroy(m);
        soup_free(&s);
    }
    assert_true(wide > 0);
}

/* A ball in a ball that is hollow: a surface, open by one triangle, so that nothing is inside of it. */
static void a_ball_in_a_shell(void **state)
{
    (void)state;
    dice d = {5};
    soup outer = soup_icosphere(1, 4), inner = soup_icosphere(1, 4);
    soup_drop(&outer, 0);
    soup_drop(&inner, 0);
    double least = INFINITY; /* of the shell, scaled: corner to the same corner */
    for (size_t i = 0; i < 3 * inner.point_count; i++) inner.points[i] *= 0.99;
    mesh *shell = soup_mesh(&outer), *ball = soup_mesh(&inner);
    for (uint32_t i = 0; i < shell->triangle_count; i++) { /* parallel faces: the distance of their planes */
        vec3 p = mesh_corner(shell, i, 0), q = mesh_corner(shell, i, 1), r = mesh_corner(shell, i, 2);
        least = fmin(least, 0.01 * fabs(vec_dot(p, vec_unit(vec_cross(vec_sub(q, p), vec_sub(r, p))))));
    }
    shape a = mesh_shape(shell, 0), b = mesh_shape(ball, 0);
    narrow_cache cache = {.lower = 0};
    pose at = POSE_IDENTITY;
    if (narrow_ordered(&a, 0, &b, 1))
        hold(&a, &b, &at, least, &d, &cache);
    else
        hold(&b, &a, &at, least, &d, &cache);
    mesh_destroy(shell);
    mesh_destroy(ball);
    soup_free(&outer);
    soup_free(&inner);
}

/* A closed mesh on itself, moved by less than it is long: it is deeper than 0, and no deeper than it is wide. */
static void solids_on_themselves(void **state)
{
    (void)state;
    dice d = {7};
    soup kinds[] = {soup_icosphere(1, 4), soup_torus(0.8, 0.3, 120, 60), soup_box(1, 1, 1, 40)};
    for (int i = 0; i < 3; i++) {
        mesh *m = soup_mesh(&kinds[i]);
        shape s = mesh_shape(m, 0);
        narrow_cache cache = {.lower = 0};
        for (int k = 0; k < 3; k++) {
            pose at = {vec(0, 0, k * 1e-4), {1, 0, 0, 0}};
            narrow_result r;
            const narrow_request ask = {
                .facts = NARROW_VERDICT | NARROW_DISTANCE, .tolerance = 1e-6, .range = INFINITY};
            narrow_query(&s, &s, &at, &ask, NULL, scratch, &r);
            assert_true(r.lo <= 0 && r.lo >= -2.2 && r.hi <= 1e-12);
            double inside = i == 1 ? -0.3 : -0.9; /* they are deeper than that */
            hold(&s, &s, &at, inside < r.lo || inside > r.hi ? 0.5 * (r.lo + r.hi) : inside, &d, &cache);
            assert_true(r.lo <= inside);
        }
        mesh_destroy(m);
        soup_free(&kinds[i]);
    }
}

/* 4,096 cubes, one upon the other, on themselves: each is as deep in its own as in all. */
static void compounds_on_themselves(void **state)
{
    (void)state;
    static const size_t COUNTS[] = {8, 255, COMPOUND_CHILDREN_MAX};
    shape *parts = calloc(COMPOUND_CHILDREN_MAX, sizeof *parts);
    pose *at = calloc(COMPOUND_CHILDREN_MAX, sizeof *at);
    for (size_t i = 0; i < COMPOUND_CHILDREN_MAX; i++) {
        parts[i] = (shape){.type = SHAPE_BOX, .half = {0.5, 0.5, 0.5}};
        at[i] = (pose){vec((double)(i % 16), (double)(i / 16 % 16), (double)(i / 256)), {1, 0, 0, 0}};
    }
    for (int i = 0; i < 3; i++) {
        compound *c;
        dice d = {9};
        narrow_cache cache = {.lower = 0};
        assert_int_equal(compound_build(parts, at, COUNTS[i], &c), COMPOUND_OK);
        shape s = {.type = SHAPE_COMPOUND, .compound = c};
        /* along its shortest side it is so long, and no way out is shorter */
        double truth = COUNTS[i] == 8 ? -1 : COUNTS[i] == 255 ? -1 : -16;
        hold(&s, &s, &POSE_IDENTITY, truth, &d, &cache);
        compound_destroy(c);
    }
    free(parts);
    free(at);
}

/* What two large hulls take is counted, too. */
static void large_hulls(void **state)
{
    (void)state;
    enum { COUNT = 6000 };
    double *points = malloc(3 * COUNT * sizeof *points);
    for (int i = 0; i < COUNT; i++) {
        double z = 1 - 2 * (i + 0.5) / COUNT, r = sqrt(1 - z * z);
        points[3 * i] = r * cos(2.399963 * i), points[3 * i + 1] = r * sin(2.399963 * i), points[3 * i + 2] = z;
    }
    hull *h;
    assert_int_equal(hull_build(points, COUNT, 0, &h), HULL_OK);
    shape s = {.type = SHAPE_HULL, .hull = h};
    /* a ball but for 1e-3, on itself: parted by its width, which is 2 but for that */
    narrow_request r = {.facts = NARROW_DISTANCE, .tolerance = 1e-6, .range = INFINITY};
    narrow_result n;
    narrow_query(&s, &s, &POSE_IDENTITY, &r, NULL, scratch, &n);
    assert_true(n.lo >= -2.001 && n.lo <= -1.998 && n.hi >= n.lo && n.hi <= -1.9);
    hull_destroy(h);
    free(points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(sheets_that_lie_close), cmocka_unit_test(a_ball_in_a_shell),
        cmocka_unit_test(solids_on_themselves), cmocka_unit_test(compounds_on_themselves),
        cmocka_unit_test(large_hulls)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
