/* same_answer: two answers that are to be the same bits, as one with a cache and one from nothing; and the requests
 * that such tests ask with: what a tick asks, the finest, a near end, contacts alone, a verdict, and coarse ones. After
 * cmocka.h. */
#ifndef COLLIDED_TESTS_NARROW_SAME_ANSWER_H
#define COLLIDED_TESTS_NARROW_SAME_ANSWER_H

#include "narrow/narrow.h"

static inline void assert_same_vec(vec3 x, vec3 y)
{
    assert_memory_equal(&x, &y, sizeof x);
}

static inline void assert_same(const narrow_result *x, const narrow_result *y)
{
    assert_true(x->lo == y->lo && x->hi == y->hi);
    assert_same_vec(x->axis, y->axis);
    assert_same_vec(x->point_a, y->point_a);
    assert_same_vec(x->point_b, y->point_b);
    assert_true(x->status == y->status && x->method == y->method && x->iterations == y->iterations);
    assert_true(x->peer_failures == y->peer_failures && x->refined == y->refined);
    assert_int_equal(x->manifold.count, y->manifold.count);
    for (uint32_t i = 0; i < x->manifold.count; i++) {
        const manifold_point *p = &x->manifold.points[i], *q = &y->manifold.points[i];
        assert_same_vec(p->point, q->point);
        assert_true(p->distance == q->distance && p->feature == q->feature);
    }
}

static const narrow_request REQUESTS[] = {
    {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY},
    {.facts = NARROW_DISTANCE | NARROW_MANIFOLD | NARROW_VERDICT, .tolerance = 1e-6, .range = 1, .threshold = 0.05},
    {.facts = NARROW_DISTANCE, .tolerance = 0, .range = INFINITY},
    {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = 0.3},
    {.facts = NARROW_MANIFOLD, .tolerance = 1e-9, .threshold = 0.2},
    {.facts = NARROW_VERDICT, .threshold = 0.1},
    {.facts = NARROW_DISTANCE, .tolerance = 1e-3, .range = INFINITY},
    {.facts = NARROW_DISTANCE, .tolerance = 0.02, .range = INFINITY},
    {.facts = NARROW_DISTANCE | NARROW_VERDICT, .tolerance = 0.1, .range = INFINITY},
    {.facts = NARROW_DISTANCE | NARROW_VERDICT, .tolerance = 1, .range = INFINITY},
};
enum { REQUEST_COUNT = sizeof REQUESTS / sizeof *REQUESTS };

#endif
