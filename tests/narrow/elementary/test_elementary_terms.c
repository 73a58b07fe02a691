/* What a caller with many pairs asks (elementary_terms), against the full test and exact arithmetic: until a time, the
 * verdict alone, and the distance at one time. */
#include "elementary_judge.h"
#include "elementary_sets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t queries(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 100000 : getenv("COLLIDED_BRIEF") ? 300 : 2000;
}

static elementary_result ask_on(const elementary_query *q, double separation, double until, bool verdict)
{
    elementary_result r;
    elementary_terms terms = {separation, until, verdict};
    (q->kind == ELEMENTARY_VF ? elementary_vertex_face_on : elementary_edge_edge_on)(q->start, q->end, &terms, &r);
    return r;
}

static bool same_result(const elementary_result *a, const elementary_result *b)
{
    return a->status == b->status && a->proof == b->proof && a->t_lo == b->t_lo && a->t_hi == b->t_hi &&
           a->gap == b->gap && a->steps == b->steps;
}

/* Before `until` all is as without it; what would be told later is free until then. */
static void until_a_time(void **state)
{
    (void)state;
    size_t cut = 0;
    for (int c = 0; c < ELEMENTARY_CLASSES; c++)
        for (uint64_t i = 0; i < queries(); i++) {
            elementary_query q = elementary_make((elementary_class)c, i);
            double separation = i % 3 ? 0 : 0.01, until = (double)(1 + i % 64) / 64;
            elementary_result full = ask_on(&q, separation, 1, false);
            if (full.status == ELEMENTARY_HIT && i % 5 == 0) until = nextafter(full.t_lo, 1);
            if (full.status == ELEMENTARY_HIT && i % 5 == 1 && full.t_lo > 0) until = full.t_lo;
            elementary_result r = ask_on(&q, separation, until, false);
            bool before = full.status == ELEMENTARY_HIT && full.t_lo < until;
            if (before) assert_true(same_result(&r, &full));
            if (!before) assert_true(r.status == ELEMENTARY_FREE && r.t_lo == until && r.t_hi == until);
            cut += !before && full.status == ELEMENTARY_HIT;
        }
    assert_true(cut > 0);
}

static void verdict_alone(void **state)
{
    (void)state;
    size_t wider = 0;
    for (int c = 0; c < ELEMENTARY_CLASSES; c++)
        for (uint64_t i = 0; i < queries(); i++) {
            elementary_query q = elementary_make((elementary_class)c, i);
            elementary_result full = ask_on(&q, 0, 1, false), r = ask_on(&q, 0, 1, true);
            assert_int_equal(r.status, full.status);
            assert_true(r.proof <= full.proof);
            if (same_result(&r, &full)) continue;
            wider++;
            assert_true(r.status == ELEMENTARY_HIT && r.proof == ELEMENTARY_CERTAIN);
            elementary_truth truth = elementary_oracle(&q);
            assert_true(truth.touches && r.t_lo <= truth.hi && r.t_hi >= truth.lo);
        }
    assert_true(wider > 0);
}

static void distance_at_one_time(void **state)
{
    (void)state;
    for (int c = 0; c < ELEMENTARY_CLASSES; c++)
        for (uint64_t i = 0; i < queries(); i++) {
            double lo, hi;
            elementary_query q = elementary_make((elementary_class)c, i);
            if (q.kind == ELEMENTARY_VF)
                elementary_vertex_face_distance(q.start, &lo, &hi);
            else
                elementary_edge_edge_distance(q.start, &lo, &hi);
            assert_true(lo >= 0 && lo <= hi);
            memcpy(q.end, q.start, sizeof q.end);
            assert_true(elementary_oracle_within(&q, 0, hi));
            assert_true(lo == 0 || !elementary_oracle_within(&q, 0, nextafter(lo, 0)));
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(until_a_time),
        cmocka_unit_test(verdict_alone),
        cmocka_unit_test(distance_at_one_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
