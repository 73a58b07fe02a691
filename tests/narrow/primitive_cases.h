/* primitive_cases: two shapes and where they are, for the tests of the formulas (narrow/primitives/primitives.h); and
 * that a formula answers the same at every size. After cmocka.h. */
#ifndef COLLIDED_TESTS_NARROW_PRIMITIVE_CASES_H
#define COLLIDED_TESTS_NARROW_PRIMITIVE_CASES_H

#include "cases.h"
#include "where_they_stand.h"

#include <stdlib.h>

typedef struct pair {
    shape a, b;
    pose at_a, at_b;
} pair;

/* Rounds of a test: more by night, fewer with sanitizers. */
static inline int count_of(int usual)
{
    return getenv("COLLIDED_NIGHTLY") ? 20 * usual : getenv("COLLIDED_BRIEF") ? usual / 10 : usual;
}

static inline double pick(random_state *r, const double *from, size_t count)
{
    return from[random_bits(r) % count];
}

/* The shapes, as they are brought before a formula. */
static inline void put_in_order(pair *x)
{
    if (narrow_ordered(&x->a, 0, &x->b, 1)) return;
    shape a = x->a;
    x->a = x->b, x->b = a;
}

static inline double size_of(const pair *x)
{
    return shape_reach(&x->a) + shape_reach(&x->b) + vec_norm(vec_sub(x->at_b.p, x->at_a.p));
}

/* A's frame becomes the world's: most formulas answer in it. */
static inline void put_in_frame_of_a(pair *x)
{
    x->at_b = pose_relative(x->at_a, x->at_b);
    x->at_a = POSE_IDENTITY;
}

/* By the formula of the two types, A being in its frame: false where it leaves the pair to others. Without scratch
 * memory it is a formula alone. */
static inline bool ask_with(
    const pair *x, const narrow_request *request, narrow_cache *cache, narrow_scratch *scratch, narrow_result *r)
{
    assert_memory_equal(&x->at_a, &POSE_IDENTITY, sizeof x->at_a);
    if (scratch) narrow_query(&x->a, &x->b, &x->at_b, request, cache, scratch, r);
    return scratch || primitives_answer(&x->a, &x->b, &x->at_b, request, cache, NULL, r);
}

static inline pair scaled(pair x, double by)
{
    x.a.radius *= by, x.b.radius *= by;
    x.a.half = vec_scale(x.a.half, by), x.b.half = vec_scale(x.b.half, by);
    x.at_a.p = vec_scale(x.at_a.p, by), x.at_b.p = vec_scale(x.at_b.p, by);
    return x;
}

/* Each at its size, to the bit, or none. */
static inline void assert_same_at_every_size(const pair *x, const narrow_request *request, narrow_scratch *scratch)
{
    static const int EXPONENTS[] = {-340, -50, -33, 3, 40, 300};
    narrow_result told = {0}, other = {0};
    bool answered = ask_with(x, request, NULL, scratch, &told);
    for (size_t k = 0; k < sizeof EXPONENTS / sizeof *EXPONENTS; k++) {
        double by = ldexp(1, EXPONENTS[k]);
        pair y = scaled(*x, by);
        narrow_request at_size = *request;
        at_size.tolerance *= by, at_size.threshold *= by;
        assert_true(ask_with(&y, &at_size, NULL, scratch, &other) == answered);
        if (!answered) continue;
        vec3 point_a = vec_scale(told.point_a, by), point_b = vec_scale(told.point_b, by);
        assert_true(other.lo == by * told.lo && other.hi == by * told.hi);
        assert_memory_equal(&other.axis, &told.axis, sizeof told.axis);
        assert_memory_equal(&other.point_a, &point_a, sizeof point_a);
        assert_memory_equal(&other.point_b, &point_b, sizeof point_b);
    }
}

#endif
