/* near_features: a query with the cache of the frame before answers, to the bit, what a query from nothing answers;
 * with any forged cache, too; and whenever features are strict, the search from nothing ends with them. */
#include "cases.h"
#include "narrow/convex/near_features.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "same_answer.h"

enum { TRACKS = 240, FRAMES = 60, SIZES = 5 };

static const size_t POINTS[SIZES] = {4, 8, 16, 64, 200};

static size_t rounds_of(size_t ci)
{
    return getenv("COLLIDED_NIGHTLY") ? 60 * ci : getenv("COLLIDED_BRIEF") ? ci / 8 : ci;
}

static hull *ball(random_state *r, size_t count, vec3 half)
{
    vec3 *points = malloc(count * sizeof *points);
    hull *h = NULL;
    assert_non_null(points);
    for (size_t i = 0; i < count; i++) {
        vec3 v = random_direction(r);
        points[i] = vec(half.x * v.x, half.y * v.y, half.z * v.z);
    }
    assert_int_equal(hull_build(&points->x, count, 0, &h), HULL_OK);
    free(points);
    return h;
}

/* Hulls of five sizes, of which every fourth is a brick: its faces have four corners. Boxes; capsules. */
static shape make(random_state *r, shape_type type, size_t size)
{
    vec3 half = {random_in(r, 0.3, 1), random_in(r, 0.3, 1), random_in(r, 0.3, 1)};
    shape s = {.type = type, .half = half};
    if (type == SHAPE_CAPSULE) s.half = vec(0, 0, half.z), s.radius = 0.2;
    if (random_unit(r) < 0.2) s.radius = 0.1;
    if (type != SHAPE_HULL) return s;
    s.half = VEC_ZERO;
    if (random_unit(r) < 0.25) {
        double corners[24];
        for (int i = 0; i < 24; i++) corners[i] = (i / 3 >> i % 3 & 1 ? 1 : -1) * (&half.x)[i % 3];
        hull *brick;
        assert_int_equal(hull_build(corners, 8, 0, &brick), HULL_OK);
        s.hull = brick;
    } else {
        s.hull = ball(r, POINTS[size], half);
    }
    return s;
}

static void unmake(shape *s)
{
    if (s->hull) hull_destroy((hull *)(uintptr_t)s->hull);
}

/* The bounds hold what bounds in double-double hold, and are as close as was asked. */
static void assert_true_to(const shape *a, const shape *b, const pose *at, const narrow_result *r)
{
    static const narrow_request FINEST = {.facts = NARROW_DISTANCE, .range = INFINITY};
    narrow_result fine;
    narrow_query(a, b, at, &FINEST, NULL, case_scratch(), &fine);
    assert_true(r->lo <= fine.hi && fine.lo <= r->hi && r->hi - r->lo <= 1e-9);
    assert_true(r->status == NARROW_CERTAIN);
}

typedef struct tally {
    size_t frames, remembered, deep;
} tally;

/* Nearer and farther, deep now and then, all the time turning; and another request every eight frames. */
static void follow(random_state *r, const shape *a, const shape *b, tally *t)
{
    vec3 towards = random_direction(r), axis = random_direction(r);
    quat q = random_rotation(r);
    double most = shape_reach(a) + shape_reach(b), step = random_in(r, 0, 0.02) * most,
           away = random_in(r, 0.2, 1.3) * most, rate = random_in(r, 0, 0.02);
    narrow_shell shell = {.point_count = 0};
    narrow_cache cache = {.shell = random_unit(r) < 0.9 ? &shell : NULL};
    for (int i = 0; i < FRAMES; i++) {
        const narrow_request *request = &REQUESTS[random_unit(r) < 0.6 ? 0 : (i / 8) % REQUEST_COUNT];
        pose at = {vec_scale(towards, away), q};
        narrow_cache none = {.lower = 0};
        narrow_result warm, cold;
        narrow_query(a, b, &at, request, &cache, case_scratch(), &warm);
        narrow_query(a, b, &at, request, &none, case_scratch(), &cold);
        assert_same(&warm, &cold);
        if (i % 4 == 0 && request == &REQUESTS[0]) assert_true_to(a, b, &at, &warm);
        t->frames++;
        t->remembered += cache.nearest.count_a > 0;
        t->deep += cache.nearest.count_a > 0 && cache.nearest.deep;
        away = fabs(away + random_in(r, -step, step));
        q = quat_unit(quat_mul((quat){1, rate * axis.x, rate * axis.y, rate * axis.z}, q));
        towards = vec_unit(vec_madd(towards, rate, random_direction(r)));
    }
}

static void followed_through(shape_type type_a, shape_type type_b, unsigned seed)
{
    random_state r = {seed};
    tally t = {0, 0, 0};
    size_t tracks = rounds_of(TRACKS);
    for (size_t i = 0; i < tracks; i++) {
        shape a = make(&r, type_a, i % SIZES), b = make(&r, type_b, i / SIZES % SIZES);
        if (narrow_ordered(&a, 0, &b, 1))
            follow(&r, &a, &b, &t);
        else
            follow(&r, &b, &a, &t);
        unmake(&a);
        unmake(&b);
    }
    assert_true(t.remembered > t.frames / (type_a == type_b ? 8 : 16)); /* or else nothing has been tested */
    assert_true(type_b != SHAPE_HULL || t.deep > t.frames / 16);
}

static void hulls_followed_with_their_cache_answer_as_from_nothing(void **state)
{
    (void)state;
    followed_through(SHAPE_HULL, SHAPE_HULL, 71);
}

static void boxes_followed_with_their_cache_answer_as_from_nothing(void **state)
{
    (void)state;
    followed_through(SHAPE_BOX, SHAPE_BOX, 72);
    followed_through(SHAPE_CAPSULE, SHAPE_BOX, 73);
}

/* Apart they remember nothing. */
static void boxes_in_hulls_followed_with_their_cache_answer_as_from_nothing(void **state)
{
    (void)state;
    followed_through(SHAPE_BOX, SHAPE_HULL, 77);
}

/* Hulls that overlap by little more or less than the tolerance: a search from nothing may end as soon as it knows that
 * much, before it has seen a facet. */
static void shallow_overlaps_do_not_tell_who_remembers(void **state)
{
    (void)state;
    static const double TOLERANCES[] = {1e-3, 5e-3, 0.01, 0.02, 0.028};
    random_state r = {76};
    size_t remembered = 0;
    for (size_t i = 0; i < rounds_of(1000); i++) {
        shape_type type = i % 3 ? SHAPE_HULL : SHAPE_BOX;
        shape a = make(&r, type, i % SIZES), b = make(&r, SHAPE_HULL, i / SIZES % SIZES);
        if (!narrow_ordered(&a, 0, &b, 1)) {
            shape t = a;
            a = b, b = t;
        }
        double size = shape_reach(&a) + shape_reach(&b);
        narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = TOLERANCES[i % 5] * size, .range = INFINITY};
        pose at = {vec_scale(random_direction(&r), random_in(&r, 0.2, 0.9)), random_rotation(&r)};
        narrow_shell shell = {.point_count = 0};
        narrow_cache cache = {.shell = &shell};
        for (int k = 0; k < 40; k++) {
            narrow_cache none = {.lower = 0};
            narrow_result warm, cold;
            narrow_query(&a, &b, &at, &request, &cache, case_scratch(), &warm);
            narrow_query(&a, &b, &at, &request, &none, case_scratch(), &cold);
            assert_same(&warm, &cold);
            remembered += cache.nearest.count_a > 0 && cache.nearest.deep;
            /* towards an overlap of about the tolerance, and about */
            double by = 0.5 * (warm.lo + warm.hi) + random_in(&r, 0, 2) * request.tolerance;
            at.p = vec_madd(at.p, -by, warm.axis);
            at.p = vec_madd(at.p, 1e-3 * size * random_unit(&r), random_direction(&r));
        }
        unmake(&a);
        unmake(&b);
    }
    assert_true(remembered > rounds_of(1000) * 8);
}

/* Whatever is written there, out of range or wrong: no bit changes. */
static void forged_features_change_nothing(void **state)
{
    (void)state;
    random_state r = {74};
    for (size_t i = 0; i < rounds_of(4000); i++) {
        shape_type type_a = i % 2 ? SHAPE_HULL : SHAPE_BOX, type_b = i % 4 ? type_a : SHAPE_HULL;
        shape a = make(&r, type_a, i % SIZES), b = make(&r, type_b, i / SIZES % SIZES);
        pose at = {vec_scale(random_direction(&r), random_in(&r, 0.3, 3)), random_rotation(&r)};
        narrow_shell empty = {.point_count = 0};
        narrow_cache forged = {.shell = i % 3 ? &empty : NULL}, none = {.lower = 0};
        forged.nearest.deep = i % 3;
        unsigned most = random_unit(&r) < 0.9 ? 4 : 65536;
        for (int k = 0; k < 3; k++) {
            forged.nearest.a[k] = (uint16_t)(random_bits(&r) % most);
            forged.nearest.b[k] = (uint16_t)(random_bits(&r) % most);
        }
        forged.nearest.count_a = (uint8_t)(random_bits(&r) % 5),
        forged.nearest.count_b = (uint8_t)(random_bits(&r) % 5);
        narrow_result x, y;
        narrow_query(&a, &b, &at, &REQUESTS[0], &forged, case_scratch(), &x);
        narrow_query(&a, &b, &at, &REQUESTS[0], &none, case_scratch(), &y);
        assert_same(&x, &y);
        unmake(&a);
        unmake(&b);
    }
}

/* If any of all features is strict, the search names it; if none is, it names none. */
static void the_search_finds_what_is_strict(void **state)
{
    (void)state;
    random_state r = {75};
    static const narrow_goal CLOSELY = {1e-9, 0x1p-50, INFINITY, -INFINITY, INFINITY, INFINITY, false};
    size_t found = 0;
    for (size_t i = 0; i < rounds_of(1600); i++) {
        shape_type type = i % 2 ? SHAPE_HULL : SHAPE_BOX;
        shape a = make(&r, type, i % 3), b = make(&r, type, i / 3 % 3);
        pose at = {vec_scale(random_direction(&r), random_in(&r, 0.3, 3)), random_rotation(&r)};
        if (i % 5 == 0) at.q = (quat){1, 0, 0, 0};
        narrow_cache none = {.lower = 0};
        narrow_result x;
        unit_pair p;
        span s;
        narrow_query(&a, &b, &at, &REQUESTS[0], &none, case_scratch(), &x);
        unit_pair_init(&p, &a, &b, &at);
        if (near_features_try_all(&p, &CLOSELY, &s)) {
            assert_memory_equal(&s.nearest, &none.nearest, sizeof s.nearest);
            found++;
        } else {
            assert_true(none.nearest.count_a == 0 || none.nearest.deep);
        }
        unmake(&a);
        unmake(&b);
    }
    assert_true(found > rounds_of(1600) / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hulls_followed_with_their_cache_answer_as_from_nothing),
        cmocka_unit_test(boxes_followed_with_their_cache_answer_as_from_nothing),
        cmocka_unit_test(boxes_in_hulls_followed_with_their_cache_answer_as_from_nothing),
        cmocka_unit_test(shallow_overlaps_do_not_tell_who_remembers),
        cmocka_unit_test(forged_features_change_nothing),
        cmocka_unit_test(the_search_finds_what_is_strict),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
