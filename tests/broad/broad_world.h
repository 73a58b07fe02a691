/* broad_world: what the tests of the broad phase share: random numbers, boxes, and the pairs as an application of the
 * published changes would know them. */
#ifndef COLLIDED_TESTS_BROAD_BROAD_WORLD_H
#define COLLIDED_TESTS_BROAD_BROAD_WORLD_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/prng.h"
#include "broad/broad.h"
#include "broad/broad_peek.h"

#include <cmocka.h>

static inline vec3 random_vec(prng *r, double reach)
{
    double x = prng_between(r, -reach, reach), y = prng_between(r, -reach, reach);
    return vec(x, y, prng_between(r, -reach, reach));
}

static inline aabb box_at(vec3 center, vec3 half)
{
    return (aabb){vec_sub(center, half), vec_add(center, half)};
}
static inline aabb cube_at(double x, double y, double z, double half)
{
    return box_at(vec(x, y, z), vec(half, half, half));
}

static inline bool accept_all(void *context, uint32_t a, uint32_t b)
{
    (void)context, (void)a, (void)b;
    return true;
}

/* Every test that runs by run_with_each_index makes its broad phases with this index. */
static broad_kind tested_kind;

static inline broad *make_broad(broad_filter *filter, void *context)
{
    return broad_create(tested_kind, filter, context);
}

#define run_with_each_index(tests) run_tests_with_each_index(tests, sizeof(tests) / sizeof *(tests))

static inline int run_tests_with_each_index(const struct CMUnitTest *tests, size_t count)
{
    int failed = 0;
    for (tested_kind = BROAD_AUTO; tested_kind <= BROAD_SWEEP1; tested_kind++)
        failed += _cmocka_run_group_tests(broad_kind_name(tested_kind), tests, count, NULL, NULL);
    return failed;
}

static inline bool pair_less(broad_pair p, broad_pair q)
{
    return p.a < q.a || (p.a == q.a && p.b < q.b);
}

static inline void assert_sorted(const broad_pair *pairs, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        assert_true(pairs[i].a < pairs[i].b);
        assert_true(i == 0 || pair_less(pairs[i - 1], pairs[i]));
    }
}

#endif
