/* Relations between answers: whatever the order of corners, ends and edges, the scale by a power of two, a shift that
 * is exact, the answer is the same, bit for bit; and what holds when time is cut, reversed, or the separation grows. */
#include "elementary_judge.h"
#include "elementary_sets.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static size_t wanted(size_t count)
{
    return getenv("COLLIDED_NIGHTLY") ? 10 * count : count;
}

static bool same(const elementary_result *a, const elementary_result *b, double gap_scale)
{
    return a->status == b->status && a->proof == b->proof && a->t_lo == b->t_lo && a->t_hi == b->t_hi &&
           a->gap * gap_scale == b->gap && a->steps == b->steps;
}

static void fail_pair(
    const elementary_query *q, const elementary_result *a, const elementary_result *b, const char *why)
{
    elementary_truth truth = elementary_oracle(q);
    elementary_print(q, a, &truth);
    elementary_print(q, b, &truth);
    fail_msg("%s", why);
}

/* The permutations of the points that leave the query what it is. */
static const int FACES[6][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 1, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {0, 3, 2, 1}};
static const int EDGES[8][4] = {
    {0, 1, 2, 3}, {1, 0, 2, 3}, {0, 1, 3, 2}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 0, 1}, {2, 3, 1, 0}, {3, 2, 1, 0}};

static elementary_query permuted(const elementary_query *q, const int *to)
{
    elementary_query p = {.kind = q->kind};
    for (int i = 0; i < 4; i++) p.start[i] = q->start[to[i]], p.end[i] = q->end[to[i]];
    return p;
}

static void order_does_not_matter(void **state)
{
    (void)state;
    for (int c = 0; c < ELEMENTARY_CLASSES; c++)
        for (size_t n = 0; n < wanted(1000); n++) {
            elementary_query q = elementary_make((elementary_class)c, 3000000 + n);
            bool face = q.kind == ELEMENTARY_VF;
            elementary_result first = elementary_ask(&q, 0);
            for (int i = 0; i < (face ? 6 : 8); i++) {
                elementary_query p = permuted(&q, face ? FACES[i] : EDGES[i]);
                elementary_result r = elementary_ask(&p, 0);
                if (!same(&first, &r, 1)) fail_pair(&q, &first, &r, "another order, another answer");
            }
        }
}

static elementary_query mapped(const elementary_query *q, double scale, vec3 by)
{
    elementary_query p = {.kind = q->kind};
    for (int i = 0; i < 4; i++) {
        p.start[i] = vec_add(vec_scale(q->start[i], scale), by);
        p.end[i] = vec_add(vec_scale(q->end[i], scale), by);
    }
    return p;
}

static void scale_does_not_matter(void **state)
{
    (void)state;
    static const int EXPONENTS[] = {-850, -400, -1, 30, 400, 950};
    for (int c = 0; c < ELEMENTARY_CLASSES; c++)
        for (size_t n = 0; n < wanted(500); n++)
            for (size_t e = 0; e < sizeof EXPONENTS / sizeof *EXPONENTS; e++) {
                elementary_query q = elementary_make((elementary_class)c, 4000000 + n);
                double scale = ldexp(1, EXPONENTS[e]), separation = n % 2 ? 0.01 : 0;
                elementary_query p = mapped(&q, scale, VEC_ZERO);
                elementary_result a = elementary_ask(&q, separation), b = elementary_ask(&p, separation * scale);
                if (!same(&a, &b, scale)) fail_pair(&q, &a, &b, "another scale, another answer");
            }
}

/* The classes on grids, whose coordinates have few bits, by whole numbers. */
static void exact_shift_does_not_matter(void **state)
{
    (void)state;
    static const elementary_class CLASSES[] = {ELEMENTARY_GRID, ELEMENTARY_COPLANAR, ELEMENTARY_TURNING};
    for (size_t c = 0; c < 3; c++)
        for (size_t n = 0; n < wanted(1000); n++) {
            elementary_query q = elementary_make(CLASSES[c], 5000000 + n);
            elementary_query p = mapped(&q, 1, vec(1 << 30, -123456789, 0x1p40));
            elementary_result a = elementary_ask(&q, 0), b = elementary_ask(&p, 0);
            if (!same(&a, &b, 1)) fail_pair(&q, &a, &b, "another place, another answer");
        }
}

/* The first half of the motion, where the middle is exact; and the motion run backwards. */
static void times_agree(void **state)
{
    (void)state;
    static const elementary_class CLASSES[] = {ELEMENTARY_GRID, ELEMENTARY_COPLANAR, ELEMENTARY_TURNING};
    size_t certain = 0;
    for (size_t c = 0; c < 3; c++)
        for (size_t n = 0; n < wanted(1000); n++) {
            elementary_query q = elementary_make(CLASSES[c], 6000000 + n), half = q, back = q;
            for (int i = 0; i < 4; i++) {
                half.end[i] = vec_scale(vec_add(q.start[i], q.end[i]), 0.5);
                back.start[i] = q.end[i], back.end[i] = q.start[i];
            }
            elementary_result whole = elementary_ask(&q, 0), first = elementary_ask(&half, 0);
            elementary_result reverse = elementary_ask(&back, 0);
            bool first_hits = first.status == ELEMENTARY_HIT, first_certain = first_hits && !first.proof;
            bool hits = whole.status == ELEMENTARY_HIT, sure = hits && !whole.proof;
            certain += sure;
            if (first_certain && !(hits && whole.t_lo <= 0.5 * first.t_hi))
                fail_pair(&q, &whole, &first, "the half meets before the whole does");
            if (sure && whole.t_hi <= 0.5 && !(first_hits && 0.5 * first.t_lo <= whole.t_hi))
                fail_pair(&q, &whole, &first, "the whole meets within the half, and the half does not");
            if (sure && reverse.status == ELEMENTARY_FREE) fail_pair(&q, &whole, &reverse, "not backwards");
        }
    assert_true(certain > wanted(100));
}

static void separation_only_adds_hits(void **state)
{
    (void)state;
    for (int c = 0; c < ELEMENTARY_CLASSES; c++)
        for (size_t n = 0; n < wanted(500); n++) {
            elementary_query q = elementary_make((elementary_class)c, 7000000 + n);
            elementary_result before = elementary_ask(&q, 0);
            for (double s = 1e-9; s < 10; s *= 10) {
                elementary_result r = elementary_ask(&q, s);
                bool sure = before.status == ELEMENTARY_HIT && before.proof == ELEMENTARY_CERTAIN;
                if (sure && (r.status == ELEMENTARY_FREE || r.t_lo > before.t_hi))
                    fail_pair(&q, &before, &r, "a greater separation is reached later");
                before = r;
            }
        }
}

/* At the ends of what there is: never free, never certain without reason, and never endless. */
static void extremes_are_answered(void **state)
{
    (void)state;
    static const double BAD[] = {NAN, INFINITY, -INFINITY, DBL_MAX, 0x1.0000000000001p1000};
    elementary_query q = {.kind = ELEMENTARY_VF,
        .start = {vec(1, 1, 1), vec(0, 0, 0), vec(4, 0, 0), vec(0, 4, 0)},
        .end = {vec(1, 1, 2), vec(0, 0, 0), vec(4, 0, 0), vec(0, 4, 0)}};
    assert_int_equal(elementary_ask(&q, 0).status, ELEMENTARY_FREE);
    for (int kind = 0; kind < 2; kind++)
        for (size_t i = 0; i < sizeof BAD / sizeof *BAD; i++) {
            elementary_query bad = q;
            bad.kind = (elementary_kind)kind;
            bad.end[3].y = BAD[i];
            elementary_result r = elementary_ask(&bad, 0);
            assert_true(r.status == ELEMENTARY_HIT && r.proof == ELEMENTARY_UNDECIDED && r.t_lo == 0);
            assert_true(isinf(r.gap));
        }
    assert_int_equal(elementary_ask(&q, NAN).proof, ELEMENTARY_UNDECIDED);
    assert_int_equal(elementary_ask(&q, -1).proof, ELEMENTARY_UNDECIDED);
    elementary_result r = elementary_ask(&q, DBL_MAX); /* nothing is as far apart as that */
    assert_true(r.status == ELEMENTARY_HIT && r.proof == ELEMENTARY_CERTAIN && r.t_hi == 0);
    r = elementary_ask(&q, INFINITY);
    assert_true(r.status == ELEMENTARY_HIT && r.proof == ELEMENTARY_CERTAIN && r.t_hi == 0);
}

/* The smallest and the greatest numbers that are taken, against exact arithmetic. */
static void extreme_scales_hold(void **state)
{
    (void)state;
    static const int EXPONENTS[] = {-1074, -1060, -1022, -1000, 999};
    for (size_t e = 0; e < sizeof EXPONENTS / sizeof *EXPONENTS; e++)
        for (size_t n = 0; n < wanted(200); n++) {
            elementary_query q = elementary_make(n % 3 ? ELEMENTARY_GRID : ELEMENTARY_CLOTH, 8000000 + n);
            q = mapped(&q, ldexp(1, EXPONENTS[e] - (EXPONENTS[e] > 0 ? 2 : 0)), VEC_ZERO); /* rounds what is lost */
            elementary_truth truth = elementary_oracle(&q);
            elementary_result r = elementary_ask(&q, 0);
            const char *fault = elementary_fault(&q, 0, &r, &truth);
            if (fault) fail_pair(&q, &r, &r, fault);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order_does_not_matter),
        cmocka_unit_test(scale_does_not_matter),
        cmocka_unit_test(exact_shift_does_not_matter),
        cmocka_unit_test(times_agree),
        cmocka_unit_test(separation_only_adds_hits),
        cmocka_unit_test(extremes_are_answered),
        cmocka_unit_test(extreme_scales_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
