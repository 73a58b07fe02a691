/* The oracle itself: contacts at times known by hand, among them irrational and multiple ones, and cubics that are
 * zero; then its two halves against each other: the time found from the cubic, and exact distances at given times. */
#include "elementary_sets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static void expect(const elementary_query *q, bool touches, double time)
{
    elementary_truth t = elementary_oracle(q);
    assert_int_equal(t.touches, touches);
    if (touches && !(t.lo <= time && time <= t.hi && t.hi - t.lo <= 0x1p-52))
        fail_msg("[%.17g, %.17g] is not %.17g", t.lo, t.hi, time);
}

static const vec3 FACE[3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};

static elementary_query vertex_over_face(vec3 from, vec3 to)
{
    return (elementary_query){ELEMENTARY_VF, {from, FACE[0], FACE[1], FACE[2]}, {to, FACE[0], FACE[1], FACE[2]}};
}

static void finds_known_times(void **state)
{
    (void)state;
    elementary_query q = vertex_over_face(vec(1, 1, 1), vec(1, 1, -3));
    expect(&q, true, 0.25);
    q = vertex_over_face(vec(1, 1, 1), vec(1, 1, -2)); /* no dyadic number */
    expect(&q, true, 1.0 / 3);
    q = vertex_over_face(vec(1, 1, 1), vec(1, 1, 0)); /* at the very end */
    expect(&q, true, 1);
    q = vertex_over_face(vec(1, 1, 1), vec(1, 1, 0x1p-1000));
    expect(&q, false, 2);
    q = vertex_over_face(vec(2, 2, 1), vec(2, 2, -1)); /* on an edge */
    expect(&q, true, 0.5);
    q = vertex_over_face(vec(nextafter(2, 3), 2, 1), vec(nextafter(2, 3), 2, -1)); /* beside it */
    expect(&q, false, 2);
    q = vertex_over_face(vec(0, 0, 1), vec(0, 0, -1)); /* on a corner */
    expect(&q, true, 0.5);
}

/* The vertex rises with t as the face turns: 2 t = 1 - t^2 in the plane of the vertex and one corner. */
static void finds_an_irrational_time(void **state)
{
    (void)state;
    elementary_query q = {.kind = ELEMENTARY_VF,
        .start = {vec(1, 0, 0), vec(0, -1, -1), vec(0, 1, -1), vec(2, 0, -1)},
        .end = {vec(1, 0, 0), vec(0, -1, 1), vec(0, 1, 1), vec(1, 0, -1)}};
    /* At t: corners' x = 0, 0, 2 - t, heights 2 t - 1, 2 t - 1, -1; at x = 1: (2 t - 1) - 2 t / (2 - t) = 0. */
    expect(&q, false, 2); /* 2 t^2 - 3 t + 2 has no real root */
    q.end[3] = vec(1.5, 0, 3);
    /* x = 2 - t / 2, heights 2 t - 1 and 4 t - 1; at x = 1: (2 t - 1) + 2 t / (2 - t / 2) = 0: t^2 - 6.5 t + 2 = 0. */
    expect(&q, true, 4 / (6.5 + sqrt(6.5 * 6.5 - 8)));
}

static void finds_contacts_within_a_plane(void **state)
{
    (void)state;
    elementary_query q = vertex_over_face(vec(-4, 1, 0), vec(4, 1, 0)); /* slides in */
    expect(&q, true, 0.5);
    q = vertex_over_face(vec(-4, 1, 0), vec(-1, 1, 0));
    expect(&q, false, 2);
    q = vertex_over_face(vec(-4, 5, 0), vec(5, -4, 0)); /* 1 to 10 on the line x + y = 1 */
    expect(&q, true, 4.0 / 9);
    q = vertex_over_face(vec(-4, 4, 0), vec(4, 4, 0)); /* past the corner, through it */
    expect(&q, true, 0.5);
    q = (elementary_query){ELEMENTARY_EE, {vec(0, 0, 0), vec(1, 0, 0), vec(3, 0, 0), vec(5, 0, 0)},
        {vec(0, 0, 0), vec(1, 0, 0), vec(-1, 0, 0), vec(1, 0, 0)}}; /* along one line */
    expect(&q, true, 0.5);
    q = (elementary_query){ELEMENTARY_EE, {vec(0, 0, 0), vec(0, 0, 0), vec(3, 0, 0), vec(3, 0, 0)},
        {vec(3, 0, 0), vec(3, 0, 0), vec(0, 0, 0), vec(0, 0, 0)}}; /* two points */
    expect(&q, true, 0.5);
    q = (elementary_query){ELEMENTARY_EE, {vec(0, 0, 1), vec(2, 0, 1), vec(0, 0, 0), vec(2, 0, 0)},
        {vec(0, 0, -1), vec(2, 0, -1), vec(0, 0, 0), vec(2, 0, 0)}}; /* parallel, across */
    expect(&q, true, 0.5);
}

static void agrees_with_exact_distances(void **state)
{
    (void)state;
    size_t each = getenv("COLLIDED_NIGHTLY") ? 3000 : 300, hits = 0;
    for (int c = 0; c < ELEMENTARY_CLASSES; c++)
        for (size_t n = 0; n < each; n++) {
            elementary_query q = elementary_make((elementary_class)c, 1000000 + n);
            elementary_truth t = elementary_oracle(&q);
            double until = t.touches ? t.lo : 1;
            for (int k = 0; k < 8; k++) {
                double time = until * k / 8;
                if (time < until && elementary_oracle_within(&q, time, 0))
                    fail_msg(
                        "%s %zu: a contact at %a before %a", elementary_class_name((elementary_class)c), n, time, t.lo);
            }
            hits += t.touches;
            if (!t.touches) continue;
            assert_true(elementary_oracle_within(&q, t.hi, 64 * (t.hi - t.lo) + 64 * 0x1p-62)); /* speeds < 32 */
        }
    assert_true(hits > each * 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_known_times),
        cmocka_unit_test(finds_an_irrational_time),
        cmocka_unit_test(finds_contacts_within_a_plane),
        cmocka_unit_test(agrees_with_exact_distances),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
