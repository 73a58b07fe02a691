/* Properties of shapes' support functions. Oracles: a plain loop over the vertices with the same arithmetic (bits), and
 * heights in __float128 from the shapes' definitions (bounds). */
#include "geom/hull_scan.h"
#include "geom/round.h"
#include "geom/support.h"
#include "random_shapes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

typedef __float128 wide;

/* Newton from the double root: two steps square the error twice. */
static wide wide_sqrt(wide a)
{
    if (a == 0) return 0;
    wide x = sqrt((double)a);
    for (int i = 0; i < 3; i++) x = (x + a / x) / 2;
    return x;
}
static wide wide_max(wide a, wide b)
{
    return a > b ? a : b;
}
static wide wide_dot(vec3 a, vec3 b)
{
    return (wide)a.x * b.x + (wide)a.y * b.y + (wide)a.z * b.z;
}

/* The exact greatest dot(d, p) over the core, to about 30 digits. */
static wide true_height(const shape *s, vec3 d)
{
    wide along = (wide)s->half.z * fabs(d.z), radial = s->half.x * wide_sqrt((wide)d.x * d.x + (wide)d.y * d.y);
    wide x = (wide)s->half.x * d.x, y = (wide)s->half.y * d.y, z = (wide)s->half.z * d.z, most = -INFINITY;
    switch (s->type) {
    case SHAPE_CAPSULE:
        return along;
    case SHAPE_BOX:
        return (x < 0 ? -x : x) + (y < 0 ? -y : y) + along;
    case SHAPE_CYLINDER:
        return radial + along;
    case SHAPE_CONE:
        return wide_max(z, radial - z);
    case SHAPE_ELLIPSOID:
        return wide_sqrt(x * x + y * y + z * z);
    case SHAPE_HULL:
        for (uint32_t i = 0; i < s->hull->vertex_count; i++)
            most = wide_max(most, wide_dot(d, hull_vertex(s->hull, i)));
        return most;
    default:
        return 0;
    }
}

static void assert_height_holds(const shape *s, vec3 d)
{
    wide truth = true_height(s, d);
    double up = support_height_up(s, d, NULL);
    vec3 p = support_core(s, d, NULL);
    double slack =
        200 * ROUND_U * (fabs(d.x) + fabs(d.y) + fabs(d.z)) * (s->hull ? s->hull->max_abs : vec_max_abs(s->half));
    assert_true((wide)up >= truth);
    assert_true((wide)up <= truth + slack);
    assert_true(wide_dot(d, p) <= truth + slack);
    assert_true(wide_dot(d, p) >= truth - slack);
}

static void heights_are_never_below_the_truth(void **state)
{
    (void)state;
    uint64_t seed = 1;
    static const double sizes[] = {1e-140, 1e-6, 1, 1e6, 1e140};
    for (int i = 0; i < 20000; i++) {
        shape s = random_plain_shape(&seed, sizes[i % 5]);
        vec3 d = i % 3 ? random_unit(&seed) : vec_scale(random_vec(&seed, 1), 1e3);
        if (i % 7 == 0) d = vec(0, 0, i % 2 ? 1 : -1);
        if (i % 11 == 0) d.x = 1e-12 * d.x;
        assert_height_holds(&s, d);
    }
}

static void heights_of_hulls_are_never_below_the_truth(void **state)
{
    (void)state;
    uint64_t seed = 2;
    for (int i = 0; i < 40; i++) {
        hull *h = random_hull(&seed, 4 + prng_bits(&seed) % 200, pow(10, i % 13 - 6), i % 2);
        assert_non_null(h);
        shape s = {.type = SHAPE_HULL, .hull = h};
        for (int k = 0; k < 100; k++) assert_height_holds(&s, random_unit(&seed));
        hull_destroy(h);
    }
}

static uint32_t scanned_vertex(const hull *h, vec3 d)
{
    uint32_t best = 0;
    for (uint32_t i = 1; i < h->vertex_count; i++)
        if (vec_dot(hull_vertex(h, i), d) > vec_dot(hull_vertex(h, best), d)) best = i;
    return best;
}

static void hints_never_change_the_vertex(void **state)
{
    (void)state;
    uint64_t seed = 3;
    for (int i = 0; i < 40; i++) {
        hull *h = random_hull(&seed, i < 36 ? 4 + prng_bits(&seed) % 60 : 1500, 1, true);
        assert_non_null(h);
        shape s = {.type = SHAPE_HULL, .hull = h};
        for (int k = 0; k < 200; k++) {
            vec3 d = k % 4 ? random_unit(&seed) : h->faces[prng_bits(&seed) % h->face_count].normal;
            uint32_t hint = k % 5 ? (uint32_t)(prng_bits(&seed) % h->vertex_count) : UINT32_MAX,
                     expected = scanned_vertex(h, d);
            vec3 warm = support_core(&s, d, &hint), cold = support_core(&s, d, NULL);
            assert_int_equal(hint, expected);
            assert_memory_equal(&warm, &cold, sizeof warm);
            hint = (uint32_t)(prng_bits(&seed) % h->vertex_count);
            double up = support_height_up(&s, d, &hint);
            assert_int_equal(hint, expected);
            assert_true(up == support_height_up(&s, d, NULL));
        }
        hull_destroy(h);
    }
}

/* Each kernel of the scan that this processor has, on every size up to its limit, with ties (corners of a grid, and
 * prisms: whole faces at one height), tiny and huge hulls, and directions that are zero or not a number. */
static void assert_widths_agree(const hull *h, vec3 d)
{
    uint32_t expected = isnan(d.x) ? 0 : scanned_vertex(h, d);
    for (int w = 0; w < HULL_SCAN_WIDTHS; w++)
        if (hull_scan_has((hull_scan_width)w)) assert_int_equal(hull_scan_by((hull_scan_width)w, h, d), expected);
    assert_int_equal(hull_scan(h, d), expected);
}

/* All vertices above a cut, in each width; and what is said when there are too many. */
static void assert_widths_list_alike(const hull *h, vec3 d, double below_top)
{
    uint16_t expected[16], found[16];
    double cut = vec_dot(hull_vertex(h, scanned_vertex(h, d)), d) - below_top;
    uint32_t count = 0;
    for (uint32_t i = 0; i < h->vertex_count && count < 17; i++)
        if (vec_dot(hull_vertex(h, i), d) >= cut && count++ < 16) expected[count - 1] = (uint16_t)i;
    for (int w = 0; w < HULL_SCAN_WIDTHS; w++) {
        if (!hull_scan_has((hull_scan_width)w)) continue;
        assert_int_equal(hull_scan_above_by((hull_scan_width)w, h, d, cut, found, 16), count);
        assert_memory_equal(found, expected, (count < 16 ? count : 16) * sizeof *found);
    }
    assert_int_equal(hull_scan_above(h, d, cut, found, 16), count);
}

static hull *prism(size_t corners)
{
    vec3 points[200];
    for (size_t k = 0; k < corners; k++) {
        double angle = 6.28318530717958648 * (double)(k / 2) / (double)(corners / 2);
        points[k] = vec(cos(angle), sin(angle), k % 2 ? 1 : -1);
    }
    hull *h = NULL;
    assert_int_equal(hull_build(&points->x, corners, 0, &h), HULL_OK);
    return h;
}

/* Three directions at once, to the bit what each alone and its opposite give; in each width. */
static void spans_are_heights_both_ways(void **state)
{
    (void)state;
    uint64_t seed = 12;
    for (int i = 0; i < 300; i++) {
        hull *h = random_hull(&seed, 4 + prng_bits(&seed) % (i % 4 ? 60 : 800), ldexp(1, i % 90 - 45), true);
        assert_non_null(h);
        shape shapes[] = {{.type = SHAPE_HULL, .hull = h}, {.type = SHAPE_CONE, .half = {1, 1, 2}},
            {.type = SHAPE_BOX, .half = {1, 2, 3}}};
        vec3 d[3] = {random_unit(&seed), random_unit(&seed), {0, 0, i % 2 ? 1 : -1}};
        for (int n = 0; n < 3; n++) {
            double up[3], down[3];
            support_spans_up(&shapes[n], d, up, down);
            for (int k = 0; k < 3; k++) {
                assert_true(up[k] == support_height_up(&shapes[n], d[k], NULL));
                assert_true(down[k] == support_height_up(&shapes[n], vec_neg(d[k]), NULL));
            }
        }
        for (int w = 0; h->node_count == 0 && w < HULL_SCAN_WIDTHS; w++) {
            double top[3], bottom[3], top_plain[3], bottom_plain[3];
            if (!hull_scan_has((hull_scan_width)w)) continue;
            for (int k = 0; k < 3; k++)
                assert_true(hull_scan_top_by((hull_scan_width)w, h, d[k]) ==
                            vec_dot(d[k], hull_vertex(h, hull_scan_by(HULL_SCAN_PLAIN, h, d[k]))));
            hull_scan_spans_by((hull_scan_width)w, h, d, top, bottom);
            hull_scan_spans_by(HULL_SCAN_PLAIN, h, d, top_plain, bottom_plain);
            for (int k = 0; k < 3; k++) assert_true(top[k] == top_plain[k] && bottom[k] == bottom_plain[k]);
        }
        hull_destroy(h);
    }
}

static void every_width_of_the_scan_gives_the_same_vertex(void **state)
{
    (void)state;
    uint64_t seed = 9;
    const vec3 odd[] = {{0, 0, 0}, {0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, -1, 0}, {1, 1, 1}, {NAN, 0, 1}};
    for (int i = 0; i < 300; i++) {
        size_t count = 4 + prng_bits(&seed) % (i % 3 ? 100 : 500);
        double size = i % 5 ? 1 : i % 2 ? 1e-140 : 1e140;
        hull *h = i % 4 ? random_hull(&seed, count, size, true) : prism(6 + 2 * (count % 90));
        assert_non_null(h);
        assert_true(h->padded_count <= HULL_SCAN_MAX);
        for (size_t k = 0; k < sizeof odd / sizeof *odd; k++) assert_widths_agree(h, odd[k]);
        for (int k = 0; k < 30; k++) {
            assert_widths_agree(h, random_unit(&seed));
            assert_widths_list_alike(h, random_unit(&seed), k % 3 ? 0.1 * (k % 4) * size : 0);
            assert_widths_agree(h, h->faces[prng_bits(&seed) % h->face_count].normal);
        }
        hull_destroy(h);
    }
}

/* Caps of 100 corners, all at one height but for rounding: plateaus, where climbing would stop too early. */
static void plateaus_do_not_hold_the_search_back(void **state)
{
    (void)state;
    uint64_t seed = 5;
    for (int i = 0; i < 20; i++) {
        pose at = i ? random_pose(&seed, 1) : POSE_IDENTITY;
        vec3 points[200];
        for (int k = 0; k < 200; k++) {
            double angle = 0.0628318530717958648 * (k % 100);
            points[k] = pose_point(at, vec(cos(angle), sin(angle), k < 100 ? 0 : 1));
        }
        hull *h = NULL;
        assert_int_equal(hull_build(&points->x, 200, 0, &h), HULL_OK);
        shape s = {.type = SHAPE_HULL, .hull = h};
        for (uint32_t f = 0; f < h->face_count; f++) {
            uint32_t hint = (uint32_t)(prng_bits(&seed) % h->vertex_count);
            support_core(&s, h->faces[f].normal, &hint);
            assert_int_equal(hint, scanned_vertex(h, h->faces[f].normal));
        }
        uint32_t any = 77;
        support_core(&s, VEC_ZERO, &any);
        assert_int_equal(any, 0);
        hull_destroy(h);
    }
}

static void ties_go_to_the_least_vertex(void **state)
{
    (void)state;
    double grid[27 * 3];
    for (int i = 0; i < 27; i++) {
        const int corner[3] = {i / 9, i / 3 % 3, i % 3};
        for (int k = 0; k < 3; k++) grid[3 * i + k] = corner[k];
    }
    hull *h = NULL;
    assert_int_equal(hull_build(grid, 27, 0, &h), HULL_OK);
    shape s = {.type = SHAPE_HULL, .hull = h};
    for (uint32_t start = 0; start < h->vertex_count; start++) {
        uint32_t hint = start;
        support_core(&s, vec(0, 0, 1), &hint);
        assert_int_equal(hint, 1); /* the corners in order: 000 002 020 022 200 ...; top ones are 1, 3, 5, 7 */
        support_core(&s, VEC_ZERO, &hint);
        assert_int_equal(hint, 0);
    }
    hull_destroy(h);
}

static void a_halfspace_has_a_height_only_along_its_normal(void **state)
{
    (void)state;
    shape s = {.type = SHAPE_HALFSPACE};
    assert_true(support_height_up(&s, vec(0, 0, 1), NULL) == 0);
    assert_true(isinf(support_height_up(&s, vec(0, 0, -1), NULL)));
    assert_true(isinf(support_height_up(&s, vec(1e-9, 0, 1), NULL)));
}

static void reach_is_rounded_up(void **state)
{
    (void)state;
    uint64_t seed = 4;
    for (int i = 0; i < 5000; i++) {
        shape s = random_plain_shape(&seed, i % 2 ? 1 : 1e-150);
        wide x = s.half.x, y = s.half.y, z = s.half.z, farthest = 0;
        if (s.type == SHAPE_CAPSULE) farthest = z;
        if (s.type == SHAPE_BOX) farthest = wide_sqrt(x * x + y * y + z * z);
        if (s.type == SHAPE_CYLINDER || s.type == SHAPE_CONE) farthest = wide_sqrt(x * x + z * z);
        if (s.type == SHAPE_ELLIPSOID) farthest = wide_max(x, wide_max(y, z));
        double reach = shape_reach(&s);
        assert_true((wide)reach >= farthest + s.radius);
        assert_true(reach <= (double)(farthest + s.radius) * (1 + 1e-14));
    }
    shape floor = {.type = SHAPE_HALFSPACE}, dot = {.type = SHAPE_SPHERE};
    assert_true(isinf(shape_reach(&floor)));
    assert_true(shape_reach(&dot) == 0);
}

static void bad_shapes_are_refused(void **state)
{
    (void)state;
    shape good = {.type = SHAPE_BOX, .half = {1, 2, 0}};
    assert_null(shape_check(&good));
    static const double bad[] = {NAN, INFINITY, -INFINITY, -1, 1.01e150};
    for (int k = 0; k < 4; k++)
        for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
            shape s = good;
            *(double *[]){&s.radius, &s.half.x, &s.half.y, &s.half.z}[k] = bad[i];
            assert_non_null(shape_check(&s));
        }
    shape at_limit = {
        .type = SHAPE_BOX, .radius = SHAPE_SIZE_MAX, .half = {SHAPE_SIZE_MAX, SHAPE_SIZE_MAX, SHAPE_SIZE_MAX}};
    const shape ball = {.type = SHAPE_SPHERE, .radius = SPHERE_RADIUS_MAX};
    const shape larger = {.type = SHAPE_SPHERE, .radius = 1.01 * SPHERE_RADIUS_MAX};
    assert_null(shape_check(&ball));
    assert_true(isfinite(shape_reach(&ball)));
    assert_non_null(shape_check(&larger));
    assert_null(shape_check(&at_limit));
    assert_true(isfinite(shape_reach(&at_limit)));
    shape oval = {.type = SHAPE_CYLINDER, .half = {1, 2, 1}}, no_hull = {.type = SHAPE_HULL},
          unknown = {.type = SHAPE_TYPE_COUNT};
    assert_non_null(shape_check(&oval));
    assert_non_null(shape_check(&no_hull));
    assert_non_null(shape_check(&unknown));
    assert_string_equal(shape_type_name(SHAPE_HALFSPACE), "halfspace");
    assert_string_equal(shape_type_name(SHAPE_TYPE_COUNT), "unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heights_are_never_below_the_truth),
        cmocka_unit_test(heights_of_hulls_are_never_below_the_truth),
        cmocka_unit_test(hints_never_change_the_vertex),
        cmocka_unit_test(spans_are_heights_both_ways),
        cmocka_unit_test(every_width_of_the_scan_gives_the_same_vertex),
        cmocka_unit_test(plateaus_do_not_hold_the_search_back),
        cmocka_unit_test(ties_go_to_the_least_vertex),
        cmocka_unit_test(a_halfspace_has_a_height_only_along_its_normal),
        cmocka_unit_test(reach_is_rounded_up),
        cmocka_unit_test(bad_shapes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
