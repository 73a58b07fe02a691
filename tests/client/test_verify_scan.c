/* points_look in every width that this processor has, and prepared_look, beside a loop over the points. */
#include "verify_hull.h"
#include "verify_scan.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

enum { POINTS_MOST = 3000 };

static double uniform(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-52 - 1;
}

typedef struct plain {
    bool finite;
    double top, reach2;
} plain;

static plain look_plainly(const double *points, size_t count, vec d)
{
    plain out = {true, -INFINITY, 0};
    for (size_t i = 0; i < count; i++) {
        const double *p = points + 3 * i;
        double norm2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2], height = p[0] * d.x + p[1] * d.y + p[2] * d.z;
        out.finite &= isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
        out.top = height > out.top ? height : out.top;
        out.reach2 = norm2 <= out.reach2 ? out.reach2 : norm2 < INFINITY ? norm2 : INFINITY;
    }
    return out;
}

/* The points on top are those of the loop, and in its order. */
static void check_top(const double *points, size_t count, const points_scan *s, double depth)
{
    vec on_top[6];
    int found = points_on_top(points, count, s, depth, on_top, 6), expected = 0;
    for (size_t i = 0; i < count && expected < 6; i++) {
        const double *p = points + 3 * i;
        if (!(p[0] * s->along.x + p[1] * s->along.y + p[2] * s->along.z >= s->top - depth)) continue;
        assert_true(expected < found);
        assert_true(on_top[expected].x == p[0] && on_top[expected].y == p[1] && on_top[expected].z == p[2]);
        expected++;
    }
    assert_int_equal(found, expected);
}

static int compare(const void *a, const void *b)
{
    const vec *p = a, *q = b;
    return p->x != q->x   ? (p->x > q->x) - (p->x < q->x)
           : p->y != q->y ? (p->y > q->y) - (p->y < q->y)
                          : (p->z > q->z) - (p->z < q->z);
}

/* The same points on top, in any order. */
static void check_prepared_top(
    const double *points, size_t count, const prepared_scan *s, const collided_prepared_hull *h, double depth)
{
    static vec ours[POINTS_MOST], theirs[POINTS_MOST];
    points_scan loop = {.along = s->along, .top = s->top};
    int found = prepared_on_top(h, s, depth, ours, POINTS_MOST);
    assert_int_equal(found, points_on_top(points, count, &loop, depth, theirs, POINTS_MOST));
    qsort(ours, (size_t)found, sizeof *ours, compare);
    qsort(theirs, (size_t)found, sizeof *theirs, compare);
    for (int i = 0; i < found; i++) assert_int_equal(compare(&ours[i], &theirs[i]), 0);
    assert_int_equal(prepared_on_top(h, s, depth, ours, 1), found > 0);
}

static void check_prepared(const double *points, size_t count, vec d, const plain *expected)
{
    prepared_scan s;
    collided_prepared_hull *h = collided_prepare_hull(points, count);
    assert_int_equal(h != NULL, expected->finite);
    if (!h) return;
    prepared_look(h, d, 0.1, &s);
    assert_true(s.top == expected->top && h->reach2 == expected->reach2);
    check_prepared_top(points, count, &s, h, 0);
    check_prepared_top(points, count, &s, h, 0.1);
    collided_free_prepared_hull(h);
}

static void check(const double *points, size_t count, vec d)
{
    plain expected = look_plainly(points, count, d);
    check_prepared(points, count, d, &expected);
    for (points_width width = POINTS_PLAIN; width < POINTS_WIDTHS; width++) {
        points_scan s;
        if (!points_look_has(width)) continue;
        points_look_by(width, points, count, d, &s);
        assert_int_equal(s.finite, expected.finite);
        if (!expected.finite) continue;
        assert_true(s.top == expected.top && s.reach2 == expected.reach2);
        check_top(points, count, &s, 0);
        check_top(points, count, &s, 0.1);
    }
}

static void all_widths_see_what_a_loop_sees(void **state)
{
    (void)state;
    static const double ODD[] = {NAN, -NAN, INFINITY, -INFINITY, 1e200, -1e200, 0};
    static double points[3 * POINTS_MOST];
    uint64_t random = 7;
    for (size_t count = 1; count <= POINTS_MOST; count += count < 80 ? 1 : count < 700 ? 31 : 700) {
        for (size_t i = 0; i < 3 * count; i++) points[i] = uniform(&random);
        vec d = {uniform(&random), uniform(&random), uniform(&random)};
        check(points, count, d);
        for (size_t k = 0; k < sizeof ODD / sizeof *ODD; k++) {
            size_t at = (size_t)((uniform(&random) + 1) / 2 * (double)(3 * count - 1));
            double kept = points[at];
            points[at] = ODD[k];
            check(points, count, d);
            points[at] = kept;
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_widths_see_what_a_loop_sees)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
