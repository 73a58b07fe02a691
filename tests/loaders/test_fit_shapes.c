/* Shapes around random hulls: each holds the hull, and no drawn point of it is farther from the hull than is said;
 * shapes that are of the kind are found again. */
#include "fit_fixture.h"

#include <math.h>

enum { POINTS = 40, KINDS = 6 };

typedef struct around {
    pool pool;
    double points[3 * POINTS];
    fit_hull hull;
    solid_set truth;
} around;

static void begin(around *a, prng *r, const double half[3], double far)
{
    *a = (around){0};
    for (int i = 0; i < POINTS; i++) {
        vec3 d = drawn_direction(r);
        const double at[3] = {d.x, d.y, d.z};
        for (int k = 0; k < 3; k++) a->points[3 * i + k] = far + half[k] * at[k];
    }
    assert_true(fit_hull_make(&a->pool, a->points, POINTS, &a->hull));
    load_shape own = {.shape = collided_hull((collided_geometry){0}), .points = {a->points, POINTS}};
    set_make(&a->truth, &own, 1);
}

static void end(around *a)
{
    set_free(&a->truth);
    pool_free(&a->pool);
}

static void check(const around *a, const fit_shape *f, prng *r, size_t count)
{
    solid_set now;
    double size = 0, far = 0;
    for (int k = 0; k < 3; k++) {
        size = fmax(size, a->hull.hi[k] - a->hull.lo[k]);
        far = fmax(far, fmax(fabs(a->hull.hi[k]), fabs(a->hull.lo[k])));
    }
    set_make(&now, &f->shape, 1);
    double rounding = 1e-12 * far;
    for (int i = 0; i < POINTS; i++) {
        vec3 x = {a->points[3 * i], a->points[3 * i + 1], a->points[3 * i + 2]};
        if (set_away_at_least(&now, x) > 0) fail_msg("%s: a corner is outside", fit_shape_word(&f->shape));
    }
    for (size_t n = 0; n < count; n++) {
        double away = set_away(&a->truth, set_surface_point(&now, 0, r));
        if (away > f->excess_m + rounding)
            fail_msg("%s: a point is %.17g away, not %.17g", fit_shape_word(&f->shape), away, f->excess_m);
    }
    assert_true(f->excess_m < 2 * size && f->volume > 0.9 * a->hull.volume);
    set_free(&now);
}

static void shapes_hold_random_hulls(void **state)
{
    (void)state;
    static const double halves[][3] = {{1, 1, 1}, {1, 0.2, 0.1}, {0.3, 0.3, 0.02}, {1e-4, 3e-4, 2e-4}, {500, 100, 300}};
    prng r = {11};
    size_t count = fit_count(4000);
    for (int h = 0; h < 5; h++)
        for (int far = 0; far < 2; far++) {
            around a;
            begin(&a, &r, halves[h], far ? 100 * halves[h][0] : 0);
            fit_shape f[KINDS];
            fit_sphere(&a.hull, &f[0]);
            fit_capsule(&a.hull, &f[1]);
            fit_box(&a.hull, &f[2]);
            fit_rounded_box(&a.hull, &f[2], &f[3]);
            fit_whole_hull(&a.hull, &f[4]);
            int kinds = 5 + fit_rounded_hull(&a.pool, &a.hull, 0.1 * halves[h][2], &f[5]);
            for (int k = 0; k < kinds; k++) check(&a, &f[k], &r, count);
            end(&a);
        }
}

/* Of a turned box, a rod with round ends and a ball, by their corners. */
static void kinds_are_found_again(void **state)
{
    (void)state;
    pool p = {0};
    fit_hull h;
    fit_shape f;
    const double q[4] = {0.8, 0.2, -0.4, 0.4};
    double box[24], rod[3 * 400];
    for (int i = 0; i < 8; i++) {
        vec3 x = {i & 1 ? 0.3 : -0.3, i & 2 ? 0.1 : -0.1, i & 4 ? 0.05 : -0.05};
        x = vec_add(quat_rotate(quat_unit((quat){q[0], q[1], q[2], q[3]}), x), vec(1, 2, 3));
        box[3 * i] = x.x, box[3 * i + 1] = x.y, box[3 * i + 2] = x.z;
    }
    assert_true(fit_hull_make(&p, box, 8, &h));
    fit_box(&h, &f);
    assert_true(f.excess_m < 0.001);
    prng r = {5};
    for (int i = 0; i < 400; i++) {
        vec3 d = drawn_direction(&r);
        rod[3 * i] = 0.05 * d.x + (i % 2 ? 0.4 : 0), rod[3 * i + 1] = 0.05 * d.y, rod[3 * i + 2] = 0.05 * d.z;
    }
    assert_true(fit_hull_make(&p, rod, 400, &h));
    fit_capsule(&h, &f);
    assert_true(f.excess_m < 0.006 && fabs(f.shape.shape.half[2] - 0.2) < 0.005);
    for (int i = 0; i < 400; i++) rod[3 * i] -= i % 2 ? 0.4 : 0;
    assert_true(fit_hull_make(&p, rod, 400, &h));
    fit_sphere(&h, &f);
    assert_true(f.excess_m < 0.006 && fabs(f.shape.shape.radius - 0.05) < 0.002);
    pool_free(&p);
}

static void flat_points_are_refused(void **state)
{
    (void)state;
    pool p = {0};
    fit_hull h;
    const double flat[] = {0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1, 0.5, 0.2, 1};
    assert_false(fit_hull_make(&p, flat, 5, &h));
    assert_false(fit_hull_make(&p, flat, 3, &h));
    pool_free(&p);
}

/* Both bounds hold against the engine's, apart and overlapping, and are close where apart. */
static void gaps_are_bracketed(void **state)
{
    (void)state;
    prng r = {21};
    const double half[3] = {1, 0.5, 0.7};
    for (size_t n = 0; n < fit_count(20000); n++) {
        double a[3 * 20], b[3 * 20];
        vec3 shift = vec_scale(drawn_direction(&r), drawn(&r, 0, 4));
        const double by[3] = {shift.x, shift.y, shift.z};
        for (int i = 0; i < 60; i++) {
            a[i] = drawn(&r, -1, 1) * half[i % 3];
            b[i] = drawn(&r, -1, 1) * half[i % 3] + by[i % 3];
        }
        fit_gap gap;
        const double start[3] = {-by[0], -by[1], -by[2]};
        fit_gap_find((fit_cloud){a, 20, 1}, (fit_cloud){b, 20, 5}, start, 1e-10, INFINITY, &gap);
        const load_shape shapes[2] = {
            {.shape = {.type = COLLIDED_HULL, .pose = {{0}, {1, 0, 0, 0}}}, .points = {a, 20}},
            {.shape = {.type = COLLIDED_HULL, .pose = {{0}, {1, 0, 0, 0}}}, .points = {b, 20}}};
        solid_set of_a, of_b;
        set_make(&of_a, &shapes[0], 1);
        set_make(&of_b, &shapes[1], 1);
        double truth = set_distance(&of_a, POSE_IDENTITY, &of_b, POSE_IDENTITY);
        set_free(&of_a);
        set_free(&of_b);
        assert_true(gap.lo <= truth + 1e-9 && gap.hi >= fmax(truth, 0) - 2e-9);
        assert_true(truth < 1e-6 || gap.hi - gap.lo < 1e-9);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_hold_random_hulls),
        cmocka_unit_test(kinds_are_found_again),
        cmocka_unit_test(flat_points_are_refused),
        cmocka_unit_test(gaps_are_bracketed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
