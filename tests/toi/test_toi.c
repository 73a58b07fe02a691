/* The time of impact against dense sampling of certified distances: what is called free is free, nothing touches before
 * lo, and at hi it does; for every two convex types, straight, turning, spinning and grazing, in one go or in pieces.
 */
#include "toi_pairs.h"
#include "toi_truth.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <stdio.h>

enum { PAIRS_EACH = 12, SAMPLES = 160 }; /* COLLIDED_NIGHTLY: 100 times as many pairs */

typedef struct tally {
    uint32_t count[4], queries, queries_most;
    double width;
} tally;

static void fail_at(const char *why, const toi_pair *s, uint64_t seed, const toi_result *t, double time, double gap)
{
    fail_msg("%s: %s-%s, seed %llu: %s [%.17g, %.17g], at %.17g the distance is %g", why,
        shape_type_name(s->a.shape->type), shape_type_name(s->b.shape->type), (unsigned long long)seed,
        toi_status_name(t->status), t->lo, t->hi, time, gap);
}

static void check(const toi_pair *s, uint64_t seed, tally *count)
{
    toi_result t = toi_pair_find(s);
    double rounding = 1e-13 * s->size, end = fmin(t.lo, s->request.span);
    for (int k = 0; k < SAMPLES && end > 0; k++) {
        double time = end * k / SAMPLES;
        narrow_result n = toi_truth_at(&s->a, &s->b, time, 1e-9 * s->size, case_scratch());
        if (n.hi <= -rounding) fail_at("it touches before", s, seed, &t, time, n.hi);
    }
    if (t.status == TOI_HIT) {
        if (!(t.lo <= t.hi && t.hi <= s->request.span)) fail_at("no bracket", s, seed, &t, t.hi, 0);
        narrow_result n = toi_truth_at(&s->a, &s->b, t.hi, 1e-9 * s->size, case_scratch());
        if (n.lo > rounding) fail_at("it does not touch at hi", s, seed, &t, t.hi, n.lo);
        count->width = fmax(count->width, t.hi - t.lo);
    }
    if (t.status != TOI_FREE) {
        narrow_result n = toi_truth_at(&s->a, &s->b, t.lo, 0, case_scratch());
        if (n.lo > t.gap_hi + rounding || n.hi < t.gap_lo - rounding) fail_at("gap", s, seed, &t, t.lo, n.lo);
    }
    if (t.status == TOI_UNDECIDED) fail_at("undecided", s, seed, &t, t.lo, 0);
    count->count[t.status]++;
    count->queries += t.queries;
    if (t.queries > count->queries_most) count->queries_most = t.queries;
}

static void nothing_is_missed_and_nothing_is_late(void **state)
{
    (void)state;
    int pairs = getenv("COLLIDED_NIGHTLY") ? 100 * PAIRS_EACH : PAIRS_EACH;
    for (size_t k = 0; k < TOI_MANNERS; k++) {
        tally t = {.queries = 0};
        uint32_t all = 0;
        for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
            for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++)
                for (int i = 0; i < pairs; i++) {
                    if (ta == SHAPE_HALFSPACE && tb == SHAPE_HALFSPACE) continue;
                    uint64_t seed = (((uint64_t)k * 16 + (uint64_t)ta) * 16 + (uint64_t)tb) * 100000 + (uint64_t)i;
                    toi_pair s;
                    if (!toi_pair_make(seed, &toi_manners[k], (shape_type)ta, (shape_type)tb, &s)) continue;
                    check(&s, seed, &t);
                    all++;
                }
        print_message(
            "%-12s %5u pairs: %u free, %u hit, %u near; %.2f distances a pair, at most %u; brackets to %.2g s\n",
            toi_manners[k].name, all, t.count[TOI_FREE], t.count[TOI_HIT], t.count[TOI_NEAR], (double)t.queries / all,
            t.queries_most, t.width);
        assert_true(t.count[TOI_HIT] > all / 20);
        assert_true(t.count[TOI_FREE] > all / 20);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_is_missed_and_nothing_is_late)};
    cases_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    cases_destroy();
    return failed;
}
